/// @file
/// A bit of everything in one world: plates on sensors and on contact, a grasp, a stack, spheres.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

#include <algorithm>
#include <vector>

namespace bristle::scenes {

/// The built scene.
template <Scalar S, typename Backend = AnalyticBackend>
struct Medley {
  World<S, Backend> world;
  std::vector<BodyId> bodies{};
  std::vector<PatchId> patches{};
  std::vector<JointId> joints{};
};

/// Builds the scene.
/// @param is_reversed  Whether the groups are added in the opposite order; `bodies` keeps its
/// order.
template <Scalar S, typename Backend = AnalyticBackend>
[[nodiscard]] Medley<S, Backend> make_medley(const WorldDef<S>& def = {},
                                             bool is_reversed = false) {
  Medley<S, Backend> m{World<S, Backend>(def)};
  World<S, Backend>& world = m.world;
  const auto add_plate = [&](S x, Integration integration, S friction) {
    BodyDef<S> plate;
    plate.mass = S(0.5);
    plate.shape = Box<S>{{S(0.1), S(0.1), S(0.02)}};
    plate.position = {x, S(0), S(0.025)};
    plate.velocity = {S(0.3), S(0.1), S(0)};
    plate.angular_velocity = {S(0), S(0.4), S(1)};
    const BodyId id = world.add_body(plate);
    PatchDef<S> patch;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        patch.sensors.add(Vec3<S>(S(0.05) * S(i) - S(0.075), S(0.05) * S(j) - S(0.075), S(-0.015)),
                          Vec3<S>(S(0), S(0), S(-1)), S(0.01));
      }
    }
    patch.parameters = {S(1), S(0.05), friction, S(0.5), S(1e-3)};
    patch.integration = integration;
    m.bodies.push_back(id);
    m.patches.push_back(world.add_patch(id, patch));
  };
  const auto add_stack = [&](S x) {
    for (int k = 0; k < 3; ++k) {
      BodyDef<S> cube;
      cube.mass = S(1);
      cube.shape = Box<S>{{S(0.1), S(0.1), S(0.1)}};
      cube.position = {x + S(0.01) * S(k), S(2), S(0.1) + S(0.2) * S(k) + S(0.001) * S(k + 1)};
      cube.velocity = {S(0), S(0.2), S(0)};
      m.bodies.push_back(world.add_body(cube));
    }
  };
  const auto add_arm = [&] {
    const BodyId frame = world.add_body({.motion = Motion::fixed, .position = {S(0), S(-2), S(1)}});
    BodyDef<S> arm;
    arm.mass = S(1);
    arm.shape = Box<S>{{S(0.1), S(0.02), S(0.02)}};
    arm.position = {S(0), S(-2), S(1)};
    const BodyId slider = world.add_body(arm);
    arm.position = {S(0), S(-2), S(0.8)};
    const BodyId hand = world.add_body(arm);
    JointDef<S> slide;
    slide.kind = JointKind::prismatic;
    slide.body_a = frame;
    slide.body_b = slider;
    slide.motor = {MotorMode::velocity, S(0.1), S(5), S(1)};
    slide.upper_limit = S(0.05);
    m.joints.push_back(world.add_joint(slide));
    JointDef<S> weld;
    weld.body_a = slider;
    weld.body_b = hand;
    weld.X_AJ.translation = {S(0), S(0), S(-0.2)};
    m.joints.push_back(world.add_joint(weld));
    m.bodies.push_back(slider);
    m.bodies.push_back(hand);
  };
  BodyDef<S> floor;
  floor.motion = Motion::fixed;
  floor.shape = HalfSpace<S>{};
  world.add_body(floor);
  if (!is_reversed) {
    add_plate(S(0), Integration::explicit_, S(2000));
    add_plate(S(1), Integration::implicit, S(8000));
    add_plate(S(2), Integration::automatic, S(5000));
    add_stack(S(0));
    add_arm();
    return m;
  }
  add_arm();
  add_stack(S(0));
  add_plate(S(2), Integration::automatic, S(5000));
  add_plate(S(1), Integration::implicit, S(8000));
  add_plate(S(0), Integration::explicit_, S(2000));
  // The names of the first order: plates, cubes, arm.
  const std::vector<BodyId> b = m.bodies;
  m.bodies = {b[7], b[6], b[5], b[2], b[3], b[4], b[0], b[1]};
  std::reverse(m.patches.begin(), m.patches.end());
  return m;
}

}  // namespace bristle::scenes
