/// @file
/// What is hit or driven does not get past something that it had no contact with.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

using namespace bristle;

namespace {

/// A ball at rest of 5 cm and 0.1 kg, at x = 0. One of 10 kg hits it along x in the first step.
template <Scalar S>
struct HitBall {
  HitBall(S speed, S dt, Integrator integrator)
      : world({.gravity = Vec3<S>::Zero(), .time_step = dt, .integrator = integrator}) {
    ball = world.add_body({.mass = S(0.1), .shape = Sphere<S>{S(0.05)}});
    bat = world.add_body({.mass = S(10),
                          .shape = Sphere<S>{S(0.05)},
                          .position = {S(-0.101), S(0), S(0)},
                          .velocity = {speed, S(0), S(0)}});
  }
  /// A wall across the way, 5 mm thick.
  /// @param gap  [m] From the ball to the wall.
  void add_wall(const Shape<S>& shape, S gap) {
    world.add_body(
        {.motion = Motion::fixed, .shape = shape, .position = {S(0.0525) + gap, S(0), S(0)}});
  }
  [[nodiscard]] S place() const { return world.body(ball).center_pose.translation.x(); }
  [[nodiscard]] S momentum() const {
    return S(0.1) * world.body(ball).twist.linear.x() + S(10) * world.body(bat).twist.linear.x();
  }

  World<S> world;
  BodyId ball;
  BodyId bat;
};

}  // namespace

// Contacts of a ball at rest are sought around it alone. By the velocity that a hit gives it goes
// 0.03 to 0.27 m in a step. It passed the wall in 10 of the first 24 cases, and was up to 3 cm in
// it in the others.
TEST_CASE_TEMPLATE("way limit: a ball that is hit stays before a thin wall", S, float, double) {
  const Vec3<S> half{S(0.0025), S(0.5), S(0.5)};
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    for (const bool is_mesh : {false, true}) {
      for (const S speed : {S(2), S(4), S(8), S(16)}) {
        for (const S gap : {S(0.001), S(0.005), S(0.02)}) {
          for (const S rate : {S(60), S(240)}) {
            CAPTURE(is_mesh);
            CAPTURE(speed);
            CAPTURE(gap);
            CAPTURE(rate);
            HitBall<S> scene(speed, S(1) / rate, integrator);
            if (is_mesh) {
              scene.add_wall(box_mesh<S>(half), gap);
            } else {
              scene.add_wall(Box<S>{half}, gap);
            }
            S farthest = S(0);
            for (int n = 0; n < 20; ++n) {
              scene.world.step();
              farthest = std::max(farthest, scene.place());
            }
            // Half of the wall's inner ball, and nothing into a mesh.
            CHECK(farthest <= gap + (is_mesh ? S(1e-5) : S(0.00125)) + S(1e-5));
            CHECK(scene.place() <= gap + S(1e-4));
          }
        }
      }
    }
  }
}

// Only the way is shorter: the hit itself is what it is without a wall.
TEST_CASE("way limit: velocities stay, and what nothing is in the way of goes all of it") {
  HitBall<double> free(4.0, 1.0 / 60, Integrator::trapezoidal);
  HitBall<double> walled(4.0, 1.0 / 60, Integrator::trapezoidal);
  walled.add_wall(Box<double>{{0.0025, 0.5, 0.5}}, 0.02);
  const double before = free.momentum();
  free.world.step();
  walled.world.step();
  CHECK(free.world.report().delayed_islands == 0);
  CHECK(walled.world.report().delayed_islands == 1);
  CHECK(free.place() > 0.05);
  for (HitBall<double>* scene : {&free, &walled}) {
    CHECK(std::abs(scene->momentum() - before) < 1e-12 * before);
  }
  CHECK(walled.world.body(walled.ball).twist.linear == free.world.body(free.ball).twist.linear);
  // The bat comes no nearer to the ball than it would.
  const auto apart = [](const HitBall<double>& scene) {
    return scene.place() - scene.world.body(scene.bat).center_pose.translation.x();
  };
  CHECK(apart(walled) > 0.1 - 1e-6);
}

// A motor moves what is at rest.
TEST_CASE("way limit: a slide that a motor starts stays before a thin wall") {
  for (const double rate : {60.0, 240.0}) {
    CAPTURE(rate);
    World<double> world({.gravity = Vec3<double>::Zero(), .time_step = 1 / rate});
    const BodyId slide = world.add_body({.mass = 1, .shape = Box<double>{{0.05, 0.05, 0.05}}});
    world.add_joint({.kind = JointKind::prismatic,
                     .body_b = slide,
                     .motor = {.mode = MotorMode::velocity, .target = 6, .max_force = 1e5}});
    world.add_body({.motion = Motion::fixed,
                    .shape = Box<double>{{0.0025, 0.5, 0.5}},
                    .position = {0.0625, 0, 0}});
    for (int n = 0; n < 20; ++n) {
      world.step();
      CHECK(world.body(slide).center_pose.translation.x() < 0.0125);
    }
  }
}

// Bodies at one place are pushed apart over several steps. Pairs that are put off are no walls.
TEST_CASE("way limit: a crowd comes apart") {
  World<double> world({.gravity = Vec3<double>::Zero(), .time_step = 1.0 / 240});
  for (int i = 0; i < 60; ++i) {
    world.add_body({.mass = 1,
                    .shape = Sphere<double>{0.05},
                    .position = {1e-4 * std::sin(1.3 * i), 1e-4 * std::cos(7.1 * i),
                                 1e-4 * std::sin(3.7 * i)}});
  }
  double deepest = 0;
  for (int n = 0; n < 60; ++n) {
    world.step();
    deepest = 0;
    world.for_each_contact([&](const ContactReading<double>& contact) {
      contact.for_each_point([&](const auto& point) { deepest = std::min(deepest, point.gap); });
    });
  }
  CHECK(deepest > -1e-3);
}
