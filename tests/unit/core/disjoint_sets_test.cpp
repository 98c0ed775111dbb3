// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/core/disjoint_sets.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using bristle::detail::DisjointSets;

TEST_CASE(
    "bristle::detail::DisjointSets: a set is known by its lowest member, whatever the order") {
  bristle::detail::DisjointSets sets;
  sets.reset(6);
  CHECK(sets.find(4) == 4);
  sets.join(5, 3);
  sets.join(3, 4);
  sets.join(1, 2);
  CHECK(sets.find(5) == 3);
  CHECK(sets.find(4) == 3);
  CHECK(sets.find(2) == 1);
  sets.join(4, 2);
  CHECK(sets.find(5) == 1);
  CHECK(sets.find(0) == 0);
  sets.join(1, 5);  // Again: nothing changes.
  CHECK(sets.find(3) == 1);
  sets.reset(6);
  CHECK(sets.find(5) == 5);
}

TEST_CASE("bristle::detail::DisjointSets: the same sets as by painting, for random joins") {
  bristle::test::Random random(3);
  constexpr std::uint32_t count = 60;
  for (int round = 0; round < 20; ++round) {
    bristle::detail::DisjointSets sets;
    sets.reset(count);
    std::vector<std::uint32_t> colour(count);
    for (std::uint32_t i = 0; i < count; ++i) colour[i] = i;
    for (int k = 0; k < 40; ++k) {
      const auto a = static_cast<std::uint32_t>(random.index(count));
      const auto b = static_cast<std::uint32_t>(random.index(count));
      sets.join(a, b);
      const std::uint32_t low = std::min(colour[a], colour[b]);
      const std::uint32_t high = std::max(colour[a], colour[b]);
      std::replace(colour.begin(), colour.end(), high, low);
    }
    for (std::uint32_t i = 0; i < count; ++i) CHECK(sets.find(i) == colour[i]);
  }
}
