/// @file
/// Convex hull of points on an integer grid, in exact arithmetic: the core of `convex_hull`.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// A point on the integer grid of a hull, coordinates within +-2^29.
using GridPoint = std::array<std::int64_t, 3>;

/// The point as a vector.
/// @tparam Real  Type of lengths on the grid. It holds coordinates exactly. All of the hull takes
///         `double`. It is a parameter so that files that make no hull instantiate none of Eigen's
///         expressions of double. These take a compiler 0.15 s.
template <Scalar Real>
[[nodiscard]] Vec3<Real> to_vector(const GridPoint& p) {
  static_assert(std::numeric_limits<Real>::digits >= 30);
  return {static_cast<Real>(p[0]), static_cast<Real>(p[1]), static_cast<Real>(p[2])};
}

/// Returns 1 if d is above the plane of a, b, c, 0 if it is on the plane, -1 below. Seen from
/// above, a, b, c run counter-clockwise.
///
/// Exact for coordinates within +-2^29. Differences need 31 bits, their 2x2 determinants 62. The
/// last product would need 94. So the determinants are split at bit 30.
[[nodiscard]] inline int side_of_plane(const GridPoint& a, const GridPoint& b, const GridPoint& c,
                                       const GridPoint& d) {
  GridPoint u, v, w;
  for (std::size_t k = 0; k < 3; ++k) {
    u[k] = b[k] - a[k];
    v[k] = c[k] - a[k];
    w[k] = d[k] - a[k];
  }
  constexpr std::int64_t low_bits = (std::int64_t(1) << 30) - 1;
  std::int64_t high = 0;
  std::int64_t low = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t i = (k + 1) % 3;
    const std::size_t j = (k + 2) % 3;
    const std::int64_t minor = u[i] * v[j] - u[j] * v[i];
    high += w[k] * (minor >> 30);
    low += w[k] * (minor & low_bits);
  }
  high += low >> 30;
  low &= low_bits;
  if (high != 0) return high < 0 ? -1 : 1;
  return low != 0 ? 1 : 0;
}

/// One triangle of the growing hull.
struct HullTriangle {
  /// Corners, counter-clockwise from outside.
  std::array<std::uint32_t, 3> corners{};
  /// Number of the triangle across the edge from corner k to corner k + 1.
  std::array<std::uint32_t, 3> neighbors{};
  /// Points that are above it and above no triangle tested before it.
  DynamicArray<std::uint32_t> outside;
  bool is_alive = true;
};

/// Quickhull (Barber, Dobkin and Huhdanpaa 1996) on grid points, down to triangles.
/// @tparam Real  As in `to_vector`.
template <Scalar Real>
class TriangleHull {
 public:
  /// @param points   Must outlive the hull.
  /// @param simplex  Four points of the set that are not on a plane.
  TriangleHull(const DynamicArray<GridPoint>& points, std::array<std::uint32_t, 4> simplex)
      : points_(points) {
    make_simplex(simplex);
    DynamicArray<std::uint32_t> all(points.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    assign(all, 0);
    // Triangles are only ever appended, so one pass visits them all.
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      if (triangles_[t].is_alive && !triangles_[t].outside.empty()) {
        add_point(farthest_outside(t), t);
      }
    }
    keep_living();
  }

  /// Closed surface. Coplanar triangles are frequent, degenerate ones impossible.
  [[nodiscard]] const DynamicArray<HullTriangle>& triangles() const { return triangles_; }

 private:
  [[nodiscard]] bool is_above(std::uint32_t point, const HullTriangle& t) const {
    return side_of_plane(points_[t.corners[0]], points_[t.corners[1]], points_[t.corners[2]],
                         points_[point]) > 0;
  }

  void make_simplex(std::array<std::uint32_t, 4> s) {
    if (side_of_plane(points_[s[0]], points_[s[1]], points_[s[2]], points_[s[3]]) > 0) {
      std::swap(s[1], s[2]);
    }
    triangles_.resize(4);
    triangles_[0].corners = {s[0], s[1], s[2]};
    triangles_[0].neighbors = {1, 2, 3};
    for (std::uint32_t k = 0; k < 3; ++k) {
      triangles_[k + 1].corners = {s[(k + 1) % 3], s[k], s[3]};
      triangles_[k + 1].neighbors = {0, (k + 2) % 3 + 1, (k + 1) % 3 + 1};
    }
  }

