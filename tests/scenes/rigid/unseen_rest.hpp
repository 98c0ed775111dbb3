/// @file
/// Scenes that nothing was tuned on, of things that stand, fall over or come to rest.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"
#include "support/random.hpp"

#include <cmath>
#include <numbers>

namespace bristle::scenes {

using namespace bristle::detail;

/// Bodies that statics says stay where they are. The error is the farthest any centre ever moves
/// from where it was put [m], sampled every 10 ms.
class StaysPut : public Trial {
 public:
  explicit StaysPut(Scene scene) : Trial(std::move(scene)) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (!now.is_sampled() && !now.is(scene().duration)) return;
    for (std::size_t i = 0; i < scene().bodies.size(); ++i) {
      const SceneBody& body = scene().bodies[i];
      if (!body.moves()) continue;
      const BodyState state = engine.state(i);
      const double moved = (state.position - body.position).norm();
      error_ =
          std::isfinite(moved) ? std::max(error_, moved) : std::numeric_limits<double>::infinity();
      turn_ = std::max(turn_, angle_between(state.orientation, body.orientation));
    }
    if (now.is(scene().duration)) kinetic_ = total_kinetic_energy(scene(), engine);
  }
  [[nodiscard]] Outcome outcome() const override {
    return {error_, error_ < 5e-3, {{"turn", turn_}, {"KE_end", kinetic_}}};
  }

 private:
  double error_ = 0;
  double turn_ = 0;
  double kinetic_ = 0;
};

/// Four planks of 0.4 m overhang the edge of a table, each by 0.9 times the most that stands:
/// 0.4 m / (2 k) for plank k from the top. Every group of planks then has its centre 20 mm inside
/// the edge below it.
[[nodiscard]] inline Scene overhanging_planks() {
  constexpr double length = 0.4;
  constexpr double share = 0.9;
  constexpr int count = 4;
  Scene scene;
  scene.duration = 5;
  scene.add(box_body({0.5, 0.5, 0.5}, 0, {-0.5, 0, -0.5}, 0.5));
  double x = -length / 2;
  for (int k = count; k >= 1; --k) {
    x += share * length / (2 * k);
    scene.add(box_body({length / 2, 0.1, 0.05}, 1, {x, 0, 0.05 + 0.1 * (count - k)}, 0.5));
  }
  return scene;
}

/// Two pillars of two blocks carry a beam of 1 kg, and the beam a block of 20 kg off its middle.
[[nodiscard]] inline Scene loaded_lintel() {
  Scene scene;
  scene.duration = 5;
  scene.add(floor_body(0.5));
  for (const double x : {-0.4, 0.4}) {
    for (const double z : {0.15, 0.45}) scene.add(box_body({0.1, 0.1, 0.15}, 1, {x, 0, z}, 0.5));
  }
  scene.add(box_body({0.5, 0.1, 0.03}, 1, {0, 0, 0.63}, 0.5));
  scene.add(box_body({0.1, 0.1, 0.1}, 20, {0.12, 0, 0.76}, 0.5));
  return scene;
}

/// A cube without friction between planes inclined by 30 and 60 degrees, two faces flush with them.
[[nodiscard]] inline Scene wedged_cube() {
  const double angle = std::numbers::pi / 6;
  const Vector right(-std::sin(angle), 0, std::cos(angle));
  const Vector left(std::cos(angle), 0, std::sin(angle));
  Scene scene;
  scene.duration = 5;
  scene.add(floor_body(0, right));
  scene.add(floor_body(0, left));
  SceneBody cube = box_body({0.1, 0.1, 0.1}, 1, 0.1 * (right + left), 0);
  cube.orientation = turn_about(Vector::UnitY(), -angle);
  scene.add(cube);
  return scene;
}

