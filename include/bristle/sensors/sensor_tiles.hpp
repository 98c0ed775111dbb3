/// @file
/// Sensors and their contacts, sixteen to a tile: arrays that registers are loaded from.
///
/// A tile is a structure of short arrays, one entry a sensor. What a kernel reads of one sensor
/// lies within a few pages, aligned, and in the order in which it is read; long separate arrays
/// would be thirty streams. Sixteen lanes are the widest register there is: tiles look the same
/// whatever a file is compiled for. Which lanes take part is a word of bits.
///
/// All vectors are in A's axes, the body of the patch, in which rays stand still.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/slot_map.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/math/lane_value.hpp>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// [-] Sensors of a tile.
inline constexpr std::size_t tile_size = 16;

/// [-] Tiles of a slice at most: sums over a patch are sums of slices' sums (`sum_in_slices`). A
/// sweep over 512 sensors takes about a microsecond, beside which starting and adding up a slice is
/// little.
inline constexpr std::size_t slice_tiles = 32;
/// [-] Slices from which on threads share a sweep: less would be done before the first has heard
/// of it.
inline constexpr std::size_t fewest_shared_slices = 8;

/// [-] In how many slices so many tiles are cut, at most. Those that threads share are a multiple
/// of four, so that two and four threads have the same number each: one slice more is a tenth of a
/// sweep over 5000 sensors. Above 28 slices sizes are rounded up to so few tiles that there may be
/// a few slices less, which is little then.
[[nodiscard]] constexpr std::size_t slice_count(std::size_t tiles) {
  const std::size_t fewest = (tiles + slice_tiles - 1) / slice_tiles;
  return fewest < fewest_shared_slices ? fewest : (fewest + 3) / 4 * 4;
}
/// [-] Tiles of each of them but the last, which may have less.
[[nodiscard]] constexpr std::size_t tiles_per_slice(std::size_t tiles) {
  const std::size_t fewest = (tiles + slice_tiles - 1) / slice_tiles;
  return fewest < fewest_shared_slices ? slice_tiles
                                       : (tiles + slice_count(tiles) - 1) / slice_count(tiles);
}

/// One entry for each sensor of a tile.
template <typename T>
using Row = std::array<T, tile_size>;

/// Lane bits of a tile: bit i is its sensor i.
using LaneBits = std::uint16_t;

/// A body as one number, to be compared in lanes.
[[nodiscard]] inline std::uint64_t root_key(BodyId id) {
  return std::uint64_t(id.generation) << 32 | id.index;
}

