// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/terrain.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <doctest/doctest.h>

#if defined(BRISTLE_WITH_FCL)
#include <bristle/geometry/backends/fcl_backend.hpp>
#endif

#include <algorithm>
#include <backend/reference_shapes.hpp>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <support/random.hpp>
#include <support/rounds.hpp>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using bristle::test::Random;
using bristle::test::rounds;

namespace {

/// A flat slab whose faces are divided into cells x cells crooked squares of two triangles: top at
/// z = 0. Straight ones would be one plate, without inner edges. Those at the border are straight.
template <Scalar S>
TriangleMesh<S> tiled_slab(S half_width, S thickness, std::uint32_t cells) {
  TriangleMesh<S> surface = grid_mesh<S>({S(2) * half_width, S(2) * half_width}, {cells, cells});
  const S cell = S(2) * half_width / S(cells);
  Random random(17);
  for (Vec3<S>& v : surface.vertices) {
    const S from_border = half_width - std::max(std::abs(v.x()), std::abs(v.y()));
    if (from_border < S(0.5) * cell) continue;
    const bool is_next_to_border = half_width - std::abs(v.x()) < S(1.5) * cell;
    if (!is_next_to_border) v.x() += random.uniform(S(-0.2), S(0.2)) * cell;
    v.y() += random.uniform(S(-0.2), S(0.2)) * cell;
  }
  return extruded_mesh<S>(surface, {S(0), S(0), -thickness});
}

/// A backend and a scalar.
template <Scalar Number, typename B>
struct Setup {
  using S = Number;
  using Backend = B;

  static auto make(const Shape<S>& shape) { return Backend::template make<S>(shape); }
  using Collidable = typename Backend::template Collidable<S>;

  static ContactManifolds<S> contacts(const Collidable& a, const Collidable& b,
                                      const Transform<S>& X, S margin) {
    ContactManifolds<S> out;
    CHECK(Backend::collide(a, b, X, margin, out) == ContactStatus::ok);
    return out;
  }
};

using AnalyticFloat = Setup<float, AnalyticBackend>;
using AnalyticDouble = Setup<double, AnalyticBackend>;
#if defined(BRISTLE_WITH_FCL)
using FclFloat = Setup<float, FclBackend>;
using FclDouble = Setup<double, FclBackend>;
#define SETUPS AnalyticFloat, AnalyticDouble, FclFloat, FclDouble
#else
#define SETUPS AnalyticFloat, AnalyticDouble
#endif

template <Scalar S>
S deepest_gap(const ContactManifolds<S>& manifolds) {
  S gap = infinity<S>;
  for (const auto& m : manifolds) {
    for (std::size_t i = 0; i < m.size; ++i) gap = std::min(gap, m.points[i].gap);
  }
  return gap;
}

/// A shape of each convex kind, of size 0.2 to 0.5.
template <Scalar S>
Shape<S> random_solid(Random& random, std::size_t kind) {
  const auto size = [&] { return random.uniform(S(0.2), S(0.5)); };
  switch (kind) {
    case 0:
      return Sphere<S>{.radius = size()};
    case 1:
      return Box<S>{.half_extents = {size(), size(), size()}};
    case 2:
      return Capsule<S>{.radius = size(), .half_length = size()};
    case 3:
      return Cylinder<S>{.radius = size(), .half_length = size()};
    case 4:
      return Cone<S>{.radius = size(), .half_length = size()};
    case 5:
      return Ellipsoid<S>{.radii = {size(), size(), size()}};
    case 6: {
      std::vector<Vec3<S>> points;
      for (int i = 0; i < 12; ++i) points.push_back(random.in_cube(S(0.5)));
      return convex_hull<S>(std::span<const Vec3<S>>(points));
    }
    default:
      return box_mesh<S>({size(), size(), size()});
  }
}
constexpr std::size_t kind_count = 8;

}  // namespace

