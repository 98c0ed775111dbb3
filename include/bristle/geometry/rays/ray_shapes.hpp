/// @file
/// Hits of a ray with a shape, in closed form and in the shape's own frame.
///
/// `ray_cast(shape, ray)` returns the nearest hit, or a `RayHit` of infinite distance. All
/// overloads share these rules:
/// - Solids are closed. A ray that starts inside or on the surface is hit at distance 0 with the
///   normal -direction. A ray that only touches is hit.
/// - A hit counts up to and including `ray.length`, which may be infinite.
/// - Directions are unit vectors. Distances are right to a few ulp of the distance from the ray's
///   start to the far side of the shape. Closer to a tangent or surface, hit and miss are both
///   right. A start within round-off of the surface is never lost on its way in.
/// - Nothing is thrown or allocated, and no length is absolute.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/shapes/shapes.hpp>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

/// Ray and ball.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const Sphere<S>& sphere, const Ray<S>& ray);
/// Ray and box.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const Box<S>& box, const Ray<S>& ray);
/// Ray and capsule.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const Capsule<S>& capsule, const Ray<S>& ray);
/// Ray and cylinder.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const Cylinder<S>& cylinder, const Ray<S>& ray);
/// Ray and cone.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const Cone<S>& cone, const Ray<S>& ray);
/// Ray and ellipsoid.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const Ellipsoid<S>& ellipsoid, const Ray<S>& ray);
/// Ray and half-space.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const HalfSpace<S>& half_space, const Ray<S>& ray);
/// Ray and hull. O(faces).
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const ConvexHull<S>& hull, const Ray<S>& ray);

// Implementation ----------------------------------------------------------------------------------

namespace detail {

template <Scalar S>
[[nodiscard]] RayHit<S> start_inside(const Ray<S>& ray) {
  return {S(0), -ray.direction};
}

/// A hit at `distance` if the ray reaches it. Rounding may put a surface just behind the start.
template <Scalar S>
[[nodiscard]] RayHit<S> hit_within(const Ray<S>& ray, S distance, const Vec3<S>& normal) {
  if (!(distance <= ray.length && distance < infinity<S>)) return {};
  return {distance > S(0) ? distance : S(0), normal};
}

/// Part of a ray's line inside a convex set. Distances are from the ray's start. Empty if enter >
/// leave.
template <Scalar S>
struct Chord {
  S enter = -infinity<S>;
  S leave = infinity<S>;

  /// Returns whether the part lies in front of a start outside of the set. It is all in front or
  /// all behind. Rounding may move an end across the start, so the middle decides.
  [[nodiscard]] bool is_ahead() const { return enter <= leave && enter + leave >= S(0); }
};

/// Chord between the planes coordinate = low and coordinate = high. Within one of the planes, 0 / 0
/// = NaN loses the comparisons. That plane sets no bound.
template <Scalar S>
[[nodiscard]] Chord<S> slab_chord(S origin, S direction, S low, S high) {
  Chord<S> chord;
  const S inverse = S(1) / direction;
  S near = (low - origin) * inverse;
  S far = (high - origin) * inverse;
  if (inverse < S(0)) std::swap(near, far);
  if (near > chord.enter) chord.enter = near;
  if (far < chord.leave) chord.leave = far;
  return chord;
}

/// The two solutions of a t^2 - 2 b t + c = 0, in no order. They come from the root of the quarter
/// discriminant b^2 - a c. There is no cancellation (Press et al., Numerical Recipes, section 5.6).
/// One solution is infinite if a = 0.
template <Scalar S>
struct Roots {
  S first;
  S second;

  Roots(S a, S b, S c, S root) {
    const S q = b < S(0) ? b - root : b + root;
    if (value_of(a) != 0) {
      first = q / a;
    } else {
      first = b < S(0) ? infinity<S> : -infinity<S>;
    }
    second = value_of(q) != 0 ? c / q : S(0);
  }
};

/// A ray whose start is moved along it to where it comes near a shape. Later arithmetic then has
/// the shape's size and not the distance's.
template <Scalar S>
struct Approach {
  /// [m] Distance by which the start was moved, >= 0.
  S skipped = S(0);
  /// [m] The moved start.
  Vec3<S> origin;
  /// True if the line passes the ball around the shape's origin, up to rounding.
  bool is_near = true;

