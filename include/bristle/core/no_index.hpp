/// @file
/// The index that names nothing.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// [-] Stands for a missing element wherever an index of 32 bits is stored.
inline constexpr std::uint32_t no_index = 0xffffffffu;

}  // namespace detail

}  // namespace bristle::inline BRISTLE_ABI
