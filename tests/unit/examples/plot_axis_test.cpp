// SPDX-License-Identifier: BSD-3-Clause
#include "support/plot_axis.hpp"
#include "support/numbers.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

using namespace bristle;
using namespace figure;

using namespace bristle::detail;
using bristle::test::nan_;
constexpr double infinite = std::numeric_limits<double>::infinity();

namespace {

PlotAxis axis_over(std::vector<double> values, const PlotAxis::Fit& fit = {},
                   bool is_logarithmic = false) {
  PlotAxis axis(is_logarithmic);
  for (const double value : values) axis.include(value);
  axis.finish(fit);
  return axis;
}

std::string labels(const PlotAxis& axis) {
  std::string text;
  for (const PlotTick& tick : axis.ticks()) {
    if (!tick.label.empty()) text += (text.empty() ? "" : " ") + tick.label;
  }
  return text;
}

}  // namespace

TEST_CASE("PlotAxis: spans the values it was given, and places them from 0 to 1") {
  const PlotAxis axis = axis_over({3, -1, 2});
  CHECK(axis.low() == -1);
  CHECK(axis.high() == 3);
  CHECK(axis.place(-1) == 0);
  CHECK(axis.place(1) == 0.5);
  CHECK(axis.place(3) == 1);
  const PlotAxis wide = axis_over({0, 10}, {.margin = 0.1});
  CHECK(wide.low() == -1);
  CHECK(wide.high() == 11);
}

TEST_CASE("PlotAxis: sets labels at 1, 2, 2.5 and 5 times powers of ten") {
  CHECK(labels(axis_over({0, 6})) == "0 1 2 3 4 5 6");
  CHECK(labels(axis_over({0, 10})) == "0 2 4 6 8 10");
  CHECK(labels(axis_over({0, 0.12})) == "0.00 0.02 0.04 0.06 0.08 0.10 0.12");
  CHECK(labels(axis_over({0, 0.125}, {.room = 5})) == "0.000 0.025 0.050 0.075 0.100 0.125");
  CHECK(labels(axis_over({-1, 1}, {.room = 4})) == "\u22121.0 \u22120.5 0.0 0.5 1.0");
  CHECK(labels(axis_over({0, 99}, {.room = 2})) == "0 50");
}

TEST_CASE("PlotAxis: never sets more labels than there is room for, plus the one at zero") {
  for (int k = 1; k < 400; ++k) {
    const double high = std::pow(1.07, k - 200);
    for (const double room : {1.0, 3.0, 7.5}) {
      const PlotAxis axis = axis_over({-0.3 * high, high}, {.room = room});
      INFO("high ", high, ", room ", room);
      CHECK(axis.ticks().size() >= 1);
      CHECK(static_cast<double>(axis.ticks().size()) <= room + 1);
      for (const PlotTick& tick : axis.ticks()) {
        CHECK(axis.place(tick.value) >= -1e-8);  // 1e-9 of the range is let through at each end
        CHECK(axis.place(tick.value) <= 1 + 1e-8);
      }
    }
  }
}

TEST_CASE("PlotAxis: takes a power of ten out of very small and very large labels") {
  const PlotAxis small = axis_over({0, 2e-5});
  CHECK(labels(small) == "0 5 10 15 20");
  CHECK(small.caption("creep [m]") == "creep [m] \u00d7 10\u207b\u2076");
  const PlotAxis large = axis_over({0, 3e7});
  CHECK(labels(large) == "0 5 10 15 20 25 30");
  CHECK(large.caption("rays") == "rays \u00d7 10\u2076");
  CHECK(axis_over({0, 0.001}).caption("time [s]") == "time [s]");
  CHECK(axis_over({0, 99999}).caption("rays") == "rays");
}

TEST_CASE("PlotAxis: gives a range to a constant, even with round-off on it, and to nothing") {
  const PlotAxis constant = axis_over({8, 8});
  CHECK(constant.low() == 4);
  CHECK(constant.high() == 12);
  const PlotAxis noisy = axis_over({8, 8 * (1 + 1e-15)});
  CHECK(noisy.place(8) == test::relative(0.5));
  CHECK(axis_over({0}).place(0) == 0.5);
  CHECK(axis_over({-2}).place(-2) == 0.5);
  CHECK(labels(axis_over({})) == "0.0 0.2 0.4 0.6 0.8 1.0");
  CHECK(axis_over({}, {}, true).high() == 10);
}

TEST_CASE("PlotAxis: ignores values that have no place on it") {
  const PlotAxis linear = axis_over({nan_, infinite, -infinite, 1e200, 0, 1});
  CHECK(linear.low() == 0);
  CHECK(linear.high() == 1);
  const PlotAxis logarithmic = axis_over({nan_, infinite, 0, -5, 1, 100}, {}, true);
  CHECK(logarithmic.low() == 1);
  CHECK(logarithmic.high() == 100);
  CHECK_FALSE(logarithmic.shows(0));
  CHECK_FALSE(linear.shows(nan_));
  CHECK(linear.shows(-1));
}

TEST_CASE("PlotAxis: labels whole decades when it is logarithmic") {
  const PlotAxis axis = axis_over({1e-3, 1}, {}, true);
  CHECK(labels(axis) == "10\u207b\u00b3 10\u207b\u00b2 10\u207b\u00b9 10\u2070");
  CHECK(axis.place(1e-3) == 0);
  CHECK(axis.place(1e-2) == test::relative(1.0 / 3));
  // Twelve decades in room for four labels: every third one.
  CHECK(labels(axis_over({1e-12, 1}, {.room = 4}, true)) ==
        "10\u207b\u00b9\u00b2 10\u207b\u2079 10\u207b\u2076 10\u207b\u00b3 10\u2070");
}

TEST_CASE("PlotAxis: shows at least a decade, with labels inside, when it is logarithmic") {
  const PlotAxis axis = axis_over({2, 2}, {}, true);
  CHECK(axis.high() / axis.low() == test::relative(10));
  CHECK(axis.place(2) == test::relative(0.5));
  CHECK(labels(axis) == "10\u2070 2\u00b710\u2070 5\u00b710\u2070");
}

TEST_CASE("PlotAxis: keeps the ends that were asked for") {
  const PlotAxis axis = axis_over({2, 4}, {.margin = 0.1, .low = 0.0});
  CHECK(axis.low() == 0);
  CHECK(axis.high() == test::relative(4.2));
  // All data lie below the low end that was asked for; there is a range all the same.
  for (const bool is_logarithmic : {false, true}) {
    const PlotAxis above = axis_over({1, 2}, {.low = 5.0}, is_logarithmic);
    CHECK(above.low() == 5);
    CHECK(above.high() > 5);
    const PlotAxis below = axis_over({1, 2}, {.high = 0.5}, is_logarithmic);
    CHECK(below.high() == 0.5);
    CHECK(below.low() < 0.5);
  }
}
