/// @file
/// The final readings of a patch: impulses become forces in the frames of its sensors.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/finite.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_block.hpp>
#include <bristle/sensors/patch_scratch.hpp>
#include <bristle/sensors/patch_touch.hpp>

#include <bit>
#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// Turns the impulses of all contacts into readings.
/// @param origin   [m] A's centre of mass in the world.
/// @param find_id  Callable: BodyId find_id(slot).
/// @param parallel_for  Shares the contacts of a large patch; the readings are the same bits.
/// @return Number of sensors of depth 1.
template <Scalar S, typename FindId>
std::size_t fill_readings(SensorPatch<S>& patch, PatchScratch<S>& scratch, const Vec3<S>& origin,
                          S dt, FindId&& find_id, const ParallelFor& parallel_for = serial_for);

// Implementation ----------------------------------------------------------------------------------

/// Writes `value` into the lanes of `mask`. The other lanes become 0, or stay if `keeps`.
template <Scalar S>
BRISTLE_FORCE_INLINE void put(S* row, const Mask<S>& mask, const Pack<S>& value, bool keeps) {
  select(mask, value, keeps ? Pack<S>::load(row) : Pack<S>(S(0))).store(row);
}

/// Clears the forces of a pack of sensors.
template <Scalar S>
BRISTLE_FORCE_INLINE void clear_pack(ReadingStore<S>& out, std::size_t i) {
  const Pack<S> nothing = S(0);
  nothing.store(out.depth.data() + i);
  nothing.store(out.normal_force.data() + i);
  nothing.store(out.shear_1.data() + i);
  nothing.store(out.shear_2.data() + i);
}

/// Forces of contacts on A, in its axes: their wrench, and their part across the rays; and how many
/// sensors can give no more.
template <Scalar S>
struct ReadingSum {
  LaneWrench<S> all{};
  Pack3<S> shear = zero_vector<Pack<S>>();
  /// [-] Sensors of depth 1 among them.
  std::size_t bottomed_out = 0;

  ReadingSum& operator+=(const ReadingSum& more) {
    all += more.all;
    shear += more.shear;
    bottomed_out += more.bottomed_out;
    return *this;
  }
};

/// Writes readings of one packet's contacts on `id`. Adds their forces to `sum`.
template <Scalar S>
BRISTLE_FORCE_INLINE void read_packet(SensorPatch<S>& patch, const RayHits<S>& hits,
                                      const PatchPair<S>& pair, const ContactPacket<S>& packet,
                                      const Vec3<S>& origin, S per_step, BodyId id,
                                      ReadingSum<S>& sum) {
  using T = Pack<S>;
  const RayPacket<S>& rays = patch.geometry->packets[packet.packet];
  ReadingStore<S>& out = patch.readings;
  // One packet can be in contact with two bodies.
  const bool is_shared = patch.active_lanes[packet.packet] != 0;
  const std::size_t first = packet.packet * packet_size;
  std::uint32_t active = 0;
  std::uint32_t whole = 0;
  for (std::size_t at = 0; at < packet_size; at += lanes<S>) {
    const std::size_t i = first + at;
    if (pack_bits<S>(packet.is_in_range, at) == 0) {
      if (!is_shared) clear_pack(out, i);
      continue;
    }
    const Pack3<S> n = load_pack(rays.direction, at);
    const Pack3<S> t1 = load_pack(rays.tangent, at);
    const Mask<S> is_in_range = load_mask<S>(packet.is_in_range, at);
    const T distance = distances_of(hits, i, is_in_range);
    const Pack3<S> point = load_pack(rays.start, at) + distance * n;
    const Pack3<S> force = T(-per_step) * load_pack(packet.impulse, at);
    const T normal = load_pack(packet.normal_impulse, at) * T(per_step);
    const Pack3<S> shear = tangential<T>(force, n);
    const Mask<S> is_in_contact = load_mask<S>(packet.is_in_contact, at);
    // A sensor that gave an impulse is active. If it came into contact within the step and the
    // passes ran out, only the part across the ray is left.
    const Mask<S> is_active_lane =
        is_in_contact | (is_in_range & ((normal > T(S(0))) | (dot(shear, shear) > T(S(0)))));
    active |= bits(is_active_lane) << at;
    const Pack3<S> active_force = select(is_active_lane, force, zero_vector<T>());
    sum.all.force += active_force;
    sum.all.torque += cross(point, active_force);
    sum.shear += select(is_active_lane, shear, zero_vector<T>());
    const T depth =
        select(is_in_contact, sensor_depth(distance, load_pack(rays.inverse_length, at)), T(S(0)));
    whole |= bits(is_active_lane & (depth >= T(S(1)))) << at;
    put(out.depth.data() + i, is_active_lane, depth, is_shared);
    put(out.normal_force.data() + i, is_active_lane, normal, is_shared);
    put(out.shear_1.data() + i, is_active_lane, dot(t1, shear), is_shared);
    put(out.shear_2.data() + i, is_active_lane, dot(cross(n, t1), shear), is_shared);
    const Pack3<S> point_W = pair.R_WA * point + Pack3<S>::all(origin);
    // Points of inactive sensors stay.
    const bool keeps_some = !all(is_active_lane);
    put(out.point.x.data() + i, is_active_lane, point_W.x, keeps_some);
    put(out.point.y.data() + i, is_active_lane, point_W.y, keeps_some);
    put(out.point.z.data() + i, is_active_lane, point_W.z, keeps_some);
  }
  if (whole != 0) sum.bottomed_out += static_cast<std::size_t>(std::popcount(whole));
  BodyId* body = out.body.data() + first;
  SensorState* state = out.state.data() + first;
  for (std::size_t lane = 0; lane < packet_size; ++lane) {
    const bool is_active_lane = (active >> lane & 1u) != 0;
    const SensorState own =
        (packet.is_slipping >> lane & 1u) != 0 ? SensorState::slipping : SensorState::stuck;
    const BodyId other_body = is_shared ? body[lane] : BodyId{};
    const SensorState other_state = is_shared ? state[lane] : SensorState::free;
    body[lane] = is_active_lane ? id : other_body;
    state[lane] = is_active_lane ? own : other_state;
  }
  patch.active_lanes[packet.packet] =
      static_cast<LaneBits>(patch.active_lanes[packet.packet] | active);
}

