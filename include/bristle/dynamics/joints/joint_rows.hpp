/// @file
/// Rows of joints in a step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/dynamics_constants.hpp>
#include <bristle/dynamics/joints/joint_kinematics.hpp>
#include <bristle/dynamics/joints/joint_pose.hpp>
#include <bristle/dynamics/joints/joint_spring.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Adds the constraints of a joint in this step. Locked axes are one equality block. The motor, the
/// limits, and a soft block for springs follow.
template <Scalar S>
void add_joint_rows(Joint<S>& joint, std::uint32_t joint_slot, const Body<S>& a, const Body<S>& b,
                    S dt, Constraints<S>& out);

/// Rotates the rows of the locked axes to the poses at the end of the step. It is for bodies whose
/// free motion obeys the joint. The rows then have no error, and only resist other forces.
/// @param motion_a, motion_b  [m/s, rad/s] Displacements of the free motion, divided by the step.
template <Scalar S>
void turn_joint_rows(const Joint<S>& joint, const Transform<S>& X_WA, const Transform<S>& X_WB,
                     const Twist<S>& motion_a, const Twist<S>& motion_b, S dt, Constraints<S>& out);

/// Moves the rows of the locked axes to the instant at which their impulses act. Their targets
/// account for the joint's own rotation until the end of the step. It is the same as `time_contact`
/// for contacts. The rotation of the arms gives J' v of `constraint_acceleration_bias`.
template <Scalar S>
void time_joint_rows(const Joint<S>& joint, const Body<S>& a, const Body<S>& b,
                     Integrator integrator, S dt, Constraints<S>& out);

/// Stores the impulses that the solver found.
template <Scalar S>
void store_joint_impulses(Joint<S>& joint, const Constraints<S>& constraints);

/// Position error of a joint.
template <Scalar S>
struct JointGap {
  /// [m] Distance of the origins of its frames, and [rad] angle between them.
  S distance = S(0);
  S angle = S(0);
};
/// Position error of a joint whose rows have been added.
template <Scalar S>
[[nodiscard]] JointGap<S> joint_gap(const Joint<S>& joint, const Constraints<S>& constraints);

/// State of a joint. It follows from its bodies and the impulses of the last step.
template <Scalar S>
[[nodiscard]] JointReading<S> read_joint(const Joint<S>& joint, const Body<S>& a, const Body<S>& b,
                                         S dt);

// Implementation ----------------------------------------------------------------------------------

/// [m/s] Speed of a motor in position mode at a distance [m] from its target. The motor can still
/// brake from it with a share of its force. The rest is for loads. It does not pass the target in
/// this step. In rad for a motor that turns, with the mobility about its axis.
template <Scalar S>
[[nodiscard]] S approach_speed(const JointMotor<S>& motor, S distance, S inverse_mass, S dt) {
  using std::abs;
  using std::min;
  using std::sqrt;
  const S braking = motor.max_force * inverse_mass * S(chosen::motor_braking_share);
  const S speed =
      min(min(abs(distance) / dt, motor.max_speed), sqrt(S(2) * braking * abs(distance)));
  return distance < S(0) ? -speed : speed;
}

/// Velocity target of a motor at the end of the step.
template <Scalar S>
struct MotorTarget {
  bool acts = true;
  S velocity = S(0);    // [m/s or rad/s]
  S compliance = S(0);  // Of the row: velocity yielded per impulse.
};

/// Finds the target of a motor.
/// @param position  [m or rad] Of the joint, at the start of the step.
/// @param mobility  Returns the mobility of the axis; called in position mode.
template <Scalar S, typename Mobility>
[[nodiscard]] MotorTarget<S> target_motor(const JointMotor<S>& motor, S position,
                                          const Mobility& mobility, S dt) {
  const S distance = motor.target - position;
  switch (motor.mode) {
    case MotorMode::none:
      break;
    case MotorMode::velocity:
      return {true, motor.target, S(0)};
    case MotorMode::position:
      return {true, approach_speed(motor, distance, mobility(), dt), S(0)};
    case MotorMode::spring: {
      // The impulse dt k (distance - dt v) - dt d v is that of a row. The row has the target
      // velocity below and the compliance 1 / (dt (dt k + d)).
      const S held = dt * motor.stiffness + motor.damping;
      if (!(held > S(0))) break;
      return {true, motor.stiffness * distance / held, S(1) / (dt * held)};
    }
  }
  return {false, S(0), S(0)};
}

