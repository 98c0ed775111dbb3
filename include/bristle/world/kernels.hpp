/// @file
/// Interface between the code compiled once and the code compiled for each instruction set.
///
/// A table of functions computes all that a world does in every step. Header-only there is one
/// table, for the instruction set of the program. `bristle::compiled` has one for each
/// `InstructionSet` and chooses. Both sides see one layout of all types: stored data are arrays of
/// scalars and unaligned matrices, never registers.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/world/world_state.hpp>

#include <span>

namespace bristle::inline BRISTLE_ABI {

struct QueryFilter;
template <Scalar S>
struct WorldHit;
template <Scalar S>
class ProximityArray;
template <Scalar S>
class HapticLoop;

}  // namespace bristle::inline BRISTLE_ABI

namespace bristle::inline BRISTLE_ABI::detail {

/// Functions of a world, compiled for each instruction set. None of them throws.
template <Scalar S>
struct WorldKernels {
  /// The queries of the world's backend.
  const ShapeQueries<S>& (*queries)();
  /// Creates a `Stepper`, and deletes it.
  void* (*make_scratch)();
  void (*delete_scratch)(void* stepper);
  /// `Stepper::step`.
  void (*step)(void* stepper, WorldState<S>& state);
  /// Finds the nearest hits of rays with all shapes. Rays are valid, with one hit for each.
  void (*cast_rays)(const WorldState<S>& state, std::span<const Ray<S>> rays,
                    const QueryFilter& filter, std::span<WorldHit<S>> hits);
  /// `ProximityArray::sense`. The carrier exists.
  void (*sense)(ProximityArray<S>& array, const WorldState<S>& state, BodyId carrier);
};

/// Kernels of a haptic loop. They are apart, so that a header-only program without a loop does not
/// compile them.
template <Scalar S>
struct HapticKernels {
  /// One substep of an open loop with one left.
  void (*substep)(HapticLoop<S>& loop);
};

/// The tables to use from here on.
template <Scalar S, typename Backend>
[[nodiscard]] const WorldKernels<S>& world_kernels();
template <Scalar S>
[[nodiscard]] const HapticKernels<S>& haptic_kernels();

}  // namespace bristle::inline BRISTLE_ABI::detail
