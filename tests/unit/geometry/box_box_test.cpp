// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/box_box.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <support/random.hpp>
#include <vector>

using namespace bristle;
using bristle::test::Random;

namespace {

template <typename S>
ContactManifolds<S> contacts(const Box<S>& a, const Box<S>& b, const Transform<S>& X_AB, S margin) {
  ContactManifolds<S> out;
  collide_shapes(a, b, X_AB, margin, out);
  return out;
}

template <typename S>
S deepest(const ContactManifolds<S>& manifolds) {
  S gap = infinity<S>;
  for (const auto& m : manifolds) {
    for (std::size_t i = 0; i < m.size; ++i) gap = std::min(gap, m.points[i].gap);
  }
  return gap;
}

/// Largest separation along any of many directions, by supports: what a separating axis test finds,
/// found without knowing the axes.
template <typename S>
S sampled_separation(const Box<S>& a, const Box<S>& b, const Transform<S>& X_AB, Random& random) {
  const auto separation = [&](const Vec3<S>& n) {
    const Vec3<S> on_b = X_AB * support_point(b, Vec3<S>(X_AB.inverse().rotate(-n)));
    return n.dot(on_b - support_point(a, n));
  };
  Vec3<S> best = X_AB.translation.normalized();
  for (int i = 0; i < 500; ++i) {
    const Vec3<S> n = random.direction<S>();
    if (separation(n) > separation(best)) best = n;
  }
  for (S step = S(0.3); step > S(1e-6); step *= S(0.8)) {
    for (int i = 0; i < 8; ++i) {
      const Vec3<S> n = (best + step * random.direction<S>()).normalized();
      if (separation(n) > separation(best)) best = n;
    }
  }
  return separation(best);
}

}  // namespace

TEST_CASE_TEMPLATE("collide_shapes: two boxes face to face have four contacts at the overlap", S,
                   float, double) {
  const Box<S> a{{S(1), S(1), S(1)}};
  const Box<S> b{{S(0.5), S(0.5), S(0.5)}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const S sign : {S(1), S(-1)}) {
      Transform<S> X_AB;
      X_AB.translation = sign * S(1.49) * Vec3<S>::Unit(axis);
      const auto out = contacts(a, b, X_AB, S(0));
      REQUIRE(out.size() == 1);
      CHECK(out[0].size == 4);
      CHECK(out[0].normal == sign * Vec3<S>::Unit(axis));
      CHECK(std::abs(deepest(out) + S(0.01)) <= Tolerance<S>::round_off());
    }
  }
}

TEST_CASE_TEMPLATE("collide_shapes: boxes at rest on each other meet in the same four corners", S,
                   float, double) {
  Random random(71);
  const Box<S> box{{S(0.03), S(0.03), S(0.03)}};
  for (int i = 0; i < 1000; ++i) {
    // Sunk in by a little, turned by a little: what a solver leaves.
    const Transform<S> X_AB{exp_rotation<S>(S(1e-4) * random.direction<S>()),
                            {random.uniform(S(-0.01), S(0.01)), random.uniform(S(-0.01), S(0.01)),
                             S(0.06) - random.uniform(S(0), S(1e-5))}};
    const auto out = contacts(box, box, X_AB, S(1e-4));
    REQUIRE(out.size() == 1);
    // The normal is that of one of the two faces, which is as good as the other.
    CHECK((out[0].normal - Vec3<S>::UnitZ()).norm() <= S(1.1e-4));
    CHECK(out[0].size == 4);
  }
}

TEST_CASE_TEMPLATE("collide_shapes: the depth of two boxes is the least over all directions", S,
                   float, double) {
  Random random(72);
  int edge_count = 0;
  for (int i = 0; i < 300; ++i) {
    const Box<S> a{random.in_cube(S(0.4)) + Vec3<S>::Constant(S(0.5))};
    const Box<S> b{random.in_cube(S(0.4)) + Vec3<S>::Constant(S(0.5))};
    const Transform<S> X_AB = random.pose(S(0.8));
    const S separation = sampled_separation(a, b, X_AB, random);
    const auto out = contacts(a, b, X_AB, S(0));
    CAPTURE(i);
    if (separation > S(0)) {
      CHECK(out.empty());
      continue;
    }
    REQUIRE(out.size() == 1);
    // A face may be taken that is a twentieth deeper; sampling is good to 1e-3.
    CHECK(-deepest(out) <= -separation * S(1.12) + S(1e-3));
    CHECK(-deepest(out) >= -separation * S(0.5) - S(1e-3));
    edge_count += out[0].normal.cwiseAbs().maxCoeff() < S(0.999) ? 1 : 0;
  }
  CHECK(edge_count > 20);
}

