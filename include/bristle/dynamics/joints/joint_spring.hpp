/// @file
/// Springs and dampers of joints as soft blocks, by implicit Euler. They are stable for any
/// constants and step. They are never a source of energy. Where the step resolves them, mechanisms
/// may integrate them instead (mechanism_integrator.hpp). That avoids the loss of implicit Euler.
///
/// A spring k, d along a position x with x' = j . v pulls with -k (x - rest) - d x'. With both at
/// the end of the step, x + dt x', its impulse is affine in the velocity:
///
///   p = -dt k (x - rest) - (dt^2 k + dt d) x'.
///
/// The six springs of a bushing act on the offset c of B's frame along the axes of A's. They also
/// act on the rotation vector phi between the frames. The rate c' is the velocity of B's origin as
/// seen from A. The rate phi' is J(phi) w, with the angular velocity w of B relative to A. So the
/// torque of the energy phi . K phi / 2 is -J^T K phi.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint_pose.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// Adds a soft block for the spring on the free axis of a joint.
/// @param along  Row of the position.
/// @param position  [m or rad] At the start of the step.
/// @param mobility  [1/kg or 1/(kg m^2)] Upper bound for a force along the row.
template <Scalar S>
void add_joint_spring(Joint<S>& joint, const JointPose<S>& pose, const ConstraintRow<S>& along,
                      S position, S mobility, S dt, Constraints<S>& out);

/// Adds the springs of a `six_dof` joint.
template <Scalar S>
void add_joint_bushing(Joint<S>& joint, const JointPose<S>& pose, S dt, Constraints<S>& out);

// Implementation ----------------------------------------------------------------------------------

/// Adds an empty soft block about B's joint origin. The last step warm starts it.
template <Scalar S>
SoftBlock<S>& open_joint_soft_block(Joint<S>& joint, const JointPose<S>& pose,
                                    Constraints<S>& out) {
  SoftBlock<S> soft;
  soft.body_a = joint.def.body_a.index;
  soft.body_b = joint.def.body_b.index;
  soft.arm_a = pose.arm_a;
  soft.arm_b = pose.arm_b;
  soft.impulse = stacked(joint.spring_impulse);
  joint.soft_block = static_cast<std::uint32_t>(out.soft.size());
  joint.is_sprung = true;
  joint.is_resolved = false;
  out.soft.push_back(soft);
  return out.soft.back();
}

/// J(phi) of phi' = J(phi) w, with w in the axes before the rotation.
template <Scalar S>
[[nodiscard]] Mat3<S> rotation_vector_rate(const Vec3<S>& phi) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const S angle2 = phi.squaredNorm();
  S k = S(1) / S(12) + angle2 / S(720);
  // At smaller angles the omitted terms of the series are below round-off.
  if (angle2 > Tolerance<S>::equal()) {
    const S half = sqrt(angle2) / S(2);
    k = (S(1) - half * cos(half) / sin(half)) / angle2;
  }
  const Mat3<S> X = skew(phi);
  return identity<Mat3<S>>() - S(0.5) * X + k * X * X;
}

template <Scalar S>
void add_joint_spring(Joint<S>& joint, const JointPose<S>& pose, const ConstraintRow<S>& along,
                      S position, S mobility, S dt, Constraints<S>& out) {
  const JointSpring<S>& spring = joint.def.spring;
  SoftBlock<S>& soft = open_joint_soft_block(joint, pose, out);
  const bool turns = has_angle(joint.def.kind);
  const Vec3<S> none = zero<Vec3<S>>();
  const Vec6<S> j = turns ? stacked<S>(none, along.angular_b) : stacked<S>(along.direction, none);
  const S held = dt * dt * spring.stiffness + dt * spring.damping;
  joint.is_resolved = held * mobility <= S(1);
  soft.matrix = held * j * j.transpose();
  soft.offset = (-dt * spring.stiffness * (position - spring.rest)) * j;
}

template <Scalar S>
void add_joint_bushing(Joint<S>& joint, const JointPose<S>& pose, S dt, Constraints<S>& out) {
  const JointBushing<S>& bushing = joint.def.bushing;
  SoftBlock<S>& soft = open_joint_soft_block(joint, pose, out);
  const Vec3<S> turn_J = log_rotation<S>(pose.turn_J);
  const Mat3<S>& R = pose.axes_W;
  // Maps to the rate of the rotation vector, in A's joint frame.
  const Mat3<S> rate = rotation_vector_rate<S>(turn_J) * R.transpose();
  const auto squared = [](const Mat3<S>& J, const Vec3<S>& weight) -> Mat3<S> {
    return transposed(J) * diagonal_matrix<S>(weight) * J;
  };
  const Vec3<S> k_linear = dt * first_half<S>(bushing.stiffness);
  const Vec3<S> k_angular = dt * second_half<S>(bushing.stiffness);
  const Vec3<S> d_linear = dt * first_half<S>(bushing.damping);
  const Vec3<S> d_angular = dt * second_half<S>(bushing.damping);
  set_quarter<0, 0, S>(soft.matrix, squared(transposed(R), Vec3<S>(dt * k_linear + d_linear)));
  set_quarter<3, 3, S>(soft.matrix,
                       squared(rate, Vec3<S>(dt * k_angular)) + squared(transposed(R), d_angular));
  soft.offset = stacked<S>(-(R * cwise_product(k_linear, pose.offset_J)),
                           -(rate.transpose() * cwise_product(k_angular, turn_J)));
}

}  // namespace bristle::inline BRISTLE_ABI::detail