TEST_CASE_TEMPLATE(
    "mesh contacts: a box rests on a flat mesh with its four corners, in one manifold", T, SETUPS) {
  using S = typename T::S;
  for (const S scale : {S(0.01), S(1), S(100)}) {
    const auto slab = T::make(tiled_slab<S>(scale, S(0.1) * scale, 7));
    const auto box = T::make(Box<S>{.half_extents = Vec3<S>::Constant(S(0.3) * scale)});
    const S gap = S(-0.001) * scale;
    const Transform<S> X{.rotation = exp_rotation<S>({S(0), S(0), S(0.4)}),
                         .translation = {S(0.1) * scale, S(0.05) * scale, S(0.3) * scale + gap}};
    const S tolerance = Tolerance<S>::round_off() * scale;
    const auto found = T::contacts(slab, box, X, S(0.01) * scale);
    REQUIRE(found.size() == 1);
    CHECK((found[0].normal - Vec3<S>::UnitZ()).norm() < Tolerance<S>::round_off());
    CHECK(found[0].size == 4);
    // All four corners are among the contacts, each as deep as it is.
    for (const S x : {S(-0.3), S(0.3)}) {
      for (const S y : {S(-0.3), S(0.3)}) {
        const Vec3<S> corner = X * Vec3<S>(scale * Vec3<S>(x, y, S(-0.3)));
        S nearest = infinity<S>;
        for (std::size_t i = 0; i < found[0].size; ++i) {
          nearest = std::min(nearest, (found[0].points[i].position - corner).norm());
        }
        CHECK(nearest <= std::abs(gap) + tolerance);
      }
    }
    for (std::size_t i = 0; i < found[0].size; ++i) {
      CHECK(std::abs(found[0].points[i].gap - gap) <= tolerance);
    }
    // The other way round: the same points seen from the box, the normal reversed.
    const auto back = T::contacts(box, slab, X.inverse(), S(0.01) * scale);
    REQUIRE(back.size() == 1);
    CHECK(back[0].size == found[0].size);
    CHECK((X.rotate(back[0].normal) + Vec3<S>::UnitZ()).norm() < Tolerance<S>::round_off());
    CHECK((X * back[0].points[0].position - found[0].points[0].position).norm() < tolerance);
  }
}

// Points where inner edges cut what touches the face are no corners of it. They carried a part of
// the load, and friction against turning was less.
TEST_CASE_TEMPLATE("mesh contacts: a flat face has the contacts of a box's, however it is meshed",
                   T, SETUPS) {
  using S = typename T::S;
  const auto slab = T::make(tiled_slab<S>(S(1), S(0.1), 9));
  const auto plain = T::make(Box<S>{.half_extents = {1, 1, S(0.05)}});
  Random random(5);
  for (const Shape<S>& shape : {Shape<S>(Box<S>{.half_extents = {S(0.3), S(0.2), S(0.1)}}),
                                Shape<S>(Capsule<S>{.radius = S(0.1), .half_length = S(0.4)}),
                                Shape<S>(Box<S>{.half_extents = {S(0.02), S(0.03), S(0.1)}})}) {
    const auto body = T::make(shape);
    const bool is_capsule = std::holds_alternative<Capsule<S>>(shape);
    int compared = 0;
    for (int i = 0; i < 200; ++i) {
      CAPTURE(i);
      // Flat on the face, and in half of the rounds over its border.
      const S quarter = is_capsule ? S(1.5707963267948966) : S(0);
      const Quat<S> lie = exp_rotation<S>({S(0), quarter, S(0)});
      const S reach = i % 2 == 0 ? S(0.5) : S(1);
      const Transform<S> X{
          .rotation = exp_rotation<S>({S(0), S(0), random.uniform(S(-3), S(3))}) * lie,
          .translation = {random.uniform(-reach, reach), random.uniform(-reach, reach),
                          S(0.1) - S(0.001)}};
      const Transform<S> X_PS{.translation = {S(0), S(0), S(-0.05)}};
      const auto found = T::contacts(slab, body, X, S(0.005));
      const auto expected = T::contacts(plain, body, X_PS.inverse() * X, S(0.005));
      const bool is_within = i % 2 == 0;
      // Beside an edge of the face one of several contacts may be chosen.
      if (!is_within && (expected.size() != 1 || std::abs(expected[0].normal.z()) < S(0.999))) {
        continue;
      }
      ++compared;
      REQUIRE(expected.size() == 1);
      REQUIRE(found.size() >= 1);
      if (is_within) CHECK(found.size() == 1);
      const auto farthest = [&](const ContactManifold<S>& from, const ContactManifold<S>& to) {
        S distance = S(0);
        for (std::size_t k = 0; k < from.size; ++k) {
          S nearest = infinity<S>;
          for (std::size_t j = 0; j < to.size; ++j) {
            nearest = std::min(nearest, (from.points[k].position - to.points[j].position).norm());
          }
          distance = std::max(distance, nearest);
        }
        return distance;
      };
      // In float the end of a capsule that hangs over by a hair deeper is a contact of the box.
      ContactManifold<S> of_plain;
      for (std::size_t k = 0; k < expected[0].size; ++k) {
        ContactPoint<S> point = expected[0].points[k];
        point.position = X_PS * point.position;
        const Vec3<S>& at = point.position;
        if (std::max(std::abs(at.x()), std::abs(at.y())) <= S(1.0001)) of_plain.add(point);
      }
      // Over the border there are also corners of squares along it, and instead of a corner in a
      // square that is overlapped by less than the depth of 1 mm.
      const S tolerance = is_within ? S(10) * Tolerance<S>::equal() : S(0.002);
      CHECK(farthest(of_plain, found[0]) < tolerance);
      if (is_within) CHECK(farthest(found[0], of_plain) < tolerance);
    }
    CHECK(compared > 120);
  }
}

