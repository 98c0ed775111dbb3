/// @file
/// A hand of four driven fingers that holds a part, is loaded by its weight, and shaken.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace bristle::scenes {

using namespace bristle::detail;

/// How a hand is made.
struct HandSetup {
  /// [-] True if its fingertips have 32 sensors each.
  bool has_sensors = false;
  /// [N m] Largest torque of a motor.
  double max_torque = std::numeric_limits<double>::infinity();
};

/// Four fingers of three links each, 50 mm and 40 g, hang from a palm on hinges with drives (4 N m
/// a rad, 0.1 N m s) and close on a cylinder of 70 x 100 mm and 0.3 kg, mu = 0.8. Gravity comes at
/// 1 s; from 3 to 5 s the palm is shaken sideways at 3 Hz with half of it. The error is how far the
/// part ever moves in the palm after 1.5 s [m].
class HeldInHand : public Trial {
 public:
  explicit HeldInHand(const HandSetup& setup) : Trial(make(setup)) {}

  void push(Engine& engine, const Instant& now) const override {
    if (now.is(1)) engine.set_gravity({0, 0, -earth_gravity});
  }
  void observe(const Engine& engine, const Instant& now) override {
    const BodyState palm = engine.state(0);
    const BodyState part = engine.state(1);
    const Vector in_palm = palm.orientation.conjugate() * Vector(part.position - palm.position);
    gap_ = std::max(gap_, largest_joint_gap(scene(), engine));
    if (now.is(1.5)) held_ = in_palm;
    if (now.time < 1.5) return;
    const double moved = (in_palm - held_).norm();
    error_ =
        std::isfinite(moved) ? std::max(error_, moved) : std::numeric_limits<double>::infinity();
    at_end_ = moved;
    if (now.time > 2 && now.time < 3) rest_ = std::max(rest_, part.velocity.norm());
  }
  [[nodiscard]] Outcome outcome() const override {
    return {
        error_, error_ < 5e-3, {{"at_end", at_end_}, {"v_at_rest", rest_}, {"joint_gap", gap_}}};
  }

 private:
  static Place palm(double t) {
    constexpr double from = 3;
    constexpr double until = 5;
    const double rate = 2 * std::numbers::pi * 3;
    const double reach = 0.5 * earth_gravity / (rate * rate);
    const double x = t > from && t < until ? reach * std::sin(rate * (t - from)) : 0;
    return {Vector(x, 0, 0.2), Rotation::Identity()};
  }

  static Scene make(const HandSetup& setup) {
    constexpr double friction = 0.8;
    constexpr double length = 0.05;
    constexpr int family = 1;
    Scene scene;
    scene.duration = 6;
    scene.gravity = Vector::Zero();
    SceneBody hub = driven_body(Box<double>{{0.07, 0.07, 0.005}}, friction, palm);
    hub.meets = Meets::nothing;
    scene.add(hub);
    SceneBody part;
    part.shape = Cylinder<double>{0.035, 0.05};
    part.mass = 0.3;
    part.position = {0, 0, 0.07};
    part.friction = std::sqrt(friction);
    scene.add(part);
    for (int finger = 0; finger < 4; ++finger) {
      const Rotation turn = turn_about(Vector::UnitZ(), std::numbers::pi / 2 * finger);
      const Vector root = turn * Vector(0.062, 0, 0) + Vector(0, 0, 0.2);
      int previous = 0;
      for (int k = 0; k < 3; ++k) {
        SceneBody link = box_body({0.008, 0.009, length / 2 - 0.001}, 0.04,
                                  root - (k + 0.5) * length * Vector::UnitZ(), friction);
        link.orientation = turn;
        link.family = family;
        const std::size_t added = scene.add(link);
        SceneJoint hinge{previous, static_cast<int>(added), root - k * length * Vector::UnitZ()};
        hinge.kind = SceneJointKind::hinge;
        hinge.axis = turn * Vector::UnitY();
        hinge.lower = -0.3;
        hinge.upper = 1.5;
        hinge.motor = SceneMotor{.target = k == 0   ? 0.6
                                           : k == 1 ? 0.1
                                                    : -0.1,
                                 .stiffness = 4,
                                 .damping = 0.1,
                                 .max_torque = setup.max_torque};
        scene.joints.push_back(hinge);
        previous = static_cast<int>(added);
        if (k < 2 || !setup.has_sensors) continue;
        scene.sensors.push_back({.body = added,
                                 .centre = {-0.008, 0, 0},
                                 .side_u = {0, 0, 0.044},
                                 .side_v = {0, 0.016, 0},
                                 .count_u = 8,
                                 .count_v = 4,
                                 .load = 6,
                                 .mass = 0.3});
      }
    }
    return scene;
  }

  Vector held_ = Vector::Zero();
  double error_ = 0;
  double at_end_ = 0;
  double rest_ = 0;
  double gap_ = 0;
};

}  // namespace bristle::scenes
