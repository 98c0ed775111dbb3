/// @file
/// Hits of the rays of a patch: cast at the shapes in range, or extrapolated since the last cast.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/sensors/patch_scratch.hpp>
#include <bristle/world/query_filter.hpp>
#include <bristle/world/world_constants.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// A shape that the rays of a patch on A may meet within a step.
template <Scalar S>
struct ShapeInReach {
  std::uint32_t tag = 0;
  std::uint32_t generation = 0;
  const Collider<S>* collider = nullptr;
  /// [m] The shape and its body B, relative to A, about their centres of mass.
  Transform<S> X_AS{};
  Transform<S> X_AB{};
  /// [m] Farthest it can come closer within the step, and extra length of cast rays.
  S approach = S(0);
  S extra_length = S(0);
  /// [m] Box around the part that rays may meet, in A; for a half-space the plane instead.
  Aabb<S> box{};
  Vec3<S> normal = zero<Vec3<S>>();
  S offset = S(0);

  [[nodiscard]] bool is_near(const Aabb<S>& rays) const {
    if (!collider->half_space) return box.overlaps(rays);
    return normal.dot(rays.center()) - cwise_abs(normal).dot(rays.half_extents()) <= offset;
  }
  /// The same for the boxes with these corners.
  [[nodiscard]] BRISTLE_FORCE_INLINE Mask<S> is_near(const Pack3<S>& lower,
                                                     const Pack3<S>& upper) const {
    if (!collider->half_space) {
      return (lower.x <= Pack<S>(box.upper.x())) & (lower.y <= Pack<S>(box.upper.y())) &
             (lower.z <= Pack<S>(box.upper.z())) & (upper.x >= Pack<S>(box.lower.x())) &
             (upper.y >= Pack<S>(box.lower.y())) & (upper.z >= Pack<S>(box.lower.z()));
    }
    const Pack3<S> n = Pack3<S>::all(normal);
    const Pack<S> lowest = min(n.x * lower.x, n.x * upper.x) + min(n.y * lower.y, n.y * upper.y) +
                           min(n.z * lower.z, n.z * upper.z);
    return lowest <= Pack<S>(offset);
  }
};

/// Describes a shape relative to A.
/// @param X_AB      [m] Pose of its body about its centre of mass.
/// @param approach  [m] Farthest it can come closer within the step.
template <Scalar S>
[[nodiscard]] ShapeInReach<S> shape_in_reach(const SensorPatch<S>& patch, ShapeId id,
                                             const Collider<S>& collider, const Transform<S>& X_AB,
                                             S approach);

/// Fills `PatchScratch::near` and the hits of these packets.
/// @param shapes  By ascending tags.
/// @param is_due  True if the patch has to cast its rays in this step.
/// @return [-] Number of rays cast, one a sensor and shape.
template <Scalar S>
std::uint64_t find_hits(SensorPatch<S>& patch, PatchScratch<S>& scratch,
                        std::span<const ShapeInReach<S>> shapes, bool is_due);

// The same in parts. Threads share the second part.

/// Decides whether to cast; fills `PatchScratch::near` if so. Reset the hits there before
/// (`PatchScratch::reset_near_hits`).
template <Scalar S>
[[nodiscard]] bool needs_rays(const SensorPatch<S>& patch, PatchScratch<S>& scratch,
                              std::span<const ShapeInReach<S>> shapes, bool is_due);

/// Casts the rays of a range at one shape. Call it by ascending tags. If ranges are not packets of
/// sensors, cast all ranges before the next shape.
template <Scalar S>
void cast_rays_at(SensorPatch<S>& patch, PatchScratch<S>& scratch, const ShapeInReach<S>& shape,
                  RayRange range);

/// Stores the hits if rays are not cast in every step, and extrapolates them.
template <Scalar S>
void extrapolate_hits(SensorPatch<S>& patch, PatchScratch<S>& scratch,
                      std::span<const ShapeInReach<S>> shapes, bool has_cast);

// Implementation ----------------------------------------------------------------------------------

/// Returns whether a patch's sensors sense a shape.
template <Scalar S>
[[nodiscard]] bool senses(const WorldState<S>& state, const SensorPatch<S>& patch,
                          const Collider<S>& c) {
  return c.body != patch.body && !c.is_trigger && can_meet(patch.def, c.body, state.body_of(c));
}

/// [m/s] Fastest speed at which a body B can come closer to any point of a box on A.
/// @param box  [m] From A's centre of mass, in A's axes; `center_b` is B's centre, world axes.
template <Scalar S>
[[nodiscard]] S closing_speed(const Aabb<S>& box, const Transform<S>& X_WA, const Twist<S>& a,
                              const Vec3<S>& center_b, const Twist<S>& b) {
  const Vec3<S> center = X_WA.rotate(box.center());
  const Vec3<S> p_ab = center_b - X_WA.translation;
  const Vec3<S> v = a.at(center) - b.at(center - p_ab);
  return v.norm() + (a.angular - b.angular).norm() * box.half_extents().norm();
}

