/// @file
/// Loops over a few elements that are not left to the compiler.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstddef>
#include <type_traits>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

template <typename Use, std::size_t... i>
BRISTLE_FORCE_INLINE void unrolled(const Use& use, std::index_sequence<i...>) {
  (use(std::integral_constant<std::size_t, i>()), ...);
}

/// Calls use(i) for i from 0 up to `count`, each a constant. Arrays that it indexes stay in
/// registers. g++ 12 keeps such loops at -O2, and their arrays in memory. Products of blocks take
/// two to four times as long then.
template <std::size_t count, typename Use>
BRISTLE_FORCE_INLINE void unrolled(const Use& use) {
  unrolled(use, std::make_index_sequence<count>());
}

}  // namespace bristle::inline BRISTLE_ABI::detail
