/// @file
/// What joints do in a step, as an interface.
///
/// A world makes its joint stage with its first joint. So a program without joints does not compile
/// their rows and the integrator of mechanisms, which are a seventh of the code of a world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <cstdint>
#include <memory>

namespace bristle::inline BRISTLE_ABI::detail {

template <Scalar S>
struct WorldState;

/// The parts of a step that joints have. `MechanismStage` implements them. A stage owns scratch
/// memory of one step and no state.
template <Scalar S>
class JointStage {
 public:
  using State = WorldState<S>;

  JointStage() = default;
  JointStage(const JointStage&) = delete;
  JointStage& operator=(const JointStage&) = delete;
  virtual ~JointStage() = default;

  /// Adds the constraints of all joints of awake bodies, and reports their gaps.
  virtual void add_constraints(State& state) = 0;

  /// Lets the bodies of an island follow the smooth motion of its mechanisms: sets their free
  /// velocities and displacements, and turns the rows of joints to their end poses.
  /// @return False if the island is not such a mechanism, or its motion was not found. It is then
  ///         as before.
  virtual bool follow(State& state, const Island& island, const SolveContext<S>& context) = 0;

  /// Moves the rows of an island's joints to the instants at which their impulses act.
  virtual void time_rows(State& state, const Island& island, const SolveContext<S>& context) = 0;

  /// Returns the bodies of an island to their joints where the solved motion throws them off. That
  /// motion is a line along the directions of the start of the step. A light link that is struck
  /// may turn by radians in one step. On a line it would end far from its joint, beyond the body it
  /// lies on.
  virtual void close_wide_gaps(State& state, const Island& island) = 0;

  /// Moves a body that follows joints to its integrated pose, plus the motion that impulses added.
  virtual void move(Body<S>& body, const SolverBody<S>& solved, std::uint32_t slot, S dt) const = 0;

  /// Stores the solved impulses with their joints.
  virtual void store_impulses(State& state) const = 0;

  /// Follows the angles of hinges over full turns, once bodies have moved.
  virtual void follow_angles(State& state) const = 0;
};

/// How joint stages are made. The table is apart from `WorldKernels`, so that only a program that
/// adds joints compiles what it refers to.
template <Scalar S>
struct JointKernels {
  std::unique_ptr<JointStage<S>> (*make_stage)();
};

/// The table to use from here on.
template <Scalar S>
[[nodiscard]] const JointKernels<S>& joint_kernels();

}  // namespace bristle::inline BRISTLE_ABI::detail
