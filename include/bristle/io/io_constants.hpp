/// @file
/// Constants of files that no formula gives.
///
/// `tests/constants` runs scenes with each at half and at twice its value.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

namespace bristle::inline BRISTLE_ABI::detail::chosen {

/// [1] Rounding of a recorded time, relative to it. Times are sums of steps, and the frame of an
/// arrow may come that much too early. A smaller value skips frames after a million steps, a
/// greater one draws a frame that is not due.
inline constexpr double frame_time_rounding = 1e-9;

}  // namespace bristle::inline BRISTLE_ABI::detail::chosen
