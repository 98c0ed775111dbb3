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
  for (const std::uint32_t n : {1u, 3u, 6u, 17u, 60u}) {
    // An arrow: narrow rows, and a last one that reaches everything.
    std::vector<std::uint32_t> first(n);
    for (std::uint32_t i = 0; i < n; ++i) first[i] = i + 1 == n ? 0 : i - std::min(i, 5u);
    EnvelopeMatrix<S> a;
    a.reset(first);
    std::vector<S> x(n), b(n, S(0));
    for (std::uint32_t i = 0; i < n; ++i) {
      x[i] = random.uniform(S(-1), S(1));
      for (std::uint32_t j = first[i]; j < i; ++j) a.at(i, j) = random.uniform(S(-1), S(1));
    }
    // Diagonally dominant, hence positive definite: at most six entries of size 1 in a column
    // besides the last row, whose n - 1 are the most of any row.
    for (std::uint32_t i = 0; i < n; ++i) a.at(i, i) = i + 1 == n ? S(n) : S(14);
    for (std::uint32_t i = 0; i < n; ++i) {
      b[i] += a.at(i, i) * x[i];
      for (std::uint32_t j = first[i]; j < i; ++j) {
        b[i] += a.at(i, j) * x[j];
        b[j] += a.at(i, j) * x[i];
      }
    }
    REQUIRE(a.factor());
    a.solve(b.data());
    const S tolerance = S(n * n) * Tolerance<S>::round_off();
    for (std::size_t i = 0; i < n; ++i) CHECK(std::abs(b[i] - x[i]) < tolerance);
  }
}

TEST_CASE("EnvelopeMatrix: refuses what is not positive definite, or softens it where asked") {
  EnvelopeMatrix<double> a;
  const std::vector<std::uint32_t> first{0, 0};
  const auto fill = [&](double off) {
    a.reset(first);
    a.at(0, 0) = a.at(1, 1) = 1;
    a.at(1, 0) = off;
  };
  fill(2);
  CHECK_FALSE(a.factor());
  fill(1);
  CHECK_FALSE(a.factor());
  fill(1);
  REQUIRE(a.factor(1e-12));
  fill(infinity<double>);
  CHECK_FALSE(a.factor());
}
