// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/inner_ball.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/geometry/shapes/shape_properties.hpp>
#include <bristle/geometry/shapes/support.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <support/random.hpp>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using bristle::test::Random;
using std::numbers::pi;

namespace {

template <typename S>
void check_equal(const MassProperties<S>& found, const MassProperties<S>& expected, S tolerance) {
  const S size = std::cbrt(expected.mass);
  CHECK(std::abs(found.mass - expected.mass) <= tolerance * expected.mass);
  CHECK((found.center - expected.center).norm() <= tolerance * size);
  CHECK((found.inertia - expected.inertia).norm() <= tolerance * expected.inertia.norm());
}

/// Mesh of a closed surface: a geodesic sphere with every vertex put somewhere else. `place` keeps
/// the order around each point, so the mesh stays wound outwards.
template <typename S, typename Place>
TriangleMesh<S> mapped_sphere(std::uint32_t frequency, Place&& place) {
  TriangleMesh<S> mesh = sphere_mesh(S(1), frequency);
  for (auto& v : mesh.vertices) v = place(Vec3<S>(v));
  return mesh;
}

/// All shapes with finite mass, of about one metre.
template <typename S>
std::vector<Shape<S>> solids() {
  return {Sphere<S>{S(0.7)},
          Box<S>{{S(0.3), S(0.5), S(0.9)}},
          Capsule<S>{S(0.4), S(0.6)},
          Cylinder<S>{S(0.4), S(0.6)},
          Cone<S>{S(0.5), S(0.8)},
          Ellipsoid<S>{{S(0.3), S(0.5), S(0.9)}},
          convex_hull(sphere_mesh(S(0.6), 2)),
          sphere_mesh(S(0.6), 2)};
}

template <typename S>
Shape<S> scaled(Shape<S> shape, S k) {
  struct Scale {
    S k;
    void operator()(Sphere<S>& s) const { s.radius *= k; }
    void operator()(Box<S>& s) const { s.half_extents *= k; }
    void operator()(Capsule<S>& s) const { s.radius *= k, s.half_length *= k; }
    void operator()(Cylinder<S>& s) const { s.radius *= k, s.half_length *= k; }
    void operator()(Cone<S>& s) const { s.radius *= k, s.half_length *= k; }
    void operator()(Ellipsoid<S>& s) const { s.radii *= k; }
    void operator()(HalfSpace<S>& s) const { s.offset *= k; }
    void operator()(ConvexHull<S>& s) const {
      for (auto& v : s.vertices) v *= k;
      for (auto& offset : s.face_offsets) offset *= k;
    }
    void operator()(TriangleMesh<S>& s) const {
      for (auto& v : s.vertices) v *= k;
    }
  };
  std::visit(Scale{k}, shape);
  return shape;
}

}  // namespace

TEST_CASE_TEMPLATE("unit_mass_properties: of textbook solids", S, float, double) {
  // Standard formulas with numbers put in; inertia about the centre of mass, density 1.
  const auto expect = [](const Shape<S>& shape, double mass, double center_z, double xx, double yy,
                         double zz) {
    MassProperties<S> expected;
    expected.mass = S(mass);
    expected.center = {0, 0, S(center_z)};
    expected.inertia = Vec3<S>(S(xx), S(yy), S(zz)).asDiagonal();
    CAPTURE(name_of(kind_of(shape)));
    check_equal(unit_mass_properties(shape), expected, Tolerance<S>::round_off());
  };
  const double ball = 4.0 / 3.0 * pi * 8.0;  // radius 2
  expect(Sphere<S>{2}, ball, 0, ball * 1.6, ball * 1.6, ball * 1.6);
  // Edges 2, 4, 6: m (b^2 + c^2) / 12.
  expect(Box<S>{{1, 2, 3}}, 48, 0, 48 * 52 / 12.0, 48 * 40 / 12.0, 48 * 20 / 12.0);
  const double tube = pi * 4 * 6;  // radius 2, height 6
  const double across = tube * (3 * 4 + 36) / 12.0;
  expect(Cylinder<S>{2, 3}, tube, 0, across, across, tube * 2);
  // Two half balls with their centres of mass 3 + 3/8 * 2 from the middle; about its own centre of
  // mass a half ball has 83/320 m r^2.
  const double caps = ball * (83.0 / 320.0 * 4 + 3.75 * 3.75);
  expect(Capsule<S>{2, 3}, tube + ball, 0, across + caps, across + caps, tube * 2 + ball * 1.6);
  const double cone = tube / 3;  // base radius 2, height 6, centre of mass 1.5 above the base
  const double cone_across = cone * (3.0 / 20.0 * 4 + 3.0 / 80.0 * 36);
  expect(Cone<S>{2, 3}, cone, -1.5, cone_across, cone_across, cone * 0.3 * 4);
  const double egg = 4.0 / 3.0 * pi * 6;  // semi-axes 1, 2, 3: m (b^2 + c^2) / 5
  expect(Ellipsoid<S>{{1, 2, 3}}, egg, 0, egg * 13 / 5, egg * 10 / 5, egg * 5 / 5);
  const MassProperties<S> floor = unit_mass_properties<S>(HalfSpace<S>{});
  CHECK(floor.mass == S(0));
  CHECK(floor.inertia == Mat3<S>::Zero());
}

