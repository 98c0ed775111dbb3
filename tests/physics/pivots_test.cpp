// A body that pivots about a contact or a joint keeps its energy and its pivot: a plate that swings
// in a grip, a block that topples over its edge, a pendulum with a motor or a sensor, or with an
// inert one of either. A rolling body does not count as pivoting.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/numbers.hpp"

#include <bristle/sensors/placement.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

using namespace bristle;

namespace {

WorldDef<double> world_def(double dt, Integrator integrator) {
  WorldDef<double> def;
  def.time_step = dt;
  def.integrator = integrator;
  return def;
}

/// A plate that two balls of 10 mm press between them with 30 N, 80 mm above its centre, swings
/// about them from 0.5 rad.
struct SwingingPlate {
  static constexpr double start = 0.5;   // [rad]
  static constexpr double above = 0.08;  // [m]

  World<double> world;
  BodyId plate;
  std::array<BodyId, 2> balls;

  SwingingPlate(double dt, Integrator integrator) : world(world_def(dt, integrator)) {
    BodyDef<double> def;
    def.mass = 0.2;
    def.shape = Box<double>{.half_extents = {0.005, 0.05, 0.1}};
    def.material.friction = 0.8;
    def.position = {0, above * std::sin(start), -above * std::cos(start)};
    def.orientation = exp_rotation<double>({start, 0, 0});
    plate = world.add_body(def);
    for (std::size_t i = 0; i < 2; ++i) {
      BodyDef<double> ball;
      ball.mass = 0.1;
      ball.gravity_scale = 0;
      ball.shape = Sphere<double>{.radius = 0.01};
      ball.material.friction = 0.8;
      ball.position = {i == 0 ? -0.015 : 0.015, 0, 0};
      ball.locked.linear = {false, true, true};
      ball.locked.angular = {true, true, true};
      balls[i] = world.add_body(ball);
    }
  }
  void step() {
    for (std::size_t i = 0; i < 2; ++i) {
      world.apply_force(balls[i], {i == 0 ? 30.0 : -30.0, 0, 0}, world.pose(balls[i]).translation);
    }
    world.step();
  }
  [[nodiscard]] double angle() const {
    const Quat<double> q = world.pose(plate).rotation;
    return 2 * std::atan2(q.x(), q.w());
  }
  /// [m] How far the point of the plate that was gripped has moved.
  [[nodiscard]] double drift() const {
    const Transform<double> X = world.pose(plate);
    return (X.translation + X.rotation * Vec3<double>(0, 0, above)).norm();
  }
};

struct Swing {
  double amplitude = 0;  // [1] In the last second, as a part of the first.
  double drift = 0;      // [m] Largest.
};

/// @param change  Called with the number of each step before it.
template <typename Change>
Swing run_swing(double dt, Integrator integrator, double seconds, Change&& change) {
  SwingingPlate scene(dt, integrator);
  double first = 0;
  double last = 0;
  double time = 0;
  Swing result;
  for (int i = 0; time < seconds; ++i) {
    change(i, scene.world);
    scene.step();
    time += scene.world.time_step();
    const double angle = std::abs(scene.angle());
    if (time < 1) first = std::max(first, angle);
    if (time > seconds - 1) last = std::max(last, angle);
    result.drift = std::max(result.drift, scene.drift());
  }
  result.amplitude = last / first;
  return result;
}
Swing run_swing(double dt, Integrator integrator, double seconds = 10) {
  return run_swing(dt, integrator, seconds, [](int, const World<double>&) {});
}

}  // namespace

TEST_CASE("pivots: a plate that swings in a grip keeps its swing and its pivot") {
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    CAPTURE(static_cast<int>(integrator));
    const Swing result = run_swing(1.0 / 240, integrator);
    CHECK(result.amplitude > 0.9995);
    CHECK(result.amplitude < 1.0005);
    CHECK(result.drift < 1e-4);
    // Of second order: halving the step leaves a quarter, with a fifth to spare.
    const Swing finer = run_swing(1.0 / 480, integrator);
    CHECK(finer.drift < result.drift / 3.2);
  }
}

