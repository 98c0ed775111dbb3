/// @file
/// Sensors and their contacts, sixteen to a packet: arrays to load registers from.
///
/// A packet holds short arrays, one entry a sensor. The values that a kernel reads of one sensor
/// lie within a few pages, aligned, in the order in which they are read. Long separate arrays would
/// be thirty streams. Sixteen lanes are the widest register there is, so packets look the same for
/// every instruction set. A word of bits tells which lanes take part.
///
/// All vectors are in the axes of A, the body of the patch, where rays stand still.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/math/lane_value.hpp>
#include <bristle/sensors/sensor_constants.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// [-] Ranges that so many packets are cut into, at most. Ranges that threads share are a multiple
/// of four: two and four threads get equal numbers. One range more is a tenth of a sweep over 5000
/// sensors. Above 28 ranges, sizes are rounded up to so few packets that a few ranges may be
/// missing, which matters little then.
[[nodiscard]] inline std::size_t range_count(std::size_t packets) {
  const std::size_t fewest = (packets + chosen::range_packets - 1) / chosen::range_packets;
  return fewest < chosen::fewest_shared_ranges ? fewest : (fewest + 3) / 4 * 4;
}
/// [-] Packets of each range; the last may have fewer.
[[nodiscard]] inline std::size_t packets_per_range(std::size_t packets) {
  const std::size_t fewest = (packets + chosen::range_packets - 1) / chosen::range_packets;
  return fewest < chosen::fewest_shared_ranges
             ? chosen::range_packets
             : (packets + range_count(packets) - 1) / range_count(packets);
}

/// One entry for each sensor of a packet.
template <typename T>
using Row = std::array<T, packet_size>;

/// Lane bits: bit i is sensor i.
using LaneBits = std::uint16_t;

/// Returns which of the sixteen items from `first` on equal `value`. Quick if all do.
template <typename T>
[[nodiscard]] BRISTLE_FORCE_INLINE LaneBits equal_lanes(const T* first, T value) {
  T difference = 0;
  for (std::uint32_t i = 0; i < packet_size; ++i) difference |= first[i] ^ value;
  if (difference == 0) return 0xffffu;
  std::uint32_t bits = 0;
  for (std::uint32_t i = 0; i < packet_size; ++i) bits |= first[i] == value ? 1u << i : 0u;
  return static_cast<LaneBits>(bits);
}

/// Returns which of sixteen bodies from `first` on are `id`. Quick if all are.
[[nodiscard]] BRISTLE_FORCE_INLINE LaneBits equal_lanes(const BodyId* first, BodyId id) {
  std::uint32_t difference = 0;
  for (std::uint32_t i = 0; i < packet_size; ++i) {
    difference |= (first[i].index ^ id.index) | (first[i].generation ^ id.generation);
  }
  if (difference == 0) return 0xffffu;
  std::uint32_t bits = 0;
  for (std::uint32_t i = 0; i < packet_size; ++i) bits |= first[i] == id ? 1u << i : 0u;
  return static_cast<LaneBits>(bits);
}

/// Three rows of coordinates.
template <Scalar S>
struct Row3 {
  Row<S> x, y, z;

  [[nodiscard]] Vec3<S> operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
  void set(std::size_t i, const Vec3<S>& v) {
    x[i] = v.x();
    y[i] = v.y();
    z[i] = v.z();
  }
};

/// Rays of sixteen sensors on their body.
template <Scalar S>
struct alignas(64) RayPacket {
  /// [m] Starts of the rays from A's centre of mass; [1] unit directions and their first tangents
  /// (`tangent_basis`); [1/m] inverse lengths.
  Row3<S> start{}, direction{}, tangent{};
  Row<S> inverse_length{};
};

/// Bristles of sixteen sensors: their memory of where they touched.
template <Scalar S>
struct alignas(64) BristlePacket {
  /// [m] Anchors of the bristles on A in A's axes, on B in B's.
  Row3<S> anchor_a{}, anchor_b{};
};

/// Contacts of up to sixteen neighbouring sensors with one body in one step: bristle stretch and
/// final impulses. The rest follows from the hits (patch_touch.hpp), but for moved linear models.
/// Lanes without contact hold garbage. `PatchContact` explains the rows.
template <Scalar S>
struct alignas(64) ContactPacket {
  /// Leaves the rows as they are: every kernel writes the rows that the next ones read.
  ContactPacket() {}  // NOLINT(modernize-use-equals-default): that would clear them.

  Row3<S> stretch;
  Row3<S> impulse;
  Row<S> normal_impulse;

  /// Models that were moved (`PatchPair::has_moved_models`), and the force they were made for.
  Row3<S> constant;
  Row<S> a_normal, a_across, force;
  /// Slipping sensors only.
  Row3<S> along, last_slip;
  Row<S> a_along;

  /// [-] Index of the packet of sensors.
  std::uint32_t packet = 0;
  /// Lanes in range, in contact at the start, loaded, slipping, and with damped slip. Loaded and
  /// damped lanes are those of the last pass that had another solve left.
  LaneBits is_in_range = 0;
  LaneBits is_in_contact = 0;
  LaneBits is_loaded = 0;
  LaneBits is_slipping = 0;
  LaneBits is_damping_slip = 0;

  /// Resets to sensor packet `number`, without a contact.
  void begin(std::uint32_t number) {
    packet = number;
    is_in_range = is_in_contact = is_loaded = is_slipping = is_damping_slip = 0;
  }
};

/// [-] The bits of a full pack.
template <Scalar S>
inline constexpr std::uint32_t full_pack = (1u << lanes<S>)-1u;

/// Lanes [at, at + lanes) of a packet's bits, as bits of a pack.
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE std::uint32_t pack_bits(LaneBits bits, std::size_t at) {
  return (static_cast<std::uint32_t>(bits) >> at) & full_pack<S>;
}
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Mask<S> load_mask(LaneBits bits, std::size_t at) {
  return Mask<S>::from_bits(pack_bits<S>(bits, at));
}
/// Stores a pack's bits among those of a packet.
template <Scalar S>
BRISTLE_FORCE_INLINE void store_mask(LaneBits& bits, std::size_t at, const Mask<S>& mask) {
  bits = static_cast<LaneBits>((bits & ~(full_pack<S> << at)) | (detail::bits(mask) << at));
}

template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Pack<S> load_pack(const Row<S>& row, std::size_t at) {
  return Pack<S>::load(row.data() + at);
}
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Pack3<S> load_pack(const Row3<S>& row, std::size_t at) {
  return Pack3<S>::load(row.x.data() + at, row.y.data() + at, row.z.data() + at);
}
template <Scalar S>
BRISTLE_FORCE_INLINE void store_pack(Row<S>& row, std::size_t at, const Pack<S>& value) {
  value.store(row.data() + at);
}
template <Scalar S>
BRISTLE_FORCE_INLINE void store_pack(Row3<S>& row, std::size_t at, const Pack3<S>& value) {
  value.store(row.x.data() + at, row.y.data() + at, row.z.data() + at);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
