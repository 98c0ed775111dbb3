/// @file
/// A plate on its bristles is an oscillator: its frequency and its overshoot.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"
#include "support/integrations.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::both_integrations;
using namespace bristle::scenes;

namespace {

/// Undamped plate that does not tilt: mass m on a spring of mu_S m g.
PlateDef<double> oscillator(Integration integration, double dt) {
  PlateDef<double> def;
  def.integration = integration;
  def.time_step = dt;
  def.inertia_factor = 1e6;
  def.parameters.sliding_friction = 0;
  return def;
}

/// [Hz] From the first to the last upward crossing of x = 0 within `seconds`, interpolated.
double measured_frequency(PlateScene<double>& scene, double seconds) {
  scene.world.set_velocity(scene.plate, {{0.02, 0, 0}, {0, 0, 0}});
  const long steps = std::lround(seconds / scene.def.time_step);
  double first = 0;
  double last = 0;
  int periods = -1;
  // Away from the start, where the bristles are not anchored yet.
  scene.run(0.02);
  for (long i = 0; i < steps; ++i) {
    const double before = scene.position().x();
    scene.world.step();
    const double after = scene.position().x();
    if (before < 0 && after >= 0) {
      last = (static_cast<double>(i) + before / (before - after)) * scene.def.time_step;
      if (periods < 0) first = last;
      ++periods;
    }
  }
  return periods / (last - first);
}

}  // namespace

TEST_CASE("vibration: the tangential frequency is sqrt(mu_S g) / 2 pi, whatever n and m (R2)") {
  const double closed = std::sqrt(5000 * 9.81) / (2 * std::numbers::pi);
  CHECK(closed == test::relative(35.2484).epsilon(2e-6));
  struct Row {
    double dt;
    double tolerance;
  };
  // The step shifts the phase: symplectic Euler by (omega dt)^2 / 24 = 0.2 % at 1 ms.
  for (const Row row : {Row{1e-4, 2e-4}, Row{1e-3, 3e-3}}) {
    for (const Integration integration : both_integrations) {
      auto scene = make_plate<double>(oscillator(integration, row.dt));
      CHECK(measured_frequency(scene, 2) == test::relative(closed).epsilon(row.tolerance));
    }
  }
  PlateDef<double> other = oscillator(Integration::implicit, 1e-4);
  other.per_side = 6;
  other.mass = 1.25;
  auto scene = make_plate<double>(other);
  CHECK(measured_frequency(scene, 1) == test::relative(closed).epsilon(2e-4));
}

TEST_CASE("vibration: a sudden force overshoots to twice its static stretch (R3)") {
  // An undamped spring k = mu_S m g under F: peak 2 F / k.
  const double peak = 2 * 5 / (5000 * 0.5 * 9.81);
  CHECK(peak == test::relative(0.407747e-3).epsilon(1e-6));
  struct Row {
    double dt;
    double tolerance;
  };
  for (const Row row : {Row{1e-4, 1e-4}, Row{1e-3, 1e-2}}) {
    for (const Integration integration : both_integrations) {
      auto scene = make_plate<double>(oscillator(integration, row.dt));
      // One step, so that the bristles are anchored where the plate stands.
      scene.world.step();
      double measured = 0;
      for (double t = 0; t < 0.03; t += row.dt) {
        scene.push_at_center({5, 0, 0});
        scene.world.step();
        measured = std::max(measured, scene.position().x());
      }
      CHECK(measured == test::relative(peak).epsilon(row.tolerance));
    }
  }
}

TEST_CASE("vibration: along the rays, the frequency is sqrt(n K_N / (L m)) / 2 pi") {
  const double closed = std::sqrt(16 / (0.01 * 0.5)) / (2 * std::numbers::pi);
  for (const Integration integration : both_integrations) {
    PlateDef<double> def;
    def.integration = integration;
    def.time_step = 1e-5;
    def.parameters = {1, 0, 0, 0, 1e-3};
    auto scene = make_plate<double>(def);
    const double rest = scene.position().z();
    scene.world.set_velocity(scene.plate, {{0, 0, 0.02}, {0, 0, 0}});
    // Half a period later it is back, then down; the implicit normal part is damped a little.
    std::vector<double> crossings;
    double lowest = 0;
    for (int i = 0; i < 20000; ++i) {
      const double before = scene.position().z() - rest;
      scene.world.step();
      const double after = scene.position().z() - rest;
      if (before < 0 && after >= 0) crossings.push_back((i + before / (before - after)) * 1e-5);
      lowest = std::min(lowest, after);
    }
    REQUIRE(crossings.size() >= 1);
    CHECK(1 / crossings.front() == test::relative(closed).epsilon(2e-3));
    CHECK(lowest == test::relative(-0.02 / (2 * std::numbers::pi * closed)).epsilon(1e-2));
  }
}
