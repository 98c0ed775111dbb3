// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/geometry/backends/fcl_backend.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <support/random.hpp>
#include <support/rounds.hpp>
#include <vector>

// The two backends asked the same random questions. They share the formulas of single rays and the
// clipping of contacts, but neither frames, nor trees, nor the way to a contact normal.

using namespace bristle;
using namespace bristle::detail;
using bristle::test::Random;
using bristle::test::rounds;

namespace {

/// A shape of sizes between 0.2 and 1 times `scale`.
template <Scalar S>
Shape<S> random_shape(Random& random, ShapeKind kind, S scale) {
  const auto size = [&] { return scale * random.uniform(S(0.2), S(1)); };
  switch (kind) {
    case ShapeKind::sphere:
      return Sphere<S>{.radius = size()};
    case ShapeKind::box:
      return Box<S>{.half_extents = {size(), size(), size()}};
    case ShapeKind::capsule:
      return Capsule<S>{.radius = size(), .half_length = size()};
    case ShapeKind::cylinder:
      return Cylinder<S>{.radius = size(), .half_length = size()};
    case ShapeKind::cone:
      return Cone<S>{.radius = size(), .half_length = size()};
    case ShapeKind::ellipsoid:
      return Ellipsoid<S>{.radii = {size(), size(), size()}};
    case ShapeKind::half_space:
      return HalfSpace<S>{.normal = random.direction<S>(), .offset = random.uniform(-scale, scale)};
    case ShapeKind::convex_hull: {
      std::vector<Vec3<S>> points;
      for (int i = 0; i < 16; ++i) points.push_back(random.in_cube(scale));
      return convex_hull<S>(points);
    }
    default:
      return sphere_mesh<S>(size(), 4);
  }
}

/// One ray in the arrays that a batch wants.
template <Scalar S>
struct OneRay {
  explicit OneRay(const Ray<S>& r) : ray(r) {}

  template <typename Backend>
  RayHit<S> cast(const typename Backend::template Collidable<S>& c, const Transform<S>& X) const {
    const auto one = [](const S& value) { return std::span<const S>(&value, 1); };
    const RayBatch<S> batch{one(ray.origin.x()),    one(ray.origin.y()),    one(ray.origin.z()),
                            one(ray.direction.x()), one(ray.direction.y()), one(ray.direction.z()),
                            one(ray.length)};
    RayHits<S> hits;
    hits.reset(1);
    Backend::cast_rays(c, X, batch, 7u, hits);
    return {hits.distance[0], hits.is_hit(0) ? hits.normal[0] : Vec3<S>(Vec3<S>::Zero())};
  }

  Ray<S> ray;
};

/// Returns whether two hits of one ray agree up to `tolerance` [m], larger along steep surfaces,
/// and their normals up to `turn` [1].
template <Scalar S>
bool agree(const RayHit<S>& a, const RayHit<S>& b, const Vec3<S>& direction, S tolerance, S turn) {
  const bool is_hit = a.distance < infinity<S>;
  if (is_hit != (b.distance < infinity<S>)) return false;
  if (!is_hit) return true;
  const S steepness = std::max(std::abs(a.normal.dot(direction)), S(0.001));
  return std::abs(a.distance - b.distance) <= tolerance / steepness &&
         (a.normal - b.normal).norm() <= turn / steepness;
}

/// Deepest point of all manifolds, with its normal.
template <Scalar S>
struct Deepest {
  S gap = infinity<S>;
  Vec3<S> normal = Vec3<S>::Zero();
};

template <typename Backend, Scalar S>
Deepest<S> deepest(const typename Backend::template Collidable<S>& a,
                   const typename Backend::template Collidable<S>& b, const Transform<S>& X,
                   S margin) {
  ContactManifolds<S> out;
  REQUIRE(Backend::collide(a, b, X, margin, out) == ContactStatus::ok);
  Deepest<S> result;
  for (const ContactManifold<S>& m : out) {
    CHECK(m.size > 0);
    CHECK(std::abs(m.normal.norm() - S(1)) < Tolerance<S>::round_off());
    for (std::size_t i = 0; i < m.size; ++i) {
      if (m.points[i].gap < result.gap) result = {m.points[i].gap, m.normal};
    }
  }
  return result;
}

}  // namespace

