/// @file
/// Mass, centre of mass and inertia of a rigid body, and how they add up.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/transform.hpp>

namespace bristle {

/// What a rigid body weighs and how it resists turning, in one frame.
template <Scalar S>
struct MassProperties {
  /// [kg] Mass.
  S mass = S(0);
  /// [m] Centre of mass.
  Vec3<S> center = Vec3<S>::Zero();
  /// [kg m^2] Inertia about the centre of mass, along the frame's axes.
  Mat3<S> inertia = Mat3<S>::Zero();

  /// The same body with its mass multiplied by `factor` (a density, for unit-density properties).
  [[nodiscard]] MassProperties scaled(S factor) const {
    return {factor * mass, center, factor * inertia};
  }

  /// The same body seen from frame A, where its own frame has the pose `X_AB`.
  [[nodiscard]] MassProperties transformed(const Transform<S>& X_AB) const {
    const Mat3<S> R = X_AB.rotation_matrix();
    return {mass, X_AB * center, R * inertia * R.transpose()};
  }
};

/// Inertia of a point mass `m` [kg] at `r` [m]: what the parallel-axis theorem adds.
template <Scalar S>
[[nodiscard]] Mat3<S> point_inertia(S m, const Vec3<S>& r) {
  return m * (r.squaredNorm() * Mat3<S>::Identity() - r * r.transpose());
}

/// Two bodies welded together; either may have zero mass.
template <Scalar S>
[[nodiscard]] MassProperties<S> operator+(const MassProperties<S>& a, const MassProperties<S>& b) {
  const S mass = a.mass + b.mass;
  if (!(mass > S(0))) return {};
  const Vec3<S> center = (a.mass * a.center + b.mass * b.center) / mass;
  return {mass, center,
          a.inertia + b.inertia + point_inertia<S>(a.mass, a.center - center) +
              point_inertia<S>(b.mass, b.center - center)};
}

}  // namespace bristle
