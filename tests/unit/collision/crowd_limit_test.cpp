// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/collision/crowd_limit.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

using Limit = CrowdLimit<double>;

DynamicArray<ShapePair> all_pairs(std::uint32_t count) {
  DynamicArray<ShapePair> pairs;
  for (std::uint32_t a = 0; a < count; ++a) {
    for (std::uint32_t b = a + 1; b < count; ++b) pairs.push_back({a, b});
  }
  return pairs;
}

DynamicArray<InnerBall<double>> random_balls(std::uint32_t count, double side, double radius) {
  Random random(5);
  DynamicArray<InnerBall<double>> balls(count);
  for (InnerBall<double>& ball : balls) ball = {random.in_cube(side), radius};
  return balls;
}

std::size_t thin(DynamicArray<ShapePair>& pairs, const DynamicArray<InnerBall<double>>& balls) {
  Limit limit;
  return limit.thin(pairs, balls.size(), [&](std::uint32_t tag) { return balls[tag]; });
}

}  // namespace

TEST_CASE("CrowdLimit: balls that do not overlap keep all of their pairs") {
  // 216 balls on a lattice that touch each other, and reach others besides.
  DynamicArray<InnerBall<double>> balls;
  for (int i = 0; i < 216; ++i) {
    balls.push_back({{0.2 * (i % 6), 0.2 * (i / 6 % 6), 0.2 * (i / 36)}, 0.0999999});
  }
  const DynamicArray<ShapePair> before = all_pairs(216);
  DynamicArray<ShapePair> pairs = before;
  CHECK(thin(pairs, balls) == 0);
  CHECK(pairs == before);
  // Nothing is known of a radius of 0, at any number.
  for (InnerBall<double>& ball : balls) ball = {{0, 0, 0}, 0};
  CHECK(thin(pairs, balls) == 0);
  CHECK(pairs == before);
}

TEST_CASE("CrowdLimit: each shape of a crowd keeps its nearest, whatever else is put off") {
  const std::uint32_t count = 200;
  const auto balls = random_balls(count, 0.1, 0.4);
  const DynamicArray<ShapePair> before = all_pairs(count);
  DynamicArray<ShapePair> pairs = before;
  const std::size_t removed = thin(pairs, balls);
  CHECK(pairs.size() + removed == before.size());
  CHECK(pairs.size() <= Limit::most * count);
  CHECK(std::is_sorted(pairs.begin(), pairs.end()));
  const auto distance = [&](const ShapePair& pair) {
    return (balls[pair.a].center - balls[pair.b].center).norm();
  };
  for (std::uint32_t tag = 0; tag < count; ++tag) {
    DynamicArray<double> all, kept;
    for (const ShapePair& pair : before) {
      if (pair.a == tag || pair.b == tag) all.push_back(distance(pair));
    }
    for (const ShapePair& pair : pairs) {
      if (pair.a == tag || pair.b == tag) kept.push_back(distance(pair));
    }
    std::sort(all.begin(), all.end());
    std::sort(kept.begin(), kept.end());
    REQUIRE(kept.size() >= Limit::most);
    for (std::size_t k = 0; k < Limit::most; ++k) CHECK(kept[k] == all[k]);
  }
}

TEST_CASE(
    "CrowdLimit: shapes at one point keep neighbours, so that no few of them have all pairs") {
  const std::uint32_t count = 300;
  const DynamicArray<InnerBall<double>> balls(count, {{1, 2, 3}, 0.1});
  DynamicArray<ShapePair> pairs = all_pairs(count);
  CHECK(thin(pairs, balls) > 0);
  DynamicArray<std::size_t> degree(count, 0);
  for (const ShapePair& pair : pairs) ++degree[pair.a], ++degree[pair.b];
  CHECK(*std::min_element(degree.begin(), degree.end()) >= Limit::most);
  CHECK(*std::max_element(degree.begin(), degree.end()) <= 2 * Limit::most);
}

TEST_CASE("CrowdLimit: small shapes within a large one all keep their pair with it") {
  DynamicArray<InnerBall<double>> balls{{{0, 0, 0}, 1}};
  for (int i = 0; i < 125; ++i) {
    balls.push_back({{0.1 * (i % 5 - 2), 0.1 * (i / 5 % 5 - 2), 0.1 * (i / 25 - 2)}, 0.04});
  }
  DynamicArray<ShapePair> pairs = all_pairs(static_cast<std::uint32_t>(balls.size()));
  const DynamicArray<ShapePair> before = pairs;
  CHECK(thin(pairs, balls) == 0);
  CHECK(pairs == before);
}

TEST_CASE(
    "CrowdLimit: what overlaps by less than a radius is no crowd, dust on a ball least of all") {
  Random random(3);
  DynamicArray<InnerBall<double>> balls{{{0, 0, 0}, 1}, {{1.099, 0, 0}, 0.1}};
  for (int i = 0; i < 60; ++i) {
    balls.push_back({balls[1].center + 0.1009 * random.direction<double>(), 1e-3});
  }
  DynamicArray<ShapePair> pairs = all_pairs(static_cast<std::uint32_t>(balls.size()));
  const DynamicArray<ShapePair> before = pairs;
  CHECK(thin(pairs, balls) == 0);
  CHECK(pairs == before);
}
