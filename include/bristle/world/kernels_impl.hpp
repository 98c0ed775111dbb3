/// @file
/// Kernels of a world for the instruction set that this file is compiled for.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/haptic_substep.hpp>
#include <bristle/world/kernels.hpp>
#include <bristle/world/mechanism_stage.hpp>
#include <bristle/world/proximity.hpp>
#include <bristle/world/ray_query.hpp>
#include <bristle/world/stepper.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// The tables of this file's instruction set.
template <Scalar S, typename Backend>
[[nodiscard]] const WorldKernels<S>& own_world_kernels() {
  using Own = Stepper<S>;
  using State = WorldState<S>;
  static constexpr WorldKernels<S> own{
      .queries = &own_shape_queries<S, Backend>,
      .make_scratch = []() -> void* { return new Own; },
      .delete_scratch = [](void* stepper) { delete static_cast<Own*>(stepper); },
      .step = [](void* stepper, State& state) { static_cast<Own*>(stepper)->step(state); },
      .cast_rays =
          [](const State& state, std::span<const Ray<S>> rays, const QueryFilter& filter,
             std::span<WorldHit<S>> hits) {
            RayHits<S> scratch;
            for (std::size_t i = 0; i < rays.size(); ++i) {
              hits[i] = cast_ray(state, rays[i], filter, scratch);
            }
          },
      .sense = [](ProximityArray<S>& array, const State& state,
                  BodyId carrier) { array.sense(state, carrier); }};
  return own;
}
template <Scalar S>
[[nodiscard]] const JointKernels<S>& own_joint_kernels() {
  static constexpr JointKernels<S> own{.make_stage = []() -> std::unique_ptr<JointStage<S>> {
    return std::make_unique<MechanismStage<S>>();
  }};
  return own;
}
template <Scalar S>
[[nodiscard]] const HapticKernels<S>& own_haptic_kernels() {
  static constexpr HapticKernels<S> own{
      .substep = [](HapticLoop<S>& loop) { HapticSubstep<S>(loop).run(); }};
  return own;
}

template <Scalar S, typename Backend>
const WorldKernels<S>& world_kernels() {
  return own_world_kernels<S, Backend>();
}
template <Scalar S>
const JointKernels<S>& joint_kernels() {
  return own_joint_kernels<S>();
}
template <Scalar S>
const HapticKernels<S>& haptic_kernels() {
  return own_haptic_kernels<S>();
}

}  // namespace bristle::inline BRISTLE_ABI::detail
