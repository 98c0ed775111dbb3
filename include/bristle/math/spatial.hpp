/// @file
/// Twists and wrenches: six-dimensional velocity and force about a point.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Velocity of a rigid body about a reference point, both parts in the same frame.
template <Scalar S>
struct Twist {
  /// [m/s] Velocity of the reference point.
  Vec3<S> linear = Vec3<S>::Zero();
  /// [rad/s] Angular velocity.
  Vec3<S> angular = Vec3<S>::Zero();

  /// [m/s] Velocity of the body's point at `r` [m] from the reference point.
  [[nodiscard]] Vec3<S> at(const Vec3<S>& r) const { return linear + angular.cross(r); }

  /// The same motion about the point at `r` [m] from the reference point.
  [[nodiscard]] Twist shifted(const Vec3<S>& r) const { return {at(r), angular}; }

  friend Twist operator-(const Twist& a, const Twist& b) {
    return {a.linear - b.linear, a.angular - b.angular};
  }
  friend Twist operator+(const Twist& a, const Twist& b) {
    return {a.linear + b.linear, a.angular + b.angular};
  }
  friend Twist operator*(S k, const Twist& a) { return {k * a.linear, k * a.angular}; }
};

/// Force and torque about a reference point. Also used for impulses [N s, N m s].
template <Scalar S>
struct Wrench {
  /// [N] Force.
  Vec3<S> force = Vec3<S>::Zero();
  /// [N m] Torque about the reference point.
  Vec3<S> torque = Vec3<S>::Zero();

  /// Wrench of a force `f` that acts at `r` [m] from the reference point.
  [[nodiscard]] static Wrench at(const Vec3<S>& r, const Vec3<S>& f) { return {f, r.cross(f)}; }

  /// The same load about the point at `r` [m] from the reference point.
  [[nodiscard]] Wrench shifted(const Vec3<S>& r) const { return {force, torque - r.cross(force)}; }

  /// Adds a load about the same reference point.
  Wrench& operator+=(const Wrench& other) {
    force += other.force;
    torque += other.torque;
    return *this;
  }
  friend Wrench operator+(Wrench a, const Wrench& b) { return a += b; }
  friend Wrench operator-(const Wrench& a) { return {-a.force, -a.torque}; }
  friend Wrench operator*(S k, const Wrench& a) { return {k * a.force, k * a.torque}; }
};

/// The matrix of `Twist::shifted(r)`; its transpose is that of `Wrench::shifted(-r)`.
template <Scalar S>
[[nodiscard]] Mat6<S> shift_matrix(const Vec3<S>& r) {
  Mat6<S> G = Mat6<S>::Identity();
  G.template topRightCorner<3, 3>() = -skew(r);
  return G;
}

}  // namespace bristle::inline BRISTLE_ABI
