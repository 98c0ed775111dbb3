// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/geometry/rays/ray_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <support/random.hpp>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using bristle::test::Random;

namespace {

/// A few operations on coordinates of the given size.
template <typename S>
doctest::Approx near(S value, S size = S(1)) {
  // doctest's epsilon is relative to scale + |value|.
  return test::relative(double(value))
      .epsilon(double(S(4) * std::numeric_limits<S>::epsilon()))
      .scale(double(size));
}

template <typename S>
Ray<S> ray_along(const Vec3<S>& origin, const Vec3<S>& direction, S length = infinity<S>) {
  return {origin, direction.normalized(), length};
}

template <typename S>
ConvexHull<S> cube_hull(S half) {
  std::vector<Vec3<S>> corners;
  for (int i = 0; i < 8; ++i) {
    corners.push_back(
        {(i & 1) != 0 ? half : -half, (i & 2) != 0 ? half : -half, (i & 4) != 0 ? half : -half});
  }
  return convex_hull<S>(std::span<const Vec3<S>>(corners));
}

/// Every shape, all of the size 1 and with the origin inside.
template <typename S, typename Use>
void for_all_with_origin_inside(const Use& use) {
  use(Sphere<S>{S(0.7)});
  use(Box<S>{{S(0.3), S(0.5), S(0.7)}});
  use(Capsule<S>{S(0.4), S(0.5)});
  use(Cylinder<S>{S(0.5), S(0.3)});
  use(Cone<S>{S(0.6), S(0.5)});
  use(Ellipsoid<S>{{S(0.3), S(0.9), S(0.6)}});
  use(HalfSpace<S>{Vec3<S>(S(1), S(2), S(2)) / S(3), S(0.2)});
  use(cube_hull<S>(S(0.5)));
}

}  // namespace

TEST_CASE_TEMPLATE("ray_cast: a ball is met where its circle is", S, float, double) {
  const Sphere<S> ball{S(1)};
  const RayHit<S> hit =
      bristle::ray_cast(ball, ray_along<S>({S(3), S(0.6), S(0)}, {S(-1), S(0), S(0)}));
  CHECK(hit.distance == near(S(2.2), S(3)));
  CHECK((hit.normal - Vec3<S>(S(0.8), S(0.6), S(0))).norm() < S(1e-6));
  CHECK(
      bristle::ray_cast(ball, ray_along<S>({S(3), S(1.001), S(0)}, {S(-1), S(0), S(0)})).distance ==
      infinity<S>);
  // Tangent: touching counts.
  CHECK(bristle::ray_cast(ball, ray_along<S>({S(3), S(1), S(0)}, {S(-1), S(0), S(0)})).distance ==
        S(3));
}

TEST_CASE_TEMPLATE("ray_cast: a ball far away is met as exactly as the distance allows", S, float,
                   double) {
  // 0.8 out of 1e5 balls' radii: the discriminant would have no digit left in float.
  const S distance = S(100000);
  const RayHit<S> hit = bristle::ray_cast(
      Sphere<S>{S(1)}, ray_along<S>({distance, S(0.6), S(0)}, {S(-1), S(0), S(0)}));
  CHECK(std::abs(hit.distance - (distance - S(0.8))) <=
        S(2) * std::numeric_limits<S>::epsilon() * distance);
  CHECK((hit.normal - Vec3<S>(S(0.8), S(0.6), S(0))).norm() < S(1e-6));
}

TEST_CASE_TEMPLATE("ray_cast: a box is met on the face that is entered", S, float, double) {
  const Box<S> box{{S(1), S(2), S(3)}};
  const RayHit<S> hit =
      bristle::ray_cast(box, ray_along<S>({S(5), S(1), S(2)}, {S(-1), S(0), S(0)}));
  CHECK(hit.distance == S(4));
  CHECK(hit.normal == Vec3<S>(S(1), S(0), S(0)));
  // 3-4-5: down 4 while moving 3 along y.
  const RayHit<S> slanted =
      bristle::ray_cast(box, ray_along<S>({S(0), S(-3), S(7)}, {S(0), S(3), S(-4)}));
  CHECK(slanted.distance == near(S(5), S(7)));
  CHECK(slanted.normal == Vec3<S>(S(0), S(0), S(1)));
  // Past it, and away from it.
  CHECK(bristle::ray_cast(box, ray_along<S>({S(5), S(2.5), S(0)}, {S(-1), S(0), S(0)})).distance ==
        infinity<S>);
  CHECK(bristle::ray_cast(box, ray_along<S>({S(5), S(1), S(0)}, {S(1), S(0), S(0)})).distance ==
        infinity<S>);
}

