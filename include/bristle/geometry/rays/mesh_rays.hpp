/// @file
/// Rays against solid meshes, with any tree over their triangles.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/rays/ray_triangle.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/lane_register.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>

namespace bristle::inline BRISTLE_ABI::detail {

/// Boundary of a solid as triangles for ray traversal. `corners(i)` run counter-clockwise seen from
/// outside. `walk_ray` is that of `AabbTree`, with the triangle's number as payload.
template <typename M, typename S>
concept SolidMesh = Scalar<S> &&
    requires(const M& mesh, std::uint32_t i, const Ray<S>& ray, S (*visit)(std::uint32_t, S)) {
  { mesh.size() } -> std::convertible_to<std::size_t>;
  { mesh.corners(i) } -> std::same_as<std::array<Vec3<S>, 3>>;
  { mesh.root_box() } -> std::same_as<Aabb<S>>;
  mesh.walk_ray(ray, visit);
};

/// Returns the nearest hit of a solid mesh, under the rules of ray_shapes.hpp. Watertight.
///
/// The first crossing of the ray's line tells whether the ray starts inside. If the ray sees the
/// front of the surface there, the start is outside. If it sees the back, the start is inside. A
/// ray that grazes an edge crosses a front and a back at one distance. Then `is_inside_mesh`
/// decides.
template <Scalar S, SolidMesh<S> Mesh>
[[nodiscard]] RayHit<S> ray_cast_mesh(const Mesh& mesh, const Ray<S>& ray);

/// The same for a ray that starts outside, farther from the surface than rounding.
template <Scalar S, SolidMesh<S> Mesh>
[[nodiscard]] RayHit<S> ray_cast_mesh_from_outside(const Mesh& mesh, const Ray<S>& ray);

/// Returns whether a point is in the solid. Its surface is, to round-off.
template <Scalar S, SolidMesh<S> Mesh>
[[nodiscard]] bool is_inside_mesh(const Mesh& mesh, const Vec3<S>& point);

// Implementation ----------------------------------------------------------------------------------

/// Summary of the crossings of a ray in front of its start. Its bounds of front and back tell the
/// side of the start.
template <Scalar S>
struct MeshCrossings {
  /// [m] Nearest crossing and its triangle.
  S distance = infinity<S>;
  std::uint32_t triangle = 0;
  /// [m] Bounds of the nearest crossing of each kind.
  S front_low = infinity<S>;
  S front_high = infinity<S>;
  S back_low = infinity<S>;
  S back_high = infinity<S>;
  /// True if the surface passes through the start, up to rounding.
  bool is_start_on_surface = false;

  /// Returns whether the nearest crossing is within the ray's length.
  [[nodiscard]] bool is_within(const Ray<S>& ray) const {
    return distance <= ray.length && distance < infinity<S>;
  }
  /// Returns whether the start is inside. It is nullopt if front and back are too close to tell.
  [[nodiscard]] std::optional<bool> is_start_inside() const {
    if (!(distance < infinity<S>) || front_high < back_low) return false;
    if (back_high < front_low) return true;
    return std::nullopt;
  }
};

/// Moves a crossing into the box of its triangle. Rounding can move it out, if the triangle is seen
/// nearly edge-on. Infinite if the ray misses the box.
template <Scalar S>
[[nodiscard]] BRISTLE_NOINLINE S distance_within_box(const Ray<S>& ray,
                                                     const std::array<Vec3<S>, 3>& corners,
                                                     S distance) {
  const auto& [a, b, c] = corners;
  const S slack = Tolerance<S>::round_off() *
                  (cwise_abs(ray.origin) + cwise_abs(a) + cwise_abs(b) + cwise_abs(c)).sum();
  Aabb<S> box;
  for (const Vec3<S>& corner : corners) box.include(corner);
  box = box.inflated(slack);
  if (box.contains(ray.origin + distance * ray.direction)) return distance;
  const Vec3<S> inverse = cwise_inverse(ray.direction);
  S enter = -infinity<S>;
  S leave = infinity<S>;
  for (int i = 0; i < 3; ++i) {
    const S one = (box.lower[i] - ray.origin[i]) * inverse[i];
    const S other = (box.upper[i] - ray.origin[i]) * inverse[i];
    // The comparisons ignore a NaN, as from 0 times infinity.
    if (std::min(one, other) > enter) enter = std::min(one, other);
    if (std::max(one, other) < leave) leave = std::max(one, other);
  }
  return enter <= leave ? std::min(std::max(distance, enter), leave) : infinity<S>;
}

/// Collects the crossings of a ray.
template <Scalar S>
class CrossingCollector {
 public:
  explicit CrossingCollector(const Ray<S>& ray)
      : ray_(ray),
        test_(ray),
        trusted_(S(chosen::trusted_crossing_error) * Tolerance<S>::round_off() *
                 cwise_abs(ray.origin).sum()) {}

