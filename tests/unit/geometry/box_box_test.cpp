// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/contacts/box_box.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <support/random.hpp>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

template <typename S>
ContactManifolds<S> box_contacts(const Box<S>& a, const Box<S>& b, const Transform<S>& X_AB,
                                 S margin) {
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
      const auto out = box_contacts(a, b, X_AB, S(0));
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
    const auto out = box_contacts(box, box, X_AB, S(1e-4));
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
    const auto out = box_contacts(a, b, X_AB, S(0));
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
    const auto out = box_contacts(a, b, relative_pose(X_WA, X_WB), S(0.03));
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
    const auto found = box_contacts(box, box, X_AB, S(0.05));
    REQUIRE(found.size() == 1);
    CHECK(found[0].size == (away.z() == S(0) ? 2 : 1));
    CHECK(std::abs(deepest(found) - apart) <= tolerance);
    // The direction of a distance is its error relative to that distance.
    CHECK((found[0].normal - normal).norm() <= tolerance / apart);
    CHECK(box_contacts(box, box, X_AB, S(0.009)).empty());
  }
  X_AB.translation = {S(2.01), S(1.99), S(0)};
  CHECK(box_contacts(box, box, X_AB, S(0.05)).size() == 1);
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
    // box_box.hpp treats gaps within this tolerance as equal.
    const S tolerance = S(2) * Tolerance<S>::equal();
    if (!(distance < margin - tolerance)) continue;
    ++near;
    CHECK(deepest(box_contacts(a, b, X, margin)) <= distance + tolerance);
  }
  CHECK(near > 1000);
}

TEST_CASE("collide_shapes: two boxes have the contacts that clipping of any shapes finds") {
  // clip_features() intersects the same faces and edges without knowing that they are of boxes. In
  // float a corner in a thousand lies so near a side that one keeps it and the other cuts it.
  using S = double;
  Random random(73);
  int face_count = 0;
  int edge_count = 0;
  for (int i = 0; i < 3000; ++i) {
    const S size = std::exp2(random.uniform(S(-8), S(8)));
    const Box<S> a{(random.in_cube(S(0.4)) + Vec3<S>::Constant(S(0.5))) * size};
    const Box<S> b{(random.in_cube(S(0.4)) + Vec3<S>::Constant(S(0.5))) * size};
    Transform<S> X_AB = random.pose(S(1.1) * size);
    if (i % 3 == 0) X_AB.rotation = exp_rotation<S>(S(0.02) * random.direction<S>());
    const S margin = S(0.03) * size;
    const auto out = box_contacts(a, b, X_AB, margin);
    if (out.empty()) continue;
    CAPTURE(i);
    REQUIRE(out.size() == 1);
    const ContactManifold<S>& m = out[0];
    const auto features = detail::feature_pair(a, b, X_AB, m.normal);
    const ContactManifold<S> expected =
        detail::clip_features(features.a, features.b, m.normal, margin);
    // Both are sums of a handful of products of coordinates up to twice the size; a crossing of
    // edges divides by the sine of their angle, which is at least edge_across_sine, 1 / 20, twice.
    const S tolerance = S(100) * Tolerance<S>::round_off() * size;
    // A contact that one has and the other has not is at the margin, or beside one it has.
    const auto is_in = [&](const ContactPoint<S>& p, const ContactManifold<S>& others) {
      if (p.gap > margin - tolerance) return true;
      for (std::size_t k = 0; k < others.size; ++k) {
        const ContactPoint<S>& q = others.points[k];
        const S apart = (q.position - p.position).norm();
        if (apart <= tolerance && std::abs(q.gap - p.gap) <= tolerance) return true;
        if (apart <= S(4) * Tolerance<S>::equal() * size) return true;
      }
      return false;
    };
    std::set<std::uint32_t> names;
    for (std::size_t k = 0; k < m.size; ++k) {
      CHECK(is_in(m.points[k], expected));
      names.insert(m.points[k].feature);
    }
    for (std::size_t k = 0; k < expected.size; ++k) CHECK(is_in(expected.points[k], m));
    CHECK(names.size() == m.size);
    const Vec3<S> normal_B = X_AB.inverse().rotate(m.normal);
    const bool is_face =
        std::max(m.normal.cwiseAbs().maxCoeff(), normal_B.cwiseAbs().maxCoeff()) > S(0.9999);
    (is_face ? face_count : edge_count) += 1;
  }
  CHECK(face_count > 300);
  CHECK(edge_count > 100);
}

