// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/geometry/backends/fcl_contact_normal.hpp>
#include <bristle/geometry/backends/fcl_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <doctest/doctest.h>
#include <fcl/narrowphase/collision.h>

#include <cmath>
#include <limits>
#include <support/random.hpp>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

constexpr int convex_kinds = 7;

/// A convex shape of sizes between 0.2 and 1 times `scale`.
Shape<double> random_convex(Random& random, int kind, double scale) {
  const auto size = [&] { return scale * random.uniform(0.2, 1.0); };
  switch (kind) {
    case 0:
      return Sphere<double>{.radius = size()};
    case 1:
      return Box<double>{.half_extents = {size(), size(), size()}};
    case 2:
      return Capsule<double>{.radius = size(), .half_length = size()};
    case 3:
      return Cylinder<double>{.radius = size(), .half_length = size()};
    case 4:
      return Cone<double>{.radius = size(), .half_length = size()};
    case 5:
      return Ellipsoid<double>{.radii = {size(), size(), size()}};
    default: {
      std::vector<Vec3<double>> points;
      for (int i = 0; i < 16; ++i) points.push_back(scale * random.in_cube(1.0));
      return convex_hull<double>(points);
    }
  }
}

/// A shape and what GJK sees of it.
struct Solid {
  explicit Solid(Shape<double> of) : shape(std::move(of)), convex(make_convex(shape)) {}
  Solid(const Solid&) = delete;
  Solid& operator=(const Solid&) = delete;

  static ConvexView<double> make_convex(const Shape<double>& shape) {
    return std::visit(
        [](const auto& s) {
          if constexpr (requires { support_point(s, Vec3<double>()); }) {
            return convex_view(s);
          } else {
            return ConvexView<double>{};
          }
        },
        shape);
  }

  Shape<double> shape;
  ConvexView<double> convex;
};

/// Overlap along a unit direction, from supports alone.
double overlap_along(const ConvexView<double>& a, const ConvexView<double>& b,
                     const Transform<double>& X_AB, const Vec3<double>& n) {
  const Vec3<double> on_b = X_AB * b.support(-(X_AB.rotation.conjugate() * n));
  return (a.support(n) - on_b).dot(n) + a.rounding + b.rounding;
}

/// Least overlap that a random search of the neighbourhood of `n` finds.
double least_overlap_near(Random& random, const ConvexView<double>& a, const ConvexView<double>& b,
                          const Transform<double>& X_AB, Vec3<double> n) {
  double best = overlap_along(a, b, X_AB, n);
  for (double step = 0.05; step > 1e-9;) {
    const Vec3<double> tried = (n + step * random.in_cube(1.0)).normalized();
    const double overlap = overlap_along(a, b, X_AB, tried);
    if (overlap < best) {
      best = overlap;
      n = tried;
    } else {
      step *= 0.95;
    }
  }
  return best;
}

/// A random pose in which the gap is `gap`, up to 1e-6 of the sizes: B comes in along a random
/// line.
Transform<double> pose_with_gap(Random& random, const ConvexView<double>& a,
                                const ConvexView<double>& b, double gap) {
  const double reach = a.reach + b.reach;
  for (;;) {
    const Vec3<double> away = random.direction<double>();
    const Quat<double> attitude = random.rotation<double>();
    const auto pose_at = [&](double distance) {
      return Transform<double>{attitude,
                               Vec3<double>(a.center - attitude * b.center + distance * away)};
    };
    double near = 0.0;
    double far = 2.0 * reach;
    const auto gap_at = [&](double distance) {
      return contact_normal<FclDistance>(a, b, pose_at(distance), infinity<double>).gap;
    };
    if (gap_at(near) > gap) continue;
    while (far - near > 1e-8 * reach) {
      const double middle = 0.5 * (near + far);
      (gap_at(middle) < gap ? near : far) = middle;
    }
    // The local least depth may jump on the way in, and then no pose on the line has the gap.
    if (std::abs(gap_at(far) - gap) < 1e-6 * reach) return pose_at(far);
  }
}

}  // namespace

TEST_CASE("fcl_contact_normal: two spheres touch along the line of their centres") {
  const Solid solid_a(Sphere<double>{.radius = 1.0});
  const Solid solid_b(Sphere<double>{.radius = 2.0});
  const ConvexView<double>& a = solid_a.convex;
  const ConvexView<double>& b = solid_b.convex;
  const Transform<double> X{.translation = {0.0, 2.9, 0.0}};
  const ContactNormal<double> found = contact_normal<FclDistance>(a, b, X, 0.0);
  CHECK(found.nearness == Nearness::near);
  // Three roundings of numbers of size 3.
  CHECK((found.normal - Vec3<double>::UnitY()).norm() < 1e-15);
  CHECK(found.gap == test::relative(-0.1).epsilon(1e-14));
}

