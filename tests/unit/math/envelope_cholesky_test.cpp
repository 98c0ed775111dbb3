// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/math/envelope_cholesky.hpp>

#include <doctest/doctest.h>

#include <vector>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE_TEMPLATE("EnvelopeMatrix: solves random sparse positive definite systems", S, float,
                   double) {
  test::Random random(1);
  for (const std::uint32_t blocks : {1u, 2u, 3u, 10u}) {
    // An arrow: narrow rows, and a last one that reaches everything.
    const std::uint32_t n = 6 * blocks;
    std::vector<std::uint32_t> first(blocks);
    for (std::uint32_t i = 0; i < blocks; ++i) first[i] = i + 1 == blocks || i == 0 ? 0 : i - 1;
    EnvelopeMatrix<S> a;
    a.reset(first);
    std::vector<S> x(n), b(n, S(0)), product(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      x[i] = random.uniform(S(-1), S(1));
      for (std::uint32_t j = 6 * first[i / 6]; j < i; ++j) a.at(i, j) = random.uniform(S(-1), S(1));
    }
    // Diagonally dominant, hence positive definite: a row has less than n entries of size 1.
    for (std::uint32_t i = 0; i < n; ++i) a.at(i, i) = S(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      b[i] += a.at(i, i) * x[i];
      for (std::uint32_t j = 6 * first[i / 6]; j < i; ++j) {
        b[i] += a.at(i, j) * x[j];
        b[j] += a.at(i, j) * x[i];
      }
    }
    const S rounding = S(n * n) * Tolerance<S>::round_off();
    a.multiply(x.data(), product.data());
    for (std::size_t i = 0; i < n; ++i) CHECK(std::abs(product[i] - b[i]) < rounding);
    REQUIRE(a.factor());
    a.solve(b.data());
    for (std::size_t i = 0; i < n; ++i) CHECK(std::abs(b[i] - x[i]) < rounding);

    // x^T A^-1 x of a vector that begins in the middle: by the solution, and against bounds.
    const std::uint32_t start = blocks / 2;
    for (std::uint32_t i = 0; i < n; ++i) {
      x[i] = i < 6 * start ? S(0) : random.uniform(S(-1), S(1));
      b[i] = x[i];
    }
    a.solve(b.data());
    S response = S(0);
    for (std::uint32_t i = 0; i < n; ++i) response += x[i] * b[i];
    for (const bool is_above : {true, false}) {
      product = x;
      const S bound = response * (is_above ? S(1) - rounding : S(1) + rounding);
      CHECK(a.responds_by(bound, product.data(), start) == is_above);
    }
  }
}

TEST_CASE("EnvelopeMatrix: refuses what is not positive definite") {
  EnvelopeMatrix<double> a;
  const std::vector<std::uint32_t> first{0, 0};
  // In a diagonal block, and across blocks.
  for (const std::uint32_t last : {1u, 7u}) {
    const auto fill = [&](double off) {
      a.reset(first);
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
