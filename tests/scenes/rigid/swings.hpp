/// @file
/// Contacts about which bodies turn: a pinched plate that swings, a row of dominoes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace bristle::scenes {

using namespace bristle::detail;

/// A plate of 0.1 x 0.2 m and 0.2 kg hangs between two hard balls that press on it with 20 N near
/// its upper edge, mu = 0.8, and swings from 0.5 rad for 10 s. Each ball touches it in a point, so
/// nothing brakes it: the error is the relative change of its amplitude [1], from the angles of its
/// last turning points, and 1 when it is lost.
class PinchedPlate : public Trial {
 public:
  PinchedPlate() : Trial(make()) {}

  void push(Engine& engine, const Instant&) const override {
    engine.push(0, {force, 0, 0});
    engine.push(1, {-force, 0, 0});
  }
  void observe(const Engine& engine, const Instant& now) override {
    const BodyState plate = engine.state(2);
    const Rotation turn = plate.orientation;
    const double angle = 2 * std::atan2(turn.x(), turn.w());
    // The last two seconds hold two turning points.
    if (now.time > scene().duration - 2) amplitude_ = std::max(amplitude_, std::abs(angle));
    const Vector pivot = plate.position + turn * Vector(0, 0, arm);
    slip_ = std::max(slip_, pivot.norm());
    if (!(pivot.norm() < 0.05)) is_lost_ = true;
  }
  [[nodiscard]] Outcome outcome() const override {
    const double error = is_lost_ ? 1 : std::abs(amplitude_ / start - 1);
    return {error, error < 0.02, {{"amplitude", amplitude_ / start}, {"pivot_slip", slip_}}};
  }

 private:
  static constexpr double start = 0.5;
  static constexpr double arm = 0.08;
  static constexpr double force = 20;

  static Scene make() {
    constexpr double friction = 0.8;
    constexpr double radius = 0.01;
    constexpr double half = 0.005;
    Scene scene;
    scene.duration = 10;
    for (const double side : {-1.0, 1.0}) {
      SceneBody finger = ball_body(radius, 0.1, {side * (half + radius), 0, 0}, friction);
      finger.slides_along_x = true;
      scene.add(finger);
    }
    const Rotation turn = turn_about(Vector::UnitX(), start);
    SceneBody plate = box_body({half, 0.05, 0.1}, 0.2, turn * Vector(0, 0, -arm), friction);
    plate.orientation = turn;
    scene.add(plate);
    return scene;
  }

  double amplitude_ = 0;
  double slip_ = 0;
  bool is_lost_ = false;
};

/// 20 dominoes of 20 x 100 x 200 mm, 0.1 m apart, mu = 0.5; the first is pushed over. The error is
/// the relative difference of the mean interval at which the later half of them falls from that of
/// the same engine at fine steps [1]; 1 when one stays up.
class TopplingRow : public Trial {
 public:
  TopplingRow() : Trial(make()), times_(count, -1) {}

  void observe(const Engine& engine, const Instant& now) override {
    for (std::size_t i = 0; i < count; ++i) {
      const double lean =
          std::acos(std::clamp((engine.state(i + 1).orientation * Vector::UnitZ()).z(), -1.0, 1.0));
      if (times_[i] < 0 && lean >= mark && now.step > 0) {
        // Between the two steps around it.
        times_[i] = now.time - now.dt * (lean - mark) / std::max(lean - leans_[i], 1e-12);
      }
      leans_[i] = lean;
    }
  }
  void compare(const Trial& reference) override {
    reference_ = dynamic_cast<const TopplingRow&>(reference).interval();
  }
  [[nodiscard]] Outcome outcome() const override {
    const double found = interval();
    const double error = found > 0 && reference_ > 0 ? std::abs(found / reference_ - 1) : 1;
    return {error, error < 0.05, {{"interval", found}, {"reference", reference_}}};
  }

 private:
  static constexpr std::size_t count = 20;
  /// [rad] Lean at which one counts as falling.
  static constexpr double mark = 0.2;

  static Scene make() {
    Scene scene;
    scene.duration = 3;
    scene.add(floor_body(0.5));
    for (std::size_t i = 0; i < count; ++i) {
      const double x = 0.1 * static_cast<double>(i);
      scene.add(box_body({0.01, 0.05, 0.1}, 1, {x, 0, 0.1}, 0.5));
    }
    // About its lower front edge.
    SceneBody& first = scene.bodies[1];
    first.angular_velocity = {0, 3, 0};
    first.velocity = first.angular_velocity.cross(Vector(-0.01, 0, 0.1));
    return scene;
  }

  /// [s] Mean interval of the later half; 0 when one stays up.
  [[nodiscard]] double interval() const {
    if (std::ranges::any_of(times_, [](double t) { return t < 0; })) return 0;
    return (times_[count - 1] - times_[count / 2]) / (count - 1 - count / 2);
  }

  std::vector<double> times_;
  std::vector<double> leans_ = std::vector<double>(count, 0);
  double reference_ = 0;
};

}  // namespace bristle::scenes
