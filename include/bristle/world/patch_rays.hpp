/// @file
/// What the rays of a patch meet: cast at the shapes in reach, or carried on since they were cast.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/patch.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI {

/// A shape that the rays of a patch on A may meet within a step.
template <Scalar S, typename Backend>
struct ShapeInReach {
  std::uint32_t tag = 0;
  std::uint32_t generation = 0;
  const Collider<S, Backend>* collider = nullptr;
  /// [m] The shape and its body B about their centres of mass, as A sees them.
  Transform<S> X_AS{};
  Transform<S> X_AB{};
  /// [m] By how much it can come closer within the step, and how much longer rays are cast.
  S approach = S(0);
  S extra_length = S(0);
  /// [m] Around what the rays may meet of it, in A; for a half-space the plane instead.
  Aabb<S> box{};
  Vec3<S> normal = Vec3<S>::Zero();
  S offset = S(0);

  [[nodiscard]] bool is_near(const Aabb<S>& rays) const {
    if (!collider->half_space) return box.overlaps(rays);
    return normal.dot(rays.center()) - normal.cwiseAbs().dot(rays.half_extents()) <= offset;
  }
  /// The same of the boxes with these corners.
  [[nodiscard]] BRISTLE_INLINE Mask<S> is_near(const Pack3<S>& lower, const Pack3<S>& upper) const {
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

/// Looks at a shape from A.
/// @param X_AB      [m] Its body about its centre of mass.
/// @param approach  [m] By how much it can come closer within the step.
template <Scalar S, typename Backend>
[[nodiscard]] ShapeInReach<S, Backend> shape_in_reach(const SensorPatch<S>& patch, ShapeId id,
                                                      const Collider<S, Backend>& collider,
                                                      const Transform<S>& X_AB, S approach);

/// Fills `patch.near` and the hits of these tiles.
/// @param shapes  By ascending tags.
/// @param is_due  Whether it is the patch's turn to cast its rays.
/// @return [-] Number of rays cast, one a sensor and shape.
template <Scalar S, typename Backend>
std::uint64_t find_hits(SensorPatch<S>& patch, std::span<const ShapeInReach<S, Backend>> shapes,
                        bool is_due);

// The same in parts, for threads that share the second.

/// Decides whether rays are to be cast, and fills `patch.near` if so. Before they are, hits there
/// are to be forgotten (`SensorPatch::reset_near_hits`).
template <Scalar S, typename Backend>
[[nodiscard]] bool wants_rays(SensorPatch<S>& patch,
                              std::span<const ShapeInReach<S, Backend>> shapes, bool is_due);

/// Casts the rays of a slice at one of the shapes, which are asked by ascending tags. Where slices
/// are not runs of sensors, all of them before the next shape is.
template <Scalar S, typename Backend>
void cast_rays_at(SensorPatch<S>& patch, const ShapeInReach<S, Backend>& shape, RaySlice slice);

/// Keeps what was met, where rays are not cast in every step, and carries it on.
template <Scalar S, typename Backend>
void carry_hits(SensorPatch<S>& patch, std::span<const ShapeInReach<S, Backend>> shapes,
                bool has_cast);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// Whether the sensors of a patch take notice of a shape.
template <Scalar S, typename Backend>
[[nodiscard]] bool sees(const WorldState<S, Backend>& state, const SensorPatch<S>& patch,
                        const Collider<S, Backend>& c) {
  if (c.body == patch.body) return false;
  if ((patch.def.sees & state.body_of(c).filter.category) == 0) return false;
  return std::find(patch.def.excluded.begin(), patch.def.excluded.end(), c.body) ==
         patch.def.excluded.end();
}

/// [m/s] How fast a body B can come closer to any point of a box on A.
/// @param box  [m] From A's centre of mass, in A's axes; `center_b` is B's centre, world axes.
template <Scalar S>
[[nodiscard]] S closing_speed(const Aabb<S>& box, const Transform<S>& X_WA, const Twist<S>& a,
                              const Vec3<S>& center_b, const Twist<S>& b) {
  const Vec3<S> center = X_WA.rotate(box.center());
  const Vec3<S> p_ab = center_b - X_WA.translation;
  const Vec3<S> v = a.at(center) - b.at(center - p_ab);
  return v.norm() + (a.angular - b.angular).norm() * box.half_extents().norm();
}

}  // namespace detail

template <Scalar S, typename Backend>
ShapeInReach<S, Backend> shape_in_reach(const SensorPatch<S>& patch, ShapeId id,
                                        const Collider<S, Backend>& collider,
                                        const Transform<S>& X_AB, S approach) {
  ShapeInReach<S, Backend> shape;
  shape.tag = id.index;
  shape.generation = id.generation;
  shape.collider = &collider;
  shape.X_AB = X_AB;
  shape.X_AS = X_AB * collider.X_CmS;
  shape.approach = approach;
  // What is kept must last for a while.
  shape.extra_length = patch.def.cast_every > 1 ? approach + patch.shortest / S(4) : approach;
  if (collider.half_space) {
    shape.normal = shape.X_AS.rotate(collider.half_space->normal);
    shape.offset = collider.half_space->offset + shape.normal.dot(shape.X_AS.translation);
  } else {
    shape.box = transformed(collider.bounds, shape.X_AS).inflated(shape.extra_length);
  }
  // Boxes that touch but for their rounding do touch.
  const S size = shape.X_AS.translation.cwiseAbs().sum() + patch.reach + collider.radius;
  shape.offset += shape.extra_length + Tolerance<S>::round_off() * size;
  shape.box = shape.box.inflated(Tolerance<S>::round_off() * size);
  return shape;
}

namespace detail {

/// Whether what was met when the rays were cast last still serves.
template <Scalar S, typename Backend>
[[nodiscard]] bool serves(const SensorPatch<S>& patch,
                          std::span<const ShapeInReach<S, Backend>> shapes) {
  const std::vector<KeptShape<S>>& kept = patch.kept.shapes;
  if (kept.size() != shapes.size()) return false;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const ShapeInReach<S, Backend>& shape = shapes[i];
    if (kept[i].tag != shape.tag || kept[i].generation != shape.generation ||
        !kept[i].covers({shape.X_AB.rotation_matrix(), shape.X_AB.translation}, shape.approach,
                        patch.reach)) {
      return false;
    }
  }
  return true;
}

/// Whether the rays of a patch surely meet none of the shapes.
template <Scalar S, typename Backend>
[[nodiscard]] bool are_clear(const SensorPatch<S>& patch,
                             std::span<const ShapeInReach<S, Backend>> shapes) {
  return std::all_of(shapes.begin(), shapes.end(), [&](const auto& shape) {
    return is_surely_clear<S, Backend>(shape.collider->shape, shape.X_AS,
                                       patch.rays(shape.extra_length));
  });
}

}  // namespace detail

