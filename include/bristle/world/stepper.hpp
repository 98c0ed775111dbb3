/// @file
/// One step of a world: its stages in order.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/joints/joint_pose.hpp>
#include <bristle/dynamics/joints/joint_rows.hpp>
#include <bristle/world/contact_stage.hpp>
#include <bristle/world/sensor_stage.hpp>
#include <bristle/world/sleep_stage.hpp>
#include <bristle/world/solve_stage.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Steps a world. It owns the stages' scratch memory and no state. Any stepper takes a world from
/// the same state to the same bits.
template <Scalar S, typename Backend>
class Stepper {
 public:
  using State = WorldState<S, Backend>;

  /// Advances `state` by its time step. Never throws; allocates only until warm.
  void step(State& state);

 private:
  [[nodiscard]] static bool is_awake_joint(const State& state, std::uint32_t index);
  static void add_joints(State& state);
  void store_joint_impulses_of(State& state) const;
  static void follow_joint_angles(State& state);

  ContactStage<S, Backend> contacts_;
  SensorStage<S, Backend> sensors_;
  SolveStage<S, Backend> solve_;
  SleepStage<S, Backend> sleep_;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S, typename Backend>
void Stepper<S, Backend>::step(State& state) {
  state.report = {};
  state.ended.swap(state.ended_since);
  state.ended_since.clear();
  if (state.is_idle) {
    // Nothing moves or changes: readings and contacts stay valid.
    state.contacts.repeat();
    state.report.sleeping_bodies = state.sleeping_bodies;
    return;
  }
  state.constraints.clear();
  solve_.prepare_bodies(state);
  sleep_.wake_reached(state, solve_, sensors_);

  contacts_.find_contacts(state);
  sensors_.sense(state);
  sensors_.apply(state);

  contacts_.add_constraints(state);
  add_joints(state);

  solve_.solve(state, sensors_);
  contacts_.store_impulses(state);
  store_joint_impulses_of(state);
  sensors_.read(state);
  solve_.integrate(state);
  follow_joint_angles(state);
  contacts_.settle_boxes(state);
  sleep_.fall_asleep(state, sensors_);
  ++state.steps;
}

template <Scalar S, typename Backend>
bool Stepper<S, Backend>::is_awake_joint(const State& state, std::uint32_t index) {
  if (!state.joints.is_live(index)) return false;
  const JointDef<S>& def = state.joints.at(index).def;
  return !state.bodies.at(def.body_a.index).is_asleep() &&
         !state.bodies.at(def.body_b.index).is_asleep();
}

template <Scalar S, typename Backend>
void Stepper<S, Backend>::add_joints(State& state) {
  for (std::uint32_t i = 0; i < state.joints.slot_count(); ++i) {
    if (!is_awake_joint(state, i)) continue;
    Joint<S>& joint = state.joints.at(i);
    add_joint_rows(joint, i, state.bodies.at(joint.def.body_a.index),
                   state.bodies.at(joint.def.body_b.index), state.def.time_step, state.constraints);
    const JointGap<S> gap = joint_gap(joint, state.constraints);
    state.report.joint_gap = std::max(state.report.joint_gap, gap.distance);
    state.report.joint_tilt = std::max(state.report.joint_tilt, gap.angle);
  }
}

template <Scalar S, typename Backend>
void Stepper<S, Backend>::store_joint_impulses_of(State& state) const {
  for (std::uint32_t i = 0; i < state.joints.slot_count(); ++i) {
    if (!is_awake_joint(state, i)) continue;
    store_joint_impulses(state.joints.at(i), state.constraints);
    solve_.add_mechanism_impulse(i, state.joints.at(i).total);
  }
}

template <Scalar S, typename Backend>
void Stepper<S, Backend>::follow_joint_angles(State& state) {
  for (std::uint32_t i = 0; i < state.joints.slot_count(); ++i) {
    if (!is_awake_joint(state, i)) continue;
    Joint<S>& joint = state.joints.at(i);
    if (!has_angle(joint.def.kind)) continue;
    const std::uint32_t a = joint.def.body_a.index;
    const std::uint32_t b = joint.def.body_b.index;
    const Body<S>& body_a = state.bodies.at(a);
    const Body<S>& body_b = state.bodies.at(b);
    joint.angle =
        tracked_position(joint, joint_pose(joint, body_a.center_pose, body_b.center_pose),
                         {state.solver_bodies[a].start, body_a.twist},
                         {state.solver_bodies[b].start, body_b.twist}, state.def.time_step);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
