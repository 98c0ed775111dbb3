/// @file
/// Relative pose of the two frames of a joint.
///
/// B's frame is turned from A's by q = swing * twist. The twist comes first, about the common x
/// axis. The swing follows, about an axis across it. The twist is 2 atan2(q_x, q_w). Let a and b be
/// the x axes of both frames, and w the angular velocity of B relative to A. The rate of the twist
/// is
/// (a + b) . w / (1 + a . b). The swing is the angle between a and b. Its rate is
/// w . (a x b) / |a x b|.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint.hpp>
#include <bristle/dynamics/solver/constraint.hpp>
#include <bristle/math/rotation.hpp>

#include <array>
#include <numbers>

namespace bristle::inline BRISTLE_ABI::detail {

/// Pose of a joint. It has its frame on A in the world and the offset of B's frame from it.
template <Scalar S>
struct JointPose {
  /// [1] Columns: axes of A's joint frame, in the world.
  Mat3<S> axes_W;
  /// [m] From each centre of mass to B's joint origin, world axes.
  Vec3<S> arm_a, arm_b;
  /// [m] Offset of B's origin from A's, in A's joint frame.
  Vec3<S> offset_J;
  /// [1] Rotation of B's axes from A's, in A's joint frame.
  Quat<S> turn_J;

  /// [1] x axis of B's joint frame, in A's.
  [[nodiscard]] Vec3<S> axis_b_J() const { return turn_J * unit_x<Vec3<S>>(); }
};

/// [rad] Angle between the x axes of both frames.
template <Scalar S>
[[nodiscard]] S joint_swing(const JointPose<S>& pose);

/// Finds the pose of a joint.
/// @param X_WA, X_WB  Centres of mass in the world, with the bodies' axes.
template <Scalar S>
[[nodiscard]] JointPose<S> joint_pose(const Joint<S>& joint, const Transform<S>& X_WA,
                                      const Transform<S>& X_WB);

/// [m or rad] Position of a joint along its slide, or its angle. It is 0 without either.
/// @param guess  [rad] Angle to within half a turn.
template <Scalar S>
[[nodiscard]] S joint_position(JointKind kind, const JointPose<S>& pose, S guess);

/// Row whose velocity is the rate of `joint_position`. Its error and impulse are zero.
template <Scalar S>
[[nodiscard]] ConstraintRow<S> position_row(JointKind kind, const JointPose<S>& pose);

/// [m or rad] Position at the end of a step. The velocities at both ends count whole turns.
/// @param pose  At the end of the step.
template <Scalar S>
[[nodiscard]] S tracked_position(const Joint<S>& joint, const JointPose<S>& pose,
                                 const std::array<Twist<S>, 2>& of_a,
                                 const std::array<Twist<S>, 2>& of_b, S dt);

/// Returns whether a joint is within all its limits.
template <Scalar S>
[[nodiscard]] bool is_within_limits(const JointDef<S>& def, const JointPose<S>& pose, S position);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
JointPose<S> joint_pose(const Joint<S>& joint, const Transform<S>& X_WA, const Transform<S>& X_WB) {
  JointPose<S> pose;
  const Quat<S> R_WJa = X_WA.rotation * joint.X_CmA_J.rotation;
  const Quat<S> R_WJb = X_WB.rotation * joint.X_CmB_J.rotation;
  pose.axes_W = rotation_matrix<S>(R_WJa);
  pose.arm_b = X_WB.rotation * joint.X_CmB_J.translation;
  // Centres of mass are subtracted first. So no digits are lost far from the world's origin.
  pose.arm_a = (X_WB.translation - X_WA.translation) + pose.arm_b;
  const Vec3<S> offset_W = pose.arm_a - X_WA.rotation * joint.X_CmA_J.translation;
  pose.offset_J = pose.axes_W.transpose() * offset_W;
  pose.turn_J = R_WJa.conjugate() * R_WJb;
  return pose;
}

template <Scalar S>
S joint_swing(const JointPose<S>& pose) {
  using std::atan2;
  using std::sqrt;
  // Unlike the length of the shortest rotation, it tells opposite axes from equal ones.
  const Vec3<S> b_J = pose.axis_b_J();
  return atan2(sqrt(b_J.y() * b_J.y() + b_J.z() * b_J.z()), b_J.x());
}

template <Scalar S>
S joint_position(JointKind kind, const JointPose<S>& pose, S guess) {
  using std::atan2;
  if (!has_angle(kind)) return kind == JointKind::prismatic ? pose.offset_J.x() : S(0);
  return nearest_turn(S(2) * atan2(pose.turn_J.x(), pose.turn_J.w()), guess);
}

/// Row along an axis of A's joint frame at B's joint origin.
template <Scalar S>
[[nodiscard]] ConstraintRow<S> linear_row(const JointPose<S>& pose, int axis) {
  ConstraintRow<S> row;
  row.direction = column_of(pose.axes_W, axis);
  row.angular_a = pose.arm_a.cross(row.direction);
  row.angular_b = pose.arm_b.cross(row.direction);
  return row;
}

template <Scalar S>
ConstraintRow<S> position_row(JointKind kind, const JointPose<S>& pose) {
  using std::max;
  ConstraintRow<S> row;
  switch (kind) {
    case JointKind::prismatic:
      return linear_row(pose, 0);
    case JointKind::revolute:
      row.angular_a = row.angular_b = column_of(pose.axes_W, 0);
      break;
    case JointKind::cone_twist: {
      const Vec3<S> b_J = pose.axis_b_J();
      // Where the axes are opposite, the twist has no rate. Any rotation may then be a twist.
      const S scale = S(1) / max(S(1) + b_J.x(), Tolerance<S>::equal());
      row.angular_a = row.angular_b = pose.axes_W * (scale * (b_J + unit_x<Vec3<S>>()));
      break;
    }
    case JointKind::fixed:
    case JointKind::ball:
    case JointKind::six_dof:
      break;
  }
  return row;
}

template <Scalar S>
S tracked_position(const Joint<S>& joint, const JointPose<S>& pose,
                   const std::array<Twist<S>, 2>& of_a, const std::array<Twist<S>, 2>& of_b, S dt) {
  const JointKind kind = joint.def.kind;
  if (!has_angle(kind)) return joint_position(kind, pose, S(0));
  const ConstraintRow<S> row = position_row(kind, pose);
  const S rate = S(0.5) * (row.velocity(of_a[0], of_b[0]) + row.velocity(of_a[1], of_b[1]));
  return joint_position(kind, pose, joint.angle + dt * rate);
}

template <Scalar S>
bool is_within_limits(const JointDef<S>& def, const JointPose<S>& pose, S position) {
  if (position < def.lower_limit || position > def.upper_limit) return false;
  if (def.swing_limit >= S(std::numbers::pi)) return true;
  return joint_swing(pose) <= def.swing_limit;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
