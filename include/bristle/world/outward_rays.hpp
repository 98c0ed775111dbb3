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

/// [m] Length of each ray, from its end, outside of the shapes of its own body. Triggers do not
/// count. 0: the ray ends inside. Each ray is cast from its end to its start, at each shape once.
///
/// @param body      Index of the body.
/// @param origin_B  [m] The point of the body that the patch gives its rays about.
template <Scalar S>
DynamicArray<S> lengths_outside(const WorldState<S>& state, std::uint32_t body,
                                const SensorPatch<S>& patch, const Vec3<S>& origin_B) {
  const Vec3<S> origin_Cm = origin_B - state.bodies.at(body).center_B;
  const PatchGeometry<S>& rays = *patch.geometry;
  const std::size_t count = rays.size();
  SensorLayout<S> reversed;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3<S> start = origin_Cm + rays.start[i];
    const Vec3<S> direction = rays.direction[i];
    reversed.add(start + rays.length[i] * direction, -direction, rays.length[i]);
  }
  // A solid is closed: a ray that starts inside is hit at the distance 0.
  RayHits<S> hits;
  hits.reset(count);
  for (const std::uint32_t tag : state.colliders.live_slots()) {
    const Collider<S>& c = state.colliders.at(tag);
    if (c.body.index == body && !c.is_trigger) {
      c.shape.cast_rays(c.X_CmS, reversed.rays(), tag, hits);
    }
  }
  DynamicArray<S> outside(count);
  for (std::size_t i = 0; i < count; ++i) {
    outside[i] = std::clamp(hits.distance[i], S(0), S(rays.length[i]));
  }
  return outside;
}

/// Checks that the end of each ray lies outside of the shapes of its own body. The start of a ray
/// does not matter: it may lie deep in the body, on its surface, or behind a thin plate. A ray that
/// ends outside has left the body there, and senses contacts from there.
///
/// @throws InvalidArgument naming the first sensor whose ray ends inside.
template <Scalar S>
void require_outward_rays(const WorldState<S>& state, std::uint32_t body,
                          const SensorPatch<S>& patch, const Vec3<S>& origin_B) {
  if (patch.def.may_point_inwards) return;
  const PatchGeometry<S>& rays = *patch.geometry;
  const DynamicArray<S> outside = lengths_outside(state, body, patch, origin_B);
  for (std::size_t i = 0; i < outside.size(); ++i) {
    if (outside[i] > S(0)) continue;
    const Vec3<S> end = origin_B + rays.start[i] + rays.length[i] * rays.direction[i];
    std::string text = "(";
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      text.append(axis > 0 ? ", " : "").append(to_text(end[axis]));
    }
    raise(InvalidArgument("PatchDef::sensors[" + std::to_string(i) + "]: end of the ray",
                          text + ")",
                          "must lie outside of the shapes of its own body, unless "
                          "PatchDef::may_point_inwards"));
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
