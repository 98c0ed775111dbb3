// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/math/cholesky.hpp>

#include <doctest/doctest.h>

#include <vector>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE_TEMPLATE("factor_cholesky: solves random positive definite systems", S, float, double) {
  test::Random random(1);
  for (const std::size_t n : {std::size_t{1}, std::size_t{3}, std::size_t{6}, std::size_t{17}}) {
    std::vector<S> g(n * n), a(n * n), x(n), b(n, S(0));
    for (S& value : g) value = random.uniform(S(-1), S(1));
    for (std::size_t i = 0; i < n; ++i) {
      x[i] = random.uniform(S(-1), S(1));
      for (std::size_t j = 0; j < n; ++j) {
        a[i * n + j] = i == j ? S(1) : S(0);
        for (std::size_t k = 0; k < n; ++k) a[i * n + j] += g[i * n + k] * g[j * n + k];
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) b[i] += a[i * n + j] * x[j];
    }
    REQUIRE(factor_cholesky(a.data(), n));
    solve_lower(a.data(), n, b.data());
    solve_upper(a.data(), n, b.data());
    // Condition number up to about n^2.
    const S tolerance = S(n * n) * Tolerance<S>::round_off();
    for (std::size_t i = 0; i < n; ++i) CHECK(std::abs(b[i] - x[i]) < tolerance);
  }
}

TEST_CASE_TEMPLATE("factor_cholesky: refuses what is not positive definite or not finite", S, float,
                   double) {
  S indefinite[4] = {1, 2, 2, 1};
  CHECK_FALSE(factor_cholesky(indefinite, 2));
  S zero[1] = {0};
  CHECK_FALSE(factor_cholesky(zero, 1));
  S broken[1] = {std::numeric_limits<S>::quiet_NaN()};
  CHECK_FALSE(factor_cholesky(broken, 1));
  S huge[1] = {infinity<S>};
  CHECK_FALSE(factor_cholesky(huge, 1));
}

TEST_CASE_TEMPLATE("factor_cholesky: with a floor, redundant equations share the load", S, float,
                   double) {
  // Twice the same equation x + y = 2 in the dual: [1 1; 1 1] p = [2; 2].
  S a[4] = {1, 1, 1, 1};
  S b[2] = {2, 2};
  REQUIRE(factor_cholesky(a, 2, Tolerance<S>::round_off()));
  solve_lower(a, 2, b);
  solve_upper(a, 2, b);
  CHECK(std::abs(b[0] + b[1] - S(2)) < S(0.01));
}

TEST_CASE("solve_lower: may skip leading zeros") {
  double l[9] = {2, 0, 0, 1, 3, 0, 4, 5, 6};
  double full[3] = {0, 6, 10};
  double part[3] = {0, 6, 10};
  solve_lower(l, 3, full);
  solve_lower(l, 3, part, 1);
  for (int i = 0; i < 3; ++i) CHECK(full[i] == part[i]);
}