TEST_CASE_TEMPLATE("unit_mass_properties: of a box is that of its mesh and of its hull", S, float,
                   double) {
  const Vec3<S> half(S(0.02), S(0.05), S(0.11));
  const TriangleMesh<S> mesh = box_mesh(half);
  const MassProperties<S> box = unit_mass_properties<S>(Box<S>{half});
  check_equal(unit_mass_properties<S>(mesh), box, Tolerance<S>::round_off());
  check_equal(unit_mass_properties<S>(convex_hull(mesh)), box, Tolerance<S>::round_off());
}

TEST_CASE_TEMPLATE("unit_mass_properties: of round shapes is approached by fine meshes", S, float,
                   double) {
  using std::abs;
  using std::max;
  const S r = S(0.5);
  const S h = S(0.8);
  const auto profile_of = [](const Vec3<S>& v) {
    return max(Vec3<S>(v.x(), v.y(), 0).norm(), Tolerance<S>::round_off());
  };
  // Each maps the unit sphere onto the shape's surface, which is star-shaped about the origin.
  const auto to_cylinder = [&](const Vec3<S>& v) -> Vec3<S> {
    return v / max(profile_of(v) / r, abs(v.z()) / h);
  };
  const auto to_cone = [&](const Vec3<S>& v) -> Vec3<S> {
    // Side: radius r at -h, 0 at h, that is, rho / r + z / (2 h) = 1 / 2.
    const S side = S(2) * profile_of(v) / r + v.z() / h;
    return v / max(side, -v.z() / h);
  };
  const auto to_capsule = [&](const Vec3<S>& v) -> Vec3<S> {
    const S rho = profile_of(v);
    if (abs(v.z()) * r <= h * rho) return v * (r / rho);
    // |t v - (0, 0, +-h)| = r, the farther solution for t; |v| = 1.
    const S b = abs(v.z()) * h;
    return v * (b + std::sqrt(b * b - h * h + r * r));
  };
  const auto to_ellipsoid = [&](const Vec3<S>& v) -> Vec3<S> {
    return v.cwiseProduct(Vec3<S>(r, h, S(0.3)));
  };
  // With edges of about 1.2 / f of the radius the meshes lose some 0.1 / f of corners and bulges
  // at worst (the flat shapes have sharp rims that the mesh cuts off).
  const std::uint32_t f = 40;
  const S tolerance = S(0.01);
  const auto compare = [&](const Shape<S>& shape, const TriangleMesh<S>& mesh) {
    CAPTURE(name_of(kind_of(shape)));
    check_equal(unit_mass_properties<S>(mesh), unit_mass_properties<S>(shape), tolerance);
  };
  compare(Sphere<S>{r}, sphere_mesh(r, f));
  compare(Ellipsoid<S>{{r, h, S(0.3)}}, mapped_sphere<S>(f, to_ellipsoid));
  compare(Cylinder<S>{r, h}, mapped_sphere<S>(f, to_cylinder));
  compare(Cone<S>{r, h}, mapped_sphere<S>(f, to_cone));
  compare(Capsule<S>{r, h}, mapped_sphere<S>(f, to_capsule));
}

TEST_CASE_TEMPLATE("unit_mass_properties: scales with the third and fifth power of size", S, float,
                   double) {
  for (const Shape<S>& shape : solids<S>()) {
    CAPTURE(name_of(kind_of(shape)));
    const MassProperties<S> one = unit_mass_properties(shape);
    for (const S k : {S(0.001), S(0.01), S(100)}) {
      const MassProperties<S> expected{k * k * k * one.mass, k * one.center,
                                       k * k * k * k * k * one.inertia};
      check_equal(unit_mass_properties(scaled(shape, k)), expected, Tolerance<S>::round_off());
    }
  }
}