template <Scalar S, typename Backend>
bool wants_rays(SensorPatch<S>& patch, std::span<const ShapeInReach<S, Backend>> shapes,
                bool is_due) {
  if (patch.def.cast_every > 1 && !is_due && detail::serves(patch, shapes)) return false;
  // What met nothing in the last step mostly meets nothing now, and a look tells more quickly than
  // asking every tile.
  if (patch.contacts.empty() && detail::are_clear<S, Backend>(patch, shapes)) {
    patch.near.clear();
    return true;
  }
  patch.tile_boxes.find(
      [&](const Pack3<S>& lower, const Pack3<S>& upper) {
        Mask<S> near = Mask<S>::first(0);
        for (const auto& shape : shapes) near = near | shape.is_near(lower, upper);
        return near;
      },
      patch.near);
  return true;
}

template <Scalar S, typename Backend>
void cast_rays_at(SensorPatch<S>& patch, const ShapeInReach<S, Backend>& shape, RaySlice slice) {
  RayBatch<S> rays = patch.near_rays(shape.extra_length);
  rays.slice = slice;
  rays.kept = &patch.candidates;
  rays.shape_life = shape.generation;
  Backend::cast_rays(shape.collider->shape, shape.X_AS, rays, shape.tag, patch.hits);
}

template <Scalar S, typename Backend>
void carry_hits(SensorPatch<S>& patch, std::span<const ShapeInReach<S, Backend>> shapes,
                bool has_cast) {
  if (patch.def.cast_every == 1) return;
  if (has_cast) {
    patch.kept.shapes.clear();
    for (const ShapeInReach<S, Backend>& shape : shapes) {
      patch.kept.shapes.push_back({shape.tag,
                                   shape.generation,
                                   {shape.X_AB.rotation_matrix(), shape.X_AB.translation},
                                   shape.extra_length});
    }
    patch.kept.keep(patch);
  }
  // Also where rays were just cast: all steps of a patch then look alike.
  patch.kept.advance(patch, [&](std::uint32_t tag, PairPose<S>& pose) {
    const auto same = [tag](const auto& shape) { return shape.tag == tag; };
    const ShapeInReach<S, Backend>& shape = *std::find_if(shapes.begin(), shapes.end(), same);
    pose = {shape.X_AB.rotation_matrix(), shape.X_AB.translation};
    return shape.approach;
  });
}

template <Scalar S, typename Backend>
std::uint64_t find_hits(SensorPatch<S>& patch, std::span<const ShapeInReach<S, Backend>> shapes,
                        bool is_due) {
  const bool casts = wants_rays<S, Backend>(patch, shapes, is_due);
  const std::uint64_t rays = casts ? patch.near_count() * shapes.size() : 0;
  if (rays > 0) {
    patch.reset_near_hits();
    for (const ShapeInReach<S, Backend>& shape : shapes) cast_rays_at<S>(patch, shape, {});
  }
  carry_hits<S, Backend>(patch, shapes, casts);
  return rays;
}

}  // namespace bristle::inline BRISTLE_ABI
