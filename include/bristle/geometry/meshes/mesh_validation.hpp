/// @file
/// Checks of triangle meshes: as a surface, and as the closed boundary of a solid.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Returns the volume [m^3] that a closed mesh encloses. Negative if it is wound inside out.
/// @throws InvalidArgument if a triangle names a vertex that does not exist.
template <Scalar S>
[[nodiscard]] S signed_volume(const TriangleMesh<S>& mesh);

/// Returns the numbers, ascending, of the triangles without a normal. They repeat a corner, or are
/// so thin that rounding of their coordinates decides on their normal.
/// @throws InvalidArgument if a triangle names a vertex that does not exist.
template <Scalar S>
[[nodiscard]] std::vector<std::uint32_t> degenerate_triangles(const TriangleMesh<S>& mesh);

/// Checks the conditions of every function on meshes. Open, degenerate and inverted meshes pass.
///
/// @throws InvalidArgument if the mesh has no triangle, a vertex is not finite, or a triangle names
///         a vertex that does not exist.
template <Scalar S>
void validate_surface(const TriangleMesh<S>& mesh);

/// Checks that the mesh bounds a solid: a valid surface without degenerate triangles, facing
/// outwards. Exactly two triangles share every edge and run through it in opposite directions.
///
/// Cavities (inner surfaces that face the void) pass, and so do several separate solids. Triangles
/// that cut through each other are not detected.
///
/// @throws InvalidArgument that names the first offending triangle and edge, and the fault: open,
///         not manifold, inconsistently wound, degenerate, inverted, or no valid surface.
/// @note O(n log n). Files often repeat vertices along seams; `weld` closes them.
template <Scalar S>
void validate_solid(const TriangleMesh<S>& mesh);

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// One passage of a triangle through an edge.
struct EdgeUse {
  std::uint32_t low;       ///< [-] Smaller vertex number.
  std::uint32_t high;      ///< [-] Larger vertex number.
  std::uint32_t triangle;  ///< [-] Number of the triangle.
  std::uint32_t side;      ///< [-] Which of its sides: from that corner to the next.
  bool is_ascending;       ///< True if the triangle runs from low to high.

  friend bool operator<(const EdgeUse& a, const EdgeUse& b) {
    if (a.low != b.low) return a.low < b.low;
    if (a.high != b.high) return a.high < b.high;
    return a.triangle < b.triangle;
  }
  [[nodiscard]] bool is_same_edge(const EdgeUse& other) const {
    return low == other.low && high == other.high;
  }
  [[nodiscard]] std::string text() const { return "edge " + to_tuple_text(std::array{low, high}); }
};

/// All passages through the edges of triangles. Those of one edge are adjacent, and edges ascend.
/// @param triangles  Array of the three vertex numbers of each.
template <typename Triangles>
[[nodiscard]] DynamicArray<EdgeUse> sorted_edges(const Triangles& triangles) {
  DynamicArray<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const auto& corners = triangles[t];
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t from = corners[k];
      const std::uint32_t to = corners[(k + 1) % 3];
      uses.push_back({std::min(from, to), std::max(from, to), t, k, from < to});
    }
  }
  std::sort(uses.begin(), uses.end());
  return uses;
}

/// Returns the passages through edges that only one triangle has, ascending. Throws unless every
/// edge is passed at most once in each direction.
/// @param uses  Those of `sorted_edges`.
[[nodiscard]] inline DynamicArray<EdgeUse> border_edges(const DynamicArray<EdgeUse>& uses) {
  DynamicArray<EdgeUse> borders;
  for (std::size_t i = 0; i < uses.size();) {
    std::size_t end = i + 1;
    while (end < uses.size() && uses[end].is_same_edge(uses[i])) ++end;
    const EdgeUse& use = uses[i];
    if (end - i > 2) {
      raise_triangle(
          use.triangle, use.text(),
          "must be manifold, but " + std::to_string(end - i) + " triangles share this edge");
    }
    if (end - i == 1) {
      borders.push_back(use);
    } else if (use.is_ascending == uses[i + 1].is_ascending) {
      raise_triangle(use.triangle, use.text(),
                     "must be wound consistently, but triangle " +
                         std::to_string(uses[i + 1].triangle) +
                         " runs through this edge in the same direction");
    }
    i = end;
  }
  return borders;
}

