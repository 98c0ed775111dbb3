/// @file
/// Events that wake islands between steps.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world_state.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// Wakes the island of a body. Does nothing if the body is awake or forces do not move it.
template <Scalar S>
void wake_island(WorldState<S>& state, std::uint32_t slot) {
  if (!state.bodies.at(slot).is_asleep()) return;
  const std::uint32_t island = state.bodies.at(slot).sleep.island;
  for (const std::uint32_t i : state.bodies.live_slots()) {
    if (state.bodies.at(i).sleep.island != island) continue;
    state.bodies.at(i).sleep = {};
    --state.sleeping_bodies;
  }
  state.is_idle = false;
}

/// Wakes all islands.
template <Scalar S>
void wake_all(WorldState<S>& state) {
  for (const std::uint32_t i : state.bodies.live_slots()) state.bodies.at(i).sleep = {};
  state.sleeping_bodies = 0;
  state.is_idle = false;
}

/// Wakes all bodies that touch a body, are joined to it, or are sensed by it or sense it.
template <Scalar S>
void wake_neighbours(WorldState<S>& state, std::uint32_t slot) {
  if (state.sleeping_bodies == 0) return;
  const auto wake_other = [&](std::uint32_t a, std::uint32_t b) {
    if (a == slot) wake_island(state, b);
    if (b == slot) wake_island(state, a);
  };
  for (const CachedManifold<S>& m : state.contacts.manifolds()) {
    if (m.is_trigger) continue;
    wake_other(state.colliders.at(m.shapes.a).body.index,
               state.colliders.at(m.shapes.b).body.index);
  }
  for (const std::uint32_t i : state.joints.live_slots()) {
    wake_other(state.joints.at(i).def.body_a.index, state.joints.at(i).def.body_b.index);
  }
  for (const std::uint32_t i : state.patches.live_slots()) {
    const SensorPatch<S>& patch = state.patches.at(i);
    for (const SensedBody<S>& other : patch.sensed) wake_other(patch.body.index, other.body);
  }
}

/// Marks a body as changed by the caller. Wakes its island, or else its neighbours. The next step
/// wakes bodies that it reaches.
template <Scalar S>
void mark_dirty(WorldState<S>& state, BodyId id) {
  Body<S>& body = state.bodies.at(id.index);
  wake_island(state, id.index);
  if (!body.is_dynamic()) wake_neighbours(state, id.index);
  body.sleep.rest_time = S(0);
  body.sleep.is_dirty = state.is_any_dirty = true;
  state.is_idle = false;
}

/// The same for both bodies of a joint.
template <Scalar S>
void mark_bodies_dirty(WorldState<S>& state, const JointDef<S>& def) {
  mark_dirty(state, def.body_a);
  mark_dirty(state, def.body_b);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
