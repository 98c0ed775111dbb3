// The scene of the paper's Fig. 7 (a): a box on its sensors, pushed by a constant force, goes up
// stairs of sigma_a; and the same motion by its equation.
//
// Between two releases the bristles, all stretched by e, are one spring k = mu_S m g, and
//
//   m e'' + c e' + k e = F,   c = n mu_V;   at e = sigma_a they let go, and e starts again from 0.
//
// In the steady state a stair begins and ends with one speed; over it the spring takes
// k sigma_a^2 / 2, so the mean speed is near (F - F_max / 2) / c with F_max = mu_S sigma_a m g.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/plate.hpp"

#include <algorithm>
#include <cmath>

namespace fig7 {

/// One row of the table.
struct Push {
  /// [1] Force, as a part of F_max.
  double force = 0.51;
  /// [1] Damping ratio of the bristles; the paper's mu_V = 0.1 N s/m is 0.0072.
  double damping_ratio = 0;
  double time_step = 1e-3;
  bristle::Integration integration = bristle::Integration::implicit;
};

/// [1] Damping ratio that the paper's mu_V amounts to.
inline double papers_damping_ratio() { return 16 * 0.1 / (2 * std::sqrt(5000 * 0.5 * 9.81 * 0.5)); }

/// A motion up the stairs.
struct Stairs {
  double height = 0;       // [m]
  double period = 0;       // [s]
  double speed = 0;        // [m/s], mean
  double start_speed = 0;  // [m/s], where a stair begins
};

/// The bristles' motion with the constants of a push.
class StairEquation {
 public:
  explicit StairEquation(const Push& push)
      : frequency_(std::sqrt(stiffness / mass)),
        decay_(push.damping_ratio * frequency_),
        swing_(frequency_ * std::sqrt(1 - push.damping_ratio * push.damping_ratio)),
        rest_(push.force * sigma) {}

  /// The steady state, from the mean speed on: each stair takes the plate closer to it.
  [[nodiscard]] Stairs steady() const {
    const double viscous = 2 * decay_ * mass;
    double speed = std::max((rest_ / sigma - 0.5) * full_load / viscous, 1e-3);
    double period = 0;
    for (int stair = 0; stair < 20000; ++stair) {
      const double last = speed;
      period = duration(last);
      speed = speed_after(period, last);
      if (std::abs(speed - last) < 1e-12 * last) break;
    }
    return {sigma, period, sigma / period, speed};
  }

  static constexpr double mass = 0.5;
  static constexpr double sigma = 1e-3;
  static constexpr double stiffness = 5000 * mass * 9.81;
  static constexpr double full_load = stiffness * sigma;

 private:
  /// Stretch a time after a stair began with a speed.
  [[nodiscard]] double stretch_after(double t, double speed) const {
    const double b = (speed - decay_ * rest_) / swing_;
    return rest_ +
           std::exp(-decay_ * t) * (b * std::sin(swing_ * t) - rest_ * std::cos(swing_ * t));
  }
  [[nodiscard]] double speed_after(double t, double speed) const {
    const double b = (speed - decay_ * rest_) / swing_;
    const double s = std::sin(swing_ * t);
    const double c = std::cos(swing_ * t);
    return std::exp(-decay_ * t) * (swing_ * (b * c + rest_ * s) - decay_ * (b * s - rest_ * c));
  }
  /// Time until the stretch is sigma: by small steps, then by halving.
  [[nodiscard]] double duration(double speed) const {
    const double step = 1e-2 / frequency_;
    double late = step;
    while (stretch_after(late, speed) < sigma && late * frequency_ < 10) late += step;
    double early = late - step;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (early + late);
      (stretch_after(middle, speed) < sigma ? early : late) = middle;
    }
    return late;
  }

  double frequency_;
  double decay_;
  double swing_;
  double rest_;
};

/// The plate at rest on its sensors, for a push.
inline bristle::scenes::PlateScene<double> make_stairs(const Push& push) {
  bristle::scenes::PlateDef<double> def;
  def.time_step = push.time_step;
  def.integration = push.integration;
  // It cannot tilt, so that its equation is the one above.
  def.inertia_factor = 1e6;
  const double critical = 2 * std::sqrt(StairEquation::stiffness * def.mass);
  def.parameters.sliding_friction = push.damping_ratio * critical / 16;
  return bristle::scenes::make_plate<double>(def);
}

/// Pushes for a while, at the height of the plane so that the plate does not lean, from the steady
/// state on, and measures from release to release over the second half.
/// `observe(scene, time)` sees every step.
template <typename Observe>
Stairs climb(const Push& push, double duration, Observe&& observe) {
  auto scene = make_stairs(push);
  scene.world.step();
  const double start_speed = StairEquation(push).steady().start_speed;
  scene.world.set_velocity(scene.plate, {{start_speed, 0, 0}, bristle::Vec3<double>::Zero()});
  const long steps = std::lround(duration / push.time_step);
  const long half = steps / 2;
  // Releases since the first in the second half, and where and when that and the last one were.
  double releases = -1;
  double first_place = 0, last_place = 0, half_place = 0;
  long first_step = 0, last_step = 0;
  for (long i = 0; i < steps; ++i) {
    if (i == half) half_place = scene.position().x();
    scene.push_at_plane({push.force * StairEquation::full_load, 0, 0});
    scene.world.step();
    observe(scene, static_cast<double>(i + 1) * push.time_step);
    // All sixteen sensors are loaded alike, and let go together.
    if (i < half || 2 * scene.world.reading(scene.patch).slipping() < 16) continue;
    if (++releases == 0) {
      first_place = scene.position().x();
      first_step = i;
    }
    last_place = scene.position().x();
    last_step = i;
  }
  Stairs measured;
  measured.speed =
      (scene.position().x() - half_place) / (static_cast<double>(steps - half) * push.time_step);
  if (releases > 0) {
    measured.height = (last_place - first_place) / releases;
    measured.period = static_cast<double>(last_step - first_step) * push.time_step / releases;
  }
  return measured;
}
inline Stairs climb(const Push& push, double duration) {
  return climb(push, duration, [](const auto&, double) {});
}

/// [1] Mean friction of the bristles, as a part of F_max, at a mean speed.
inline double mean_friction(const Push& push, double speed) {
  const double viscous =
      2 * push.damping_ratio * std::sqrt(StairEquation::stiffness * StairEquation::mass);
  return push.force - viscous * speed / StairEquation::full_load;
}

/// Returns whether stairs are as in their equation, up to the resolution of a step.
inline bool is_right(const Push& push, const Stairs& measured, const Stairs& expected) {
  const double steps_a_stair = expected.period / push.time_step;
  if (steps_a_stair < 1.5) {
    // Only the mean friction is left of the stairs.
    return std::abs(mean_friction(push, measured.speed) - mean_friction(push, expected.speed)) <
           0.01;
  }
  const bool is_height_right = std::abs(measured.height - expected.height) < 1e-2 * expected.height;
  // A few steps a stair may stick, which below F_max is as much an equilibrium as sliding.
  if (steps_a_stair < 10) return is_height_right || std::abs(measured.speed) < 1e-6;
  // To a step, since stairs fall into step with it, and to what the damping has not settled.
  return is_height_right &&
         std::abs(measured.period - expected.period) < push.time_step + 0.01 * expected.period;
}

}  // namespace fig7
