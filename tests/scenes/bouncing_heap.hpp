/// @file
/// Bodies that fall between four walls and bounce off them, the floor and each other.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/momentum.hpp"
#include "support/random.hpp"

#include <bristle/math/rotation.hpp>
#include <bristle/world/world.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace bristle::scenes {

/// Definition of a bouncing heap.
struct BouncingHeapDef {
  /// [-] Number of bodies, and whether every second one is a ball; all others are boxes.
  int count = 48;
  bool has_balls = false;
  /// [1] Of bodies, and so of all pairs; friction of floor and walls, too.
  double restitution = 1;
  double friction = 0.5;
  /// [s] Of the world.
  double time_step = 1.0 / 240;
  /// [-] Of the world.
  SolverDef<double> solver{};
  /// [-] Makes masses and velocities.
  std::uint64_t seed = 1;
};

/// The built scene.
struct BouncingHeap {
  World<double> world;
  std::vector<BodyId> bodies{};

  [[nodiscard]] double energy() const {
    return test::energy_of(world, std::span<const BodyId>(bodies));
  }
};

/// Builds the scene: boxes and balls of 16 and 20 cm and 0.2 to 2 kg, in layers of 4 x 4.
[[nodiscard]] inline BouncingHeap make_bouncing_heap(const BouncingHeapDef& def) {
  WorldDef<double> world_def;
  world_def.time_step = def.time_step;
  world_def.solver = def.solver;
  BouncingHeap heap{World<double>(world_def)};
  BodyDef<double> wall;
  wall.motion = Motion::fixed;
  wall.shape = HalfSpace<double>{};
  wall.material.friction = def.friction;
  heap.world.add_body(wall);
  for (const Vec3<double>& normal : {Vec3<double>(1, 0, 0), Vec3<double>(-1, 0, 0),
                                     Vec3<double>(0, 1, 0), Vec3<double>(0, -1, 0)}) {
    wall.orientation = exp_rotation<double>(shortest_turn<double>(Vec3<double>::UnitZ(), normal));
    wall.position = -0.45 * normal;
    heap.world.add_body(wall);
  }
  test::Random random(def.seed);
  for (int i = 0; i < def.count; ++i) {
    BodyDef<double> body;
    body.mass = random.uniform(0.2, 2.0);
    body.shape = Box<double>{{0.08, 0.08, 0.08}};
    if (def.has_balls && i % 2 == 1) body.shape = Sphere<double>{0.1};
    body.material = {def.friction, def.restitution};
    body.position = {(i % 4) * 0.22 - 0.33, (i / 4 % 4) * 0.22 - 0.33, 0.3 + 0.25 * (i / 16)};
    body.velocity = random.in_cube(1.0);
    heap.bodies.push_back(heap.world.add_body(body));
  }
  return heap;
}

}  // namespace bristle::scenes
