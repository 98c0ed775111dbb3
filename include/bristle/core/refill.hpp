/// @file
/// Scratch vectors that stop allocating.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace bristle::detail {

/// Makes a vector `count` equal values. Unlike `assign` it grows to twice what it was, so that
/// sizes which wander (contacts of a pile) settle below it.
template <typename T>
void refill(std::vector<T>& vector, std::size_t count, const T& value) {
  if (vector.capacity() < count) vector.reserve(std::max(count, 2 * vector.capacity()));
  vector.assign(count, value);
}

}  // namespace bristle::detail
