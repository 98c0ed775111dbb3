// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/contacts/gjk.hpp>
#include <bristle/geometry/shapes/support.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <support/random.hpp>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

/// Distance of two shapes, B at X in A.
template <Scalar S, typename A, typename B>
GjkResult<S> distance_by_gjk(const A& a, const B& b, const Transform<S>& X, S far = infinity<S>,
                             S enough = S(0), int* supports = nullptr) {
  const Mat3<S> R = X.rotation_matrix();
  const auto support = [&](const Vec3<S>& d) {
    if (supports != nullptr) ++*supports;
    return Vec3<S>(support_point(a, d) -
                   (R * support_point(b, Vec3<S>(R.transpose() * -d)) + X.translation));
  };
  return gjk_distance<S>(support, support(X.translation), far, enough);
}

}  // namespace

TEST_CASE_TEMPLATE("gjk_distance: a corner and a box are as far apart as clamping says", S, float,
                   double) {
  // A tiny tetrahedron stands for a point; its size is part of the tolerance.
  Random random(1);
  for (const S scale : {S(0.001), S(1), S(100)}) {
    for (const Vec3<S>& shape : {Vec3<S>(S(1), S(0.7), S(0.4)), Vec3<S>(S(1), S(1), S(0.001))}) {
      const Box<S> box{scale * shape};
      for (int i = 0; i < 500; ++i) {
        const Vec3<S> p = random.in_cube(S(2) * scale);
        const Vec3<S> outside = p - p.cwiseMax(-box.half_extents).cwiseMin(box.half_extents);
        const auto support = [&](const Vec3<S>& d) { return Vec3<S>(support_point(box, d) - p); };
        const auto found = gjk_distance<S>(support, support(p));
        // Coordinates of twice the size, differences of differences of them.
        const S tolerance = S(4) * Tolerance<S>::round_off() * scale;
        if (outside.norm() <= tolerance) continue;
        REQUIRE(found.is_apart);
        CHECK(std::abs(found.distance - outside.norm()) <= tolerance);
        // Progress in squared distance is seen down to round-off: in the direction, to its root.
        CHECK((found.normal - outside.normalized()).norm() <=
              tolerance / outside.norm() + Tolerance<S>::equal());
      }
    }
  }
}

TEST_CASE_TEMPLATE("gjk_distance: triangles are as far apart as their edges and corners", S, float,
                   double) {
  // The distance of two triangles that do not cross is that of a corner and a triangle or of two
  // edges; sampled here, so an upper bound within what the sampling leaves.
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    std::array<Vec3<S>, 3> corners_a, corners_b;
    for (Vec3<S>& p : corners_a) p = random.in_cube(S(1));
    for (Vec3<S>& p : corners_b) p = Vec3<S>(S(3), S(0), S(0)) + random.in_cube(S(1));
    const std::array<std::uint32_t, 3> names{0, 1, 2};
    const auto plate = [&](const std::array<Vec3<S>, 3>& c) {
      return Plate<S>{c, names, (c[1] - c[0]).cross(c[2] - c[0]).normalized()};
    };
    const Plate<S> a = plate(corners_a);
    const Plate<S> b = plate(corners_b);
    const auto found = distance_by_gjk<S>(a, b, {});
    REQUIRE(found.is_apart);
    S sampled = infinity<S>;
    constexpr int steps = 12;
    const auto point = [](const Plate<S>& t, int j, int k) {
      return Vec3<S>(t.corners[0] + S(j) / S(steps) * (t.corners[1] - t.corners[0]) +
                     S(k) / S(steps) * (t.corners[2] - t.corners[0]));
    };
    for (int j = 0; j <= steps; ++j) {
      for (int k = 0; j + k <= steps; ++k) {
        for (int l = 0; l <= steps; ++l) {
          for (int m = 0; l + m <= steps; ++m) {
            sampled = std::min(sampled, (point(a, j, k) - point(b, l, m)).norm());
          }
        }
      }
    }
    CHECK(found.distance <= sampled * (S(1) + Tolerance<S>::round_off()));
    // Edges of up to 3.5: samples lie within 0.3 of the nearest points.
    CHECK(found.distance >= sampled - S(0.3));
    // Supports prove the claimed distance.
    const S proved = -found.normal.dot(support_point(a, found.normal) -
                                       support_point(b, Vec3<S>(-found.normal)));
    CHECK(std::abs(proved - found.distance) <= S(4) * Tolerance<S>::round_off());
  }
}

