/// @file
/// Figures of a step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// Counters of one step. A stage without work leaves its counters at zero. They show that a step
/// skips the work that a scene does not need.
template <Scalar S>
struct StepReport {
  /// [-] Pairs of overlapping boxes, pairs queried from the backend, and contact points found.
  std::uint64_t pairs_tested = 0;
  std::uint64_t pairs_collided = 0;
  std::uint64_t contact_points = 0;
  /// [-] Patches in the world, and those with a body in range.
  std::uint64_t patches = 0;
  std::uint64_t patches_near = 0;
  /// [-] Rays cast, sensors skipped, and sensors in contact. A ray counts once per shape that it is
  /// cast at; rays cast at meshes in packets do not count. A sensor is skipped if nothing is in its
  /// range, or all of it sleeps. Patches that are switched off count only as patches.
  std::uint64_t rays_cast = 0;
  std::uint64_t sensors_skipped = 0;
  std::uint64_t sensors_touching = 0;
  /// [-] Patch-body pairs evaluated explicitly and solved implicitly.
  std::uint64_t explicit_pairs = 0;
  std::uint64_t implicit_pairs = 0;
  /// [-] Islands with constraints, those solved by factorisation, rows, sweeps, factorisations.
  std::uint64_t islands = 0;
  std::uint64_t direct_islands = 0;
  std::uint64_t rows = 0;
  std::uint64_t sweeps = 0;
  std::uint64_t factorisations = 0;
  /// [-] Acceleration evaluations in smooth motion of mechanisms.
  std::uint64_t mechanism_evaluations = 0;
  /// [m], [rad] Largest position and angle error of a joint of awake bodies when the step began.
  /// Limits do not count, nor hinges with opposite axes. The step closes what it can of them by
  /// displacements that velocities do not show, however wide they are.
  S joint_gap = S(0);
  S joint_tilt = S(0);
  /// [-] Sweeps of the position correction; zero in a step without position errors.
  std::uint64_t position_sweeps = 0;
  /// [m/s] Residual of the worst island: the largest velocity change of its last sweep.
  S residual = S(0);
  /// [-] Islands where a limit of `SolverDef` ended the solution before its tolerance did.
  std::uint64_t capped_islands = 0;
  /// [-] Contact queries that failed in the backend. Those pairs do not touch in this step.
  std::uint64_t backend_failures = 0;
  /// [-] Islands whose solution was not finite. Their contacts and joints are swept one by one.
  /// Rows that would overflow give nothing in this step, nor do sensors and springs.
  std::uint64_t discarded_islands = 0;
  /// [-] Dynamic bodies asleep and awake after the step.
  std::uint64_t sleeping_bodies = 0;
  std::uint64_t awake_bodies = 0;
  /// [-] Bodies whose new state was not finite. They keep their pose, at rest.
  std::uint64_t frozen_bodies = 0;
};

}  // namespace bristle::inline BRISTLE_ABI
