// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/trees/aabb_split.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <support/random.hpp>
#include <support/rounds.hpp>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::detail::SplitLeaf;
using bristle::test::Random;
using bristle::test::rounds;

namespace {

template <Scalar S>
std::vector<SplitLeaf<S>> leaves(std::size_t count) {
  std::vector<SplitLeaf<S>> result(count);
  for (std::uint32_t i = 0; i < count; ++i) result[i].number = i;
  return result;
}

template <Scalar S>
std::vector<std::uint32_t> sorted_numbers(const std::vector<SplitLeaf<S>>& some) {
  std::vector<std::uint32_t> numbers;
  for (const SplitLeaf<S>& leaf : some) numbers.push_back(leaf.number);
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

}  // namespace

// Boxes that differ by round-off, and whose middles come out in another last bit each time they are
// computed: what fused multiply-adds or wider registers do to an expression that is compiled twice.
TEST_CASE_TEMPLATE("aabb_split: middles that are rounded differently each time still divide boxes",
                   S, float, double) {
  constexpr S ulp = std::numeric_limits<S>::epsilon();
  Random random(5);
  for (int round = 0; round < rounds(500); ++round) {
    const std::size_t count = 2 + random.index(60);
    std::vector<S> places;
    for (std::size_t i = 0; i < count; ++i) places.push_back(S(1) + ulp * S(random.index(4)));
    std::size_t looks = 0;
    const auto box_of = [&](std::uint32_t i) {
      ++looks;
      const S x = places[i] + ulp * S(random.index(2));
      return Aabb<S>{Vec3<S>(x, 0, 0), Vec3<S>(x, 0, 0)};
    };
    CAPTURE(round);
    auto some = leaves<S>(count);
    const auto all = sorted_numbers(some);

    CHECK(detail::split_in_halves<S>(some, box_of) == count / 2);
    CHECK(std::is_sorted(some.begin(), some.end(), [](const auto& a, const auto& b) {
      return a.key < b.key || (a.key == b.key && a.number < b.number);
    }));
    CHECK(sorted_numbers(some) == all);
    // Once for the axis and once for the key.
    CHECK(looks == 2 * count);

    // A part without a leaf would be divided for ever.
    const std::size_t first = detail::split_by_surface<S>(some, box_of);
    CHECK(first >= 1);
    CHECK(first < count);
    CHECK(sorted_numbers(some) == all);
  }
}

TEST_CASE_TEMPLATE("aabb_split: two clusters of boxes are divided where the gap is", S, float,
                   double) {
  // Three at the left, two at the right, in any order.
  const std::vector<S> places{S(9), S(0), S(0.5), S(10), S(1)};
  const auto box_of = [&](std::uint32_t i) {
    return Aabb<S>{Vec3<S>(0, places[i], 0), Vec3<S>(1, places[i] + S(1), 1)};
  };
  auto some = leaves<S>(places.size());
  REQUIRE(detail::split_by_surface<S>(some, box_of) == 3);
  for (std::size_t i = 0; i < some.size(); ++i) CHECK((places[some[i].number] < S(5)) == (i < 3));
}
