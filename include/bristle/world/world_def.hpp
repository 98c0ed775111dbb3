/// @file
/// Settings of a world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/parallel.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/dynamics/solver/solver_def.hpp>
#include <bristle/math/types.hpp>

#include <cstdint>
#include <functional>

namespace bristle::inline BRISTLE_ABI {

/// Sleep of islands of bodies. Sleeping islands are not computed. Nothing moves and velocities are
/// zero; contacts, joints and sensors keep their impulses and readings.
template <Scalar S>
struct SleepDef {
  /// [m/s] Speed of the centre of mass up to which a body is at rest, >= 0.
  S linear_speed = S(0.01);
  /// [rad/s] Angular speed up to which a body is at rest, >= 0.
  S angular_speed = S(0.05);
  /// [s] Time that all bodies of an island must be at rest, > 0. Infinite, the default: nothing
  /// ever sleeps (docs/decisions/0014-sleep-is-off.md gives the reasons).
  S time = infinity<S>;
};

/// Settings of a world.
template <Scalar S>
struct WorldDef {
  /// [m/s^2] Gravity.
  Vec3<S> gravity = Vec3<S>(S(0), S(0), S(-9.81));
  /// [s] Length of a step, > 0.
  S time_step = S(1) / S(240);
  /// [m/s] Impact speed below which nothing bounces, >= 0.
  S restitution_speed = S(0.01);
  /// [-] Integrator of positions.
  Integrator integrator = Integrator::trapezoidal;
  /// [-] Settings of the solver.
  SolverDef<S> solver{};
  /// [-] Conditions of sleep.
  SleepDef<S> sleep{};
  /// [1] Material of a pair of shapes in contact, from those of the two. A pure function, the same
  /// in both orders. A result that `validate` would refuse counts as that of `combined`, and
  /// velocities of surfaces are not its business.
  Material<S> (*combine)(const Material<S>& a, const Material<S>& b) = combined<S>;
  /// [-] Returns whether two shapes may touch that filters let meet, by their `user_data`. Unset:
  /// they may. Asked in each step for shapes that may reach each other, in either order, on any
  /// thread of `parallel_for`, and by all copies of the world. Must not throw, and must depend on
  /// nothing that changes while bodies sleep. Sensors do not ask.
  std::function<bool(std::uint64_t user_data_a, std::uint64_t user_data_b)> may_collide{};
  /// [-] True to keep begins and ends of contacts until they are cleared (`World::contact_events`).
  /// The list grows until then.
  bool keeps_contact_events = false;
  /// [-] Runs independent tasks, on threads of the caller if it has any. The results are the same.
  ParallelFor parallel_for = serial_for;
};

}  // namespace bristle::inline BRISTLE_ABI
