/// @file
/// Momentum and energy of a whole world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/spatial.hpp>

#include <span>
#include <type_traits>

namespace bristle::test {

/// [N s, N m s] Momentum and angular momentum about the world's origin of some bodies.
template <typename World, typename Id>
auto momentum_of(const World& world, std::span<const Id> bodies) {
  using S = std::decay_t<decltype(world.time_step())>;
  Wrench<S> sum;
  for (const Id id : bodies) {
    const auto& body = world.body(id);
    const Vec3<S> p = body.mass * body.twist.linear;
    sum += Wrench<S>{p, body.center_pose.translation.cross(p) + body.angular_momentum()};
  }
  return sum;
}

/// [J] Kinetic energy and energy in the world's gravity, from the world's origin.
template <typename World, typename Id>
auto energy_of(const World& world, std::span<const Id> bodies) {
  using S = std::decay_t<decltype(world.time_step())>;
  S sum = S(0);
  for (const Id id : bodies) {
    const auto& body = world.body(id);
    sum += body.kinetic_energy() -
           body.mass * body.gravity_scale * world.def().gravity.dot(body.center_pose.translation);
  }
  return sum;
}

}  // namespace bristle::test
