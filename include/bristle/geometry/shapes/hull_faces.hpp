/// @file
/// Joins the coplanar triangles of a convex hull to polygons: the second half of `convex_hull`.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/fill_numbers.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/geometry/shapes/grid_hull.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// A polygon of a hull.
/// @tparam Real  As in `to_vector`.
template <Scalar Real>
struct HullFace {
  /// Corners, counter-clockwise from outside.
  DynamicArray<std::uint32_t> corners;
  /// Third corners of the triangles across its border. The hull is convex. So a plane through the
  /// face that has them below has everything below.
  DynamicArray<std::uint32_t> ring;
  /// Outward unit normal on the grid, of the largest triangle of the face. No point of the hull is
  /// above that plane.
  Vec3<Real> normal = unit_z<Vec3<Real>>();
};

/// Joins the triangles of a closed convex surface to faces.
///
/// A region grows from the largest free triangle over all neighbours whose corners are near its
/// plane. The plane of a sliver means little. A sliver joins the region across its longest edge, if
/// it is near that plane. A region with fewer than three corners is no polygon and joins its
/// longest neighbour. A vertex is a corner if at least three regions meet there. That does not
/// depend on the side. So faces on both sides of an edge agree on its ends.
template <Scalar Real>
class FaceJoin {
 public:
  /// @param points, triangles  Must outlive it.
  /// @param tolerance          [grid steps] Largest distance of a face's corners from its plane.
  FaceJoin(const DynamicArray<GridPoint>& points, const DynamicArray<HullTriangle>& triangles,
           Real tolerance)
      : points_(points), triangles_(triangles), tolerance_(tolerance) {
    measure();
    grow_regions();
    // Each call that returns true removes one region.
    while (dissolve_small_regions()) {
    }
  }

  [[nodiscard]] DynamicArray<HullFace<Real>> faces() const;

 private:
  /// One side of a triangle: from corner `edge` to the next.
  struct Side {
    std::uint32_t triangle;
    std::size_t edge;

    friend bool operator==(const Side&, const Side&) = default;
  };

  [[nodiscard]] std::uint32_t start_of(Side s) const {
    return triangles_[s.triangle].corners[s.edge];
  }
  [[nodiscard]] std::uint32_t across(Side s) const {
    return triangles_[s.triangle].neighbors[s.edge];
  }
  [[nodiscard]] bool is_border(Side s) const { return region_[s.triangle] != region_[across(s)]; }
  [[nodiscard]] Real length_of(Side s) const {
    const std::uint32_t end = triangles_[s.triangle].corners[(s.edge + 1) % 3];
    return (to_vector<Real>(points_[end]) - to_vector<Real>(points_[start_of(s)])).norm();
  }
  /// The side of a triangle that starts at one of its vertices.
  [[nodiscard]] Side side_from(std::uint32_t triangle, std::uint32_t vertex) const {
    const auto& corners = triangles_[triangle].corners;
    const auto corner = std::find(corners.begin(), corners.end(), vertex);
    return {triangle, static_cast<std::size_t>(corner - corners.begin())};
  }
  /// The next side, counter-clockwise around the vertex where both start.
  [[nodiscard]] Side turned(Side s) const {
    return side_from(across({s.triangle, (s.edge + 2) % 3}), start_of(s));
  }
  /// The same, clockwise.
  [[nodiscard]] Side turned_back(Side s) const { return side_from(across(s), start_of(s)); }

  void measure();
  [[nodiscard]] Real depth_below(std::uint32_t plane, std::uint32_t t) const;
  void grow_regions();
  void grow_region(std::uint32_t seed);
  bool adopt_slivers(DynamicArray<std::uint32_t>& orphans);
  bool dissolve_small_regions();
  [[nodiscard]] DynamicArray<Side> sides_by_start() const;
  [[nodiscard]] std::size_t count_regions_around(Side first) const;

  const DynamicArray<GridPoint>& points_;
  const DynamicArray<HullTriangle>& triangles_;
  Real tolerance_;
  DynamicArray<Vec3<Real>> area_vectors_;
  DynamicArray<std::size_t> longest_edge_;
  DynamicArray<bool> is_sliver_;
  /// Seed triangle of each triangle's region.
  DynamicArray<std::uint32_t> region_;
};

template <Scalar Real>
void FaceJoin<Real>::measure() {
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    const auto& c = triangles_[t].corners;
    const Vec3<Real> a = to_vector<Real>(points_[c[0]]);
    area_vectors_.push_back(
        (to_vector<Real>(points_[c[1]]) - a).cross(to_vector<Real>(points_[c[2]]) - a));
    std::size_t longest = 0;
    for (std::size_t k = 1; k < 3; ++k) {
      if (length_of({t, k}) > length_of({t, longest})) longest = k;
    }
    longest_edge_.push_back(longest);
    // Apex and base may both be off by a tolerance.
    is_sliver_.push_back(area_vectors_[t].norm() <= Real(2) * tolerance_ * length_of({t, longest}));
  }
}

/// Depth of the lowest corner of triangle t below the plane of another. No corner is above.
template <Scalar Real>
Real FaceJoin<Real>::depth_below(std::uint32_t plane, std::uint32_t t) const {
  const Vec3<Real> normal = area_vectors_[plane].normalized();
  const Vec3<Real> origin = to_vector<Real>(points_[triangles_[plane].corners[0]]);
  Real depth = Real(0);
  for (const std::uint32_t v : triangles_[t].corners) {
    depth = std::max(depth, normal.dot(origin - to_vector<Real>(points_[v])));
  }
  return depth;
}