  /// @param radius  [m] Radius of a ball around the origin that holds the shape.
  Approach(const Ray<S>& ray, S radius) : origin(ray.origin) {
    const S closest = -ray.origin.dot(ray.direction);
    if (closest > radius) {
      skipped = closest - radius;
      origin += skipped * ray.direction;
    }
    // A wide margin: this test only saves work, the shape itself decides.
    is_near = (ray.origin + closest * ray.direction).squaredNorm() <=
              S(chosen::ball_early_out_area) * radius * radius;
  }
};

/// Chord of a disk of the given radius about the z axis: an infinite cylinder.
template <Scalar S>
[[nodiscard]] Chord<S> tube_chord(const Vec3<S>& origin, const Vec3<S>& direction, S radius) {
  using std::sqrt;
  const Vec2<S> o = xy_of(origin);
  const Vec2<S> d = xy_of(direction);
  const S a = d.squaredNorm();
  const S b = -o.dot(d);
  const S distance = o.norm();
  const S c = (distance - radius) * (distance + radius);
  if (!(a > S(0))) return c <= S(0) ? Chord<S>{} : Chord<S>{infinity<S>, -infinity<S>};
  // b^2 - a c by Lagrange's identity: the cross product is the axis' distance from the line.
  const S cross = o.x() * d.y() - o.y() * d.x();
  const S discriminant = a * radius * radius - cross * cross;
  if (discriminant < S(0)) return {infinity<S>, -infinity<S>};
  const Roots<S> roots(a, b, c, sqrt(discriminant));
  return {std::min(roots.first, roots.second), std::max(roots.first, roots.second)};
}

}  // namespace detail

template <Scalar S>
RayHit<S> ray_cast(const Sphere<S>& sphere, const Ray<S>& ray) {
  using std::sqrt;
  const S radius2 = sphere.radius * sphere.radius;
  if (ray.origin.squaredNorm() <= radius2) return detail::start_inside(ray);
  // The point closest to the centre is exact to an ulp of the distance. The usual discriminant
  // would lose a sphere that is far away.
  const S closest = -ray.origin.dot(ray.direction);
  if (closest < S(0)) return {};
  const Vec3<S> foot = ray.origin + closest * ray.direction;
  const S half2 = radius2 - foot.squaredNorm();
  if (half2 < S(0)) return {};
  const S half = sqrt(half2);
  const Vec3<S> point = foot - half * ray.direction;
  return detail::hit_within<S>(ray, closest - half, point.normalized());
}

template <Scalar S>
RayHit<S> ray_cast(const Box<S>& box, const Ray<S>& ray) {
  if (all_at_most(cwise_abs(ray.origin), box.half_extents)) {
    return detail::start_inside(ray);
  }
  detail::Chord<S> chord;
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    const S half = box.half_extents[i];
    const auto slab = detail::slab_chord(ray.origin[i], ray.direction[i], -half, half);
    if (slab.enter > chord.enter) {
      chord.enter = slab.enter;
      axis = i;
    }
    chord.leave = std::min(chord.leave, slab.leave);
  }
  if (!chord.is_ahead()) return {};
  Vec3<S> normal = detail::zero<Vec3<S>>();
  normal[axis] = ray.direction[axis] > S(0) ? S(-1) : S(1);
  return detail::hit_within<S>(ray, chord.enter, normal);
}

