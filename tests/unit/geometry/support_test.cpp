// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/geometry/shapes/support.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <set>
#include <support/random.hpp>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

template <typename S>
ConvexHull<S> random_hull() {
  Random random(51);
  std::vector<Vec3<S>> points;
  for (int i = 0; i < 40; ++i) points.push_back(random.direction<S>());
  return convex_hull<S>(std::span<const Vec3<S>>(points));
}

template <typename S, typename Use>
void for_all_with_support(const Use& use) {
  use(Sphere<S>{S(0.7)});
  use(Box<S>{{S(0.3), S(0.5), S(0.7)}});
  use(Capsule<S>{S(0.4), S(0.5)});
  use(Cylinder<S>{S(0.5), S(0.3)});
  use(Cone<S>{S(0.6), S(0.5)});
  use(Ellipsoid<S>{{S(0.3), S(0.9), S(0.6)}});
  use(random_hull<S>());
  const std::array<Vec3<S>, 4> corners{Vec3<S>(S(0), S(0), S(0)), Vec3<S>(S(1), S(0), S(0)),
                                       Vec3<S>(S(1), S(1), S(1)), Vec3<S>(S(0), S(1), S(1))};
  const std::array<std::uint32_t, 4> names{0, 1, 2, 3};
  use(Plate<S>{corners, names, Vec3<S>(S(0), S(-1), S(1)).normalized()});
}

template <typename S>
std::set<std::uint32_t> ids(const SupportFeature<S>& feature) {
  return {feature.ids.begin(), feature.ids.begin() + static_cast<std::ptrdiff_t>(feature.size)};
}

}  // namespace

TEST_CASE_TEMPLATE("support_point: closed forms", S, float, double) {
  const Vec3<S> d = Vec3<S>(S(3), S(0), S(4)) / S(5);
  CHECK((support_point(Sphere<S>{S(2)}, d) - S(2) * d).norm() == S(0));
  CHECK(support_point(Box<S>{{S(1), S(2), S(3)}}, Vec3<S>(S(0.6), S(-0.8), S(0))) ==
        Vec3<S>(S(1), S(-2), S(3)));
  CHECK((support_point(Capsule<S>{S(1), S(2)}, d) - Vec3<S>(S(0.6), S(0), S(2.8))).norm() <
        Tolerance<S>::round_off());
  CHECK(support_point(Cylinder<S>{S(1), S(2)}, d) == Vec3<S>(S(1), S(0), S(2)));
  // The cone's side of radius 1 and height 2 faces (2, 1): this direction is steeper, the other
  // not.
  CHECK(support_point(Cone<S>{S(1), S(1)}, d) == Vec3<S>(S(0), S(0), S(1)));
  CHECK(support_point(Cone<S>{S(1), S(1)}, Vec3<S>(S(1), S(0), S(0))) ==
        Vec3<S>(S(1), S(0), S(-1)));
  // Where the normal (x / a^2, z / c^2) is along d.
  const Vec3<S> p = support_point(Ellipsoid<S>{{S(1), S(2), S(3)}}, d);
  CHECK(std::abs(p.x() * p.x() + p.z() * p.z() / S(9) - S(1)) < Tolerance<S>::round_off());
  CHECK((Vec3<S>(p.x(), S(0), p.z() / S(9)).normalized() - d).norm() < Tolerance<S>::round_off());
}

TEST_CASE_TEMPLATE("support_face, support_edge: hold the farthest point", S, float, double) {
  Random random(52);
  for_all_with_support<S>([&](const auto& shape) {
    for (int i = 0; i < 500; ++i) {
      // Every fourth along an axis, where faces and edges are.
      const Vec3<S> d = i % 4 == 0 ? Vec3<S>(Vec3<S>::Unit(i / 4 % 3) * S(i % 8 == 0 ? 1 : -1))
                                   : random.direction<S>();
      const S farthest = support_point(shape, d).dot(d);
      for (const SupportFeature<S>& feature : {support_edge(shape, d), support_face(shape, d)}) {
        REQUIRE(feature.size >= 1);
        S reached = -infinity<S>;
        for (std::size_t k = 0; k < feature.size; ++k) {
          reached = std::max(reached, feature.points[k].dot(d));
          // A corner of the feature is a point of the shape.
          const Vec3<S> out = random.direction<S>();
          CHECK(feature.points[k].dot(out) <=
                support_point(shape, out).dot(out) + Tolerance<S>::round_off());
        }
        CHECK(std::abs(reached - farthest) <= Tolerance<S>::round_off());
        CHECK(ids(feature).size() == feature.size);
      }
      CHECK(support_edge(shape, d).size <= 2);
    }
  });
}

