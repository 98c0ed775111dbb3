/// @file
/// Indexed triangle mesh: its normals, its bounds, and the merging of its vertices.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Vertices and the triangles over them, counter-clockwise seen from outside.
///
/// As a *surface* (for the placement of sensors) it may be open. As a *shape* it must be a closed
/// solid. `validate_surface` and `validate_solid` check the two. All other functions on meshes
/// require valid vertex numbers.
template <Scalar S>
struct TriangleMesh {
  /// [m] Corners.
  std::vector<Vec3<S>> vertices;
  /// [-] Three vertex numbers a triangle.
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Cross product of two edges [m^2]: the outward normal times twice the triangle's area.
template <Scalar S>
[[nodiscard]] Vec3<S> area_vector(const TriangleMesh<S>& mesh, std::size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const Vec3<S>& origin = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - origin).cross(mesh.vertices[t[2]] - origin);
}

/// Area [m^2] of a triangle.
template <Scalar S>
[[nodiscard]] S triangle_area(const TriangleMesh<S>& mesh, std::size_t triangle) {
  return area_vector(mesh, triangle).norm() / S(2);
}

/// Outward unit normal of a triangle. Garbage if the triangle is degenerate.
template <Scalar S>
[[nodiscard]] Vec3<S> triangle_normal(const TriangleMesh<S>& mesh, std::size_t triangle) {
  return area_vector(mesh, triangle).stableNormalized();
}

/// Centroid [m] of a triangle.
template <Scalar S>
[[nodiscard]] Vec3<S> triangle_centroid(const TriangleMesh<S>& mesh, std::size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  return (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / S(3);
}

/// Smallest axis-aligned box [m] around the triangles. Unused vertices do not count.
template <Scalar S>
[[nodiscard]] Aabb<S> mesh_bounds(const TriangleMesh<S>& mesh) {
  Aabb<S> box;
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t) box.include(mesh.vertices[v]);
  }
  return box;
}

/// Returns the same surface with coinciding vertices merged.
///
/// The first of several vertices stays and keeps its place in the order. Triangles keep their
/// number and order. A triangle that lost a corner repeats a vertex number, and
/// `degenerate_triangles` lists it.
///
/// @param tolerance  [1] Distance below which vertices coincide, as a fraction of the diagonal of
///         the box around all vertices. 0 merges only equal coordinates.
/// @throws InvalidArgument if a vertex or the tolerance is not finite, the tolerance is negative,
///         or a triangle names a vertex that does not exist.
/// @note O(n log n).
template <Scalar S>
[[nodiscard]] TriangleMesh<S> weld(const TriangleMesh<S>& mesh, S tolerance = S(0));

/// Returns the mesh without the triangles of the given ascending numbers. All vertices stay.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> without_triangles(const TriangleMesh<S>& mesh,
                                                std::span<const std::uint32_t> numbers) {
  TriangleMesh<S> rest{mesh.vertices, {}};
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!std::binary_search(numbers.begin(), numbers.end(), t)) {
      rest.triangles.push_back(mesh.triangles[t]);
    }
  }
  return rest;
}

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// Text of numbers: "(3, 7, 9)".
template <typename Numbers>
[[nodiscard]] std::string to_tuple_text(const Numbers& numbers) {
  std::string text = "(";
  for (const auto& number : numbers) {
    if (text.size() > 1) text += ", ";
    text += to_text(number);
  }
  return text + ")";
}

[[noreturn]] inline void raise_triangle(std::size_t number, std::string value, std::string rule) {
  raise(InvalidArgument("TriangleMesh::triangles[" + std::to_string(number) + "]", std::move(value),
                        std::move(rule)));
}

/// Throws if a triangle names a vertex that does not exist.
template <Scalar S>
void require_named_vertices(const TriangleMesh<S>& mesh) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      if (v < mesh.vertices.size()) continue;
      raise_triangle(t, to_tuple_text(mesh.triangles[t]),
                     "must name vertices below " + std::to_string(mesh.vertices.size()));
    }
  }
}

