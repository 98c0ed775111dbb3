/// @file
/// The door between what is compiled once and what is compiled for each instruction set.
///
/// All that a world computes in every step goes through a table of functions. Header-only there is
/// one, made for what the program is compiled for; `bristle::compiled` has one for each
/// `InstructionSet` and chooses. Both sides of the door see one layout of all types: what is stored
/// holds arrays of scalars and unaligned matrices, never a register.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/world/world_state.hpp>

#include <span>

namespace bristle::inline BRISTLE_ABI {

struct RayFilter;
template <Scalar S>
struct WorldRayHit;
template <Scalar S>
class ProximityArray;
template <Scalar S, typename Backend = AnalyticBackend>
class HapticLoop;

/// The functions of a world that are compiled for each instruction set. None of them throws.
template <Scalar S, typename Backend>
struct WorldKernels {
  /// A new `Stepper`, and its end.
  void* (*make_scratch)();
  void (*delete_scratch)(void* stepper);
  /// `Stepper::step`.
  void (*step)(void* stepper, WorldState<S, Backend>& state);
  /// Nearest hits of rays with all shapes. Rays are valid, and there is one hit for each.
  void (*cast_rays)(const WorldState<S, Backend>& state, std::span<const Ray<S>> rays,
                    const RayFilter& filter, std::span<WorldRayHit<S>> hits);
  /// `ProximityArray::sense`; the carrier is there.
  void (*sense)(ProximityArray<S>& array, const WorldState<S, Backend>& state, BodyId carrier);
};

/// The same of a haptic loop, apart, so that a header-only program without one does not compile it.
template <Scalar S, typename Backend>
struct HapticKernels {
  /// One tick of a loop that is open and has one left.
  void (*tick)(HapticLoop<S, Backend>& loop);
};

/// The tables that are used from here on.
template <Scalar S, typename Backend>
[[nodiscard]] const WorldKernels<S, Backend>& world_kernels();
template <Scalar S, typename Backend>
[[nodiscard]] const HapticKernels<S, Backend>& haptic_kernels();

}  // namespace bristle::inline BRISTLE_ABI
