// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/reading_store.hpp>
#include <bristle/sensors/tactile_image.hpp>

#include <doctest/doctest.h>

#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// A store whose values tell channel and sensor: 100 * channel + sensor + offset.
ReadingStore<double> numbered(std::size_t n, double offset) {
  ReadingStore<double> store;
  store.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double x = static_cast<double>(i) + offset;
    store.depth[i] = x;
    store.normal_force[i] = 100 + x;
    store.shear_1[i] = 200 + x;
    store.shear_2[i] = 300 + x;
  }
  return store;
}

constexpr TactileChannel channels[] = {TactileChannel::depth, TactileChannel::normal_force,
                                       TactileChannel::shear_1, TactileChannel::shear_2};

}  // namespace

TEST_CASE("tactile image: views the reading row by row, without a copy") {
  const ReadingStore<double> store = numbered(12, 0);
  const PatchReading<double> reading = store.view();
  for (std::size_t channel = 0; channel < tactile_channel_count; ++channel) {
    const TactileImage<double> image = tactile_image(reading, channels[channel], 4);
    CHECK(image.rows == 3);
    CHECK(image.columns == 4);
    CHECK(image(2, 1) == 100.0 * static_cast<double>(channel) + 9);
  }
  CHECK(tactile_image(reading, TactileChannel::depth, 4).pixels.data() == store.depth.data());
  CHECK(tactile_image(reading, TactileChannel::depth).rows == 1);
  CHECK_THROWS_AS((void)tactile_image(reading, TactileChannel::depth, 5), InvalidArgument);
}

TEST_CASE("tactile image: a sensor grid has its columns along side_u") {
  SensorGridDef<double> def;
  def.side_u = {0.04, 0, 0};
  def.side_v = {0, 0.03, 0};
  def.count_u = 4;
  def.count_v = 3;
  const SensorLayout<double> layout = sensor_grid(def);
  ReadingStore<double> store;
  store.resize(layout.size());
  // An image of x is the same in every row, one of y in every column.
  for (std::size_t i = 0; i < layout.size(); ++i) {
    store.depth[i] = layout.start[i].x();
    store.normal_force[i] = layout.start[i].y();
  }
  const auto reading = store.view();
  const auto x = tactile_image(reading, TactileChannel::depth, def.count_u);
  const auto y = tactile_image(reading, TactileChannel::normal_force, def.count_u);
  for (std::size_t row = 0; row < x.rows; ++row) {
    for (std::size_t column = 0; column < x.columns; ++column) {
      CHECK(x(row, column) == x(0, column));
      CHECK(y(row, column) == y(row, 0));
    }
  }
  CHECK(x(0, 1) - x(0, 0) == test::relative(0.01));
  CHECK(y(1, 0) - y(0, 0) == test::relative(0.01));
}

TEST_CASE("tactile history: keeps the last frames, newest first") {
  TactileHistory<double> history(6, 3);
  CHECK(history.size() == 0);
  CHECK_THROWS_AS((void)history.image(0, TactileChannel::depth), InvalidArgument);
  for (int frame = 0; frame < 5; ++frame) {
    const ReadingStore<double> store = numbered(6, 1000.0 * frame);
    history.push(store.view());
  }
  CHECK(history.size() == 3);
  for (std::size_t age = 0; age < 3; ++age) {
    const auto image = history.image(age, TactileChannel::shear_1, 3);
    CHECK(image(1, 2) == 205 + 1000.0 * (4 - static_cast<double>(age)));
  }
  CHECK_THROWS_AS((void)history.image(3, TactileChannel::depth), InvalidArgument);

  std::vector<double> flat(history.value_count());
  history.copy_to(flat);
  CHECK(flat[0] == 4000);                  // Newest, depth, sensor 0.
  CHECK(flat[4 * 6 + 3 * 6 + 5] == 3305);  // One before, shear_2, sensor 5.
  CHECK_THROWS_AS(history.copy_to(std::span<double>(flat).first(5)), InvalidArgument);

  history.clear();
  const ReadingStore<double> store = numbered(6, 7000);
  history.push(store.view());
  history.copy_to(flat);
  CHECK(flat[0] == 7000);
  for (std::size_t i = 4 * 6; i < flat.size(); ++i) CHECK(flat[i] == 0);
}

TEST_CASE("tactile history: refuses what does not fit") {
  CHECK_THROWS_AS(TactileHistory<float>(0, 1), InvalidArgument);
  CHECK_THROWS_AS(TactileHistory<float>(1, 0), InvalidArgument);
  TactileHistory<double> history(6, 3);
  const ReadingStore<double> store = numbered(5, 0);
  CHECK_THROWS_AS(history.push(store.view()), InvalidArgument);
  CHECK(history.size() == 0);
}

TEST_CASE("TactileHistory: more frames than memory can count are refused, and so is no channel") {
  CHECK_THROWS_WITH_AS(TactileHistory<double>(1, std::size_t{1} << 62),
                       doctest::Contains("TactileHistory: frames"), InvalidArgument);
  const PatchReading<double> reading;
  CHECK_THROWS_WITH_AS((void)tactile_image(reading, static_cast<TactileChannel>(9)),
                       doctest::Contains("TactileChannel = 9"), InvalidArgument);
}
