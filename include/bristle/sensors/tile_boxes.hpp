/// @file
/// Boxes around the rays of a patch, tile by tile: which of its sensors a small body can be near.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/aabb.hpp>
#include <bristle/geometry/ray.hpp>
#include <bristle/sensors/sensor_tiles.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bristle {

/// One box for each tile and one for each group of tiles, in A's axes from A's centre of mass.
///
/// Tiles are sensors that follow each other in their layout: the better neighbours stand beside
/// each other there, the fewer sensors are looked at.
template <Scalar S>
class TileBoxes {
 public:
  /// [-] Tiles of a group.
  static constexpr std::size_t group_size = 16;

  TileBoxes() = default;
  explicit TileBoxes(const RayBatch<S>& rays) {
    boxes_.resize((rays.size() + tile_size - 1) / tile_size);
    groups_.resize((boxes_.size() + group_size - 1) / group_size);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Ray<S> ray = rays[i];
      boxes_[i / tile_size].include(ray.origin);
      boxes_[i / tile_size].include(Vec3<S>(ray.origin + ray.length * ray.direction));
    }
    for (std::size_t i = 0; i < boxes_.size(); ++i) groups_[i / group_size].include(boxes_[i]);
  }

  /// Makes `tiles` the numbers of those for whose boxes `is_near(box)` is true, ascending. It must
  /// be true of a box around a box of which it is true.
  template <typename IsNear>
  void find(IsNear&& is_near, std::vector<std::uint32_t>& tiles) const {
    tiles.clear();
    for (std::size_t group = 0; group < groups_.size(); ++group) {
      if (!is_near(groups_[group])) continue;
      const std::size_t end = std::min(boxes_.size(), (group + 1) * group_size);
      for (std::size_t i = group * group_size; i < end; ++i) {
        if (is_near(boxes_[i])) tiles.push_back(static_cast<std::uint32_t>(i));
      }
    }
  }

 private:
  std::vector<Aabb<S>> boxes_, groups_;
};

}  // namespace bristle
