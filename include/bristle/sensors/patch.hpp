/// @file
/// A patch: many resistive sensors on one body, as structures of arrays, with their state.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/fill_numbers.hpp>
#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/contacts/triangle_cache.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/patch_def.hpp>
#include <bristle/sensors/patch_geometry.hpp>
#include <bristle/sensors/plane_cache.hpp>
#include <bristle/sensors/reading_store.hpp>
#include <bristle/sensors/sensor_packets.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace bristle::inline BRISTLE_ABI::detail {

/// One sensor that meets a body in this step: geometry, the linear model of its impulse, and the
/// resulting impulse. In A's axes; c belongs to its `PatchPair`. Patches work on
/// PatchContact<Pack<S>>. `ContactPacket`s store the values that cannot be recomputed.
template <Value T>
struct PatchContact {
  /// Lanes in contact at the start of the step (else maybe within it), loaded (normal part acts),
  /// slipping in this step, and with damped slip.
  Truth<T> is_touching{};
  Truth<T> is_pushing{};
  Truth<T> is_slipping{};
  Truth<T> is_damping_slip{};
  /// [1] Ray direction n and depth gradient g.
  Vector3<T> n, g;
  /// [m] From c to the contact point.
  Vector3<T> rho;
  /// [m] Stretch at the start of the step.
  Vector3<T> stretch;
  /// [m/s] Relative velocity at the start of the step, and tangential one of the last pass.
  Vector3<T> start_velocity, last_slip;
  /// [1], [1/m] Depth at the start of the step and inverse length of the ray.
  T depth, inverse_length;
  /// [N] Normal force behind this pass's friction.
  T force;

  /// Impulse on B as a function of the relative velocity v at the end of the step: constant +
  /// a_normal (g.v) g + a_across v_T + (a_along - a_across) (along.v) along. The part with a_normal
  /// acts under load.
  Vector3<T> constant, along;
  T normal_constant, a_normal, a_across, a_along;

  /// [N s] Impulses on B: of the normal part, and of the whole contact.
  T normal_impulse;
  Vector3<T> impulse;
};

/// Sum of the stiffness of a pair's contacts, about the middle of the patch's box.
template <Scalar S>
struct PairStiffness {
  /// [N/m], [N s/m] Of the bristles in contact.
  S bristle_sum = S(0), viscous_sum = S(0);
  /// [kg] Sums of s, of s rho, of s rho^2 (`measure_pair`), across the rays and along them.
  S tangential = S(0), normal = S(0);
  Vec3<S> tangential_first = zero<Vec3<S>>(), normal_first = zero<Vec3<S>>();
  S tangential_second = S(0), normal_second = S(0);
};

/// A patch's contacts with one body in one step.
template <Scalar S>
struct PatchPair {
  /// [-] Index of body B; its contact packets are [first, first + count).
  std::uint32_t body_b = 0;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  /// [-] Axes of A in the world, and the pose of B relative to A.
  Mat3<S> R_WA = identity<Mat3<S>>();
  PairPose<S> pose{};
  /// [m/s, rad/s] Motion of A relative to B at the start of the step, about A's centre of mass, in
  /// A's axes.
  Twist<S> start_motion{};
  /// [m] Reference point c from A's centre of mass in A's axes, and from each centre of mass in
  /// world axes.
  Vec3<S> center = zero<Vec3<S>>();
  Vec3<S> arm_a = zero<Vec3<S>>();
  Vec3<S> arm_b = zero<Vec3<S>>();
  PairStiffness<S> stiffness{};
  /// [N s, N m s] Impulse on B about c in A's axes, if it was applied with the contacts.
  bool is_applied = false;
  Wrench<S> given{};
  /// [1] Lambda of these contacts alone, if requested (`CollectDef`).
  S lambda = S(0);
  bool is_implicit = false;
  /// [1] Weights of the implicit scheme (docs/sensors.md).
  S alpha = S(1);
  S beta = S(0);
  S theta = S(1);
  /// True if its linear models were moved to a solved motion; its packets keep those. The first
  /// models, around the motion at the start of the step, follow from the hits and the stretch.
  bool has_moved_models = false;
  /// [-] Sum of the contacts' linear models about c, in A's axes: impulse = offset + matrix u.
  Mat6<S> matrix = zero<Mat6<S>>();
  Vec6<S> offset = zero<Vec6<S>>();
  /// [-] Its index among soft blocks, when implicit.
  std::uint32_t soft = 0;
};

