/// @file
/// Scenes of SimBenchmark (Kang and Hwangbo, 2018) with its parameters and error measures, so that
/// figures can be held against the published ones.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"

#include <cmath>
#include <random>

namespace bristle::scenes {

/// 25 balls on a plate that is pulled by 150 N, along y or 30 degrees off it. Plate and balls
/// accelerate uniformly; the error is the mean over the steps of the squared errors of the
/// velocities of the plate and of one ball [m^2/s^2].
class PulledPlate : public Trial {
 public:
  explicit PulledPlate(bool is_oblique)
      : Trial(make()),
        direction_(is_oblique ? Vector(0.5, 0.866025403784439, 0) : Vector(0, 1, 0)) {}

  void push(Engine& engine, const Instant&) const override { engine.push(1, pull * direction_); }
  void observe(const Engine& engine, const Instant& now) override {
    const Vector plate = engine.state(1).velocity;
    const Vector ball = engine.state(2).velocity;
    if (now.time > scene().duration - now.dt / 2) {
      plate_end_ = plate.dot(direction_) / (plate_acceleration * now.time) - 1;
      ball_end_ = ball.dot(direction_) / (ball_acceleration * now.time) - 1;
      return;
    }
    sum_ += (ball - ball_acceleration * now.time * direction_).squaredNorm() +
            (plate - plate_acceleration * now.time * direction_).squaredNorm();
    ++count_;
  }
  [[nodiscard]] Outcome outcome() const override {
    const double error = sum_ / static_cast<double>(count_);
    return {error, error < 1e-2, {{"plate_v_end", plate_end_}, {"ball_v_end", ball_end_}}};
  }

 private:
  static constexpr double pull = 150;
  static constexpr double drag = 0.4 * (10 + 25) * earth_gravity;
  // The friction f of a ball on the plate accelerates the ball by f/m and, with 2/5 m r^2, its
  // surface by 7/2 f/m; both surfaces move alike, and 25 balls hold the plate back.
  static constexpr double ball_force = (pull - drag) / 10 / (3.5 + 25.0 / 10);
  static constexpr double plate_acceleration = (pull - drag - 25 * ball_force) / 10;
  static constexpr double ball_acceleration = ball_force;

  static Scene make() {
    Scene scene;
    scene.duration = 4;
    // Pairs: plane and plate 0.4, plate and ball 0.8.
    SceneBody ground = floor_body(0.25);
    ground.friction_if_maximum = 0.4;
    ground.friction_if_minimum = 0.4;
    scene.add(ground);
    SceneBody plate = box_body({10, 10, 0.5}, 10, {0, 0, 0.5 - 2e-5}, 0.64);
    plate.friction_if_maximum = 0.4;
    plate.friction_if_minimum = 0.8;
    scene.add(plate);
    for (int i = 0; i < 5; ++i) {
      for (int j = 0; j < 5; ++j) {
        SceneBody ball = ball_body(0.5, 1, {i * 2.0 - 4, j * 2.0 - 4, 1.5 - 6e-5}, 1);
        ball.friction_if_maximum = 0.8;
        ball.friction_if_minimum = 0.8;
        scene.add(ball);
      }
    }
    return scene;
  }

  Vector direction_;
  double sum_ = 0;
  long count_ = 0;
  double plate_end_ = 0;
  double ball_end_ = 0;
};

/// The error of scenes that keep their energy: the mean squared change of it [J^2].
class EnergyKept : public Trial {
 public:
  /// @param limit          [1] Largest root of that, relative to the energy, that passes.
  /// @param every_step     Whether every step counts, or one every 10 ms.
  EnergyKept(Scene scene, double limit, bool every_step)
      : Trial(std::move(scene)), limit_(limit), every_step_(every_step) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (!every_step_ && !now.is_sampled()) return;
    const double e = total_energy(scene(), engine);
    if (now.step == 0) at_start_ = e;
    sum_ += (e - at_start_) * (e - at_start_);
    ++count_;
    at_end_ = e / at_start_ - 1;
  }
  [[nodiscard]] Outcome outcome() const override {
    const double error = sum_ / static_cast<double>(count_);
    const double relative = std::sqrt(error) / at_start_;
    return {error, relative < limit_, {{"rms_relative", relative}, {"E_end", at_end_}}};
  }

 private:
  double limit_;
  bool every_step_;
  double at_start_ = 0;
  double at_end_ = 0;
  double sum_ = 0;
  long count_ = 0;
};

/// 49 balls of 10 kg bounce without loss from 4.9 m for 20 s.
[[nodiscard]] inline Scene bouncing_balls() {
  Scene scene;
  scene.duration = 20;
  scene.restitution = 1;
  scene.add(floor_body(0));
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 7; ++j) scene.add(ball_body(0.1, 10, {i * 2.0 - 6, j * 2.0 - 6, 5}, 0));
  }
  return scene;
}

/// 6 x 6 x 6 balls of 0.1 m and 10 kg, 10 mm apart and shaken by up to 1 mm; elastic ones start 1 m
/// above the floor.
[[nodiscard]] inline Scene cube_of_balls(bool is_elastic) {
  Scene scene;
  scene.duration = 10;
  scene.restitution = is_elastic ? 1 : 0;
  scene.is_large = true;
  scene.add(floor_body(0));
  std::mt19937 engine(42);
  std::uniform_real_distribution<double> jitter(0, 0.001);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      for (int k = 0; k < 6; ++k) {
        const double x = i * 0.21 + jitter(engine);
        const double y = j * 0.21 + jitter(engine);
        const double z = k * 0.21 + jitter(engine) + (is_elastic ? 1.101 : 0.101);
        scene.add(ball_body(0.1, 10, {x, y, z}, 0));
      }
    }
  }
  return scene;
}

/// The cube of balls collapses and its balls roll apart. The error is the mean over time of the sum
/// of the squared depths of all pairs [m^2].
class CollapsingCube : public Trial {
 public:
  CollapsingCube() : Trial(cube_of_balls(false)) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (!now.is_sampled()) return;
    sum_ += overlaps(scene(), engine).sum_of_squares;
    ++count_;
  }
  [[nodiscard]] Outcome outcome() const override {
    const double error = sum_ / static_cast<double>(count_);
    return {error, error < 1e-3, {{"rms_depth", std::sqrt(error)}}};
  }

 private:
  double sum_ = 0;
  long count_ = 0;
};

}  // namespace bristle::scenes