TEST_CASE_TEMPLATE("backends: rays get the same answers from both", S, float, double) {
  // Round-off of a few operations on numbers as large as the distance to the shape's far side, 10
  // sizes; the float backend's pose is composed in float, FCL's in double. The planes of a hull are
  // made for FCL's copy anew from its corners, and equal up to the resolution of hulls.
  Random random(11);
  for (std::size_t k = 0; k < shape_kind_count; ++k) {
    const auto kind = static_cast<ShapeKind>(k);
    CAPTURE(std::string(name_of(kind)));
    const S precision = S(20) * Tolerance<S>::round_off() +
                        (kind == ShapeKind::convex_hull ? S(4) * hull_resolution<S>() : S(0));
    int hits = 0;
    int grazing = 0;
    int asked = 0;
    for (const S scale : {S(0.01), S(1), S(100)}) {
      for (int n = 0; n < rounds(8); ++n) {
        const Shape<S> shape = random_shape(random, kind, scale);
        const auto by_formula = AnalyticBackend::make(shape);
        const auto by_fcl = FclBackend::make(shape);
        const Transform<S> X = random.pose(scale);
        for (int i = 0; i < 100; ++i, ++asked) {
          Ray<S> ray;
          ray.origin = X.translation + random.in_cube(S(3) * scale);
          // Half of them aimed, so that most hit.
          ray.direction =
              i % 2 == 0
                  ? random.direction<S>()
                  : Vec3<S>(
                        (X.translation + random.in_cube(S(0.5) * scale) - ray.origin).normalized());
          ray.length = i % 3 == 0 ? infinity<S> : random.uniform(S(0), S(6) * scale);
          const RayHit<S> expected = OneRay<S>(ray).template cast<AnalyticBackend>(by_formula, X);
          const RayHit<S> found = OneRay<S>(ray).template cast<FclBackend>(by_fcl, X);
          if (expected.distance < infinity<S>) ++hits;
          const S tolerance = precision * scale;
          const S turn = S(10) * precision;
          if (agree(expected, found, ray.direction, tolerance, turn)) continue;
          // Rays within round-off of an edge, a tangent or their own end may get the answer of
          // their neighbours: moved by the tolerance in any direction.
          ++grazing;
          bool is_neighbour = false;
          for (int j = 0; j < 64 && !is_neighbour; ++j) {
            Ray<S> moved = ray;
            moved.origin += tolerance * random.in_cube(S(4));
            moved.length += tolerance * random.uniform(S(-4), S(4));
            const RayHit<S> other = OneRay<S>(moved).template cast<AnalyticBackend>(by_formula, X);
            is_neighbour = agree(other, found, ray.direction, S(10) * tolerance, S(10) * turn);
          }
          CAPTURE(scale);
          CAPTURE(n);
          CAPTURE(i);
          CAPTURE(expected.distance);
          CAPTURE(found.distance);
          CAPTURE(expected.normal.transpose());
          CAPTURE(found.normal.transpose());
          CHECK(is_neighbour);
        }
      }
    }
    CHECK(hits > asked / 5);
    CHECK(grazing <= asked / 100);
  }
}

namespace {

/// Properties of a pair that its tolerances depend on.
struct PairTraits {
  PairTraits(ShapeKind a, ShapeKind b) {
    const auto has = [&](ShapeKind kind) { return a == kind || b == kind; };
    is_on_plane = has(ShapeKind::half_space);
    is_boxes = a == ShapeKind::box && b == ShapeKind::box;
    is_mesh = has(ShapeKind::triangle_mesh) && !is_on_plane;
    is_curved = !is_on_plane &&
                (has(ShapeKind::cylinder) || has(ShapeKind::cone) || has(ShapeKind::ellipsoid));
  }
  bool is_on_plane, is_boxes, is_mesh, is_curved;
};

/// [1] How far the gaps of two backends may differ, relative to the size.
template <Scalar S>
S gap_tolerance(const PairTraits& pair) {
  S tolerance = S(20) * Tolerance<S>::round_off();
  // On a plane the analytic backend thins points first, and takes depths as equal within
  // Tolerance::equal. Mesh contacts join points within it.
  if (pair.is_on_plane || pair.is_mesh) tolerance += S(4) * Tolerance<S>::equal();
  // Accuracy of curved cores by contact_normal.hpp: 1e-8 each, and a factor of ten in reserve,
  // since libccd is one of the two.
  if (pair.is_curved) tolerance = std::max(tolerance, S(1e-7));
  // A mesh's contacts lie where features cross, not at supports: there a gap takes the error of the
  // normal, the root of that of a depth, times the distance from the support, a tenth of the size.
  if (pair.is_curved && pair.is_mesh) tolerance = std::max(tolerance, S(1e-5));
  return tolerance;
}

}  // namespace

