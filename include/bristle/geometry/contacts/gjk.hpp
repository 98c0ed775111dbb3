/// @file
/// Distance of a convex set from the origin by its support function: GJK (Gilbert, Johnson,
/// Keerthi 1988).
///
/// The set is that of all differences a - b of points of two solids. Its point nearest the origin
/// gives their distance and their contact normal.
///
/// Robustness: every step must shorten the distance. Otherwise the search ends with the last step
/// that did. All sub-simplices with the newest corner are measured. The nearest one counts.
/// Sub-simplices that are flat to round-off are left to their edges. Nothing depends on the size of
/// the solids.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Result of a distance query. Its distance is a claim, which callers check by supports.
template <Scalar S>
struct GjkResult {
  /// False if the solids overlap or touch, to round-off. Then nothing else is valid.
  bool is_apart = false;
  /// [1] Unit normal from A into B.
  Vec3<S> normal = zero<Vec3<S>>();
  /// [m] Claimed distance. At least `far` if the search ended early.
  S distance = S(0);
};

/// Returns the distance of A and B. Ends after 64 supports at the latest.
///
/// @param support  (d) -> the farthest point of A - B along the direction d of any length > 0.
/// @param start    Any point of A - B.
/// @param far      [m] The search ends once the solids are proved to be farther apart.
/// @param enough   [1] The search also ends once claimed and proved distance agree to this part of
///                 the distance. The direction is then off by at most 2 sqrt(enough). Zero suits
///                 sets with corners alone. They end to round-off, the direction to its root. Round
///                 sets converge by a factor a support.
template <Scalar S, typename Support>
[[nodiscard]] GjkResult<S> gjk_distance(const Support& support, const Vec3<S>& start,
                                        S far = infinity<S>, S enough = S(0));

// Implementation ----------------------------------------------------------------------------------

/// Simplex of up to four points, and the point of it nearest to the origin.
template <Scalar S>
class GjkSimplex {
 public:
  explicit GjkSimplex(const Vec3<S>& first) : nearest_(first), nearest2_(first.squaredNorm()) {
    points_.fill(first);
  }

  [[nodiscard]] const Vec3<S>& nearest() const { return nearest_; }
  /// [m^2] Squared distance of the nearest point from the origin.
  [[nodiscard]] S nearest2() const { return nearest2_; }
  [[nodiscard]] bool has(const Vec3<S>& p) const {
    for (std::size_t i = 0; i < size_; ++i) {
      if (points_[i] == p) return true;
    }
    return false;
  }

  /// Adds a corner and drops those that do not carry the nearest point. Returns false, and changes
  /// nothing, if no point gets nearer.
  /// @param may_enclose  Whether the simplex may hold the origin. A flat one seems to, by rounding.
  bool add(const Vec3<S>& p, bool may_enclose) {
    const std::size_t n = size_;
    points_[n] = p;
    Best best{nearest2_, nearest_, 0, {}};
    offer(best, p, {n}, 1);
    for (std::size_t i = 0; i < n; ++i) try_edge(best, i, n);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) try_triangle(best, i, j, n);
    }
    if (may_enclose && n == 3 && is_origin_within(points_[0], points_[1], points_[2], p)) {
      offer(best, zero<Vec3<S>>(), {0, 1, 2}, 3);
    }
    if (best.size == 0) return false;
    const std::array<Vec3<S>, 4> all = points_;
    for (std::size_t i = 0; i < best.size; ++i) points_[i] = all[best.corners[i]];
    size_ = best.size;
    nearest_ = best.nearest;
    nearest2_ = best.nearest2;
    return true;
  }

 private:
  /// Indices of the corners that carry the nearest point.
  using Corners = std::array<std::size_t, 3>;

  struct Best {
    S nearest2;
    Vec3<S> nearest;
    std::size_t size;
    Corners corners;
  };

  static void offer(Best& best, const Vec3<S>& nearest, const Corners& corners, std::size_t size) {
    const S nearest2 = nearest.squaredNorm();
    if (nearest2 < best.nearest2) best = {nearest2, nearest, size, corners};
  }

  void try_edge(Best& best, std::size_t i, std::size_t n) const {
    const Vec3<S>& p = points_[n];
    const Vec3<S> along = points_[i] - p;
    const S length2 = along.squaredNorm();
    const S at = -p.dot(along);
    if (at > S(0) && at < length2) offer(best, p + (at / length2) * along, {i, n}, 2);
  }

  void try_triangle(Best& best, std::size_t i, std::size_t j, std::size_t k) const {
    const Vec3<S>& a = points_[i];
    const Vec3<S>& b = points_[j];
    const Vec3<S>& p = points_[k];
    const Vec3<S> pa = a - p;
    const Vec3<S> pb = b - p;
    const Vec3<S> n = pa.cross(pb);
    const S area2 = n.squaredNorm();
    // The normal of a sliver is rounding error. Its edges lie as near.
    constexpr S sliver = Tolerance<S>::equal() * Tolerance<S>::equal();
    if (!(area2 > sliver * pa.squaredNorm() * pb.squaredNorm())) return;
    if (pa.cross(p).dot(n) > S(0) || p.cross(pb).dot(n) > S(0)) return;
    if ((b - a).cross(a).dot(n) > S(0)) return;
    // Along the normal, whose direction is good however near the plane is.
    offer(best, (n.dot(p) / area2) * n, {i, j, k}, 3);
  }

  [[nodiscard]] static bool is_origin_within(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c,
                                             const Vec3<S>& p) {
    return is_beside(a, b, c, p) && is_beside(a, b, p, c) && is_beside(a, c, p, b) &&
           is_beside(b, c, p, a);
  }
  /// Returns whether the origin is on the same side of the plane through a, b, c as d.
  [[nodiscard]] static bool is_beside(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c,
                                      const Vec3<S>& d) {
    const Vec3<S> n = (b - a).cross(c - a);
    const S side = n.dot(d - a);
    return side > S(0) ? n.dot(a) <= S(0) : side < S(0) && n.dot(a) >= S(0);
  }

  // The fourth point exists only inside `add`.
  std::array<Vec3<S>, 4> points_;
  std::size_t size_ = 1;
  Vec3<S> nearest_;
  S nearest2_;
};

template <Scalar S, typename Support>
GjkResult<S> gjk_distance(const Support& support, const Vec3<S>& start, S far, S enough) {
  using std::sqrt;
  GjkSimplex<S> simplex(start);
  S size2 = start.squaredNorm();
  bool is_parted = false;  // By a plane that some support has shown.
  for (int i = 0; i < chosen::gjk_supports; ++i) {
    const Vec3<S>& v = simplex.nearest();
    constexpr S nothing = Tolerance<S>::round_off() * Tolerance<S>::round_off();
    if (!(simplex.nearest2() > nothing * size2)) return {};
    const Vec3<S> w = support(Vec3<S>(-v));
    size2 = std::max(size2, w.squaredNorm());
    const S proved = v.dot(w);
    if (simplex.nearest2() - proved <= enough * simplex.nearest2()) break;
    if (proved > S(0) && proved * proved > far * far * simplex.nearest2()) break;
    is_parted = is_parted || proved > Tolerance<S>::round_off() * sqrt(simplex.nearest2() * size2);
    if (simplex.has(w) || !simplex.add(w, !is_parted)) break;
  }
  const S distance = sqrt(simplex.nearest2());
  return {true, simplex.nearest() / -distance, distance};
}

}  // namespace bristle::inline BRISTLE_ABI::detail
