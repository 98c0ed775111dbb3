/// @file
/// Friction of an implicit patch follows the load within the step, not one step behind.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"

#include <doctest/doctest.h>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("implicit_friction: is bounded by mu times the normal force of the same step") {
  // The load doubles from one step to the next while the plate slides: drag then is mu_S sigma_a
  // times what the sensors read as their normal force, in that very step.
  PlateDef<double> def;
  def.time_step = 1.0 / 60;
  def.inertia_factor = 1e6;
  def.options.reset = SlipReset::drag;
  def.parameters = {1, 0.5, 5000, 0, 1e-3};
  auto scene = make_plate<double>(def);
  scene.run(0.2);
  scene.world.set_velocity(scene.plate, {{10, 0, 0}, {0, 0, 0}});
  scene.world.step();
  for (int i = 0; i < 4; ++i) {
    scene.push_at_plane({24.525, 0, 0});
    scene.push_at_center({0, 0, i % 2 == 0 ? -4.0 : 0.0});
    scene.world.step();
    const auto r = scene.world.reading(scene.patch);
    REQUIRE(r.slipping() == 16);
    CHECK(r.total_shear() == doctest::Approx(5 * r.total_normal()).epsilon(5e-3));
  }
}
