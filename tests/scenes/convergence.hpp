/// @file
/// Small scenes with known motions, and how their error falls with the step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/ground.hpp"
#include "support/tumbling.hpp"

#include <bristle/math/rotation.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <vector>

namespace bristle::scenes {

/// A motion whose end is known in another way.
struct KnownMotion {
  std::string name;
  /// [m] or [rad] Error after the whole run, in steps of dt; the largest over a few starts, so that
  /// the place of an event within its step does not decide.
  std::function<double(double dt, Integrator integrator)> error;
  /// [m] or [rad] Largest error that round-off and the solver's tolerance explain.
  double round_off = 1e-11;
  /// [-] Order of the trapezoidal rule and of symplectic Euler; 0: exact to `round_off`.
  int order = 0;
  int euler_order = 1;
};

/// All of them.
[[nodiscard]] std::vector<KnownMotion> known_motions();

/// [s] Steps that divide every run.
inline constexpr std::array<double, 6> step_ladder{1.0 / 50,  1.0 / 100, 1.0 / 200,
                                                   1.0 / 400, 1.0 / 800, 1.0 / 1600};

/// [1] Slope of log error against log step by least squares, over the errors above a floor; NaN if
/// fewer than three are.
[[nodiscard]] double fitted_order(std::span<const double> steps, std::span<const double> errors,
                                  double floor);

// Implementation ----------------------------------------------------------------------------------

inline double fitted_order(std::span<const double> steps, std::span<const double> errors,
                           double floor) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (!(errors[i] > floor)) continue;
    const double a = std::log(steps[i]);
    const double b = std::log(errors[i]);
    n += 1;
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  return n < 3 ? std::numeric_limits<double>::quiet_NaN() : (n * xy - x * y) / (n * xx - x * x);
}

