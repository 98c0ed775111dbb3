/// @file
/// Joints between two bodies, and the rows they become.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/body.hpp>
#include <bristle/dynamics/solver_types.hpp>
#include <bristle/math/rotation.hpp>

namespace bristle {

struct JointTag;
/// Names a joint of a world.
using JointId = Id<JointTag>;

/// What a joint leaves free.
enum class JointKind {
  /// Nothing.
  fixed,
  /// Sliding along the x axis of the joint frame.
  prismatic,
  /// Turning about the origin of the joint frame.
  ball
};

/// What drives the free axis of a joint.
enum class DriveMode {
  /// Nothing.
  none,
  /// The velocity target, as far as the force limit lets it.
  velocity,
  /// The position target, at up to the speed limit and as far as the force limit lets it.
  position
};

/// Drive of the free axis of a joint.
template <Scalar S>
struct JointDrive {
  /// [-] What is driven.
  DriveMode mode = DriveMode::none;
  /// [m/s] or [m] Velocity or position of the joint that is wanted.
  S target = S(0);
  /// [N] Largest force, >= 0.
  S max_force = S(0);
  /// [m/s] Largest speed of a position drive, > 0. It goes slower where it could not brake in time.
  S max_speed = infinity<S>;
};

/// [-] How many relative velocities a joint keeps at zero.
[[nodiscard]] constexpr std::uint32_t locked_rows(JointKind kind) {
  switch (kind) {
    case JointKind::fixed:
      break;
    case JointKind::prismatic:
      return 5;
    case JointKind::ball:
      return 3;
  }
  return 6;
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
  /// [m] Pose of the joint frame in the body frame of B. The joint's position is the x coordinate
  /// of this frame's origin in A's joint frame.
  Transform<S> X_BJ{};
  /// [m] Smallest position of the free axis; -infinity for no stop.
  S lower_limit = -infinity<S>;
  /// [m] Largest position of the free axis; infinity for no stop.
  S upper_limit = infinity<S>;
  /// [-] What drives the free axis.
  JointDrive<S> drive{};
  /// [-] Whether the two bodies still touch each other.
  bool bodies_collide = false;
};

/// What a joint did in the last step.
template <Scalar S>
struct JointReading {
  /// [m] Position of the free axis at the end of the step; 0 for a joint that does not slide.
  S position = S(0);
  /// [m/s] Its velocity.
  S velocity = S(0);
  /// [N] Force of the drive on B along the axis.
  S drive_force = S(0);
  /// [N, N m] Wrench of the whole joint on B about B's joint frame's origin, world axes.
  Wrench<S> reaction{};
};

/// A joint of a world.
template <Scalar S>
struct Joint {
  JointDef<S> def{};
  /// Frames about the centres of mass.
  Transform<S> X_CmA_J{};
  Transform<S> X_CmB_J{};
  /// [N s, N m s] Impulses of the last step, for warm start: three to six locked axes, then drive,
  /// lower and upper stop.
  std::array<S, 9> impulses{};
  /// [N s, N m s] All of them on B about B's joint origin, world axes of the step they acted in.
  Wrench<S> total{};
  /// [-] First of this step's blocks, and how many.
  std::uint32_t first_block = 0;
  std::uint32_t block_count = 0;
};

/// @throws InvalidArgument naming the field.
template <Scalar S>
void validate(const JointDrive<S>& drive) {
  detail::require_finite("JointDrive::target", drive.target);
  detail::require_not_negative("JointDrive::max_force", drive.max_force);
  detail::require(drive.max_speed > S(0), "JointDrive::max_speed", drive.max_speed, "must be > 0");
}

/// @throws InvalidArgument naming the field.
template <Scalar S>
void validate(const JointDef<S>& def) {
  detail::require_all_finite("JointDef::X_AJ.translation", def.X_AJ.translation);
  detail::require_all_finite("JointDef::X_BJ.translation", def.X_BJ.translation);
  detail::require_unit<S>("JointDef::X_AJ.rotation", def.X_AJ.rotation);
  detail::require_unit<S>("JointDef::X_BJ.rotation", def.X_BJ.rotation);
  detail::require(def.lower_limit <= def.upper_limit, "JointDef::lower_limit", def.lower_limit,
                  "must be <= upper_limit");
  validate(def.drive);
}

/// Adds a joint's rows for this step: locked axes as one equality block, then the drive, then the
/// stops.
template <Scalar S>
void add_joint_rows(Joint<S>& joint, std::uint32_t joint_slot, const Body<S>& a, const Body<S>& b,
                    S dt, Constraints<S>& out);

/// Turns the rows of the locked axes to where the bodies will be at the end of the step, for bodies
/// whose free motion obeys the joint: they then only answer to what else acts, and have no error.
/// @param motion_a, motion_b  [m/s, rad/s] Displacements of the free motion, divided by the step.
template <Scalar S>
void turn_joint_rows(const Joint<S>& joint, const Transform<S>& X_WA, const Transform<S>& X_WB,
                     const Twist<S>& motion_a, const Twist<S>& motion_b, S dt, Constraints<S>& out);

/// Keeps the impulses that the solver found.
template <Scalar S>
void store_joint_impulses(Joint<S>& joint, const Constraints<S>& constraints);

/// State of a joint from its bodies and the impulses of the last step.
template <Scalar S>
[[nodiscard]] JointReading<S> read_joint(const Joint<S>& joint, const Body<S>& a, const Body<S>& b,
                                         S dt);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// Where a joint stands: its frame on A in the world and the offset of B's frame from it.
template <Scalar S>
struct JointPose {
  Mat3<S> axes_W;        // Columns: axes of A's joint frame.
  Vec3<S> arm_a, arm_b;  // From each centre of mass to B's joint origin.
  Vec3<S> offset_J;      // Of B's origin from A's, in A's joint frame.
  Vec3<S> angle_J;       // Of B's axes from A's, as a rotation vector in A's joint frame.
};

template <Scalar S>
[[nodiscard]] JointPose<S> joint_pose(const Joint<S>& joint, const Transform<S>& X_WA,
                                      const Transform<S>& X_WB) {
  JointPose<S> pose;
  const Quat<S> R_WJa = X_WA.rotation * joint.X_CmA_J.rotation;
  const Quat<S> R_WJb = X_WB.rotation * joint.X_CmB_J.rotation;
  pose.axes_W = R_WJa.toRotationMatrix();
  pose.arm_b = X_WB.rotation * joint.X_CmB_J.translation;
  // Centres of mass are subtracted first, so nothing is lost far from the world's origin.
  pose.arm_a = (X_WB.translation - X_WA.translation) + pose.arm_b;
  const Vec3<S> offset_W = pose.arm_a - X_WA.rotation * joint.X_CmA_J.translation;
  pose.offset_J = pose.axes_W.transpose() * offset_W;
  pose.angle_J = log_rotation<S>(R_WJa.conjugate() * R_WJb);
  return pose;
}

/// [m/s] Speed of a position drive at a distance [m] from its target: as fast as it can still brake
/// with half of its force (the other half is for loads), and not beyond the target in this step.
template <Scalar S>
[[nodiscard]] S approach_speed(const JointDrive<S>& drive, S distance, S inverse_mass, S dt) {
  using std::abs;
  using std::min;
  using std::sqrt;
  const S braking = drive.max_force * inverse_mass / S(2);
  const S speed =
      min(min(abs(distance) / dt, drive.max_speed), sqrt(S(2) * braking * abs(distance)));
  return distance < S(0) ? -speed : speed;
}

/// Row along an axis of A's joint frame, or against it, at B's joint origin.
template <Scalar S>
[[nodiscard]] ConstraintRow<S> linear_row(const JointPose<S>& pose, int axis, S sign) {
  ConstraintRow<S> row;
  row.direction = sign * pose.axes_W.col(axis);
  row.angular_a = pose.arm_a.cross(row.direction);
  row.angular_b = pose.arm_b.cross(row.direction);
  row.error = sign * pose.offset_J[axis];
  return row;
}

/// Calls use(row) for each row that a joint keeps at zero, `locked_rows` in all.
template <Scalar S, typename Use>
void for_each_locked_row(JointKind kind, const JointPose<S>& pose, Use&& use) {
  for (int axis = kind == JointKind::prismatic ? 1 : 0; axis < 3; ++axis) {
    use(linear_row(pose, axis, S(1)));
  }
  if (kind == JointKind::ball) return;
  for (int axis = 0; axis < 3; ++axis) {
    ConstraintRow<S> row;
    row.angular_a = row.angular_b = pose.axes_W.col(axis);
    row.error = pose.angle_J[axis];
    use(row);
  }
}

inline constexpr std::size_t drive_impulse = 6;
inline constexpr std::size_t lower_impulse = 7;
inline constexpr std::size_t upper_impulse = 8;

}  // namespace detail