/// Which of the sixteen items from `first` on equal `value`. Quick where all do.
template <typename T>
[[nodiscard]] BRISTLE_INLINE LaneBits equal_lanes(const T* first, T value) {
  T difference = 0;
  for (std::uint32_t i = 0; i < tile_size; ++i) difference |= first[i] ^ value;
  if (difference == 0) return 0xffffu;
  std::uint32_t bits = 0;
  for (std::uint32_t i = 0; i < tile_size; ++i) bits |= first[i] == value ? 1u << i : 0u;
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

/// In which bodies the bristles of a tile are rooted (`root_key`). Mostly in one, so that sixteen
/// keys need not be looked at.
struct RootBodies {
  /// That of all lanes, or `several`: each its own.
  std::uint64_t common = several;
  Row<std::uint64_t> own{};

  static constexpr std::uint64_t several = ~std::uint64_t(0);

  [[nodiscard]] std::uint64_t operator[](std::size_t i) const {
    return common == several ? own[i] : common;
  }
  /// Lanes whose key is `key`.
  [[nodiscard]] BRISTLE_INLINE LaneBits lanes_in(std::uint64_t key) const {
    if (common == several) return equal_lanes(own.data(), key);
    return common == key ? 0xffffu : 0u;
  }
  /// Gives some lanes a key. The others keep theirs, if any of them `is_used`.
  void set(LaneBits lanes, std::uint64_t key, bool is_used) {
    if (!is_used || common == key) {
      common = key;
      return;
    }
    if (common != several) own.fill(common);
    common = several;
    for (std::uint32_t rest = lanes; rest != 0; rest &= rest - 1) {
      own[static_cast<std::size_t>(std::countr_zero(rest))] = key;
    }
  }
};

/// Sixteen sensors of a patch, and what their bristles remember.
template <Scalar S>
struct alignas(64) SensorTile {
  /// [m] Starts of the rays from A's centre of mass; [1] unit directions and their first tangents
  /// (`tangent_basis`); [1/m] inverse lengths.
  Row3<S> start{}, direction{}, tangent{};
  Row<S> inverse_length{};
  /// [m] Roots of the bristles on A in A's axes, on B in B's.
  Row3<S> root_a{}, root_b{};
  /// Whether they are rooted, and in which bodies.
  LaneBits is_rooted = 0;
  RootBodies rooted_in{};
};

/// The contacts of up to sixteen neighbouring sensors with one body in one step: how their bristles
/// are stretched, and the impulses they finally gave. All else follows from the hits
/// (patch_touch.hpp), but for linear models that were moved to another motion. Lanes without
/// contact hold anything. See `PatchContact` for what the rows mean.
template <Scalar S>
struct alignas(64) ContactTile {
  /// Leaves the rows as they are: every kernel writes the rows that the next ones read.
  ContactTile() {}  // NOLINT(modernize-use-equals-default): that would clear them.

  Row3<S> stretch;
  Row3<S> impulse;
  Row<S> normal_impulse;

  /// Models that were moved (`PatchPair::has_moved_models`), and the force that they were made for.
  Row3<S> constant;
  Row<S> a_normal, a_across, force;
  /// Of slipping sensors only.
  Row3<S> along, last_slip;
  Row<S> a_along;

  /// [-] Number of the tile of sensors.
  std::uint32_t tile = 0;
  /// Which lanes have a contact; which of these touch, slip, and, as the last pass that had another
  /// solve left saw them, push and slip damped.
  LaneBits is_met = 0;
  LaneBits is_touching = 0;
  LaneBits is_pushing = 0;
  LaneBits is_slipping = 0;
  LaneBits is_damping_slip = 0;

  /// Becomes that of sensor tile `number`, without a contact.
  void begin(std::uint32_t number) {
    tile = number;
    is_met = is_touching = is_pushing = is_slipping = is_damping_slip = 0;
  }
};

namespace detail {

/// [-] The bits of a full pack.
template <Scalar S>
inline constexpr std::uint32_t full_pack = (1u << lanes<S>)-1u;

/// Lanes [at, at + lanes) of a tile's bits, as bits of a pack.
template <Scalar S>
[[nodiscard]] BRISTLE_INLINE std::uint32_t pack_bits(LaneBits bits, std::size_t at) {
  return (static_cast<std::uint32_t>(bits) >> at) & full_pack<S>;
}
template <Scalar S>
[[nodiscard]] BRISTLE_INLINE Mask<S> load_mask(LaneBits bits, std::size_t at) {
  return Mask<S>::from_bits(pack_bits<S>(bits, at));
}
/// Puts a pack's bits in their place among those of a tile.
template <Scalar S>
BRISTLE_INLINE void store_mask(LaneBits& bits, std::size_t at, const Mask<S>& mask) {
  bits = static_cast<LaneBits>((bits & ~(full_pack<S> << at)) | (bristle::bits(mask) << at));
}

template <Scalar S>
[[nodiscard]] BRISTLE_INLINE Pack<S> load_pack(const Row<S>& row, std::size_t at) {
  return Pack<S>::load(row.data() + at);
}
template <Scalar S>
[[nodiscard]] BRISTLE_INLINE Pack3<S> load_pack(const Row3<S>& row, std::size_t at) {
  return Pack3<S>::load(row.x.data() + at, row.y.data() + at, row.z.data() + at);
}
template <Scalar S>
BRISTLE_INLINE void store_pack(Row<S>& row, std::size_t at, const Pack<S>& value) {
  value.store(row.data() + at);
}
template <Scalar S>
BRISTLE_INLINE void store_pack(Row3<S>& row, std::size_t at, const Pack3<S>& value) {
  value.store(row.x.data() + at, row.y.data() + at, row.z.data() + at);
}

}  // namespace detail

}  // namespace bristle::inline BRISTLE_ABI
