/// @file
/// Linear and angular damping against v' = -rate v: alone, with gravity, spinning, on
/// joints.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

using namespace bristle;
using namespace bristle::detail;

namespace {

constexpr double damping_rate = 3;

BodyDef<double> damped_block() {
  return {.mass = 2.0,
          .shape = Box<double>{{0.1, 0.2, 0.3}},
          .linear_damping = damping_rate,
          .angular_damping = damping_rate};
}

World<double> weightless(double dt) { return World<double>({.gravity = {0, 0, 0}, .time_step = dt}); }

/// [m] Way of a block of 1 m/s within half a second.
double way_after_half_a_second(int steps) {
  World<double> world = weightless(0.5 / steps);
  BodyDef<double> def = damped_block();
  def.velocity = {1, 0, 0};
  const BodyId block = world.add_body(def);
  for (int i = 0; i < steps; ++i) world.step();
  return world.pose(block).translation.x();
}

}  // namespace

TEST_CASE("damping: velocities decay exactly at any step, and positions are of second order") {
  for (const double dt : {0.5, 0.05, 0.001}) {
    World<double> world = weightless(dt);
    BodyDef<double> def = damped_block();
    def.velocity = {1, -2, 0.5};
    const BodyId block = world.add_body(def);
    const int steps = static_cast<int>(std::lround(1 / dt));
    for (int i = 0; i < steps; ++i) world.step();
    const Vec3<double> exact = std::exp(-damping_rate) * def.velocity;
    CHECK((world.body(block).twist.linear - exact).norm() < 1e-12);
  }
  const double exact = (1 - std::exp(-damping_rate * 0.5)) / damping_rate;
  const double coarse = way_after_half_a_second(20) - exact;
  const double fine = way_after_half_a_second(40) - exact;
  // The mean of both velocities, once a step: h^2 v'' / 12 of error, within the next order.
  const double h = 0.5 / 20;
  CHECK(coarse == test::relative(h * h / 12 * damping_rate * (1 - std::exp(-damping_rate * 0.5)))
                      .epsilon(0.01));
  CHECK(coarse / fine == test::relative(4).epsilon(0.01));
}

TEST_CASE("damping: a falling body has its terminal velocity, and reaches it as it should") {
  World<double> world({.time_step = 0.01});
  const BodyId block = world.add_body(damped_block());
  const double terminal = -9.81 / damping_rate;
  for (int i = 1; i <= 300; ++i) {
    world.step();
    const double exact = terminal * (1 - std::exp(-damping_rate * 0.01 * i));
    CHECK(std::abs(world.body(block).twist.linear.z() - exact) < 1e-12 * i);
  }
}

TEST_CASE("damping: angular momentum of a tumbling body decays, along the same axis") {
  World<double> world = weightless(0.002);
  BodyDef<double> def = damped_block();
  def.linear_damping = 0;
  def.velocity = {1, 0, 0};
  def.angular_velocity = {2, 3, -1};
  const BodyId block = world.add_body(def);
  const Vec3<double> start = world.body(block).angular_momentum();
  for (int i = 0; i < 500; ++i) world.step();
  // The axes turn by the mean of two velocities; momentum itself does not know of that.
  CHECK((world.body(block).angular_momentum() - std::exp(-damping_rate) * start).norm() <
        1e-12 * start.norm());
  CHECK(world.body(block).twist.linear.x() == 1);
}

// With equal rates every part of a pendulum loses momentum alike, so
// I theta'' = -rate I theta' - m g l sin(theta).
TEST_CASE("damping: a pendulum on a joint to the world loses amplitude as its equation says") {
  const double l = 0.5;
  World<double> world({.time_step = 0.001});
  BodyDef<double> def = damped_block();
  def.linear_damping = def.angular_damping = 0.4;
  const double angle = 1e-4;
  def.position = {l * std::sin(angle), 0, -l * std::cos(angle)};
  def.orientation = Quat<double>(std::cos(-angle / 2), 0, std::sin(-angle / 2), 0);
  const BodyId bob = world.add_body(def);
  // The joint turns about its x axis: the world's y.
  const Quat<double> to_y(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  world.add_joint({.kind = JointKind::revolute,
                   .body_b = bob,
                   .X_AJ = {.rotation = to_y},
                   .X_BJ = {.rotation = to_y, .translation = {0, 0, l}}});
  const double I = world.body(bob).inertia_B(1, 1) + 2.0 * l * l;
  const double w2 = 2.0 * 9.81 * l / I;
  const double decay = 0.4 / 2;
  const double w = std::sqrt(w2 - decay * decay);
  double worst = 0;
  for (int i = 1; i <= 4000; ++i) {
    world.step();
    const double t = 0.001 * i;
    const double exact =
        angle * std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t));
    worst = std::max(worst, std::abs(world.pose(bob).translation.x() / l - exact));
  }
  CHECK(worst < 1e-6 * angle);
}

