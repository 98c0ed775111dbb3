/// @file
/// Rays through a whole world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/ray_filter.hpp>
#include <bristle/world/world_state.hpp>

#include <span>

namespace bristle::inline BRISTLE_ABI {

/// Nearest hit of a ray through a world.
template <Scalar S>
struct WorldRayHit {
  /// [m] Distance from the ray's start. Infinite without a hit, 0 where it starts inside.
  S distance = infinity<S>;
  /// [m] Point of the hit, in the world.
  Vec3<S> point = Vec3<S>::Zero();
  /// [1] Outward unit normal of the surface, in the world.
  Vec3<S> normal = Vec3<S>::Zero();
  /// [-] Body that was hit.
  BodyId body{};
  /// [-] Shape that was hit.
  ShapeId shape{};

  /// Returns whether the ray hit anything.
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

/// Nearest hit of a ray.
/// @param scratch  Room for one hit, allocated once for many rays.
template <Scalar S, typename Backend>
[[nodiscard]] WorldRayHit<S> cast_ray(const WorldState<S, Backend>& state, const Ray<S>& ray,
                                      const RayFilter& filter, RayHits<S>& scratch) {
  RayHit<S> best;
  std::uint32_t best_tag = 0;
  state.broad_phase.walk_ray(ray, [&](std::uint32_t tag, S nearest) {
    const Collider<S, Backend>& c = state.colliders.at(tag);
    const Body<S>& body = state.body_of(c);
    if (!can_meet(filter, c.body, body)) return nearest;
    // The frame starts at the ray's own origin, which keeps precision far from the world's.
    Transform<S> X_RS = body.center_pose * c.X_CmS;
    X_RS.translation -= ray.origin;
    const S zero = S(0);
    const S length = std::min(nearest, ray.length);
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
    Backend::cast_rays(c.shape, X_RS, batch, tag, scratch);
    // Visits follow the order of the tree. Ties go to the lower tag, as for sensors.
    const S distance = scratch.distance[0];
    if (distance < best.distance ||
        (distance == best.distance && scratch.is_hit(0) && tag < best_tag)) {
      best = {distance, scratch.normal[0]};
      best_tag = tag;
    }
    return std::min(nearest, best.distance);
  });
  WorldRayHit<S> result;
  if (!(best.distance < infinity<S>)) return result;
  result.distance = best.distance;
  result.normal = best.normal;
  result.point = ray.origin + best.distance * ray.direction;
  result.body = state.colliders.at(best_tag).body;
  result.shape = state.colliders.handle(best_tag);
  return result;
}

}  // namespace detail
}  // namespace bristle::inline BRISTLE_ABI
