/// @file
/// What a patch finds and needs within one step: hits, contacts, and pairs. It is no state: worlds
/// that are stepped in turn share it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/fill_numbers.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/sensor_packets.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// One sensor that meets a body in this step: geometry, the linear model of its impulse, and the
/// resulting impulse. In A's axes; c belongs to its `PatchPair`. Patches work on
/// PatchContact<Pack<S>>. `ContactPacket`s store the values that cannot be recomputed.
template <Value T>
struct PatchContact {
  /// Lanes in contact at the start of the step (else maybe within it), loaded (normal part acts),
  /// slipping in this step, and with damped slip.
  Truth<T> is_in_contact{};
  Truth<T> is_loaded{};
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
  Wrench<S> applied{};
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

/// A shape that rays hit in this step, and the pair of its body.
struct TouchedShape {
  std::uint32_t tag = 0;
  std::uint32_t pair = 0;
};

/// Scratch memory of a patch. Arrays have one entry a sensor unless said otherwise.
template <Scalar S>
struct PatchScratch {
  /// Rays of the patch that it serves (`begin`).
  const PatchGeometry<S>* geometry = nullptr;
  /// Numbers of the packets that can be near anything, ascending. Hits, contacts and pairs are
  /// theirs.
  DynamicArray<std::uint32_t> near;
  RayHits<S> hits{};
  /// Lanes of each packet that hit anything in the step before.
  DynamicArray<LaneBits> hit_before;
  DynamicArray<TouchedShape> touched;
  /// Of the current pair: lanes of a near packet that hit its body, and the first contact of each
  /// range of near packets.
  DynamicArray<LaneBits> pair_bits;
  DynamicArray<std::uint32_t> range_contacts;
  DynamicArray<ContactPacket<S>> contacts;
  DynamicArray<PatchPair<S>> pairs;
  /// Lanes of each packet that were active in the step before.
  DynamicArray<LaneBits> active_before;

  /// Makes room for a patch, and removes its pairs. Allocates only for a patch that is larger than
  /// all before.
  void begin(const SensorPatch<S>& patch) {
    geometry = patch.geometry.get();
    pairs.clear();
    const std::size_t packets = packet_count();
    if (hits.distance.size() == packets * packet_size) return;
    hit_before.resize(packets);
    active_before.resize(packets);
    pair_bits.resize(packets);
    range_contacts.resize(range_count(packets));
    contacts.reserve(packets);
    near.reserve(packets);
    hits.reset(packets * packet_size);  // Last: its size tells that the others have theirs.
  }
  /// Lists all packets as near.
  void list_all() {
    near.resize(packet_count());
    fill_numbers(near);
  }
  [[nodiscard]] std::size_t packet_count() const { return geometry->packets.size(); }
  /// Its rays, each longer by `extra_length` [m]. Only those of the near packets need a result.
  [[nodiscard]] RayBatch<S> near_rays(S extra_length) const {
    RayBatch<S> batch = geometry->rays(extra_length);
    batch.near_packets = &near;
    return batch;
  }
  /// [-] Sensors of the near packets.
  [[nodiscard]] std::size_t near_count() const {
    const std::size_t all = near.size() * packet_size;
    // Only the last packet may have unused lanes.
    const bool has_last = !near.empty() && near.back() + 1 == packet_count();
    return has_last ? all - (packet_count() * packet_size - geometry->size()) : all;
  }
  /// [-] First packet of a range, and one behind its last, which may be padded where the range is
  /// not. Only for ranges of whole packets (`RayTree::has_packets_in_ranges`), or for all sensors.
  [[nodiscard]] std::array<std::size_t, 2> packets_in(RayRange range) const {
    const std::size_t end = range.end / packet_size + (range.end % packet_size != 0 ? 1u : 0u);
    return {range.first / packet_size, std::min(packet_count(), end)};
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
};

}  // namespace bristle::inline BRISTLE_ABI::detail
