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
  Vec3<S> lower = Vec3<S>::Constant(infinity<S>);
  /// [m] Largest corner.
  Vec3<S> upper = Vec3<S>::Constant(-infinity<S>);

  /// Returns whether the box holds no point.
  [[nodiscard]] bool is_empty() const { return (lower.array() > upper.array()).any(); }

  /// Grows the box to hold a point.
  void include(const Vec3<S>& p) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  /// Grows the box to hold another one.
  void include(const Aabb& box) {
    lower = lower.cwiseMin(box.lower);
    upper = upper.cwiseMax(box.upper);
  }

  /// Returns the box grown by `margin` [m] on every side.
  [[nodiscard]] Aabb inflated(S margin) const {
    return {lower - Vec3<S>::Constant(margin), upper + Vec3<S>::Constant(margin)};
  }
  /// [m] Middle of the box.
  [[nodiscard]] Vec3<S> center() const { return S(0.5) * (lower + upper); }
  /// [m] Half of each edge.
  [[nodiscard]] Vec3<S> half_extents() const { return S(0.5) * (upper - lower); }

  /// Returns whether two boxes overlap. Touching counts.
  [[nodiscard]] bool overlaps(const Aabb& other) const {
    return (lower.array() <= other.upper.array()).all() &&
           (other.lower.array() <= upper.array()).all();
  }
  /// Returns whether the other box is inside. Touching the bounds counts.
  [[nodiscard]] bool contains(const Aabb& other) const {
    return (lower.array() <= other.lower.array()).all() &&
           (other.upper.array() <= upper.array()).all();
  }
  /// Returns whether a point is inside. The bounds count.
  [[nodiscard]] bool contains(const Vec3<S>& p) const {
    return (lower.array() <= p.array()).all() && (p.array() <= upper.array()).all();
  }

  /// [m^2] Half the surface of a box with edges x, y and z [m].
  [[nodiscard]] static S half_area_of(S x, S y, S z) { return x * y + y * z + z * x; }
  /// [m^2] Half the surface: the cost measure of tree building (surface-area heuristic).
  [[nodiscard]] S half_area() const {
    return half_area_of(upper.x() - lower.x(), upper.y() - lower.y(), upper.z() - lower.z());
  }
};

/// Returns the smallest axis-aligned box in A around a finite box in B.
template <Scalar S>
[[nodiscard]] Aabb<S> transformed(const Aabb<S>& box_B, const Transform<S>& X_AB) {
  const Mat3<S> R = X_AB.rotation_matrix();
  const Vec3<S> center = R * box_B.center() + X_AB.translation;
  const Vec3<S> half = R.cwiseAbs() * box_B.half_extents();
  return {center - half, center + half};
}

}  // namespace bristle::inline BRISTLE_ABI