TEST_CASE("damping: two bodies on a joint keep the direction of their momentum and lose it alike") {
  World<double> world = weightless(0.01);
  BodyDef<double> def = damped_block();
  def.velocity = {1, 0, 0};
  const BodyId a = world.add_body(def);
  def.position = {0, 1, 0};
  def.velocity = {0, 0, 2};
  const BodyId b = world.add_body(def);
  world.add_joint({.kind = JointKind::ball,
                   .body_a = a,
                   .body_b = b,
                   .X_AJ = {.translation = {0, 0.5, 0}},
                   .X_BJ = {.translation = {0, -0.5, 0}}});
  const auto momentum = [&] {
    return Vec3<double>(2.0 * (world.body(a).twist.linear + world.body(b).twist.linear));
  };
  const Vec3<double> start = momentum();
  for (int i = 0; i < 100; ++i) world.step();
  CHECK((momentum() - std::exp(-damping_rate) * start).norm() < 1e-7 * start.norm());
}

// In a slot that takes the ball some steps only damping changes the speed, however often the ball
// bounces.
TEST_CASE("damping: bounces neither add speed nor escape it") {
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    for (const double slowed : {0.5, 3.0, 20.0}) {
      World<double> world({.gravity = {0, 0, 0}, .time_step = 1.0 / 240, .integrator = integrator});
      for (const double side : {-1.0, 1.0}) {
        world.add_body({.motion = Motion::fixed,
                        .shape = Box<double>{{0.5, 1, 1}},
                        .material = {.restitution = 1},
                        .position = {side * 0.65, 0, 0}});
      }
      const BodyId ball = world.add_body({.mass = 1.0,
                                          .shape = Sphere<double>{0.1},
                                          .material = {.friction = 0, .restitution = 1},
                                          .velocity = {3, 0, 0},
                                          .linear_damping = slowed});
      for (int i = 1; i <= 120; ++i) {
        world.step();
        const double exact = 3 * std::exp(-slowed * i / 240);
        if (exact < 0.02) break;  // Below the speed at which things bounce.
        CHECK(std::abs(world.body(ball).twist.linear.x()) == test::relative(exact).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("damping: a bouncing ball never gains energy") {
  World<double> world({.time_step = 1.0 / 60});
  world.add_body(
      {.motion = Motion::fixed, .shape = HalfSpace<double>{}, .material = {.restitution = 1}});
  const BodyId ball = world.add_body(
      {.mass = 1.0, .shape = Sphere<double>{0.1}, .position = {0, 0, 1.1}, .linear_damping = 2});
  double energy = 9.81;
  for (int i = 0; i < 600; ++i) {
    world.step();
    const double now = 0.5 * world.body(ball).twist.linear.squaredNorm() +
                       9.81 * (world.pose(ball).translation.z() - 0.1);
    CHECK(now <= energy * (1 + 1e-9) + 1e-12);
    energy = now;
  }
}

// A hundred crates in one island that is swept: v' = -rate v for all of them, on ice.
TEST_CASE("damping: a heap that is swept decays as one body does, and falls as one") {
  World<double> world({.time_step = 1.0 / 60});
  world.add_body(
      {.motion = Motion::fixed, .shape = HalfSpace<double>{}, .material = {.friction = 0}});
  std::vector<BodyId> boxes;
  for (int k = 0; k < 15; ++k) {
    for (int i = 0; i < 15 - k; ++i) {
      BodyDef<double> def{.mass = 1.0, .shape = Box<double>{{0.1, 0.1, 0.1}}};
      def.position = {0.201 * i + 0.1005 * k, 0, 0.1 + 0.2 * k};
      def.velocity = {0, 2, 0};
      def.linear_damping = damping_rate;
      boxes.push_back(world.add_body(def));
    }
  }
  for (int i = 0; i < 30; ++i) world.step();
  CHECK(world.report().direct_islands == 0);
  // They rub on each other a little; the floor takes nothing of their momentum.
  double sum = 0;
  for (const BodyId id : boxes) sum += world.body(id).twist.linear.y();
  CHECK(sum == test::relative(240 * std::exp(-damping_rate / 2)).epsilon(1e-6));
}

TEST_CASE("damping: bad rates are refused by name, and bodies that forces do not move have none") {
  World<double> world;
  BodyDef<double> def = damped_block();
  def.linear_damping = -1;
  CHECK_THROWS_WITH_AS(world.add_body(def), doctest::Contains("BodyDef::linear_damping"),
                       InvalidArgument);
  def.linear_damping = 0;
  def.angular_damping = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS(world.add_body(def), doctest::Contains("BodyDef::angular_damping"),
                       InvalidArgument);
  CHECK(world.body_count() == 0);
  def = damped_block();
  def.motion = Motion::kinematic;
  def.velocity = {1, 0, 0};
  const BodyId carrier = world.add_body(def);
  for (int i = 0; i < 10; ++i) world.step();
  CHECK(world.body(carrier).twist.linear.x() == 1);
}
