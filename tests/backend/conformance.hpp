/// @file
/// Requirements on every shape backend, as one suite over all shapes.
///
/// Expectations come from `ReferenceShape`: implicit functions that know nothing of the library.
/// Contacts of pairs that a backend does not know are left out, but it must say that it does not.
///
///     TEST_CASE_TEMPLATE("MyBackend: conforms", S, float, double) {
///       bristle::test::check_conformance<MyBackend, S>({});
///     }
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/shape_backend.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <backend/contact_conformance.hpp>
#include <backend/reference_shapes.hpp>
#include <cmath>
#include <string>
#include <support/random.hpp>
#include <vector>

namespace bristle::test {

using namespace bristle::detail;

/// How exact a backend has to be.
template <Scalar S>
struct ConformanceDef {
  /// [1] Error of a ray's distance, relative to the distance of the shape's far side. A handful of
  /// operations on coordinates of that size, and two changes of frame.
  S ray_tolerance = Tolerance<S>::round_off();
  /// [-] Error of contacts.
  ContactTolerance<S> contacts{};
  /// [-] Random rays for each shape.
  int rays = 300;
};

/// Arrays that own the rays of a batch.
template <Scalar S>
struct RayList {
  Vec3Array<S> origin;
  Vec3Array<S> direction;
  std::vector<S> length;

