/// @file
/// Cubes on top of each other, standing on sensors or on hard contact.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

#include <cmath>
#include <vector>

namespace bristle::scenes {

/// Support of the cubes of a stack.
enum class StackBy { contact, sensors };

/// The stack scene. Defaults: five equal cubes of 0.2 m on hard contact.
template <Scalar S>
struct StackDef {
  /// [kg] Masses from the bottom up.
  std::vector<S> masses{S(1), S(1), S(1), S(1), S(1)};
  /// [-] Support of the cubes.
  StackBy by = StackBy::contact;
  /// [s] Step.
  S time_step = S(1) / S(60);
  /// [-] How the sensors integrate.
  Integration integration = Integration::implicit;
  /// [1] Depth of the sensors at rest.
  S press = S(0.3);
  /// [m] Gap between cubes at the start.
  S gap = S(0.002);
  /// [-] Settings of the solver.
  SolverDef<S> solver{};
};

/// The built scene.
template <Scalar S, typename Backend = AnalyticBackend>
struct StackScene {
  StackDef<S> def;
  World<S, Backend> world;
  std::vector<BodyId> cubes{};
  std::vector<PatchId> patches{};
  /// [m] Height of each cube's centre at rest.
  std::vector<S> rest_heights{};

  void run(S seconds) {
    const long steps = std::lround(static_cast<double>(seconds / def.time_step));
    for (long i = 0; i < steps; ++i) world.step();
  }
};

/// Builds the scene. On sensors, each cube has 16 below it, stiff enough for what they carry.
template <Scalar S, typename Backend = AnalyticBackend>
[[nodiscard]] StackScene<S, Backend> make_stack(const StackDef<S>& def) {
  using std::sqrt;
  constexpr int per_side = 4;
  const S half = S(0.1);
  const S ray = S(0.01);
  const S gravity = S(9.81);
  WorldDef<S> world_def;
  world_def.time_step = def.time_step;
  world_def.gravity = {S(0), S(0), -gravity};
  world_def.solver = def.solver;
  StackScene<S, Backend> scene{def, World<S, Backend>(world_def)};
  const bool touches = def.by == StackBy::contact;
  const std::uint32_t mask = touches ? 0xffffffffu : 0u;

  BodyDef<S> floor;
  floor.motion = Motion::fixed;
  floor.shape = HalfSpace<S>{};
  floor.filter.mask = mask;
  scene.world.add_body(floor);

  S carried = S(0);
  for (const S m : def.masses) carried += m;
  S top = S(0);
  for (std::size_t k = 0; k < def.masses.size(); ++k) {
    // Sensors hold the cube off by what they are not pressed in.
    const S off = touches ? S(0) : ray * (S(0.5) - def.press);
    scene.rest_heights.push_back(top + off + half);
    top = scene.rest_heights.back() + half;
    BodyDef<S> cube;
    cube.mass = def.masses[k];
    cube.shape = Box<S>{{half, half, half}};
    cube.filter.mask = mask;
    cube.position = {S(0), S(0), scene.rest_heights.back() + S(k + 1) * def.gap};
    scene.cubes.push_back(scene.world.add_body(cube));
    if (touches) continue;
    PatchDef<S> patch;
    for (int i = 0; i < per_side; ++i) {
      for (int j = 0; j < per_side; ++j) {
        patch.sensors.add(
            Vec3<S>(S(0.05) * S(i) - S(0.075), S(0.05) * S(j) - S(0.075), ray / S(2) - half),
            Vec3<S>(S(0), S(0), S(-1)), ray);
      }
    }
    const S n = S(per_side * per_side);
    const S stiffness = carried * gravity / (n * def.press);
    // Critical damping for the mass carried.
    const S damping = S(2) * sqrt(stiffness * carried * ray / n);
    patch.parameters = {stiffness, damping, S(5000), S(0.1), S(1e-3)};
    patch.integration = def.integration;
    scene.patches.push_back(scene.world.add_patch(scene.cubes.back(), patch));
    carried -= def.masses[k];
  }
  return scene;
}

}  // namespace bristle::scenes
