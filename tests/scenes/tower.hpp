/// @file
/// Towers of cubes on a floor, in a world where islands sleep.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace bristle::scenes {

/// [s] After how long at rest these worlds sleep.
inline constexpr double nap = 0.5;

/// A world in which islands sleep.
[[nodiscard]] inline WorldDef<double> sleepy(double dt = 1.0 / 240) {
  WorldDef<double> def;
  def.time_step = dt;
  def.sleep.time = nap;
  return def;
}

[[nodiscard]] inline BodyDef<double> box_def(double mass, const Vec3<double>& half,
                                             const Vec3<double>& position) {
  BodyDef<double> def;
  def.mass = mass;
  def.shape = Box<double>{half};
  def.position = position;
  return def;
}

inline BodyId add_floor(World<double>& world, Motion motion = Motion::fixed) {
  BodyDef<double> floor;
  floor.motion = motion;
  floor.shape = HalfSpace<double>{};
  return world.add_body(floor);
}

/// A tower of cubes of 0.2 m, exactly on top of each other.
inline std::vector<BodyId> add_tower(World<double>& world, int count, double x = 0) {
  std::vector<BodyId> cubes;
  for (int k = 0; k < count; ++k) {
    cubes.push_back(world.add_body(box_def(1, {0.1, 0.1, 0.1}, {x, 0, 0.1 + 0.2 * k})));
  }
  return cubes;
}

inline void run(World<double>& world, double seconds) {
  const int steps = static_cast<int>(std::lround(seconds / world.time_step()));
  for (int i = 0; i < steps; ++i) world.step();
}

/// [m/s] Fastest of some bodies, centre or corner of a cube.
[[nodiscard]] inline double fastest(const World<double>& world, const std::vector<BodyId>& bodies) {
  double speed = 0;
  for (const BodyId id : bodies) {
    const Twist<double>& t = world.body(id).twist;
    speed = std::max(speed, t.linear.norm() + 0.17 * t.angular.norm());
  }
  return speed;
}

}  // namespace bristle::scenes
