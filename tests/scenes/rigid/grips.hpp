/// @file
/// Two fingers hold a cube by friction alone, with steady and with pulsing forces.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/trial.hpp"
#include "support/random.hpp"

#include <cmath>
#include <numbers>

namespace bristle::scenes {

using namespace bristle::detail;

/// Fingers of 0.1 kg that slide along x press with 10 N from both sides on a cube of 0.1 m,
/// mu = 0.6: friction carries up to 12 N. Defaults: 0.5 kg, 41 % of that.
struct GripSetup {
  /// [kg] Mass of the cube.
  double mass = 0.5;
  /// [rad] Turn of the cube about x, the axis of the fingers.
  double angle = 0;
  /// [m] Offset of the cube along y.
  double offset = 0;
  /// [1] Amplitude of the fingers' force, as a part of it; frequency 3 Hz.
  double pulse = 0;
  /// [1] Amplitude of a force on the cube along y, as a part of its weight; frequency 5 Hz.
  double side_force = 0;
  /// [rad] Phases of the two.
  double pulse_phase = 0;
  double side_phase = 0;
};

/// [N] Force of a finger, [1] friction of the cube and the fingers.
inline constexpr double grip_force = 10;
inline constexpr double grip_friction = 0.6;

/// [kg] Cube whose weight is this part of the most that friction can carry.
[[nodiscard]] inline double grip_mass(double load) {
  return load * 2 * grip_friction * grip_force / earth_gravity;
}

/// A grip for 10 s; the error is how far the cube is in the end from where it started [m].
class Grip : public Trial {
 public:
  explicit Grip(const GripSetup& setup) : Trial(make(setup)), setup_(setup) {}

  void push(Engine& engine, const Instant& now) const override {
    const double cycle = 2 * std::numbers::pi * now.time;
    const double force = grip_force * (1 + setup_.pulse * std::sin(3 * cycle + setup_.pulse_phase));
    engine.push(0, {force, 0, 0});
    engine.push(1, {-force, 0, 0});
    if (setup_.side_force == 0) return;
    const double side = setup_.side_force * setup_.mass * earth_gravity;
    engine.push(2, {0, side * std::sin(5 * cycle + setup_.side_phase), 0});
  }
  void observe(const Engine& engine, const Instant& now) override {
    if (now.is(1)) early_ = engine.state(2);
    if (now.is(scene().duration)) end_ = engine.state(2);
  }
  [[nodiscard]] Outcome outcome() const override {
    const SceneBody& cube = scene().bodies[2];
    const Vector moved = end_.position - cube.position;
    const double error = moved.norm();
    return {error,
            error < 1e-3,
            {{"slip", -moved.z()},
             {"creep_1_10", (early_.position.z() - end_.position.z()) / 9},
             {"turn", angle_between(end_.orientation, cube.orientation)},
             {"side", std::hypot(moved.x(), moved.y())}}};
  }

 private:
  static Scene make(const GripSetup& setup) {
    constexpr double half = 0.05;
    constexpr double finger = 0.02;
    Scene scene;
    scene.duration = 10;
    for (const double side : {-1.0, 1.0}) {
      SceneBody body =
          box_body({finger, 0.04, 0.04}, 0.1, {side * (half + finger), 0, 1}, grip_friction);
      body.slides_along_x = true;
      scene.add(body);
    }
    SceneBody cube = box_body({half, half, half}, setup.mass, {0, setup.offset, 1}, grip_friction);
    cube.orientation = turn_about(Vector::UnitX(), setup.angle);
    scene.add(cube);
    return scene;
  }

  GripSetup setup_;
  BodyState early_{};
  BodyState end_{};
};

/// A grip whose force pulses by 30 % while the cube is shaken sideways with a tenth of its weight.
/// @param load  [1] Weight, as a part of what friction can carry when the fingers press least.
/// @param seed  Of the phases, of a turn up to 15 degrees, and of an offset up to 1 mm: little
/// enough
///              that the torque about the fingers' axis leaves friction for the load.
[[nodiscard]] inline GripSetup pulsed_grip(double load, std::uint64_t seed) {
  constexpr double pulse = 0.3;
  test::Random random(seed);
  GripSetup setup;
  setup.mass = grip_mass(load * (1 - pulse));
  setup.angle = random.uniform(-1.0, 1.0) * std::numbers::pi / 12;
  setup.offset = random.uniform(-0.001, 0.001);
  setup.pulse = pulse;
  setup.side_force = 0.1;
  setup.pulse_phase = random.uniform(0.0, 2 * std::numbers::pi);
  setup.side_phase = random.uniform(0.0, 2 * std::numbers::pi);
  return setup;
}

}  // namespace bristle::scenes