/// Result of a merge. `unique` lists the numbers of the points that stay, ascending. `renumber[i]`
/// is the index in that list of point i, or of the point it coincides with.
struct MergedPoints {
  DynamicArray<std::uint32_t> unique;
  DynamicArray<std::uint32_t> renumber;
};

/// Merges each point, in order, with the first earlier one that stayed within `distance` [m] of it.
/// The points must be finite.
///
/// Points that stayed are listed by their cubic cell. Cells are twice `distance` wide. So a
/// neighbour is in the point's own cell or in one of the seven on its near side.
template <Scalar S>
[[nodiscard]] MergedPoints merge_points(std::span<const Vec3<S>> points, S distance) {
  using Cell = std::array<S, 3>;
  using std::floor;
  const bool is_exact = !(distance > S(0));
  const S width = S(2) * distance;
  // Equal coordinates only: every coordinate is its own cell. Adding 0 turns -0 into 0.
  const auto place_of = [&](const Vec3<S>& point, std::size_t axis) {
    const S x = point[static_cast<Eigen::Index>(axis)];
    return is_exact ? x + S(0) : x / width;
  };
  const auto cell_of = [&](const Vec3<S>& point) {
    Cell cell;
    for (std::size_t a = 0; a < 3; ++a) {
      cell[a] = is_exact ? place_of(point, a) : floor(place_of(point, a));
    }
    return cell;
  };
  DynamicArray<Cell> cells;
  cells.reserve(points.size());
  for (const Vec3<S>& point : points) cells.push_back(cell_of(point));
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  DynamicArray<DynamicArray<std::uint32_t>> stayed(cells.size());
  MergedPoints result;
  result.renumber.reserve(points.size());

  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Cell cell = cell_of(points[i]);
    std::uint32_t found = detail::no_index;
    for (unsigned corner = 0; corner < (is_exact ? 1u : 8u); ++corner) {
      Cell near = cell;
      for (std::size_t a = 0; a < 3; ++a) {
        if ((corner >> a & 1u) == 0) continue;
        near[a] += place_of(points[i], a) - cell[a] < S(0.5) ? S(-1) : S(1);
      }
      const auto place = std::lower_bound(cells.begin(), cells.end(), near);
      if (place == cells.end() || *place != near) continue;
      for (const std::uint32_t candidate :
           stayed[static_cast<std::size_t>(place - cells.begin())]) {
        const Vec3<S> gap = points[result.unique[candidate]] - points[i];
        if (gap.squaredNorm() <= distance * distance) found = std::min(found, candidate);
      }
    }
    if (found == detail::no_index) {
      found = static_cast<std::uint32_t>(result.unique.size());
      result.unique.push_back(i);
      const auto place = std::lower_bound(cells.begin(), cells.end(), cell);
      stayed[static_cast<std::size_t>(place - cells.begin())].push_back(found);
    }
    result.renumber.push_back(found);
  }
  return result;
}

}  // namespace detail

template <Scalar S>
TriangleMesh<S> weld(const TriangleMesh<S>& mesh, S tolerance) {
  detail::require_not_negative("weld: tolerance", tolerance);
  detail::require_named_vertices(mesh);
  Aabb<S> box;
  for (const Vec3<S>& v : mesh.vertices) {
    detail::require_all_finite("TriangleMesh::vertices", v);
    box.include(v);
  }
  const S distance = box.is_empty() ? S(0) : tolerance * (box.upper - box.lower).norm();
  const detail::MergedPoints merged =
      detail::merge_points<S>(std::span<const Vec3<S>>(mesh.vertices), distance);

  TriangleMesh<S> welded;
  welded.vertices.reserve(merged.unique.size());
  for (const std::uint32_t v : merged.unique) welded.vertices.push_back(mesh.vertices[v]);
  welded.triangles = mesh.triangles;
  for (auto& t : welded.triangles) {
    for (std::uint32_t& v : t) v = merged.renumber[v];
  }
  return welded;
}

}  // namespace bristle::inline BRISTLE_ABI