TEST_CASE_TEMPLATE(
    "unit_mass_properties: of a moved and turned mesh follows the parallel-axis theorem", S, float,
    double) {
  const std::uint64_t seed = 3;
  CAPTURE(seed);
  Random random(seed);
  // An L of two boxes, as one mesh of two closed parts.
  TriangleMesh<S> mesh = box_mesh<S>({S(0.5), S(0.1), S(0.1)});
  const TriangleMesh<S> leg = box_mesh<S>({S(0.1), S(0.1), S(0.3)});
  for (const auto& t : leg.triangles) mesh.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  for (const auto& v : leg.vertices) mesh.vertices.push_back(v + Vec3<S>(S(0.6), 0, S(0.2)));
  const MassProperties<S> parts = unit_mass_properties<S>(Box<S>{{S(0.5), S(0.1), S(0.1)}}) +
                                  unit_mass_properties<S>(Box<S>{{S(0.1), S(0.1), S(0.3)}})
                                      .transformed({Quat<S>::Identity(), {S(0.6), 0, S(0.2)}});
  check_equal(unit_mass_properties<S>(mesh), parts, Tolerance<S>::round_off());

  for (int i = 0; i < 20; ++i) {
    const Transform<S> X = random.pose(S(100));
    TriangleMesh<S> moved = mesh;
    for (auto& v : moved.vertices) v = X * v;
    // 100 m away, coordinates are rounded to 100 epsilon; a rotation doubles that, and thin parts
    // (0.2 m) see it ten times. Integrating about the world's origin would lose 1e4 more.
    const S tolerance = S(2000) * Tolerance<S>::round_off();
    check_equal(unit_mass_properties<S>(moved), parts.transformed(X), tolerance);
  }
}

TEST_CASE_TEMPLATE("local_bounds: touches each shape", S, float, double) {
  const auto expect = [](const Shape<S>& shape, const Vec3<S>& half) {
    CAPTURE(name_of(kind_of(shape)));
    const Aabb<S> box = local_bounds(shape);
    CHECK((box.upper - half).norm() <= Tolerance<S>::round_off() * half.norm());
    CHECK((box.lower + half).norm() <= Tolerance<S>::round_off() * half.norm());
  };
  expect(Sphere<S>{2}, {2, 2, 2});
  expect(Box<S>{{1, 2, 3}}, {1, 2, 3});
  expect(Capsule<S>{2, 3}, {2, 2, 5});
  expect(Cylinder<S>{2, 3}, {2, 2, 3});
  expect(Cone<S>{2, 3}, {2, 2, 3});
  expect(Ellipsoid<S>{{1, 2, 3}}, {1, 2, 3});
  expect(box_mesh<S>({1, 2, 3}), {1, 2, 3});
  expect(convex_hull(box_mesh<S>({1, 2, 3})), {1, 2, 3});
  const Aabb<S> floor = local_bounds<S>(HalfSpace<S>{});
  CHECK(floor.lower == Vec3<S>::Constant(-infinity<S>));
  CHECK(floor.upper == Vec3<S>::Constant(infinity<S>));
}

TEST_CASE_TEMPLATE("inner_ball: lies in its shape, and touches its surface where that is round", S,
                   float, double) {
  Random random(11);
  for (const Shape<S>& shape : solids<S>()) {
    CAPTURE(name_of(kind_of(shape)));
    const InnerBall<S> ball = inner_ball(shape);
    if (kind_of(shape) == ShapeKind::triangle_mesh) {
      CHECK(ball.radius == S(0));
      continue;
    }
    REQUIRE(ball.radius > S(0));
    // The shape's extent along any direction is at least the ball's; along some it is the same.
    S least = infinity<S>;
    const auto look_along = [&](const Vec3<S>& n) {
      std::visit(
          [&](const auto& s) {
            if constexpr (requires { support_point(s, n); }) {
              least = std::min(least, n.dot(support_point(s, n) - ball.center) - ball.radius);
            }
          },
          shape);
    };
    for (int i = 0; i < 3000; ++i) look_along(random.template direction<S>());
    for (int axis = 0; axis < 3; ++axis) {
      look_along(Vec3<S>::Unit(axis));
      look_along(-Vec3<S>::Unit(axis));
    }
    CHECK(least >= -Tolerance<S>::round_off());
    CHECK(least <= S(0.02));
  }
  CHECK(inner_ball(Shape<S>(HalfSpace<S>{})).radius == S(0));
}
