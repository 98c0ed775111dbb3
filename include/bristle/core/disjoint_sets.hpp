/// @file
/// Numbers that fall into sets as they are joined two by two.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Union-find over [0, count). Each set is known by its lowest member, whatever the order in which
/// members were joined. Allocates only when it grows.
class DisjointSets {
 public:
  /// Makes every number a set of its own.
  void reset(std::size_t count) {
    parent_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) parent_[i] = i;
  }

  /// The lowest member of a number's set.
  [[nodiscard]] std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  }

  void join(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t root_a = find(a);
    const std::uint32_t root_b = find(b);
    if (root_a < root_b) {
      parent_[root_b] = root_a;
    } else {
      parent_[root_a] = root_b;
    }
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace bristle::inline BRISTLE_ABI
