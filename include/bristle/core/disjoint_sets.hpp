/// @file
/// Disjoint sets of numbers, joined two by two.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/core/dynamic_array.hpp>

#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Union-find over [0, count). Each set is named by its lowest member, whatever the order of joins.
/// Allocates only when it grows.
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

  /// Joins the sets of two numbers.
  void join(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t anchor_a = find(a);
    const std::uint32_t anchor_b = find(b);
    if (anchor_a < anchor_b) {
      parent_[anchor_b] = anchor_a;
    } else {
      parent_[anchor_a] = anchor_b;
    }
  }

 private:
  DynamicArray<std::uint32_t> parent_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
