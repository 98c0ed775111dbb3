/// @file
/// Convex hull of a set of points, with polygons as faces.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/shapes/convex_hull.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <span>

namespace bristle::inline BRISTLE_ABI {

/// Returns the smallest convex solid around a set of points, with coplanar triangles joined to
/// polygons.
///
/// Points may repeat. Any number of them may be on one plane or line. Points that are no corners
/// are left out. Points closer than `hull_resolution` times the size of the set count as equal.
/// Vertices keep the order of the points. Each face starts at its lowest vertex. Faces are sorted
/// by their vertices. So the result does not depend on the search.
///
/// @throws InvalidArgument when a point is not finite, or the points do not span a volume: fewer
///         than 4, all on a plane, a line or a point.
/// @note O(n log n) for points spread evenly. A cloud of 10 000 takes some hundredths of a second.
template <Scalar S>
[[nodiscard]] ConvexHull<S> convex_hull(std::span<const Vec3<S>> points);

/// Returns the hull of all vertices that a mesh's triangles use.
/// @throws InvalidArgument as above, or when a triangle names a vertex that does not exist.
template <Scalar S>
[[nodiscard]] ConvexHull<S> convex_hull(const TriangleMesh<S>& mesh);

/// [1] Distance below which points of a hull count as equal, coplanar or collinear, as a fraction
/// of the longest side of their box.
template <Scalar S>
[[nodiscard]] S hull_resolution() {
  return std::max(detail::Tolerance<S>::round_off(),
                  S(detail::chosen::hull_resolution_cells / (1 << 30)));
}

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/core/error.hpp>
#include <bristle/geometry/shapes/grid_hull.hpp>
#include <bristle/geometry/shapes/hull_faces.hpp>
#include <bristle/geometry/trees/aabb.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

namespace bristle::inline BRISTLE_ABI {

// Rounding breaks quickhull if points are nearly coplanar. It sees one side of a face as visible
// and contradicts itself at the next. So the points are put on an integer grid of 2^30 steps across
// the set. There every sidedness test is exact. So the textbook algorithm is right for every input.
// The grid's noise remains. A plane of many points becomes many triangles that differ in the last
// bits. A second pass joins faces that are coplanar within the resolution. A vertex with fewer than
// three faces disappears. It does so from both sides of its edge alike.

namespace detail {

/// The points of a hull, each of them once, and their grid points.
template <Scalar S>
struct GriddedPoints {
  /// Of lengths on the grid.
  using Real = double;

  DynamicArray<Vec3<S>> points;
  DynamicArray<GridPoint> grid;
  /// [m] Distance below which points count as equal.
  S resolution = S(0);
  /// [grid steps] The same distance.
  Real tolerance = Real(0);
};

[[noreturn]] inline void raise_no_volume(const std::string& what) {
  raise(InvalidArgument("convex_hull: points", what, "must span a volume"));
}

template <Scalar S>
[[nodiscard]] GriddedPoints<S> put_on_grid(std::span<const Vec3<S>> points) {
  Aabb<S> box;
  for (std::size_t i = 0; i < points.size(); ++i) {
    require_all_finite("convex_hull: points[" + std::to_string(i) + "]", points[i]);
    box.include(points[i]);
  }
  if (points.size() < 4) raise_no_volume(std::to_string(points.size()) + " points");
  const S extent = (box.upper - box.lower).maxCoeff();
  if (!(extent > S(0))) raise_no_volume("all equal");
  require_finite("convex_hull: extent of the points", extent);

  // Far from the origin, rounding of the coordinates exceeds the resolution.
  const S reach = std::max(cwise_abs(box.lower).maxCoeff(), cwise_abs(box.upper).maxCoeff());
  GriddedPoints<S> result;
  result.resolution = std::max(hull_resolution<S>() * extent, Tolerance<S>::round_off() * reach);
  for (const std::uint32_t i : merge_points(points, result.resolution).unique) {
    result.points.push_back(points[i]);
  }
  const double scale = static_cast<double>(1 << 30) / static_cast<double>(extent);
  result.tolerance = scale * static_cast<double>(result.resolution);
  for (const Vec3<S>& p : result.points) {
    GridPoint& g = result.grid.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const S from_center = p[k] - box.center()[k];
      g[static_cast<std::size_t>(k)] = std::llround(scale * static_cast<double>(from_center));
    }
  }
  return result;
}

/// Four points that are far from coplanar.
/// @tparam Real  As in `to_vector`.
template <Scalar Real>
[[nodiscard]] std::array<std::uint32_t, 4> find_simplex(const DynamicArray<GridPoint>& points,
                                                        Real tolerance) {
  const auto farthest = [&](auto&& distance, const char* what) {
    std::uint32_t best = 0;
    Real best_distance = tolerance;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const Real d = distance(to_vector<Real>(points[i]));
      if (d > best_distance) {
        best_distance = d;
        best = i;
      }
    }
    if (!(best_distance > tolerance)) raise_no_volume(what);
    return best;
  };
  std::array<std::uint32_t, 4> s{};
  const Vec3<Real> any = to_vector<Real>(points[0]);
  s[0] = farthest([&](const Vec3<Real>& p) { return (p - any).norm(); }, "all equal");
  const Vec3<Real> a = to_vector<Real>(points[s[0]]);
  s[1] = farthest([&](const Vec3<Real>& p) { return (p - a).norm(); }, "all equal");
  const Vec3<Real> along = (to_vector<Real>(points[s[1]]) - a).normalized();
  s[2] = farthest([&](const Vec3<Real>& p) { return along.cross(p - a).norm(); }, "all on a line");
  const Vec3<Real> normal = along.cross(to_vector<Real>(points[s[2]]) - a).normalized();
  // If thinner, both sides could be in the slab of one face.
  tolerance *= Real(chosen::hull_simplex_height);
  s[3] =
      farthest([&](const Vec3<Real>& p) { return std::abs(normal.dot(p - a)); }, "all on a plane");
  return s;
}

/// Outward unit normal of a face. It is computed from the points themselves, to their full
/// precision. Small or thin faces take the grid. Rounding would tilt them out of their corners or
/// into the hull.
template <Scalar S>
[[nodiscard]] Vec3<S> face_normal(const GriddedPoints<S>& gridded,
                                  const HullFace<typename GriddedPoints<S>::Real>& face) {
  const DynamicArray<Vec3<S>>& points = gridded.points;
  const Vec3<S>& origin = points[face.corners[0]];
  Vec3<S> sum = zero<Vec3<S>>();
  for (std::size_t i = 2; i < face.corners.size(); ++i) {
    sum += (points[face.corners[i - 1]] - origin).cross(points[face.corners[i]] - origin);
  }
  const Vec3<S> normal = sum.stableNormalized();
  const auto height = [&](std::uint32_t v) { return normal.dot(points[v] - origin); };
  S lowest = S(0);
  S highest = S(0);
  for (const std::uint32_t v : face.corners) {
    lowest = std::min(lowest, height(v));
    highest = std::max(highest, height(v));
  }
  const bool is_supporting = std::all_of(face.ring.begin(), face.ring.end(),
                                         [&](std::uint32_t v) { return height(v) <= lowest; });
  const bool is_flat = highest - lowest <= gridded.resolution;
  return is_supporting && is_flat ? normal : Vec3<S>(face.normal.template cast<S>());
}

}  // namespace detail

