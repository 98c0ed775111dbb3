// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/contacts/analytic_contacts.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <support/random.hpp>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

template <typename S, typename A, typename B>
ContactManifolds<S> contacts(const A& a, const B& b, const Transform<S>& X_AB, S margin) {
  ContactManifolds<S> out;
  collide_shapes(a, b, X_AB, margin, out);
  return out;
}

template <typename S>
Transform<S> at(S x, S y, S z) {
  return {Quat<S>::Identity(), {x, y, z}};
}

template <typename S>
constexpr S tolerance = S(4) * Tolerance<S>::round_off();

}  // namespace

TEST_CASE_TEMPLATE("collide_shapes: two balls, at the point between them", S, float, double) {
  const Sphere<S> a{S(1)};
  const Sphere<S> b{S(0.5)};
  // 3-4-5: centres 1.25 apart.
  const auto out = contacts(a, b, at<S>(S(0), S(0.75), S(1)), S(0));
  REQUIRE(out.size() == 1);
  CHECK((out[0].normal - Vec3<S>(S(0), S(0.6), S(0.8))).norm() <= tolerance<S>);
  CHECK(std::abs(out[0].points[0].gap + S(0.25)) <= tolerance<S>);
  // Surfaces at 1 and 0.75 along the normal.
  CHECK((out[0].points[0].position - S(0.875) * out[0].normal).norm() <= tolerance<S>);
  CHECK(contacts(a, b, at<S>(S(0), S(0), S(1.6)), S(0.05)).empty());
  CHECK(contacts(a, b, at<S>(S(0), S(0), S(1.6)), S(0.11)).size() == 1);
}

TEST_CASE_TEMPLATE("collide_shapes: concentric balls part along z", S, float, double) {
  const auto out = contacts(Sphere<S>{S(1)}, Sphere<S>{S(0.5)}, Transform<S>{}, S(0));
  REQUIRE(out.size() == 1);
  CHECK(out[0].normal == Vec3<S>(S(0), S(0), S(1)));
  CHECK(out[0].points[0].gap == S(-1.5));
  // A distance too small to be squared still has a direction.
  const S tiny = std::numeric_limits<S>::min();
  const auto near = contacts(Sphere<S>{S(1)}, Sphere<S>{S(0.5)}, at<S>(tiny, S(0), S(0)), S(0));
  REQUIRE(near.size() == 1);
  CHECK(std::abs(near[0].normal.norm() - S(1)) <= tolerance<S>);
}

TEST_CASE_TEMPLATE("collide_shapes: a ball leaves a box through the nearest face", S, float,
                   double) {
  const Box<S> box{{S(1), S(2), S(3)}};
  const Sphere<S> ball{S(0.5)};
  const auto out = contacts(box, ball, at<S>(S(-0.9), S(0.5), S(0)), S(0));
  REQUIRE(out.size() == 1);
  CHECK(out[0].normal == Vec3<S>(S(-1), S(0), S(0)));
  CHECK(std::abs(out[0].points[0].gap + S(0.6)) <= tolerance<S>);
  // Halfway between the face at -1 and the ball's far side at -0.4.
  CHECK((out[0].points[0].position - Vec3<S>(S(-0.7), S(0.5), S(0))).norm() <= tolerance<S>);
  // Through the surface nothing jumps.
  const S h = S(1e-3);
  S last = S(0);
  for (int i = -10; i <= 10; ++i) {
    const auto slide = contacts(box, ball, at<S>(S(1) + h * S(i), S(0.5), S(0.2)), S(1));
    REQUIRE(slide.size() == 1);
    CHECK((slide[0].normal - Vec3<S>::UnitX()).norm() <= tolerance<S>);
    if (i > -10) CHECK(std::abs(slide[0].points[0].gap - last - h) <= tolerance<S>);
    last = slide[0].points[0].gap;
  }
  // In the very middle the first axis with the least half extent.
  CHECK(contacts(box, ball, Transform<S>{}, S(0))[0].normal == Vec3<S>(S(1), S(0), S(0)));
}

