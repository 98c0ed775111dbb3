// SPDX-License-Identifier: BSD-3-Clause
#include "support/texts.hpp"

#include <bristle/sensors/sensor_layout.hpp>

#include <doctest/doctest.h>

#include <limits>
#include <string>

using namespace bristle;
using bristle::test::contains;
using bristle::test::error_of;

namespace {

template <typename S>
std::string layout_error(const SensorLayout<S>& layout) {
  return error_of([&] { layout.validate(); });
}

template <typename S>
SensorLayout<S> three_sensors() {
  SensorLayout<S> layout;
  for (int i = 0; i < 3; ++i) layout.add({S(i), 0, 0}, {S(i), 0, S(0.5)});
  return layout;
}

}  // namespace

TEST_CASE_TEMPLATE("SensorLayout: keeps start, unit direction and length of each ray", S, float,
                   double) {
  SensorLayout<S> layout;
  layout.add({1, 2, 3}, {1, 5, 7});
  layout.add({1, 1, 1}, Vec3<S>::UnitX(), S(0.25));
  REQUIRE(layout.size() == 2);
  CHECK(layout.start[0] == Vec3<S>(1, 2, 3));
  CHECK(layout.length[0] == S(5));
  CHECK(layout.direction[0].isApprox(Vec3<S>(0, S(0.6), S(0.8))));
  CHECK(layout.start[1] == Vec3<S>(1, 1, 1));
  CHECK(layout.direction[1] == Vec3<S>::UnitX());
  CHECK(layout.length[1] == S(0.25));
  CHECK(layout_error(layout) == "");
  CHECK(layout_error(SensorLayout<S>{}) == "");
}

TEST_CASE_TEMPLATE("SensorLayout: appends another layout behind its own", S, float, double) {
  SensorLayout<S> layout = three_sensors<S>();
  SensorLayout<S> other;
  other.add({7, 8, 9}, {7, 8, 11});
  layout.add(other);
  REQUIRE(layout.size() == 4);
  CHECK(layout.start[2] == Vec3<S>(2, 0, 0));
  CHECK(layout.start[3] == Vec3<S>(7, 8, 9));
  CHECK(layout.length[3] == S(2));
  CHECK(layout_error(layout) == "");
  layout.add(layout);
  CHECK(layout.size() == 8);
  CHECK(layout.start[7] == Vec3<S>(7, 8, 9));
}

TEST_CASE_TEMPLATE("SensorLayout::validate: names the sensor at fault", S, float, double) {
  SensorLayout<S> layout = three_sensors<S>();
  layout.add({1, 1, 1}, {1, 1, 1});
  CHECK(contains(layout_error(layout), "SensorLayout::length[3] = 0: must be finite and > 0"));

  const S nan = std::numeric_limits<S>::quiet_NaN();
  layout = three_sensors<S>();
  layout.start.y[1] = nan;
  CHECK(contains(layout_error(layout), "SensorLayout::start[1][1]"));
  layout = three_sensors<S>();
  layout.direction.z[2] = nan;
  CHECK(contains(layout_error(layout), "SensorLayout::direction[2]"));
  layout = three_sensors<S>();
  layout.direction.z[2] = S(2);
  CHECK(contains(layout_error(layout), "SensorLayout::direction[2]: length = 2"));
  layout = three_sensors<S>();
  layout.length[0] = infinity<S>;
  CHECK(contains(layout_error(layout), "SensorLayout::length[0]"));
  layout = three_sensors<S>();
  layout.start.x.pop_back();
  CHECK(contains(layout_error(layout), "number of lengths, 3"));
}
