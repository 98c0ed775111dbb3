/// @file
/// Scenes that nothing was tuned on, of things that are driven: each with a closed form.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bristle::scenes {

/// A ball rolls for 5 s on a level table that turns at 3 rad/s, mu = 1.
///
/// It goes round in a circle at 2/7 of the table's rate, whatever its mass and radius: with c = 2/7
/// of the rate, v' = c z x v. It starts 0.5 m from the axis at 0.5 m/s against the table's turn and
/// rolls without sliding. The error is its largest distance from the circle's point [m].
class Turntable : public Trial {
 public:
  Turntable() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    const double c = 2.0 / 7 * rate;
    const Vector v = Vector(0, speed, 0);
    const double s = std::sin(c * now.time) / c;
    const double r = (1 - std::cos(c * now.time)) / c;
    const Vector place = start() + Vector(s * v.x() - r * v.y(), s * v.y() + r * v.x(), 0);
    const double away = (engine.state(1).position - place).norm();
    error_ = std::isfinite(away) ? std::max(error_, away) : std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] Outcome outcome() const override { return {error_, error_ < 0.02}; }

 private:
  static constexpr double rate = 3;
  static constexpr double speed = -0.5;
  static constexpr double radius = 0.05;

  static Vector start() { return {0.5, 0, radius}; }

  static Scene make() {
    Scene scene;
    scene.duration = 5;
    scene.add(driven_body(Box<double>{{2, 2, 0.05}}, 1, [](double t) -> Place {
      return {Vector(0, 0, -0.05), turn_about(Vector::UnitZ(), rate * t)};
    }));
    SceneBody ball = ball_body(radius, 1, start(), 1);
    ball.velocity = {0, speed, 0};
    // Where it touches it moves as the table: v + w x (-r z) = rate z x p.
    const Vector slip = rate * Vector::UnitZ().cross(start()) - ball.velocity;
    ball.angular_velocity = Vector(slip.y(), -slip.x(), 0) / radius;
    scene.add(ball);
    return scene;
  }

  double error_ = 0;
};

/// A flat box on a table that is shaken to and fro at 2 Hz with 0.8 g, mu = 0.4: it sticks and
/// slides twice a cycle. Coulomb's law, integrated in steps of 10 us by the trial itself, tells
/// where it is. The error is its largest distance from there in 5 s [m].
class Shaker : public Trial {
 public:
  Shaker() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    for (; time_ < now.time - 0.5 * fine; time_ += fine) advance();
    const double away = std::abs(engine.state(1).position.x() - x_);
    error_ = std::isfinite(away) ? std::max(error_, away) : std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] Outcome outcome() const override { return {error_, error_ < 0.02, {{"x", x_}}}; }

 private:
  static constexpr double fine = 1e-5;
  static constexpr double friction = 0.4;
  static constexpr double rate = 4 * 3.14159265358979;
  static constexpr double reach = 0.8 * earth_gravity / (rate * rate);

  static double table(double t) { return reach * (std::cos(rate * t) - 1); }

  void advance() {
    const double moves = (table(time_ + fine) - table(time_)) / fine;
    const double most = friction * earth_gravity * fine;
    v_ += std::clamp(moves - v_, -most, most);
    x_ += fine * v_;
  }

  static Scene make() {
    Scene scene;
    scene.duration = 5;
    scene.add(driven_body(Box<double>{{2, 1, 0.05}}, friction, [](double t) -> Place {
      return {Vector(table(t), 0, -0.05), Rotation::Identity()};
    }));
    scene.add(box_body({0.1, 0.1, 0.02}, 1, {0, 0, 0.02}, friction));
    return scene;
  }

  double time_ = 0;
  double x_ = 0;
  double v_ = 0;
  double error_ = 0;
};

/// An arm of 0.4 m and 1 kg on a hinge, without gravity, is driven from rest to 1 rad by a spring
/// of 5 N m and a damper of 0.2 N m s: it swings there, underdamped, for 3 s. The error is the
/// largest difference from the closed form [rad].
class Servo : public Trial {
 public:
  Servo() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    const Rotation turn = engine.state(0).orientation;
    const double angle = 2 * std::atan2(turn.y(), turn.w());
    // Inertia about the hinge.
    const double inertia = mass * (half * half + (half * half + width * width) / 3);
    const double decay = damping / (2 * inertia);
    const double rate = std::sqrt(stiffness / inertia - decay * decay);
    const double right =
        1 - std::exp(-decay * now.time) *
                (std::cos(rate * now.time) + decay / rate * std::sin(rate * now.time));
    const double away = std::abs(angle - right);
    error_ = std::isfinite(away) ? std::max(error_, away) : std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] Outcome outcome() const override { return {error_, error_ < 0.05}; }

 private:
  static constexpr double mass = 1;
  static constexpr double half = 0.2;
  static constexpr double width = 0.02;
  static constexpr double stiffness = 5;
  static constexpr double damping = 0.2;

  static Scene make() {
    Scene scene;
    scene.duration = 3;
    scene.gravity = Vector::Zero();
    scene.add(box_body({half, width, width}, mass, {half, 0, 0}, 0));
    SceneJoint hinge{-1, 0, Vector::Zero()};
    hinge.kind = SceneJointKind::hinge;
    hinge.axis = Vector::UnitY();
    hinge.motor = SceneMotor{.target = 1, .stiffness = stiffness, .damping = damping};
    scene.joints.push_back(hinge);
    return scene;
  }

  double error_ = 0;
};

}  // namespace bristle::scenes
