// The scene of the paper's Fig. 7 (b): the box of Fig. 7 is set down on an incline, and stays.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/plate.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace fig7 {

/// One row of the table.
struct Incline {
  double degrees = 20;
  bristle::Law law = bristle::Law::paper;
  double time_step = 1e-3;
  bristle::Integration integration = bristle::Integration::implicit;
  /// Sensors along each side; two carry less than the weight, so that a hard contact must help.
  int per_side = 4;
};

/// How a plate stays.
struct Hold {
  double shift = 0;     // [m] down the incline, where it came to rest
  double expected = 0;  // [m] the same by statics; 0 where there is no closed form
  double drift = 0;     // [m] between beginning and end of the watch
  double jitter = 0;    // [m/s] root mean square of its speed during the watch
};

inline bristle::scenes::PlateDef<double> plate_of(const Incline& incline) {
  bristle::scenes::PlateDef<double> def;
  def.incline = incline.degrees * std::numbers::pi / 180;
  def.options.law = incline.law;
  def.time_step = incline.time_step;
  def.integration = incline.integration;
  def.per_side = incline.per_side;
  def.has_contact = bristle::scenes::plate_rest_depth(def) > 0.5;
  // Set down with its face on the plane, which presses all rays half.
  def.drop = def.has_contact ? 0
                             : -bristle::scenes::plate_ray<double> *
                                   (0.5 - bristle::scenes::plate_rest_depth(def));
  return def;
}

/// Lets the plate settle [s], then watches it [s]. With the paper's mu_V it rings down at 1.6 / s.
inline Hold hold(const Incline& incline, double settle = 20, double watch = 10) {
  const auto def = plate_of(incline);
  auto scene = bristle::scenes::make_plate<double>(def);
  const bristle::Vec3<double> start = scene.position();
  scene.run(settle);
  const bristle::Vec3<double> before = scene.position();
  const long steps = std::lround(watch / incline.time_step);
  double sum = 0;
  for (long i = 0; i < steps; ++i) {
    scene.world.step();
    sum += scene.velocity().squaredNorm();
  }
  Hold result;
  result.shift = before.x() - start.x();
  if (incline.law == bristle::Law::paper && !def.has_contact) {
    result.expected = bristle::scenes::plate_rest_shift(def);
  }
  result.drift = (scene.position() - before).norm();
  result.jitter = std::sqrt(sum / static_cast<double>(steps));
  return result;
}

/// Returns whether it stands still, and within 1 % of its place by statics. The closed form is
/// linear in the plate's tilt on its springs.
inline bool holds(const Hold& hold) {
  return hold.drift < 1e-9 && hold.jitter < 1e-9 &&
         std::abs(hold.shift - hold.expected) < 0.01 * hold.expected;
}

}  // namespace fig7
