/// @file
/// What a step did, in numbers.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// Counters of one step. A stage with nothing to do leaves its counters at zero: what a scene does
/// not need is not done, and this is where it shows.
template <Scalar S>
struct StepReport {
  /// [-] Pairs of overlapping boxes, pairs asked of the backend, and points of contact found.
  std::uint64_t pairs_tested = 0;
  std::uint64_t pairs_collided = 0;
  std::uint64_t contact_points = 0;
  /// [-] Patches in the world, and those with a body in reach.
  std::uint64_t patches = 0;
  std::uint64_t patches_near = 0;
  /// [-] Rays cast (a ray counts once per shape it is asked of; those that meshes are asked in
  /// bundles with others are not counted), sensors skipped because nothing was in reach of them or
  /// all of it sleeps, and sensors that touch. Patches that are switched off count as patches, and
  /// as nothing else.
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
  /// [-] Evaluations of accelerations in the smooth motion of mechanisms.
  std::uint64_t flow_evaluations = 0;
  /// [m] Largest distance between the frames of a joint of bodies that are awake, and [rad] largest
  /// angle, that the joint does not allow, when the step began; limits do not count, nor do hinges
  /// whose axes are opposite. The step closes what it can of them, however wide they are, by
  /// displacements that velocities do not show.
  S joint_gap = S(0);
  S joint_tilt = S(0);
  /// [-] Sweeps of the position correction; zero in a step without position errors.
  std::uint64_t position_sweeps = 0;
  /// [m/s] What is left to solve in the worst island: the largest velocity change of its last
  /// sweep.
  S residual = S(0);
  /// [-] Islands where a limit of `SolverDef` ended the solution before its tolerance did.
  std::uint64_t capped_islands = 0;
  /// [-] Contact queries that the backend failed; those pairs do not touch in this step.
  std::uint64_t backend_failures = 0;
  /// [-] Islands whose solution was not finite. Their contacts and joints are swept one by one, and
  /// those that would overflow give nothing in this step; nor do sensors and springs.
  std::uint64_t discarded_islands = 0;
  /// [-] Dynamic bodies asleep and awake when the step ended.
  std::uint64_t sleeping_bodies = 0;
  std::uint64_t awake_bodies = 0;
  /// [-] Bodies whose new state was not finite; they stay where they were, at rest.
  std::uint64_t frozen_bodies = 0;
};

}  // namespace bristle::inline BRISTLE_ABI
