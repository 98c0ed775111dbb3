// SPDX-License-Identifier: BSD-3-Clause
#include "support/block_patterns.hpp"
#include "support/random.hpp"

#include <bristle/math/block_cholesky.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// Fills the lower triangle of the pattern. The matrix is diagonally dominant, hence positive
/// definite: a row has less than n entries of size 1.
template <typename S>
void fill_dominant(BlockCholesky<S>& a, test::Random& random) {
  const BlockPattern& pattern = a.pattern();
  for (std::size_t i = 0; i < a.size(); ++i) {
    pattern.for_each_below(i / 6, [&](std::size_t column, std::size_t) {
      for (std::size_t j = 6 * column; j < 6 * column + 6; ++j) {
        a.at(i, j) = random.uniform(S(-1), S(1));
      }
    });
    for (std::size_t j = i / 6 * 6; j < i; ++j) a.at(i, j) = random.uniform(S(-1), S(1));
    a.at(i, i) = S(a.size());
  }
}

/// Calls use(i, j) for the entries below the diagonal.
template <typename S, typename Use>
void for_entries_below(const BlockCholesky<S>& a, std::size_t i, const Use& use) {
  a.pattern().for_each_below(i / 6, [&](std::size_t column, std::size_t) {
    for (std::size_t j = 6 * column; j < 6 * column + 6; ++j) use(i, j);
  });
  for (std::size_t j = i / 6 * 6; j < i; ++j) use(i, j);
}

}  // namespace

TEST_CASE_TEMPLATE("BlockCholesky: solves random sparse positive definite systems", S, float,
                   double) {
  test::Random random(1);
  for (const std::size_t blocks : {1u, 2u, 3u, 10u, 17u}) {
    for (const double share : {0.0, 0.1, 0.3, 1.0}) {
      CAPTURE(blocks);
      CAPTURE(share);
      // Scattered blocks, and a last row that reaches everything.
      const BlockPattern pattern = test::pattern_with_fill(blocks, [&](std::size_t i, std::size_t) {
        return i + 1 == blocks || random.uniform(0.0, 1.0) < share;
      });
      const std::size_t n = 6 * blocks;
      BlockCholesky<S> a;
      a.reset(pattern);
      fill_dominant(a, random);
      std::vector<S> x(n), b(n, S(0)), product(n);
      for (S& number : x) number = random.uniform(S(-1), S(1));
      for (std::size_t i = 0; i < n; ++i) {
        b[i] += a.at(i, i) * x[i];
        for_entries_below(a, i, [&](std::size_t row, std::size_t column) {
          b[row] += a.at(row, column) * x[column];
          b[column] += a.at(row, column) * x[row];
        });
      }
      const S rounding = S(n * n) * Tolerance<S>::round_off();
      a.multiply(x.data(), product.data());
      for (std::size_t i = 0; i < n; ++i) CHECK(std::abs(product[i] - b[i]) < rounding);
      REQUIRE(a.factor());
      a.solve(b.data());
      for (std::size_t i = 0; i < n; ++i) CHECK(std::abs(b[i] - x[i]) < rounding);

      // x^T A^-1 x of a vector that begins in the middle: by the solution, and against bounds.
      const std::size_t start = blocks / 2;
      for (std::size_t i = 0; i < n; ++i) {
        x[i] = i < 6 * start ? S(0) : random.uniform(S(-1), S(1));
        b[i] = x[i];
      }
      a.solve(b.data());
      S response = S(0);
      for (std::size_t i = 0; i < n; ++i) response += x[i] * b[i];
      for (const bool is_above : {true, false}) {
        product = x;
        const S bound = response * (is_above ? S(1) - rounding : S(1) + rounding);
        CHECK(a.responds_by(bound, product.data(), start) == is_above);
      }
    }
  }
}

TEST_CASE("BlockCholesky: takes the blocks of a pattern from a matrix that has others") {
  const BlockPattern full = test::full_pattern(4);
  const BlockPattern band =
      test::pattern_with_fill(4, [](std::size_t i, std::size_t j) { return i - j == 1; });
  test::Random random(2);
  BlockCholesky<double> wide;
  wide.reset(full);
  fill_dominant(wide, random);
  BlockCholesky<double> narrow;
  narrow.assign(band, wide);
  CHECK(&narrow.pattern() == &band);
  for (std::size_t i = 0; i < narrow.size(); ++i) {
    CHECK(narrow.at(i, i) == wide.at(i, i));
    for_entries_below(narrow, i, [&](std::size_t row, std::size_t column) {
      CHECK(narrow.at(row, column) == wide.at(row, column));
    });
  }
}

TEST_CASE("BlockCholesky: refuses what is not positive definite") {
  const BlockPattern pattern = test::full_pattern(2);
  BlockCholesky<double> a;
  // In a diagonal block, and across blocks.
  for (const std::uint32_t last : {1u, 7u}) {
    const auto fill = [&](double off) {
      a.reset(pattern);
      for (std::uint32_t i = 0; i < 12; ++i) a.at(i, i) = 1;
      a.at(last, 0) = off;
    };
    fill(0.9);
    CHECK(a.factor());
    for (const double off : {2.0, 1.0, infinity<double>}) {
      fill(off);
      CHECK_FALSE(a.factor());
    }
  }
}
