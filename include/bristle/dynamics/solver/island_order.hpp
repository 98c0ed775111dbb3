/// @file
/// Order of an island's bodies in its matrix, and the blocks that its factors have in that order.
///
/// The body with the fewest neighbours is eliminated next, and makes neighbours of those that it
/// had (Tinney and Walker 1967; George and Liu 1989 have its properties). Chains, trees and stacks
/// get no blocks but their own, and heaps few.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/math/block_pattern.hpp>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Numbers the bodies of islands, one island at a time. Keeps its memory.
class IslandOrder {
 public:
  /// Numbers the bodies and finds the pattern of their matrix.
  template <Scalar S>
  void build(const Island& island, const Constraints<S>& constraints, std::size_t slots) {
    eliminate(island, constraints, slots, std::numeric_limits<std::uint64_t>::max());
    number_bodies();
    make_pattern();
    // From here on indexed by slot. Slots of other islands stay `no_index`.
    for (const std::uint32_t slot : island.bodies) local_[slot] = number_[local_[slot]];
  }

  /// Multiply-adds of the factorisation of an island's matrix. Numbers no bodies.
  /// @param most  [-] Above this the result is only a lower bound.
  template <Scalar S>
  [[nodiscard]] std::uint64_t factor_work(const Island& island, const Constraints<S>& constraints,
                                          std::size_t slots, std::uint64_t most) {
    const std::uint64_t work = eliminate(island, constraints, slots, most);
    clear(island);
    return work;
  }

  /// Clears the island, ready for the next one.
  void clear(const Island& island) {
    for (const std::uint32_t slot : island.bodies) local_[slot] = no_index;
  }

  /// Number of a body. It is `no_index` if the body is not in the island.
  [[nodiscard]] std::uint32_t number(std::uint32_t slot) const { return local_[slot]; }
  /// Blocks of the island's matrix and of its factors, six unknowns a body.
  [[nodiscard]] const BlockPattern& pattern() const { return pattern_; }

 private:
  /// Those bodies that are neighbours of one, in ascending order: `size` of `lists_`. Some may be
  /// eliminated. `left` are not.
  struct List {
    std::size_t first = 0;
    std::uint32_t size = 0;
    std::uint32_t left = 0;
  };

  /// Puts the bodies in the order of their elimination. Afterwards the list of each body has those
  /// that come after it and have a block in its column.
  /// @return Multiply-adds of the factorisation. Ends early above `most`.
  template <Scalar S>
  std::uint64_t eliminate(const Island& island, const Constraints<S>& constraints,
                          std::size_t slots, std::uint64_t most) {
    if (local_.size() < slots) local_.resize(slots, no_index);
    const auto count = static_cast<std::uint32_t>(island.bodies.size());
    for (std::uint32_t i = 0; i < count; ++i) local_[island.bodies[i]] = i;
    link(island, constraints, count);
    list_neighbours(count);

    queue_.clear();
    number_.assign(count, no_index);
    order_.clear();
    for (std::uint32_t i = 0; i < count; ++i) enqueue(i);
    std::uint64_t work = 0;
    while (order_.size() < count && work <= most) {
      const std::uint32_t body = pop_least();
      drop_eliminated(list_of_[body]);
      const List column = list_of_[body];
      number_[body] = static_cast<std::uint32_t>(order_.size());
      order_.push_back(body);
      // A product for each two blocks of the column. Each of six columns takes half of the square
      // of the rows below it: those of the blocks, and three of its own in the mean.
      const std::uint64_t width = 6 * std::uint64_t(column.size) + 3;
      work += 3 * width * width;
      for (std::uint32_t k = 0; k < column.size; ++k) {
        const std::uint32_t other = lists_[column.first + k];
        const std::uint32_t before = list_of_[other].left;
        merge(other, column);
        if (list_of_[other].left != before) enqueue(other);
      }
    }
    return work;
  }

