/// @file
/// Joints between two bodies. They have free axes, limits, motors, springs and readings.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/math/spatial.hpp>

#include <array>
#include <cstdint>
#include <string>

namespace bristle::inline BRISTLE_ABI {

namespace detail {
struct JointTag;
}  // namespace detail
/// Handle of a joint of a world.
using JointId = detail::Id<detail::JointTag>;

/// Kind of a joint, by the degrees of freedom that it leaves free.
enum class JointKind {
  /// Nothing.
  fixed,
  /// Rotation about the x axis of the joint frame.
  revolute,
  /// Translation along the x axis of the joint frame.
  prismatic,
  /// Rotation about the origin of the joint frame.
  ball,
  /// Rotation about the origin, within a cone and a range of twist.
  cone_twist,
  /// All; springs and dampers pull the two joint frames together.
  six_dof
};

/// Control mode of a motor on the free axis of a joint.
enum class MotorMode {
  /// Nothing.
  none,
  /// Follows the velocity target, within the force limit.
  velocity,
  /// Goes to the position target. Speed and force have limits.
  position,
  /// Pulls to the position target by a spring and a damper (a PD controller), within the force
  /// limit.
  spring
};

/// Motor on the free axis of a joint. By default it does nothing.
template <Scalar S>
struct JointMotor {
  /// [-] Control mode.
  MotorMode mode = MotorMode::none;
  /// [m/s] or [m] Velocity or position target. It is in rad/s or rad for a joint that turns.
  S target = S(0);
  /// [N] Largest force, >= 0. [N m] Torque for a joint that turns.
  S max_force = S(0);
  /// [m/s] Largest speed in position mode, > 0. It is in rad/s for a joint that turns. The motor is
  /// slower where it could not brake in time.
  S max_speed = infinity<S>;
  /// [N/m] Gain in spring mode, >= 0: force per distance from the target. The distance is that at
  /// the end of the step. So any gain is stable. N m/rad for a joint that turns.
  S stiffness = S(0);
  /// [N s/m] Gain in spring mode, >= 0: force per velocity. The velocity is that at the end of the
  /// step. So any gain is stable. N m s/rad for a joint that turns.
  S damping = S(0);
};

/// Passive spring and damper on the free axis of a joint. Stable for any constants and step.
template <Scalar S>
struct JointSpring {
  /// [N/m] Force per displacement from rest, >= 0; N m/rad for a joint that turns.
  S stiffness = S(0);
  /// [N s/m] Force per velocity, >= 0; N m s/rad for a joint that turns.
  S damping = S(0);
  /// [m] Position without force; rad for a joint that turns.
  S rest = S(0);
};

/// Springs and dampers of a `six_dof` joint between its two frames, along and about the axes of A's
/// joint frame. No force acts where the frames coincide.
template <Scalar S>
struct JointBushing {
  /// [N/m; N m/rad] Along x, y, z, then about x, y, z, each >= 0. Rotation counts as one rotation
  /// vector.
  Vec6<S> stiffness = detail::zero<Vec6<S>>();
  /// [N s/m; N m s/rad] The same per velocity.
  Vec6<S> damping = detail::zero<Vec6<S>>();
};

/// [-] Number of relative velocities that a joint keeps at zero.
[[nodiscard]] constexpr std::uint32_t locked_rows(JointKind kind) {
  switch (kind) {
    case JointKind::fixed:
      break;
    case JointKind::revolute:
    case JointKind::prismatic:
      return 5;
    case JointKind::ball:
    case JointKind::cone_twist:
      return 3;
    case JointKind::six_dof:
      return 0;
  }
  return 6;
}

/// Name of a kind in messages ("cone_twist").
[[nodiscard]] constexpr const char* name_of(JointKind kind) {
  constexpr const char* names[] = {"fixed", "revolute",   "prismatic",
                                   "ball",  "cone_twist", "six_dof"};
  return names[static_cast<std::size_t>(kind)];
}

/// Returns whether a joint has one free axis. Motors and springs need it.
[[nodiscard]] constexpr bool has_free_axis(JointKind kind) {
  return kind == JointKind::revolute || kind == JointKind::prismatic;
}
/// Returns whether its position is an angle. That is about the x axis of the joint frame.
[[nodiscard]] constexpr bool has_angle(JointKind kind) {
  return kind == JointKind::revolute || kind == JointKind::cone_twist;
}

/// Definition of a joint, for `World::add_joint`.
template <Scalar S>
struct JointDef {
  /// [-] Degrees of freedom that it leaves free.
  JointKind kind = JointKind::fixed;
  /// [-] Body A; unset: the world (`World::ground`), and `X_AJ` is the joint frame in the world. At
  /// least one of the two must be dynamic.
  BodyId body_a{};
  /// [-] Body B, different from A; unset: the world.
  BodyId body_b{};
  /// [m] Pose of the joint frame in the body frame of A.
  Transform<S> X_AJ{};
  /// [m] Pose of the joint frame in the body frame of B. The position of a slide is the x
  /// coordinate of this frame's origin in A's joint frame. The position of a joint that turns is
  /// the angle about x from A's frame to this one. It counts whole turns. It starts within half a
  /// turn of zero. If the limits exclude that, it starts at the turn nearest to them. Frames that
  /// do not match at the start are brought together like a position error. That mostly takes one
  /// step, however far apart they are. So place the bodies first.
  Transform<S> X_BJ{};
  /// [m] Smallest position of the free axis. It is -infinity for no limit. [rad] for a joint that
  /// turns, also below -pi. It is the twist about x for a `cone_twist`.
  S lower_limit = -infinity<S>;
  /// [m] Largest position of the free axis. It is infinity for no limit. [rad] for a joint that
  /// turns.
  S upper_limit = infinity<S>;
  /// [rad] Largest angle between the x axes of the two frames of a `cone_twist`, > 0. From pi on
  /// there is no limit.
  S swing_limit = infinity<S>;
  /// [-] Motor on the free axis of a `revolute` or `prismatic` joint.
  JointMotor<S> motor{};
  /// [-] Passive spring and damper on the free axis of a `revolute` or `prismatic` joint.
  JointSpring<S> spring{};
  /// [-] Springs and dampers of a `six_dof` joint.
  JointBushing<S> bushing{};
  /// [-] True if the two bodies collide with each other.
  bool bodies_collide = false;
  /// [-] A number of the caller's, such as an index (`World::user_data`).
  std::uint64_t user_data = 0;
};

/// State of a joint at the end of a step. Its forces in the step.
template <Scalar S>
struct JointReading {
  /// [m] Position of the free axis at the end of the step. It is 0 for a joint without one. [rad]
  /// angle of a `revolute` and twist of a `cone_twist` joint, with whole turns.
  S position = S(0);
  /// [m/s] Velocity of the free axis. It is in rad/s for a joint that turns.
  S velocity = S(0);
  /// [rad] Angle between the x axes of the two frames of a `cone_twist`.
  S swing = S(0);
  /// [N] Force of the motor on B along the axis. [N m] Torque about it.
  S motor_force = S(0);
  /// [N, N m] Wrench of the whole joint on B. It is about B's joint frame's origin, world axes.
  Wrench<S> reaction{};
  /// [m] Distance of the origins of the two frames, where the joint does not allow it. Limits do
  /// not count. More than round-off is left before the first step. It is also left in a loop that
  /// cannot be closed, and where a step could not close it.
  S gap = S(0);
  /// [rad] Angle between the axes of the two frames, where the joint does not allow it. Otherwise
  /// as `gap`. Opposite axes of a hinge stay so: no way back is the shortest.
  S tilt = S(0);
};

namespace detail {

/// A joint of a world.
template <Scalar S>
struct Joint {
  JointDef<S> def{};
  /// [m] Joint frames about the centres of mass.
  Transform<S> X_CmA_J{};
  Transform<S> X_CmB_J{};
  /// [rad] Angle of the joint at the end of the last step. Unused by a joint without an angle. It
  /// tells whole turns apart.
  S angle = S(0);
  /// [N s, N m s] Impulses of the last step, for the warm start. The order is up to six locked
  /// axes, motor, lower and upper limit, cone.
  std::array<S, 10> impulses{};
  /// [N s, N m s] Impulse of the springs on B. It is about B's joint origin, world axes.
  Wrench<S> spring_impulse{};
  /// [N s, N m s] Total impulse on B about B's joint origin. It is in world axes of the step it
  /// acted in.
  Wrench<S> total{};
  /// [-] First block of the joint in this step. Number of its blocks.
  std::uint32_t first_block = 0;
  std::uint32_t block_count = 0;
  /// [-] Soft block of the joint in this step. `is_sprung`: true if it has one. `is_resolved`: true
  /// if the step is at most a radian of the oscillation of its spring.
  std::uint32_t soft_block = 0;
  bool is_sprung = false;
  bool is_resolved = false;
};

}  // namespace detail

/// Checks a motor.
/// @throws InvalidArgument naming the field. Also thrown if a joint of this kind has no axis for a
///         motor.
template <Scalar S>
void validate(const JointMotor<S>& motor, JointKind kind) {
  detail::require_enumerator("JointMotor::mode", motor.mode, MotorMode::spring);
  detail::require_finite("JointMotor::target", motor.target);
  using std::isfinite;
  // A bound may be the largest number there is.
  detail::require(isfinite(motor.max_force) && motor.max_force >= S(0), "JointMotor::max_force",
                  motor.max_force, "must be finite and >= 0");
  detail::require(motor.max_speed > S(0), "JointMotor::max_speed", motor.max_speed, "must be > 0");
  detail::require_not_negative("JointMotor::stiffness", motor.stiffness);
  detail::require_not_negative("JointMotor::damping", motor.damping);
  detail::require(has_free_axis(kind) || motor.mode == MotorMode::none, "JointDef::motor",
                  name_of(kind), "needs a revolute or prismatic joint");
}

/// Checks a spring.
/// @throws InvalidArgument naming the field. Also thrown if a joint of this kind has no axis for a
///         spring.
template <Scalar S>
void validate(const JointSpring<S>& spring, JointKind kind) {
  detail::require_not_negative("JointSpring::stiffness", spring.stiffness);
  detail::require_not_negative("JointSpring::damping", spring.damping);
  detail::require_finite("JointSpring::rest", spring.rest);
  detail::require(has_free_axis(kind) || (spring.stiffness == S(0) && spring.damping == S(0)),
                  "JointDef::spring", name_of(kind), "needs a revolute or prismatic joint");
}

/// Checks a bushing.
/// @throws InvalidArgument naming the field.
template <Scalar S>
void validate(const JointBushing<S>& bushing) {
  for (Eigen::Index i = 0; i < 6; ++i) {
    const std::string index = "[" + std::to_string(i) + "]";
    detail::require_not_negative("JointBushing::stiffness" + index, bushing.stiffness[i]);
    detail::require_not_negative("JointBushing::damping" + index, bushing.damping[i]);
  }
}

namespace detail {

/// Checks the limits of a joint's position.
/// @throws InvalidArgument naming the field. Also thrown if a joint of this kind has no position.
template <Scalar S>
void require_limits(const S& lower, const S& upper, JointKind kind) {
  require(lower <= upper, "JointDef::lower_limit", lower, "must be <= upper_limit");
  require(lower < infinity<S>, "JointDef::lower_limit", lower, "must be < infinity");
  require(upper > -infinity<S>, "JointDef::upper_limit", upper, "must be > -infinity");
  const bool has_position = has_free_axis(kind) || has_angle(kind);
  constexpr const char* needs = "needs a revolute, prismatic or cone_twist joint";
  require(has_position || lower == -infinity<S>, "JointDef::lower_limit", lower, needs);
  require(has_position || upper == infinity<S>, "JointDef::upper_limit", upper, needs);
}

}  // namespace detail

/// Checks the definition of a joint.
/// @throws InvalidArgument naming the field.
template <Scalar S>
void validate(const JointDef<S>& def) {
  const JointKind kind = def.kind;
  detail::require_enumerator("JointDef::kind", kind, JointKind::six_dof);
  detail::require_all_finite("JointDef::X_AJ.translation", def.X_AJ.translation);
  detail::require_all_finite("JointDef::X_BJ.translation", def.X_BJ.translation);
  detail::require_unit<S>("JointDef::X_AJ.rotation", def.X_AJ.rotation);
  detail::require_unit<S>("JointDef::X_BJ.rotation", def.X_BJ.rotation);
  detail::require_limits(def.lower_limit, def.upper_limit, kind);
  detail::require(def.swing_limit > S(0), "JointDef::swing_limit", def.swing_limit, "must be > 0");
  detail::require(kind == JointKind::cone_twist || def.swing_limit == infinity<S>,
                  "JointDef::swing_limit", def.swing_limit, "needs a cone_twist joint");
  validate(def.motor, kind);
  validate(def.spring, kind);
  validate(def.bushing);
  detail::require(kind == JointKind::six_dof ||
                      (def.bushing.stiffness.isZero(S(0)) && def.bushing.damping.isZero(S(0))),
                  "JointDef::bushing", def.bushing.stiffness.maxCoeff(), "needs a six_dof joint");
}

}  // namespace bristle::inline BRISTLE_ABI