/// Adds the readings of a pair's contacts on `id`. The function is apart from `fill_readings`, so
/// that it is compiled once for all callers.
/// @param sensed  Gets the forces of the pair.
/// @return Number of sensors of depth 1.
template <Scalar S>
std::size_t read_pair(SensorPatch<S>& patch, PatchScratch<S>& scratch, const PatchPair<S>& pair,
                      const Vec3<S>& origin, S per_step, BodyId id, SensedBody<S>& sensed,
                      const ParallelFor& parallel_for) {
  using Sum = ReadingSum<S>;
  const auto read = [&] {
    return sum_of_contacts<Sum>(contacts_of(scratch, pair), parallel_for,
                                [&](std::span<ContactPacket<S>> packets, Sum& part) {
                                  Sum own;
                                  for (const ContactPacket<S>& packet : packets) {
                                    read_packet(patch, scratch.hits, pair, packet, origin, per_step,
                                                id, own);
                                  }
                                  part = own;
                                });
  };
  Sum sum = read();
  Wrench<S> on_a = sum.all.in_world(pair);
  if (!has_finite_square(on_a.force) || !has_finite_square(on_a.torque)) {
    // Far from the centre of mass a moment can overflow where no force does. No velocity can
    // follow it, so nothing was applied.
    clear_impulses(scratch, pair);
    sum = read();
    on_a = {};
  }
  sensed.on_a = on_a;
  sensed.shear_W = pair.R_WA * sum_of_lanes(sum.shear);
  patch.readings.wrench += sensed.on_a;
  patch.readings.shear_W += sensed.shear_W;
  return sum.bottomed_out;
}

template <Scalar S, typename FindId>
std::size_t fill_readings(SensorPatch<S>& patch, PatchScratch<S>& scratch, const Vec3<S>& origin,
                          S dt, FindId&& find_id, const ParallelFor& parallel_for) {
  ReadingStore<S>& out = patch.readings;
  patch.was_active = !scratch.pairs.empty();
  std::swap(patch.active_lanes, scratch.active_before);
  std::fill(patch.active_lanes.begin(), patch.active_lanes.end(), LaneBits(0));
  out.wrench = {};
  set_zero(out.shear_W);
  std::size_t bottomed_out = 0;
  // A pair without a contact is not among the sensed bodies, and gives nothing.
  SensedBody<S>* sensed = patch.sensed.begin();
  for (const PatchPair<S>& pair : scratch.pairs) {
    if (pair.count == 0) continue;
    BRISTLE_ASSERT(sensed != patch.sensed.end() && sensed->body == pair.body_b);
    bottomed_out += read_pair(patch, scratch, pair, origin, S(1) / dt, find_id(pair.body_b),
                              *sensed++, parallel_for);
  }
  for (std::size_t i = 0; i < patch.active_lanes.size(); ++i) {
    if (patch.active_lanes[i] == 0 && scratch.active_before[i] != 0) out.clear_packet(i);
  }
  return bottomed_out;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
