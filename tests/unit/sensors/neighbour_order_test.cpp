// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/sensors/neighbour_order.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// A square grid of side x side sensors, 1 mm apart, somewhere in space; each moved along the grid
/// by up to `scatter` [m] in x and y.
template <Scalar S>
SensorLayout<S> grid(std::size_t side, S scatter = S(0)) {
  test::Random random(7);
  SensorLayout<S> result;
  for (std::size_t i = 0; i < side * side; ++i) {
    const Vec3<S> at(S(1e-3) * S(i % side), S(1e-3) * S(i / side), S(0.25));
    const Vec3<S> off = scatter * random.in_cube(S(1));
    result.add(Vec3<S>(at + Vec3<S>(off.x(), off.y(), S(0))), Vec3<S>::UnitZ(), S(0.005));
  }
  return result;
}

template <Scalar S>
SensorLayout<S> scattered(std::size_t n) {
  test::Random random(3);
  SensorLayout<S> layout;
  for (std::size_t i = 0; i < n; ++i) {
    layout.add(random.in_cube(S(0.05)), random.direction<S>(), random.uniform(S(0.005), S(0.02)));
  }
  return layout;
}

/// [-] How many columns and rows of a grid some sensors are spread over.
std::array<std::size_t, 2> extent(const std::uint32_t* first, std::size_t count, std::size_t side) {
  std::array<std::size_t, 2> lower{side, side};
  std::array<std::size_t, 2> upper{0, 0};
  for (std::size_t k = 0; k < count; ++k) {
    const std::array<std::size_t, 2> at{first[k] % side, first[k] / side};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      lower[axis] = std::min(lower[axis], at[axis]);
      upper[axis] = std::max(upper[axis], at[axis]);
    }
  }
  return {upper[0] - lower[0] + 1, upper[1] - lower[1] + 1};
}

}  // namespace

TEST_CASE_TEMPLATE("neighbour_order: every sensor once, and then nothing is left to sort", S, float,
                   double) {
  for (const SensorLayout<S>& layout :
       {grid<S>(1), grid<S>(10), grid<S>(32), scattered<S>(37), scattered<S>(1000)}) {
    const std::vector<std::uint32_t> order = neighbour_order(layout);
    std::vector<std::uint32_t> sorted = order;
    std::sort(sorted.begin(), sorted.end());
    REQUIRE(sorted.size() == layout.size());
    for (std::size_t i = 0; i < sorted.size(); ++i) CHECK(sorted[i] == i);
    const SensorLayout<S> result = in_order<S>(layout, order);
    REQUIRE(result.size() == layout.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
      CHECK(result.start[k] == layout.start[order[k]]);
      CHECK(result.direction[k] == layout.direction[order[k]]);
      CHECK(result.length[k] == layout.length[order[k]]);
    }
    const RayTree<S> ray_tree(result.rays());
    for (std::size_t k = 0; k < order.size(); ++k) CHECK(ray_tree.ray_at(k) == k);
  }
  CHECK(neighbour_order(SensorLayout<S>{}).empty());
}

// Rows are not torn, neither where they are rows to round-off nor where sensors stand a little off.
TEST_CASE_TEMPLATE("neighbour_order: grids of whole nodes are divided into squares", S, float,
                   double) {
  for (const std::size_t side : {4u, 8u, 16u, 24u, 32u, 40u, 48u, 96u, 200u}) {
    for (const S scatter : {S(0), S(3e-4)}) {
      const std::vector<std::uint32_t> order = neighbour_order(grid<S>(side, scatter));
      for (std::size_t k = 0; k < order.size(); k += 16) {
        CHECK(extent(&order[k], 16, side) == std::array<std::size_t, 2>{4, 4});
      }
    }
  }
}