template <Scalar S>
RayHit<S> ray_cast(const Capsule<S>& capsule, const Ray<S>& ray) {
  using std::abs;
  const S radius = capsule.radius;
  const S half = capsule.half_length;
  const S nearest_z = std::clamp(ray.origin.z(), -half, half);
  const Vec3<S> from_axis = ray.origin - Vec3<S>(S(0), S(0), nearest_z);
  if (from_axis.squaredNorm() <= radius * radius) return detail::start_inside(ray);
  const detail::Approach<S> near(ray, half + radius);
  if (!near.is_near) return {};

  const auto tube = detail::tube_chord(near.origin, ray.direction, radius);
  if (!(tube.enter <= tube.leave)) return {};
  // A start inside the tube but outside the capsule is beyond one of the ends. It meets only the
  // ball there. Otherwise the height at which the ray enters the tube tells side from ends.
  const bool is_beyond_end =
      abs(near.origin.z()) > half && detail::xy_of(near.origin).squaredNorm() <= radius * radius;
  S z = near.origin.z();
  if (!is_beyond_end) {
    if (!tube.is_ahead()) return {};
    const Vec3<S> point = near.origin + tube.enter * ray.direction;
    z = point.z();
    if (abs(z) <= half) {
      return detail::hit_within<S>(ray, near.skipped + tube.enter,
                                   Vec3<S>(point.x(), point.y(), S(0)).normalized());
    }
  }
  const Vec3<S> center(S(0), S(0), z < S(0) ? -half : half);
  return ray_cast(Sphere<S>{radius}, Ray<S>{ray.origin - center, ray.direction, ray.length});
}

template <Scalar S>
RayHit<S> ray_cast(const Cylinder<S>& cylinder, const Ray<S>& ray) {
  using std::abs;
  const S radius = cylinder.radius;
  const S half = cylinder.half_length;
  const detail::Vec2<S> planar = detail::xy_of(ray.origin);
  if (planar.squaredNorm() <= radius * radius && abs(ray.origin.z()) <= half) {
    return detail::start_inside(ray);
  }
  const detail::Approach<S> near(ray, half + radius);
  if (!near.is_near) return {};
  const auto tube = detail::tube_chord(near.origin, ray.direction, radius);
  const auto slab = detail::slab_chord(near.origin.z(), ray.direction.z(), -half, half);
  const detail::Chord<S> chord{near.skipped + std::max(tube.enter, slab.enter),
                               near.skipped + std::min(tube.leave, slab.leave)};
  if (!chord.is_ahead()) return {};
  if (slab.enter >= tube.enter) {
    const S side = ray.direction.z() > S(0) ? S(-1) : S(1);
    return detail::hit_within<S>(ray, chord.enter, side * detail::unit_z<Vec3<S>>());
  }
  const Vec3<S> point = near.origin + tube.enter * ray.direction;
  return detail::hit_within<S>(ray, chord.enter, Vec3<S>(point.x(), point.y(), S(0)).normalized());
}

// The cone is the set x^2 + y^2 <= (k w)^2 with 0 <= w <= height. w = half_length - z is the depth
// below the apex and k = radius / height. Along the ray that is a quadratic a t^2 - 2 b t + c. Its
// negative set also holds the mirror cone at w < 0. The slab cuts that away.
template <Scalar S>
RayHit<S> ray_cast(const Cone<S>& cone, const Ray<S>& ray) {
  using std::sqrt;
  const S height = S(2) * cone.half_length;
  const S k = cone.radius / height;
  const S start_depth = cone.half_length - ray.origin.z();
  if (start_depth >= S(0) && start_depth <= height &&
      detail::xy_of(ray.origin).norm() <= k * start_depth) {
    return detail::start_inside(ray);
  }
  const detail::Approach<S> near(ray, cone.half_length + cone.radius);
  if (!near.is_near) return {};

  const detail::Vec2<S> o = detail::xy_of(near.origin);
  const detail::Vec2<S> d = detail::xy_of(ray.direction);
  const S w = cone.half_length - near.origin.z();
  const S dw = -ray.direction.z();
  const S a = d.squaredNorm() - k * k * dw * dw;
  const S b = k * k * w * dw - o.dot(d);
  const S c = (o.norm() - k * w) * (o.norm() + k * w);
  // b^2 - a c with the terms in k^4 cancelled by hand.
  const S cross = o.x() * d.y() - o.y() * d.x();
  const S discriminant = k * k * (w * d - dw * o).squaredNorm() - cross * cross;
  if (discriminant < S(0) && a > S(0)) return {};
  const detail::Roots<S> roots(a, b, c, sqrt(std::max(discriminant, S(0))));
  const S low = std::min(roots.first, roots.second);
  const S high = std::max(roots.first, roots.second);
  // A ray steeper than the side is in one cone before the first root. It is in the other after the
  // second.
  detail::Chord<S> side{low, high};
  if (!(a > S(0))) {
    side = dw > S(0) ? detail::Chord<S>{high, infinity<S>} : detail::Chord<S>{-infinity<S>, low};
  }
  const auto slab = detail::slab_chord(w, dw, S(0), height);
  const detail::Chord<S> chord{near.skipped + std::max(side.enter, slab.enter),
                               near.skipped + std::min(side.leave, slab.leave)};
  if (!chord.is_ahead()) return {};
  if (slab.enter >= side.enter) {
    // Through the base, or through the plane of the apex, of which only the apex is in the cone.
    const S up = dw > S(0) ? S(1) : S(-1);
    return detail::hit_within<S>(ray, chord.enter, up * detail::unit_z<Vec3<S>>());
  }
  const Vec3<S> point = near.origin + side.enter * ray.direction;
  const Vec3<S> gradient(point.x(), point.y(), k * k * (cone.half_length - point.z()));
  return detail::hit_within<S>(
      ray, chord.enter,
      gradient.squaredNorm() > S(0) ? Vec3<S>(gradient.normalized()) : detail::unit_z<Vec3<S>>());
}

