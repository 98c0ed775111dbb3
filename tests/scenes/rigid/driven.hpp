/// @file
/// Bodies that are pushed, carried and turned over by bodies that follow a path.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/watched.hpp"
#include "support/random.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace bristle::scenes {

/// A block of cubes of 0.2 m, three deep and two high, 0.1 to 10 kg, on a floor, mu = 0.6. A plate
/// comes at 0.3 m/s, slightly obliquely and turning by 0.1 rad/s, and pushes them for 5 s: all
/// contacts slide.
/// @param rows  Rows of six cubes along the way of the plate.
[[nodiscard]] inline Scene pushed_boxes(int rows, std::uint64_t seed = 2) {
  constexpr double friction = 0.6;
  test::Random random(seed);
  Scene scene;
  scene.duration = 5;
  scene.is_large = true;
  scene.add(floor_body(friction));
  for (int x = 0; x < rows; ++x) {
    for (int y = 0; y < 3; ++y) {
      for (int z = 0; z < 2; ++z) {
        const double mass = std::pow(10, random.uniform(-1.0, 1.0));
        const double shift = random.uniform(-0.002, 0.002);
        SceneBody cube = box_body({0.1, 0.1, 0.1}, mass,
                                  {0.205 * x + shift, 0.205 * y, 0.1 + 0.2 * z}, friction);
        cube.orientation = turn_about(Vector::UnitZ(), random.uniform(-0.02, 0.02));
        scene.add(cube);
      }
    }
  }
  scene.add(driven_body(Box<double>{{0.05, 1, 0.3}}, friction, [](double t) -> Place {
    return {Vector(-0.3 + 0.3 * t, 0.2 + 0.05 * t, 0.35), turn_about(Vector::UnitZ(), 0.1 * t)};
  }));
  return scene;
}

/// 48 cubes of 0.2 m and 2 kg, two high, on a belt that runs at 1 m/s, mu = 0.4; a wall across the
/// belt holds them back. They all stand in the end, and the belt slides below them.
[[nodiscard]] inline Scene held_back_on_belt() {
  constexpr double friction = 0.4;
  Scene scene;
  scene.duration = 6;
  scene.is_large = true;
  scene.add(driven_body(Box<double>{{40, 1, 0.05}}, friction, [](double t) -> Place {
    return {Vector(20 + t, 0, -0.05), Rotation::Identity()};
  }));
  for (int i = 0; i < 24; ++i) {
    for (const double z : {0.1, 0.3}) {
      const double x = 0.2005 * (i / 3);
      scene.add(box_body({0.1, 0.1, 0.1}, 2, {x, 0.35 * (i % 3 - 1), z}, friction));
    }
  }
  scene.add(box_body({0.05, 1, 0.5}, 0, {8 * 0.2005 + 0.3, 0, 0.55}, friction));
  return scene;
}

/// A stack of eight boxes, 0.2 x 0.2 x 0.1 m and 1 kg, on a plate that is dragged to and fro with
/// at most 0.15 g, mu = 0.6. Friction holds up to 0.6 g, and the stack would tip at 0.25 g: it
/// rides along. The error is how far a box ever is from its place above the plate [m].
class DraggedStack : public Trial {
 public:
  DraggedStack() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    const double carried = place(now.time).position.x();
    for (std::size_t i = 1; i < scene().bodies.size(); ++i) {
      const Vector home = scene().bodies[i].position + carried * Vector::UnitX();
      const double away = (engine.state(i).position - home).norm();
      error_ =
          std::isfinite(away) ? std::max(error_, away) : std::numeric_limits<double>::infinity();
      if (now.is(scene().duration)) end_ = std::max(end_, away);
    }
  }
  [[nodiscard]] Outcome outcome() const override {
    return {error_, error_ < 5e-3, {{"at_end", end_}}};
  }

 private:
  static constexpr int count = 8;

  /// It starts at rest, and the first cycle of 1 Hz fades in: no jolt.
  static Place place(double t) {
    const double rate = 2 * std::numbers::pi;
    const double reach = 0.15 * earth_gravity / (rate * rate);
    return {Vector(reach * (std::cos(rate * t) - 1), 0, -0.05), Rotation::Identity()};
  }
  static Scene make() {
    Scene scene;
    scene.duration = 5;
    scene.add(driven_body(Box<double>{{0.5, 0.5, 0.05}}, 0.6, place));
    for (int i = 0; i < count; ++i) {
      scene.add(box_body({0.1, 0.1, 0.05}, 1, {0, 0, 0.05 + 0.1 * i}, 0.6));
    }
    return scene;
  }

  double error_ = 0;
  double end_ = 0;
};

/// 60 balls, boxes and capsules of about 0.1 m, mu = 0.5, in a drum of 16 plates, 1 m wide and 0.5
/// m long, that turns about its level axis at 2 rad/s for 5 s.
[[nodiscard]] inline Scene drum() {
  constexpr double friction = 0.5;
  constexpr double radius = 0.5;
  constexpr int plates = 16;
  test::Random random(5);
  Scene scene;
  scene.duration = 5;
  scene.is_large = true;
  for (int i = 0; i < plates; ++i) {
    const double start = 2 * std::numbers::pi * i / plates;
    const double half = (radius + 0.05) * std::tan(std::numbers::pi / plates);
    scene.add(driven_body(Box<double>{{0.025, 0.3, half}}, friction, [start](double t) -> Place {
      // The turn about y takes the x axis of a plate outwards.
      const Rotation turn = turn_about(Vector::UnitY(), start + 2 * t);
      return {turn * Vector(radius + 0.025, 0, 0), turn};
    }));
  }
  for (const double side : {-1.0, 1.0}) {
    scene.add(box_body({0.7, 0.025, 0.7}, 0, {0, side * 0.275, 0}, friction));
  }
  for (int i = 0; i < 60; ++i) {
    const Vector at = {0.16 * (i % 4 - 1.5), 0.13 * (i / 4 % 3 - 1), 0.13 * (i / 12 - 2)};
    const double size = random.uniform(0.04, 0.055);
    SceneBody body = i % 3 == 0   ? ball_body(size, 1, at, friction)
                     : i % 3 == 1 ? box_body({size, 0.8 * size, 0.6 * size}, 1, at, friction)
                                  : capsule_body({0.6 * size, 0.4 * size}, 1, at, friction);
    body.orientation = random.rotation<double>();
    scene.add(body);
  }
  return scene;
}

}  // namespace bristle::scenes
