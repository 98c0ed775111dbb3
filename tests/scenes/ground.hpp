/// @file
/// The floor of most scenes: a fixed half-space below z = 0.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

namespace bristle::scenes {

/// Adds the floor.
template <Scalar S, typename Backend>
BodyId add_ground(World<S, Backend>& world, const Material<S>& material = {}) {
  BodyDef<S> def;
  def.motion = Motion::fixed;
  def.shape = HalfSpace<S>{};
  def.material = material;
  return world.add_body(def);
}

}  // namespace bristle::scenes