TEST_CASE_TEMPLATE("collide_shapes: crossed edges of two boxes, apart, have their distance", S,
                   float, double) {
  const Box<S> a{{S(2), S(0.5), S(0.5)}};
  const Box<S> b{{S(0.5), S(2), S(0.5)}};
  const S quarter = std::atan(S(1));
  const Transform<S> X_WA{exp_rotation<S>({quarter, S(0), S(0)}), Vec3<S>::Zero()};
  for (const S gap : {S(0.02), S(-0.02)}) {
    const Transform<S> X_WB{exp_rotation<S>({S(0), quarter, S(0)}),
                            {S(0.1), S(0.2), std::sqrt(S(2)) + gap}};
    const auto out = contacts(a, b, relative_pose(X_WA, X_WB), S(0.03));
    REQUIRE(out.size() == 1);
    REQUIRE(out[0].size == 1);
    CHECK(std::abs(out[0].points[0].gap - gap) <= S(4) * Tolerance<S>::round_off());
    CHECK((X_WA.rotate(out[0].normal) - Vec3<S>::UnitZ()).norm() <=
          S(4) * Tolerance<S>::round_off());
  }
}

TEST_CASE_TEMPLATE(
    "collide_shapes: boxes beside each other's edges and corners keep their distance", S, float,
    double) {
  const Box<S> box{{S(1), S(1), S(1)}};
  Transform<S> X_AB;
  // No face of one is over a face of the other: what is nearest are two parallel edges, then two
  // corners. Round-off of coordinates of 2.
  const S tolerance = S(4) * Tolerance<S>::round_off();
  const S apart = S(0.01);
  for (const Vec3<S>& away : {Vec3<S>(S(1), S(-1), S(0)), Vec3<S>(S(1), S(-1), S(1))}) {
    const Vec3<S> normal = away.normalized();
    X_AB.translation = S(2) * away + apart * normal;
    const auto found = contacts(box, box, X_AB, S(0.05));
    REQUIRE(found.size() == 1);
    CHECK(found[0].size == (away.z() == S(0) ? 2 : 1));
    CHECK(std::abs(deepest(found) - apart) <= tolerance);
    // The direction of a distance is its error relative to that distance.
    CHECK((found[0].normal - normal).norm() <= tolerance / apart);
    CHECK(contacts(box, box, X_AB, S(0.009)).empty());
  }
  X_AB.translation = {S(2.01), S(1.99), S(0)};
  CHECK(contacts(box, box, X_AB, S(0.05)).size() == 1);
}

TEST_CASE_TEMPLATE("collide_shapes: no box comes within the margin without a contact", S, float,
                   double) {
  // Whatever way a small box passes: if a corner of it is within the margin of the other box, which
  // that corner's distance tells in closed form, there is a contact no farther than that.
  Random random(31);
  const Box<S> a{{S(1), S(0.7), S(0.4)}};
  const Box<S> b{{S(0.2), S(0.1), S(0.3)}};
  int near = 0;
  for (int i = 0; i < 4000; ++i) {
    const Transform<S> X = random.pose(S(1.5));
    const S margin = S(0.2);
    S distance = infinity<S>;
    for (unsigned k = 0; k < 8; ++k) {
      const Vec3<S> sign(k & 1 ? S(1) : S(-1), k & 2 ? S(1) : S(-1), k & 4 ? S(1) : S(-1));
      const Vec3<S> corner = X * Vec3<S>(sign.cwiseProduct(b.half_extents));
      distance =
          std::min(distance, (corner.cwiseAbs() - a.half_extents).cwiseMax(Vec3<S>::Zero()).norm());
    }
    // What box_box.hpp takes for no difference of gaps.
    const S tolerance = S(2) * Tolerance<S>::equal();
    if (!(distance < margin - tolerance)) continue;
    ++near;
    CHECK(deepest(contacts(a, b, X, margin)) <= distance + tolerance);
  }
  CHECK(near > 1000);
}
