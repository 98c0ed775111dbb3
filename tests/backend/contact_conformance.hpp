/// @file
/// The part of the conformance suite that is about contacts.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/relative.hpp"

#include <bristle/geometry/backends/shape_backend.hpp>
#include <bristle/math/rotation.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <backend/reference_shapes.hpp>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <support/random.hpp>
#include <vector>

namespace bristle::test {

using namespace bristle::detail;

/// How exact contacts have to be.
template <Scalar S>
struct ContactTolerance {
  /// [1] Error of a gap, relative to the shapes' size, and of a normal.
  S gap = S(8) * Tolerance<S>::round_off();
  S normal = S(8) * Tolerance<S>::round_off();
  /// [1] The same where a core is curved and no half-space takes part: a normal found by iteration.
  /// 1e-8 is what contact_normal.hpp says of gaps; depth is flat to second order in the direction,
  /// whose error is the root of that of the depth.
  S curved_gap = std::max(S(1e-8), S(8) * Tolerance<S>::round_off());
  S curved_normal = S(1e-4);

  [[nodiscard]] S gap_of(const Shape<S>& a, const Shape<S>& b) const {
    return is_curved(a, b) ? curved_gap : gap;
  }
  [[nodiscard]] S normal_of(const Shape<S>& a, const Shape<S>& b) const {
    return is_curved(a, b) ? curved_normal : normal;
  }
  [[nodiscard]] static bool is_curved(const Shape<S>& a, const Shape<S>& b) {
    const auto has = [&](ShapeKind kind) { return kind_of(a) == kind || kind_of(b) == kind; };
    return !has(ShapeKind::half_space) &&
           (has(ShapeKind::cylinder) || has(ShapeKind::cone) || has(ShapeKind::ellipsoid));
  }
};

/// Two shapes that just touch, with what is known of their contact.
template <Scalar S>
struct TouchingPair {
  std::string name;
  Shape<S> a;
  Shape<S> b;
  /// Pose of B in A in which the gap is 0.
  Transform<S> X_AB;
  /// [1] From A to B, in A.
  Vec3<S> normal;
  /// [-] Fewest and most contacts.
  std::size_t least = 1;
  std::size_t most = 1;
};

/// Shortest rotation that turns one unit vector into another; not into its opposite.
template <Scalar S>
Quat<S> rotation_between(const Vec3<S>& from, const Vec3<S>& to) {
  const Vec3<S> axis = from.cross(to);
  return Quat<S>(S(1) + from.dot(to), axis.x(), axis.y(), axis.z()).normalized();
}

/// Touching pairs `u` times the size of the first ones.
template <Scalar S>
std::vector<TouchingPair<S>> touching_pairs(S u) {
  const auto turned = [](S x, S y, S z) { return exp_rotation<S>({x, y, z}); };
  const Quat<S> upright = Quat<S>::Identity();
  const S right_angle = S(std::numbers::pi / 2);
  const Vec3<S> z = Vec3<S>::UnitZ();
  const auto at = [&](const Quat<S>& q, S x, S y, S h) {
    return Transform<S>{q, u * Vec3<S>(x, y, h)};
  };
  const Vec3<S> oblique = Vec3<S>(S(1), S(2), S(2)) / S(3);
  const S half_root = std::sqrt(S(0.5));
  const Sphere<S> ball{S(0.3) * u};
  const Box<S> box{u * Vec3<S>(S(0.5), S(0.4), S(0.3))};
  const Box<S> table{u * Vec3<S>(S(2), S(2), S(0.5))};
  const Capsule<S> capsule{S(0.2) * u, S(0.5) * u};
  const Cylinder<S> cylinder{S(0.4) * u, S(0.3) * u};
  const Cone<S> cone{S(0.4) * u, S(0.3) * u};
  const Ellipsoid<S> ellipsoid{u * Vec3<S>(S(0.5), S(0.4), S(0.3))};
  const HalfSpace<S> floor{z, S(0)};
  std::vector<Vec3<S>> corners;
  for (int i = 0; i < 3; ++i) {
    corners.push_back(S(0.6) * u * Vec3<S>::Unit(i));
    corners.push_back(S(-0.6) * u * Vec3<S>::Unit(i));
  }
  const ConvexHull<S> octahedron = convex_hull<S>(std::span<const Vec3<S>>(corners));
  const TriangleMesh<S> l = l_mesh<S>(u);
  // Turns the octahedron's face (-1, -1, -1) down.
  const Quat<S> on_face = rotation_between<S>(Vec3<S>::Constant(-std::sqrt(S(1) / S(3))), -z);
  // Turns the cone's side down: its normal is (height, radius) / length in (x, z).
  const S cone_side = std::hypot(S(0.6), S(0.4));
  const Quat<S> on_side = rotation_between<S>(Vec3<S>(S(0.6), S(0), S(0.4)) / cone_side, -z);

  std::vector<TouchingPair<S>> pairs = {
      {"two balls", Sphere<S>{S(0.5) * u}, ball, {upright, S(0.8) * u * oblique}, oblique},
      {"ball over a box", box, ball, at(upright, S(0.1), S(0.2), S(0.6)), z},
      {"ball at a box's edge",
       box,
       ball,
       at(upright, S(0.5) + S(0.3) * half_root, S(0.1), S(0.3) + S(0.3) * half_root),
       {half_root, S(0), half_root}},
      {"ball at a box's corner",
       box,
       ball,
       {upright, -(box.half_extents + ball.radius * oblique)},
       -oblique},
      {"ball beside a capsule", capsule, ball, at(upright, S(0.5), S(0), S(0.2)), Vec3<S>::UnitX()},
      {"ball over a capsule", capsule, ball, at(upright, S(0), S(0), S(1)), z},
      {"crossed capsules",
       capsule,
       capsule,
       {turned(S(0), right_angle, S(0)), u * Vec3<S>(S(0.1), S(0.4), S(0.2))},
       Vec3<S>::UnitY()},
      {"capsules side by side", capsule, capsule, at(upright, S(0), S(-0.4), S(0.3)),
       -Vec3<S>::UnitY(), 2, 2},
      {"capsules end to end", capsule, capsule, at(upright, S(0), S(0), S(1.4)), z},
      {"boxes face to face", box, box, at(upright, S(0.1), S(0.1), S(0.6)), z, 4, 4},
      {"equal boxes flush", box, box, at(upright, S(0), S(0), S(0.6)), z, 4, 4},
      {"boxes turned against each other", Box<S>{u * Vec3<S>(S(0.5), S(0.5), S(0.3))},
       Box<S>{u * Vec3<S>(S(0.5), S(0.5), S(0.3))},
       at(turned(S(0), S(0), right_angle / S(2)), S(0), S(0), S(0.6)), z, 8, 8},
      {"box on its edge on a box", table, box,
       at(turned(right_angle / S(2), S(0), S(0)), S(0), S(0), S(0.5) + S(0.7) * half_root), z, 2,
       2},
      // Edges along y of A and along x of B, both boxes standing on them.
      {"crossed edges of boxes",
       Box<S>{u * Vec3<S>(S(0.5), S(0.5), S(0.5))},
       Box<S>{u * Vec3<S>(S(0.5), S(0.5), S(0.5))},
       {turned(S(0), right_angle / S(2), S(0)).conjugate() * turned(right_angle / S(2), S(0), S(0)),
        turned(S(0), right_angle / S(2), S(0)).conjugate() *
            Vec3<S>(S(0), S(0), S(2) * half_root * u)},
       {-half_root, S(0), half_root}},
      {"ball on the floor", floor, ball, at(upright, S(1), S(2), S(0.3)), z},
      {"box on the floor", floor, box, at(upright, S(1), S(2), S(0.3)), z, 4, 4},
      {"box on its corner on the floor",
       floor,
       box,
       {rotation_between<S>(-box.half_extents.normalized(), -z), z * box.half_extents.norm()},
       z,
       1,
       1},
      {"capsule standing on the floor", floor, capsule, at(upright, S(1), S(2), S(0.7)), z},
      {"capsule lying on the floor", floor, capsule,
       at(turned(right_angle, S(0), S(0)), S(1), S(2), S(0.2)), z, 2, 2},
      {"cylinder standing on the floor", floor, cylinder, at(upright, S(1), S(2), S(0.3)), z, 3, 8},
      {"cylinder lying on the floor", floor, cylinder,
       at(turned(right_angle, S(0), S(0)), S(1), S(2), S(0.4)), z, 2, 2},
      {"cone standing on the floor", floor, cone, at(upright, S(1), S(2), S(0.3)), z, 3, 8},
      {"cone on its tip on the floor", floor, cone,
       at(turned(S(2) * right_angle, S(0), S(0)), S(1), S(2), S(0.3)), z, 1, 1},
      {"cone on its side on the floor", floor, cone,
       at(on_side, S(1), S(2), S(0.3) * S(0.4) / cone_side), z, 2, 2},
      {"ellipsoid on the floor", floor, ellipsoid, at(upright, S(1), S(2), S(0.3)), z},
      {"octahedron on its corner on the floor", floor, octahedron, at(upright, S(1), S(2), S(0.6)),
       z, 1, 1},
      {"octahedron on its face on the floor", floor, octahedron,
       at(on_face, S(1), S(2), S(0.6) / std::sqrt(S(3))), z, 3, 3},
      {"mesh on the floor", floor, l, at(upright, S(1), S(2), S(0)), z, 3, 8},
      {"box under a sloping ceiling",
       HalfSpace<S>{-oblique, S(-0.2) * u},
       ball,
       {upright, (S(0.2) - S(0.3)) * u * oblique},
       -oblique},
      {"ball on a mesh", l, ball, at(upright, S(0.5), S(0.1), S(0.8)), z, 1, 8},
      {"box on a mesh", l, box, at(upright, S(0.25), S(0), S(0.8)), z, 3, 8},
      {"ball over a cylinder", cylinder, ball, at(upright, S(0.1), S(0.2), S(0.6)), z},
      {"ball beside a cylinder", cylinder, ball, at(upright, S(0.7), S(0), S(0.1)),
       Vec3<S>::UnitX()},
      {"ball over an ellipsoid", ellipsoid, ball, at(upright, S(0), S(0), S(0.6)), z},
      {"ball over an octahedron",
       octahedron,
       ball,
       {upright, Vec3<S>::Constant((S(0.2) + S(0.3) / std::sqrt(S(3))) * u)},
       Vec3<S>::Constant(std::sqrt(S(1) / S(3)))},
      {"capsule lying on a box", table, capsule,
       at(turned(right_angle, S(0), S(0)), S(0.1), S(0.2), S(0.7)), z, 2, 2},
      {"cylinder standing on a box", table, cylinder, at(upright, S(0.1), S(0.2), S(0.8)), z, 3, 8},
      {"cone standing on a box", table, cone, at(upright, S(0.1), S(0.2), S(0.8)), z, 3, 8},
      {"ellipsoid on a box", table, ellipsoid, at(upright, S(0.1), S(0.2), S(0.8)), z},
      {"octahedron on a box", table, octahedron,
       at(on_face, S(0.1), S(0.2), S(0.5) + S(0.6) / std::sqrt(S(3))), z, 3, 3},
  };
  return pairs;
}

/// All contacts of a query.
template <Scalar S>
struct QueriedContacts {
  ContactManifolds<S> manifolds;
  ContactStatus status = ContactStatus::failed;