template <Scalar S>
void add_joint_rows(Joint<S>& joint, std::uint32_t joint_slot, const Body<S>& a, const Body<S>& b,
                    S dt, Constraints<S>& out) {
  using std::max;
  using std::min;
  const JointDef<S>& def = joint.def;
  const detail::JointPose<S> pose = detail::joint_pose(joint, a.center_pose, b.center_pose);
  joint.first_block = static_cast<std::uint32_t>(out.blocks.size());
  const auto open_block = [&](BlockKind kind) -> ConstraintBlock<S>& {
    ConstraintBlock<S> block;
    block.body_a = def.body_a.index;
    block.body_b = def.body_b.index;
    block.first = static_cast<std::uint32_t>(out.rows.size());
    block.kind = kind;
    block.joint = joint_slot;
    out.blocks.push_back(block);
    return out.blocks.back();
  };
  open_block(BlockKind::equality).count = locked_rows(def.kind);
  std::size_t k = 0;
  detail::for_each_locked_row(def.kind, pose, [&](ConstraintRow<S> row) {
    row.impulse = joint.impulses[k++];
    out.rows.push_back(row);
  });

  if (def.kind == JointKind::prismatic) {
    const S position = pose.offset_J.x();
    const auto axis_row = [&](BlockKind kind, S sign, S target, S lower, S upper,
                              std::size_t slot) -> ConstraintRow<S>& {
      ConstraintBlock<S>& block = open_block(kind);
      block.count = 1;
      block.lower = lower;
      block.upper = upper;
      ConstraintRow<S> row = detail::linear_row(pose, 0, sign);
      row.error = S(0);
      row.target = target;
      row.impulse = min(max(joint.impulses[slot], lower), upper);
      out.rows.push_back(row);
      return out.rows.back();
    };
    if (def.drive.mode != DriveMode::none) {
      const S limit = def.drive.max_force * dt;
      const S wanted = def.drive.mode == DriveMode::velocity
                           ? def.drive.target
                           : detail::approach_speed(def.drive, def.drive.target - position,
                                                    a.inverse_mass + b.inverse_mass, dt);
      axis_row(BlockKind::bounded, S(1), wanted, -limit, limit, detail::drive_impulse);
    }
    // Like a contact, a stop may be approached as fast as reaches it in this step; what is beyond
    // it comes back by the position correction, which leaves no speed behind.
    const auto stop = [&](S sign, S distance, std::size_t slot) {
      axis_row(BlockKind::stop, sign, -max(S(0), distance) / dt, S(0), infinity<S>, slot).error =
          distance;
    };
    if (def.lower_limit > -infinity<S>) {
      stop(S(1), position - def.lower_limit, detail::lower_impulse);
    }
    if (def.upper_limit < infinity<S>) {
      stop(S(-1), def.upper_limit - position, detail::upper_impulse);
    }
  }
  joint.block_count = static_cast<std::uint32_t>(out.blocks.size()) - joint.first_block;
}

