/// @file
/// The shapes of each body, found without a search through all shapes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>

#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// A list of slots of shapes for each slot of a body, in ascending order: it depends on the shapes
/// there are, and not on the order in which they came.
class ShapesOfBodies {
 public:
  void add(std::uint32_t body, std::uint32_t shape) {
    grow(first_, body);
    grow(next_, shape);
    std::uint32_t* link = &first_[body];
    while (*link < shape) link = &next_[*link];
    next_[shape] = *link;
    *link = shape;
  }
  /// Removes a shape that the body has.
  void remove(std::uint32_t body, std::uint32_t shape) {
    std::uint32_t* link = &first_[body];
    while (*link != shape) link = &next_[*link];
    *link = next_[shape];
  }
  /// Calls visit(shape) for each shape of a body; `visit` may remove that shape.
  template <typename Visit>
  void for_each(std::uint32_t body, Visit&& visit) const {
    if (body >= first_.size()) return;
    for (std::uint32_t shape = first_[body]; shape != no_index;) {
      const std::uint32_t next = next_[shape];
      visit(shape);
      shape = next;
    }
  }

 private:
  static void grow(DynamicArray<std::uint32_t>& links, std::uint32_t slot) {
    if (links.size() <= slot) links.resize(slot + std::size_t{1}, no_index);
  }

  DynamicArray<std::uint32_t> first_, next_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
