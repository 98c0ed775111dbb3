// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/contacts/expanding_polytope.hpp>
#include <bristle/geometry/shapes/support.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <support/random.hpp>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

/// Grows a tetrahedron of supports of a shape, moved by `center`, until its nearest face is on the
/// surface. The least distance of the surface from the origin, from below and from above.
template <Scalar S, typename ConvexShape>
std::array<S, 2> grow(const ConvexShape& shape, const Vec3<S>& center) {
  const auto support = [&](const Vec3<S>& d) { return Vec3<S>(support_point(shape, d) + center); };
  ExpandingPolytope<S> polytope;
  const std::array<Vec3<S>, 4> corners{
      support(Vec3<S>(S(1), S(1), S(1))), support(Vec3<S>(S(1), S(-1), S(-1))),
      support(Vec3<S>(S(-1), S(1), S(-1))), support(Vec3<S>(S(-1), S(-1), S(1)))};
  REQUIRE(polytope.start(corners));
  S above = infinity<S>;
  for (std::size_t i = 0; i < ExpandingPolytope<S>::max_corners; ++i) {
    const auto face = polytope.nearest();
    CHECK(std::abs(face.normal.norm() - S(1)) <= Tolerance<S>::round_off());
    const Vec3<S> w = support(face.normal);
    above = std::min(above, w.dot(face.normal));
    if (!polytope.expand(w)) break;
  }
  return {polytope.nearest().distance, above};
}

}  // namespace

TEST_CASE_TEMPLATE("ExpandingPolytope: finds the nearest face of a box around the origin", S, float,
                   double) {
  Random random(1);
  for (const S scale : {S(0.001), S(1), S(100)}) {
    for (int i = 0; i < 100; ++i) {
      const Box<S> box{scale * Vec3<S>(S(1), random.uniform(S(0.3), S(1)), S(0.5))};
      const Vec3<S> center = random.in_cube(S(1)).cwiseProduct(box.half_extents);
      const S exact = (box.half_extents - center.cwiseAbs()).minCoeff();
      const auto [below, above] = grow<S>(box, center);
      const S tolerance = S(4) * Tolerance<S>::round_off() * scale;
      CHECK(std::abs(below - exact) <= tolerance);
      CHECK(std::abs(above - exact) <= tolerance);
    }
  }
}

TEST_CASE_TEMPLATE("ExpandingPolytope: the surface lies between its faces and their supports", S,
                   float, double) {
  // A ball of radius 1 whose middle is `off` away: its nearest point is 1 - off away. 124
  // faces have 0.1 of solid angle each, a radius of 0.24 if they are even and of 0.4 if, as the
  // order of growth leaves them, some are three times the others: 1 - cos(0.4) = 8 % below.
  Random random(2);
  for (int i = 0; i < 50; ++i) {
    const S off = random.uniform(S(0), S(0.9));
    const auto [below, above] = grow<S>(Ellipsoid<S>{Vec3<S>::Ones()}, off * random.direction<S>());
    const S exact = S(1) - off;
    CHECK(below <= exact + Tolerance<S>::round_off());
    CHECK(above >= exact - Tolerance<S>::round_off());
    CHECK(above - below <= S(0.08));
  }
}

TEST_CASE_TEMPLATE("ExpandingPolytope: closes in on an origin that is outside at first", S, float,
                   double) {
  const auto [below, above] = grow<S>(Box<S>{{S(1), S(2), S(3)}}, Vec3<S>(S(0.99), S(1.9), S(2.8)));
  CHECK(std::abs(below - S(0.01)) <= S(8) * Tolerance<S>::round_off());
  CHECK(std::abs(above - S(0.01)) <= S(8) * Tolerance<S>::round_off());
}

TEST_CASE_TEMPLATE("ExpandingPolytope: flat starts and corners inside are refused", S, float,
                   double) {
  ExpandingPolytope<S> polytope;
  const Vec3<S> x = Vec3<S>::UnitX();
  const Vec3<S> y = Vec3<S>::UnitY();
  const Vec3<S> z = Vec3<S>::UnitZ();
  CHECK(!polytope.start({x, y, Vec3<S>(-x), Vec3<S>(-y)}));
  CHECK(!polytope.start({x, x, x, x}));
  CHECK(!polytope.start({x, Vec3<S>(S(2) * x), Vec3<S>(S(3) * x), y}));
  REQUIRE(polytope.start({Vec3<S>(-x - z), Vec3<S>(x - z), Vec3<S>(y - z), z}));
  CHECK(!polytope.expand(Vec3<S>(Vec3<S>::Zero())));
  CHECK(!polytope.expand(z));
  CHECK(polytope.expand(Vec3<S>(S(2) * z)));
}

TEST_CASE("ExpandingPolytope: is full at its capacity") {
  Random random(3);
  ExpandingPolytope<double> polytope;
  REQUIRE(polytope.start({Vec3<double>(1, 1, 1), Vec3<double>(1, -1, -1), Vec3<double>(-1, 1, -1),
                          Vec3<double>(-1, -1, 1)}));
  std::size_t corners = 4;
  // Every point of a sphere around what there is becomes a corner.
  while (corners < ExpandingPolytope<double>::max_corners) {
    REQUIRE(polytope.expand(2.0 * random.direction<double>()));
    ++corners;
  }
  CHECK(!polytope.expand(Vec3<double>(5, 0, 0)));
}
