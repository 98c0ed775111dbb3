// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/contacts/contact_clip.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <support/random.hpp>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

template <typename S, typename A, typename B>
ContactManifold<S> manifold_of(const A& a, const B& b, const Transform<S>& X_AB,
                               const Vec3<S>& normal, S margin) {
  ContactManifolds<S> out;
  const bool is_found = build_manifold(a, b, X_AB, normal, margin, out);
  REQUIRE(is_found == (out.size() == 1));
  return is_found ? out[0] : ContactManifold<S>{};
}

template <typename S>
std::set<std::uint32_t> features(const ContactManifold<S>& m) {
  std::set<std::uint32_t> names;
  for (std::size_t i = 0; i < m.size; ++i) names.insert(m.points[i].feature);
  return names;
}

template <typename S>
S deepest_of(const ContactManifold<S>& m) {
  S gap = infinity<S>;
  for (std::size_t i = 0; i < m.size; ++i) gap = std::min(gap, m.points[i].gap);
  return gap;
}

}  // namespace

TEST_CASE_TEMPLATE("build_manifold: overlapping faces meet in the corners of their overlap", S,
                   float, double) {
  const Box<S> a{{S(1), S(1), S(1)}};
  const Box<S> b{{S(1), S(0.5), S(1)}};
  Transform<S> X_AB;
  X_AB.translation = {S(0.5), S(0), S(1.9)};
  const auto m = manifold_of<S>(a, b, X_AB, Vec3<S>::UnitZ(), S(0));
  REQUIRE(m.size == 4);
  CHECK(m.normal == Vec3<S>(S(0), S(0), S(1)));
  CHECK(features(m).size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3<S>& p = m.points[i].position;
    // The overlap is -0.5..1 by -0.5..0.5; halfway between 0.9 and 1.
    CHECK(std::abs(std::abs(p.y()) - S(0.5)) <= Tolerance<S>::round_off());
    CHECK(std::min(std::abs(p.x() + S(0.5)), std::abs(p.x() - S(1))) <= Tolerance<S>::round_off());
    CHECK(std::abs(p.z() - S(0.95)) <= Tolerance<S>::round_off());
    CHECK(std::abs(m.points[i].gap + S(0.1)) <= S(2) * Tolerance<S>::round_off());
  }
}

TEST_CASE_TEMPLATE("build_manifold: equal faces neither lose nor double a corner", S, float,
                   double) {
  Random random(61);
  for (int i = 0; i < 500; ++i) {
    const Box<S> box{(random.in_cube(S(0.4)) + Vec3<S>::Constant(S(0.5))) *
                     std::exp2(random.uniform(S(-10), S(10)))};
    // Rounding of the pose moves the corners by ulps to either side of the other's edges.
    const Transform<S> X_WA = random.pose(box.half_extents.maxCoeff());
    Transform<S> X_WB = X_WA;
    X_WB.translation += X_WA.rotate(Vec3<S>(S(0), S(0), S(2) * box.half_extents.z()));
    const auto m = manifold_of<S>(box, box, relative_pose(X_WA, X_WB), Vec3<S>::UnitZ(),
                                  S(0.01) * box.half_extents.z());
    CHECK(m.size == 4);
  }
}

TEST_CASE_TEMPLATE("build_manifold: names of contacts stay while a box slides and tips", S, float,
                   double) {
  const Box<S> table{{S(2), S(2), S(0.5)}};
  const Box<S> box{{S(0.3), S(0.2), S(0.1)}};
  std::set<std::uint32_t> names;
  for (int i = 0; i < 50; ++i) {
    const S t = S(i) / S(50);
    const Transform<S> X_AB{exp_rotation<S>({S(0.01) * t, S(-0.02) * t, S(3) * t}),
                            {t, S(-0.5) * t, S(0.6)}};
    const auto m = manifold_of<S>(table, box, X_AB, Vec3<S>::UnitZ(), S(0.05));
    REQUIRE(m.size == 4);
    if (i == 0) names = features(m);
    CHECK(features(m) == names);
  }
}

TEST_CASE_TEMPLATE("build_manifold: a tipped box has its low corners first in depth", S, float,
                   double) {
  const Box<S> table{{S(2), S(2), S(0.5)}};
  const Box<S> box{{S(0.3), S(0.2), S(0.1)}};
  const S angle = S(0.1);
  Transform<S> X_AB{exp_rotation<S>({S(0), angle, S(0)}), {S(0), S(0), S(0)}};
  // Lowest edge at the table's top.
  X_AB.translation.z() = S(0.5) + S(0.3) * std::sin(angle) + S(0.1) * std::cos(angle);
  const auto all = manifold_of<S>(table, box, X_AB, Vec3<S>::UnitZ(), S(1));
  REQUIRE(all.size == 4);
  int touching = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const S gap = all.points[i].gap;
    const bool is_low = gap < S(0.01);
    touching += is_low ? 1 : 0;
    CHECK(std::abs(gap - (is_low ? S(0) : S(0.6) * std::sin(angle))) <=
          S(4) * Tolerance<S>::round_off());
  }
  CHECK(touching == 2);
  // A margin between the two leaves the touching edge.
  CHECK(manifold_of<S>(table, box, X_AB, Vec3<S>::UnitZ(), S(0.01)).size == 2);
  CHECK(manifold_of<S>(table, box, X_AB, Vec3<S>::UnitZ(), S(-0.01)).size == 0);
}