  /// Adds the crossing of a triangle. Neither this nor `hit_on` is inlined. So the compiler fuses
  /// products and sums alike for all callers.
  /// @return [m] Distance up to which further crossings matter.
  BRISTLE_NOINLINE S visit(std::uint32_t triangle, const std::array<Vec3<S>, 3>& corners, S reach) {
    // [1] Part of the triangle's distance. Crossings closer than that are at the start.
    const S at_start = S(chosen::start_crossing_error) * Tolerance<S>::round_off();
    const auto& [a, b, c] = corners;
    TriangleCrossing<S> crossing = test_(a, b, c);
    if (!(crossing.distance < infinity<S>)) return reach;
    if (!(crossing.uncertainty <= trusted_)) {
      crossing.distance = distance_within_box(ray_, corners, crossing.distance);
    }
    using std::abs;
    if (abs(crossing.distance) <= crossing.uncertainty &&
        crossing.uncertainty <= at_start * (a - ray_.origin).norm()) {
      found.is_start_on_surface = true;
    }
    if (!(crossing.distance >= S(0) && crossing.distance < infinity<S>)) return reach;
    // Of equal crossings the lowest number wins, whatever the order of visits.
    if (crossing.distance < found.distance ||
        (crossing.distance == found.distance && triangle < found.triangle)) {
      found.distance = crossing.distance;
      found.triangle = triangle;
    }
    S& low = crossing.is_front ? found.front_low : found.back_low;
    S& high = crossing.is_front ? found.front_high : found.back_high;
    low = std::min(low, crossing.distance - crossing.uncertainty);
    high = std::min(high, crossing.distance + crossing.uncertainty);
    return std::min({reach, found.front_high, found.back_high});
  }

  MeshCrossings<S> found;

 private:
  Ray<S> ray_;
  TriangleTest<S> test_;
  /// [m] Uncertainties up to this are rounding of the start.
  S trusted_;
};

/// Collects the crossings up to ray.length.
template <Scalar S, SolidMesh<S> Mesh>
[[nodiscard]] MeshCrossings<S> mesh_crossings(const Mesh& mesh, const Ray<S>& ray) {
  CrossingCollector<S> collector(ray);
  mesh.walk_ray(ray, [&](std::uint32_t triangle, S reach) {
    return collector.visit(triangle, mesh.corners(triangle), reach);
  });
  return collector.found;
}

/// Returns the hit of a ray at a distance, on a triangle.
template <Scalar S>
[[nodiscard]] BRISTLE_NOINLINE RayHit<S> hit_on(const std::array<Vec3<S>, 3>& corners,
                                                const Ray<S>& ray, S distance) {
  const auto& [a, b, c] = corners;
  const Vec3<S> normal = (b - a).cross(c - a).stableNormalized();
  return {distance, normal.dot(ray.direction) > S(0) ? Vec3<S>(-normal) : normal};
}

/// Returns the hit of a ray that starts outside, from its crossings.
template <Scalar S, SolidMesh<S> Mesh>
[[nodiscard]] RayHit<S> nearest_hit(const Mesh& mesh, const Ray<S>& ray,
                                    const MeshCrossings<S>& found) {
  if (!found.is_within(ray)) return {};
  return hit_on<S>(mesh.corners(found.triangle), ray, found.distance);
}

/// Winding number of the surface around a point, 1 inside and 0 outside. It sums the solid angles
/// of all triangles over 4 pi (van Oosterom and Strackee 1983). O(triangles), and never undecided.
template <Scalar S, SolidMesh<S> Mesh>
[[nodiscard]] S winding_number(const Mesh& mesh, const Vec3<S>& point) {
  using std::atan2;
  S half_angles = S(0);
  for (std::uint32_t i = 0; i < mesh.size(); ++i) {
    const auto corners = mesh.corners(i);
    const Vec3<S> a = corners[0] - point;
    const Vec3<S> b = corners[1] - point;
    const Vec3<S> c = corners[2] - point;
    const S la = a.norm();
    const S lb = b.norm();
    const S lc = c.norm();
    half_angles +=
        atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return half_angles / (S(2) * S(std::numbers::pi));
}

// Casts rays towards the middles of a few triangles, spread over the mesh. Each surely has a
// crossing. Hardly any meets an edge.
template <Scalar S, SolidMesh<S> Mesh>
bool is_inside_mesh(const Mesh& mesh, const Vec3<S>& point) {
  if (!mesh.root_box().contains(point)) return false;
  const std::size_t count = mesh.size();
  const std::size_t tries = std::min<std::size_t>(count, chosen::inside_test_rays);
  for (std::size_t i = 0; i < tries; ++i) {
    const auto [a, b, c] = mesh.corners(static_cast<std::uint32_t>(i * count / tries));
    const Vec3<S> towards = (a + b + c) / S(3) - point;
    const S distance = towards.norm();
    if (!(distance > S(0))) return true;
    const auto found = mesh_crossings(mesh, Ray<S>{point, towards / distance});
    if (found.is_start_on_surface) return true;
    const std::optional<bool> is_inside = found.is_start_inside();
    if (is_inside.has_value() && found.distance < infinity<S>) return *is_inside;
  }
  return winding_number(mesh, point) >= S(0.5);
}

template <Scalar S, SolidMesh<S> Mesh>
RayHit<S> ray_cast_mesh(const Mesh& mesh, const Ray<S>& ray) {
  // Only a start within the box can be inside. It needs more of its line than its length.
  const bool is_in_box = mesh.root_box().contains(ray.origin);
  const Ray<S> line{ray.origin, ray.direction, is_in_box ? infinity<S> : ray.length};
  const auto found = mesh_crossings(mesh, line);
  if (is_in_box) {
    const std::optional<bool> is_inside = found.is_start_inside();
    if (is_inside.has_value() ? *is_inside : is_inside_mesh(mesh, ray.origin)) {
      return {S(0), -ray.direction};
    }
  }
  return nearest_hit(mesh, ray, found);
}

template <Scalar S, SolidMesh<S> Mesh>
RayHit<S> ray_cast_mesh_from_outside(const Mesh& mesh, const Ray<S>& ray) {
  return nearest_hit(mesh, ray, mesh_crossings(mesh, ray));
}

}  // namespace bristle::inline BRISTLE_ABI::detail
