// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/math/block_pattern.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

using namespace bristle::detail;

namespace {

/// Rows 0 to 4: none, none, {0, 1}, {2}, {0, 2, 3}.
BlockPattern five_rows() {
  BlockPattern pattern;
  pattern.add_row({});
  pattern.add_row({});
  pattern.add_row(std::array<std::uint32_t, 2>{0, 1});
  pattern.add_row(std::array<std::uint32_t, 1>{2});
  pattern.add_row(std::array<std::uint32_t, 3>{0, 2, 3});
  return pattern;
}

using Triple = std::array<std::size_t, 3>;

std::vector<Triple> common_runs(const BlockPattern& pattern, std::size_t row, std::size_t other) {
  std::vector<Triple> spans;
  pattern.for_each_common(row, other, [&](std::size_t a, std::size_t b, std::size_t columns) {
    spans.push_back({a, b, columns});
  });
  return spans;
}

}  // namespace

TEST_CASE("BlockPattern: numbers blocks row by row") {
  const BlockPattern pattern = five_rows();
  CHECK(pattern.rows() == 5);
  CHECK(pattern.size() == 11);
  CHECK(pattern.diagonal(0) == 0);
  CHECK(pattern.diagonal(2) == 4);
  CHECK(pattern.start(4) == 7);
  CHECK(pattern.block(2, 1) == 3);
  CHECK(pattern.block(4, 0) == 7);
  CHECK(pattern.block(4, 3) == 9);
  CHECK(pattern.block(4, 4) == pattern.diagonal(4));

  std::vector<std::array<std::size_t, 2>> below;
  pattern.for_each_below(4, [&](std::size_t column, std::size_t number) {
    below.push_back({column, number});
  });
  CHECK(below == std::vector<std::array<std::size_t, 2>>{{0, 7}, {2, 8}, {3, 9}});
}

TEST_CASE("BlockPattern: two rows have runs of columns in common, before the other's diagonal") {
  const BlockPattern pattern = five_rows();
  CHECK(common_runs(pattern, 1, 0).empty());
  CHECK(common_runs(pattern, 1, 1).empty());
  CHECK(common_runs(pattern, 4, 1).empty());
  CHECK(common_runs(pattern, 2, 2) == std::vector<Triple>{{2, 2, 2}});
  CHECK(common_runs(pattern, 4, 2) == std::vector<Triple>{{7, 2, 1}});
  CHECK(common_runs(pattern, 4, 3) == std::vector<Triple>{{8, 5, 1}});
  // A row with itself: all that is below its diagonal, columns 0, and 2 to 3.
  CHECK(common_runs(pattern, 4, 4) == std::vector<Triple>{{7, 7, 1}, {8, 8, 2}});
}

TEST_CASE("BlockPattern: starts anew") {
  BlockPattern pattern = five_rows();
  pattern.clear();
  CHECK(pattern.rows() == 0);
  CHECK(pattern.size() == 0);
  pattern.add_row({});
  CHECK(pattern.diagonal(0) == 0);
}
