/// @file
/// Two fingers with sensor pads hold a box between them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

#include <cmath>
#include <numbers>

namespace bristle::scenes {

/// The grasp scene. Defaults: 0.5 kg between two pads of 25 sensors at 10 N each.
template <Scalar S>
struct GraspDef {
  /// [s] Step.
  S time_step = S(1e-3);
  /// [-] How the pads integrate.
  Integration integration = Integration::implicit;
  /// [kg] Mass of the part, a cube of 60 mm.
  S part_mass = S(0.5);
  /// [kg] Mass of each finger. 0: fingers that stand still (kinematic), their pads pressed to give
  /// `grip`. Else fingers on prismatic joints, driven with the force `grip`.
  S finger_mass = S(0);
  /// [N] Normal force of each pad.
  S grip = S(10);
  /// [1] Depth of the sensors under the grip.
  S press = S(0.35);
  /// [1/m] mu_S, [N s/m] mu_V, [m] sigma_a, [N s] K_D.
  S static_friction = S(1000);
  S sliding_friction = S(2);
  S breakaway_distance = S(1e-3);
  S normal_damping = S(0.1);
  /// [-] Readings of the law.
  LawOptions options{};
  /// [m/s^2] Gravity, downwards.
  S gravity = S(9.81);
  /// [-] Settings of the solver.
  SolverDef<S> solver{};
  /// [-] Settings of its sleep.
  SleepDef<S> sleep{};
};

/// The built scene. Fingers close along x; left is at negative x.
template <Scalar S, typename Backend = AnalyticBackend>
struct GraspScene {
  GraspDef<S> def;
  World<S, Backend> world;
  BodyId part{};
  BodyId fingers[2]{};
  PatchId pads[2]{};
  JointId drives[2]{};

  /// [N] Sum of the normal forces of both pads.
  [[nodiscard]] S total_normal() const {
    return world.reading(pads[0]).total_normal() + world.reading(pads[1]).total_normal();
  }
  /// [m] How far the part hangs below where it was grasped.
  [[nodiscard]] S sag() const { return -world.pose(part).translation.z(); }
  void run(S seconds) {
    const long steps = std::lround(static_cast<double>(seconds / def.time_step));
    for (long i = 0; i < steps; ++i) world.step();
  }
};

/// Builds the scene, pads already pressed. Part and fingers touch by sensors only.
template <Scalar S, typename Backend = AnalyticBackend>
[[nodiscard]] GraspScene<S, Backend> make_grasp(const GraspDef<S>& def) {
  constexpr int per_side = 5;
  const S half_part = S(0.03);
  const S half_finger = S(0.01);
  const S ray = S(0.01);

  WorldDef<S> world_def;
  world_def.time_step = def.time_step;
  world_def.gravity = {S(0), S(0), -def.gravity};
  world_def.solver = def.solver;
  world_def.sleep = def.sleep;
  GraspScene<S, Backend> scene{def, World<S, Backend>(world_def), {}, {}, {}, {}};

  BodyDef<S> part;
  part.mass = def.part_mass;
  part.shape = Box<S>{{half_part, half_part, half_part}};
  part.filter = {1, 2, 0};
  scene.part = scene.world.add_body(part);
  const BodyId frame = scene.world.add_body({.motion = Motion::fixed});

  for (int k = 0; k < 2; ++k) {
    const S side = k == 0 ? S(-1) : S(1);
    BodyDef<S> finger;
    finger.shape = Box<S>{{half_finger, half_part, half_part}};
    finger.filter = {4, 0, 0};
    // Rays start 5 mm under the finger's face and meet the part at 1 - press of their length.
    finger.position = {side * (half_part + half_finger + ray * (S(0.5) - def.press)), S(0), S(0)};
    if (def.finger_mass > S(0)) {
      finger.mass = def.finger_mass;
    } else {
      finger.motion = Motion::kinematic;
    }
    scene.fingers[k] = scene.world.add_body(finger);

    PatchDef<S> pad;
    for (int i = 0; i < per_side; ++i) {
      for (int j = 0; j < per_side; ++j) {
        pad.sensors.add(
            Vec3<S>(-side * (half_finger - ray / S(2)), S(0.01) * S(i - 2), S(0.01) * S(j - 2)),
            Vec3<S>(-side, S(0), S(0)), ray);
      }
    }
    pad.parameters = {def.grip / (S(per_side * per_side) * def.press), def.normal_damping,
                      def.static_friction, def.sliding_friction, def.breakaway_distance};
    pad.options = def.options;
    pad.integration = def.integration;
    pad.sense_mask = 1;
    scene.pads[k] = scene.world.add_patch(scene.fingers[k], pad);

    if (def.finger_mass > S(0)) {
      JointDef<S> slide;
      slide.kind = JointKind::prismatic;
      slide.body_a = frame;
      slide.body_b = scene.fingers[k];
      // The joint's x axis points inwards.
      const S turn = k == 0 ? S(0) : S(std::numbers::pi);
      slide.X_AJ.rotation = slide.X_BJ.rotation = exp_rotation<S>(turn * Vec3<S>::UnitZ());
      slide.motor = {MotorMode::velocity, S(10), def.grip, infinity<S>};
      scene.drives[k] = scene.world.add_joint(slide);
    }
  }
  return scene;
}

}  // namespace bristle::scenes