TEST_CASE("pivots: a step that changes its length in mid-swing changes nothing else") {
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    CAPTURE(static_cast<int>(integrator));
    const Swing result = run_swing(1.0 / 480, integrator, 10, [](int i, World<double>& world) {
      if (i % 7 == 0) world.set_time_step(i % 2 == 0 ? 1.0 / 480 : 1.0 / 240);
    });
    CHECK(result.amplitude > 0.98);
    CHECK(result.amplitude < 1.01);
    CHECK(result.drift < 3e-4);
  }
}

namespace {

/// [1] Energy that a block gains or loses while it topples over its edge, from a little beyond its
/// balance to half a right angle, as a part of what it falls by. (Where it lies flatter the ground
/// carries ever less of it, until its foot slips.)
double energy_error_of_toppling(double dt) {
  constexpr double a = 0.05;  // [m] Half a side of its foot.
  constexpr double b = 0.25;  // [m] Half its height.
  World<double> world(world_def(dt, Integrator::trapezoidal));
  BodyDef<double> ground;
  ground.motion = Motion::fixed;
  ground.shape = HalfSpace<double>{};
  ground.material.friction = 2;
  world.add_body(ground);
  BodyDef<double> def;
  def.mass = 1;
  def.shape = Box<double>{.half_extents = {a, 2 * a, b}};
  def.material.friction = 2;
  const double start = std::atan2(a, b) + 0.1;
  const Quat<double> turn = exp_rotation<double>({0, start, 0});
  def.orientation = turn;
  def.position = -(turn * Vec3<double>(a, 0, -b));
  const BodyId block = world.add_body(def);
  const auto energy = [&] {
    const Body<double>& body = world.body(block);
    return body.kinetic_energy() + body.mass * test::g * body.center_pose.translation.z();
  };
  const double before = energy();
  const double height = world.pose(block).translation.z();
  double worst = 0;
  const auto tilt = [&] {
    const Vec3<double> up = world.pose(block).rotation * Vec3<double>(0, 0, 1);
    return std::atan2(up.x(), up.z());
  };
  while (tilt() < std::acos(0.0) / 2) {
    world.step();
    worst = std::max(worst, std::abs(energy() - before));
  }
  return worst / (test::g * (height - world.pose(block).translation.z()));
}

}  // namespace

TEST_CASE("pivots: a block that topples over its edge keeps its energy to second order") {
  const double coarse = energy_error_of_toppling(1.0 / 240);
  const double fine = energy_error_of_toppling(1.0 / 960);
  CAPTURE(coarse);
  CAPTURE(fine);
  CHECK(coarse < 5e-3);
  // A sixteenth, with a half to spare.
  CHECK(fine < coarse / 8);
}

TEST_CASE("pivots: a ball that rolls does not pivot about what it touches") {
  World<double> world(world_def(1.0 / 240, Integrator::trapezoidal));
  BodyDef<double> ground;
  ground.motion = Motion::fixed;
  ground.shape = HalfSpace<double>{};
  world.add_body(ground);
  BodyDef<double> def;
  def.mass = 1;
  def.shape = Sphere<double>{.radius = 0.05};
  def.position = {0, 0, 0.05};
  def.velocity = {2, 0, 0};
  def.angular_velocity = {0, 40, 0};
  const BodyId ball = world.add_body(def);
  for (int i = 0; i < 240; ++i) world.step();
  // As if it did, it would leave the ground at h w^2 r / 2 = 0.17 m/s.
  CHECK(std::abs(world.pose(ball).translation.z() - 0.05) < 1e-9);
  CHECK(std::abs(world.body(ball).twist.linear.x() - 2) < 1e-9);
}

namespace {

/// Addition to the hinge of a pendulum of 1 kg and 0.3 m.
enum class Extra { nothing, motor, sensor };

struct Pendulum {
  World<double> world;
  BodyId bob;

