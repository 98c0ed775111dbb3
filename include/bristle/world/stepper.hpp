/// @file
/// One step of a world: its stages in order.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/contact_stage.hpp>
#include <bristle/world/joint_stage.hpp>
#include <bristle/world/sensor_stage.hpp>
#include <bristle/world/sleep_stage.hpp>
#include <bristle/world/solve_stage.hpp>
#include <bristle/world/world_state.hpp>

#include <memory>

namespace bristle::inline BRISTLE_ABI::detail {

/// Steps a world. It owns the stages' scratch memory and no state. Any stepper takes a world from
/// the same state to the same bits.
template <Scalar S>
class Stepper {
 public:
  using State = WorldState<S>;

  /// Advances `state` by its time step. Never throws; allocates only until warm.
  void step(State& state);

 private:
  ContactStage<S> contacts_;
  SensorStage<S> sensors_;
  /// Null until the world has a joint.
  std::unique_ptr<JointStage<S>> joints_;
  SolveStage<S> solve_;
  SleepStage<S> sleep_;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void Stepper<S>::step(State& state) {
  state.report = {};
  state.ended.swap(state.ended_since);
  state.ended_since.clear();
  if (state.is_idle) {
    // Nothing moves or changes: readings and contacts stay valid.
    state.contacts.repeat();
    state.report.sleeping_bodies = state.sleeping_bodies;
    if (state.def.keeps_contact_events) keep_events(state);
    return;
  }
  if (joints_ == nullptr && state.joint_kernels != nullptr) {
    joints_ = state.joint_kernels->make_stage();
  }
  state.constraints.clear();
  solve_.prepare_bodies(state);
  sleep_.wake_reached(state, solve_, sensors_);

  contacts_.find_contacts(state);
  sensors_.sense(state);
  sensors_.apply(state);

  contacts_.add_constraints(state);
  if (joints_) joints_->add_constraints(state);

  solve_.solve(state, sensors_, joints_.get());
  contacts_.store_impulses(state);
  if (joints_) joints_->store_impulses(state);
  sensors_.read(state);
  solve_.integrate(state, joints_.get());
  if (joints_) joints_->follow_angles(state);
  contacts_.settle_boxes(state);
  sleep_.fall_asleep(state, sensors_);
  ++state.steps;
  if (state.def.keeps_contact_events) keep_events(state);
  state.touch_log.update(state.patches);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