TEST_CASE_TEMPLATE("support_face: polygons run counter-clockwise around their normal", S, float,
                   double) {
  Random random(53);
  for_all_with_support<S>([&](const auto& shape) {
    for (int i = 0; i < 200; ++i) {
      const Vec3<S> d = random.direction<S>();
      const SupportFeature<S> face = support_face(shape, d);
      if (!face.is_polygon()) {
        CHECK(face.cosine == S(0));
        continue;
      }
      CHECK(face.cosine == face.normal.dot(d));
      CHECK(std::abs(face.normal.norm() - S(1)) <= Tolerance<S>::round_off());
      for (std::size_t k = 0; k < face.size; ++k) {
        const Vec3<S>& a = face.points[k];
        const Vec3<S>& b = face.points[(k + 1) % face.size];
        const Vec3<S>& c = face.points[(k + 2) % face.size];
        CHECK(face.normal.dot((b - a).cross(c - b)) >= -Tolerance<S>::round_off());
        // Faces of a hull are flat to the resolution of its corners.
        CHECK(std::abs(face.normal.dot(b - a)) <= Tolerance<S>::equal());
      }
    }
  });
}

TEST_CASE_TEMPLATE("support_face: names of corners do not depend on the direction", S, float,
                   double) {
  const Box<S> box{{S(1), S(1), S(1)}};
  const Vec3<S> tilted = Vec3<S>(S(0.1), S(0.2), S(-1)).normalized();
  CHECK(ids(support_face(box, Vec3<S>(-Vec3<S>::UnitZ()))) == std::set<std::uint32_t>{0, 1, 2, 3});
  CHECK(ids(support_face(box, tilted)) == std::set<std::uint32_t>{0, 1, 2, 3});
  CHECK(ids(support_face(box, Vec3<S>(Vec3<S>::UnitX()))) == std::set<std::uint32_t>{1, 3, 5, 7});
  // Samples of a rim stay where they are, and the farthest point comes in addition.
  const Cylinder<S> cylinder{S(1), S(1)};
  const auto level = ids(support_face(cylinder, Vec3<S>(Vec3<S>::UnitZ())));
  auto leaning = ids(support_face(cylinder, Vec3<S>(S(0.1), S(0.2), S(1)).normalized()));
  CHECK(leaning.size() == level.size() + 1);
  leaning.erase(detail::rim_farthest);
  CHECK(leaning == level);
}

TEST_CASE_TEMPLATE("support_edge: an edge within the tolerance, else a point", S, float, double) {
  const Box<S> box{{S(1), S(2), S(3)}};
  const SupportFeature<S> edge = support_edge(box, Vec3<S>(S(0.6), S(0.01), S(-0.8)).normalized());
  REQUIRE(edge.size == 2);
  CHECK(edge.points[0] == Vec3<S>(S(1), S(-2), S(-3)));
  CHECK(edge.points[1] == Vec3<S>(S(1), S(2), S(-3)));
  CHECK(support_edge(box, Vec3<S>(S(0.6), S(0.1), S(-0.8)).normalized()).size == 1);
  const Capsule<S> capsule{S(1), S(2)};
  CHECK(support_edge(capsule, Vec3<S>(Vec3<S>::UnitX())).size == 2);
  CHECK(support_edge(capsule, Vec3<S>(S(0.6), S(0), S(0.8))).size == 1);
  CHECK(support_face(capsule, Vec3<S>(S(0.6), S(0), S(0.8))).size == 2);
  CHECK(support_face(capsule, Vec3<S>(Vec3<S>::UnitZ())).size == 1);
}

TEST_CASE_TEMPLATE("SupportFeature: moves with its shape", S, float, double) {
  Random random(54);
  const Transform<S> X = random.pose(S(3));
  const SupportFeature<S> face =
      support_face(Box<S>{{S(1), S(2), S(3)}}, Vec3<S>(Vec3<S>::UnitX()));
  const SupportFeature<S> moved = face.transformed(X);
  CHECK(moved.ids == face.ids);
  CHECK((moved.normal - X.rotate(face.normal)).norm() <= Tolerance<S>::round_off());
  for (std::size_t i = 0; i < face.size; ++i) {
    CHECK((moved.points[i] - X * face.points[i]).norm() <= Tolerance<S>::round_off());
  }
}