// In float, corners of plates that meet along a line are off it by rounding. What lies between two
// plates must not be lost by both.
TEST_CASE_TEMPLATE("mesh contacts: a box along the inner edges of a turned face keeps its corners",
                   T, SETUPS) {
  using S = typename T::S;
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    CAPTURE(i);
    TriangleMesh<S> mesh = tiled_slab<S>(S(1), S(0.1), 16);
    const Transform<S> X_WM{.rotation = random.rotation<S>(),
                            .translation = {random.uniform(S(-1), S(1)), S(0.3), S(0)}};
    for (Vec3<S>& v : mesh.vertices) v = X_WM * v;
    const auto slab = T::make(mesh);
    const auto box = T::make(Box<S>{.half_extents = {S(0.25), S(0.125), S(0.1)}});
    // A side along the line where squares of 0.125 m at the border meet plates within.
    const Transform<S> X =
        X_WM * Transform<S>{.translation = {S(0.625), random.uniform(S(-0.7), S(0.7)), S(0.099)}};
    const auto found = T::contacts(slab, box, X, S(0.005));
    REQUIRE(found.size() == 1);
    for (const S x : {S(-0.25), S(0.25)}) {
      for (const S y : {S(-0.125), S(0.125)}) {
        const Vec3<S> corner = X * Vec3<S>(x, y, S(-0.0995));
        S nearest = infinity<S>;
        for (std::size_t k = 0; k < found[0].size; ++k) {
          nearest = std::min(nearest, (found[0].points[k].position - corner).norm());
        }
        CHECK(nearest < S(2e-5));
      }
    }
  }
}

// Each edge of a dome this flat is flat, and no face has all of it. Its crest carries.
TEST_CASE_TEMPLATE("mesh contacts: a box on the crest of a nearly flat dome is carried there", T,
                   AnalyticDouble) {
  using S = typename T::S;
  std::vector<S> heights;
  for (int j = 0; j <= 60; ++j) {
    for (int i = 0; i <= 60; ++i) {
      const S x = S(0.02) * S(i) - S(0.6);
      const S y = S(0.02) * S(j) - S(0.6);
      heights.push_back(-(x * x + y * y) / S(600));
    }
  }
  const auto dome = T::make(extruded_mesh<S>(
      height_field_mesh<S>({S(1.2), S(1.2)}, {60, 60}, heights), {S(0), S(0), S(-0.2)}));
  const auto box = T::make(Box<S>{.half_extents = {S(0.5), S(0.5), S(0.1)}});
  const auto found = T::contacts(dome, box, {.translation = {S(0), S(0), S(0.1)}}, S(0.0001));
  CHECK(std::abs(deepest_gap(found)) < S(1e-6));
}

