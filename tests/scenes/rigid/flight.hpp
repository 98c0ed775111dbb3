/// @file
/// A ball that bounces, a body that spins freely, and many that fly.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"
#include "support/tumbling.hpp"

#include <cmath>
#include <vector>

namespace bristle::scenes {

using namespace bristle::detail;

/// A ball of 0.1 m falls 1 m and bounces with restitution e. Peak k has the height e^(2k); the
/// error is the largest relative one of the first 5 (e < 1) or 10 peaks [1].
class Bounce : public Trial {
 public:
  explicit Bounce(double restitution) : Trial(make(restitution)), restitution_(restitution) {}

  void observe(const Engine& engine, const Instant& now) override {
    const BodyState ball = engine.state(1);
    const double v = ball.velocity.z();
    if (now.step > 0 && last_v_ > 0 && v <= 0) {
      // The peak lies between two steps: what it still was above this one follows from the speed.
      peaks_.push_back(ball.position.z() - radius + v * v / (2 * earth_gravity));
    }
    last_v_ = v;
    deepest_ = std::max(deepest_, radius - ball.position.z());
  }

  [[nodiscard]] Outcome outcome() const override {
    const std::size_t count = restitution_ < 1 ? 5 : 10;
    double error = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const double height = k < peaks_.size() ? peaks_[k] : 0;
      error = std::max(
          error, std::abs(height / std::pow(restitution_, 2 * (static_cast<double>(k) + 1)) - 1));
    }
    return {error,
            error < (restitution_ < 1 ? 0.15 : 0.05),
            {{"peaks", static_cast<double>(peaks_.size())},
             {"last_peak", peaks_.empty() ? 0 : peaks_.back()},
             {"max_depth", deepest_}}};
  }

 private:
  static constexpr double radius = 0.1;

  static Scene make(double restitution) {
    Scene scene;
    scene.restitution = restitution;
    scene.duration = restitution < 1 ? 3.5 : 10;
    scene.add(floor_body(0.5));
    scene.add(ball_body(radius, 1, {0, 0, 1 + radius}, 0.5));
    return scene;
  }

  double restitution_;
  double last_v_ = 0;
  double deepest_ = 0;
  std::vector<double> peaks_;
};

/// A body with principal moments 1, 2, 3 kg m^2 spins about its middle axis at 5 rad/s, with 0.1 on
/// the others: it tumbles. The error is the largest relative change of energy in 10 s [1].
class Spin : public Trial {
 public:
  Spin() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    end_ = engine.state(0);
    const double e = kinetic_energy(scene().bodies[0], end_);
    const Vector l = momentum(end_);
    if (now.step == 0) {
      energy_at_start_ = e;
      momentum_at_start_ = l;
    }
    energy_at_end_ = e / energy_at_start_ - 1;
    error_ = std::max(error_, std::abs(energy_at_end_));
    turn_ =
        std::max(turn_, std::atan2(l.cross(momentum_at_start_).norm(), l.dot(momentum_at_start_)));
  }

  [[nodiscard]] Outcome outcome() const override {
    return {error_,
            error_ < 0.05,
            {{"E_end", energy_at_end_},
             {"momentum_turn", turn_},
             {"attitude_error", angle_between(end_.orientation, reference_attitude())}}};
  }

 private:
  static Scene make() {
    Scene scene;
    scene.gravity = Vector::Zero();
    scene.duration = 10;
    SceneBody body = box_body({0.3, 0.2, 0.1}, 1, Vector::Zero(), 0);
    body.principal_inertia = Vector(1, 2, 3);
    body.angular_velocity = {0.1, 5, 0.1};
    scene.add(body);
    return scene;
  }

  [[nodiscard]] Vector momentum(const BodyState& state) const {
    const Vector spin = state.orientation.conjugate() * state.angular_velocity;
    return state.orientation * Vector(principal_inertia(scene().bodies[0]).cwiseProduct(spin));
  }

  /// Attitude after 10 s: Euler's equations by Runge-Kutta of fourth order in steps of 50 us, whose
  /// error is that of the round-off (1e-12).
  [[nodiscard]] Rotation reference_attitude() const {
    return test::tumbled_attitude(principal_inertia(scene().bodies[0]),
                                  scene().bodies[0].angular_velocity, scene().duration, 200000);
  }

  double energy_at_start_ = 0;
  double energy_at_end_ = 0;
  double error_ = 0;
  double turn_ = 0;
  Vector momentum_at_start_ = Vector::Zero();
  BodyState end_{};
};

/// A thousand balls of 0.1 m, 2 m apart, fly at 8 m/s and turn for 1 s; nothing touches. The error
/// is the largest distance from their parabolas [m].
class Flight : public Trial {
 public:
  Flight() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    const Vector fallen = 0.5 * now.time * now.time * scene().gravity;
    for (std::size_t i = 0; i < scene().bodies.size(); ++i) {
      const SceneBody& ball = scene().bodies[i];
      const Vector there = ball.position + now.time * ball.velocity + fallen;
      error_ = std::max(error_, (engine.state(i).position - there).norm());
    }
  }

  [[nodiscard]] Outcome outcome() const override { return {error_, error_ < 0.1}; }

 private:
  static Scene make() {
    Scene scene;
    scene.duration = 1;
    for (int i = 0; i < 1000; ++i) {
      const Vector place(i % 10, i / 10 % 10, i / 100);
      SceneBody ball = ball_body(0.1, 1, 2 * place, 0.5);
      ball.velocity = {8, 0.3, 0};
      ball.angular_velocity = {1, 2, 0.5};
      scene.add(ball);
    }
    return scene;
  }

  double error_ = 0;
};

}  // namespace bristle::scenes