TEST_CASE_TEMPLATE("backends: contacts are as deep by both, along the same normal", S, float,
                   double) {
  Random random(12);
  const S scales[] = {S(0.01), S(1), S(100)};
  for (std::size_t ka = 0; ka < shape_kind_count; ++ka) {
    for (std::size_t kb = 0; kb < shape_kind_count; ++kb) {
      const auto kind_a = static_cast<ShapeKind>(ka);
      const auto kind_b = static_cast<ShapeKind>(kb);
      CHECK(AnalyticBackend::can_collide(kind_a, kind_b) ==
            FclBackend::can_collide(kind_a, kind_b));
      if (!AnalyticBackend::can_collide(kind_a, kind_b)) continue;
      CAPTURE(std::string(name_of(kind_a)));
      CAPTURE(std::string(name_of(kind_b)));
      const PairTraits pair(kind_a, kind_b);
      int touching = 0;
      int elsewhere = 0;
      // Meshes of 320 triangles cost as much as a hundred solids.
      const int count = rounds(pair.is_mesh ? 10 : 60);
      for (int n = 0; n < 3 * count; ++n) {
        const S scale = scales[n % 3];
        CAPTURE(n);
        const Shape<S> shape_a = random_shape(random, kind_a, scale);
        const Shape<S> shape_b = random_shape(random, kind_b, scale);
        const auto formula_a = AnalyticBackend::make(shape_a);
        const auto formula_b = AnalyticBackend::make(shape_b);
        const auto fcl_a = FclBackend::make(shape_a);
        const auto fcl_b = FclBackend::make(shape_b);
        const Transform<S> X = random.pose(S(1.2) * scale);
        const S margin = S(0.05) * scale;
        const auto expected = deepest<AnalyticBackend>(formula_a, formula_b, X, margin);
        const auto found = deepest<FclBackend>(fcl_a, fcl_b, X, margin);
        const S tolerance = scale * gap_tolerance<S>(pair);
        // At the margin itself one may see what the other does not.
        if (expected.gap == infinity<S> || found.gap == infinity<S>) {
          const S gap = std::min(expected.gap, found.gap);
          CHECK((gap == infinity<S> || std::abs(gap - margin) <= tolerance));
          continue;
        }
        ++touching;
        CAPTURE(scale);
        CAPTURE(expected.gap);
        CAPTURE(found.gap);
        CAPTURE(expected.normal.transpose());
        CAPTURE(found.normal.transpose());
        if (pair.is_boxes) {
          // The analytic backend prefers faces until an edge is better by a twentieth.
          CHECK((found.gap < S(0)) == (expected.gap < S(0)));
          CHECK(found.gap >= expected.gap - tolerance);
          CHECK(found.gap <= expected.gap + S(0.06) * std::abs(expected.gap) + tolerance);
          continue;
        }
        const bool is_same_direction = (found.normal - expected.normal).norm() <= S(1e-3);
        // Two directions of equal depth, within what the search resolves: both are right.
        const bool is_other_valley =
            !is_same_direction && pair.is_curved && expected.gap < S(0) &&
            std::abs(found.gap - expected.gap) <= S(0.02) * std::abs(expected.gap);
        CHECK((is_other_valley || std::abs(found.gap - expected.gap) <= tolerance));
        if (!is_same_direction) ++elsewhere;
      }
      CHECK(touching > count / 2);
      CHECK(elsewhere <= touching / 50);
    }
  }
}