template <Scalar Real>
void FaceJoin<Real>::grow_regions() {
  region_.assign(triangles_.size(), no_index);
  DynamicArray<std::uint32_t> order(triangles_.size());
  fill_numbers(order);
  DynamicArray<Real> area2(order.size());
  for (const std::uint32_t t : order) area2[t] = area_vectors_[t].squaredNorm();
  // Not std::stable_sort. That of libstdc++ before 13 uses a part that C++20 deprecates, and clang
  // warns.
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return area2[a] != area2[b] ? area2[a] > area2[b] : a < b;
  });
  for (const std::uint32_t seed : order) {
    if (region_[seed] == no_index && !is_sliver_[seed]) grow_region(seed);
  }
  erase_if(order, [this](std::uint32_t t) { return region_[t] != no_index; });
  while (!order.empty()) {
    if (adopt_slivers(order)) continue;
    // No neighbour adopts them: thin needles consist of slivers alone.
    grow_region(order.front());
    erase_if(order, [this](std::uint32_t t) { return region_[t] != no_index; });
  }
}

template <Scalar Real>
void FaceJoin<Real>::grow_region(std::uint32_t seed) {
  const Vec3<Real>& normal = area_vectors_[seed];
  DynamicArray<std::uint32_t> members{seed};
  region_[seed] = seed;
  for (std::size_t i = 0; i < members.size(); ++i) {
    for (const std::uint32_t t : triangles_[members[i]].neighbors) {
      // Thin solids have two faces in one slab, back to back.
      if (region_[t] != no_index || normal.dot(area_vectors_[t]) < Real(0) ||
          depth_below(seed, t) > tolerance_) {
        continue;
      }
      region_[t] = seed;
      members.push_back(t);
    }
  }
}

/// Removes the triangles that found a region from the list. Returns false if none did.
template <Scalar Real>
bool FaceJoin<Real>::adopt_slivers(DynamicArray<std::uint32_t>& orphans) {
  return erase_if(orphans, [this](std::uint32_t t) {
           const std::uint32_t heir = region_[across({t, longest_edge_[t]})];
           // Two tolerances of its own height, one of the heir's border.
           if (heir != no_index && depth_below(heir, t) <= Real(3) * tolerance_) region_[t] = heir;
           return region_[t] != no_index;
         }) > 0;
}

/// One side that starts at each vertex. `triangle` is `no_index` if the vertex is not on the hull.
template <Scalar Real>
auto FaceJoin<Real>::sides_by_start() const -> DynamicArray<Side> {
  DynamicArray<Side> sides(points_.size(), Side{no_index, 0});
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) sides[triangles_[t].corners[k]] = {t, k};
  }
  return sides;
}

template <Scalar Real>
std::size_t FaceJoin<Real>::count_regions_around(Side first) const {
  std::size_t count = 0;
  Side side = first;
  do {
    if (is_border(side)) ++count;
    side = turned(side);
  } while (!(side == first));
  return count;
}

template <Scalar Real>
bool FaceJoin<Real>::dissolve_small_regions() {
  DynamicArray<std::size_t> corner_count(triangles_.size(), 0);
  for (const Side first : sides_by_start()) {
    if (first.triangle == no_index || count_regions_around(first) < 3) continue;
    Side side = first;
    do {
      if (is_border(side)) ++corner_count[region_[side.triangle]];
      side = turned(side);
    } while (!(side == first));
  }
  // One region at a time. Its end changes the corners of its neighbours.
  std::uint32_t region = no_index;
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    if (corner_count[region_[t]] >= 3) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      if (is_border({t, k})) region = std::min(region, region_[t]);
    }
  }
  if (region == no_index) return false;
  DynamicArray<Real> border_lengths(triangles_.size(), Real(0));  // By the region beyond.
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    if (region_[t] != region) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Side side{t, k};
      if (is_border(side)) border_lengths[region_[across(side)]] += length_of(side);
    }
  }
  const auto heir = static_cast<std::uint32_t>(
      std::max_element(border_lengths.begin(), border_lengths.end()) - border_lengths.begin());
  std::replace(region_.begin(), region_.end(), region, heir);
  return true;
}

template <Scalar Real>
DynamicArray<HullFace<Real>> FaceJoin<Real>::faces() const {
  DynamicArray<bool> is_corner(points_.size(), false);
  for (const Side side : sides_by_start()) {
    if (side.triangle == no_index) continue;
    is_corner[start_of(side)] = count_regions_around(side) >= 3;
  }
  DynamicArray<HullFace<Real>> faces;
  DynamicArray<bool> is_done(triangles_.size(), false);
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Side first{t, k};
      if (is_done[region_[t]] || !is_border(first)) continue;
      is_done[region_[t]] = true;
      HullFace<Real> face{{}, {}, area_vectors_[region_[t]].normalized()};
      Side side = first;
      do {
        if (is_corner[start_of(side)]) face.corners.push_back(start_of(side));
        face.ring.push_back(start_of({across(side), (turned_back(side).edge + 1) % 3}));
        // Proceeds to the border side of this region that starts where this one ends.
        side = {side.triangle, (side.edge + 1) % 3};
        while (!is_border(side)) side = turned_back(side);
      } while (!(side == first));
      faces.push_back(std::move(face));
    }
  }
  return faces;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