/// Row for the rotation of B relative to A about an axis.
template <Scalar S>
[[nodiscard]] ConstraintRow<S> angular_row(const Vec3<S>& axis, S error) {
  ConstraintRow<S> row;
  row.angular_a = row.angular_b = axis;
  row.error = error;
  return row;
}

/// Calls use(row) for each row that a joint keeps at zero. There are `locked_rows` of them.
template <Scalar S, typename Use>
void for_each_locked_row(JointKind kind, const JointPose<S>& pose, Use&& use) {
  if (kind == JointKind::six_dof) return;
  for (int axis = kind == JointKind::prismatic ? 1 : 0; axis < 3; ++axis) {
    ConstraintRow<S> row = linear_row(pose, axis);
    row.error = pose.offset_J[axis];
    use(row);
  }
  if (kind == JointKind::ball || kind == JointKind::cone_twist) return;
  const bool has_hinge = kind == JointKind::revolute;
  const Vec3<S> turn_J = has_hinge ? shortest_turn<S>(unit_x<Vec3<S>>(), pose.axis_b_J())
                                   : log_rotation<S>(pose.turn_J);
  for (int axis = has_hinge ? 1 : 0; axis < 3; ++axis) {
    use(angular_row<S>(column_of(pose.axes_W, axis), turn_J[axis]));
  }
}

/// Returns the gap measured by locked rows. It has no derivatives, since a length has none at 0.
template <Scalar S>
[[nodiscard]] JointGap<S> gap_of(std::span<const ConstraintRow<S>> locked) {
  using std::sqrt;
  auto distance2 = value_of(S(0));
  auto angle2 = value_of(S(0));
  for (const ConstraintRow<S>& row : locked) {
    const auto error = value_of(row.error);
    (row.direction.isZero(S(0)) ? angle2 : distance2) += error * error;
  }
  return {S(sqrt(distance2)), S(sqrt(angle2))};
}

/// [1/kg or 1/(kg m^2)] Acceleration along a free axis per force there. Only the two bodies move,
/// and the joint holds its locked axes.
template <Scalar S>
[[nodiscard]] S axis_mobility(JointKind kind, const JointPose<S>& pose, const Body<S>& a,
                              const Body<S>& b) {
  if (kind == JointKind::prismatic) return a.inverse_mass + b.inverse_mass;
  std::array<ConstraintRow<S>, 6> rows;
  std::size_t count = 0;
  for_each_locked_row(kind, pose, [&](const ConstraintRow<S>& row) { rows[count++] = row; });
  rows[count] = position_row(kind, pose);
  ConstraintBlock<S> block;
  block.count = 6;
  const auto mass_of = [](const Body<S>& body) {
    SolverBody<S> out;
    out.inverse_mass = body.inverse_mass_W();
    out.inverse_inertia = body.inverse_inertia_W();
    return out;
  };
  BlockResponse<S> K;
  local_response(block, rows.data(), mass_of(a), mass_of(b), K);
  // The last pivot is the rest of the last row's response when the other rows hold.
  const S pivot = K.factor.back();
  return pivot < infinity<S> ? pivot * pivot : S(0);
}

/// Row whose velocity is the rate of the swing of a `cone_twist`. Its error is the swing. Without a
/// swing, or with opposite axes, it uses the axis of the present swing velocity.
template <Scalar S>
[[nodiscard]] ConstraintRow<S> swing_row(const JointPose<S>& pose, const Twist<S>& a,
                                         const Twist<S>& b) {
  const Vec3<S> turn_J = shortest_turn<S>(unit_x<Vec3<S>>(), pose.axis_b_J());
  const S swing = joint_swing(pose);
  const S length = turn_J.norm();
  if (length > Tolerance<S>::equal()) {
    return angular_row<S>(pose.axes_W * (turn_J / length), swing);
  }
  Vec3<S> rate_J = pose.axes_W.transpose() * (b.angular - a.angular);
  rate_J.x() = S(0);
  const S speed = rate_J.norm();
  const Vec3<S> axis_J = speed > S(0) ? Vec3<S>(rate_J / speed) : unit_y<Vec3<S>>();
  return angular_row<S>(pose.axes_W * axis_J, swing);
}

inline constexpr std::uint8_t motor_impulse = 6;
inline constexpr std::uint8_t lower_impulse = 7;
inline constexpr std::uint8_t upper_impulse = 8;
inline constexpr std::uint8_t swing_impulse = 9;