  /// @param strength  [N m] Of a motor; [1] of a sensor's constants.
  Pendulum(double dt, Extra extra, double strength, Integration integration)
      : world(world_def(dt, Integrator::trapezoidal)) {
    BodyDef<double> wall;
    wall.motion = Motion::fixed;
    wall.shape = HalfSpace<double>{.normal = {0, 1, 0}, .offset = -0.03};
    const BodyId fixed = world.add_body(wall);
    BodyDef<double> def;
    def.mass = 1;
    def.shape = Box<double>{.half_extents = {0.02, 0.02, 0.02}};
    def.position = {0.3, 0, 0};
    bob = world.add_body(def);
    JointDef<double> joint;
    joint.kind = JointKind::revolute;
    joint.body_a = fixed;
    joint.body_b = bob;
    const Quat<double> to_y = exp_rotation<double>({0, 0, std::acos(0.0)});
    joint.X_AJ = {to_y, {0, 0, 0}};
    joint.X_BJ = {to_y, {-0.3, 0, 0}};
    if (extra == Extra::motor) {
      joint.motor.mode = MotorMode::velocity;
      joint.motor.max_force = strength;
    }
    world.add_joint(joint);
    if (extra != Extra::sensor) return;
    PatchDef<double> patch;
    patch.sensors = sensor_grid<double>({.center = {0, -0.02, 0},
                                         .side_u = {0.02, 0, 0},
                                         .side_v = {0, 0, 0.02},
                                         .count_u = 1,
                                         .count_v = 1,
                                         .depth = 0.01,
                                         .range = 0.025});
    patch.parameters = {.normal_stiffness = strength, .static_friction = strength};
    patch.integration = integration;
    world.add_patch(bob, patch);
  }
  [[nodiscard]] double energy() const {
    const Body<double>& body = world.body(bob);
    return body.kinetic_energy() + body.mass * test::g * (body.center_pose.translation.z() + 0.3);
  }
};

}  // namespace

TEST_CASE("pivots: what gives no force changes no bit of a pendulum's motion") {
  const auto states = [](Extra extra, Integration integration) {
    Pendulum pendulum(1.0 / 240, extra, 0, integration);
    std::vector<double> out;
    for (int i = 0; i < 480; ++i) {
      pendulum.world.step();
      const Body<double>& body = pendulum.world.body(pendulum.bob);
      out.insert(out.end(), {body.center_pose.translation.x(), body.center_pose.translation.z(),
                             body.center_pose.rotation.y(), body.twist.angular.y()});
    }
    return out;
  };
  const std::vector<double> bare = states(Extra::nothing, Integration::automatic);
  CHECK(states(Extra::motor, Integration::automatic) == bare);
  for (const Integration integration :
       {Integration::automatic, Integration::implicit, Integration::explicit_}) {
    CHECK(states(Extra::sensor, integration) == bare);
  }
}

TEST_CASE("pivots: a pendulum keeps its energy under motors and sensors that hardly act") {
  // Its energy swings by the order of the step, as with every symplectic scheme of first order, and
  // goes nowhere: as far off in the last second of twenty as in the first.
  for (const Extra extra : {Extra::motor, Extra::sensor}) {
    CAPTURE(static_cast<int>(extra));
    Pendulum pendulum(1.0 / 240, extra, 1e-9, Integration::implicit);
    const double before = pendulum.energy();
    const int second = 240;
    double first = 0;
    double last = 0;
    for (int i = 0; i < 20 * second; ++i) {
      pendulum.world.step();
      const double error = std::abs(pendulum.energy() / before - 1);
      if (i < second) first = std::max(first, error);
      if (i >= 19 * second) last = std::max(last, error);
    }
    CAPTURE(first);
    CAPTURE(last);
    CHECK(first < 0.02);
    CHECK(last < 1.2 * first);
  }
}
