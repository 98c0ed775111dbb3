/// @file
/// A box that slides, sticks or slips on a plane, a ball that starts to roll: one body, Coulomb
/// friction, closed forms.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/trial.hpp"

#include <cmath>

namespace bristle::scenes {

using namespace bristle::detail;

/// A box of 0.2 m and 0.5 kg is let go at 2 m/s on a floor with mu = 0.5. It stops after
/// v^2 / (2 mu g); the error is how far from there it is after 1 s [m].
class Slide : public Trial {
 public:
  /// @param direction  [rad] Of the velocity, from x.
  explicit Slide(double direction)
      : Trial(make(direction)), direction_(std::cos(direction), std::sin(direction), 0) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (now.is(1)) stop_ = engine.state(1).position;
    if (now.is(5)) end_ = engine.state(1);
  }

  [[nodiscard]] Outcome outcome() const override {
    const double distance = speed * speed / (2 * friction * earth_gravity);
    const Vector miss = stop_ - distance * direction_;
    const double error = miss.head<2>().norm();
    const double drift = (end_.position - stop_).head<2>().norm();
    const bool is_straight = direction_.y() == 0;
    return {error,
            error < 0.025 && (!is_straight || drift < 1e-3),
            {{"signed", stop_.dot(direction_) - distance},
             {"drift", drift},
             {"rest_gap", end_.position.z() - 0.1},
             {"turn", angle_between(end_.orientation, Rotation::Identity())}}};
  }

 private:
  static constexpr double friction = 0.5;
  static constexpr double speed = 2;

  static Scene make(double direction) {
    Scene scene;
    scene.duration = 5;
    scene.add(floor_body(friction));
    SceneBody box = box_body({0.1, 0.1, 0.1}, 0.5, {0, 0, 0.1}, friction);
    box.velocity = speed * Vector(std::cos(direction), std::sin(direction), 0);
    scene.add(box);
    return scene;
  }

  Vector direction_;
  Vector stop_ = Vector::Zero();
  BodyState end_{};
};

/// A box on an incline (gravity is tilted), tan(angle) = `steepness` * mu.
///
/// Below 1 it sticks: the error is its mean creep from 1 s to 10 s [m/s]. Above it slips with
/// a = g (sin - mu cos): the error is that of the speed gained from 1 s to 2 s [1].
class Incline : public Trial {
 public:
  explicit Incline(double steepness) : Trial(make(steepness)), steepness_(steepness) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (now.is(1)) early_ = engine.state(1);
    if (now.is(scene().duration)) end_ = engine.state(1);
  }

  [[nodiscard]] Outcome outcome() const override {
    if (steepness_ < 1) {
      const double creep = std::abs(end_.position.x() - early_.position.x()) / 9;
      return {
          creep, creep < 1e-4, {{"total_slide", end_.position.x()}, {"v_end", end_.velocity.x()}}};
    }
    const double angle = std::atan(steepness_ * friction);
    const double a = earth_gravity * (std::sin(angle) - friction * std::cos(angle));
    const double x_error = end_.position.x() - 0.5 * a * 4;
    return {std::abs((end_.velocity.x() - early_.velocity.x()) / a - 1),
            std::abs(x_error) < 0.027,
            {{"v_error", end_.velocity.x() / (2 * a) - 1}, {"x_error", x_error}}};
  }

 private:
  static constexpr double friction = 0.5;

  static Scene make(double steepness) {
    const double angle = std::atan(steepness * friction);
    Scene scene;
    scene.duration = steepness < 1 ? 10 : 2;
    scene.gravity = earth_gravity * Vector(std::sin(angle), 0, -std::cos(angle));
    scene.add(floor_body(friction));
    scene.add(box_body({0.1, 0.1, 0.1}, 0.5, {0, 0, 0.1}, friction));
    return scene;
  }

  double steepness_;
  BodyState early_{};
  BodyState end_{};
};

/// A ball of 0.1 m starts to slide at 2 m/s without spin and ends up rolling at 5/7 of it. The
/// error is that of the speed after 2 s [m/s].
class Roll : public Trial {
 public:
  Roll() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (now.is(2)) rolling_ = engine.state(1);
    if (now.is(5)) end_ = engine.state(1);
  }

  [[nodiscard]] Outcome outcome() const override {
    const double expected = 5.0 / 7 * speed;
    const double error = std::abs(rolling_.velocity.x() - expected);
    return {error,
            error < 0.01 * expected,
            {{"relative", error / expected},
             {"dv_2_5s", end_.velocity.x() - rolling_.velocity.x()},
             {"slip", rolling_.velocity.x() - rolling_.angular_velocity.y() * 0.1}}};
  }

 private:
  static constexpr double speed = 2;

  static Scene make() {
    Scene scene;
    scene.duration = 5;
    scene.add(floor_body(0.5));
    SceneBody ball = ball_body(0.1, 1, {0, 0, 0.1}, 0.5);
    ball.velocity = {speed, 0, 0};
    scene.add(ball);
    return scene;
  }

  BodyState rolling_{};
  BodyState end_{};
};

}  // namespace bristle::scenes