  [[nodiscard]] std::size_t count() const {
    std::size_t n = 0;
    for (const auto& m : manifolds) n += m.size;
    return n;
  }
  /// [m] Least gap; infinite without contacts.
  [[nodiscard]] S deepest() const {
    S gap = infinity<S>;
    for (const auto& m : manifolds) {
      for (std::size_t i = 0; i < m.size; ++i) gap = std::min(gap, m.points[i].gap);
    }
    return gap;
  }
};

template <typename Backend, Scalar S>
QueriedContacts<S> query_contacts(const typename Backend::template Collidable<S>& a,
                                  const typename Backend::template Collidable<S>& b,
                                  const Transform<S>& X_AB, S margin) {
  QueriedContacts<S> result;
  result.status = Backend::collide(a, b, X_AB, margin, result.manifolds);
  return result;
}

/// Requirements on every result.
template <Scalar S>
void check_sane(const QueriedContacts<S>& contacts, S margin) {
  CHECK(contacts.status == ContactStatus::ok);
  for (const auto& m : contacts.manifolds) {
    CHECK(std::abs(m.normal.norm() - S(1)) <= S(4) * Tolerance<S>::round_off());
    CHECK(m.size > 0);
    REQUIRE(m.size <= m.capacity);
    std::set<std::uint32_t> features;
    for (std::size_t i = 0; i < m.size; ++i) {
      CHECK(m.points[i].position.allFinite());
      CHECK(m.points[i].gap <= margin);
      features.insert(m.points[i].feature);
    }
    CHECK(features.size() == m.size);
  }
}

template <typename Backend, Scalar S>
void check_touching_pairs(const ContactTolerance<S>& tolerance) {
  for (const S u : {S(0.01), S(1), S(100)}) {
    for (const TouchingPair<S>& pair : touching_pairs<S>(u)) {
      CAPTURE(pair.name);
      CAPTURE(u);
      if (!Backend::can_collide(kind_of(pair.a), kind_of(pair.b))) continue;
      const S gap_tolerance = tolerance.gap_of(pair.a, pair.b);
      const S normal_tolerance = tolerance.normal_of(pair.a, pair.b);
      const auto a = Backend::template make<S>(pair.a);
      const auto b = Backend::template make<S>(pair.b);
      for (const S gap : {S(-0.01) * u, S(0), S(0.005) * u}) {
        CAPTURE(gap);
        Transform<S> X_AB = pair.X_AB;
        X_AB.translation += gap * pair.normal;
        const S margin = S(0.006) * u;
        const auto contacts = query_contacts<Backend, S>(a, b, X_AB, margin);
        check_sane(contacts, margin);
        CHECK(contacts.count() >= pair.least);
        CHECK(contacts.count() <= pair.most);
        CHECK(std::abs(contacts.deepest() - gap) <= gap_tolerance * u);
        for (const auto& m : contacts.manifolds) {
          CHECK((m.normal - pair.normal).norm() <= normal_tolerance);
        }
        // The other way round the same is seen from B.
        const Transform<S> X_BA = X_AB.inverse();
        const auto swapped = query_contacts<Backend, S>(b, a, X_BA, margin);
        check_sane(swapped, margin);
        CHECK(swapped.count() == contacts.count());
        CHECK(std::abs(swapped.deepest() - contacts.deepest()) <= gap_tolerance * u);
        for (const auto& m : swapped.manifolds) {
          CHECK((X_AB.rotate(m.normal) + pair.normal).norm() <= normal_tolerance);
        }
        // A smaller margin than the gap finds nothing.
        if (gap > S(0)) {
          CHECK(query_contacts<Backend, S>(a, b, X_AB, S(0.004) * u).count() == 0);
          CHECK(query_contacts<Backend, S>(a, b, X_AB, S(0)).count() == 0);
        }
      }
      // Far apart.
      Transform<S> X_AB = pair.X_AB;
      X_AB.translation += S(5) * u * pair.normal;
      CHECK(query_contacts<Backend, S>(a, b, X_AB, S(0.01) * u).count() == 0);
    }
  }
}

/// Random poses of all pairs of solids: what overlaps is found, and parted along the normal.
template <typename Backend, Scalar S>
void check_random_contacts(const ContactTolerance<S>& tolerance) {
  Random random(104);
  const std::vector<ReferenceShape<S>> shapes = reference_shapes<S>(S(1));
  for (const ReferenceShape<S>& shape_a : shapes) {
    for (const ReferenceShape<S>& shape_b : shapes) {
      CAPTURE(shape_a.name);
      CAPTURE(shape_b.name);
      const ShapeKind kind_a = kind_of(shape_a.shape);
      const ShapeKind kind_b = kind_of(shape_b.shape);
      if (!shape_a.is_convex || !shape_b.is_convex || !Backend::can_collide(kind_a, kind_b)) {
        continue;
      }
      const S gap_tolerance = tolerance.gap_of(shape_a.shape, shape_b.shape);
      const auto a = Backend::template make<S>(shape_a.shape);
      const auto b = Backend::template make<S>(shape_b.shape);
      for (int i = 0; i < 40; ++i) {
        const Transform<S> X_AB = random.pose(S(1.2));
        CAPTURE(X_AB.translation.transpose());
        CAPTURE(X_AB.rotation.coeffs().transpose());
        const S margin = S(0.05);
        const auto contacts = query_contacts<Backend, S>(a, b, X_AB, margin);
        check_sane(contacts, margin);
        const Transform<S> X_BA = X_AB.inverse();
        bool is_overlapping = false;
        for (int k = 0; k < 200 && !is_overlapping; ++k) {
          const Vec3<S> p = random.in_cube(S(1.5));
          is_overlapping =
              shape_a.level(p) < -gap_tolerance && shape_b.level(X_BA * p) < -gap_tolerance;
        }
        if (is_overlapping) CHECK(contacts.deepest() < S(0));
        if (contacts.manifolds.empty()) continue;
        // Moved apart along the normal by as much as they overlap, nothing overlaps any more.
        Transform<S> parted = X_AB;
        parted.translation -= contacts.deepest() * contacts.manifolds[0].normal;
        const auto after = query_contacts<Backend, S>(a, b, parted, margin);
        check_sane(after, margin);
        CHECK(after.deepest() >= S(-4) * gap_tolerance);
      }
    }
  }
}

/// Shapes in each other's middle, where no direction is better than the others.
template <typename Backend, Scalar S>
void check_degenerate_contacts() {
  for (const ReferenceShape<S>& shape_a : reference_shapes<S>(S(1))) {
    for (const ReferenceShape<S>& shape_b : reference_shapes<S>(S(1))) {
      CAPTURE(shape_a.name);
      CAPTURE(shape_b.name);
      if (!shape_a.is_convex || !shape_b.is_convex ||
          !Backend::can_collide(kind_of(shape_a.shape), kind_of(shape_b.shape))) {
        continue;
      }
      const auto a = Backend::template make<S>(shape_a.shape);
      const auto b = Backend::template make<S>(shape_b.shape);
      const auto first = query_contacts<Backend, S>(a, b, Transform<S>{}, S(0));
      const auto again = query_contacts<Backend, S>(a, b, Transform<S>{}, S(0));
      check_sane(first, S(0));
      CHECK(first.deepest() < S(0));
      REQUIRE(again.manifolds.size() == first.manifolds.size());
      for (std::size_t i = 0; i < first.manifolds.size(); ++i) {
        CHECK(again.manifolds[i].normal == first.manifolds[i].normal);
        CHECK(again.manifolds[i].size == first.manifolds[i].size);
      }
    }
  }
}

/// `can_collide` is symmetric, and an unknown pair fails loudly and adds nothing.
template <typename Backend, Scalar S>
void check_known_pairs() {
  CHECK(!Backend::can_collide(ShapeKind::half_space, ShapeKind::half_space));
  for (const ReferenceShape<S>& shape_a : reference_shapes<S>(S(1))) {
    for (const ReferenceShape<S>& shape_b : reference_shapes<S>(S(1))) {
      CAPTURE(shape_a.name);
      CAPTURE(shape_b.name);
      const ShapeKind kind_a = kind_of(shape_a.shape);
      const ShapeKind kind_b = kind_of(shape_b.shape);
      CHECK(Backend::can_collide(kind_a, kind_b) == Backend::can_collide(kind_b, kind_a));
      const auto contacts = query_contacts<Backend, S>(Backend::template make<S>(shape_a.shape),
                                                       Backend::template make<S>(shape_b.shape),
                                                       Transform<S>{}, S(0));
      if (Backend::can_collide(kind_a, kind_b)) {
        CHECK(contacts.status == ContactStatus::ok);
      } else {
        CHECK(contacts.status == ContactStatus::failed);
        CHECK(contacts.manifolds.empty());
      }
    }
  }
}

/// Contacts that are in the output already stay there.
template <typename Backend, Scalar S>
void check_contacts_are_appended() {
  const auto ball = Backend::template make<S>(Sphere<S>{S(1)});
  ContactManifolds<S> out(1);
  out[0].key = 77;
  Transform<S> X_AB;
  X_AB.translation.x() = S(1.5);
  CHECK(Backend::collide(ball, ball, X_AB, S(0), out) == ContactStatus::ok);
  REQUIRE(out.size() == 2);
  CHECK(out[0].key == 77);
  CHECK(out[0].size == 0);
  CHECK(out[1].points[0].gap == test::relative(-0.5));
}

/// Bad shapes are refused by name.
template <typename Backend, Scalar S>
void check_bad_shapes() {
  const S nan = std::numeric_limits<S>::quiet_NaN();
  const auto make = [](const Shape<S>& shape) { (void)Backend::template make<S>(shape); };
  CHECK_THROWS_AS(make(Sphere<S>{S(0)}), InvalidArgument);
  CHECK_THROWS_AS(make(Sphere<S>{nan}), InvalidArgument);
  CHECK_THROWS_AS(make(Box<S>{{S(1), S(-1), S(1)}}), InvalidArgument);
  CHECK_THROWS_AS(make(Capsule<S>{S(1), infinity<S>}), InvalidArgument);
  CHECK_THROWS_AS(make(Cylinder<S>{S(1), S(0)}), InvalidArgument);
  CHECK_THROWS_AS(make(Cone<S>{nan, S(1)}), InvalidArgument);
  CHECK_THROWS_AS(make(Ellipsoid<S>{{S(1), S(1), S(0)}}), InvalidArgument);
  CHECK_THROWS_AS(make(HalfSpace<S>{{S(0), S(0), S(2)}, S(0)}), InvalidArgument);
  CHECK_THROWS_AS(make(ConvexHull<S>{}), InvalidArgument);
  CHECK_THROWS_AS(make(TriangleMesh<S>{}), InvalidArgument);
  TriangleMesh<S> open = l_mesh<S>(S(1));
  open.triangles.pop_back();
  CHECK_THROWS_AS(make(open), InvalidArgument);
}

}  // namespace bristle::test
