/// @file
/// An order of sensors in which neighbours follow each other, for layouts whose order means
/// nothing.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/core/refill.hpp>
#include <bristle/geometry/rays/ray_bundles.hpp>
#include <bristle/sensors/sensor_layout.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// The numbers of a layout's sensors, neighbours after neighbours: four rows of four, four such
/// squares, and so on, as far as their number and places allow.
///
/// A patch takes its sensors sixteen at a time, in the order of their layout. The edge of a contact
/// runs through most of the rows of sixteen that it meets, but through few squares: in squares a
/// pad of 1000 to 10,000 sensors that half touches a box, a ball or a capsule takes 4 to 16 % less
/// time, one of a hundred up to 14 % more (docs/decisions/0031-order-of-sensors.md). Readings are
/// in the order of the layout, so this is for skins that are read as sums or by a table of sensors;
/// images want rows (`tactile_image`). What else goes by the layout, as `PatchDef::per_sensor`, has
/// to follow.
///
/// @throws InvalidArgument when the layout breaks a rule of `SensorLayout::validate`.
/// @note O(n log n).
template <Scalar S>
[[nodiscard]] std::vector<std::uint32_t> neighbour_order(const SensorLayout<S>& layout);

/// The sensors of a layout in another order: the k-th is `layout`'s sensor order[k]. Some may be
/// left out or be there twice.
/// @throws InvalidArgument when the layout is not valid, or a number is not that of a sensor.
template <Scalar S>
[[nodiscard]] SensorLayout<S> in_order(const SensorLayout<S>& layout,
                                       std::span<const std::uint32_t> order);

// Implementation -----------------------------------------------------------------------------------

template <Scalar S>
std::vector<std::uint32_t> neighbour_order(const SensorLayout<S>& layout) {
  layout.validate();
  const RayBundles<S> bundles(layout.rays());
  std::vector<std::uint32_t> order(layout.size());
  if (bundles.is_empty()) {
    detail::fill_numbers(order);  // No sensors, or rays without an end.
  } else {
    std::copy_n(bundles.rays_from(0), order.size(), order.begin());
  }
  return order;
}

template <Scalar S>
SensorLayout<S> in_order(const SensorLayout<S>& layout, std::span<const std::uint32_t> order) {
  layout.validate();
  SensorLayout<S> result;
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (order[k] >= layout.size()) {
      detail::raise(InvalidArgument(
          "in_order: order[" + std::to_string(k) + "]", std::to_string(order[k]),
          "must be less than the number of sensors, " + std::to_string(layout.size())));
    }
    result.add(layout.start[order[k]], layout.direction[order[k]], layout.length[order[k]]);
  }
  return result;
}

}  // namespace bristle::inline BRISTLE_ABI
