// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/rays/ray_triangle.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <support/random.hpp>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

template <typename S>
bool crosses(const TriangleCrossing<S>& crossing) {
  return crossing.distance < infinity<S>;
}

}  // namespace

TEST_CASE_TEMPLATE("TriangleTest: distance, side and miss along every axis", S, float, double) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const S sign : {S(1), S(-1)}) {
      const Vec3<S> direction = sign * Vec3<S>::Unit(axis);
      const Vec3<S> x = Vec3<S>::Unit((axis + 1) % 3);
      const Vec3<S> y = Vec3<S>::Unit((axis + 2) % 3);
      // Counter-clockwise seen from +axis.
      const Vec3<S> a = S(-1) * x - y;
      const Vec3<S> b = S(2) * x - y;
      const Vec3<S> c = S(2) * y - x;
      const TriangleTest<S> test(Ray<S>{S(-3) * direction, direction, infinity<S>});
      const auto crossing = test(a, b, c);
      CHECK(crossing.distance == S(3));
      CHECK(crossing.is_front == (sign < S(0)));
      CHECK(test(a, c, b).is_front == (sign > S(0)));
      CHECK(!crosses(test(a + S(3) * x, b + S(3) * x, c + S(3) * x)));
      // Behind the start the distance is negative.
      CHECK(TriangleTest<S>(Ray<S>{direction, direction, infinity<S>})(a, b, c).distance == S(-1));
    }
  }
}

TEST_CASE_TEMPLATE("TriangleTest: edges and corners belong to the triangle, its plane does not", S,
                   float, double) {
  const Vec3<S> a(S(0), S(0), S(0));
  const Vec3<S> b(S(1), S(0), S(0));
  const Vec3<S> c(S(0), S(1), S(0));
  const auto from = [](S x, S y) {
    return TriangleTest<S>(Ray<S>{{x, y, S(1)}, {S(0), S(0), S(-1)}, infinity<S>});
  };
  CHECK(from(S(0), S(0))(a, b, c).distance == S(1));
  CHECK(from(S(1), S(0))(a, b, c).distance == S(1));
  CHECK(from(S(0.5), S(0))(a, b, c).distance == S(1));
  CHECK(from(S(0.5), S(0.5))(a, b, c).distance == S(1));
  CHECK(!crosses(from(S(0.5), std::nextafter(S(0.5), S(1)))(a, b, c)));
  CHECK(!crosses(from(S(0.5), S(-1e-30))(a, b, c)));
  // Edge-on.
  const TriangleTest<S> within(Ray<S>{{S(-1), S(0.1), S(0)}, {S(1), S(0), S(0)}, infinity<S>});
  CHECK(!crosses(within(a, b, c)));
  // A triangle without area has nothing to meet.
  CHECK(!crosses(from(S(0.5), S(0))(a, b, b)));
}

TEST_CASE_TEMPLATE("TriangleTest: no ray passes between two triangles with a common edge", S, float,
                   double) {
  Random random(41);
  for (int i = 0; i < 100000; ++i) {
    // A point of the common edge, as near as rounding puts it, and a ray from anywhere to there.
    const Vec3<S> a = random.in_cube(S(1));
    const Vec3<S> b = random.in_cube(S(1));
    const Vec3<S> target = a + random.uniform(S(0.01), S(0.99)) * (b - a);
    const Vec3<S> origin = random.in_cube(S(5));
    const Vec3<S> direction = (target - origin).normalized();
    // The third corners to both sides of the edge as the ray sees it.
    const Vec3<S> side = direction.cross(b - a).normalized();
    if (!(direction.cross(b - a).norm() > S(0.01) * (b - a).norm())) continue;
    const Vec3<S> c = target + side + S(0.5) * random.direction<S>();
    const Vec3<S> d = target - side + S(0.5) * random.direction<S>();
    const TriangleTest<S> test(Ray<S>{origin, direction, infinity<S>});
    const auto left = test(a, b, c);
    const auto right = test(b, a, d);
    REQUIRE((crosses(left) || crosses(right)));
    for (const auto& crossing : {left, right}) {
      if (!crosses(crossing)) continue;
      const S error = std::abs(crossing.distance - (target - origin).norm());
      CHECK(error <= crossing.uncertainty + S(32) * Tolerance<S>::round_off());
    }
  }
}

TEST_CASE_TEMPLATE("TriangleTest: a triangle seen nearly from its edge knows that it is uncertain",
                   S, float, double) {
  const Vec3<S> a(S(0), S(-1), S(-1));
  const Vec3<S> b(S(0), S(1), S(-1));
  const Vec3<S> c(S(0), S(0), S(1));
  const S tilt = Tolerance<S>::equal();
  const TriangleTest<S> steep(
      Ray<S>{{tilt, S(0), S(3)}, Vec3<S>(-tilt, S(0), S(-3)).normalized(), infinity<S>});
  const TriangleTest<S> square(Ray<S>{{S(3), S(0), S(0)}, {S(-1), S(0), S(0)}, infinity<S>});
  REQUIRE(crosses(square(a, b, c)));
  CHECK(square(a, b, c).uncertainty <= S(64) * Tolerance<S>::round_off());
  const auto crossing = steep(a, b, c);
  REQUIRE(crosses(crossing));
  CHECK(crossing.uncertainty > S(0.1) * Tolerance<S>::equal());
  CHECK(std::abs(crossing.distance - S(3)) <= crossing.uncertainty);
}
