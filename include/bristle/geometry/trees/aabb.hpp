/// @file
/// Axis-aligned box.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/transform.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Axis-aligned box. Default-constructed it is empty (lower > upper). Bounds may be infinite.
template <Scalar S>
struct Aabb {
  /// [m] Smallest corner.
  Vec3<S> lower = detail::filled<Vec3<S>>(infinity<S>);
  /// [m] Largest corner.
  Vec3<S> upper = detail::filled<Vec3<S>>(-infinity<S>);

  /// Returns whether the box holds no point.
  [[nodiscard]] bool is_empty() const {
    return lower[0] > upper[0] || lower[1] > upper[1] || lower[2] > upper[2];
  }

  /// Grows the box to hold a point.
  void include(const Vec3<S>& p) {
    lower = cwise_min(lower, p);
    upper = cwise_max(upper, p);
  }
  /// Grows the box to hold another one.
  void include(const Aabb& box) {
    lower = cwise_min(lower, box.lower);
    upper = cwise_max(upper, box.upper);
  }

  /// Returns the box grown by `margin` [m] on every side.
  [[nodiscard]] Aabb inflated(S margin) const {
    return {lower - detail::filled<Vec3<S>>(margin), upper + detail::filled<Vec3<S>>(margin)};
  }
  /// [m] Middle of the box.
  [[nodiscard]] Vec3<S> center() const { return S(0.5) * (lower + upper); }
  /// [m] Half of each edge.
  [[nodiscard]] Vec3<S> half_extents() const { return S(0.5) * (upper - lower); }

  /// Returns whether two boxes overlap. Touching counts.
  [[nodiscard]] bool overlaps(const Aabb& other) const {
    return all_at_most(lower, other.upper) && all_at_most(other.lower, upper);
  }
  /// Returns whether the other box is inside. Touching the bounds counts.
  [[nodiscard]] bool contains(const Aabb& other) const {
    return all_at_most(lower, other.lower) && all_at_most(other.upper, upper);
  }
  /// Returns whether a point is inside. The bounds count.
  [[nodiscard]] bool contains(const Vec3<S>& p) const {
    return all_at_most(lower, p) && all_at_most(p, upper);
  }

  /// Returns the box around this one and itself moved by `way` [m].
  [[nodiscard]] Aabb swept(const Vec3<S>& way) const {
    return {lower + cwise_min(way, detail::zero<Vec3<S>>()),
            upper + cwise_max(way, detail::zero<Vec3<S>>())};
  }
  /// [m^2] Squared distance to another box. 0 where they overlap.
  [[nodiscard]] S distance2_to(const Aabb& other) const {
    const Vec3<S> apart = cwise_max(Vec3<S>(other.lower - upper), Vec3<S>(lower - other.upper));
    return cwise_max(apart, detail::zero<Vec3<S>>()).squaredNorm();
  }

  /// [m^2] Half the surface of a box with edges x, y and z [m].
  [[nodiscard]] static S half_area_of(S x, S y, S z) { return x * y + y * z + z * x; }
  /// [m^2] Half the surface: the cost measure of tree building (surface-area heuristic).
  [[nodiscard]] S half_area() const {
    return half_area_of(upper.x() - lower.x(), upper.y() - lower.y(), upper.z() - lower.z());
  }
};

/// Returns the smallest axis-aligned box in A around a finite box in B, at the position p_AB [m].
template <Scalar S>
[[nodiscard]] Aabb<S> transformed(const Aabb<S>& box_B, const Mat3<S>& R_AB, const Vec3<S>& p_AB) {
  const Vec3<S> center = R_AB * box_B.center() + p_AB;
  const Vec3<S> half = cwise_abs(R_AB) * box_B.half_extents();
  return {center - half, center + half};
}
/// The same, at the pose X_AB.
template <Scalar S>
[[nodiscard]] Aabb<S> transformed(const Aabb<S>& box_B, const Transform<S>& X_AB) {
  return transformed<S>(box_B, X_AB.rotation_matrix(), X_AB.translation);
}

}  // namespace bristle::inline BRISTLE_ABI