TEST_CASE_TEMPLATE("build_manifold: crossed edges meet in one point", S, float, double) {
  // Two bars of square section, each on its edge, across each other.
  const Box<S> a{{S(2), S(0.5), S(0.5)}};
  const Box<S> b{{S(0.5), S(2), S(0.5)}};
  const S quarter = S(std::numbers::pi / 4);
  const S reach = std::sqrt(S(0.5));
  const Transform<S> X_WA{exp_rotation<S>({quarter, S(0), S(0)}), Vec3<S>::Zero()};
  const Transform<S> X_WB{exp_rotation<S>({S(0), quarter, S(0)}),
                          {S(0.3), S(-0.2), S(2) * reach - S(0.01)}};
  const Vec3<S> normal = X_WA.inverse().rotate(Vec3<S>::UnitZ());
  const auto m = manifold_of<S>(a, b, relative_pose(X_WA, X_WB), normal, S(0));
  REQUIRE(m.size == 1);
  CHECK(std::abs(m.points[0].gap + S(0.01)) <= S(4) * Tolerance<S>::round_off());
  const Vec3<S> position = X_WA * m.points[0].position;
  CHECK((position - Vec3<S>(S(0.3), S(0), reach - S(0.005))).norm() <=
        S(8) * Tolerance<S>::round_off());
}

TEST_CASE_TEMPLATE("build_manifold: a rough normal still finds the contact", S, float, double) {
  Random random(62);
  const Box<S> table{{S(2), S(2), S(0.5)}};
  const Box<S> box{{S(0.3), S(0.2), S(0.1)}};
  for (int i = 0; i < 200; ++i) {
    const Transform<S> X_AB{exp_rotation<S>({S(0), S(0), random.uniform(S(0), S(6))}),
                            {S(0.2), S(0.1), S(0.6) - S(0.001)}};
    const Vec3<S> normal = (Vec3<S>::UnitZ() + S(1e-4) * random.direction<S>()).normalized();
    const auto m = manifold_of<S>(table, box, X_AB, normal, S(0));
    CHECK(m.size == 4);
    CHECK(std::abs(deepest_of(m) + S(0.001)) < S(3e-4));
  }
}

TEST_CASE_TEMPLATE("build_manifold: a round face keeps four contacts and the deepest", S, float,
                   double) {
  Random random(63);
  const Box<S> table{{S(2), S(2), S(0.5)}};
  const Cylinder<S> cylinder{S(0.5), S(0.4)};
  for (int i = 0; i < 300; ++i) {
    const S tilt = i % 3 == 0 ? S(0) : random.uniform(S(0), S(0.3));
    const S heading = random.uniform(S(0), S(6));
    const Vec3<S> axis(std::cos(heading), std::sin(heading), S(0));
    Transform<S> X_AB{exp_rotation<S>(tilt * axis), Vec3<S>::Zero()};
    X_AB.translation.z() = S(0.5) + S(0.5) * std::sin(tilt) + S(0.4) * std::cos(tilt) - S(0.01);
    const auto m = manifold_of<S>(table, cylinder, X_AB, Vec3<S>::UnitZ(), S(1));
    CHECK(m.size == 4);
    CHECK(features(m).size() == 4);
    CHECK(std::abs(deepest_of(m) + S(0.01)) <= S(8) * Tolerance<S>::round_off());
    // They hold the cylinder up on all sides: around its middle for an upright one.
    if (tilt > S(0)) continue;
    Vec3<S> middle = Vec3<S>::Zero();
    for (std::size_t k = 0; k < 4; ++k) middle += m.points[k].position / S(4);
    CHECK(middle.template head<2>().norm() < S(0.01));
  }
}

