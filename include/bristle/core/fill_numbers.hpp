/// @file
/// Fills an array with 0, 1, 2, ...
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// Makes the elements of an array 0, 1, 2, ... It replaces `std::iota`: <numeric> would add five
/// hundred lines to every file of a user.
template <typename Array>
void fill_numbers(Array& array) {
  typename Array::value_type next{0};
  for (auto& element : array) element = next++;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
