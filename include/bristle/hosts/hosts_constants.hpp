/// @file
/// Constants of hosts that no formula gives.
///
/// `tests/constants` runs scenes with each at half and at twice its value.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

namespace bristle::inline BRISTLE_ABI::detail::chosen {

/// [1] Error of the squared norm of a host's rotation, from which on its body counts as missing.
/// Smaller errors are rounding of the engine, and are normalised away. A smaller value refuses the
/// rotations of engines that normalise seldom, a greater one takes numbers for a rotation that are
/// none.
inline constexpr double host_rotation_error = 0.5;

/// [1] Share of a body's mobility without joints, up to which a motion counts as held by the joints
/// before. Joints may hold the same motion twice, and round-off is left. A smaller value divides by
/// round-off, a greater one leaves a weak motion free.
inline constexpr double held_mobility_share = 1e-10;

}  // namespace bristle::inline BRISTLE_ABI::detail::chosen