/// Impulse of an implicit pair in the last step: its warm start in this one.
template <Scalar S>
struct PairImpulse {
  BodyId body{};
  /// [N s; N m s] On B about the pair's point c, world axes.
  Vec6<S> impulse = zero<Vec6<S>>();
};

/// A shape that rays hit in this step, and the pair of its body.
struct TouchedShape {
  std::uint32_t tag = 0;
  std::uint32_t pair = 0;
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
  /// Bristles, a packet for each of the geometry's.
  DynamicArray<BristlePacket<S>> bristles;
  /// False if the patch is off and senses nothing.
  bool is_active = true;

  /// Hits of this step, by ray. Valid in the packets that can be near anything, whose numbers are
  /// listed in ascending order; all packets until they were tested. Also contacts and pairs.
  RayHits<S> hits{};
  DynamicArray<std::uint32_t> near;
  PlaneCache<S> plane_cache{};
  /// Lanes of each packet that hit anything in this step, and in the one before.
  DynamicArray<LaneBits> hit_bits, hit_before;
  DynamicArray<TouchedShape> touched;
  /// Of the current pair: lanes of a near packet that hit its body, and the first contact of each
  /// range of near packets.
  DynamicArray<LaneBits> pair_bits;
  DynamicArray<std::uint32_t> range_contacts;
  DynamicArray<ContactPacket<S>> contacts;
  DynamicArray<PatchPair<S>> pairs;
  DynamicArray<PairImpulse<S>> last_impulses;
  /// Active sensors of each packet: those with nonzero readings.
  DynamicArray<LaneBits> felt, active_before;
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
  /// Its rays, each longer by `extra_length` [m]. Only those of the near packets need a result.
  [[nodiscard]] RayBatch<S> near_rays(S extra_length) const {
    RayBatch<S> batch = geometry->rays(extra_length);
    batch.near_packets = &near;
    return batch;
  }
  /// [m] Distances of the hits from sensor `first` on; 0 in the lanes outside `asked`.
  [[nodiscard]] BRISTLE_FORCE_INLINE Pack<S> distances_of(std::size_t first,
                                                          const Mask<S>& asked) const {
    return select(asked, Pack<S>::load(hits.distance.data() + first), Pack<S>(S(0)));
  }
  /// [-] Sensors of the near packets.
  [[nodiscard]] std::size_t near_count() const {
    const std::size_t all = near.size() * packet_size;
    // Only the last packet may have unused lanes.
    const bool has_last = !near.empty() && near.back() + 1 == bristles.size();
    return has_last ? all - (bristles.size() * packet_size - size()) : all;
  }
  /// [-] First packet of a range, and one behind its last, which may be padded where the range is
  /// not. Only for ranges of whole packets (`RayTree::has_packets_in_ranges`), or for all sensors.
  [[nodiscard]] std::array<std::size_t, 2> packets_in(RayRange range) const {
    const std::size_t end = range.end / packet_size + (range.end % packet_size != 0 ? 1u : 0u);
    return {range.first / packet_size, std::min(bristles.size(), end)};
  }
  /// [-] Near packets of the range.
  [[nodiscard]] std::span<const std::uint32_t> near_in(RayRange range) const {
    const auto [begin, end] = packets_in(range);
    const auto first = std::lower_bound(near.begin(), near.end(), begin);
    return {first, std::lower_bound(first, near.end(), end)};
  }
  /// Clears the hits of a range's near packets.
  void reset_near_hits(RayRange range = {}) {
    for (const std::uint32_t packet : near_in(range)) {
      const auto first = static_cast<std::ptrdiff_t>(packet * packet_size);
      std::fill_n(hits.distance.begin() + first, packet_size, infinity<S>);
    }
  }
  /// [-] Number of active sensors (nonzero readings).
  [[nodiscard]] std::size_t active_count() const {
    std::size_t count = 0;
    for (const LaneBits bits : felt) count += static_cast<std::size_t>(std::popcount(bits));
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
  patch.hits.reset(packet_count * packet_size);
  patch.hit_bits.resize(packet_count);
  patch.hit_before.resize(packet_count);
  patch.pair_bits.resize(packet_count);
  patch.range_contacts.resize(range_count(packet_count));
  patch.near.resize(packet_count);
  fill_numbers(patch.near);
  patch.contacts.reserve(packet_count);
  patch.felt.resize(packet_count);
  patch.active_before.resize(packet_count);
  patch.readings.resize(n);
  def.sensors = {};  // The geometry replaces it.
  patch.def = std::move(def);
  return patch;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