/// Throws unless every edge is passed exactly once in each direction.
inline void require_closed(const DynamicArray<EdgeUse>& uses) {
  const DynamicArray<EdgeUse> borders = border_edges(uses);
  if (borders.empty()) return;
  raise_triangle(borders.front().triangle, borders.front().text(),
                 "must be closed, but no other triangle shares this edge (open mesh; are "
                 "vertices repeated? see weld, or extruded_mesh for terrain)");
}

}  // namespace detail

template <Scalar S>
S signed_volume(const TriangleMesh<S>& mesh) {
  detail::require_named_vertices(mesh);
  const Vec3<S> reference = mesh_bounds(mesh).center();
  S volume = S(0);
  for (const auto& t : mesh.triangles) {
    const Vec3<S> a = mesh.vertices[t[0]] - reference;
    const Vec3<S> b = mesh.vertices[t[1]] - reference;
    const Vec3<S> c = mesh.vertices[t[2]] - reference;
    volume += a.dot(b.cross(c)) / S(6);
  }
  return volume;
}

template <Scalar S>
std::vector<std::uint32_t> degenerate_triangles(const TriangleMesh<S>& mesh) {
  using std::max;
  using std::sqrt;
  detail::require_named_vertices(mesh);
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    const Vec3<S>& a = mesh.vertices[corners[0]];
    const Vec3<S>& b = mesh.vertices[corners[1]];
    const Vec3<S>& c = mesh.vertices[corners[2]];
    // The height is uncertain by the rounding of the coordinates. That grows with the distance from
    // the origin. Dividing by the longest edge first keeps tiny triangles from underflowing.
    const S longest =
        sqrt(max((b - a).squaredNorm(), max((c - b).squaredNorm(), (a - c).squaredNorm())));
    const S reach = max(longest, max(cwise_abs(a).maxCoeff(),
                                     max(cwise_abs(b).maxCoeff(), cwise_abs(c).maxCoeff())));
    const bool has_height = longest > S(0) && ((b - a) / longest).cross(c - a).norm() >
                                                  detail::Tolerance<S>::round_off() * reach;
    if (!has_height) numbers.push_back(t);
  }
  return numbers;
}

template <Scalar S>
void validate_surface(const TriangleMesh<S>& mesh) {
  detail::require(!mesh.triangles.empty(), "TriangleMesh::triangles.size()", 0,
                  "must hold at least one triangle");
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!detail::all_finite(mesh.vertices[v])) {
      detail::raise(InvalidArgument("TriangleMesh::vertices[" + std::to_string(v) + "]",
                                    detail::to_tuple_text(mesh.vertices[v]), "must be finite"));
    }
  }
  detail::require_named_vertices(mesh);
}

template <Scalar S>
void validate_solid(const TriangleMesh<S>& mesh) {
  validate_surface(mesh);
  const std::vector<std::uint32_t> degenerate = degenerate_triangles(mesh);
  if (!degenerate.empty()) {
    detail::raise_triangle(degenerate.front(),
                           detail::to_tuple_text(mesh.triangles[degenerate.front()]),
                           "must not be degenerate (repeated corner or no area)");
  }
  detail::require_closed(detail::sorted_edges(mesh.triangles));
  detail::require(signed_volume(mesh) > S(0), "TriangleMesh: enclosed volume", signed_volume(mesh),
                  "must be > 0 (inverted mesh: triangles must be counter-clockwise from outside)");
}

}  // namespace bristle::inline BRISTLE_ABI
