/// @file
/// Scenes that nothing was tuned on, of things that move: each with a closed form or an invariant.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"

#include <cmath>
#include <numbers>

namespace bristle::scenes {

using namespace bristle::detail;

/// A body that moves along x as a closed form says; the error is the relative one of the distance
/// at the end [1].
class KnownDistance : public Trial {
 public:
  KnownDistance(Scene scene, std::size_t body, double distance)
      : Trial(std::move(scene)), body_(body), distance_(distance) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (!now.is(scene().duration)) return;
    moved_ = engine.state(body_).position - scene().bodies[body_].position;
  }
  [[nodiscard]] Outcome outcome() const override {
    const double error = std::abs(moved_.x() / distance_ - 1);
    return {error, error < 0.02, {{"x", moved_.x()}, {"y", moved_.y()}, {"z", moved_.z()}}};
  }

 private:
  std::size_t body_;
  double distance_;
  Vector moved_ = Vector::Zero();
};

/// A ball of 0.1 m rolls for 2 s down a V groove of two planes at 45 degrees, itself inclined by 20
/// degrees, mu = 0.5.
///
/// It turns about the line through its two points of contact, d = r cos 45 below its centre:
/// a = g sin(20) / (1 + 2/5 r^2 / d^2) = g sin(20) / 1.8.
class GrooveRoll : public KnownDistance {
 public:
  GrooveRoll() : KnownDistance(make(), 2, 0.5 * earth_gravity * std::sin(slope) / 1.8 * 4) {}

 private:
  static constexpr double slope = std::numbers::pi / 9;

  static Scene make() {
    const double c = std::numbers::sqrt2 / 2;
    Scene scene;
    scene.duration = 2;
    scene.gravity = earth_gravity * Vector(std::sin(slope), 0, -std::cos(slope));
    scene.add(floor_body(0.5, {0, -c, c}));
    scene.add(floor_body(0.5, {0, c, c}));
    scene.add(ball_body(0.1, 1, {0, 0, 0.1 / c}, 0.5));
    return scene;
  }
};

/// A plank of 2 kg on four balls of 0.5 kg rolls for 1 s down an incline of 5 degrees, mu = 0.8.
///
/// The balls go half as fast as the plank: with M of the plank and m of all balls,
/// a = g sin(5) (M + m/2) / (M + 7/5 m/4).
class Rollers : public KnownDistance {
 public:
  Rollers() : KnownDistance(make(), 5, 0.5 * earth_gravity * std::sin(slope) * 3 / 2.7) {}

 private:
  static constexpr double slope = std::numbers::pi / 36;

  static Scene make() {
    Scene scene;
    scene.duration = 1;
    scene.gravity = earth_gravity * Vector(std::sin(slope), 0, -std::cos(slope));
    scene.add(floor_body(0.8));
    for (const double x : {-0.3, 0.3}) {
      for (const double y : {-0.1, 0.1}) scene.add(ball_body(0.05, 0.5, {x, y, 0.05}, 0.8));
    }
    scene.add(box_body({0.6, 0.2, 0.02}, 2, {0, 0, 0.12}, 0.8));
    return scene;
  }
};

/// A box of 0.5 kg on a floor, mu = 0.5, is pulled with a force that grows by m mu g each second.
/// It lets go after 1 s, and x = k (t - 1)^3 / (6 m) then.
class Tug : public KnownDistance {
 public:
  Tug() : KnownDistance(make(), 1, growth * 8 / (6 * mass)) {}

  void push(Engine& engine, const Instant& now) const override {
    // The mean force of the step, so that the steps add up to the impulse of the ramp.
    engine.push(1, {growth * (now.time + 0.5 * now.dt), 0, 0});
  }

 private:
  static constexpr double mass = 0.5;
  static constexpr double growth = mass * 0.5 * earth_gravity;

  static Scene make() {
    Scene scene;
    scene.duration = 3;
    scene.add(floor_body(0.5));
    scene.add(box_body({0.1, 0.1, 0.1}, mass, {0, 0, 0.1}, 0.5));
    return scene;
  }
};

/// A coin of 0.1 m radius rolls on its edge, leaning 10 degrees, at 3 m/s, mu = 1. That is too fast
/// to fall over (an upright disk is stable from sqrt(g r / 3) on), and rolling loses nothing. The
/// error is the largest relative change of its energy in 1 s [1].
class Coin : public Trial {
 public:
  Coin() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    const BodyState coin = engine.state(1);
    const double e = energy(scene(), scene().bodies[1], coin);
    if (now.step == 0) at_start_ = e;
    at_end_ = e / at_start_ - 1;
    error_ = std::max(error_, std::abs(at_end_));
    lowest_ = std::max(lowest_, depth(scene().bodies[0], BodyState{}, scene().bodies[1], coin));
  }
  [[nodiscard]] Outcome outcome() const override {
    return {error_, error_ < 0.05, {{"E_end", at_end_}, {"max_depth", lowest_}}};
  }

 private:
  static Scene make() {
    constexpr double radius = 0.1;
    constexpr double half = 0.005;
    const double lean = std::numbers::pi / 18;
    Scene scene;
    scene.duration = 1;
    scene.add(floor_body(1));
    SceneBody coin;
    coin.shape = Cylinder<double>{radius, half};
    coin.mass = 0.5;
    coin.friction = 1;
    // Its axis lies along x and then dips by the lean; the lowest point of the rim is on the floor.
    coin.orientation = turn_about(Vector::UnitY(), std::numbers::pi / 2 + lean);
    const Vector axis = coin.orientation * Vector::UnitZ();
    const Vector down = -(Vector::UnitZ() - axis.z() * axis).normalized();
    const Vector rim = radius * down + (axis.z() < 0 ? half : -half) * axis;
    coin.position = {0, 0, -rim.z()};
    // The point of contact stands still.
    coin.angular_velocity = 30 * axis;
    coin.velocity = rim.cross(coin.angular_velocity);
    scene.add(coin);
    return scene;
  }

  double at_start_ = 0;
  double at_end_ = 0;
  double error_ = 0;
  double lowest_ = 0;
};

/// Newton's cradle without its strings: a ball at 1 m/s hits four that touch, no gravity, no
/// friction, no loss. The law of impact decides which balls move afterwards, but momentum and
/// energy are kept: the error is the larger relative change of the two [1].
class Cradle : public Trial {
 public:
  Cradle() : Trial(make()) {}

  void observe(const Engine& engine, const Instant&) override {
    double p = 0;
    double e = 0;
    for (std::size_t i = 0; i < scene().bodies.size(); ++i) {
      const BodyState ball = engine.state(i);
      p += ball.velocity.x();
      e += kinetic_energy(scene().bodies[i], ball);
      last_ = ball.velocity.x();
    }
    error_ = std::max({error_, std::abs(p - 1), std::abs(2 * e - 1)});
    energy_ = 2 * e - 1;
  }
  [[nodiscard]] Outcome outcome() const override {
    return {error_, error_ < 0.02, {{"E_end", energy_}, {"v_last", last_}}};
  }

 private:
  static Scene make() {
    Scene scene;
    scene.duration = 1;
    scene.gravity = Vector::Zero();
    scene.restitution = 1;
    SceneBody striker = ball_body(0.1, 1, {-0.5, 0, 0}, 0);
    striker.velocity = {1, 0, 0};
    scene.add(striker);
    for (int i = 0; i < 4; ++i) scene.add(ball_body(0.1, 1, {0.2 * i, 0, 0}, 0));
    return scene;
  }

  double error_ = 0;
  double energy_ = 0;
  double last_ = 0;
};

}  // namespace bristle::scenes