TEST_CASE_TEMPLATE(
    "build_manifold: more corners than a manifold holds are thinned to the outer ones", S, float,
    double) {
  // Two prisms of 16 sides, on each other and turned by half a side: 32 corners in common.
  std::vector<Vec3<S>> points;
  for (int i = 0; i < 16; ++i) {
    const S angle = S(std::numbers::pi / 8) * S(i);
    points.push_back({std::cos(angle), std::sin(angle), S(0.5)});
    points.push_back({std::cos(angle), std::sin(angle), S(-0.5)});
  }
  const ConvexHull<S> prism = convex_hull<S>(std::span<const Vec3<S>>(points));
  const Transform<S> X_AB{exp_rotation<S>({S(0), S(0), S(std::numbers::pi / 16)}),
                          {S(0), S(0), S(1)}};
  const auto m = manifold_of<S>(prism, prism, X_AB, Vec3<S>::UnitZ(), S(0.001));
  REQUIRE(m.size == 8);
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      CHECK((m.points[i].position - m.points[k].position).norm() > S(0.5));
    }
  }
}

TEST_CASE_TEMPLATE("build_manifold: points and lines against faces", S, float, double) {
  const Box<S> table{{S(2), S(2), S(0.5)}};
  Transform<S> X_AB;
  X_AB.translation = {S(0.3), S(0.4), S(0.7)};
  const auto ball = manifold_of<S>(table, Sphere<S>{S(0.2)}, X_AB, Vec3<S>::UnitZ(), S(0.1));
  REQUIRE(ball.size == 1);
  CHECK((ball.points[0].position - Vec3<S>(S(0.3), S(0.4), S(0.5))).norm() <=
        Tolerance<S>::round_off());
  // A capsule that lies over the edge of the table touches up to the edge.
  X_AB = {exp_rotation<S>({S(0), S(std::numbers::pi / 2), S(0)}), {S(1.8), S(0), S(0.7)}};
  const auto lying =
      manifold_of<S>(table, Capsule<S>{S(0.2), S(1)}, X_AB, Vec3<S>::UnitZ(), S(0.1));
  REQUIRE(lying.size == 2);
  const S x0 = lying.points[0].position.x();
  const S x1 = lying.points[1].position.x();
  CHECK(std::abs(std::max(x0, x1) - S(2)) <= S(4) * Tolerance<S>::round_off());
  CHECK(std::abs(std::min(x0, x1) - S(0.8)) <= S(4) * Tolerance<S>::round_off());
  // And the key is passed on.
  ContactManifolds<S> out;
  CHECK(build_manifold(table, Capsule<S>{S(0.2), S(1)}, X_AB, Vec3<S>(Vec3<S>::UnitZ()), S(0.1),
                       out, 42u));
  CHECK(out[0].key == 42);
}

// All corners of a face across the normal are as far as each other, so that none of them tells a
// place.
TEST_CASE_TEMPLATE("extreme_contact: of the farthest points a face's tells no place", S, float,
                   double) {
  const Box<S> table{{S(2), S(2), S(0.5)}};
  const Capsule<S> pin{S(0.2), S(1)};
  const Quat<S> tilt = exp_rotation<S>({S(0), S(1), S(0)});
  const Transform<S> X_AB{tilt, {S(0.3), S(0.4), S(1)}};
  const Vec3<S> up = Vec3<S>::UnitZ();
  const Vec3<S> end = X_AB * Vec3<S>(0, 0, -1) - S(0.2) * up;
  const S tolerance = S(4) * Tolerance<S>::round_off();
  const ContactPoint<S> on_table = extreme_contact(table, pin, X_AB, up);
  CHECK(std::abs(on_table.gap - (end.z() - S(0.5))) <= tolerance);
  CHECK((on_table.position - Vec3<S>(end.x(), end.y(), S(0.5) * (end.z() + S(0.5)))).norm() <=
        tolerance);
  // The same seen from the capsule.
  const Transform<S> X_BA = X_AB.inverse();
  const ContactPoint<S> on_pin =
      extreme_contact(pin, table, X_BA, Vec3<S>(X_BA.rotate(Vec3<S>(-up))));
  CHECK((X_AB * on_pin.position - on_table.position).norm() <= tolerance);
}

TEST_CASE_TEMPLATE("build_manifold: the same at one hundredth and a hundred times the size", S,
                   float, double) {
  Random random(64);
  for (int i = 0; i < 200; ++i) {
    const Quat<S> q = random.rotation<S>();
    const Vec3<S> p = S(1.2) * random.direction<S>();
    const Vec3<S> normal = p.normalized();
    const auto at_scale = [&](S u) {
      return manifold_of<S>(Box<S>{u * Vec3<S>(S(0.5), S(0.6), S(0.7))},
                            Box<S>{u * Vec3<S>(S(0.6), S(0.4), S(0.5))}, Transform<S>{q, u * p},
                            normal, S(0.1) * u);
    };
    const auto expected = at_scale(S(1));
    for (const S u : {S(1.0 / 128.0), S(128)}) {
      const auto m = at_scale(u);
      REQUIRE(m.size == expected.size);
      for (std::size_t k = 0; k < m.size; ++k) {
        CHECK(m.points[k].gap == u * expected.points[k].gap);
        CHECK(m.points[k].feature == expected.points[k].feature);
      }
    }
  }
}
