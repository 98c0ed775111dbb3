/// @file
/// Joints between two bodies: what they leave free, what acts on it, what they report.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/math/spatial.hpp>

#include <array>
#include <cstdint>
#include <string>

namespace bristle::inline BRISTLE_ABI {

struct JointTag;
/// Names a joint of a world.
using JointId = Id<JointTag>;

/// What a joint leaves free.
enum class JointKind {
  /// Nothing.
  fixed,
  /// Turning about the x axis of the joint frame.
  revolute,
  /// Sliding along the x axis of the joint frame.
  prismatic,
  /// Turning about the origin of the joint frame.
  ball,
  /// The same within a cone and a range of twist.
  cone_twist,
  /// Everything; springs and dampers pull the two joint frames together.
  six_dof
};

/// What drives the free axis of a joint.
enum class DriveMode {
  /// Nothing.
  none,
  /// The velocity target, as far as the force limit lets it.
  velocity,
  /// The position target, at up to the speed limit and as far as the force limit lets it.
  position,
  /// The position target by a spring and a damper (a PD controller), within the force limit.
  spring
};

/// Drive of the free axis of a joint; without one it does nothing.
template <Scalar S>
struct JointDrive {
  /// [-] What is driven.
  DriveMode mode = DriveMode::none;
  /// [m/s] or [m] Velocity or position of the joint that is wanted; rad for one that turns.
  S target = S(0);
  /// [N] Largest force, >= 0; [N m] torque for one that turns.
  S max_force = S(0);
  /// [m/s] Largest speed of a position drive, > 0; rad/s for one that turns. It goes slower where
  /// it could not brake in time.
  S max_speed = infinity<S>;
  /// [N/m], [N s/m] Gains of a spring drive, >= 0: force per distance from the target and per
  /// velocity, both at the end of the step, so that any gains are stable; N m/rad, N m s/rad for
  /// one that turns.
  S stiffness = S(0);
  S damping = S(0);
};

/// Spring and damper on the free axis of a joint, always on. Stable for any constants and step.
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
/// joint frame; without force where the frames coincide.
template <Scalar S>
struct JointBushing {
  /// [N/m; N m/rad] Along x, y, z, then about x, y, z, each >= 0. Turns count as one rotation
  /// vector.
  Vec6<S> stiffness = Vec6<S>::Zero();
  /// [N s/m; N m s/rad] The same per velocity.
  Vec6<S> damping = Vec6<S>::Zero();
};

/// [-] How many relative velocities a joint keeps at zero.
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

/// Name of a kind as it stands in messages ("cone_twist").
[[nodiscard]] constexpr const char* name_of(JointKind kind) {
  constexpr const char* names[] = {"fixed", "revolute",   "prismatic",
                                   "ball",  "cone_twist", "six_dof"};
  return names[static_cast<std::size_t>(kind)];
}

/// Whether a joint has one free axis, for drives and springs.
[[nodiscard]] constexpr bool has_free_axis(JointKind kind) {
  return kind == JointKind::revolute || kind == JointKind::prismatic;
}
/// Whether its position is an angle about the x axis of the joint frame.
[[nodiscard]] constexpr bool has_angle(JointKind kind) {
  return kind == JointKind::revolute || kind == JointKind::cone_twist;
}

/// Describes a joint to `World::add_joint`.
template <Scalar S>
struct JointDef {
  /// [-] What it leaves free.
  JointKind kind = JointKind::fixed;
  /// [-] Body A. At least one of the two must be dynamic.
  BodyId body_a{};
  /// [-] Body B, another than A.
  BodyId body_b{};
  /// [m] Pose of the joint frame in the body frame of A.
  Transform<S> X_AJ{};
  /// [m] Pose of the joint frame in the body frame of B. The position of a slide is the x
  /// coordinate of this frame's origin in A's joint frame; that of a joint that turns is the angle
  /// about x from A's frame to this one, whole turns counted. It starts within half a turn of zero,
  /// or at the turn nearest to the limits where they leave that out.
  /// Frames that do not meet when the joint is made are brought together as a position error is,
  /// mostly within a step, however far apart they are: place the bodies first.
  Transform<S> X_BJ{};
  /// [m] Smallest position of the free axis; -infinity for no stop. [rad] for a joint that turns,
  /// also below -pi; the twist about x of a `cone_twist`.
  S lower_limit = -infinity<S>;
  /// [m] Largest position of the free axis; infinity for no stop. [rad] for a joint that turns.
  S upper_limit = infinity<S>;
  /// [rad] Largest angle between the x axes of the two frames of a `cone_twist`, > 0; no stop from
  /// pi on.
  S swing_limit = infinity<S>;
  /// [-] What drives the free axis of a `revolute` or `prismatic` joint.
  JointDrive<S> drive{};
  /// [-] Passive spring and damper on the free axis of a `revolute` or `prismatic` joint.
  JointSpring<S> spring{};
  /// [-] Springs and dampers of a `six_dof` joint.
  JointBushing<S> bushing{};
  /// [-] Whether the two bodies still touch each other.
  bool bodies_collide = false;
};

/// What a joint did in the last step.
template <Scalar S>
struct JointReading {
  /// [m] Position of the free axis at the end of the step, 0 for a joint without one; [rad] angle
  /// of a `revolute` and twist of a `cone_twist` joint, whole turns counted.
  S position = S(0);
  /// [m/s] Its velocity; rad/s for a joint that turns.
  S velocity = S(0);
  /// [rad] Angle between the x axes of the two frames of a `cone_twist`.
  S swing = S(0);
  /// [N] Force of the drive on B along the axis; [N m] torque about it.
  S drive_force = S(0);
  /// [N, N m] Wrench of the whole joint on B about B's joint frame's origin, world axes.
  Wrench<S> reaction{};
  /// [m] How far the origins of the two frames are from each other, and [rad] how far their axes are
  /// turned, where the joint allows neither, limits apart. More than round-off is left before the
  /// first step, where a loop cannot be closed, where a step could not close it, and where the axes
  /// of a hinge are opposite to each other, from where no way is the shortest.
  S gap = S(0);
  S tilt = S(0);
};

/// A joint of a world.
template <Scalar S>
struct Joint {
  JointDef<S> def{};
  /// Frames about the centres of mass.
  Transform<S> X_CmA_J{};
  Transform<S> X_CmB_J{};
  /// [rad] Angle of a joint that has one, at the end of the last step: it tells whole turns apart.
  S angle = S(0);
  /// [N s, N m s] Impulses of the last step, for warm start: up to six locked axes, then drive,
  /// lower and upper stop, cone.
  std::array<S, 10> impulses{};
  /// [N s, N m s] The same of springs, on B about B's joint origin, world axes.
  Wrench<S> spring_impulse{};
  /// [N s, N m s] All of them on B about B's joint origin, world axes of the step they acted in.
  Wrench<S> total{};
  /// [-] First of this step's blocks, and how many.
  std::uint32_t first_block = 0;
  std::uint32_t block_count = 0;
  /// [-] This step's soft block, whether there is one, and whether a step is short for its spring:
  /// not more than a radian of its oscillation.
  std::uint32_t soft_block = 0;
  bool is_sprung = false;
  bool is_resolved = false;
};

/// @throws InvalidArgument naming the field, or where a joint of this kind has nothing to drive.
template <Scalar S>
void validate(const JointDrive<S>& drive, JointKind kind) {
  detail::require_finite("JointDrive::target", drive.target);
  using std::isfinite;
  // Only a bound, which may be the largest number there is.
  detail::require(isfinite(drive.max_force) && drive.max_force >= S(0), "JointDrive::max_force",
                  drive.max_force, "must be finite and >= 0");
  detail::require(drive.max_speed > S(0), "JointDrive::max_speed", drive.max_speed, "must be > 0");
  detail::require_not_negative("JointDrive::stiffness", drive.stiffness);
  detail::require_not_negative("JointDrive::damping", drive.damping);
  detail::require(has_free_axis(kind) || drive.mode == DriveMode::none, "JointDef::drive",
                  name_of(kind), "needs a revolute or prismatic joint");
}

/// @throws InvalidArgument naming the field.
template <Scalar S>
void validate(const JointSpring<S>& spring) {
  detail::require_not_negative("JointSpring::stiffness", spring.stiffness);
  detail::require_not_negative("JointSpring::damping", spring.damping);
  detail::require_finite("JointSpring::rest", spring.rest);
}

/// @throws InvalidArgument naming the field.
template <Scalar S>
void validate(const JointBushing<S>& bushing) {
  for (Eigen::Index i = 0; i < 6; ++i) {
    const std::string index = "[" + std::to_string(i) + "]";
    detail::require_not_negative("JointBushing::stiffness" + index, bushing.stiffness[i]);
    detail::require_not_negative("JointBushing::damping" + index, bushing.damping[i]);
  }
}

/// @throws InvalidArgument naming the field.
template <Scalar S>
void validate(const JointDef<S>& def) {
  const JointKind kind = def.kind;
  detail::require_all_finite("JointDef::X_AJ.translation", def.X_AJ.translation);
  detail::require_all_finite("JointDef::X_BJ.translation", def.X_BJ.translation);
  detail::require_unit<S>("JointDef::X_AJ.rotation", def.X_AJ.rotation);
  detail::require_unit<S>("JointDef::X_BJ.rotation", def.X_BJ.rotation);
  detail::require(def.lower_limit <= def.upper_limit, "JointDef::lower_limit", def.lower_limit,
                  "must be <= upper_limit");
  detail::require(def.lower_limit < infinity<S>, "JointDef::lower_limit", def.lower_limit,
                  "must be < infinity");
  detail::require(def.upper_limit > -infinity<S>, "JointDef::upper_limit", def.upper_limit,
                  "must be > -infinity");
  const bool has_position = has_free_axis(kind) || has_angle(kind);
  detail::require(has_position || def.lower_limit == -infinity<S>, "JointDef::lower_limit",
                  def.lower_limit, "needs a revolute, prismatic or cone_twist joint");
  detail::require(has_position || def.upper_limit == infinity<S>, "JointDef::upper_limit",
                  def.upper_limit, "needs a revolute, prismatic or cone_twist joint");
  detail::require(def.swing_limit > S(0), "JointDef::swing_limit", def.swing_limit, "must be > 0");
  detail::require(kind == JointKind::cone_twist || def.swing_limit == infinity<S>,
                  "JointDef::swing_limit", def.swing_limit, "needs a cone_twist joint");
  validate(def.drive, kind);
  validate(def.spring);
  detail::require(
      has_free_axis(kind) || (def.spring.stiffness == S(0) && def.spring.damping == S(0)),
      "JointDef::spring", def.spring.stiffness, "needs a revolute or prismatic joint");
  validate(def.bushing);
  detail::require(kind == JointKind::six_dof ||
                      (def.bushing.stiffness.isZero(S(0)) && def.bushing.damping.isZero(S(0))),
                  "JointDef::bushing", def.bushing.stiffness.maxCoeff(), "needs a six_dof joint");
}

}  // namespace bristle::inline BRISTLE_ABI