// Of 100 columns no whole number of nodes of 64 takes half. Divided in halves, which tears a row
// at once, such grids have hardly a square of four by four left.
TEST_CASE("neighbour_order: grids that are not of whole nodes have squares, too") {
  for (const std::size_t side : {60u, 100u}) {
    const std::vector<std::uint32_t> order = neighbour_order(grid<double>(side, 3e-4));
    std::size_t squares = 0;
    for (std::size_t k = 0; k + 16 <= order.size(); k += 16) {
      squares += extent(&order[k], 16, side) == std::array<std::size_t, 2>{4, 4} ? 1u : 0u;
    }
    CHECK(squares * 3 >= order.size() / 16);
  }
}

// Nothing to tell them apart by, or hardly anything: they keep their order, or any, and are all
// there.
TEST_CASE_TEMPLATE("neighbour_order: sensors in a row, in one place, and nearly so", S, float,
                   double) {
  const S tiny = std::numeric_limits<S>::denorm_min();
  const S huge = largest_number<S> / S(8);
  for (const Vec3<S>& step :
       {Vec3<S>(S(1e-3), 0, 0), Vec3<S>(S(1e-3), S(2e-3), S(1e-3)), Vec3<S>(0, 0, 0),
        Vec3<S>(0, tiny, 0), Vec3<S>(huge / S(500), 0, 0)}) {
    for (const std::size_t n : {1u, 2u, 16u, 17u, 64u, 65u, 500u}) {
      SensorLayout<S> layout;
      for (std::size_t i = 0; i < n; ++i) layout.add(Vec3<S>(S(i) * step), Vec3<S>::UnitZ(), S(1));
      const std::vector<std::uint32_t> order = neighbour_order(layout);
      REQUIRE(order.size() == n);
      for (std::size_t k = 0; k < n; ++k) CHECK(order[k] == k);
    }
  }
}

TEST_CASE("RayTree: ranges of ten thousand rays are sixteen, and none is small") {
  const SensorLayout<double> layout = grid<double>(100, 3e-4);
  const RayTree<double> ray_tree(layout.rays());
  CHECK(ray_tree.ranges().size() == 16);
  for (const RayRange& range : ray_tree.ranges()) CHECK(range.end - range.first >= 400);
}

TEST_CASE("RayTree: in neighbour order ranges are runs of the batch, in rows they need not be") {
  const auto are_runs = [](const RayTree<double>& ray_tree) {
    bool all = true;
    for (const RayRange& range : ray_tree.ranges()) {
      all = all && range.first % packet_size == 0;
      for (std::uint32_t place = range.first; place < range.end; ++place) {
        all = all && ray_tree.ray_at(place) >= range.first && ray_tree.ray_at(place) < range.end;
      }
    }
    return all;
  };
  for (const std::size_t side : {40u, 99u, 100u}) {
    const SensorLayout<double> rows = grid<double>(side, 3e-4);
    const RayTree<double> in_rows(rows.rays());
    CHECK(in_rows.has_packets_in_ranges() == are_runs(in_rows));
    // Two ranges are halves of the rows.
    CHECK(in_rows.has_packets_in_ranges() == (side == 40));
    const SensorLayout<double> layout = in_order<double>(rows, neighbour_order(rows));
    const RayTree<double> ray_tree(layout.rays());
    CHECK(ray_tree.has_packets_in_ranges());
    CHECK(are_runs(ray_tree));
  }
}

TEST_CASE("in_order: sensors can be chosen, and must be there") {
  const SensorLayout<double> layout = grid<double>(3);
  const std::vector<std::uint32_t> some = {8, 0, 8};
  const SensorLayout<double> chosen = in_order<double>(layout, some);
  REQUIRE(chosen.size() == 3);
  CHECK(chosen.start[0] == layout.start[8]);
  CHECK(chosen.start[1] == layout.start[0]);
  CHECK(chosen.start[2] == layout.start[8]);
  const std::vector<std::uint32_t> wrong = {0, 9};
  CHECK_THROWS_WITH_AS((void)in_order<double>(layout, wrong),
                       doctest::Contains("in_order: order[1]"), InvalidArgument);
  SensorLayout<double> broken = layout;
  broken.start.y[4] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS((void)neighbour_order(broken), doctest::Contains("SensorLayout::start[4]"),
                       InvalidArgument);
}
