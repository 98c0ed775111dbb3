/// @file
/// The 96-case hold matrix: a plate on an incline of 20 degrees, over everything that could shake
/// it.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;
using namespace bristle::scenes;

namespace {

struct HoldCase {
  int per_side;
  double static_friction;
  double stiffness;  // Factor on K_N.
  double damping_ratio;
  SlipReset reset;
  double dt;
};

template <typename Visit>
void for_each_hold(Visit&& visit) {
  for (const int per_side : {4, 10}) {
    for (const double static_friction : {5e3, 2e4, 1e5, 1e6}) {
      for (const double stiffness : {1.0, 1000.0}) {
        for (const double damping_ratio : {0.0, 0.7}) {
          for (const SlipReset reset : {SlipReset::release, SlipReset::drag}) {
            // 1e6 / m only at its large step, and 2e4 / m only at its small one: 96 cases.
            for (const double dt : {1e-3, 1.0 / 60}) {
              if (static_friction == 2e4 && dt > 5e-3) continue;
              if (static_friction == 1e6 && dt < 5e-3) continue;
              visit(HoldCase{per_side, static_friction, stiffness, damping_ratio, reset, dt});
            }
          }
        }
      }
    }
  }
}

struct Drift {
  double moved;    // m, over the second half of the run
  double fastest;  // m/s, likewise
};

Drift drift_of(const HoldCase& c, Integration integration) {
  PlateDef<double> def;
  def.per_side = c.per_side;
  def.incline = 20 * std::numbers::pi / 180;
  def.integration = integration;
  def.time_step = c.dt;
  def.options.reset = c.reset;
  def.parameters.static_friction = c.static_friction;
  def.parameters.normal_stiffness = c.stiffness;
  const double n = c.per_side * c.per_side;
  // zeta = n mu_V / (2 sqrt(mu_S m g m)).
  def.parameters.sliding_friction =
      c.damping_ratio * 2 * def.mass * std::sqrt(c.static_friction * 9.81) / n;
  auto scene = make_plate<double>(def);
  scene.run(4);
  const Vec3<double> start = scene.position();
  Drift drift{0, 0};
  const long steps = std::lround(4 / c.dt);
  for (long i = 0; i < steps; ++i) {
    scene.world.step();
    drift.moved = std::max(drift.moved, (scene.position() - start).norm());
    drift.fastest = std::max(drift.fastest, scene.velocity().norm());
  }
  return drift;
}

}  // namespace

TEST_CASE("hold: 96 cases hold, implicitly and automatically") {
  int cases = 0;
  for_each_hold([&](const HoldCase& c) {
    ++cases;
    for (const Integration integration : {Integration::implicit, Integration::automatic}) {
      const Drift drift = drift_of(c, integration);
      INFO("n = ", c.per_side * c.per_side, ", mu_S = ", c.static_friction, ", K_N = ", c.stiffness,
           ", zeta = ", c.damping_ratio, ", drag: ", c.reset == SlipReset::drag, ", dt = ", c.dt,
           ", automatic: ", integration == Integration::automatic, ", fastest ", drift.fastest);
      // Undamped bristles ring on: .012 of sigma_a after 4 s implicitly, .041 automatically. Damped
      // ones stand.
      const double allowed = c.damping_ratio > 0                    ? 1e-8
                             : integration == Integration::implicit ? 0.03e-3
                                                                    : 0.1e-3;
      CHECK(drift.moved < allowed);
    }
  });
  CHECK(cases == 96);
}

TEST_CASE("hold: 10000 stiff sensors hold at 1/60 s") {
  for (const double damping : {0.0, 50.0}) {
    PlateDef<double> def;
    def.per_side = 100;
    def.incline = 20 * std::numbers::pi / 180;
    def.time_step = 1.0 / 60;
    def.parameters = {1e6, damping, 1e6, 0.1, 1e-3};
    auto scene = make_plate<double>(def);
    scene.run(1);
    const Vec3<double> start = scene.position();
    scene.run(2);
    INFO("K_D = ", damping);
    CHECK((scene.position() - start).norm() < 2e-7);
    CHECK(scene.velocity().norm() < 1e-7);
    CHECK(scene.world.reading(scene.patch).slipping() == 0);
  }
}
