// SPDX-License-Identifier: BSD-3-Clause
#include "support/block_patterns.hpp"
#include "support/random.hpp"

#include <bristle/dynamics/solver/island_order.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

constexpr std::uint64_t all_work = std::numeric_limits<std::uint64_t>::max();

/// An island of bodies that contacts connect. Between its bodies are slots of others.
struct LinkedBodies {
  Constraints<double> constraints;
  std::size_t slots;
  std::vector<std::uint32_t> bodies, contacts;

  LinkedBodies(std::uint32_t count,
               const std::vector<std::pair<std::uint32_t, std::uint32_t>>& links)
      : slots(3 * count + 1) {
    for (std::uint32_t i = 0; i < count; ++i) bodies.push_back(slot(i));
    for (const auto& [a, b] : links) {
      ContactConstraint<double> contact;
      contact.body_a = slot(a);
      contact.body_b = slot(b);
      contacts.push_back(static_cast<std::uint32_t>(constraints.contacts.size()));
      constraints.contacts.push_back(contact);
    }
  }

  Island island() const {
    Island all;
    all.bodies = bodies;
    all.contacts = contacts;
    return all;
  }
  static std::uint32_t slot(std::uint32_t body) { return 3 * body + 1; }
};

/// [-] Blocks of a matrix below its diagonal that has `links`, each once, and no fill.
std::size_t fill_of(const LinkedBodies& linked, std::size_t links) {
  IslandOrder order;
  order.build(linked.island(), linked.constraints, linked.slots);
  return order.pattern().size() - linked.bodies.size() - links;
}

}  // namespace

TEST_CASE("IslandOrder: numbers all bodies, with the blocks of their links and all fill") {
  test::Random random(3);
  IslandOrder order;
  for (const std::uint32_t count : {1u, 2u, 5u, 20u, 50u}) {
    for (const double share : {0.0, 0.05, 0.2, 1.0}) {
      CAPTURE(count);
      CAPTURE(share);
      std::vector<std::pair<std::uint32_t, std::uint32_t>> links;
      for (std::uint32_t i = 0; i < count; ++i) {
        for (std::uint32_t j = 0; j < i; ++j) {
          if (random.uniform(0.0, 1.0) >= share) continue;
          // In both directions, some twice, as the manifolds of a pair of bodies come.
          if (random.uniform(0.0, 1.0) < 0.5) links.emplace_back(j, i);
          links.emplace_back(i, j);
        }
      }
      const LinkedBodies linked(count, links);
      order.build(linked.island(), linked.constraints, linked.slots);
      std::vector<std::uint32_t> number(count);
      for (std::uint32_t i = 0; i < count; ++i) number[i] = order.number(LinkedBodies::slot(i));
      CHECK(order.number(0) == detail::no_index);
      std::vector<std::uint32_t> sorted = number;
      std::sort(sorted.begin(), sorted.end());
      for (std::uint32_t i = 0; i < count; ++i) CHECK(sorted[i] == i);

      std::vector<std::vector<bool>> is_linked(count, std::vector<bool>(count));
      for (const auto& [a, b] : links) {
        is_linked[number[a]][number[b]] = is_linked[number[b]][number[a]] = true;
      }
      const BlockPattern expected = test::pattern_with_fill(
          count, [&](std::size_t i, std::size_t j) { return is_linked[i][j]; });
      REQUIRE(order.pattern().size() == expected.size());
      // Products of the factorisation: half a block's for the diagonal, one for each two blocks.
      std::uint64_t work = 27 * count;
      std::vector<std::uint64_t> below(count);
      for (std::size_t row = 0; row < count; ++row) {
        CHECK(order.pattern().diagonal(row) == expected.diagonal(row));
        expected.for_each_below(row, [&](std::size_t column, std::size_t block) {
          CHECK(order.pattern().block(row, column) == block);
          ++below[column];
        });
      }
      for (const std::uint64_t b : below) work += 216 * (b * (b + 1) / 2);
      order.clear(linked.island());
      CHECK(order.number(LinkedBodies::slot(0)) == detail::no_index);
      CHECK(order.factor_work(linked.island(), linked.constraints, linked.slots, all_work) == work);
      CHECK(order.number(LinkedBodies::slot(0)) == detail::no_index);
      // A search that ends early has seen more than was asked for.
      CHECK(order.factor_work(linked.island(), linked.constraints, linked.slots, work / 2) >
            work / 2);
    }
  }
}

TEST_CASE("IslandOrder: what is eliminated into a body precedes it in one run") {
  // Arms of three bodies on a hub. The ends of the arms come first, since they have one neighbour
  // and the lowest slots: by the order of elimination alone an arm would be scattered.
  const std::uint32_t arm_count = 10;
  const std::uint32_t hub = 3 * arm_count;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> arms;
  for (std::uint32_t end = 0; end < arm_count; ++end) {
    arms.emplace_back(end, arm_count + end);
    arms.emplace_back(arm_count + end, 2 * arm_count + end);
    arms.emplace_back(2 * arm_count + end, hub);
  }
  const LinkedBodies linked(hub + 1, arms);
  IslandOrder order;
  order.build(linked.island(), linked.constraints, linked.slots);
  CHECK(order.number(LinkedBodies::slot(hub)) == hub);
  for (std::uint32_t end = 0; end < arm_count; ++end) {
    const std::uint32_t first = order.number(LinkedBodies::slot(end));
    CHECK(order.number(LinkedBodies::slot(arm_count + end)) == first + 1);
    CHECK(order.number(LinkedBodies::slot(2 * arm_count + end)) == first + 2);
  }
}

TEST_CASE("IslandOrder: the hub of a large wheel knows all neighbours") {
  // Lists keep eliminated bodies until something is added to them (benchmarks/factor_cost.cpp).
  std::vector<std::pair<std::uint32_t, std::uint32_t>> links;
  const std::uint32_t count = 50000;
  for (std::uint32_t i = 1; i < count; ++i) links.emplace_back(0, i);
  for (std::uint32_t i = 2; i < count; ++i) links.emplace_back(i - 1, i);
  const LinkedBodies linked(count, links);
  IslandOrder order;
  // A body of the chain has the next one and the hub in its column.
  CHECK(order.factor_work(linked.island(), linked.constraints, linked.slots, all_work) ==
        27 + 243 + (count - 2) * std::uint64_t(675));
}

TEST_CASE("IslandOrder: chains, trees and hubs get no blocks but their own") {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> chain, tree, hub;
  for (std::uint32_t i = 1; i < 40; ++i) {
    chain.emplace_back(i - 1, i);
    tree.emplace_back((i - 1) / 3, i);
    hub.emplace_back(17, i == 17 ? 0 : i);
  }
  CHECK(fill_of(LinkedBodies(40, chain), 39) == 0);
  CHECK(fill_of(LinkedBodies(40, tree), 39) == 0);
  CHECK(fill_of(LinkedBodies(40, hub), 39) == 0);
  // A ring has one block more for each body between its ends but two.
  chain.emplace_back(39, 0);
  CHECK(fill_of(LinkedBodies(40, chain), 40) == 37);
}
