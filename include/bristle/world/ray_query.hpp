/// @file
/// Rays through a whole world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/query_filter.hpp>
#include <bristle/world/world_state.hpp>

#include <span>

namespace bristle::inline BRISTLE_ABI {

/// Result of a query of a world.
template <Scalar S>
struct WorldHit {
  /// [m] Way of a ray or a cast shape before the hit, or distance of the nearest shape. Infinite if
  /// nothing was found, 0 where the query starts inside or overlaps.
  S distance = infinity<S>;
  /// [m] Point of the hit, in the world.
  Vec3<S> point = detail::zero<Vec3<S>>();
  /// [1] Outward unit normal of the surface, in the world. Where a query starts inside it is that
  /// against its motion, and zero without motion.
  Vec3<S> normal = detail::zero<Vec3<S>>();
  /// [-] Body that was hit.
  BodyId body{};
  /// [-] Shape that was hit.
  ShapeId shape{};

  /// Returns whether anything was found.
  [[nodiscard]] bool is_hit() const { return distance < infinity<S>; }
};

namespace detail {

/// Checks a ray.
/// @throws InvalidArgument when the ray is not finite, has no unit direction or no length.
template <Scalar S>
void require_ray(const Ray<S>& ray) {
  using std::abs;
  require_all_finite("Ray::origin", ray.origin);
  require_all_finite("Ray::direction", ray.direction);
  require(abs(ray.direction.squaredNorm() - S(1)) <= Tolerance<S>::equal(), "Ray::direction",
          ray.direction.norm(), "must have length 1");
  require(ray.length > S(0), "Ray::length", ray.length, "must be > 0");
}

/// Nearest hit of a ray with one shape, within a length [m].
/// @param scratch  Room for one hit, allocated once for many rays.
template <Scalar S>
[[nodiscard]] RayHit<S> cast_ray_at(const WorldState<S>& state, std::uint32_t tag,
                                    const Ray<S>& ray, const S& length, RayHits<S>& scratch) {
  const Collider<S>& c = state.colliders.at(tag);
  // The frame starts at the ray's own origin, which keeps precision far from the world's.
  Transform<S> X_RS = state.body_of(c).center_pose * c.X_CmS;
  X_RS.translation -= ray.origin;
  const S zero = S(0);
  const auto one = [](const S& value) { return std::span<const S>(&value, 1); };
  const RayBatch<S> batch{one(zero),
                          one(zero),
                          one(zero),
                          one(ray.direction.x()),
                          one(ray.direction.y()),
                          one(ray.direction.z()),
                          one(length),
                          S(0)};
  scratch.reset(1);
  c.shape.cast_rays(X_RS, batch, tag, scratch);
  return {scratch.distance[0], scratch.normal[0]};
}

/// The hit of a ray with a shape, as callers see it.
template <Scalar S>
[[nodiscard]] WorldHit<S> world_hit(const WorldState<S>& state, std::uint32_t tag,
                                    const Ray<S>& ray, const RayHit<S>& hit) {
  return {hit.distance, ray.origin + hit.distance * ray.direction, hit.normal,
          state.colliders.at(tag).body, state.colliders.handle(tag)};
}

/// Nearest hit of a ray.
/// @param scratch  As above.
template <Scalar S>
[[nodiscard]] WorldHit<S> cast_ray(const WorldState<S>& state, const Ray<S>& ray,
                                   const QueryFilter& filter, RayHits<S>& scratch) {
  RayHit<S> best;
  std::uint32_t best_tag = 0;
  state.broad_phase.walk_ray(ray, [&](std::uint32_t tag, S nearest) {
    const Collider<S>& c = state.colliders.at(tag);
    if (!can_meet_shape(filter, c, state.body_of(c))) return nearest;
    const S length = std::min(nearest, ray.length);
    const RayHit<S> hit = cast_ray_at(state, tag, ray, length, scratch);
    // Visits follow the order of the tree. Ties go to the lower tag, as for sensors.
    if (hit.distance < best.distance ||
        (hit.distance == best.distance && hit.distance < infinity<S> && tag < best_tag)) {
      best = hit;
      best_tag = tag;
    }
    return std::min(nearest, best.distance);
  });
  if (!(best.distance < infinity<S>)) return {};
  return world_hit(state, best_tag, ray, best);
}

}  // namespace detail
}  // namespace bristle::inline BRISTLE_ABI
