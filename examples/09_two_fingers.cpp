// Two force-driven fingers hold a box without gluing it, in the fewest lines.
//
// While gravity is off the fingers close on the box; then it sags by m g / (mu_S sum F_N) and
// stays. The prismatic joints slide along the x axis of their frames, which point at the box; the
// rays of a grid run along side_u x side_v, out of the finger. Expected output:
// 09_two_fingers.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstdio>
#include <numbers>

int main() {
  using namespace bristle;
  World<double> world({.gravity = {0, 0, 0}, .time_step = 1e-3});
  const double mass = 0.5;
  const double load = 20;  // N, of each finger
  const auto tuning =
      tuned_for<double>({.friction = 0.8, .creep = 1e-3, .load = load, .mass = mass});

  const BodyId box =
      world.add_body({.mass = mass, .shape = Box<double>{.half_extents = {0.03, 0.02, 0.03}}});
  const BodyId palm = world.add_body({.motion = Motion::kinematic});
  PatchId pads[2];
  for (const int side : {0, 1}) {
    const double sign = side == 0 ? -1 : 1;  // Finger 0 stands at -y, finger 1 at +y.
    const Transform<double> start{Quat<double>::Identity(), {0, sign * 0.04, 0}};
    const Transform<double> towards_box{exp_rotation<double>({0, 0, -sign * std::numbers::pi / 2})};
    const BodyId finger =
        world.add_body({.mass = 0.2,
                        .shape = Box<double>{.half_extents = {0.015, 0.01, 0.015}},
                        .position = start.translation});
    world.add_joint({.kind = JointKind::prismatic,
                     .body_a = palm,
                     .body_b = finger,
                     .X_AJ = start * towards_box,
                     .X_BJ = towards_box,
                     .motor = {MotorMode::velocity, 0.1, load}});
    pads[side] = world.add_patch(finger,
                                 sensor_grid<double>({.center = {0, -sign * 0.01, 0},
                                                      .side_u = {0.03, 0, 0},
                                                      .side_v = {0, 0, sign * 0.03},
                                                      .count_u = 6,
                                                      .count_v = 6}),
                                 tuning);
  }

  for (int i = 0; i < 500; ++i) world.step();
  const double before = world.pose(box).translation.z();
  world.set_gravity({0, 0, -9.81});
  for (int i = 0; i < 2000; ++i) world.step();

  const double normal =
      world.reading(pads[0]).total_normal() + world.reading(pads[1]).total_normal();
  const double mu_S = 0.8 / 1e-3;
  std::printf("normal force %.3f N\n", normal);
  std::printf("sag %.3f um, predicted %.3f um\n", 1e6 * (before - world.pose(box).translation.z()),
              1e6 * mass * 9.81 / (mu_S * normal));
}