TEST_CASE_TEMPLATE("backends: agree apart, at touch and at shallow depths, one way and the other",
                   S, float, double) {
  // B comes in along a random line until the gap is what is wanted.
  Random random(13);
  for (std::size_t ka = 0; ka < shape_kind_count; ++ka) {
    for (std::size_t kb = ka; kb < shape_kind_count; ++kb) {
      const auto kind_a = static_cast<ShapeKind>(ka);
      const auto kind_b = static_cast<ShapeKind>(kb);
      if (!AnalyticBackend::can_collide(kind_a, kind_b)) continue;
      CAPTURE(std::string(name_of(kind_a)));
      CAPTURE(std::string(name_of(kind_b)));
      const PairTraits pair(kind_a, kind_b);
      // Deep in each other two meshes see nothing, and there is no way in (mesh_contacts_test.cpp).
      if (kind_a == ShapeKind::triangle_mesh && kind_b == kind_a) continue;
      int asked = 0;
      int jumped = 0;
      int elsewhere = 0;
      const int count = rounds(pair.is_mesh ? 1 : 10);
      for (int n = 0; n < 4 * count; ++n) {
        CAPTURE(n);
        const S wanted = std::array{S(0.03), S(0), S(-1e-3), S(-0.02)}[std::size_t(n) % 4];
        const Shape<S> shape_a = random_shape(random, kind_a, S(1));
        const Shape<S> shape_b = random_shape(random, kind_b, S(1));
        const auto own_a = AnalyticBackend::make(shape_a);
        const auto own_b = AnalyticBackend::make(shape_b);
        const Quat<S> attitude = random.rotation<S>();
        // Out of a half-space, whose middle is anywhere, only along its normal.
        const auto* plane = std::get_if<HalfSpace<S>>(&shape_a);
        const auto* other_plane = std::get_if<HalfSpace<S>>(&shape_b);
        Vec3<S> away = random.direction<S>();
        if (plane != nullptr) away = plane->normal;
        if (other_plane != nullptr) away = attitude * Vec3<S>(-other_plane->normal);
        S near = S(-4);
        S far = S(6);
        if (plane == nullptr && other_plane == nullptr) near = S(0);
        for (int k = 0; k < 30; ++k) {
          const S middle = S(0.5) * (near + far);
          const auto at = deepest<AnalyticBackend>(own_a, own_b, {attitude, middle * away}, S(12));
          (at.gap < wanted ? near : far) = middle;
        }
        const Transform<S> X{attitude, Vec3<S>(far * away)};
        const S margin = S(0.05);
        const auto expected = deepest<AnalyticBackend>(own_a, own_b, X, margin);
        const auto found =
            deepest<FclBackend>(FclBackend::make(shape_a), FclBackend::make(shape_b), X, margin);
        const auto swapped = deepest<AnalyticBackend>(own_b, own_a, X.inverse(), margin);
        CAPTURE(expected.gap);
        CAPTURE(found.gap);
        CAPTURE(swapped.gap);
        CAPTURE(expected.normal.transpose());
        CAPTURE(found.normal.transpose());
        // The way in may end at a jump, from one way out to another.
        if (std::abs(expected.gap - wanted) > S(1e-3)) {
          ++jumped;
          continue;
        }
        REQUIRE(found.gap < infinity<S>);
        REQUIRE(swapped.gap < infinity<S>);
        // Two boxes prefer faces by a twentieth of the overlap.
        const S tolerance =
            gap_tolerance<S>(pair) + (pair.is_boxes ? S(0.06) * std::abs(expected.gap) : S(0)) +
            (pair.is_curved && expected.gap < S(0) ? S(0.02) * std::abs(expected.gap) : S(0));
        CHECK(std::abs(found.gap - expected.gap) <= tolerance);
        CHECK(std::abs(swapped.gap - expected.gap) <= tolerance);
        // At a touch of corners any direction between the faces is right.
        if (wanted == S(0)) continue;
        ++asked;
        const S turn = std::max((found.normal - expected.normal).norm(),
                                (X.rotate(swapped.normal) + expected.normal).norm());
        if (turn > S(1e-3)) ++elsewhere;
      }
      CHECK(jumped <= count);
      // Two ways out of equal depth, or two triangles at an equal distance.
      CHECK(elsewhere <= 1 + asked / 10);
    }
  }
}
