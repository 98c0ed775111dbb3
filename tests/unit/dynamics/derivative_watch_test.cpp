/// @file
/// Iterations that go on until their derivatives have settled.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/dynamics/solver/derivative_watch.hpp>
#include <bristle/math/dual.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;
using D = Dual<double, 2>;

TEST_CASE("DerivativeWatch: Newton's method goes on from a root whose derivative is not known") {
  // x^2 = p by x -> (x + p / x) / 2.
  D x = 3;
  const D p = D::variable(9, 1);
  DerivativeWatch<D> watch;
  watch.start();
  int steps = 0;
  do {
    x = (x + p / x) / 2;
    ++steps;
  } while (!watch.have_settled(1e-8, [&](auto& w) { w.velocity(x); }) && steps < 20);
  CHECK(x.value() == 3);
  CHECK(x.partial(0) == 0);
  CHECK(x.partial(1) == test::relative(1.0 / 6).epsilon(1e-15));
  // One that finds it, one that finds nothing new.
  CHECK(steps == 2);
}

TEST_CASE("DerivativeWatch: each variable counts by itself, relative to its own largest") {
  DerivativeWatch<D> watch;
  const auto sees = [&](const D& a, const D& b) {
    return watch.have_settled(1e-3, [&](auto& w) {
      w.velocity(a);
      w.velocity(b);
    });
  };
  watch.start();
  CHECK_FALSE(sees(D(1, {1e6, 1e-6}), D(0, {0, 0})));
  CHECK(sees(D(2, {1e6 + 1, 1e-6}), D(0, {999, 0})));  // Values are not looked at.
  CHECK_FALSE(sees(D(2, {1e6, 1.002e-6}), D(0, {0, 0})));
  CHECK(sees(D(2, {1e6, 1.002e-6}), D(0, {0, 0})));
  watch.start();
  CHECK_FALSE(sees(D(2, {1e6, 1.002e-6}), D(0, {0, 0})));
}

TEST_CASE("DerivativeWatch: what is round-off beside the impulses has settled") {
  DerivativeWatch<D> watch;
  watch.start();
  const auto sees = [&](double noise) {
    return watch.have_settled(1e-8, [&](auto& w) {
      w.velocity(D(0, {noise, 0}));
      w.impulse(D(5, {4, 0}), D(0.5));
    });
  };
  CHECK_FALSE(sees(1e-17));
  CHECK(sees(-2e-17));
  CHECK_FALSE(sees(1e-7));
}

TEST_CASE("DerivativeWatch: without derivatives there is nothing to wait for") {
  DerivativeWatch<double> watch;
  watch.start();
  CHECK(watch.have_settled(1e-8, [](auto&) { FAIL("looked at"); }));
}