  /// Queues a body by its neighbours. Entries with other numbers of them are out of date.
  void enqueue(std::uint32_t body) {
    queue_.push_back(std::uint64_t(list_of_[body].left) << 32 | body);
    std::push_heap(queue_.begin(), queue_.end(), std::greater<>());
  }
  /// Takes the body with the fewest neighbours. The first of equals is taken.
  [[nodiscard]] std::uint32_t pop_least() {
    for (;;) {
      const std::uint64_t least = queue_.front();
      std::pop_heap(queue_.begin(), queue_.end(), std::greater<>());
      queue_.pop_back();
      const auto body = static_cast<std::uint32_t>(least);
      if (number_[body] == no_index && list_of_[body].left == least >> 32) return body;
    }
  }
  /// Removes eliminated bodies from a list.
  void drop_eliminated(List& list) {
    std::uint32_t* const begin = lists_.begin() + list.first;
    const std::uint32_t* const end =
        std::remove_if(begin, begin + list.size,
                       [this](std::uint32_t other) { return number_[other] != no_index; });
    list.size = list.left = static_cast<std::uint32_t>(end - begin);
  }
  /// Adds the other bodies of a column to the neighbours of one, which lose the column's own.
  void merge(std::uint32_t body, const List& column) {
    List& list = list_of_[body];
    --list.left;
    const std::uint32_t* const added = lists_.begin() + column.first;
    const std::uint32_t* const known = lists_.begin() + list.first;
    // A body that touches most others has a long list, and mostly knows them all.
    const bool knows_all = std::all_of(added, added + column.size, [&](std::uint32_t other) {
      return other == body || std::binary_search(known, known + list.size, other);
    });
    if (knows_all) return;
    drop_eliminated(list);
    const List old = list;
    list.first = lists_.size();
    if (lists_.capacity() < list.first + old.size + column.size) {
      lists_.reserve(2 * (list.first + old.size + column.size));
    }
    lists_.resize(list.first + old.size + column.size);
    std::uint32_t* const begin = lists_.begin() + list.first;
    std::uint32_t* const end = std::set_union(
        lists_.begin() + old.first, lists_.begin() + old.first + old.size,
        lists_.begin() + column.first, lists_.begin() + column.first + column.size, begin);
    list.size = list.left = static_cast<std::uint32_t>(std::remove(begin, end, body) - begin);
    lists_.resize(list.first + list.size);
  }

  /// Numbers the bodies so that those which are eliminated into one another follow each other. That
  /// gives no other blocks, and long runs of them.
  void number_bodies() {
    // The parent of a body is the next one in its column. Its children and theirs precede it.
    sizes_.assign(number_.size(), 1);
    parents_.resize(number_.size());
    for (const std::uint32_t body : order_) {
      const std::uint32_t* const column = lists_.begin() + list_of_[body].first;
      std::uint32_t& parent = parents_[body] = no_index;
      for (std::uint32_t k = 0; k < list_of_[body].size; ++k) {
        if (parent == no_index || number_[column[k]] < number_[parent]) parent = column[k];
      }
      if (parent != no_index) sizes_[parent] += sizes_[body];
    }
    // The numbers left for the children of a body end here. Parents come before children.
    range_ends_.resize(number_.size());
    auto end = static_cast<std::uint32_t>(number_.size());
    for (std::size_t k = order_.size(); k-- > 0;) {
      const std::uint32_t body = order_[k];
      std::uint32_t& range_end = parents_[body] == no_index ? end : range_ends_[parents_[body]];
      number_[body] = range_ends_[body] = range_end - 1;
      range_end -= sizes_[body];
    }
  }

  /// Turns the lists, which are columns, into rows.
  void make_pattern() {
    const std::size_t count = number_.size();
    for (std::uint32_t body = 0; body < count; ++body) order_[number_[body]] = body;
    starts_.assign(count + 1, 0);
    const auto for_blocks = [&](const auto& use) {
      for (std::uint32_t column = 0; column < count; ++column) {
        const List& list = list_of_[order_[column]];
        for (std::uint32_t k = 0; k < list.size; ++k) use(number_[lists_[list.first + k]], column);
      }
    };
    for_blocks([&](std::uint32_t row, std::uint32_t) { ++starts_[row + 1]; });
    for (std::size_t i = 0; i < count; ++i) starts_[i + 1] += starts_[i];
    links_.resize(starts_[count]);
    next_.assign(starts_.begin(), starts_.end());
    for_blocks([&](std::uint32_t row, std::uint32_t column) { links_[next_[row]++] = column; });
    pattern_.clear();
    for (std::size_t row = 0; row < count; ++row) {
      pattern_.add_row({links_.data() + starts_[row], links_.data() + starts_[row + 1]});
    }
  }

  /// Turns the links into lists without repetitions.
  void list_neighbours(std::uint32_t count) {
    list_of_.resize(count);
    lists_.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
      std::uint32_t* const begin = links_.begin() + starts_[i];
      std::uint32_t* const end = links_.begin() + starts_[i + 1];
      std::sort(begin, end);
      const std::uint32_t* const last = std::unique(begin, end);
      const auto size = static_cast<std::uint32_t>(last - begin);
      list_of_[i] = {lists_.size(), size, size};
      lists_.append(begin, begin + list_of_[i].size);
    }
  }

  /// Lists the neighbours of each body, with repetitions.
  template <Scalar S>
  void link(const Island& island, const Constraints<S>& constraints, std::uint32_t count) {
    const auto for_links = [&](const auto& use) {
      const auto one = [&](std::uint32_t a, std::uint32_t b) {
        if (local_[a] != no_index && local_[b] != no_index) use(local_[a], local_[b]);
      };
      // The points of a manifold follow each other. One link is enough for all of them.
      std::uint32_t last_a = no_index;
      std::uint32_t last_b = no_index;
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

  DynamicArray<std::uint32_t> local_, number_, order_, starts_, links_, next_;
  DynamicArray<std::uint32_t> sizes_, parents_, range_ends_, lists_;
  DynamicArray<List> list_of_;
  DynamicArray<std::uint64_t> queue_;  // A heap of neighbours and bodies, the least first.
  BlockPattern pattern_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