  void add(const Ray<S>& ray) {
    origin.resize(length.size() + 1);
    direction.resize(length.size() + 1);
    origin.set(length.size(), ray.origin);
    direction.set(length.size(), ray.direction);
    length.push_back(ray.length);
  }
  [[nodiscard]] RayBatch<S> batch(S extra_length = S(0)) const {
    return {origin.x,    origin.y,    origin.z, direction.x,
            direction.y, direction.z, length,   extra_length};
  }
};

/// The hit of one ray with a shape that stands at X_RC.
template <typename Backend, Scalar S>
RayHit<S> cast_one(const typename Backend::template Collidable<S>& c, const Transform<S>& X_RC,
                   const Ray<S>& ray) {
  RayList<S> list;
  list.add(ray);
  RayHits<S> hits;
  hits.reset(1);
  Backend::cast_rays(c, X_RC, list.batch(), 7, hits);
  if (hits.is_hit(0)) CHECK(hits.tag[0] == 7);
  return {hits.distance[0], hits.normal[0]};
}

template <typename Backend, Scalar S>
void check_bounds(const ConformanceDef<S>& def) {
  Random random(101);
  for (const ReferenceShape<S>& reference : reference_shapes<S>(S(1))) {
    CAPTURE(reference.name);
    const auto c = Backend::template make<S>(reference.shape);
    CHECK(Backend::kind(c) == kind_of(reference.shape));
    const Aabb<S> box = Backend::bounds(c);
    if (Backend::kind(c) == ShapeKind::half_space) {
      CHECK(box.upper.minCoeff() == infinity<S>);
      CHECK(box.lower.maxCoeff() == -infinity<S>);
      continue;
    }
    // Nothing of the shape sticks out, and every side of the box is reached.
    CHECK((box.lower - reference.box.lower).cwiseAbs().maxCoeff() <= def.ray_tolerance);
    CHECK((box.upper - reference.box.upper).cwiseAbs().maxCoeff() <= def.ray_tolerance);
    for (int i = 0; i < 200; ++i) {
      const Vec3<S> p = random.in_cube(S(2));
      if (reference.level(p) <= S(0)) CHECK(box.inflated(def.ray_tolerance).contains(p));
    }
  }
}

template <typename Backend, Scalar S>
void check_mass_properties(const ConformanceDef<S>&) {
  Random random(102);
  for (const ReferenceShape<S>& reference : reference_shapes<S>(S(1))) {
    CAPTURE(reference.name);
    const auto c = Backend::template make<S>(reference.shape);
    const MassProperties<S> properties = Backend::mass_properties(c);
    if (Backend::kind(c) == ShapeKind::half_space) {
      CHECK(properties.mass == S(0));
      continue;
    }
    // Monte Carlo over the box: 40000 samples are good to about 1 %, 4 sigma allowed.
    constexpr int count = 40000;
    const Vec3<double> half = reference.box.half_extents().template cast<double>();
    const Vec3<double> middle = reference.box.center().template cast<double>();
    double inside = 0;
    Vec3<double> first = Vec3<double>::Zero();
    Mat3<double> second = Mat3<double>::Zero();
    for (int i = 0; i < count; ++i) {
      const Vec3<double> p = middle + half.cwiseProduct(random.in_cube(1.0));
      if (reference.level(p.template cast<S>()) > S(0)) continue;
      inside += 1.0;
      first += p;
      second += p * p.transpose();
    }
    const double element = 8.0 * half.prod() / count;
    const double mass = inside * element;
    const Vec3<double> center = first / inside;
    const Mat3<double> spread = second * element - mass * center * center.transpose();
    const Mat3<double> inertia = spread.trace() * Mat3<double>::Identity() - spread;
    CHECK(std::abs(double(properties.mass) / mass - 1.0) < 0.04);
    CHECK((properties.center.template cast<double>() - center).norm() < 0.02 * half.norm());
    CHECK((properties.inertia.template cast<double>() - inertia).norm() < 0.05 * inertia.norm());
  }
}

/// A hit or miss of one ray, against the implicit function in the shape's frame.
template <Scalar S>
void check_hit(const ReferenceShape<S>& reference, const Ray<S>& ray, const RayHit<S>& hit,
               S tolerance) {
  const auto level = [&](S t) { return reference.level(ray.origin + t * ray.direction); };
  CAPTURE(reference.name);
  CAPTURE(ray.origin.transpose());
  CAPTURE(ray.direction.transpose());
  CAPTURE(ray.length);
  CAPTURE(hit.distance);
  const bool is_hit = hit.distance < infinity<S>;
  if (level(S(0)) < -tolerance) {
    CHECK(hit.distance == S(0));
    CHECK((hit.normal + ray.direction).norm() <= tolerance / reference.size + tolerance);
    return;
  }
  // All the way to the hit, or to the end, nothing was passed.
  const S end = is_hit ? hit.distance : std::min(ray.length, S(20) * reference.size);
  for (int i = 0; i < 64; ++i) CHECK(level(end * S(i) / S(64)) >= -tolerance);
  if (!is_hit) return;
  CHECK(hit.distance <= ray.length);
  CHECK(std::abs(level(hit.distance)) <= tolerance);
  CHECK(std::abs(hit.normal.norm() - S(1)) <= S(4) * Tolerance<S>::round_off());
  CHECK(hit.normal.dot(ray.direction) <= S(4) * Tolerance<S>::round_off());
  if (reference.is_convex && hit.distance > S(0)) {
    // Outwards the function grows as fast as the distance.
    const S step = S(0.01) * reference.size;
    const Vec3<S> out = ray.origin + hit.distance * ray.direction + step * hit.normal;
    CHECK(reference.level(out) >= S(0.5) * step);
  }
}

template <typename Backend, Scalar S>
void check_random_rays(const ConformanceDef<S>& def) {
  Random random(103);
  for (const S scale : {S(0.01), S(1), S(100)}) {
    for (const ReferenceShape<S>& reference : reference_shapes<S>(scale)) {
      const auto c = Backend::template make<S>(reference.shape);
      const Transform<S> X_RC = random.pose(S(2) * reference.size);
      int hit_count = 0;
      int inside_count = 0;
      for (int i = 0; i < def.rays; ++i) {
        // Aimed at the shape's middle region from around it, every fourth from a place inside.
        const S reach = i % 4 == 0 ? S(0.5) * reference.size : S(3) * reference.size;
        const Vec3<S> origin = random.in_cube(reach);
        Vec3<S> direction = random.template direction<S>();
        if (i % 2 == 0) direction = (random.in_cube(reference.size) - origin).normalized();
        const S length = i % 3 == 0 ? infinity<S> : random.uniform(S(0), S(4) * reference.size);
        const Ray<S> ray{origin, direction, length};
        const RayHit<S> hit =
            cast_one<Backend, S>(c, X_RC, {X_RC * origin, X_RC.rotate(direction), length});
        const RayHit<S> in_shape{hit.distance, X_RC.inverse().rotate(hit.normal)};
        // Relative to how far the coordinates are from the shape's frame and the rays'.
        S extent = S(8) * reference.size;
        if (hit.distance < infinity<S>) extent += hit.distance;
        check_hit(reference, ray, in_shape, def.ray_tolerance * extent);
        hit_count += hit.distance < infinity<S> ? 1 : 0;
        inside_count += hit.distance == S(0) ? 1 : 0;
      }
      CAPTURE(reference.name);
      CHECK(hit_count > def.rays / 10);
      CHECK(hit_count < def.rays * 19 / 20);
      CHECK(inside_count > 0);
    }
  }
}

/// Rays that end just before and just behind the surface, start just before, just behind and on it.
template <typename Backend, Scalar S>
void check_ray_limits(const ConformanceDef<S>& def) {
  const S slack = S(64) * def.ray_tolerance;
  for (const ReferenceShape<S>& reference : reference_shapes<S>(S(1))) {
    CAPTURE(reference.name);
    const auto c = Backend::template make<S>(reference.shape);
    const auto cast = [&](const Vec3<S>& origin, const Vec3<S>& direction, S length) {
      return cast_one<Backend, S>(c, Transform<S>{}, {origin, direction, length});
    };
    // From above onto the top, which every shape has at `top`.
    const Vec3<S> down = -Vec3<S>::UnitZ();
    const Vec3<S> above = reference.top + Vec3<S>(S(0), S(0), S(2));
    const RayHit<S> hit = cast(above, down, infinity<S>);
    CHECK(std::abs(hit.distance - S(2)) <= slack);
    CHECK(cast(above, down, S(2) - slack).distance == infinity<S>);
    CHECK(std::abs(cast(above, down, S(2) + slack).distance - S(2)) <= slack);
    // Nothing lies behind.
    CHECK(cast(above, -down, infinity<S>).distance == infinity<S>);
    CHECK(cast(reference.top - slack * down, -down, infinity<S>).distance == infinity<S>);
    // Inside is distance 0 in every direction, even with no length at all.
    for (const Vec3<S>& direction : {down, Vec3<S>(-down), Vec3<S>(Vec3<S>::UnitX())}) {
      const RayHit<S> inside = cast(reference.inside, direction, S(0));
      CHECK(inside.distance == S(0));
      CHECK((inside.normal + direction).norm() <= def.ray_tolerance);
    }
    // On the surface, inwards: 0, whatever the rounding.
    CHECK(cast(reference.top, down, S(1)).distance <= slack);
  }
}

/// The same rays onto a shape close by and far away: what is lost is relative to the distance.
template <typename Backend, Scalar S>
void check_far_rays(const ConformanceDef<S>& def) {
  for (const ReferenceShape<S>& reference : reference_shapes<S>(S(1))) {
    CAPTURE(reference.name);
    const auto c = Backend::template make<S>(reference.shape);
    for (const S distance : {S(10), S(1000)}) {
      const Vec3<S> above = reference.top + Vec3<S>(S(0), S(0), distance);
      const RayHit<S> hit =
          cast_one<Backend, S>(c, Transform<S>{}, {above, -Vec3<S>::UnitZ(), infinity<S>});
      CHECK(std::abs(hit.distance - distance) <= def.ray_tolerance * distance);
    }
  }
}

/// Requirements on a batch beyond those on its single rays.
template <typename Backend, Scalar S>
void check_batches(const ConformanceDef<S>& def) {
  const auto c = Backend::template make<S>(Sphere<S>{S(1)});
  RayList<S> list;
  for (int i = 0; i < 40; ++i) list.add({{S(3), S(0.02) * S(i), S(0)}, -Vec3<S>::UnitX(), S(1.5)});
  RayHits<S> hits;
  hits.reset(40);
  Transform<S> X_RC;
  Backend::cast_rays(c, X_RC, list.batch(), 1, hits);
  for (std::size_t i = 0; i < 40; ++i) CHECK(!hits.is_hit(i));
  // The extra length is added to every ray.
  Backend::cast_rays(c, X_RC, list.batch(S(2)), 1, hits);
  for (std::size_t i = 0; i < 40; ++i) {
    const S y = S(0.02) * S(int(i));
    CHECK(std::abs(hits.distance[i] - (S(3) - std::sqrt(S(1) - y * y))) <=
          S(8) * def.ray_tolerance);
    CHECK(hits.tag[i] == 1);
  }
  // A farther shape changes nothing, an equal one neither, a nearer one does.
  const LineArray<S> before = hits.distance;
  X_RC.translation.x() = S(-1);
  Backend::cast_rays(c, X_RC, list.batch(S(5)), 2, hits);
  CHECK(hits.distance == before);
  X_RC.translation.x() = S(0);
  Backend::cast_rays(c, X_RC, list.batch(S(5)), 3, hits);
  CHECK(hits.distance == before);
  CHECK(hits.tag[20] == 1);
  X_RC.translation.x() = S(0.5);
  Backend::cast_rays(c, X_RC, list.batch(S(5)), 4, hits);
  for (std::size_t i = 0; i < 40; ++i) CHECK(hits.tag[i] == 4);
  CHECK(std::abs(hits.distance[0] - S(1.5)) <= S(8) * def.ray_tolerance);
  // No rays at all are no error.
  hits.reset(0);
  Backend::cast_rays(c, X_RC, RayBatch<S>{}, 5, hits);
}

/// The whole suite, each part a subcase.
template <typename Backend, Scalar S>
void check_conformance(const ConformanceDef<S>& def) {
  static_assert(ShapeBackend<Backend, S>);
  SUBCASE("bounds hold the shape and touch it") { check_bounds<Backend, S>(def); }
  SUBCASE("mass properties are those of the solid") { check_mass_properties<Backend, S>(def); }
  SUBCASE("random rays, at three scales") { check_random_rays<Backend, S>(def); }
  SUBCASE("rays that start or end at the surface") { check_ray_limits<Backend, S>(def); }
  SUBCASE("rays from far away") { check_far_rays<Backend, S>(def); }
  SUBCASE("batches of rays") { check_batches<Backend, S>(def); }
  SUBCASE("contacts of shapes that just touch, at three scales") {
    check_touching_pairs<Backend, S>(def.contacts);
  }
  SUBCASE("contacts in random poses") { check_random_contacts<Backend, S>(def.contacts); }
  SUBCASE("contacts of concentric shapes") { check_degenerate_contacts<Backend, S>(); }
  SUBCASE("pairs it knows and pairs it does not") { check_known_pairs<Backend, S>(); }
  SUBCASE("contacts are appended") { check_contacts_are_appended<Backend, S>(); }
  SUBCASE("bad shapes are refused") { check_bad_shapes<Backend, S>(); }
}

}  // namespace bristle::test