TEST_CASE("fcl_contact_normal: a gap beyond the margin is apart, up to the margin it is near") {
  const Solid solid_a(Sphere<double>{.radius = 1.0});
  const ConvexView<double>& a = solid_a.convex;
  const Transform<double> X{.translation = {2.125, 0.0, 0.0}};
  CHECK(contact_normal<FclDistance>(a, a, X, 0.124).nearness == Nearness::apart);
  CHECK(contact_normal<FclDistance>(a, a, X, 0.126).nearness == Nearness::near);
  CHECK(contact_normal<FclDistance>(a, a, X, 0.126).gap == test::relative(0.125).epsilon(1e-14));
}

TEST_CASE("fcl_contact_normal: a box resting on a box touches along the face's normal") {
  const Solid solid_a(Box<double>{.half_extents = {10.0, 10.0, 0.5}});
  const Solid solid_b(Box<double>{.half_extents = {0.03, 0.03, 0.03}});
  const ConvexView<double>& a = solid_a.convex;
  const ConvexView<double>& b = solid_b.convex;
  // Also at the floor's rim, where the line of centres is far from the normal.
  for (const double x : {0.0, 4.0, 9.99}) {
    const Transform<double> X{.rotation = exp_rotation<double>({0.0, 0.0, 0.3}),
                              .translation = {x, -x / 2.0, 0.5299}};
    const ContactNormal<double> found = contact_normal<FclDistance>(a, b, X, 0.001);
    CHECK((found.normal - Vec3<double>::UnitZ()).norm() < 1e-14);
    // Round-off of the floor's size, 10 m.
    CHECK(std::abs(found.gap + 1e-4) < 1e-14);
  }
}

TEST_CASE("fcl_contact_normal: crossed edges touch along the normal to both") {
  const Solid solid_a(Box<double>{.half_extents = {1.0, 1.0, 1.0}});
  const ConvexView<double>& a = solid_a.convex;
  // A: turned by 45 degrees about x, its edge up at z = sqrt(2); B: about y, its edge down.
  const double quarter = std::acos(-1.0) / 4.0;
  const Transform<double> X_WA{.rotation = exp_rotation<double>({quarter, 0.0, 0.0})};
  const Transform<double> X_WB{.rotation = exp_rotation<double>({0.0, quarter, 0.0}),
                               .translation = {0.1, -0.2, 2.0 * std::sqrt(2.0) - 0.01}};
  const ContactNormal<double> found =
      contact_normal<FclDistance>(a, a, relative_pose(X_WA, X_WB), 0.0);
  CHECK((X_WA.rotate(found.normal) - Vec3<double>::UnitZ()).norm() < 1e-14);
  CHECK(std::abs(found.gap + 0.01) < 1e-14);
}

TEST_CASE("fcl_contact_normal: no direction nearby has less overlap, for every pair of kinds") {
  // Random poses from 5 % apart to 20 % deep. Polyhedra and round cores: the tolerance that GJK is
  // given, 4e-12. Curved cores: what libccd leaves, 1e-7 of the size at the worst seen, with a
  // factor of ten in reserve.
  Random random(20240601);
  for (const double scale : {0.01, 1.0, 100.0}) {
    for (int kind_a = 0; kind_a < convex_kinds; ++kind_a) {
      for (int kind_b = 0; kind_b < convex_kinds; ++kind_b) {
        const auto is_curved = [](int kind) { return kind >= 3 && kind <= 5; };
        const double tolerance = is_curved(kind_a) || is_curved(kind_b) ? 1e-6 : 1e-11;
        int elsewhere = 0;
        for (int i = 0; i < 20; ++i) {
          CAPTURE(kind_a);
          CAPTURE(kind_b);
          CAPTURE(scale);
          CAPTURE(i);
          const Solid solid_a(random_convex(random, kind_a, scale));
          const Solid solid_b(random_convex(random, kind_b, scale));
          const ConvexView<double>& a = solid_a.convex;
          const ConvexView<double>& b = solid_b.convex;
          const Transform<double> X =
              pose_with_gap(random, a, b, scale * random.uniform(-0.2, 0.05));
          const ContactNormal<double> found = contact_normal<FclDistance>(a, b, X, 0.1 * scale);
          REQUIRE(found.nearness == Nearness::near);
          CHECK(std::abs(found.normal.norm() - 1.0) < 1e-14);
          const double overlap = overlap_along(a, b, X, found.normal);
          const double size = std::max(a.reach, b.reach);
          CHECK(std::abs(overlap + found.gap) < 1e-14 * size);
          // The normal found is a local minimum; the random search may step into another valley.
          const double excess = overlap - least_overlap_near(random, a, b, X, found.normal);
          if (excess > tolerance * size) ++elsewhere;
        }
        CHECK(elsewhere <= 1);
      }
    }
  }
}

