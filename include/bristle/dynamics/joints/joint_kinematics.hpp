/// @file
/// Equations of a joint for the positions, velocities and accelerations of its two bodies.
///
/// Bodies are at x with axes R, velocity v of the centre of mass and angular velocity w, all in the
/// world. B's joint origin is P = x_B + r_B, A's is Q = x_A + r_A. A joint keeps c = P - Q at zero
/// along axes d of A. These are all three or, where B slides, the two across the slide. Where it
/// allows no rotation, it keeps the rotation of B's axes from A's at zero too. As r' = w x r,
///
///   u = (v_B + w_B x r_B) - (v_A + w_A x r_A)                                          = J v
///
/// is the rate of c. Where B slides, r_A ends at P instead of Q and so slides along. Its rate is
/// P' - v_A = u + w_A x r_A. Then u is the rate of c as seen from A. The rest of the rate of c,
/// w_A x c, is the rotation of A's axes. So (d . c)' = d . (u + w_A x c) + (w_A x d) . c = d . u.
///
/// The second derivative uses (w_A x d) . u = -d . (w_A x u). The slide of the arm gives another
/// such term:
///
///   (d . u)' = d . [ (v_B' + w_B' x r_B) - (v_A' + w_A' x r_A)                         = J v'
///                    + w_B x (w_B x r_B) - w_A x (w_A x r_A) - 2 w_A x u ],            = J' v
///
/// These are the centripetal accelerations of both arms and the Coriolis acceleration of the slide.
/// Where all of u is kept at zero, the last term is zero too. It is used there all the same. It
/// belongs to the acceleration of c in the axes of A. One formula then serves all joints. The
/// relative velocity w_B - w_A has no such terms where it is kept at zero altogether. Where B turns
/// about the axis h of A, w_B - w_A is kept at zero across h. In the axes of A again:
///
///   (d . (w_B - w_A))' = d . [ w_B' - w_A' - w_A x (w_B - w_A) ].
///
/// Rows are kept in world axes. Three locked rows mean the same in any axes. Where B slides along
/// d, or turns about it, I - d d^T removes the part along d.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/spatial.hpp>

#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// A joint of a mechanism, between two of its bodies.
template <Scalar S>
struct MechanismJoint {
  /// [-] Degrees of freedom that it leaves free.
  JointKind kind = JointKind::fixed;
  /// [-] Its bodies, by index in the mechanism.
  std::uint32_t body_a = 0;
  std::uint32_t body_b = 0;
  /// [m] Joint frames about the centres of mass, along the bodies' axes.
  Transform<S> X_CmA_J{};
  Transform<S> X_CmB_J{};
  /// [-] Spring and damper on its free axis, if it has one.
  JointSpring<S> spring{};
  /// [rad] Angle at the start of the step, to within half a turn, for a hinge with a spring.
  S angle = S(0);

  [[nodiscard]] bool has_spring() const { return spring.stiffness > S(0) || spring.damping > S(0); }
};

/// Pose and velocity of a body at one instant. It is the part of a `MechanismBody` that an
/// integrator changes. Its matrix of axes is stored, as each joint of the body reads it.
template <Scalar S>
struct BodyState {
  /// [m] Centre of mass.
  Vec3<S> x = zero<Vec3<S>>();
  /// [1] Axes of the body.
  Quat<S> q = Quat<S>::Identity();
  Mat3<S> R = identity<Mat3<S>>();
  /// [m/s, rad/s] Velocity of the centre of mass and angular velocity.
  Twist<S> twist{};

  /// Sets the axes from a quaternion of any length but zero.
  void set_axes(const Quat<S>& rotation);
};

/// The geometry of a joint at one instant, world axes.
template <Scalar S>
struct JointState {
  /// [m] Arms from the centres of mass to the joint origins. That of A ends at B's origin where B
  /// slides. It does so, too, where other joints connect the two bodies.
  Vec3<S> arm_a = zero<Vec3<S>>();
  Vec3<S> arm_b = zero<Vec3<S>>();
  /// [1] Axis along which B slides; zero if it does not.
  Vec3<S> slide = zero<Vec3<S>>();
  /// [1] Axis about which B turns. It is zero if B does not turn, or turns about any axis.
  Vec3<S> hinge = zero<Vec3<S>>();
};

/// Returns whether a joint of this kind allows relative translation, rotation about one axis, or
/// rotation about all axes.
[[nodiscard]] constexpr bool lets_slide(JointKind kind) { return kind == JointKind::prismatic; }
[[nodiscard]] constexpr bool lets_hinge(JointKind kind) { return kind == JointKind::revolute; }
[[nodiscard]] constexpr bool lets_turn(JointKind kind) {
  return kind == JointKind::ball || kind == JointKind::cone_twist;
}

/// A vector without its part along the unit vector d.
template <Scalar S>
[[nodiscard]] Vec3<S> across(const Vec3<S>& d, const Vec3<S>& u) {
  return u - d.dot(u) * d;
}

/// Finds the geometry of a joint from the states of its bodies.
template <Scalar S>
[[nodiscard]] JointState<S> joint_state(const MechanismJoint<S>& joint, const BodyState<S>& a,
                                        const BodyState<S>& b);

/// J v: the relative velocity that the joint keeps at zero. Also used for J times accelerations.
template <Scalar S>
[[nodiscard]] Twist<S> constraint_velocity(JointKind kind, const JointState<S>& at,
                                           const Twist<S>& a, const Twist<S>& b);

/// [m/s^2, rad/s^2] J' v.
template <Scalar S>
[[nodiscard]] Twist<S> constraint_acceleration_bias(JointKind kind, const JointState<S>& at,
                                                    const Twist<S>& a, const Twist<S>& b);