TEST_CASE_TEMPLATE("collide_shapes: capsules against all points of their segments", S, float,
                   double) {
  // The closest pair found by scanning both segments.
  Random random(81);
  const Capsule<S> a{S(0.1), S(0.7)};
  const Capsule<S> b{S(0.2), S(0.5)};
  for (int i = 0; i < 300; ++i) {
    Transform<S> X_AB = random.pose(S(1));
    if (i % 5 == 0) X_AB.rotation = exp_rotation<S>({S(0), S(1e-4) * S(i), S(0)});
    if (i % 10 == 0) X_AB.rotation = Quat<S>::Identity();
    const Vec3<S> axis = X_AB.rotate(Vec3<S>::UnitZ());
    constexpr int steps = 200;
    S nearest = infinity<S>;
    for (int u = 0; u <= steps; ++u) {
      const Vec3<S> on_a(S(0), S(0), S(0.7) * (S(2 * u) / S(steps) - S(1)));
      // The point of B's segment that is closest to it, exactly.
      const S t = std::clamp(axis.dot(on_a - X_AB.translation), S(-0.5), S(0.5));
      nearest = std::min(nearest, (X_AB.translation + t * axis - on_a).norm());
    }
    const auto out = contacts(a, b, X_AB, S(10));
    REQUIRE(out.size() == 1);
    S gap = infinity<S>;
    for (std::size_t k = 0; k < out[0].size; ++k) gap = std::min(gap, out[0].points[k].gap);
    // The scan misses the minimum by at most half a step along A, which is across the distance.
    CHECK(gap <= nearest - S(0.3) + tolerance<S>);
    CHECK(gap >= nearest - S(0.3) - S(0.004));
  }
}

TEST_CASE_TEMPLATE("collide_shapes: capsules that lie along each other have two contacts", S, float,
                   double) {
  const Capsule<S> capsule{S(0.1), S(1)};
  const auto out = contacts(capsule, capsule, at<S>(S(0.2), S(0), S(1.5)), S(0.01));
  REQUIRE(out.size() == 1);
  REQUIRE(out[0].size == 2);
  // From 0.5 to 1 along z.
  const S low = std::min(out[0].points[0].position.z(), out[0].points[1].position.z());
  const S high = std::max(out[0].points[0].position.z(), out[0].points[1].position.z());
  CHECK(std::abs(low - S(0.5)) <= tolerance<S>);
  CHECK(std::abs(high - S(1)) <= tolerance<S>);
  // The same axis twice, and crossed axes: across them, whatever rounding.
  const auto same = contacts(capsule, capsule, Transform<S>{}, S(0));
  REQUIRE(same.size() == 1);
  CHECK(same[0].normal == Vec3<S>(S(1), S(0), S(0)));
  const Transform<S> crossed{exp_rotation<S>({S(std::numbers::pi / 2), S(0), S(0)}),
                             Vec3<S>::Zero()};
  const auto cross = contacts(capsule, capsule, crossed, S(0));
  REQUIRE(cross.size() == 1);
  CHECK(std::abs(std::abs(cross[0].normal.x()) - S(1)) <= tolerance<S>);
  CHECK(std::abs(cross[0].points[0].gap + S(0.2)) <= tolerance<S>);
}

TEST_CASE_TEMPLATE("collide_shapes: the lowest point of every shape over a slope", S, float,
                   double) {
  Random random(82);
  const HalfSpace<S> slope{Vec3<S>(S(1), S(2), S(2)) / S(3), S(0.3)};
  const auto check = [&](const auto& shape) {
    for (int i = 0; i < 100; ++i) {
      const Transform<S> X_AB = random.pose(S(1));
      const Vec3<S> down_B = X_AB.inverse().rotate(-slope.normal);
      const S lowest = slope.normal.dot(X_AB * support_point(shape, down_B)) - slope.offset;
      const auto out = contacts(slope, shape, X_AB, S(0.1));
      REQUIRE(out.empty() == (lowest > S(0.1)));
      if (out.empty()) continue;
      CHECK(out[0].normal == slope.normal);
      S gap = infinity<S>;
      for (std::size_t k = 0; k < out[0].size; ++k) {
        const ContactPoint<S>& p = out[0].points[k];
        gap = std::min(gap, p.gap);
        // Halfway between the plane and the shape.
        CHECK(std::abs(slope.normal.dot(p.position) - slope.offset - S(0.5) * p.gap) <=
              tolerance<S>);
      }
      CHECK(std::abs(gap - lowest) <= tolerance<S>);
    }
  };
  check(Sphere<S>{S(0.5)});
  check(Box<S>{{S(0.3), S(0.4), S(0.5)}});
  check(Capsule<S>{S(0.2), S(0.4)});
  check(Cylinder<S>{S(0.4), S(0.3)});
  check(Cone<S>{S(0.4), S(0.3)});
  check(Ellipsoid<S>{{S(0.3), S(0.4), S(0.5)}});
}
