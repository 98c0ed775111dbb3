/// @file
/// Numbers that many tests name.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

namespace bristle::test {

inline constexpr double g = 9.81;  ///< [m/s^2] Strength of gravity.
inline constexpr double nan_ = std::numeric_limits<double>::quiet_NaN();

}  // namespace bristle::test