template <Scalar S>
ShapeInReach<S> shape_in_reach(const SensorPatch<S>& patch, ShapeId id, const Collider<S>& collider,
                               const Transform<S>& X_AB, S approach) {
  ShapeInReach<S> shape;
  shape.tag = id.index;
  shape.generation = id.generation;
  shape.collider = &collider;
  shape.X_AB = X_AB;
  shape.X_AS = X_AB * collider.X_CmS;
  shape.approach = approach;
  // The cache must stay valid for several steps.
  shape.extra_length = patch.def.cast_every > 1
                           ? approach + patch.geometry->shortest * S(chosen::plane_cache_margin)
                           : approach;
  if (collider.half_space) {
    shape.normal = shape.X_AS.rotate(collider.half_space->normal);
    shape.offset = collider.half_space->offset + shape.normal.dot(shape.X_AS.translation);
  } else {
    shape.box = transformed(collider.bounds, shape.X_AS).inflated(shape.extra_length);
  }
  // Boxes that touch but for rounding count, too.
  const S size = cwise_abs(shape.X_AS.translation).sum() + patch.geometry->reach + collider.radius;
  shape.offset += shape.extra_length + Tolerance<S>::round_off() * size;
  shape.box = shape.box.inflated(Tolerance<S>::round_off() * size);
  return shape;
}

/// Returns whether the plane cache is still valid.
template <Scalar S>
[[nodiscard]] bool serves(const SensorPatch<S>& patch, std::span<const ShapeInReach<S>> shapes) {
  const DynamicArray<PlaneCacheShape<S>>& kept = patch.plane_cache.shapes;
  if (kept.size() != shapes.size()) return false;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const ShapeInReach<S>& shape = shapes[i];
    if (kept[i].tag != shape.tag || kept[i].generation != shape.generation ||
        !kept[i].covers({shape.X_AB.rotation_matrix(), shape.X_AB.translation}, shape.approach,
                        patch.geometry->reach)) {
      return false;
    }
  }
  return true;
}

/// Returns whether the rays of a patch surely meet none of the shapes.
template <Scalar S>
[[nodiscard]] bool are_clear(const SensorPatch<S>& patch, std::span<const ShapeInReach<S>> shapes) {
  return std::all_of(shapes.begin(), shapes.end(), [&](const auto& shape) {
    return shape.collider->shape.is_surely_clear(shape.X_AS,
                                                 patch.geometry->rays(shape.extra_length));
  });
}

template <Scalar S>
bool needs_rays(const SensorPatch<S>& patch, PatchScratch<S>& scratch,
                std::span<const ShapeInReach<S>> shapes, bool is_due) {
  if (patch.def.cast_every > 1 && !is_due && serves(patch, shapes)) return false;
  // A patch without hits before mostly has none now. This early out is quicker than testing every
  // packet.
  if (!patch.has_hits && are_clear<S>(patch, shapes)) {
    scratch.near.clear();
    return true;
  }
  patch.geometry->packet_boxes.find(
      [&](const Pack3<S>& lower, const Pack3<S>& upper) {
        Mask<S> near = Mask<S>::first(0);
        for (const auto& shape : shapes) near = near | shape.is_near(lower, upper);
        return near;
      },
      scratch.near);
  return true;
}

template <Scalar S>
void cast_rays_at(SensorPatch<S>& patch, PatchScratch<S>& scratch, const ShapeInReach<S>& shape,
                  RayRange range) {
  RayBatch<S> rays = scratch.near_rays(shape.extra_length);
  rays.range = range;
  rays.triangle_cache = &patch.triangle_cache;
  rays.shape_life = shape.generation;
  shape.collider->shape.cast_rays(shape.X_AS, rays, shape.tag, scratch.hits);
}

template <Scalar S>
void extrapolate_hits(SensorPatch<S>& patch, PatchScratch<S>& scratch,
                      std::span<const ShapeInReach<S>> shapes, bool has_cast) {
  if (patch.def.cast_every == 1) return;
  if (has_cast) {
    patch.plane_cache.shapes.clear();
    for (const ShapeInReach<S>& shape : shapes) {
      patch.plane_cache.shapes.push_back({shape.tag,
                                          shape.generation,
                                          {shape.X_AB.rotation_matrix(), shape.X_AB.translation},
                                          shape.extra_length});
    }
    patch.plane_cache.keep(scratch);
  }
  // Also after a cast, so that all steps of a patch are alike.
  patch.plane_cache.advance(scratch, [&](std::uint32_t tag, PairPose<S>& pose) {
    const auto same = [tag](const auto& shape) { return shape.tag == tag; };
    const ShapeInReach<S>& shape = *std::find_if(shapes.begin(), shapes.end(), same);
    pose = {shape.X_AB.rotation_matrix(), shape.X_AB.translation};
    return shape.approach;
  });
}

template <Scalar S>
std::uint64_t find_hits(SensorPatch<S>& patch, PatchScratch<S>& scratch,
                        std::span<const ShapeInReach<S>> shapes, bool is_due) {
  const bool casts = needs_rays<S>(patch, scratch, shapes, is_due);
  const std::uint64_t rays = casts ? scratch.near_count() * shapes.size() : 0;
  if (rays > 0) {
    scratch.reset_near_hits();
    for (const ShapeInReach<S>& shape : shapes) cast_rays_at<S>(patch, scratch, shape, {});
  }
  extrapolate_hits<S>(patch, scratch, shapes, casts);
  return rays;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