TEST_CASE_TEMPLATE("gjk_distance: what is claimed of curved shapes is proved by supports", S, float,
                   double) {
  Random random(3);
  const Ellipsoid<S> ellipsoid{{S(1), S(0.5), S(0.01)}};
  const Cylinder<S> coin{S(1), S(0.001)};
  int most = 0;
  for (int i = 0; i < 500; ++i) {
    const Transform<S> X{random.rotation<S>(), S(2.5) * random.direction<S>()};
    int supports = 0;
    const S enough = Tolerance<S>::equal();
    const auto found = distance_by_gjk<S>(ellipsoid, coin, X, infinity<S>, enough, &supports);
    most = std::max(most, supports);
    REQUIRE(found.is_apart);
    const Vec3<S>& n = found.normal;
    CHECK(std::abs(n.norm() - S(1)) <= Tolerance<S>::round_off());
    const Vec3<S> n_B = X.rotation.conjugate() * n;
    const S proved = n.dot(X * support_point(coin, Vec3<S>(-n_B)) - support_point(ellipsoid, n));
    // Or where round-off lets nothing come nearer.
    CHECK(proved <= found.distance + S(8) * Tolerance<S>::round_off());
    CHECK(found.distance - proved <= enough * found.distance + S(8) * Tolerance<S>::round_off());
  }
  CHECK(most <= 65);
}

TEST_CASE_TEMPLATE("gjk_distance: overlapping and coinciding shapes are not apart", S, float,
                   double) {
  Random random(4);
  const Box<S> box{{S(1), S(0.5), S(0.25)}};
  CHECK(!distance_by_gjk<S>(box, box, {}).is_apart);
  for (int i = 0; i < 200; ++i) {
    // The centre of one within the other.
    const Transform<S> X{random.rotation<S>(),
                         S(0.9) * random.in_cube(S(1)).cwiseProduct(box.half_extents)};
    CHECK(!distance_by_gjk<S>(box, box, X).is_apart);
  }
  // A set of one point, at the origin and beside it.
  const auto nothing = [](const Vec3<S>&) { return Vec3<S>(Vec3<S>::Zero()); };
  CHECK(!gjk_distance<S>(nothing, Vec3<S>(Vec3<S>::Zero())).is_apart);
  const auto one = [](const Vec3<S>&) { return Vec3<S>(S(0), S(-2), S(0)); };
  const auto found = gjk_distance<S>(one, one(Vec3<S>::UnitX()));
  CHECK(found.is_apart);
  CHECK(found.distance == S(2));
  CHECK(found.normal == Vec3<S>(Vec3<S>::UnitY()));
}

TEST_CASE("gjk_distance: ends early where the shapes are proved to be far apart") {
  const Ellipsoid<double> ellipsoid{{1, 0.5, 0.3}};
  const Transform<double> X{.rotation = Quat<double>(0.5, 0.5, 0.5, 0.5), .translation = {3, 2, 1}};
  int all = 0;
  int few = 0;
  const double exact =
      distance_by_gjk<double>(ellipsoid, ellipsoid, X, infinity<double>, 1e-12, &all).distance;
  const auto found = distance_by_gjk<double>(ellipsoid, ellipsoid, X, 0.5, 1e-12, &few);
  CHECK(found.is_apart);
  CHECK(exact > 0.5);
  CHECK(few < all);
}

TEST_CASE("gjk_distance: numbers that are none end it") {
  const auto nan = [](const Vec3<double>&) {
    return Vec3<double>(Vec3<double>::Constant(std::nan("")));
  };
  CHECK(!gjk_distance<double>(nan, nan(Vec3<double>::UnitX())).is_apart);
}
