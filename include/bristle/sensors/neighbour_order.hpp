/// @file
/// Order of sensors in which neighbours follow each other, for layouts whose order means nothing.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/core/fill_numbers.hpp>
#include <bristle/geometry/rays/ray_tree.hpp>
#include <bristle/sensors/sensor_layout.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Returns the indices of a layout's sensors in squares: four rows of four, four such squares, and
/// so on, as far as their number and positions allow.
///
/// A patch takes its sensors sixteen at a time, in the order of their layout. The edge of a contact
/// runs through most of the rows of sixteen that it meets, but through few squares. Take a pad of
/// 1000 to 10,000 sensors that half touches a box, a ball or a capsule. In squares it takes 4 to 16
/// % less time. One of a hundred takes up to 14 % more (docs/decisions/0031-order-of-sensors.md).
/// Readings are in the order of the layout. So squares suit skins that are read as sums or by a
/// table of sensors; images want rows (`tactile_image`). Other data in the order of the layout,
/// such as `PatchDef::per_sensor`, has to be reordered likewise.
///
/// @throws InvalidArgument when the layout breaks a rule of `SensorLayout::validate`.
/// @note O(n log n).
template <Scalar S>
[[nodiscard]] std::vector<std::uint32_t> neighbour_order(const SensorLayout<S>& layout);

/// Reorders the sensors of a layout: the k-th is `layout`'s sensor order[k]. Sensors may be left
/// out or repeated.
/// @throws InvalidArgument when the layout is not valid, or an index is not that of a sensor.
template <Scalar S>
[[nodiscard]] SensorLayout<S> in_order(const SensorLayout<S>& layout,
                                       std::span<const std::uint32_t> order);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
std::vector<std::uint32_t> neighbour_order(const SensorLayout<S>& layout) {
  layout.validate();
  const detail::RayTree<S> ray_tree(layout.rays());
  std::vector<std::uint32_t> order(layout.size());
  if (ray_tree.is_empty()) {
    detail::fill_numbers(order);  // No sensors, or rays without an end.
  } else {
    std::copy_n(ray_tree.rays_from(0), order.size(), order.begin());
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
