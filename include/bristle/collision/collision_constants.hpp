/// @file
/// Constants of collision that no formula gives.
///
/// `tests/constants` runs scenes with each at half and at twice its value.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

namespace bristle::inline BRISTLE_ABI::detail::chosen {

/// [1] Margin of a fat AABB, as a part of the largest half-extent of its shape. A smaller one
/// changes the tree more often. A greater one has more false pairs.
inline constexpr double fat_box_margin = 0.2;

/// [1] A fat AABB shrinks if an extent has this many margins to spare. A smaller number changes the
/// tree more often. A greater one keeps the false pairs of a shape that was fast.
inline constexpr double fat_box_surplus = 8.0;

/// [-] Steps that a fat AABB covers in the direction of motion. Fewer change the tree more often.
/// More have more false pairs.
inline constexpr double fat_box_steps = 30.0;

/// [1] Bound on what these steps add, in the largest half-extents of the shape. A greater one has
/// more false pairs of fast shapes. A smaller one changes the tree in each of their steps.
inline constexpr double fat_box_stretch = 4.0;

/// [1] Square of the distance at which a point of the last step is the same one, as a part of its
/// manifold's extent. It is a hundredth. That is much more than the motion of points at rest. It is
/// much less than the distance of two points. A smaller one loses warm starts. A greater one gives
/// impulses to other points.
inline constexpr double same_point_distance2 = 1e-4;

}  // namespace bristle::inline BRISTLE_ABI::detail::chosen
