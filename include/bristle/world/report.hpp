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
  /// [-] Pairs of overlapping boxes.
  std::uint64_t pairs_tested = 0;
  /// [-] Pairs put off to later steps. Of many shapes at one place, each is pushed off the dozen
  /// nearest first.
  std::uint64_t pairs_put_off = 0;
  /// [-] Pairs queried from the backend.
  std::uint64_t pairs_collided = 0;
  /// [-] Contact points found.
  std::uint64_t contact_points = 0;
  /// [-] Patches in the world. Those that are switched off count only here.
  std::uint64_t patches = 0;
  /// [-] Patches with a body in range.
  std::uint64_t patches_near = 0;
  /// [-] Rays cast. A ray counts once per shape that it is cast at. Rays cast at meshes in packets
  /// do not count.
  std::uint64_t rays_cast = 0;
  /// [-] Sensors skipped: nothing is in their range, or all of it sleeps.
  std::uint64_t sensors_skipped = 0;
  /// [-] Sensors in contact.
  std::uint64_t sensors_touching = 0;
  /// [-] Sensors of those pressed in over their whole length (`PatchReading::bottomed_out`).
  std::uint64_t sensors_bottomed_out = 0;
  /// [-] Patch-body pairs evaluated explicitly.
  std::uint64_t explicit_pairs = 0;
  /// [-] Patch-body pairs solved implicitly.
  std::uint64_t implicit_pairs = 0;
  /// [-] Islands with constraints.
  std::uint64_t islands = 0;
  /// [-] Islands solved by factorisation.
  std::uint64_t direct_islands = 0;
  /// [-] Rows of all islands.
  std::uint64_t rows = 0;
  /// [-] Sweeps of all islands.
  std::uint64_t sweeps = 0;
  /// [-] Factorisations of all islands.
  std::uint64_t factorisations = 0;
  /// [-] Acceleration evaluations in smooth motion of mechanisms.
  std::uint64_t mechanism_evaluations = 0;
  /// [m] Largest position error of a joint of awake bodies when the step began. Limits do not
  /// count. The step closes what it can of it by displacements that velocities do not show, however
  /// wide it is.
  S joint_gap = S(0);
  /// [rad] Largest angle error of a joint. Otherwise as `joint_gap`. Hinges with opposite axes do
  /// not count.
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
  /// [-] Dynamic bodies asleep after the step.
  std::uint64_t sleeping_bodies = 0;
  /// [-] Dynamic bodies awake after the step.
  std::uint64_t awake_bodies = 0;
  /// [-] Bodies whose new state was not finite. They keep their pose, at rest.
  std::uint64_t frozen_bodies = 0;
};

}  // namespace bristle::inline BRISTLE_ABI
