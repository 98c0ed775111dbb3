/// @file
/// Boxes around the rays of a patch, packet by packet: they find the sensors that a body can be
/// near.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/math/lane_value.hpp>
#include <bristle/sensors/sensor_packets.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// One box for each packet and one for each group of packets, in A's axes from A's centre of mass.
///
/// A packet holds consecutive sensors of the layout. Closer neighbours there mean fewer tests.
template <Scalar S>
class PacketBoxes {
 public:
  /// [-] Packets of a group.
  static constexpr std::size_t group_size = packet_size;

  PacketBoxes() = default;
  explicit PacketBoxes(const RayBatch<S>& rays)
      : packets_((rays.size() + packet_size - 1) / packet_size),
        groups_((packets_ + group_size - 1) / group_size),
        packet_boxes_(groups_),
        group_boxes_((groups_ + group_size - 1) / group_size) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Ray<S> ray = rays[i];
      const Vec3<S> end = ray.origin + ray.length * ray.direction;
      const std::size_t packet = i / packet_size;
      const std::size_t group = packet / group_size;
      for (const Vec3<S>& point : {ray.origin, end}) {
        packet_boxes_[group].include(packet % group_size, point);
        group_boxes_[group / group_size].include(group % group_size, point);
      }
    }
    if (!packet_boxes_.empty()) packet_boxes_.back().fill_up(packets_);
    if (!group_boxes_.empty()) group_boxes_.back().fill_up(groups_);
  }

  /// Sets `packets` to the indices of the packets whose boxes are near, ascending.
  /// @param is_near  Callable: Mask<S> is_near(lower, upper) of the corners of some boxes as
  ///                 `Pack3`s. Where true of a box, it must be true of any box around it.
  template <typename IsNear>
  void find(IsNear&& is_near, DynamicArray<std::uint32_t>& packets) const {
    packets.resize(packets_);
    auto next = packets.begin();
    for (std::size_t row = 0; row < group_boxes_.size(); ++row) {
      for_each_near(group_boxes_[row], groups_, row * group_size, is_near, [&](std::size_t group) {
        for_each_near(packet_boxes_[group], packets_, group * group_size, is_near,
                      [&](std::size_t packet) { *next++ = static_cast<std::uint32_t>(packet); });
      });
    }
    packets.erase(next, packets.end());
  }

 private:
  /// The boxes of a group, side by side.
  struct BoxRow {
    Row3<S> lower, upper;

    BoxRow() {
      for (std::size_t i = 0; i < group_size; ++i) {
        lower.set(i, filled<Vec3<S>>(infinity<S>));
        upper.set(i, filled<Vec3<S>>(-infinity<S>));
      }
    }
    void include(std::size_t i, const Vec3<S>& point) {
      lower.set(i, cwise_min(lower[i], point));
      upper.set(i, cwise_max(upper[i], point));
    }
    /// Fills the unused entries of the last row, behind `count` boxes, with finite numbers.
    /// Infinities would raise floating-point exceptions.
    void fill_up(std::size_t count) {
      for (std::size_t i = (count - 1) % group_size + 1; i < group_size; ++i) {
        lower.set(i, zero<Vec3<S>>());
        upper.set(i, zero<Vec3<S>>());
      }
    }
  };

  /// Calls visit(index) for the near boxes of a row. Its first box has the index `first`.
  /// @param count  [-] Boxes of all rows.
  template <typename IsNear, typename Visit>
  static void for_each_near(const BoxRow& row, std::size_t count, std::size_t first,
                            IsNear&& is_near, Visit&& visit) {
    std::uint32_t near = 0;
    for (std::size_t at = 0; at < group_size; at += lanes<S>) {
      near |= bits(is_near(load_pack(row.lower, at), load_pack(row.upper, at))) << at;
    }
    near &= (std::uint32_t(1) << std::min(count - first, group_size)) - 1;
    if (near == first_bits(group_size)) {
      // All boxes of the row are near: no index has to wait for the bits of another.
      for (std::size_t i = 0; i < group_size; ++i) visit(first + i);
      return;
    }
    for (; near != 0; near &= near - 1) {
      visit(first + static_cast<std::size_t>(std::countr_zero(near)));
    }
  }

  std::size_t packets_ = 0;
  std::size_t groups_ = 0;
  DynamicArray<BoxRow> packet_boxes_, group_boxes_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
