/// @file
/// What a patch finally reads: impulses become forces in the frames of its sensors.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/finite.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_block.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Turns the impulses of all contacts into readings.
/// @param origin   [m] A's centre of mass in the world.
/// @param find_id  Callable: BodyId find_id(slot).
/// @param parallel_for  Shares the contacts of a large patch; the readings are the same bits.
template <Scalar S, typename FindId>
void fill_readings(SensorPatch<S>& patch, const Vec3<S>& origin, S dt, FindId&& find_id,
                   const ParallelFor& parallel_for = serial_for);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// Writes `value` into the lanes of `mask`; the others become 0 or keep what was there.
template <Scalar S>
BRISTLE_INLINE void put(S* row, const Mask<S>& mask, const Pack<S>& value, bool keeps) {
  select(mask, value, keeps ? Pack<S>::load(row) : Pack<S>(S(0))).store(row);
}

/// Makes a pack of sensors read no forces.
template <Scalar S>
BRISTLE_INLINE void clear_pack(ReadingStore<S>& out, std::size_t i) {
  const Pack<S> nothing = S(0);
  nothing.store(out.depth.data() + i);
  nothing.store(out.normal_force.data() + i);
  nothing.store(out.shear_1.data() + i);
  nothing.store(out.shear_2.data() + i);
}

/// Forces on A of contacts, in its axes: their wrench, and their part across the rays.
template <Scalar S>
struct ReadingSum {
  LaneWrench<S> all{};
  Pack3<S> shear = zero_vector<Pack<S>>();

  ReadingSum& operator+=(const ReadingSum& more) {
    all += more.all;
    shear += more.shear;
    return *this;
  }
};

/// Readings of the contacts of one tile on the body `id`, with their forces added to `sum`.
template <Scalar S>
BRISTLE_INLINE void read_tile(SensorPatch<S>& patch, const PatchPair<S>& pair,
                              const ContactTile<S>& tile, const Vec3<S>& origin, S per_step,
                              BodyId id, ReadingSum<S>& sum) {
  using T = Pack<S>;
  const SensorTile<S>& sensors = patch.tiles[tile.tile];
  ReadingStore<S>& out = patch.readings;
  // Two bodies can be touched by sensors of one tile.
  const bool is_shared = patch.felt[tile.tile] != 0;
  const std::size_t first = tile.tile * tile_size;
  std::uint32_t felt = 0;
  for (std::size_t at = 0; at < tile_size; at += lanes<S>) {
    const std::size_t i = first + at;
    if (pack_bits<S>(tile.is_met, at) == 0) {
      if (!is_shared) clear_pack(out, i);
      continue;
    }
    const Pack3<S> n = load_pack(sensors.direction, at);
    const Pack3<S> t1 = load_pack(sensors.tangent, at);
    const Mask<S> is_met = load_mask<S>(tile.is_met, at);
    const T distance = patch.distances_of(i, is_met);
    const Pack3<S> point = load_pack(sensors.start, at) + distance * n;
    const Pack3<S> force = T(-per_step) * load_pack(tile.impulse, at);
    const T normal = load_pack(tile.normal_impulse, at) * T(per_step);
    const Pack3<S> shear = tangential<T>(force, n);
    const Mask<S> is_touching = load_mask<S>(tile.is_touching, at);
    // What gave an impulse is felt: in the step of a first touch also where the passes ran out, and
    // only what acts across the ray is left of it.
    const Mask<S> is_felt =
        is_touching | (is_met & ((normal > T(S(0))) | (dot(shear, shear) > T(S(0)))));
    felt |= bits(is_felt) << at;
    const Pack3<S> felt_force = select(is_felt, force, zero_vector<T>());
    sum.all.force += felt_force;
    sum.all.torque += cross(point, felt_force);
    sum.shear += select(is_felt, shear, zero_vector<T>());
    const T depth =
        select(is_touching, sensor_depth(distance, load_pack(sensors.inverse_length, at)), T(S(0)));
    put(out.depth.data() + i, is_felt, depth, is_shared);
    put(out.normal_force.data() + i, is_felt, normal, is_shared);
    put(out.shear_1.data() + i, is_felt, dot(t1, shear), is_shared);
    put(out.shear_2.data() + i, is_felt, dot(cross(n, t1), shear), is_shared);
    const Pack3<S> point_W = pair.R_WA * point + Pack3<S>::all(origin);
    // Points stay where nothing is felt.
    const bool keeps_some = !all(is_felt);
    put(out.point.x.data() + i, is_felt, point_W.x, keeps_some);
    put(out.point.y.data() + i, is_felt, point_W.y, keeps_some);
    put(out.point.z.data() + i, is_felt, point_W.z, keeps_some);
  }
  BodyId* body = out.body.data() + first;
  SensorState* state = out.state.data() + first;
  for (std::size_t lane = 0; lane < tile_size; ++lane) {
    const bool is_felt = (felt >> lane & 1u) != 0;
    const SensorState own =
        (tile.is_slipping >> lane & 1u) != 0 ? SensorState::slipping : SensorState::stuck;
    const BodyId other_body = is_shared ? body[lane] : BodyId{};
    const SensorState other_state = is_shared ? state[lane] : SensorState::free;
    body[lane] = is_felt ? id : other_body;
    state[lane] = is_felt ? own : other_state;
  }
  patch.felt[tile.tile] = static_cast<LaneBits>(patch.felt[tile.tile] | felt);
}

}  // namespace detail

template <Scalar S, typename FindId>
void fill_readings(SensorPatch<S>& patch, const Vec3<S>& origin, S dt, FindId&& find_id,
                   const ParallelFor& parallel_for) {
  ReadingStore<S>& out = patch.readings;
  patch.has_felt = !patch.pairs.empty();
  std::swap(patch.felt, patch.felt_before);
  std::fill(patch.felt.begin(), patch.felt.end(), LaneBits(0));
  out.wrench = {};
  out.shear_W.setZero();
  for (const PatchPair<S>& pair : patch.pairs) {
    const BodyId id = find_id(pair.body_b);
    using Sum = detail::ReadingSum<S>;
    const auto read = [&] {
      return detail::sum_of_contacts<Sum>(detail::contacts_of(patch, pair), parallel_for,
                                          [&](std::span<ContactTile<S>> tiles, Sum& part) {
                                            Sum own;
                                            for (const ContactTile<S>& tile : tiles) {
                                              detail::read_tile(patch, pair, tile, origin,
                                                                S(1) / dt, id, own);
                                            }
                                            part = own;
                                          });
    };
    Sum sum = read();
    Wrench<S> on_a = sum.all.in_world(pair);
    if (!has_finite_square(on_a.force) || !has_finite_square(on_a.torque)) {
      // Far from the centre of mass a moment can overflow where no force does. No velocity can
      // follow it, and so nothing was given.
      clear_impulses(patch, pair);
      sum = read();
      on_a = {};
    }
    out.wrench += on_a;
    out.shear_W += pair.R_WA * sum_of_lanes(sum.shear);
  }
  for (std::size_t i = 0; i < patch.felt.size(); ++i) {
    if (patch.felt[i] == 0 && patch.felt_before[i] != 0) out.clear_tile(i);
  }
}

}  // namespace bristle::inline BRISTLE_ABI