TEST_CASE_TEMPLATE("collide_shapes: equal boxes that jitter keep their four contacts and names", S,
                   float, double) {
  Random random(74);
  // From the last bit to a tenth of what counts as one place.
  const S smallest = std::log2(std::numeric_limits<S>::epsilon());
  const S largest = std::log2(beside_tolerance<S>() / S(10));
  for (int i = 0; i < 300; ++i) {
    const S size = std::exp2(random.uniform(S(-8), S(8)));
    const Box<S> box{(random.in_cube(S(0.4)) + Vec3<S>::Constant(S(0.5))) * size};
    const int axis = i % 3;
    const S side = i % 2 == 0 ? S(1) : S(-1);
    std::set<std::uint32_t> names;
    for (int k = 0; k < 20; ++k) {
      const S jitter = std::exp2(random.uniform(smallest, largest));
      Transform<S> X_AB{exp_rotation<S>(jitter * random.direction<S>()),
                        size * jitter * random.direction<S>()};
      X_AB.translation[axis] += S(2) * side * box.half_extents[axis];
      const auto out = box_contacts(box, box, X_AB, S(0.01) * size);
      REQUIRE(out.size() == 1);
      REQUIRE(out[0].size == 4);
      std::set<std::uint32_t> now;
      for (std::size_t p = 0; p < 4; ++p) now.insert(out[0].points[p].feature);
      CHECK(now.size() == 4);
      if (k == 0) names = now;
      CHECK(now == names);
    }
  }
}

TEST_CASE_TEMPLATE("collide_shapes: boxes that meet at an edge or a corner keep their normal", S,
                   float, double) {
  Random random(75);
  const S largest = std::log2(Tolerance<S>::equal() / S(10));
  for (int i = 0; i < 200; ++i) {
    const S size = std::exp2(random.uniform(S(-8), S(8)));
    const Box<S> box{(random.in_cube(S(0.4)) + Vec3<S>::Constant(S(0.5))) * size};
    // Neighbours in a block of equal boxes, along a diagonal of a face or of the box.
    Vec3<S> apart = S(2) * box.half_extents;
    for (Eigen::Index k = 0; k < 3; ++k) apart[k] *= random.uniform(0.0, 1.0) < 0.5 ? S(1) : S(-1);
    if (i % 4 < 3) apart[i % 4] = S(0);
    for (int k = 0; k < 20; ++k) {
      const S jitter =
          std::exp2(random.uniform(S(std::log2(std::numeric_limits<S>::epsilon())), largest));
      const Transform<S> X_AB{exp_rotation<S>(jitter * random.direction<S>()),
                              apart + size * jitter * random.direction<S>()};
      const auto out = box_contacts(box, box, X_AB, S(0.01) * size);
      REQUIRE(out.size() == 1);
      const Eigen::Index axis = i % 4 == 0 ? 1 : 0;
      CHECK(out[0].normal[axis] * apart[axis] > S(0.99) * std::abs(apart[axis]));
    }
  }
}

TEST_CASE_TEMPLATE("collide_shapes: names of contacts stay when the other box gives the normal", S,
                   float, double) {
  // Two boxes that lie half over each other. Tipped one way the edge of the second comes down on
  // the face of the first, tipped the other way its face comes down on the edge of the first.
  const Box<S> box{{S(1), S(1), S(1)}};
  std::set<std::uint32_t> names;
  int taken_from_a = 0;
  int taken_from_b = 0;
  for (int i = -25; i <= 25; ++i) {
    const Transform<S> X_AB{exp_rotation<S>({S(1e-3) * S(i), S(-4e-3) * S(i), S(0.1)}),
                            {S(1), S(0.5), S(1.95)}};
    const auto out = box_contacts(box, box, X_AB, S(0.5));
    REQUIRE(out.size() == 1);
    REQUIRE(out[0].size == 4);
    (out[0].normal == Vec3<S>::UnitZ() ? taken_from_a : taken_from_b) += 1;
    std::set<std::uint32_t> now;
    for (std::size_t p = 0; p < 4; ++p) now.insert(out[0].points[p].feature);
    if (names.empty()) names = now;
    CHECK(now == names);
  }
  CHECK(taken_from_a > 10);
  CHECK(taken_from_b > 10);
}