TEST_CASE_TEMPLATE("ray_cast: a ray in the plane of a box's face touches it", S, float, double) {
  const Box<S> box{{S(1), S(2), S(3)}};
  for (const S zero : {S(0), -S(0)}) {
    CHECK(bristle::ray_cast(box, {{S(5), S(2), S(0)}, {S(-1), zero, zero}, infinity<S>}).distance ==
          S(4));
    CHECK(
        bristle::ray_cast(box, {{S(5), S(2), S(-3)}, {S(-1), zero, zero}, infinity<S>}).distance ==
        S(4));
  }
  const S beside = S(2) + S(4) * std::numeric_limits<S>::epsilon();
  CHECK(bristle::ray_cast(box, {{S(5), beside, S(0)}, {S(-1), S(0), S(0)}, infinity<S>}).distance ==
        infinity<S>);
}

TEST_CASE_TEMPLATE("ray_cast: a capsule is met on its side and on its ends", S, float, double) {
  const Capsule<S> capsule{S(0.5), S(1)};
  const RayHit<S> side =
      bristle::ray_cast(capsule, ray_along<S>({S(2), S(0), S(0.9)}, {S(-1), S(0), S(0)}));
  CHECK(side.distance == near(S(1.5), S(2)));
  CHECK(side.normal == Vec3<S>(S(1), S(0), S(0)));
  const RayHit<S> end =
      bristle::ray_cast(capsule, ray_along<S>({S(2), S(0), S(1.3)}, {S(-1), S(0), S(0)}));
  CHECK(end.distance == near(S(1.6), S(2)));
  CHECK((end.normal - Vec3<S>(S(0.8), S(0), S(0.6))).norm() < S(1e-6));
  // Along the axis and along a line of the side.
  const Vec3<S> down(S(0), S(0), S(-1));
  CHECK(bristle::ray_cast(capsule, ray_along<S>({S(0), S(0), S(5)}, down)).distance == S(3.5));
  CHECK(bristle::ray_cast(capsule, ray_along<S>({S(0.3), S(0), S(5)}, down)).distance ==
        near(S(3.6), S(5)));
  CHECK(bristle::ray_cast(capsule, ray_along<S>({S(0.5001), S(0), S(5)}, down)).distance ==
        infinity<S>);
  // Into the tube and out again beyond the end.
  CHECK(
      bristle::ray_cast(capsule, ray_along<S>({S(1), S(0), S(2)}, {S(-1), S(0), S(1)})).distance ==
      infinity<S>);
}

TEST_CASE_TEMPLATE("ray_cast: a cylinder is met on its side and on its ends", S, float, double) {
  const Cylinder<S> cylinder{S(1), S(2)};
  const RayHit<S> side =
      bristle::ray_cast(cylinder, ray_along<S>({S(3), S(0.6), S(1)}, {S(-1), S(0), S(0)}));
  CHECK(side.distance == near(S(2.2), S(3)));
  CHECK((side.normal - Vec3<S>(S(0.8), S(0.6), S(0))).norm() < S(1e-6));
  const RayHit<S> end =
      bristle::ray_cast(cylinder, ray_along<S>({S(0), S(-3), S(6)}, {S(0), S(3), S(-4)}));
  CHECK(end.distance == near(S(5), S(6)));
  CHECK(end.normal == Vec3<S>(S(0), S(0), S(1)));
  const Vec3<S> up(S(0), S(0), S(1));
  CHECK(bristle::ray_cast(cylinder, ray_along<S>({S(0.6), S(0.7), S(-5)}, up)).distance == S(3));
  CHECK(bristle::ray_cast(cylinder, ray_along<S>({S(0.8), S(0.7), S(-5)}, up)).distance ==
        infinity<S>);
  // Over the end, across the tube.
  CHECK(bristle::ray_cast(cylinder, ray_along<S>({S(3), S(0), S(2.1)}, {S(-1), S(0), S(0)}))
            .distance == infinity<S>);
}