TEST_CASE("fcl_contact_normal: agrees with fcl::collide where FCL has a closed form") {
  // Box-box, sphere-box, sphere-capsule, sphere-cylinder at depths up to 5 % of the size, where the
  // direction of least depth is not in doubt. FCL's box-box prefers faces to edges by 5 % of depth
  // (its fudge factor), so its depth may be that much larger.
  Random random(7);
  const int pairs[][2] = {{1, 1}, {0, 1}, {0, 2}, {0, 3}, {0, 0}};
  int compared = 0;
  for (const auto& pair : pairs) {
    for (int i = 0; i < 200; ++i) {
      CAPTURE(pair[0]);
      CAPTURE(pair[1]);
      CAPTURE(i);
      const Solid solid_a(random_convex(random, pair[0], 1.0));
      const Solid solid_b(random_convex(random, pair[1], 1.0));
      const ConvexView<double>& a = solid_a.convex;
      const ConvexView<double>& b = solid_b.convex;
      const Transform<double> X = pose_with_gap(random, a, b, random.uniform(-0.05, -0.001));
      const ContactNormal<double> found = contact_normal<FclDistance>(a, b, X, 0.0);

      fcl::Transform3d pose = fcl::Transform3d::Identity();
      pose.linear() = X.rotation_matrix();
      pose.translation() = X.translation;
      fcl::CollisionRequestd request(1, true);
      fcl::CollisionResultd result;
      fcl::collide(to_fcl(solid_a.shape).get(), fcl::Transform3d::Identity(),
                   to_fcl(solid_b.shape).get(), pose, request, result);
      REQUIRE(result.numContacts() == 1);
      const auto& contact = result.getContact(0);
      // The depth FCL gives a box-box contact is that of one of its points; the normal tells more.
      const double depth = overlap_along(a, b, X, contact.normal);
      const double excess = depth + found.gap;
      if (pair[0] == 1) {
        CHECK(excess > -1e-12);
        CHECK(excess < 0.06 * depth);
      } else {
        CHECK(std::abs(excess) < 1e-8);
        // Depth is flat to second order at the least depth.
        CHECK((contact.normal - found.normal).norm() < 1e-3);
      }
      ++compared;
    }
  }
  CHECK(compared == 1000);
}

TEST_CASE("fcl_contact_normal: swapping the solids reverses the normal") {
  Random random(99);
  for (int i = 0; i < 200; ++i) {
    const Solid solid_a(random_convex(random, 1, 1.0));
    const Solid solid_b(random_convex(random, 6, 1.0));
    const ConvexView<double>& a = solid_a.convex;
    const ConvexView<double>& b = solid_b.convex;
    const Transform<double> X = pose_with_gap(random, a, b, random.uniform(-0.01, 0.05));
    const ContactNormal<double> forth = contact_normal<FclDistance>(a, b, X, 0.1);
    const ContactNormal<double> back = contact_normal<FclDistance>(b, a, X.inverse(), 0.1);
    CHECK(std::abs(forth.gap - back.gap) < 1e-11);
    CHECK((forth.normal + X.rotate(back.normal)).norm() < 1e-6);
  }
}

TEST_CASE("fcl_contact_normal: hostile poses end with an answer") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = infinity<double>;
  Random random(5);
  for (int kind_a = 0; kind_a < convex_kinds; ++kind_a) {
    for (int kind_b = 0; kind_b < convex_kinds; ++kind_b) {
      CAPTURE(kind_a);
      CAPTURE(kind_b);
      const Solid solid_a(random_convex(random, kind_a, 1.0));
      const Solid solid_b(random_convex(random, kind_b, 1.0));
      const ConvexView<double>& a = solid_a.convex;
      const ConvexView<double>& b = solid_b.convex;
      const auto nearness = [&](const Transform<double>& X) {
        return contact_normal<FclDistance>(a, b, X, 0.01).nearness;
      };
      CHECK(nearness({.translation = {nan, 0.0, 0.0}}) == Nearness::unknown);
      CHECK(nearness({.rotation = Quat<double>(nan, 0, 0, 0), .translation = {1.0, 0.0, 0.0}}) ==
            Nearness::unknown);
      CHECK(nearness({.translation = {inf, 0.0, 0.0}}) != Nearness::near);
      CHECK(nearness({.translation = {0.0, 1e12, 0.0}}) == Nearness::apart);
      CHECK(nearness({.translation = {0.0, 1e300, 0.0}}) != Nearness::near);
      // Coincident centres, equal attitude: any answer that separates them.
      const ContactNormal<double> deep = contact_normal<FclDistance>(a, b, {}, 0.01);
      CHECK(deep.nearness == Nearness::near);
      CHECK(deep.gap < 0.0);
      CHECK(std::abs(deep.normal.norm() - 1.0) < 1e-14);
    }
  }
}
