/// @file
/// Definitions of `World`: contacts as callers see them. Included by world.hpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/world/world.hpp>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
template <typename Visit>
void World<S, Backend>::for_each_contact_event(Visit&& visit) const {
  detail::for_each_event(state_, visit);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
template <typename Visit>
void World<S, Backend>::for_each_contact(Visit&& visit) const {
  const detail::DynamicArray<detail::CachedManifold<S>>& manifolds = state_.contacts.manifolds();
  for (std::size_t i = 0; i < manifolds.size();) {
    const std::span<const detail::CachedManifold<S>> pair = detail::same_pair(manifolds, i);
    ContactReading<S> reading(pair, state_.contacts.points());
    reading.shape_a = state_.colliders.handle(manifolds[i].shapes.a);
    reading.shape_b = state_.colliders.handle(manifolds[i].shapes.b);
    reading.body_a = state_.colliders.at(manifolds[i].shapes.a).body;
    reading.body_b = state_.colliders.at(manifolds[i].shapes.b).body;
    visit(reading);
    i += pair.size();
  }
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> Wrench<S> World<S, Backend>::contact_impulse(BodyId id)
const {
  (void)body(id);
  Wrench<S> sum;
  for_each_contact([&](const ContactReading<S>& contact) {
    if (contact.body_a == id) sum += contact.impulse_on_a();
    if (contact.body_b == id) sum += contact.impulse_on_b();
  });
  return sum;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S> Wrench<S> World<S, Backend>::contact_impulse(BodyId id,
                                                                               BodyId from)
const {
  (void)body(id);
  (void)body(from);
  Wrench<S> sum;
  for_each_contact([&](const ContactReading<S>& contact) {
    if (contact.body_a == id && contact.body_b == from) sum += contact.impulse_on_a();
    if (contact.body_b == id && contact.body_a == from) sum += contact.impulse_on_b();
  });
  return sum;
}

}  // namespace bristle::inline BRISTLE_ABI
