/// @file
/// A patch: many resistive sensors on one body, as structures of arrays, with the state that they
/// keep from step to step. `PatchScratch` has the memory of one step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/contacts/triangle_cache.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/patch_def.hpp>
#include <bristle/sensors/patch_geometry.hpp>
#include <bristle/sensors/plane_cache.hpp>
#include <bristle/sensors/reading_store.hpp>
#include <bristle/sensors/sensor_packets.hpp>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <string>

namespace bristle::inline BRISTLE_ABI::detail {

/// Impulse of an implicit pair in the last step: its warm start in this one.
template <Scalar S>
struct PairImpulse {
  BodyId body{};
  /// [N s; N m s] On B about the pair's point c, world axes.
  Vec6<S> impulse = zero<Vec6<S>>();
};

/// A body that a patch sensed in the last step. Its neighbours wake it, and `taxel_points` measures
/// stretches at the pose of that step: the body has moved since.
template <Scalar S>
struct SensedBody {
  /// [-] Index of the body.
  std::uint32_t body = 0;
  /// Its pose relative to A as that step began.
  PairPose<S> pose{};
  /// [N, N m] Its part of the reading, which goes with it if it is removed: force on A about A's
  /// centre of mass, and its part across the rays. World axes.
  Wrench<S> on_a{};
  Vec3<S> shear_W = zero<Vec3<S>>();
};

/// State of a patch. Arrays have one entry a sensor unless said otherwise.
template <Scalar S>
struct SensorPatch {
  PatchDef<S> def{};
  /// [-] Body A.
  BodyId body{};
  /// Its rays. Copies of the patch share them. Null in a patch that `make_patch` did not make, such
  /// as a removed one of a haptic loop.
  std::shared_ptr<const PatchGeometry<S>> geometry{};
  /// Triangle cache for a fine mesh. Not state: results do not depend on it.
  TriangleCache<S> triangle_cache{};
  /// Bristles, a packet for each of the geometry's, and which lanes are anchored. They are so in
  /// the body of their reading.
  DynamicArray<BristlePacket<S>> bristles;
  DynamicArray<LaneBits> is_anchored;
  /// False if the patch is off and senses nothing.
  bool is_active = true;

  PlaneCache<S> plane_cache{};
  /// Lanes of each packet that hit anything in the last step, and whether any did. Others hold no
  /// anchors.
  DynamicArray<LaneBits> hit_bits;
  bool has_hits = false;
  DynamicArray<SensedBody<S>> sensed;
  DynamicArray<PairImpulse<S>> last_impulses;
  /// Active sensors of each packet: those with nonzero readings.
  DynamicArray<LaneBits> active_lanes;
  bool was_active = false;
  ReadingStore<S> readings{};

  [[nodiscard]] std::size_t size() const { return geometry->size(); }
  [[nodiscard]] const SensorParameters<S>& parameters(std::size_t sensor) const {
    return def.per_sensor.empty() ? def.parameters : def.per_sensor[sensor];
  }
  /// Returns whether any sensor can apply a force, whatever it is in contact with.
  [[nodiscard]] bool can_apply_force() const {
    const auto of = [&](const SensorParameters<S>& p) {
      return bristle::can_apply_force(p, def.options);
    };
    return def.per_sensor.empty() ? of(def.parameters)
                                  : std::any_of(def.per_sensor.begin(), def.per_sensor.end(), of);
  }
  /// [-] Number of active sensors (nonzero readings).
  [[nodiscard]] std::size_t active_count() const {
    std::size_t count = 0;
    for (const LaneBits bits : active_lanes) count += static_cast<std::size_t>(std::popcount(bits));
    return count;
  }
};

/// Gives all sensors of a patch the same constants. Bristles keep their stretch.
/// @throws InvalidArgument naming the field.
template <Scalar S>
void set_constants(SensorPatch<S>& patch, const SensorParameters<S>& parameters) {
  validate(parameters);
  patch.def.parameters = parameters;
  patch.def.per_sensor.clear();
  patch.def.load = S(0);
}

/// Checks a definition and makes a patch on a body with its centre of mass at `center_B` [m].
/// @throws InvalidArgument naming the field.
template <Scalar S>
[[nodiscard]] SensorPatch<S> make_patch(PatchDef<S> def, BodyId body, const Vec3<S>& center_B) {
  def.sensors.validate();
  const std::size_t n = def.sensors.size();
  require(n > 0, "PatchDef::sensors.size()", n, "must be > 0");
  validate(def.parameters);
  require_enumerator("PatchDef::integration", def.integration, Integration::automatic);
  require_enumerator("PatchOptions::scaling", def.options.scaling, FrictionScaling::none);
  require_enumerator("PatchOptions::law", def.options.law, Law::ambf);
  for (const SensorParameters<S>& p : def.per_sensor) validate(p);
  require(def.per_sensor.empty() || def.per_sensor.size() == n, "PatchDef::per_sensor.size()",
          static_cast<S>(def.per_sensor.size()), "must be 0 or the number of sensors");
  require_not_negative("PatchDef::explicit_below", def.explicit_below);
  require_not_negative("PatchDef::load", def.load);
  require(def.cast_every > 0, "PatchDef::cast_every", def.cast_every, "must be > 0");
  require(def.options.law == Law::paper || def.integration != Integration::implicit,
          "PatchDef::integration", "implicit", "must not be implicit with the AMBF law");

  SensorPatch<S> patch;
  patch.body = body;
  patch.geometry = std::make_shared<const PatchGeometry<S>>(def.sensors, center_B);
  const std::size_t packet_count = patch.geometry->packets.size();
  patch.bristles.resize(packet_count);
  patch.is_anchored.resize(packet_count);
  patch.hit_bits.resize(packet_count);
  patch.active_lanes.resize(packet_count);
  patch.readings.resize(n);
  def.sensors = {};  // The geometry replaces it.
  patch.def = std::move(def);
  return patch;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
