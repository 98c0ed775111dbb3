/// @file
/// 192 drops onto sensors: whatever the constants, nothing ever has more energy than it started
/// with.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"
#include "support/momentum.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

using namespace bristle;
using namespace bristle::scenes;

namespace {

struct DropCase {
  double tilt;  // rad
  double stiffness;
  double static_friction;
  double normal_damping;
  NormalDirection normal;
  SlipReset reset;
  double dt;
};

template <typename Visit>
void for_each_drop(Visit&& visit) {
  for (const double tilt : {0.0, 0.1}) {
    for (const double stiffness : {1.0, 1e3, 1e5}) {
      for (const double static_friction : {5e3, 1e6}) {
        for (const double normal_damping : {0.0, 0.05}) {
          for (const NormalDirection normal : {NormalDirection::ray, NormalDirection::gradient}) {
            for (const SlipReset reset : {SlipReset::release, SlipReset::drag}) {
              for (const double dt : {1e-3, 1.0 / 60}) {
                visit(
                    DropCase{tilt, stiffness, static_friction, normal_damping, normal, reset, dt});
              }
            }
          }
        }
      }
    }
  }
}

/// Highest energy, relative to the initial one, over 1.5 s from 30 mm with spin.
double highest_energy(const DropCase& c, Integration integration) {
  PlateDef<double> def;
  def.time_step = c.dt;
  def.integration = integration;
  def.drop = 0.03;
  def.parameters = {c.stiffness, c.normal_damping, c.static_friction, 0.1, 1e-3};
  def.options.normal = c.normal;
  def.options.reset = c.reset;
  auto scene = make_plate<double>(def);
  Transform<double> X = scene.world.pose(scene.plate);
  X.rotation = exp_rotation<double>({0, c.tilt, 0});
  scene.world.set_pose(scene.plate, X);
  scene.world.set_velocity(scene.plate, {{0.3, -0.1, 0}, {0.5, 0.2, 3}});
  const std::array<BodyId, 1> bodies{scene.plate};
  const auto energy = [&] { return test::energy_of(scene.world, std::span<const BodyId>(bodies)); };
  const double initial = energy();
  double highest = 0;
  const long steps = std::lround(1.5 / c.dt);
  for (long i = 0; i < steps; ++i) {
    scene.world.step();
    const double now = energy();
    REQUIRE(std::isfinite(now));
    highest = std::max(highest, now);
  }
  return highest / initial;
}

}  // namespace

TEST_CASE("drop: 192 drops never gain energy (R18)") {
  int cases = 0;
  for_each_drop([&](const DropCase& c) {
    ++cases;
    for (const Integration integration : {Integration::implicit, Integration::automatic}) {
      INFO("tilt = ", c.tilt, ", K_N = ", c.stiffness, ", mu_S = ", c.static_friction,
           ", K_D = ", c.normal_damping, ", gradient: ", c.normal == NormalDirection::gradient,
           ", drag: ", c.reset == SlipReset::drag, ", dt = ", c.dt,
           ", automatic: ", integration == Integration::automatic);
      CHECK(highest_energy(c, integration) <= 1 + 1e-12);
    }
  });
  CHECK(cases == 192);
}