template <Scalar S>
void add_joint_rows(Joint<S>& joint, std::uint32_t joint_slot, const Body<S>& a, const Body<S>& b,
                    S dt, Constraints<S>& out) {
  using std::max;
  using std::min;
  const JointDef<S>& def = joint.def;
  const JointKind kind = def.kind;
  const JointPose<S> pose = joint_pose(joint, a.center_pose, b.center_pose);
  joint.first_block = static_cast<std::uint32_t>(out.blocks.size());
  joint.is_sprung = false;
  const auto open_block = [&](BlockKind block_kind,
                              std::uint8_t first_impulse) -> ConstraintBlock<S>& {
    ConstraintBlock<S> block;
    block.body_a = def.body_a.index;
    block.body_b = def.body_b.index;
    block.first = static_cast<std::uint32_t>(out.rows.size());
    block.kind = block_kind;
    block.first_impulse = first_impulse;
    block.joint = joint_slot;
    out.blocks.push_back(block);
    return out.blocks.back();
  };
  if (locked_rows(kind) > 0) {
    open_block(BlockKind::equality, 0).count = locked_rows(kind);
    std::size_t k = 0;
    for_each_locked_row(kind, pose, [&](ConstraintRow<S> row) {
      row.impulse = joint.impulses[k++];
      out.rows.push_back(row);
    });
  }

  const auto single_row = [&](BlockKind block_kind, ConstraintRow<S> row, S target, S lower,
                              S upper, std::uint8_t slot) {
    ConstraintBlock<S>& block = open_block(block_kind, slot);
    block.count = 1;
    block.lower = lower;
    block.upper = upper;
    row.target = target;
    row.impulse = min(max(joint.impulses[slot], lower), upper);
    out.rows.push_back(row);
  };
  // Like a contact, a limit may be approached as fast as reaches it in this step. The position
  // correction removes an excess, and leaves no speed behind.
  const auto add_limit = [&](ConstraintRow<S> row, S distance, std::uint8_t slot) {
    row.error = distance;
    single_row(BlockKind::limit, row, -max(S(0), distance) / dt, S(0), infinity<S>, slot);
  };
  const bool is_driven = has_free_axis(kind) && def.motor.mode != MotorMode::none;
  const bool has_lower = def.lower_limit > -infinity<S>;
  const bool has_upper = def.upper_limit < infinity<S>;
  const bool has_spring = def.spring.stiffness > S(0) || def.spring.damping > S(0);
  if (is_driven || has_lower || has_upper || has_spring) {
    const S position = joint_position(kind, pose, joint.angle);
    const ConstraintRow<S> along = position_row(kind, pose);
    // A motor without force has no row.
    if (is_driven && def.motor.max_force > S(0)) {
      const S limit = def.motor.max_force * dt;
      const MotorTarget<S> target = target_motor(
          def.motor, position, [&] { return axis_mobility(kind, pose, a, b); }, dt);
      ConstraintRow<S> row = along;
      row.compliance = target.compliance;
      if (target.acts) {
        single_row(BlockKind::bounded, row, target.velocity, -limit, limit, motor_impulse);
      }
    }
    if (has_lower) add_limit(along, position - def.lower_limit, lower_impulse);
    if (has_upper) add_limit(reversed(along), def.upper_limit - position, upper_impulse);
    if (has_spring) {
      const S mobility = kind == JointKind::prismatic
                             ? a.inverse_mass + b.inverse_mass
                             : along.angular_a.dot(a.inverse_inertia_W() * along.angular_a) +
                                   along.angular_b.dot(b.inverse_inertia_W() * along.angular_b);
      add_joint_spring(joint, pose, along, position, mobility, dt, out);
    }
  }
  if (kind == JointKind::cone_twist && def.swing_limit < S(std::numbers::pi)) {
    const ConstraintRow<S> swing = swing_row(pose, a.twist, b.twist);
    add_limit(reversed(swing), def.swing_limit - swing.error, swing_impulse);
  }
  if (kind == JointKind::six_dof) add_joint_bushing(joint, pose, dt, out);
  joint.block_count = static_cast<std::uint32_t>(out.blocks.size()) - joint.first_block;
}

template <Scalar S>
void turn_joint_rows(const Joint<S>& joint, const Transform<S>& X_WA, const Transform<S>& X_WB,
                     const Twist<S>& motion_a, const Twist<S>& motion_b, S dt,
                     Constraints<S>& out) {
  ConstraintRow<S>* out_row = &out.rows[out.blocks[joint.first_block].first];
  for_each_locked_row(joint.def.kind, joint_pose(joint, X_WA, X_WB), [&](ConstraintRow<S> row) {
    row.impulse = out_row->impulse;
    row.error = -dt * row.velocity(motion_a, motion_b);
    *out_row++ = row;
  });
}

