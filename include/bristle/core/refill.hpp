/// @file
/// Fills vectors with equal values, or with 0, 1, 2, ..., and soon stops allocating.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Makes a vector hold `count` equal values. Unlike `assign` it doubles the capacity when it grows.
/// So varying sizes (contacts of a pile) soon stay below it.
template <typename T>
void refill(std::vector<T>& vector, std::size_t count, const T& value) {
  if (vector.capacity() < count) vector.reserve(std::max(count, 2 * vector.capacity()));
  vector.assign(count, value);
}

/// Makes the elements of a vector 0, 1, 2, ... It replaces `std::iota`: <numeric> would add five
/// hundred lines to every file of a user.
template <typename T>
void fill_numbers(std::vector<T>& vector) {
  T next = T(0);
  for (T& element : vector) element = next++;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