template <Scalar S>
void turn_joint_rows(const Joint<S>& joint, const Transform<S>& X_WA, const Transform<S>& X_WB,
                     const Twist<S>& motion_a, const Twist<S>& motion_b, S dt,
                     Constraints<S>& out) {
  ConstraintRow<S>* out_row = &out.rows[out.blocks[joint.first_block].first];
  detail::for_each_locked_row(joint.def.kind, detail::joint_pose(joint, X_WA, X_WB),
                              [&](ConstraintRow<S> row) {
                                row.impulse = out_row->impulse;
                                row.error = -dt * row.velocity(motion_a, motion_b);
                                *out_row++ = row;
                              });
}

template <Scalar S>
void store_joint_impulses(Joint<S>& joint, const Constraints<S>& constraints) {
  joint.total = {};
  for (std::uint32_t i = joint.first_block; i < joint.first_block + joint.block_count; ++i) {
    const ConstraintBlock<S>& block = constraints.blocks[i];
    for (std::uint32_t r = block.first; r < block.first + block.count; ++r) {
      const ConstraintRow<S>& row = constraints.rows[r];
      const bool is_angular = row.direction.isZero(S(0));
      joint.total.force += row.impulse * row.direction;
      if (is_angular) joint.total.torque += row.impulse * row.angular_b;
    }
  }
  joint.impulses.fill(S(0));
  const ConstraintBlock<S>& locked = constraints.blocks[joint.first_block];
  for (std::uint32_t k = 0; k < locked.count; ++k) {
    joint.impulses[k] = constraints.rows[locked.first + k].impulse;
  }
  const JointDef<S>& def = joint.def;
  std::uint32_t block = joint.first_block + 1;
  const auto keep = [&](bool is_there, std::size_t slot) {
    if (is_there)
      joint.impulses[slot] = constraints.rows[constraints.blocks[block++].first].impulse;
  };
  if (def.kind == JointKind::prismatic) {
    keep(def.drive.mode != DriveMode::none, detail::drive_impulse);
    keep(def.lower_limit > -infinity<S>, detail::lower_impulse);
    keep(def.upper_limit < infinity<S>, detail::upper_impulse);
  }
}

template <Scalar S>
JointReading<S> read_joint(const Joint<S>& joint, const Body<S>& a, const Body<S>& b, S dt) {
  const detail::JointPose<S> pose = detail::joint_pose(joint, a.center_pose, b.center_pose);
  JointReading<S> reading;
  reading.reaction = (S(1) / dt) * joint.total;
  if (joint.def.kind == JointKind::prismatic) {
    reading.position = pose.offset_J.x();
    reading.velocity = pose.axes_W.col(0).dot(b.twist.at(pose.arm_b) - a.twist.at(pose.arm_a));
    reading.drive_force = joint.impulses[detail::drive_impulse] / dt;
  }
  return reading;
}

}  // namespace bristle
