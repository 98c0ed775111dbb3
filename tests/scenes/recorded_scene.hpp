/// @file
/// A small scene with a recorder.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/recorder.hpp>
#include <bristle/sensors/tuning.hpp>

namespace bristle::test {

/// A plate whose sensors come down on the ground and are pushed aside, and a ball.
template <typename S>
struct RecordedScene {
  World<S> world;
  BodyDef<S> ground_def, plate_def, ball_def;
  BodyId ground, plate, ball;
  PatchId patch;
  Recorder<S> recorder;

  explicit RecordedScene(double rate = 100) : recorder(rate) {
    world.set_time_step(S(1e-3));
    ground_def.motion = Motion::fixed;
    ground_def.shape = HalfSpace<S>{};
    ground = world.add_body(ground_def);
    plate_def.shape = Box<S>{{S(0.1), S(0.1), S(0.01)}};
    plate_def.mass = S(1);
    plate_def.center_of_mass = Vec3<S>(S(0.01), S(0.005), S(0));
    plate_def.position = {S(0), S(0), S(0.018)};
    plate = world.add_body(plate_def);
    ball_def.shape = Sphere<S>{S(0.05)};
    ball_def.position = {S(0.5), S(0), S(1)};
    ball = world.add_body(ball_def);
    PatchDef<S> pad;
    for (const int i : {-1, 1}) {
      for (const int j : {-1, 1}) {
        const S x = S(0.08) * S(i), y = S(0.08) * S(j);
        pad.sensors.add({x, y, S(0)}, {x, y, S(-0.02)});
      }
    }
    GripSpec<S> spec;
    spec.load = S(9.81);
    spec.mass = S(1);
    pad.parameters = tuned_for<S>(spec).parameters(pad.sensors);
    patch = world.add_patch(plate, pad);
  }
  void record_all() {
    recorder.add_body(ground, ground_def, "ground");
    recorder.add_body(plate, plate_def, "a \"plate\"\t");
    recorder.add_body(ball, ball_def, "ball");
    recorder.add_patch(world, patch, "pad");
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      world.apply_force(plate, {S(2), S(1), S(0)}, world.pose(plate).translation);
      world.step();
      recorder.observe(world);
    }
  }
};

}  // namespace bristle::test