/// A row of ten dominoes of 20 x 100 x 200 mm, 100 mm apart, mu = 0.5; the first is set tipping at
/// 3 rad/s. Nothing bounces, so energy can only be lost, and all must fall. The error is the
/// largest of: energy gained, as a part of the potential energy at the start; the part of the
/// dominoes left standing; the deepest overlap, as a part of the thickness [1].
class Dominoes : public Trial {
 public:
  Dominoes() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    const double e = total_energy(scene(), engine);
    if (now.step == 0) at_start_ = e;
    gain_ = std::max(gain_, (e - at_start_) / (count * earth_gravity * 0.1));
    if (now.is_sampled()) deepest_ = std::max(deepest_, overlaps(scene(), engine).largest);
    if (!now.is(scene().duration)) return;
    int fallen = 0;
    for (std::size_t i = 1; i <= count; ++i) {
      const Vector up = engine.state(i).orientation * Vector::UnitZ();
      if (up.z() < 0.9) ++fallen;
    }
    standing_ = 1 - fallen / static_cast<double>(count);
  }
  [[nodiscard]] Outcome outcome() const override {
    const double error = std::max({gain_, standing_, deepest_ / 0.02});
    return {
        error, error < 0.25, {{"E_gain", gain_}, {"standing", standing_}, {"max_depth", deepest_}}};
  }

 private:
  static constexpr int count = 10;

  static Scene make() {
    Scene scene;
    scene.duration = 3;
    scene.add(floor_body(0.5));
    for (int i = 0; i < count; ++i) {
      scene.add(box_body({0.01, 0.05, 0.1}, 1, {0.1 * i, 0, 0.1}, 0.5));
    }
    // About its lower front edge.
    SceneBody& first = scene.bodies[1];
    first.angular_velocity = {0, 3, 0};
    first.velocity = first.angular_velocity.cross(Vector(-0.01, 0, 0.1));
    return scene;
  }

  double at_start_ = 0;
  double gain_ = 0;
  double standing_ = 1;
  double deepest_ = 0;
};

/// 24 blocks of many sizes, 0.03 to 2.2 kg, are tossed with spin into a bin. The error is the
/// deepest overlap after 4 s [m]; nothing may have left the bin.
class Toss : public Trial {
 public:
  Toss() : Trial(make()) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (!now.is(scene().duration)) return;
    deepest_ = overlaps(scene(), engine).largest;
    kinetic_ = total_kinetic_energy(scene(), engine);
    escaped_ = 0;
    for (std::size_t i = first_moving; i < scene().bodies.size(); ++i) {
      const Vector p = engine.state(i).position;
      const bool is_inside = std::abs(p.x()) < width && std::abs(p.y()) < width && p.z() > 0;
      if (!is_inside) ++escaped_;
    }
  }
  [[nodiscard]] Outcome outcome() const override {
    return {
        deepest_, deepest_ < 0.01 && escaped_ == 0, {{"KE_end", kinetic_}, {"escaped", escaped_}}};
  }

 private:
  static constexpr double width = 0.5;
  static constexpr std::size_t first_moving = 5;

  static Scene make() {
    Scene scene;
    scene.duration = 4;
    scene.add(floor_body(0.5));
    for (const double side : {-1.0, 1.0}) {
      scene.add(box_body({0.5, 2, 2}, 0, {side * (width + 0.5), 0, 2}, 0.5));
      scene.add(box_body({2, 0.5, 2}, 0, {0, side * (width + 0.5), 2}, 0.5));
    }
    test::Random random(2026);
    for (int i = 0; i < 24; ++i) {
      const Vector half = Vector(0.08, 0.08, 0.08) + random.in_cube(0.05);
      const Vector place((i % 2) * 0.5 - 0.25, (i / 2 % 2) * 0.5 - 0.25, 0.35 + (i / 4) * 0.4);
      SceneBody block = box_body(half, 1000 * half.prod(), place, 0.5);
      block.orientation = random.rotation<double>();
      block.velocity = random.in_cube(1.0);
      block.angular_velocity = random.in_cube(5.0);
      scene.add(block);
    }
    return scene;
  }

  double deepest_ = 0;
  double kinetic_ = 0;
  double escaped_ = 0;
};

}  // namespace bristle::scenes