TEST_CASE_TEMPLATE("ray_cast: a cone is met on its side, its base and its tip", S, float, double) {
  // Radius 1 and height 2: half as wide as the depth below the tip.
  const Cone<S> cone{S(1), S(1)};
  const S root5 = std::sqrt(S(5));
  const RayHit<S> side =
      bristle::ray_cast(cone, ray_along<S>({S(3), S(0), S(0)}, {S(-1), S(0), S(0)}));
  CHECK(side.distance == near(S(2.5), S(3)));
  CHECK((side.normal - Vec3<S>(S(2) / root5, S(0), S(1) / root5)).norm() < S(1e-6));
  const Vec3<S> up(S(0), S(0), S(1));
  const RayHit<S> base = bristle::ray_cast(cone, ray_along<S>({S(0.9), S(0), S(-4)}, up));
  CHECK(base.distance == S(3));
  CHECK(base.normal == -up);
  CHECK(bristle::ray_cast(cone, ray_along<S>({S(1.1), S(0), S(-4)}, up)).distance == infinity<S>);
  // Steeper than the side, from above: at x = 0.25 the surface is 0.5 below the tip.
  CHECK(bristle::ray_cast(cone, ray_along<S>({S(0.25), S(0), S(4)}, -up)).distance ==
        near(S(3.5), S(4)));
  CHECK(bristle::ray_cast(cone, ray_along<S>({S(0), S(0), S(4)}, -up)).distance ==
        near(S(3), S(4)));
  // Parallel to a line of the side, which it meets on the other side: from (-1.5, 0, 1) with the
  // slope of the right side, x = -1.5 + t, z = 1 - 2 t is never within; from (-0.5, 0, 1) it is at
  // t where -0.5 + t = -t, so at x = -0.25, z = 0.5.
  const Vec3<S> along(S(1), S(0), S(-2));
  CHECK(bristle::ray_cast(cone, ray_along<S>({S(-0.5), S(0), S(1)}, along)).distance ==
        near(S(0.25) * root5, S(2)));
  // The mirror cone above the tip is not there.
  CHECK(bristle::ray_cast(cone, ray_along<S>({S(3), S(0), S(1.5)}, {S(-1), S(0), S(0)})).distance ==
        infinity<S>);
  CHECK(bristle::ray_cast(cone, ray_along<S>({S(0.1), S(0), S(2)}, up)).distance == infinity<S>);
}

TEST_CASE_TEMPLATE("ray_cast: an ellipsoid is met on its axes and between", S, float, double) {
  const Ellipsoid<S> ellipsoid{{S(1), S(2), S(3)}};
  const RayHit<S> hit =
      bristle::ray_cast(ellipsoid, ray_along<S>({S(5), S(0), S(0)}, {S(-1), S(0), S(0)}));
  CHECK(hit.distance == near(S(4), S(5)));
  CHECK((hit.normal - Vec3<S>(S(1), S(0), S(0))).norm() < S(1e-6));
  // At y = 1.2, (x, y) = (0.8, 1.2): gradient (x, y / 4).
  const RayHit<S> off =
      bristle::ray_cast(ellipsoid, ray_along<S>({S(5), S(1.2), S(0)}, {S(-1), S(0), S(0)}));
  CHECK(off.distance == near(S(4.2), S(5)));
  CHECK((off.normal - Vec3<S>(S(0.8), S(0.3), S(0)).normalized()).norm() < S(1e-6));
}

TEST_CASE_TEMPLATE("ray_cast: a half-space is met at its plane, from outside", S, float, double) {
  const HalfSpace<S> floor{{S(0), S(0), S(1)}, S(1)};
  const RayHit<S> hit =
      bristle::ray_cast(floor, ray_along<S>({S(0), S(0), S(5)}, {S(3), S(0), S(-4)}));
  CHECK(hit.distance == near(S(5), S(5)));
  CHECK(hit.normal == floor.normal);
  CHECK(bristle::ray_cast(floor, ray_along<S>({S(0), S(0), S(5)}, {S(1), S(0), S(0)})).distance ==
        infinity<S>);
  CHECK(bristle::ray_cast(floor, ray_along<S>({S(0), S(0), S(-9)}, {S(0), S(0), S(1)})).distance ==
        S(0));
}