template <Scalar S>
ConvexHull<S> convex_hull(std::span<const Vec3<S>> points) {
  const detail::GriddedPoints<S> gridded = detail::put_on_grid(points);
  using Real = typename detail::GriddedPoints<S>::Real;
  const detail::TriangleHull<Real> triangles(
      gridded.grid, detail::find_simplex<Real>(gridded.grid, gridded.tolerance));
  auto faces =
      detail::FaceJoin<Real>(gridded.grid, triangles.triangles(), gridded.tolerance).faces();
  for (auto& face : faces) {
    const auto lowest = std::min_element(face.corners.begin(), face.corners.end());
    std::rotate(face.corners.begin(), lowest, face.corners.end());
  }
  std::sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) {
    return std::lexicographical_compare(a.corners.begin(), a.corners.end(), b.corners.begin(),
                                        b.corners.end());
  });

  ConvexHull<S> hull;
  detail::DynamicArray<std::uint32_t> renumber(gridded.points.size(), detail::no_index);
  for (const auto& face : faces) {
    for (const std::uint32_t v : face.corners) renumber[v] = 0;
  }
  for (std::size_t v = 0; v < renumber.size(); ++v) {
    if (renumber[v] == detail::no_index) continue;
    renumber[v] = static_cast<std::uint32_t>(hull.vertices.size());
    hull.vertices.push_back(gridded.points[v]);
  }
  hull.face_starts.push_back(0);
  for (const auto& face : faces) {
    for (const std::uint32_t v : face.corners) hull.face_vertices.push_back(renumber[v]);
    hull.face_starts.push_back(static_cast<std::uint32_t>(hull.face_vertices.size()));
    hull.face_normals.push_back(detail::face_normal(gridded, face));
    S offset = -infinity<S>;
    for (const std::uint32_t v : face.corners) {
      offset = std::max(offset, hull.face_normals.back().dot(gridded.points[v]));
    }
    hull.face_offsets.push_back(offset);
  }
  return hull;
}

template <Scalar S>
ConvexHull<S> convex_hull(const TriangleMesh<S>& mesh) {
  detail::require_named_vertices(mesh);
  detail::DynamicArray<Vec3<S>> points;
  for (const auto& t : mesh.triangles) {
    for (const std::uint32_t v : t) points.push_back(mesh.vertices[v]);
  }
  return convex_hull<S>(std::span<const Vec3<S>>(points));
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

/// Declares (`extern template`) or defines (`template`) the hulls in a scalar.
#define BRISTLE_HULL_FUNCTIONS(declare_or_make, S)                               \
  declare_or_make ConvexHull<S> convex_hull<S>(std::span<const Vec3<S>> points); \
  declare_or_make ConvexHull<S> convex_hull<S>(const TriangleMesh<S>& mesh);

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

BRISTLE_HULL_FUNCTIONS(extern template, float)
BRISTLE_HULL_FUNCTIONS(extern template, double)

}  // namespace bristle::inline BRISTLE_ABI
#endif
