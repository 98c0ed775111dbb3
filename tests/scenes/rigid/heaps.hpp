/// @file
/// Many bodies: a pyramid of boxes, a tower of planks, and boxes and balls poured into a bin.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/measures.hpp"

#include <cmath>
#include <random>
#include <utility>

namespace bristle::scenes {

/// A wall-like pyramid of 210 boxes of 0.2 m and 1 kg, 20 in the lowest row, 10 mm apart.
inline Scene pyramid() {
  constexpr int rows = 20;
  Scene scene;
  scene.duration = 10;
  scene.is_large = true;
  scene.add(floor_body(0.5));
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i < rows - row; ++i) {
      scene.add(box_body({0.1, 0.1, 0.1}, 1,
                         {(i - (rows - row - 1) / 2.0) * 0.21, 0, 0.1 + 0.2 * row}, 0.5));
    }
  }
  return scene;
}

/// A tower of 30 layers of four planks of 0.5 m and 5 kg, 10 mm apart, each layer across the last.
inline Scene tower_of_planks() {
  Scene scene;
  scene.duration = 10;
  scene.is_large = true;
  scene.add(floor_body(0.5));
  for (int layer = 0; layer < 30; ++layer) {
    const double height = 0.05 + 0.1 * layer;
    for (int i = 0; i < 4; ++i) {
      const double aside = (i - 1.5) * 0.11;
      scene.add(layer % 2 == 0 ? box_body({0.25, 0.05, 0.05}, 5, {0, aside, height}, 0.5)
                               : box_body({0.05, 0.25, 0.05}, 5, {aside, 0, height}, 0.5));
    }
  }
  return scene;
}

/// Boxes that stand on each other and should not move. The error is the deepest overlap at the end
/// [m].
class StandingHeap : public Trial {
 public:
  explicit StandingHeap(Scene heap) : Trial(std::move(heap)) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (!now.is(scene().duration)) return;
    found_ = overlaps(scene(), engine);
    kinetic_ = total_kinetic_energy(scene(), engine);
    for (std::size_t i = 1; i < scene().bodies.size(); ++i) {
      const Vector moved = engine.state(i).position - scene().bodies[i].position;
      farthest_ = moved.allFinite() ? std::max(farthest_, moved.norm())
                                    : std::numeric_limits<double>::infinity();
    }
  }
  [[nodiscard]] Outcome outcome() const override {
    return {found_.largest,
            found_.largest < 0.02 && farthest_ < 0.1,
            {{"mean_depth", found_.mean}, {"KE_end", kinetic_}, {"max_move", farthest_}}};
  }

 private:
  Overlaps found_{};
  double kinetic_ = 0;
  double farthest_ = 0;
};

/// Boxes of 0.16 m and balls of 0.2 m, 1 kg each, fall into a bin of 1.6 m and lie there after 5 s.
/// The error is the deepest overlap then [m].
class Pile : public Trial {
 public:
  explicit Pile(int count) : Trial(make(count)) {}

  void observe(const Engine& engine, const Instant& now) override {
    if (now.is(1)) early_depth_ = overlaps(scene(), engine).largest;
    if (!now.is(scene().duration)) return;
    found_ = overlaps(scene(), engine);
    kinetic_ = total_kinetic_energy(scene(), engine);
    escaped_ = 0;
    for (std::size_t i = first_moving; i < scene().bodies.size(); ++i) {
      const Vector p = engine.state(i).position;
      const bool is_inside = std::abs(p.x()) <= half_width && std::abs(p.y()) <= half_width &&
                             p.z() >= 0 && p.z() <= 8;
      if (!is_inside) ++escaped_;
    }
  }
  [[nodiscard]] Outcome outcome() const override {
    return {found_.largest,
            found_.largest < 0.02 && escaped_ == 0,
            {{"mean_depth", found_.mean},
             {"depth_1s", early_depth_},
             {"KE_end", kinetic_},
             {"escaped", escaped_}}};
  }

 private:
  static constexpr double half_width = 0.8;
  static constexpr std::size_t first_moving = 5;

  static Scene make(int count) {
    Scene scene;
    scene.duration = 5;
    scene.is_large = true;
    scene.add(floor_body(0.5));
    for (const Vector& side :
         {Vector(1, 0, 0), Vector(-1, 0, 0), Vector(0, 1, 0), Vector(0, -1, 0)}) {
      const Vector half(side.x() != 0 ? 0.5 : half_width + 1, side.y() != 0 ? 0.5 : half_width + 1,
                        5);
      scene.add(box_body(half, 0, (half_width + 0.5) * side + Vector(0, 0, 5), 0.5));
    }
    std::mt19937 engine(42);
    std::uniform_real_distribution<double> jitter(-0.01, 0.01);
    for (int i = 0; i < count; ++i) {
      const int layer = i / 49;
      const int cell = i % 49;
      const double x = (cell % 7 - 3) * 0.22 + jitter(engine);
      const double y = (cell / 7 - 3) * 0.22 + jitter(engine);
      const Vector p(x, y, 0.15 + layer * 0.23);
      scene.add(i % 2 != 0 ? box_body({0.08, 0.08, 0.08}, 1, p, 0.5) : ball_body(0.1, 1, p, 0.5));
    }
    return scene;
  }

  Overlaps found_{};
  double early_depth_ = 0;
  double kinetic_ = 0;
  double escaped_ = 0;
};

}  // namespace bristle::scenes
