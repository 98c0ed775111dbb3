/// @file
/// Order of an island's bodies in its matrix. Neighbours are side by side, so that the envelope is
/// narrow (reverse Cuthill-McKee, from an end of the island; George 1971).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <algorithm>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Numbers the bodies of islands, one island at a time. Keeps its memory.
class IslandOrder {
 public:
  static constexpr std::uint32_t none = 0xffffffffu;

  /// Numbers the bodies. Finds for each body the lowest number among itself and its neighbours.
  template <Scalar S>
  void build(const Island& island, const Constraints<S>& constraints, std::size_t slots) {
    if (local_.size() < slots) local_.resize(slots, none);
    const auto count = static_cast<std::uint32_t>(island.bodies.size());
    for (std::uint32_t i = 0; i < count; ++i) local_[island.bodies[i]] = i;
    link(island, constraints, count);
    // Two walks. The first finds a far end. The second starts there.
    walk(0, count);
    walk(queue_.back(), count);

    number_.resize(count);
    // Reversed. A hub that many bodies touch then comes after them. There it fills one row only.
    for (std::uint32_t i = 0; i < count; ++i) number_[queue_[i]] = count - 1 - i;
    lowest_.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) lowest_[i] = i;
    for (std::uint32_t i = 0; i < count; ++i) {
      for (std::uint32_t k = starts_[i]; k < starts_[i + 1]; ++k) {
        lowest_[number_[i]] = std::min(lowest_[number_[i]], number_[links_[k]]);
      }
    }
    // From here on indexed by slot. Slots of other islands stay `none`.
    for (const std::uint32_t slot : island.bodies) local_[slot] = number_[local_[slot]];
  }

  /// Clears the island, ready for the next one.
  void clear(const Island& island) {
    for (const std::uint32_t slot : island.bodies) local_[slot] = none;
  }

  /// Number of a body. It is `none` if the body is not in the island.
  [[nodiscard]] std::uint32_t number(std::uint32_t slot) const { return local_[slot]; }
  /// [-] Multiply-adds of the factorisation of the island's matrix within its envelope. That is
  /// half the square of the width of each row.
  [[nodiscard]] std::uint64_t factor_work() const {
    std::uint64_t sum = 0;
    for (std::uint32_t i = 0; i < lowest_.size(); ++i) {
      const std::uint64_t width = 6 * (i - lowest_[i]) + 3;  // The mean of a body's six rows.
      sum += 3 * width * width;
    }
    return sum;
  }
  /// Lowest number among a body and its neighbours.
  [[nodiscard]] std::uint32_t lowest(std::uint32_t number) const { return lowest_[number]; }

 private:
  /// Lists the neighbours of each body, with repetitions.
  template <Scalar S>
  void link(const Island& island, const Constraints<S>& constraints, std::uint32_t count) {
    const auto for_links = [&](const auto& use) {
      const auto one = [&](std::uint32_t a, std::uint32_t b) {
        if (local_[a] != none && local_[b] != none) use(local_[a], local_[b]);
      };
      // The points of a manifold follow each other. One link is enough for all of them.
      std::uint32_t last_a = none;
      std::uint32_t last_b = none;
      for (const std::uint32_t i : island.contacts) {
        const ContactConstraint<S>& c = constraints.contacts[i];
        if (c.body_a == last_a && c.body_b == last_b) continue;
        last_a = c.body_a;
        last_b = c.body_b;
        one(last_a, last_b);
      }
      for (const std::uint32_t i : island.blocks) {
        one(constraints.blocks[i].body_a, constraints.blocks[i].body_b);
      }
      for (const std::uint32_t i : island.soft) {
        one(constraints.soft[i].body_a, constraints.soft[i].body_b);
      }
    };
    starts_.assign(count + 1, 0);
    for_links([&](std::uint32_t a, std::uint32_t b) {
      ++starts_[a + 1];
      ++starts_[b + 1];
    });
    for (std::uint32_t i = 0; i < count; ++i) starts_[i + 1] += starts_[i];
    links_.resize(starts_[count]);
    next_.assign(starts_.begin(), starts_.end());
    for_links([&](std::uint32_t a, std::uint32_t b) {
      links_[next_[a]++] = b;
      links_[next_[b]++] = a;
    });
  }

  /// Breadth first from a body, neighbours with fewer links first.
  void walk(std::uint32_t from, std::uint32_t count) {
    is_queued_.assign(count, false);
    queue_.clear();
    const auto push = [&](std::uint32_t i) {
      if (is_queued_[i]) return;
      is_queued_[i] = true;
      queue_.push_back(i);
    };
    push(from);
    for (std::size_t head = 0; head < queue_.size(); ++head) {
      const std::uint32_t i = queue_[head];
      const std::size_t first = queue_.size();
      for (std::uint32_t k = starts_[i]; k < starts_[i + 1]; ++k) push(links_[k]);
      std::sort(queue_.begin() + static_cast<std::ptrdiff_t>(first), queue_.end(),
                [&](std::uint32_t a, std::uint32_t b) {
                  const std::uint32_t links_a = starts_[a + 1] - starts_[a];
                  const std::uint32_t links_b = starts_[b + 1] - starts_[b];
                  return links_a != links_b ? links_a < links_b : a < b;
                });
    }
    // Bodies that only fixed ones connect to the rest, if the caller's island has any.
    for (std::uint32_t i = 0; i < count; ++i) push(i);
  }

  DynamicArray<std::uint32_t> local_, number_, lowest_, starts_, links_, next_, queue_;
  DynamicArray<bool> is_queued_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
