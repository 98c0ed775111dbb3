/// @file
/// How far the rays of a patch leave its own body, and a refusal of those that do not.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/sensors/patch.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <cstdint>
#include <string>

namespace bristle::inline BRISTLE_ABI::detail {

/// [m] Distance at which each ray meets a shape of a body: 0 for a ray that starts inside, infinity
/// for one that meets none. Triggers do not count.
///
/// @param body      Index of the body.
/// @param origin_B  [m] The point of the body that the rays are given about, in its axes.
template <Scalar S>
DynamicArray<S> distances_to_body(const WorldState<S>& state, std::uint32_t body,
                                  const RayBatch<S>& rays, const Vec3<S>& origin_B) {
  const Vec3<S> origin_Cm = origin_B - state.bodies.at(body).center_B;
  // A solid is closed: a ray that starts inside is hit at the distance 0.
  RayHits<S> hits;
  hits.reset(rays.size());
  for (const std::uint32_t tag : state.colliders.live_slots()) {
    const Collider<S>& c = state.colliders.at(tag);
    if (c.body.index != body || c.is_trigger) continue;
    Transform<S> X_RS = c.X_CmS;
    X_RS.translation -= origin_Cm;
    c.shape.cast_rays(X_RS, rays, tag, hits);
  }
  DynamicArray<S> distances(rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) distances[i] = hits.distance[i];
  return distances;
}

/// [m] Length of each ray, from its end, outside of the shapes of its own body. 0: the ray ends
/// inside. Each ray is cast from its end to its start, at each shape once. Parameters are those of
/// `distances_to_body`.
template <Scalar S>
DynamicArray<S> lengths_outside(const WorldState<S>& state, std::uint32_t body,
                                const SensorPatch<S>& patch, const Vec3<S>& origin_B) {
  const PatchGeometry<S>& rays = *patch.geometry;
  SensorLayout<S> reversed;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Vec3<S> start = rays.start[i];
    const Vec3<S> direction = rays.direction[i];
    reversed.add(start + rays.length[i] * direction, -direction, rays.length[i]);
  }
  DynamicArray<S> outside = distances_to_body(state, body, reversed.rays(), origin_B);
  for (std::size_t i = 0; i < outside.size(); ++i) {
    outside[i] = std::clamp(outside[i], S(0), S(rays.length[i]));
  }
  return outside;
}

/// Checks that the end of each ray lies outside of the shapes of its own body, and that its start
/// lies inside or on one of them unless the ray meets none. A ray that comes from outside looks
/// through the body, and would read what is behind it; one that ends inside never leaves it. A ray
/// that starts inside may leave and enter again before its end: it is accepted.
///
/// @throws InvalidArgument naming the first sensor whose ray does, and the number of others.
template <Scalar S>
void require_outward_rays(const WorldState<S>& state, std::uint32_t body,
                          const SensorPatch<S>& patch, const Vec3<S>& origin_B) {
  if (patch.def.may_point_inwards) return;
  const PatchGeometry<S>& rays = *patch.geometry;
  const DynamicArray<S> outside = lengths_outside(state, body, patch, origin_B);
  const DynamicArray<S> before_entry = distances_to_body(state, body, rays.rays(S(0)), origin_B);
  std::size_t wrong = 0;
  std::size_t first = 0;
  for (std::size_t i = outside.size(); i-- > 0;) {
    // A start within round-off of the surface is on it.
    const S least = Tolerance<S>::equal() * (rays.start[i].norm() + rays.length[i]);
    const bool enters = before_entry[i] > least && before_entry[i] < infinity<S>;
    if (outside[i] > S(0) && !enters) continue;
    first = i;
    ++wrong;
  }
  if (wrong == 0) return;
  const bool ends_inside = !(outside[first] > S(0));
  const S at = ends_inside ? S(rays.length[first]) : before_entry[first];
  const Vec3<S> place = origin_B + rays.start[first] + at * rays.direction[first];
  std::string text = "(";
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    text.append(axis > 0 ? ", " : "").append(to_text(place[axis]));
  }
  text += ")";
  if (wrong > 1) text += ", and " + std::to_string(wrong - 1) + " more sensors";
  raise(InvalidArgument(
      "PatchDef::sensors[" + std::to_string(first) +
          (ends_inside ? "]: end of the ray" : "]: entry of the ray"),
      text,
      ends_inside
          ? "must lie outside of the shapes of its own body, unless "
            "PatchDef::may_point_inwards"
          : "must not be there: a ray starts inside its own body or does not meet it (depth "
            "at most the thickness of a plate), unless PatchDef::may_point_inwards"));
}

}  // namespace bristle::inline BRISTLE_ABI::detail
