/// @file
/// Convex solid with polygons as faces. Quickhull (geometry/shapes/quickhull.hpp) builds one from
/// points.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Convex solid. Build one with `convex_hull(points)`.
template <Scalar S>
struct ConvexHull {
  /// [m] Corners. All are on the hull.
  std::vector<Vec3<S>> vertices;
  /// [-] Vertex numbers, face after face. Each face runs counter-clockwise seen from outside.
  std::vector<std::uint32_t> face_vertices;
  /// [-] Start of each face in `face_vertices`, then the end of the last.
  std::vector<std::uint32_t> face_starts;
  /// [1] Outward unit normal of each face.
  std::vector<Vec3<S>> face_normals;
  /// [m] Distance of each face from the origin along its normal.
  std::vector<S> face_offsets;

  /// [-] Number of faces.
  [[nodiscard]] std::size_t face_count() const { return face_normals.size(); }
  /// [-] Vertex numbers of a face.
  [[nodiscard]] std::span<const std::uint32_t> face(std::size_t f) const {
    return {face_vertices.data() + face_starts[f], face_starts[f + 1] - face_starts[f]};
  }

  /// Checks that the faces close a convex solid. Two faces share every edge in opposite directions.
  /// All vertices are used. A face's corners are in its plane, and all others behind it.
  ///
  /// @throws InvalidArgument that names the face or vertex at fault.
  /// @note O(faces x vertices).
  void validate() const;

 private:
  void validate_numbers() const;
  void validate_edges() const;
  void validate_planes() const;
};

// Implementation ----------------------------------------------------------------------------------

namespace detail {

[[noreturn]] inline void raise_face(std::size_t face, std::string value, std::string rule) {
  raise(InvalidArgument("ConvexHull: face " + std::to_string(face), std::move(value),
                        std::move(rule)));
}

}  // namespace detail

template <Scalar S>
void ConvexHull<S>::validate() const {
  validate_numbers();
  validate_edges();
  validate_planes();
}

template <Scalar S>
void ConvexHull<S>::validate_numbers() const {
  detail::require(vertices.size() >= 4, "ConvexHull::vertices.size()", vertices.size(),
                  "must be at least 4");
  detail::require(face_count() >= 4, "ConvexHull::face_normals.size()", face_count(),
                  "must be at least 4");
  detail::require(face_offsets.size() == face_count(), "ConvexHull::face_offsets.size()",
                  face_offsets.size(), "must be the number of faces");
  detail::require(face_starts.size() == face_count() + 1, "ConvexHull::face_starts.size()",
                  face_starts.size(), "must be the number of faces + 1");
  detail::require(face_starts.front() == 0, "ConvexHull::face_starts[0]", face_starts.front(),
                  "must be 0");
  detail::require(face_starts.back() == face_vertices.size(), "ConvexHull::face_vertices.size()",
                  face_vertices.size(), "must be the last entry of face_starts");
  for (std::size_t f = 0; f < face_count(); ++f) {
    // In this order a start beyond the end is found before it is used to read.
    if (face_starts[f + 1] < face_starts[f] || face_starts[f + 1] - face_starts[f] < 3 ||
        face_starts[f + 1] > face_vertices.size()) {
      detail::raise_face(
          f, "[" + std::to_string(face_starts[f]) + ", " + std::to_string(face_starts[f + 1]) + ")",
          "must have at least 3 corners within face_vertices");
    }
    detail::require_all_finite("ConvexHull::face_normals", face_normals[f]);
    detail::require_finite("ConvexHull::face_offsets", face_offsets[f]);
  }
  detail::DynamicArray<bool> is_used(vertices.size(), false);
  for (const std::uint32_t v : face_vertices) {
    detail::require(v < vertices.size(), "ConvexHull::face_vertices", v,
                    "must name an existing vertex");
    is_used[v] = true;
  }
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    detail::require_all_finite("ConvexHull::vertices", vertices[v]);
    detail::require(is_used[v], "ConvexHull::vertices: number", v, "must be the corner of a face");
  }
}

template <Scalar S>
void ConvexHull<S>::validate_edges() const {
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  detail::DynamicArray<Edge> edges;
  edges.reserve(face_vertices.size());
  for (std::size_t f = 0; f < face_count(); ++f) {
    const std::span<const std::uint32_t> corners = face(f);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      edges.emplace_back(corners[i], corners[(i + 1) % corners.size()]);
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Edge reversed{edges[i].second, edges[i].first};
    const bool is_repeated = i > 0 && edges[i] == edges[i - 1];
    if (is_repeated || !std::binary_search(edges.begin(), edges.end(), reversed)) {
      detail::raise(InvalidArgument(
          "ConvexHull: edge",
          "(" + std::to_string(edges[i].first) + ", " + std::to_string(edges[i].second) + ")",
          "must be shared by two faces in opposite directions"));
    }
  }
}

template <Scalar S>
void ConvexHull<S>::validate_planes() const {
  using std::abs;
  Aabb<S> box;
  for (const Vec3<S>& v : vertices) box.include(v);
  // Faces joined from nearly coplanar triangles have corners up to three resolutions below their
  // plane, and a grid cell adds less than one more. Four are two of `equal` in double.
  // Coordinates far from the origin are rounded to a multiple of their own size.
  const S size = (box.upper - box.lower).norm();
  const S reach = cwise_max(cwise_abs(box.lower), cwise_abs(box.upper)).maxCoeff();
  const S slack =
      S(2) * detail::Tolerance<S>::equal() * size + detail::Tolerance<S>::round_off() * reach;

  for (std::size_t f = 0; f < face_count(); ++f) {
    if (abs(face_normals[f].squaredNorm() - S(1)) > detail::Tolerance<S>::equal()) {
      detail::raise_face(f, "normal of length " + detail::to_text(face_normals[f].norm()),
                         "must have length 1");
    }
    for (const std::uint32_t v : face(f)) {
      const S height = face_normals[f].dot(vertices[v]) - face_offsets[f];
      if (abs(height) > slack) {
        detail::raise_face(f, "corner " + std::to_string(v) + " at " + detail::to_text(height),
                           "must have its corners in its plane");
      }
    }
    S lowest = S(0);
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      const S height = face_normals[f].dot(vertices[v]) - face_offsets[f];
      lowest = std::min(lowest, height);
      if (height > slack) {
        detail::raise_face(f, "vertex " + std::to_string(v) + " at " + detail::to_text(height),
                           "must have all vertices behind its plane (not convex)");
      }
    }
    if (lowest >= -detail::Tolerance<S>::round_off() * std::max(size, reach)) {
      detail::raise_face(f, "no vertex behind it", "must bound a solid (flat)");
    }
  }
}

}  // namespace bristle::inline BRISTLE_ABI
