/// @file
/// Definitions of `World`: lists of what is in it. Included by world.hpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// Calls visit(handle) for each live slot.
template <typename Slots, typename Visit>
void for_each_handle(const Slots& slots, Visit&& visit) {
  for (const std::uint32_t i : slots.live_slots()) visit(slots.handle(i));
}

}  // namespace detail

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
template <typename Visit>
void World<S, Backend>::for_each_body(Visit&& visit) const {
  detail::for_each_handle(state_.bodies, visit);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
template <typename Visit>
void World<S, Backend>::for_each_joint(Visit&& visit) const {
  detail::for_each_handle(state_.joints, visit);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
template <typename Visit>
void World<S, Backend>::for_each_patch(Visit&& visit) const {
  detail::for_each_handle(state_.patches, visit);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
template <typename Visit>
void World<S, Backend>::for_each_shape(
    BodyId id, Visit&& visit) const requires detail::TellsShapes<Backend, S> {
  const Vec3<S> center_B = body(id).center_B;
  state_.shapes_of_bodies.for_each(id.index, [&](std::uint32_t i) {
    const detail::Collider<S>& c = state_.colliders.at(i);
    ShapeDef<S> def;
    def.shape = Backend::shape(c.shape.template as<Prepared>());
    def.X_BS = {c.X_CmS.rotation, center_B + c.X_CmS.translation};
    def.material = c.material;
    def.is_trigger = c.is_trigger;
    def.user_data = c.user_data;
    visit(state_.colliders.handle(i), def);
  });
}

}  // namespace bristle::inline BRISTLE_ABI