  /// Assigns each point to the first triangle from `first` on that it is above. Points above none
  /// are inside and dropped.
  void assign(const DynamicArray<std::uint32_t>& candidates, std::size_t first) {
    for (const std::uint32_t p : candidates) {
      for (std::size_t t = first; t < triangles_.size(); ++t) {
        if (is_above(p, triangles_[t])) {
          triangles_[t].outside.push_back(p);
          break;
        }
      }
    }
  }

  /// Any point above is correct. The farthest leaves most others inside. So rounding is harmless
  /// here.
  [[nodiscard]] std::uint32_t farthest_outside(std::uint32_t t) const {
    const HullTriangle& triangle = triangles_[t];
    const Vec3<Real> origin = to_vector<Real>(points_[triangle.corners[0]]);
    const Vec3<Real> normal = (to_vector<Real>(points_[triangle.corners[1]]) - origin)
                                  .cross(to_vector<Real>(points_[triangle.corners[2]]) - origin);
    std::uint32_t best = triangle.outside.front();
    Real best_height = -infinity<Real>;
    for (const std::uint32_t p : triangle.outside) {
      const Real height = normal.dot(to_vector<Real>(points_[p]) - origin);
      if (height > best_height) {
        best_height = height;
        best = p;
      }
    }
    return best;
  }

  /// An edge between a triangle that the new point sees and one that it does not.
  struct HorizonEdge {
    std::uint32_t from, to, beyond;
  };

  /// Replaces the triangles that see the point by a fan from the horizon to it.
  void add_point(std::uint32_t point, std::uint32_t seed) {
    DynamicArray<HorizonEdge> horizon;
    DynamicArray<std::uint32_t> orphans;
    DynamicArray<std::uint32_t> visible{seed};
    triangles_[seed].is_alive = false;
    for (std::size_t i = 0; i < visible.size(); ++i) {
      HullTriangle& t = triangles_[visible[i]];
      orphans.append(t.outside.begin(), t.outside.end());
      t.outside = {};
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t beyond = t.neighbors[k];
        if (!triangles_[beyond].is_alive) continue;
        if (is_above(point, triangles_[beyond])) {
          triangles_[beyond].is_alive = false;
          visible.push_back(beyond);
        }
      }
    }
    for (const std::uint32_t v : visible) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t beyond = triangles_[v].neighbors[k];
        if (triangles_[beyond].is_alive) {
          horizon.push_back({triangles_[v].corners[k], triangles_[v].corners[(k + 1) % 3], beyond});
        }
      }
    }
    const auto first = static_cast<std::uint32_t>(triangles_.size());
    add_fan(point, horizon);
    assign(orphans, first);
  }

  /// Takes the horizon as one closed loop, in any order.
  void add_fan(std::uint32_t point, DynamicArray<HorizonEdge>& horizon) {
    const auto by_start = [](const HorizonEdge& a, const HorizonEdge& b) {
      return a.from < b.from;
    };
    std::sort(horizon.begin(), horizon.end(), by_start);
    const auto first = static_cast<std::uint32_t>(triangles_.size());
    const auto starting_at = [&](std::uint32_t vertex) {
      const auto edge =
          std::lower_bound(horizon.begin(), horizon.end(), HorizonEdge{vertex, 0, 0}, by_start);
      BRISTLE_ASSERT(edge != horizon.end() && edge->from == vertex);
      return first + static_cast<std::uint32_t>(edge - horizon.begin());
    };
    triangles_.resize(triangles_.size() + horizon.size());
    for (std::uint32_t i = 0; i < horizon.size(); ++i) {
      const HorizonEdge& edge = horizon[i];
      const std::uint32_t next = starting_at(edge.to);
      triangles_[first + i].corners = {edge.from, edge.to, point};
      triangles_[first + i].neighbors[0] = edge.beyond;
      triangles_[first + i].neighbors[1] = next;
      triangles_[next].neighbors[2] = first + i;
      HullTriangle& beyond = triangles_[edge.beyond];
      for (std::size_t k = 0; k < 3; ++k) {
        if (beyond.corners[k] == edge.to) beyond.neighbors[k] = first + i;
      }
    }
  }

  void keep_living() {
    DynamicArray<std::uint32_t> renumber(triangles_.size());
    std::uint32_t count = 0;
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      if (triangles_[t].is_alive) renumber[t] = count++;
    }
    erase_if(triangles_, [](const HullTriangle& t) { return !t.is_alive; });
    for (HullTriangle& t : triangles_) {
      for (std::uint32_t& n : t.neighbors) n = renumber[n];
    }
  }

  const DynamicArray<GridPoint>& points_;
  DynamicArray<HullTriangle> triangles_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
