// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/math/dormand_prince.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// y'' = -y cos t with y, y', and the integral of y: not autonomous, so that wrong times show.
template <typename S>
struct Swing {
  S tolerance = infinity<S>;
  int calls = 0;

  bool derivative(S t, const S* y, S* dy) {
    using std::cos;
    ++calls;
    dy[0] = y[1];
    dy[1] = -y[0] * cos(t);
    dy[2] = y[0];
    return true;
  }
  S error_ratio(const S*, const S* error, S) const {
    return std::hypot(error[0], error[1]) / tolerance;
  }
};

/// End values after `steps` equal steps over two seconds.
template <typename S>
std::array<S, 3> end_of(int steps) {
  std::array<S, 3> y{S(1), S(0), S(0)};
  DormandPrince<S> integrator;
  S t = S(0);
  for (int i = 0; i < steps; ++i) {
    struct Shifted {
      Swing<S> swing;
      S start;
      bool derivative(S time, const S* values, S* rates) {
        return swing.derivative(start + time, values, rates);
      }
      S error_ratio(const S* a, const S* b, S h) const { return swing.error_ratio(a, b, h); }
    } system{{}, t};
    REQUIRE(integrator.advance(std::span<S>(y), 2, S(2) / S(steps), system, 1));
    t += S(2) / S(steps);
  }
  return y;
}

}  // namespace

TEST_CASE("DormandPrince: fifth order, also for integrals along the way") {
  const auto exact = end_of<double>(512);
  const auto error = [&](int steps) {
    const auto y = end_of<double>(steps);
    return std::hypot(y[0] - exact[0], y[1] - exact[1], y[2] - exact[2]);
  };
  // Halving divides the error by 32; terms of the next order move that by a tenth of these steps.
  CHECK(error(16) / error(32) == test::relative(32).epsilon(0.2));
  CHECK(error(16) < 1e-6);
  CHECK(std::abs(end_of<double>(16)[2] - exact[2]) < 1e-6);
}

TEST_CASE_TEMPLATE("DormandPrince: keeps to the tolerance and ends on the step", S, float, double) {
  const auto exact = end_of<double>(512);
  Swing<S> system{S(1e-5)};
  DormandPrince<S> integrator;
  std::array<S, 3> y{S(1), S(0), S(0)};
  REQUIRE(integrator.advance(std::span<S>(y), 2, S(2), system, 50));
  CHECK(integrator.substeps() > 1);
  CHECK(system.calls == 1 + 6 * integrator.substeps());
  // Ended at another time it would be off by the speed, which is of the order of one.
  CHECK(std::abs(static_cast<double>(y[0]) - exact[0]) < 1e-4);
  CHECK(std::abs(static_cast<double>(y[1]) - exact[1]) < 1e-4);
}

TEST_CASE("DormandPrince: gives up at the limit and leaves the values alone") {
  std::array<double, 3> y{1, 0, 0};
  DormandPrince<double> integrator;
  Swing<double> tight{1e-14};
  CHECK_FALSE(integrator.advance(std::span<double>(y), 2, 2.0, tight, 5));
  CHECK(integrator.substeps() == 5);
  Swing<double> broken{std::numeric_limits<double>::quiet_NaN()};
  CHECK_FALSE(integrator.advance(std::span<double>(y), 2, 2.0, broken, 5));
  CHECK(y == std::array<double, 3>{1, 0, 0});
}
