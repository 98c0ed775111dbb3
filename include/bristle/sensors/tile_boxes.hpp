/// @file
/// Boxes around the rays of a patch, tile by tile: which of its sensors a small body can be near.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/ray.hpp>
#include <bristle/math/lane_value.hpp>
#include <bristle/sensors/sensor_tiles.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// One box for each tile and one for each group of tiles, in A's axes from A's centre of mass.
///
/// Tiles are sensors that follow each other in their layout: the better neighbours stand beside
/// each other there, the fewer sensors are looked at.
template <Scalar S>
class TileBoxes {
 public:
  /// [-] Tiles of a group.
  static constexpr std::size_t group_size = tile_size;

  TileBoxes() = default;
  explicit TileBoxes(const RayBatch<S>& rays)
      : tiles_((rays.size() + tile_size - 1) / tile_size),
        groups_((tiles_ + group_size - 1) / group_size),
        tile_boxes_(groups_),
        group_boxes_((groups_ + group_size - 1) / group_size) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Ray<S> ray = rays[i];
      const Vec3<S> end = ray.origin + ray.length * ray.direction;
      const std::size_t tile = i / tile_size;
      const std::size_t group = tile / group_size;
      for (const Vec3<S>& point : {ray.origin, end}) {
        tile_boxes_[group].include(tile % group_size, point);
        group_boxes_[group / group_size].include(group % group_size, point);
      }
    }
    if (!tile_boxes_.empty()) tile_boxes_.back().fill_up(tiles_);
    if (!group_boxes_.empty()) group_boxes_.back().fill_up(groups_);
  }

  /// Makes `tiles` the numbers of those whose boxes are near, ascending.
  /// @param is_near  Callable: Mask<S> is_near(lower, upper) of the corners of some boxes as
  ///                 `Pack3`s. Must be true of a box around a box of which it is true.
  template <typename IsNear>
  void find(IsNear&& is_near, std::vector<std::uint32_t>& tiles) const {
    tiles.resize(tiles_);
    auto next = tiles.begin();
    for (std::size_t row = 0; row < group_boxes_.size(); ++row) {
      for_each_near(group_boxes_[row], groups_, row * group_size, is_near, [&](std::size_t group) {
        for_each_near(tile_boxes_[group], tiles_, group * group_size, is_near,
                      [&](std::size_t tile) { *next++ = static_cast<std::uint32_t>(tile); });
      });
    }
    tiles.erase(next, tiles.end());
  }

 private:
  /// The boxes of a group, side by side.
  struct BoxRow {
    Row3<S> lower, upper;

    BoxRow() {
      for (std::size_t i = 0; i < group_size; ++i) {
        lower.set(i, Vec3<S>::Constant(infinity<S>));
        upper.set(i, Vec3<S>::Constant(-infinity<S>));
      }
    }
    void include(std::size_t i, const Vec3<S>& point) {
      lower.set(i, lower[i].cwiseMin(point));
      upper.set(i, upper[i].cwiseMax(point));
    }
    /// Gives the last of all rows numbers behind the last of `count` boxes: infinities would raise
    /// exceptions of arithmetic.
    void fill_up(std::size_t count) {
      for (std::size_t i = (count - 1) % group_size + 1; i < group_size; ++i) {
        lower.set(i, Vec3<S>::Zero());
        upper.set(i, Vec3<S>::Zero());
      }
    }
  };

  /// Calls visit(number) for the near boxes of a row, of which the first has the number `first`.
  /// @param count  [-] Boxes of all rows.
  template <typename IsNear, typename Visit>
  static void for_each_near(const BoxRow& row, std::size_t count, std::size_t first,
                            IsNear&& is_near, Visit&& visit) {
    std::uint32_t near = 0;
    for (std::size_t at = 0; at < group_size; at += lanes<S>) {
      near |= bits(is_near(detail::load_pack(row.lower, at), detail::load_pack(row.upper, at)))
              << at;
    }
    near &= (std::uint32_t(1) << std::min(count - first, group_size)) - 1;
    if (near == first_bits(group_size)) {
      // In the midst of what is near, where no number has to wait for the bits of another.
      for (std::size_t i = 0; i < group_size; ++i) visit(first + i);
      return;
    }
    for (; near != 0; near &= near - 1) {
      visit(first + static_cast<std::size_t>(std::countr_zero(near)));
    }
  }

  std::size_t tiles_ = 0;
  std::size_t groups_ = 0;
  std::vector<BoxRow> tile_boxes_, group_boxes_;
};

}  // namespace bristle::inline BRISTLE_ABI