TEST_CASE_TEMPLATE("ray_cast: a hull of a box's corners is that box", S, float, double) {
  Random random(21);
  const ConvexHull<S> hull = cube_hull<S>(S(1));
  const Box<S> box{Vec3<S>::Constant(S(1))};
  for (int i = 0; i < 2000; ++i) {
    const Vec3<S> origin = random.in_cube(S(3));
    const Vec3<S> target = random.in_cube(S(1.3));
    const Ray<S> ray = ray_along<S>(origin, target - origin);
    const RayHit<S> expected = bristle::ray_cast(box, ray);
    const RayHit<S> hit = bristle::ray_cast(hull, ray);
    REQUIRE((hit.distance < infinity<S>) == (expected.distance < infinity<S>));
    if (!(hit.distance < infinity<S>)) continue;
    CHECK(std::abs(hit.distance - expected.distance) <= S(10) * Tolerance<S>::round_off());
    CHECK((hit.normal - expected.normal).norm() <= Tolerance<S>::round_off());
  }
}

TEST_CASE_TEMPLATE("ray_cast: reach counts to the end and no farther", S, float, double) {
  for_all_with_origin_inside<S>([](const auto& shape) {
    const Vec3<S> direction(S(-1), S(0), S(0));
    Ray<S> ray{{S(4), S(0.05), S(0.05)}, direction, infinity<S>};
    const S distance = bristle::ray_cast(shape, ray).distance;
    REQUIRE(distance < S(4));
    ray.length = distance;
    CHECK(bristle::ray_cast(shape, ray).distance == distance);
    ray.length = std::nextafter(distance, S(0));
    CHECK(bristle::ray_cast(shape, ray).distance == infinity<S>);
    ray.length = S(0);
    CHECK(bristle::ray_cast(shape, ray).distance == infinity<S>);
  });
}

TEST_CASE_TEMPLATE("ray_cast: a start inside is a hit at 0 against the ray", S, float, double) {
  Random random(22);
  for_all_with_origin_inside<S>([&](const auto& shape) {
    for (int i = 0; i < 50; ++i) {
      const Vec3<S> direction = random.direction<S>();
      const RayHit<S> hit = bristle::ray_cast(shape, Ray<S>{Vec3<S>::Zero(), direction, S(0)});
      CHECK(hit.distance == S(0));
      CHECK(hit.normal == -direction);
    }
  });
}

TEST_CASE_TEMPLATE("ray_cast: a start within round-off of the surface is not lost on its way in", S,
                   float, double) {
  Random random(23);
  for_all_with_origin_inside<S>([&](const auto& shape) {
    for (int i = 0; i < 2000; ++i) {
      const Vec3<S> from = S(3) * random.direction<S>();
      const Vec3<S> to = random.in_cube(S(0.1));
      const RayHit<S> hit = bristle::ray_cast(shape, ray_along<S>(from, to - from));
      if (!(hit.distance > S(0))) continue;
      const Vec3<S> start = from + hit.distance * (to - from).normalized();
      for (const Vec3<S>& inwards : {Vec3<S>(to - start), Vec3<S>(-hit.normal)}) {
        const RayHit<S> again = bristle::ray_cast(shape, ray_along<S>(start, inwards));
        REQUIRE(again.distance <= S(16) * Tolerance<S>::round_off());
      }
    }
  });
}

TEST_CASE_TEMPLATE("ray_cast: tiny and huge copies of a shape give the same answer", S, float,
                   double) {
  Random random(24);
  for (int i = 0; i < 300; ++i) {
    const Vec3<S> origin = random.in_cube(S(2));
    const Vec3<S> direction = random.direction<S>();
    const auto at_scale = [&](S u) {
      const Ray<S> ray{u * origin, direction, infinity<S>};
      return std::vector<S>{bristle::ray_cast(Sphere<S>{u}, ray).distance / u,
                            bristle::ray_cast(Box<S>{{u, S(0.5) * u, u}}, ray).distance / u,
                            bristle::ray_cast(Capsule<S>{S(0.5) * u, u}, ray).distance / u,
                            bristle::ray_cast(Cylinder<S>{u, u}, ray).distance / u,
                            bristle::ray_cast(Cone<S>{u, u}, ray).distance / u,
                            bristle::ray_cast(Ellipsoid<S>{{u, S(0.5) * u, u}}, ray).distance / u};
    };
    // Powers of two round alike: not a bit may differ.
    const std::vector<S> expected = at_scale(S(1));
    CHECK(at_scale(S(1.0 / 1048576.0)) == expected);
    CHECK(at_scale(S(1048576.0)) == expected);
  }
}
