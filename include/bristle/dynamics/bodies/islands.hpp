/// @file
/// Islands: groups of moving bodies that act on each other, directly or through others.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/disjoint_sets.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <algorithm>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Splits bodies and constraints into islands. Bodies that forces do not move belong to no island.
/// They do not connect the bodies that touch them.
///
/// Islands are ordered by their lowest body slot. Bodies and constraints within each ascend. So the
/// same input gives the same islands.
template <Scalar S>
class IslandBuilder {
 public:
  /// Finds the islands; they stay valid until the next call.
  const DynamicArray<Island>& build(std::span<const SolverBody<S>> bodies,
                                    const Constraints<S>& constraints) {
    const std::size_t count = bodies.size();
    sets_.reset(count);
    // The points of a manifold follow each other. The first one connects for all of them.
    std::uint32_t last_a = no_index;
    std::uint32_t last_b = no_index;
    const auto connect = [&](std::uint32_t a, std::uint32_t b) {
      if (a == last_a && b == last_b) return;
      last_a = a;
      last_b = b;
      if (bodies[a].is_moving() && bodies[b].is_moving()) sets_.join(a, b);
    };
    for (const ContactConstraint<S>& c : constraints.contacts) connect(c.body_a, c.body_b);
    for (const ConstraintBlock<S>& c : constraints.blocks) connect(c.body_a, c.body_b);
    for (const SoftBlock<S>& s : constraints.soft) connect(s.body_a, s.body_b);

    // An island's root is its lowest slot, so ascending slots meet islands in order.
    number_.assign(count, no_index);
    std::uint32_t islands = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!bodies[i].is_moving()) continue;
      const std::uint32_t root = sets_.find(i);
      if (number_[root] == no_index) number_[root] = islands++;
      number_[i] = number_[root];
    }
    const auto island_of = [&](std::uint32_t a, std::uint32_t b) {
      return bodies[a].is_moving() ? number_[a] : bodies[b].is_moving() ? number_[b] : no_index;
    };
    distribute(islands, count, bodies_, [&](std::size_t i) { return number_[i]; });
    distribute(islands, constraints.contacts.size(), contacts_, [&](std::size_t i) {
      return island_of(constraints.contacts[i].body_a, constraints.contacts[i].body_b);
    });
    distribute(islands, constraints.blocks.size(), blocks_, [&](std::size_t i) {
      return island_of(constraints.blocks[i].body_a, constraints.blocks[i].body_b);
    });
    distribute(islands, constraints.soft.size(), soft_, [&](std::size_t i) {
      return island_of(constraints.soft[i].body_a, constraints.soft[i].body_b);
    });
    islands_.resize(islands);
    for (std::uint32_t i = 0; i < islands; ++i) {
      islands_[i] = {bodies_.part(i), contacts_.part(i), blocks_.part(i), soft_.part(i)};
    }
    return islands_;
  }

 private:
  /// Members of all islands, one island after the other.
  struct Members {
    DynamicArray<std::uint32_t> items;  // With spare room at the end.
    DynamicArray<std::uint32_t> starts;

    [[nodiscard]] std::span<const std::uint32_t> part(std::uint32_t i) const {
      return std::span(items).subspan(starts[i], starts[i + 1] - starts[i]);
    }
  };

  /// Counting sort of items by island. Items without an island are left out.
  template <typename IslandOf>
  void distribute(std::uint32_t islands, std::size_t count, Members& out, IslandOf&& island_of) {
    out.starts.assign(islands + 1, 0);
    if (count == 0) return;
    if (islands == 1) {
      if (out.items.size() < count) out.items.resize(std::max(count, 2 * out.items.size()));
      std::uint32_t kept = 0;
      for (std::size_t i = 0; i < count; ++i) {
        out.items[kept] = static_cast<std::uint32_t>(i);
        kept += island_of(i) != no_index ? 1u : 0u;
      }
      out.starts[1] = kept;
      return;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t island = island_of(i);
      if (island != no_index) ++out.starts[island + 1];
    }
    for (std::uint32_t i = 0; i < islands; ++i) out.starts[i + 1] += out.starts[i];
    const std::size_t total = out.starts[islands];
    if (out.items.size() < total) out.items.resize(std::max(total, 2 * out.items.size()));
    next_.assign(out.starts.begin(), out.starts.end());
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t island = island_of(i);
      if (island != no_index) out.items[next_[island]++] = static_cast<std::uint32_t>(i);
    }
  }

  DisjointSets sets_;
  DynamicArray<std::uint32_t> number_, next_;
  Members bodies_, contacts_, blocks_, soft_;
  DynamicArray<Island> islands_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