template <Scalar S>
void time_joint_rows(const Joint<S>& joint, const Body<S>& a, const Body<S>& b,
                     Integrator integrator, S dt, Constraints<S>& out) {
  if (a.twist.angular.isZero(S(0)) && b.twist.angular.isZero(S(0))) return;
  if (turns_far<S>(a.twist.angular, dt) || turns_far<S>(b.twist.angular, dt)) return;
  const bool is_trapezoidal = integrator == Integrator::trapezoidal;
  const JointKind kind = joint.def.kind;
  const S half = dt / S(2);
  const auto acting_pose = [&](const Body<S>& body) -> Transform<S> {
    if (!is_trapezoidal) return body.center_pose;
    return {step_rotation(body.center_pose.rotation, body.twist.angular, half),
            body.center_pose.translation + half * body.twist.linear};
  };
  const JointPose<S> pose = joint_pose(joint, acting_pose(a), acting_pose(b));
  JointState<S> at;
  at.arm_a = pose.arm_a;
  at.arm_b = pose.arm_b;
  if (lets_slide(kind)) at.slide = column_of(pose.axes_W, 0);
  if (lets_hinge(kind)) at.hinge = column_of(pose.axes_W, 0);
  const Twist<S> turning = constraint_acceleration_bias(kind, at, a.twist, b.twist);
  ConstraintRow<S>* out_row = &out.rows[out.blocks[joint.first_block].first];
  for_each_locked_row(kind, pose, [&](ConstraintRow<S> row) {
    const bool is_angular = row.direction.isZero(S(0));
    row.target = -half * (is_angular ? row.angular_b.dot(turning.angular)
                                     : row.direction.dot(turning.linear));
    row.impulse = out_row->impulse;
    row.error = is_trapezoidal ? out_row->error : out_row->error - dt * row.target;
    *out_row++ = row;
  });
}

template <Scalar S>
void store_joint_impulses(Joint<S>& joint, const Constraints<S>& constraints) {
  joint.total = {};
  joint.impulses.fill(S(0));
  for (std::uint32_t i = joint.first_block; i < joint.first_block + joint.block_count; ++i) {
    const ConstraintBlock<S>& block = constraints.blocks[i];
    for (std::uint32_t r = 0; r < block.count; ++r) {
      const ConstraintRow<S>& row = constraints.rows[block.first + r];
      const bool is_angular = row.direction.isZero(S(0));
      joint.impulses[block.first_impulse + r] = row.impulse;
      joint.total.force += row.impulse * row.direction;
      if (is_angular) joint.total.torque += row.impulse * row.angular_b;
    }
  }
  joint.spring_impulse = {};
  if (!joint.is_sprung) return;
  const Vec6<S>& impulse = constraints.soft[joint.soft_block].impulse;
  joint.spring_impulse = wrench_of<S>(impulse);
  joint.total += joint.spring_impulse;
}

template <Scalar S>
JointGap<S> joint_gap(const Joint<S>& joint, const Constraints<S>& constraints) {
  const std::size_t count = locked_rows(joint.def.kind);
  if (count == 0) return {};
  const std::span<const ConstraintRow<S>> rows = constraints.rows;
  return gap_of(rows.subspan(constraints.blocks[joint.first_block].first, count));
}

template <Scalar S>
JointReading<S> read_joint(const Joint<S>& joint, const Body<S>& a, const Body<S>& b, S dt) {
  const JointKind kind = joint.def.kind;
  JointReading<S> reading;
  reading.reaction = (S(1) / dt) * joint.total;
  const JointPose<S> pose = joint_pose(joint, a.center_pose, b.center_pose);
  std::array<ConstraintRow<S>, 6> rows;
  std::size_t count = 0;
  for_each_locked_row(kind, pose, [&](const ConstraintRow<S>& row) { rows[count++] = row; });
  const JointGap<S> gap = gap_of(std::span<const ConstraintRow<S>>(rows.data(), count));
  reading.gap = gap.distance;
  // Opposite axes have no shortest rotation. So they have no rows that close them.
  reading.tilt = kind == JointKind::revolute ? S(value_of(joint_swing(pose))) : gap.angle;
  if (!has_free_axis(kind) && !has_angle(kind)) return reading;
  reading.position = joint_position(kind, pose, joint.angle);
  reading.velocity = position_row(kind, pose).velocity(a.twist, b.twist);
  reading.motor_force = joint.impulses[motor_impulse] / dt;
  if (kind == JointKind::cone_twist) {
    reading.swing = joint_swing(pose);
  }
  return reading;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