namespace parts {

inline constexpr double gravity = 9.81;
/// [m] or [m/s] Starts that put an event at different places within a step: they spread over more
/// than the longest step.
[[nodiscard]] inline std::array<double, 20> starts() {
  std::array<double, 20> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = 1 + 0.0237 * static_cast<double>(i);
  return all;
}

[[nodiscard]] inline World<double> world_of(double dt, Integrator integrator,
                                            const Vec3<double>& g = {0, 0, -gravity}) {
  WorldDef<double> def;
  def.time_step = dt;
  def.gravity = g;
  def.integrator = integrator;
  return World<double>(def);
}

inline void run(World<double>& world, double duration) {
  const long steps = std::lround(duration / world.time_step());
  for (long i = 0; i < steps; ++i) world.step();
}

[[nodiscard]] inline BodyDef<double> cube(const Material<double>& material) {
  BodyDef<double> def;
  def.mass = 0.5;
  def.shape = Box<double>{{0.1, 0.1, 0.1}};
  def.material = material;
  def.position = {0, 0, 0.1};
  return def;
}

/// A body thrown with a spin, for 1 s.
[[nodiscard]] inline double projectile_error(double dt, Integrator integrator) {
  World<double> world = world_of(dt, integrator);
  BodyDef<double> def = cube({});
  def.velocity = {3, -1, 4};
  def.angular_velocity = {1, 2, 3};
  const BodyId id = world.add_body(def);
  run(world, 1);
  const Vec3<double> end(3, -1, 0.1 + 4 - gravity / 2);
  return (world.body(id).center_pose.translation - end).norm();
}

/// A box slides until it stops, v^2 / (2 mu g) from where it started.
[[nodiscard]] inline double slide_error(double dt, Integrator integrator) {
  double worst = 0;
  for (const double v : starts()) {
    World<double> world = world_of(dt, integrator);
    add_ground(world, {0.5, 0});
    BodyDef<double> def = cube({0.5, 0});
    def.velocity = {v, 0, 0};
    const BodyId id = world.add_body(def);
    run(world, 0.5);
    const double x = world.body(id).center_pose.translation.x();
    worst = std::max(worst, std::abs(x - v * v / gravity));
  }
  return worst;
}

/// A box slips on an incline steeper than friction holds.
[[nodiscard]] inline double slip_error(double dt, Integrator integrator) {
  const double angle = std::atan(0.8);
  World<double> world =
      world_of(dt, integrator, {gravity * std::sin(angle), 0, -gravity * std::cos(angle)});
  add_ground(world, {0.5, 0});
  const BodyId id = world.add_body(cube({0.5, 0}));
  run(world, 1);
  const double a = gravity * (std::sin(angle) - 0.5 * std::cos(angle));
  return std::abs(world.body(id).center_pose.translation.x() - a / 2);
}

/// A ball slides and comes to roll: at 5/7 of its speed, after 2 v / (7 mu g).
[[nodiscard]] inline double roll_error(double dt, Integrator integrator) {
  double worst = 0;
  for (const double v : starts()) {
    World<double> world = world_of(dt, integrator);
    add_ground(world, {0.5, 0});
    BodyDef<double> def = cube({0.5, 0});
    def.shape = Sphere<double>{0.1};
    def.velocity = {v, 0, 0};
    const BodyId id = world.add_body(def);
    run(world, 0.5);
    const double t = 2 * v / (7 * 0.5 * gravity);
    const double end = (v + 5 * v / 7) / 2 * t + 5 * v / 7 * (0.5 - t);
    worst = std::max(worst, std::abs(world.body(id).center_pose.translation.x() - end));
  }
  return worst;
}

/// A ball falls from a height and bounces with e = 0.8 for 1.5 s: two to three impacts.
[[nodiscard]] inline double bounce_error(double dt, Integrator integrator) {
  constexpr double e = 0.8;
  double worst = 0;
  for (const double height : starts()) {
    World<double> world = world_of(dt, integrator);
    add_ground(world, {0.5, e});
    BodyDef<double> def = cube({0.5, e});
    def.shape = Sphere<double>{0.1};
    def.position.z() += height;
    const BodyId id = world.add_body(def);
    run(world, 1.5);
    double t = std::sqrt(2 * height / gravity);
    double v = e * gravity * t;
    while (t + 2 * v / gravity < 1.5) {
      t += 2 * v / gravity;
      v *= e;
    }
    const double s = 1.5 - t;
    const double end = 0.1 + v * s - gravity * s * s / 2;
    worst = std::max(worst, std::abs(world.body(id).center_pose.translation.z() - end));
  }
  return worst;
}

/// A body with three different moments tumbles for 1 s. Euler's equations by Runge-Kutta of fourth
/// order in steps of 20 us say where it ends, to 1e-13.
[[nodiscard]] inline double spin_error(double dt, Integrator integrator) {
  const Vec3<double> moments(0.01, 0.02, 0.025);
  const Vec3<double> spin(4, 3, -5);
  World<double> world = world_of(dt, integrator);
  BodyDef<double> def = cube({});
  def.inertia = Mat3<double>(moments.asDiagonal());
  def.angular_velocity = spin;
  const BodyId id = world.add_body(def);
  run(world, 1);
  static const Quat<double> reference = test::tumbled_attitude(moments, spin, 1, 50000);
  return log_rotation<double>(world.pose(id).rotation.conjugate() * reference).norm();
}

/// Two links on ball joints, let go horizontally, after 1 s. The angles of a double pendulum by
/// Runge-Kutta of fourth order in steps of 20 us say where the last one is.
[[nodiscard]] inline double chain_error(double dt, Integrator integrator) {
  constexpr double length = 0.2;
  constexpr double inertia = (0.1 * 0.1 + 0.02 * 0.02) / 3;  // about the centre, across
  World<double> world = world_of(dt, integrator);
  BodyId last = world.add_body({.motion = Motion::fixed});
  for (int i = 0; i < 2; ++i) {
    BodyDef<double> link;
    link.mass = 1;
    link.shape = Box<double>{{0.1, 0.02, 0.02}};
    link.position = {length * (i + 0.5), 0, 0};
    link.filter.mask = 0;
    const BodyId id = world.add_body(link);
    JointDef<double> joint;
    joint.kind = JointKind::ball;
    joint.body_a = last;
    joint.body_b = id;
    joint.X_AJ.translation = {i == 0 ? 0.0 : length / 2, 0, 0};
    joint.X_BJ.translation = {-length / 2, 0, 0};
    world.add_joint(joint);
    last = id;
  }
  run(world, 1);
  using State = Eigen::Vector4d;  // angles from hanging, and their rates
  const auto rate = [](const State& s) {
    const double d = s[0] - s[1];
    Eigen::Matrix2d M;
    M(0, 0) = inertia + length * length * 1.25;
    M(0, 1) = M(1, 0) = length * length / 2 * std::cos(d);
    M(1, 1) = inertia + length * length / 4;
    const double swing = length * length / 2 * std::sin(d);
    const Eigen::Vector2d load(-swing * s[3] * s[3] - 1.5 * gravity * length * std::sin(s[0]),
                               swing * s[2] * s[2] - 0.5 * gravity * length * std::sin(s[1]));
    const Eigen::Vector2d a = M.inverse() * load;
    return State(s[2], s[3], a[0], a[1]);
  };
  static const State reference = [&] {
    State s(std::numbers::pi / 2, std::numbers::pi / 2, 0, 0);
    constexpr int steps = 50000;
    constexpr double h = 1.0 / steps;
    for (int i = 0; i < steps; ++i) {
      const State a = rate(s);
      const State b = rate(s + h / 2 * a);
      const State c = rate(s + h / 2 * b);
      const State d = rate(s + h * c);
      s += h / 6 * (a + 2 * b + 2 * c + d);
    }
    return s;
  }();
  const Vec3<double> end(length * std::sin(reference[0]) + length / 2 * std::sin(reference[1]), 0,
                         -length * std::cos(reference[0]) - length / 2 * std::cos(reference[1]));
  return (world.body(last).center_pose.translation - end).norm();
}

}  // namespace parts

inline std::vector<KnownMotion> known_motions() {
  return {{"projectile", parts::projectile_error},
          {"slide", parts::slide_error, 1e-11, 2},
          {"slip", parts::slip_error},
          {"roll", parts::roll_error, 1e-11, 2},
          {"bounce", parts::bounce_error},
          {"spin", parts::spin_error, 1e-12, 4, 4},
          {"chain of 2", parts::chain_error, 1e-12, 5}};
}

}  // namespace bristle::scenes
