// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/shapes/grid_hull.hpp>

#include <doctest/doctest.h>

#include <set>
#include <support/random.hpp>
#include <utility>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::detail::GridPoint;
using bristle::detail::side_of_plane;
using bristle::test::Random;

namespace {

constexpr std::int64_t limit = std::int64_t(1) << 29;

/// Volume of a small tetrahedron, which 64 bits hold.
std::int64_t small_volume(const GridPoint& a, const GridPoint& b, const GridPoint& c,
                          const GridPoint& d) {
  const auto u = [&](std::size_t k) { return b[k] - a[k]; };
  const auto v = [&](std::size_t k) { return c[k] - a[k]; };
  const auto w = [&](std::size_t k) { return d[k] - a[k]; };
  return w(0) * (u(1) * v(2) - u(2) * v(1)) + w(1) * (u(2) * v(0) - u(0) * v(2)) +
         w(2) * (u(0) * v(1) - u(1) * v(0));
}

GridPoint random_point(Random& random, std::int64_t half) {
  GridPoint p;
  for (auto& x : p) {
    x = static_cast<std::int64_t>(random.index(static_cast<std::size_t>(2 * half + 1))) - half;
  }
  return p;
}

}  // namespace

TEST_CASE("side_of_plane: has the sign of the volume of small tetrahedra") {
  const std::uint64_t seed = 17;
  CAPTURE(seed);
  Random random(seed);
  for (int i = 0; i < 20000; ++i) {
    // Three steps make coplanar points frequent; 2^18 is what fits the plain formula.
    const std::int64_t half = i % 2 == 0 ? 1 : 1 << 18;
    const GridPoint a = random_point(random, half), b = random_point(random, half),
                    c = random_point(random, half), d = random_point(random, half);
    const std::int64_t volume = small_volume(a, b, c, d);
    CHECK(side_of_plane(a, b, c, d) == (volume > 0) - (volume < 0));
  }
}

TEST_CASE("side_of_plane: is exact at the limits of the grid") {
  // Three far corners of the cube, and points one step off their plane x + y + z = limit.
  const GridPoint a{limit, limit, -limit}, b{-limit, limit, limit}, c{limit, -limit, limit};
  for (const std::int64_t step : {-1, 0, 1}) {
    const GridPoint d{limit / 2 + step, limit / 4, limit / 4};
    CHECK(side_of_plane(a, c, b, d) == -side_of_plane(a, b, c, d));
    // Outside is away from the origin: the origin lies below.
    const int below = side_of_plane(a, b, c, {0, 0, 0});
    CHECK(below != 0);
    CHECK(side_of_plane(a, b, c, d) == (step == 0 ? 0 : step > 0 ? -below : below));
  }
  // The largest volume there is.
  CHECK(side_of_plane({-limit, -limit, -limit}, {limit, -limit, -limit}, {-limit, limit, -limit},
                      {-limit, -limit, limit}) == 1);
}

TEST_CASE("side_of_plane: does not change under even permutations of its points") {
  const std::uint64_t seed = 18;
  CAPTURE(seed);
  Random random(seed);
  for (int i = 0; i < 2000; ++i) {
    const GridPoint a = random_point(random, limit), b = random_point(random, limit),
                    c = random_point(random, limit);
    // Within a few steps of the plane of the three.
    GridPoint d = random_point(random, 2);
    for (std::size_t k = 0; k < 3; ++k) d[k] += (a[k] + b[k] + c[k]) / 3;
    const int side = side_of_plane(a, b, c, d);
    CHECK(side_of_plane(b, c, a, d) == side);
    CHECK(side_of_plane(b, a, d, c) == side);
    CHECK(side_of_plane(b, a, c, d) == -side);
  }
}

TEST_CASE("TriangleHull: is closed, and no point lies above it") {
  const std::uint64_t seed = 19;
  CAPTURE(seed);
  Random random(seed);
  for (int round = 0; round < 300; ++round) {
    CAPTURE(round);
    // From a lattice of few steps, full of coplanar and equal points, to the whole grid.
    const std::int64_t half = round % 3 == 0 ? 2 : round % 3 == 1 ? 50 : limit;
    bristle::detail::DynamicArray<GridPoint> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 60; ++i) points.push_back(random_point(random, half));
    const bristle::detail::TriangleHull<double> hull(points, {0, 1, 2, 3});

    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    std::set<std::uint32_t> corners;
    bool is_convex = true;
    bool knows_neighbors = true;
    for (const auto& t : hull.triangles()) {
      for (std::size_t k = 0; k < 3; ++k) {
        corners.insert(t.corners[k]);
        edges.insert({t.corners[k], t.corners[(k + 1) % 3]});
        const auto& across = hull.triangles()[t.neighbors[k]];
        int shared = 0;
        for (std::size_t j = 0; j < 3; ++j) {
          if (across.corners[j] == t.corners[(k + 1) % 3] &&
              across.corners[(j + 1) % 3] == t.corners[k]) {
            ++shared;
          }
        }
        knows_neighbors = knows_neighbors && shared == 1;
      }
      for (const auto& p : points) {
        is_convex = is_convex && side_of_plane(points[t.corners[0]], points[t.corners[1]],
                                               points[t.corners[2]], p) <= 0;
      }
    }
    CHECK(is_convex);
    CHECK(knows_neighbors);
    CHECK(edges.size() == 3 * hull.triangles().size());
    CHECK(corners.size() + hull.triangles().size() == edges.size() / 2 + 2);
  }
}
