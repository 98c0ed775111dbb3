/// @file
/// Converts joints of an AMBF description to joint definitions.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint.hpp>
#include <bristle/io/adf/adf_axis_turn.hpp>
#include <bristle/io/adf/adf_body_builder.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_scene.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>

namespace bristle::inline BRISTLE_ABI::detail {

/// Frames of a joint in its two bodies.
template <Scalar S>
struct JointFrames {
  Transform<S> X_AJ;
  Transform<S> X_BJ;
};

/// Axis of the joint's frame that is along its axis: the free one, x. Joints with limits or springs
/// about all three axes have them in the frame of the format, whose z is along the axis.
[[nodiscard]] inline Vec3<double> frame_axis(AdfJointType type) {
  const bool has_three = type == AdfJointType::cone_twist || type == AdfJointType::six_dof ||
                         type == AdfJointType::six_dof_spring;
  return has_three ? unit_z<Vec3<double>>() : unit_x<Vec3<double>>();
}

/// Returns the frames of a joint. At zero the child's axis is along the parent's, and the child is
/// turned by the offset about it.
template <Scalar S>
[[nodiscard]] JointFrames<S> joint_frames(const AdfJoint& joint, double parent_scale,
                                          double child_scale) {
  const auto about_axis = [&joint](double angle) {
    return Quat<double>(Eigen::AngleAxis<double>(angle, joint.parent_axis));
  };
  const Quat<double> R_AJ =
      about_axis(joint.frame_offset) * axis_turn(frame_axis(joint.type), joint.parent_axis);
  const Quat<double> R_AB =
      about_axis(joint.offset) * axis_turn(joint.child_axis, joint.parent_axis);
  const Quat<double> R_BJ = R_AB.conjugate() * R_AJ;
  return {scaled_pose<S>({R_AJ, joint.parent_pivot}, parent_scale),
          scaled_pose<S>({R_BJ, joint.child_pivot}, child_scale)};
}

/// Kind of joint for a type of the format.
[[nodiscard]] constexpr JointKind kind_of(AdfJointType type) {
  switch (type) {
    case AdfJointType::revolute:
    case AdfJointType::torsion_spring:
      return JointKind::revolute;
    case AdfJointType::prismatic:
    case AdfJointType::linear_spring:
      return JointKind::prismatic;
    case AdfJointType::point_to_point:
      return JointKind::ball;
    case AdfJointType::cone_twist:
      return JointKind::cone_twist;
    case AdfJointType::six_dof:
    case AdfJointType::six_dof_spring:
      return JointKind::six_dof;
    case AdfJointType::fixed:
      break;
  }
  return JointKind::fixed;
}

/// [m or rad] Position of a joint for bodies at these poses. Of equivalent angles it is the one
/// nearest to the limits.
template <Scalar S>
[[nodiscard]] S joint_position(const JointDef<S>& def, const Transform<S>& X_WA,
                               const Transform<S>& X_WB) {
  const Transform<S> X_JaJb = relative_pose(X_WA * def.X_AJ, X_WB * def.X_BJ);
  if (def.kind == JointKind::prismatic) return X_JaJb.translation.x();
  using std::atan2;
  const S turn = S(2.0 * std::numbers::pi);
  S angle = S(2) * atan2(X_JaJb.rotation.x(), X_JaJb.rotation.w());
  if (angle > turn / S(2)) angle -= turn;
  if (angle <= -turn / S(2)) angle += turn;
  const auto outside = [&](S x) {
    return std::max({def.lower_limit - x, x - def.upper_limit, S(0)});
  };
  for (const S other : {angle - turn, angle + turn}) {
    if (outside(other) < outside(angle)) angle = other;
  }
  return angle;
}

template <Scalar S>
class AdfJointBuilder {
 public:
  AdfJointBuilder(const AdfBuildDef<S>& def, AdfReport& report) : def_(def), report_(report) {}

  /// Returns a joint without the bodies that it joins, and free.
  [[nodiscard]] JointDef<S> joint(const AdfJoint& joint, double parent_scale, double child_scale) {
    JointDef<S> result;
    result.kind = kind_of(joint.type);
    const JointFrames<S> frames = joint_frames<S>(joint, parent_scale, child_scale);
    result.X_AJ = frames.X_AJ;
    result.X_BJ = frames.X_BJ;
    result.bodies_collide = !joint.ignore_inter_collision;
    if (has_free_axis(result.kind)) set_axis(joint, result);
    if (result.kind == JointKind::cone_twist) set_cone(joint, result);
    if (result.kind == JointKind::six_dof) {
      for (std::size_t i = 0; i < 6; ++i) {
        result.bushing.stiffness[static_cast<Eigen::Index>(i)] = S(joint.six_stiffness[i]);
        result.bushing.damping[static_cast<Eigen::Index>(i)] = S(joint.six_damping[i]);
      }
    }
    return result;
  }

  /// Adds what holds a joint where it stands. A controller acts like a spring and a damper, added
  /// to those of the joint. A motor acts like a brake.
  ///
  /// @param X_WA, X_WB  Poses of parent and child.
  void hold(const AdfJoint& joint, const Transform<S>& X_WA, const Transform<S>& X_WB,
            JointDef<S>& result) const {
    if (!def_.hold_joints || !has_free_axis(result.kind)) return;
    if (!joint.controller) {
      result.motor = {.mode = MotorMode::velocity,
                      .max_force = S(joint.max_motor_impulse) / def_.authored_step};
      return;
    }
    const S P = S(joint.controller->P);
    const S both = result.spring.stiffness + P;
    if (both > S(0)) {
      result.spring.rest =
          (result.spring.stiffness * result.spring.rest + P * joint_position(result, X_WA, X_WB)) /
          both;
    }
    result.spring.stiffness = both;
    result.spring.damping += S(joint.controller->D);
  }

 private:
  static void set_axis(const AdfJoint& joint, JointDef<S>& result) {
    if (joint.limits) {
      result.lower_limit = S(joint.limits->low);
      result.upper_limit = S(joint.limits->high);
    }
    // The rest position of a spring that is none says nothing.
    if (joint.stiffness == 0 && joint.damping == 0) return;
    result.spring = {
        .stiffness = S(joint.stiffness), .damping = S(joint.damping), .rest = S(joint.equilibrium)};
  }

  void set_cone(const AdfJoint& joint, JointDef<S>& result) {
    const Vec3<double>& limits = joint.cone_limits;
    result.lower_limit = -S(limits.x());
    result.upper_limit = S(limits.x());
    result.swing_limit = S(std::min(limits.y(), limits.z()));
    if (limits.y() != limits.z()) {
      report_.add(AdfNoteKind::changed, "joint/joint limits",
                  "cones are round: of y and z the smaller counts", joint.line);
    }
  }

  const AdfBuildDef<S>& def_;
  AdfReport& report_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