// Stretched to the unit ball. Distances along the ray are the same in both spaces.
template <Scalar S>
RayHit<S> ray_cast(const Ellipsoid<S>& ellipsoid, const Ray<S>& ray) {
  using std::sqrt;
  const Vec3<S> scale = cwise_inverse(ellipsoid.radii);
  if (cwise_product(ray.origin, scale).squaredNorm() <= S(1)) return detail::start_inside(ray);
  const detail::Approach<S> near(ray, ellipsoid.radii.maxCoeff());
  if (!near.is_near) return {};
  const Vec3<S> o = cwise_product(near.origin, scale);
  const Vec3<S> d = cwise_product(ray.direction, scale);
  const S speed2 = d.squaredNorm();
  const S closest = -o.dot(d) / speed2;
  if (near.skipped + closest < S(0)) return {};
  const Vec3<S> foot = o + closest * d;
  const S half2 = (S(1) - foot.squaredNorm()) / speed2;
  if (half2 < S(0)) return {};
  const S half = sqrt(half2);
  const Vec3<S> point = foot - half * d;
  return detail::hit_within<S>(ray, near.skipped + (closest - half),
                               cwise_product(point, scale).normalized());
}

template <Scalar S>
RayHit<S> ray_cast(const HalfSpace<S>& half_space, const Ray<S>& ray) {
  const S height = half_space.normal.dot(ray.origin) - half_space.offset;
  if (height <= S(0)) return detail::start_inside(ray);
  const S speed = half_space.normal.dot(ray.direction);
  if (!(speed < S(0))) return {};
  return detail::hit_within<S>(ray, height / -speed, half_space.normal);
}

template <Scalar S>
RayHit<S> ray_cast(const ConvexHull<S>& hull, const Ray<S>& ray) {
  detail::Chord<S> chord;
  std::size_t entered = 0;
  bool is_inside = true;
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const S height = hull.face_normals[f].dot(ray.origin) - hull.face_offsets[f];
    const S speed = hull.face_normals[f].dot(ray.direction);
    is_inside = is_inside && height <= S(0);
    if (speed < S(0)) {
      const S t = height / -speed;
      if (t > chord.enter) {
        chord.enter = t;
        entered = f;
      }
    } else if (speed > S(0)) {
      chord.leave = std::min(chord.leave, -height / speed);
    } else if (height > S(0)) {
      return {};
    }
    if (chord.enter > chord.leave) return {};
  }
  if (is_inside) return detail::start_inside(ray);
  if (!chord.is_ahead()) return {};
  return detail::hit_within<S>(ray, chord.enter, hull.face_normals[entered]);
}

}  // namespace bristle::inline BRISTLE_ABI
