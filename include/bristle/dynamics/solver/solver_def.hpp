/// @file
/// Settings of the solver and the integrator.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <cstdint>
#include <limits>

namespace bristle::inline BRISTLE_ABI {

/// Rule for positions from velocities; docs/solver.md compares them.
enum class Integrator {
  /// By the mean of the velocities at both ends of the step. It is of second order, and exact under
  /// constant forces. Bodies that sensors push are stepped by symplectic Euler all the same. The
  /// law of the bristles is integrated with it.
  trapezoidal,
  /// By the velocity at the end of the step. It is of first order, as in the paper.
  symplectic_euler
};

/// Settings of the solver. The defaults are made for holding things still.
template <Scalar S>
struct SolverDef {
  /// [-] Most sweeps over an island in a solve. As many again run without a warm start if those
  /// diverged.
  int max_sweeps = 100;
  /// [-] Most sweeps of the position problem in a step.
  int max_position_sweeps = 30;
  /// [-] Most solves of an island because its sensors changed state (stuck to slipping, touching to
  /// free, normal force). The same bound holds for contacts that turned out to be open.
  int max_passes = 12;
  /// [1] Sweeps end when one changes no velocity by more than this fraction. It is a fraction of
  /// the speed gained from gravity in a step. It is tight on purpose. A state that is not at rest
  /// to this precision never becomes a fixed point. Only a fixed point makes the next step one
  /// sweep.
  S tolerance = std::numeric_limits<S>::digits > 30 ? S(1e-8) : S(1e-5);
  /// [1] Position errors below this fraction are ignored. It is a fraction of the displacement by
  /// gravity in a step. Positions do not act back on velocities. So this may be looser.
  S position_tolerance = std::numeric_limits<S>::digits > 30 ? S(1e-6) : S(1e-3);
  /// [-] Most multiply-adds of one factorisation of the matrix of an island. Islands within it are
  /// solved by factorisation where sweeps converge too slowly. Examples are a tower of some five
  /// hundred bodies, or a heap of some forty. Larger islands are swept, and so are heaps that
  /// slide, from a tenth of it on, and heaps of mechanisms of at most `large_sweeps` bodies, where
  /// the elimination alone takes a fifth of it. 0 for plain sequential impulses. Twenty times as
  /// many are the budget of one solve of an island.
  std::uint64_t max_direct_work = 700000;
  /// [-] Most Newton steps of one such solve. Islands for which they exceed the budget take fewer.
  /// With the bounds on sweeps and passes it bounds the cost of the worst step.
  int max_newton_steps = 60;
  /// [-] Most sweeps over a larger island in each substep. Half of them run, and the others as long
  /// as extrapolating them gains. That is never so with joints, sensors or restitution.
  /// `max_sweeps` run if most of its contacts are new. Where surfaces slide fast, the
  /// others run as a quarter of the budget of `max_direct_work` allows, up to `max_sweeps`. All of
  /// them run over a smaller heap that slides, and up to twice as many where it is hit.
  int large_sweeps = 20;
  /// [-] The same for the position problem of a larger island. Where surfaces slide fast, as many
  /// run as the budget allows, at least these.
  int large_position_sweeps = 20;
  /// [s] Longest substep over which a larger island is solved at once, > 0. Infinite for one
  /// substep per step.
  S longest_substep = S(1) / S(240);
};

}  // namespace bristle::inline BRISTLE_ABI
