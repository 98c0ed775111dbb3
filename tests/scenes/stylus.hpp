/// @file
/// A stylus with a pad of sensors at its tip, in a haptic loop, above whatever lies at z <= 0.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>

namespace bristle::scenes {

/// The stylus. Defaults: sixteen sensors of 0.5 N over 10 mm, 800 N/m together.
template <Scalar S>
struct StylusDef {
  /// [s] Step of the world.
  S time_step = S(1) / S(60);
  /// [-] Ticks a step, and how often rays are cast.
  std::uint32_t substeps = 16;
  std::uint32_t cast_every = 1;
  /// [m/s^2] Gravity, downwards.
  S gravity = S(9.81);
  /// [-] How positions follow from velocities.
  Integrator integrator = Integrator::trapezoidal;
  /// [N], [N s] K_N and K_D of each sensor.
  S normal_stiffness = S(0.5);
  S normal_damping = S(0.005);
  /// [1/m] mu_S.
  S static_friction = S(1000);
  /// [N s/m] mu_V.
  S sliding_friction = S(0.1);
  ParallelFor parallel_for = serial_for;
};

/// The built scene: an empty world with a tool.
template <Scalar S>
struct StylusScene {
  /// [m] Length of the rays; all of it is below the tip's frame.
  static constexpr S ray = S(0.01);

  StylusDef<S> def;
  World<S> world;
  HapticLoop<S> loop;
  BodyId body{};
  ToolId tool{};
  ToolPatchId pad{};

  explicit StylusScene(const StylusDef<S>& stylus)
      : def(stylus), world(world_def(stylus)), loop({.substeps = stylus.substeps}) {
    body = world.add_body({.motion = Motion::kinematic, .position = {0, 0, S(1)}});
    tool = loop.add_tool(body);
    pad = loop.add_patch(tool, pad_def(stylus));
  }

  [[nodiscard]] static WorldDef<S> world_def(const StylusDef<S>& stylus) {
    WorldDef<S> result;
    result.time_step = stylus.time_step;
    result.gravity = {0, 0, -stylus.gravity};
    result.integrator = stylus.integrator;
    result.parallel_for = stylus.parallel_for;
    return result;
  }
  [[nodiscard]] static PatchDef<S> pad_def(const StylusDef<S>& stylus) {
    PatchDef<S> result;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        result.sensors.add(Vec3<S>(S(0.004) * (S(i) - S(1.5)), S(0.004) * (S(j) - S(1.5)), S(0)),
                           Vec3<S>(0, 0, -1), ray);
      }
    }
    result.parameters = {stylus.normal_stiffness, stylus.normal_damping, stylus.static_friction,
                         stylus.sliding_friction, S(1e-3)};
    result.cast_every = stylus.cast_every;
    return result;
  }
  /// [N/m] Of all sensors together.
  [[nodiscard]] S stiffness() const { return S(16) * def.normal_stiffness / ray; }
  [[nodiscard]] S substep_length() const { return def.time_step / S(def.substeps); }

  /// One substep with the tip's frame at `p`.
  const Wrench<S>& tick_at(const Vec3<S>& p) {
    loop.move(tool, {Quat<S>::Identity(), p});
    loop.substep();
    return loop.wrench(tool);
  }
};

/// A table whose top is z = 0, and a box of 40 mm on it or `gap` [m] above.
template <typename S>
void add_table(World<S>& world) {
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
}
template <typename S>
BodyId add_box(World<S>& world, S mass, S gap = 0) {
  return world.add_body({.mass = mass,
                         .shape = Box<S>{{S(0.02), S(0.02), S(0.02)}},
                         .position = {0, 0, S(0.02) + gap}});
}

/// [m] A hand that comes down on such a box, presses and wiggles.
template <typename S>
Vec3<S> wiggle(S time) {
  const S down = std::min(time / S(0.2), S(1));
  return {S(3e-4) * std::sin(S(40) * time), S(2e-4) * std::sin(S(31) * time),
          S(0.05) - S(0.004) * down + S(0.001) * std::sin(S(25) * time)};
}

}  // namespace bristle::scenes
