/// @file
/// Definition of a patch: the positions of its sensors, their constants, and their law.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/sensors/sensor_layout.hpp>
#include <bristle/sensors/sensor_parameters.hpp>

#include <cstdint>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

namespace detail {
struct PatchTag;
}  // namespace detail
/// Handle of a patch of a world.
using PatchId = detail::Id<detail::PatchTag>;

/// Definition of a patch for `World::add_patch`.
template <Scalar S>
struct PatchDef {
  /// [m] Rays of the sensors, in the body frame.
  SensorLayout<S> sensors{};
  /// [-] Constants that all sensors share.
  SensorParameters<S> parameters{};
  /// [-] Constants of each sensor instead, in the order of the layout; empty to share.
  std::vector<SensorParameters<S>> per_sensor{};
  /// [-] Integration of the forces in the step.
  Integration integration = Integration::automatic;
  /// [-] Variants of the law.
  LawOptions options{};
  /// [1] Lambda below which `automatic` integrates explicitly. 0: never. Lambda is the stability
  /// measure of docs/sensors.md; 4 is the limit of a single mode.
  S explicit_below = S(0.5);
  /// [-] Categories of bodies that the sensors sense. Their collision masks do not matter to
  /// sensors.
  std::uint32_t sense_mask = 0xffffffffu;
  /// [-] Bodies never sensed, besides their own.
  std::vector<BodyId> excluded{};
  /// [-] True to accept rays that end inside their own body, or that come from outside and enter it.
  /// `World::add_patch` refuses them otherwise, by the shapes that the body has then. Such a ray
  /// senses contacts through the body, and presses the body towards them.
  bool may_point_inwards = false;
  /// [N] Normal force of the whole patch that its constants are for, as `Tuning::patch` sets it; 0
  /// where that is not known. `World::patch_report` compares it with the weights in the world, and
  /// nothing else asks for it.
  S load = S(0);
  /// [-] Steps from one cast of the rays to the next, >= 1. Every step evaluates the law. In the
  /// steps between, the hit surfaces move on as planes (docs/sensors.md, section 8). Patches take
  /// turns by their index. Rays are cast sooner if another shape comes into range, or if bodies
  /// have moved by a quarter of the shortest ray.
  std::uint32_t cast_every = 1;
  /// [-] A number of the caller's, such as an index (`World::user_data`).
  std::uint64_t user_data = 0;
};

}  // namespace bristle::inline BRISTLE_ABI