TEST_CASE_TEMPLATE("mesh contacts: nothing stumbles over the inner edges of a flat mesh", T,
                   SETUPS) {
  using S = typename T::S;
  const auto slab = T::make(tiled_slab<S>(S(1), S(0.1), 9));
  Random random(3);
  for (std::size_t kind = 0; kind < kind_count; ++kind) {
    CAPTURE(kind);
    for (int i = 0; i < 100; ++i) {
      CAPTURE(i);
      const Shape<S> shape = random_solid<S>(random, kind);
      const auto body = T::make(shape);
      // Some attitude, then down until the lowest point is 2 mm deep.
      Transform<S> X{
          .rotation = random.rotation<S>(),
          .translation = {random.uniform(S(-0.3), S(0.3)), random.uniform(S(-0.3), S(0.3)), S(0)}};
      const auto plane = T::make(HalfSpace<S>{});
      X.translation.z() = S(-0.002) - deepest_gap(T::contacts(plane, body, X, S(10)));
      const auto found = T::contacts(slab, body, X, S(0.005));
      CHECK(found.size() == 1);
      for (const auto& m : found) {
        CHECK((m.normal - Vec3<S>::UnitZ()).norm() < S(1e-6));
        CHECK(m.key == found[0].key);
      }
      CHECK(std::abs(deepest_gap(found) + S(0.002)) < S(2) * Tolerance<S>::equal());
    }
  }
}

TEST_CASE_TEMPLATE("mesh contacts: a box and its mesh are touched alike", T, SETUPS) {
  using S = typename T::S;
  // Shallow: up to 2 cm deep in boxes of about a metre. Deeper, the triangle-by-triangle view and
  // the solid's differ by design.
  Random random(4);
  for (std::size_t kind = 0; kind < kind_count; ++kind) {
    CAPTURE(kind);
    int touching = 0;
    int different = 0;
    for (int i = 0; i < rounds(200); ++i) {
      CAPTURE(i);
      const Vec3<S> half{random.uniform(S(0.3), S(1)), random.uniform(S(0.3), S(1)),
                         random.uniform(S(0.3), S(1))};
      const auto solid = T::make(Box<S>{half});
      const auto mesh = T::make(box_mesh<S>(half));
      const Shape<S> shape = random_solid<S>(random, kind);
      const auto other = T::make(shape);
      // For the reference a mesh is its hull.
      auto reference = other;
      if (const auto* m = std::get_if<TriangleMesh<S>>(&shape)) {
        reference = T::make(convex_hull<S>(*m));
      }
      // In along a random line until the gap is what is wanted.
      const Vec3<S> away = random.direction<S>();
      const Quat<S> attitude = random.rotation<S>();
      const S wanted = random.uniform(S(-0.02), S(0.01));
      S near = S(0);
      S far = S(4);
      for (int k = 0; k < 40; ++k) {
        const S middle = S(0.5) * (near + far);
        const auto at = T::contacts(solid, reference, {attitude, Vec3<S>(middle * away)}, S(4));
        (deepest_gap(at) < wanted ? near : far) = middle;
      }
      const Transform<S> X{attitude, Vec3<S>(far * away)};
      const S margin = S(0.015);
      const auto expected = T::contacts(solid, reference, X, margin);
      const auto found = T::contacts(mesh, other, X, margin);
      const S gap = deepest_gap(expected);
      if (gap == infinity<S>) continue;
      ++touching;
      CAPTURE(gap);
      CAPTURE(deepest_gap(found));
      REQUIRE(!found.empty());
      // The contact that is deepest for the solid is there, along its normal; nothing is much
      // deeper.
      S nearest = infinity<S>;
      for (const auto& m : found) {
        for (std::size_t k = 0; k < m.size; ++k) {
          if ((m.normal - expected[0].normal).norm() < S(0.05)) {
            nearest = std::min(nearest, std::abs(m.points[k].gap - gap));
          }
        }
      }
      const bool is_deeper = deepest_gap(found) < gap - std::abs(gap) - S(1e-3);
      if (nearest > S(1e-4) || is_deeper) ++different;
    }
    CHECK(touching > 100);
    // Two meshes that meet corner to corner have contacts of the faces beside the corners as well.
    CHECK(different <= (kind + 1 == kind_count ? touching / 10 : touching / 100));
  }
}