/// [m, rad] Offset of the bodies from where the joint holds them.
template <Scalar S>
[[nodiscard]] Twist<S> constraint_error(const MechanismJoint<S>& joint, const JointState<S>& at,
                                        const BodyState<S>& a, const BodyState<S>& b);

/// [m or rad] Position along or about the free axis.
/// @param guess  [rad] Angle of a hinge to within half a turn.
template <Scalar S>
[[nodiscard]] S axis_position(const MechanismJoint<S>& joint, const JointState<S>& at,
                              const BodyState<S>& a, const BodyState<S>& b, S guess);

/// [m/s or rad/s] Rate of `axis_position`.
template <Scalar S>
[[nodiscard]] S axis_rate(const JointState<S>& at, const Twist<S>& a, const Twist<S>& b);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void BodyState<S>::set_axes(const Quat<S>& rotation) {
  q = rotation;
  // Divided by the squared length, which needs no root. Quaternions do not have length one within a
  // Runge-Kutta step.
  const S k = S(2) / q.squaredNorm();
  const S x2 = k * q.x(), y2 = k * q.y(), z2 = k * q.z();
  const S wx = x2 * q.w(), wy = y2 * q.w(), wz = z2 * q.w();
  const S xx = x2 * q.x(), xy = y2 * q.x(), xz = z2 * q.x();
  const S yy = y2 * q.y(), yz = z2 * q.y(), zz = z2 * q.z();
  R(0, 0) = S(1) - (yy + zz);
  R(0, 1) = xy - wz;
  R(0, 2) = xz + wy;
  R(1, 0) = xy + wz;
  R(1, 1) = S(1) - (xx + zz);
  R(1, 2) = yz - wx;
  R(2, 0) = xz - wy;
  R(2, 1) = yz + wx;
  R(2, 2) = S(1) - (xx + yy);
}

template <Scalar S>
JointState<S> joint_state(const MechanismJoint<S>& joint, const BodyState<S>& a,
                          const BodyState<S>& b) {
  JointState<S> at;
  at.arm_b = b.R * joint.X_CmB_J.translation;
  if (lets_slide(joint.kind)) {
    at.arm_a = (b.x - a.x) + at.arm_b;
    at.slide = a.R * (joint.X_CmA_J.rotation * unit_x<Vec3<S>>());
  } else {
    at.arm_a = a.R * joint.X_CmA_J.translation;
  }
  if (lets_hinge(joint.kind)) at.hinge = a.R * (joint.X_CmA_J.rotation * unit_x<Vec3<S>>());
  return at;
}

template <Scalar S>
Twist<S> constraint_velocity(JointKind kind, const JointState<S>& at, const Twist<S>& a,
                             const Twist<S>& b) {
  const Vec3<S> u = (b.linear - a.linear) + b.angular.cross(at.arm_b) - a.angular.cross(at.arm_a);
  if (lets_turn(kind)) return {u, zero<Vec3<S>>()};
  const Vec3<S> w = b.angular - a.angular;
  return {lets_slide(kind) ? across(at.slide, u) : u, lets_hinge(kind) ? across(at.hinge, w) : w};
}

template <Scalar S>
Twist<S> constraint_acceleration_bias(JointKind kind, const JointState<S>& at, const Twist<S>& a,
                                      const Twist<S>& b) {
  const Vec3<S> turn_a = a.angular.cross(at.arm_a);
  const Vec3<S> turn_b = b.angular.cross(at.arm_b);
  const Vec3<S> u = (b.linear - a.linear) + turn_b - turn_a;
  const Vec3<S> bias = b.angular.cross(turn_b) - a.angular.cross(turn_a + S(2) * u);
  if (lets_slide(kind)) return {across(at.slide, bias), zero<Vec3<S>>()};
  if (!lets_hinge(kind)) return {bias, zero<Vec3<S>>()};
  return {bias, across(at.hinge, Vec3<S>(b.angular.cross(a.angular)))};
}

template <Scalar S>
Twist<S> constraint_error(const MechanismJoint<S>& joint, const JointState<S>& at,
                          const BodyState<S>& a, const BodyState<S>& b) {
  // Centres of mass are subtracted first. So no digits are lost far from the world's origin.
  const Vec3<S> c = (b.x - a.x) + (at.arm_b - a.R * joint.X_CmA_J.translation);
  if (lets_turn(joint.kind)) return {c, zero<Vec3<S>>()};
  if (lets_hinge(joint.kind)) {
    const Vec3<S> axis_b = b.R * (joint.X_CmB_J.rotation * unit_x<Vec3<S>>());
    return {c, shortest_turn<S>(at.hinge, axis_b)};
  }
  const Quat<S> turn = (b.q * joint.X_CmB_J.rotation) * (a.q * joint.X_CmA_J.rotation).conjugate();
  return {lets_slide(joint.kind) ? across(at.slide, c) : c, log_rotation<S>(turn)};
}

template <Scalar S>
S axis_position(const MechanismJoint<S>& joint, const JointState<S>& at, const BodyState<S>& a,
                const BodyState<S>& b, S guess) {
  using std::atan2;
  if (lets_hinge(joint.kind)) {
    const Quat<S> turn_J =
        (a.q * joint.X_CmA_J.rotation).conjugate() * (b.q * joint.X_CmB_J.rotation);
    return nearest_turn(S(2) * atan2(turn_J.x(), turn_J.w()), guess);
  }
  return at.slide.dot((b.x - a.x) + (at.arm_b - a.R * joint.X_CmA_J.translation));
}

template <Scalar S>
S axis_rate(const JointState<S>& at, const Twist<S>& a, const Twist<S>& b) {
  // One of the two axes is zero.
  return at.slide.dot(b.at(at.arm_b) - a.at(at.arm_a)) + at.hinge.dot(b.angular - a.angular);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
