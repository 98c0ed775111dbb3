/// @file
/// Mechanisms: a chain over a cylinder, ragdolls that fall, a pendulum with what must not change
/// it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/chain_links.hpp"
#include "scenes/rigid/watched.hpp"
#include "support/random.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <vector>

namespace bristle::scenes {

/// A chain of 100 capsules of 50 mm and 0.1 kg on ball joints lies over a cylinder of 0.5 m radius,
/// two thirds of what hangs on one side, mu = 0.2. By the equation of a heavy belt,
/// dT/dq = mu (T + R g cos q) - R g sin q, 1.1 m on one side hold up to 2.6 m on the other, where
/// 2.3 m hang: it should stay.
[[nodiscard]] inline Scene chain_over_cylinder() {
  constexpr int links = 100;
  constexpr double pitch = 0.05;
  constexpr double thickness = 0.01;
  constexpr double friction = 0.2;
  constexpr double drum = 0.5;
  constexpr double round = drum + thickness + 1e-3;
  Scene scene;
  scene.duration = 3;
  scene.is_large = true;
  const std::vector<Vector> ends = chain_links(links, pitch, round, 12 * pitch);
  for (int i = 0; i < links; ++i) {
    const Vector& from = ends[static_cast<std::size_t>(i)];
    const Vector& to = ends[static_cast<std::size_t>(i) + 1];
    SceneBody link =
        capsule_body({thickness, pitch / 2 - thickness}, 0.1, (from + to) / 2, friction);
    link.orientation = turn_between(Vector::UnitZ(), to - from);
    scene.add(link);
    if (i > 0) scene.joints.push_back({i - 1, i, from});
  }
  SceneBody roller;
  roller.shape = Cylinder<double>{drum, 0.5};
  roller.orientation = turn_about(Vector::UnitX(), std::numbers::pi / 2);
  roller.friction = std::sqrt(friction);
  scene.add(roller);
  return scene;
}

namespace detail {

/// Adds a ragdoll of ten parts, 1.5 m tall, with its hips at a place: ball joints with a cone of
/// 1 rad at neck, shoulders and hips, hinges that bend one way at elbows and knees.
inline void add_ragdoll(Scene& scene, const Vector& hips, const Rotation& turn, int family) {
  constexpr double friction = 0.5;
  const auto first = static_cast<int>(scene.bodies.size());
  const auto add = [&](SceneBody body) {
    body.position = hips + turn * body.position;
    body.orientation = turn * body.orientation;
    body.family = family;
    scene.add(body);
  };
  const auto join = [&](int a, int b, const Vector& anchor) -> SceneJoint& {
    scene.joints.push_back({first + a, first + b, hips + turn * anchor});
    return scene.joints.back();
  };
  const auto ball = [&](int a, int b, const Vector& anchor, const Vector& axis) {
    SceneJoint& joint = join(a, b, anchor);
    joint.axis = turn * axis;
    joint.swing = 1;
  };
  const auto hinge = [&](int a, int b, const Vector& anchor, double lower, double upper) {
    SceneJoint& joint = join(a, b, anchor);
    joint.kind = SceneJointKind::hinge;
    joint.axis = turn * Vector::UnitY();
    joint.lower = lower;
    joint.upper = upper;
  };
  const Vector up = Vector::UnitZ();
  add(box_body({0.09, 0.15, 0.25}, 25, {0, 0, 0.25}, friction));
  add(ball_body(0.11, 5, {0, 0, 0.65}, friction));
  ball(0, 1, {0, 0, 0.52}, up);
  int part = 2;
  for (const double side : {-1.0, 1.0}) {
    add(capsule_body({0.045, 0.1}, 2, {0, side * 0.21, 0.32}, friction));
    ball(0, part, {0, side * 0.21, 0.46}, -up);
    add(capsule_body({0.04, 0.1}, 1.5, {0, side * 0.21, 0.04}, friction));
    hinge(part, part + 1, {0, side * 0.21, 0.18}, -2, 0);
    part += 2;
  }
  for (const double side : {-1.0, 1.0}) {
    add(capsule_body({0.06, 0.14}, 7, {0, side * 0.09, -0.22}, friction));
    ball(0, part, {0, side * 0.09, -0.02}, -up);
    add(capsule_body({0.05, 0.14}, 4, {0, side * 0.09, -0.62}, friction));
    hinge(part, part + 1, {0, side * 0.09, -0.42}, 0, 2);
    part += 2;
  }
}

}  // namespace detail

/// 20 ragdolls in five layers fall on a floor and on each other.
[[nodiscard]] inline Scene falling_ragdolls() {
  test::Random random(11);
  Scene scene;
  scene.duration = 3;
  scene.is_large = true;
  scene.add(floor_body(0.5));
  for (int i = 0; i < 20; ++i) {
    const Vector at = {0.7 * (i % 2) + random.uniform(-0.05, 0.05),
                       0.7 * (i / 2 % 2) + random.uniform(-0.05, 0.05), 1.3 + 1.7 * (i / 4)};
    const Rotation turn = turn_about(Vector::UnitX(), random.uniform(-0.3, 0.3)) *
                          turn_about(Vector::UnitZ(), random.uniform(-3.0, 3.0));
    detail::add_ragdoll(scene, at, turn, i + 1);
  }
  return scene;
}

/// Addition to a pendulum that gives no force.
enum class Inert { nothing, motor, sensors };

/// A cube of 40 mm and 1 kg on a hinge 0.3 m away swings from the level for 10 s. The error is the
/// largest change of its energy, as a part of m g l [1]. A motor without torque, or sensors without
/// constants that touch a wall beside it, must not change it.
class Pendulum : public Trial {
 public:
  explicit Pendulum(Inert inert) : Trial(make(inert)) {}

  void observe(const Engine& engine, const Instant& now) override {
    const double e = total_energy(scene(), engine);
    if (now.step == 0) at_start_ = e;
    at_end_ = (e - at_start_) / (earth_gravity * length);
    error_ = std::isfinite(at_end_) ? std::max(error_, std::abs(at_end_))
                                    : std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] Outcome outcome() const override {
    return {error_, error_ < 0.01, {{"E_end", at_end_}}};
  }

 private:
  static constexpr double length = 0.3;

  static Scene make(Inert inert) {
    Scene scene;
    scene.duration = 10;
    scene.add(box_body({0.02, 0.02, 0.02}, 1, {length, 0, 0}, 0));
    SceneJoint hinge{-1, 0, Vector::Zero()};
    hinge.kind = SceneJointKind::hinge;
    hinge.axis = Vector::UnitY();
    if (inert == Inert::motor) hinge.motor = SceneMotor{.max_torque = 0};
    scene.joints.push_back(hinge);
    scene.add(floor_body(0, Vector::UnitY()));
    std::get<HalfSpace<double>>(scene.bodies.back().shape).offset = -0.03;
    if (inert == Inert::sensors) {
      scene.sensors.push_back({.centre = {0, -0.02, 0},
                               .side_u = {0.02, 0, 0},
                               .side_v = {0, 0, 0.02},
                               .count_u = 3,
                               .count_v = 3,
                               .reach = 0.015});
    }
    return scene;
  }

  double at_start_ = 0;
  double at_end_ = 0;
  double error_ = 0;
};

}  // namespace bristle::scenes