TEST_CASE_TEMPLATE("mesh contacts: a ball in the inner corner of a mesh touches both walls", T,
                   SETUPS) {
  using S = typename T::S;
  // The L of reference_shapes.hpp: foot's top at z = 0.5, mast's side at x = -0.5.
  const auto mesh = T::make(test::l_mesh<S>(S(1)));
  const auto ball = T::make(Sphere<S>{S(0.2)});
  const auto found =
      T::contacts(mesh, ball, {.translation = {S(-0.301), S(0.1), S(0.698)}}, S(0.01));
  REQUIRE(found.size() == 2);
  for (const auto& m : found) {
    CHECK(m.size == 1);
    const bool is_floor = m.normal.z() > S(0.5);
    const Vec3<S> expected = is_floor ? Vec3<S>(Vec3<S>::UnitZ()) : Vec3<S>(Vec3<S>::UnitX());
    CHECK((m.normal - expected).norm() < Tolerance<S>::round_off());
    CHECK(std::abs(m.points[0].gap - (is_floor ? S(-0.002) : S(-0.001))) <
          Tolerance<S>::round_off());
  }
}

TEST_CASE_TEMPLATE("mesh contacts: a ball whose middle is below a mesh's surface is pushed out", T,
                   SETUPS) {
  using S = typename T::S;
  const auto slab = T::make(tiled_slab<S>(S(1), S(0.5), 5));
  const auto ball = T::make(Sphere<S>{S(0.1)});
  const auto found =
      T::contacts(slab, ball, {.translation = {S(0.13), S(0.07), S(-0.02)}}, S(0.01));
  REQUIRE(found.size() == 1);
  CHECK((found[0].normal - Vec3<S>::UnitZ()).norm() < Tolerance<S>::round_off());
  CHECK(std::abs(deepest_gap(found) + S(0.12)) < Tolerance<S>::round_off());
}

TEST_CASE_TEMPLATE("mesh contacts: what is all inside a mesh leaves through the nearest face", T,
                   SETUPS) {
  using S = typename T::S;
  // 8 cm below the top of a slab of 50 cm, of whose triangles none is near.
  const auto slab = T::make(tiled_slab<S>(S(1), S(0.5), 5));
  const auto box = T::make(Box<S>{{S(0.03), S(0.02), S(0.01)}});
  const Transform<S> X{.translation = {S(0.13), S(0.07), S(-0.08)}};
  const auto found = T::contacts(slab, box, X, S(0.01));
  REQUIRE(found.size() == 1);
  CHECK((found[0].normal - Vec3<S>::UnitZ()).norm() < Tolerance<S>::round_off());
  CHECK(std::abs(deepest_gap(found) + S(0.09)) < Tolerance<S>::round_off());
  const auto back = T::contacts(box, slab, X.inverse(), S(0.01));
  REQUIRE(back.size() == 1);
  CHECK((back[0].normal + Vec3<S>::UnitZ()).norm() < Tolerance<S>::round_off());
  // In the hollow of an L nothing is inside.
  const auto l = T::make(test::l_mesh<S>(S(1)));
  CHECK(T::contacts(l, box, {.translation = {S(0.5), S(0), S(1)}}, S(0.01)).empty());
}

TEST_CASE_TEMPLATE("mesh contacts: crossed mesh planks touch where they cross", T, SETUPS) {
  using S = typename T::S;
  // No vertex of one is over the other.
  const auto plank = T::make(box_mesh<S>({S(1), S(0.1), S(0.05)}));
  const Transform<S> X{.rotation = exp_rotation<S>({S(0), S(0), S(1.5)}),
                       .translation = {S(0), S(0), S(0.099)}};
  const auto found = T::contacts(plank, plank, X, S(0.002));
  S least_x = S(1);
  S greatest_x = S(-1);
  for (const auto& m : found) {
    CHECK((m.normal - Vec3<S>::UnitZ()).norm() < Tolerance<S>::round_off());
    for (std::size_t i = 0; i < m.size; ++i) {
      CHECK(std::abs(m.points[i].gap + S(0.001)) < Tolerance<S>::round_off());
      CHECK(std::abs(m.points[i].position.y()) < S(0.1001));
      least_x = std::min(least_x, m.points[i].position.x());
      greatest_x = std::max(greatest_x, m.points[i].position.x());
    }
  }
  CHECK(least_x < S(-0.09));
  CHECK(greatest_x > S(0.09));
}
