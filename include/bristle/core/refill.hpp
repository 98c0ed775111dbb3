/// @file
/// Vectors filled with what is always the same: scratch that stops allocating, and numbers.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Makes a vector `count` equal values. Unlike `assign` it grows to twice what it was, so that
/// sizes which wander (contacts of a pile) settle below it.
template <typename T>
void refill(std::vector<T>& vector, std::size_t count, const T& value) {
  if (vector.capacity() < count) vector.reserve(std::max(count, 2 * vector.capacity()));
  vector.assign(count, value);
}

/// Makes the elements of a vector 0, 1, 2, ... (`std::iota` would bring all of <numeric>, five
/// hundred lines, into every file of a user.)
template <typename T>
void fill_numbers(std::vector<T>& vector) {
  T next = T(0);
  for (T& element : vector) element = next++;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
