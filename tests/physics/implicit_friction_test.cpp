/// @file
/// Friction of an implicit patch follows the load within the step, not one step behind.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"
#include "support/relative.hpp"

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
    CHECK(r.total_shear() == test::relative(5 * r.total_normal()).epsilon(5e-3));
  }
}

TEST_CASE("implicit_friction: models made with the contacts are those made when somebody chose") {
  // Patches that are implicit by definition make them early; of automatic ones it is known late.
  // The same bits, while the plate is pushed, slides and stops.
  PlateDef<double> def;
  auto early = make_plate<double>(def);
  def.integration = Integration::automatic;
  def.explicit_below = 0;
  auto late = make_plate<double>(def);
  std::size_t slips = 0;
  for (int i = 0; i < 400; ++i) {
    for (auto* scene : {&early, &late}) {
      scene->push_at_plane({i < 40 ? 20.0 : 0.0, 0, 0});
      scene->world.step();
    }
    REQUIRE(late.world.report().implicit_pairs == 1);
    REQUIRE(early.world.pose(early.plate).translation == late.world.pose(late.plate).translation);
    REQUIRE(early.world.reading(early.patch).shear_W == late.world.reading(late.patch).shear_W);
    slips += early.world.reading(early.patch).slipping();
  }
  CHECK(slips > 0);
  CHECK(early.world.reading(early.patch).slipping() == 0);
}

TEST_CASE("implicit_friction: two patches that are explicit alone are implicit on one body") {
  // Each has Lambda = dt^2 K_N w / L = 0.3, below 0.5; a body that both press feels twice that.
  // Half a side from the middle of a cube the mean mobility is w = 2 / m: r^2 / I = 3 / (2 m) for
  // two axes.
  const auto step = [](int patches) {
    WorldDef<double> world_def;
    world_def.gravity.setZero();
    world_def.time_step = 1e-3;
    World<double> world(world_def);
    BodyDef<double> pressed;
    pressed.mass = 1;
    pressed.shape = Box<double>{{0.1, 0.1, 0.1}};
    world.add_body(pressed);
    for (int i = 0; i < patches; ++i) {
      BodyDef<double> pad;
      pad.motion = Motion::fixed;
      pad.shape = Box<double>{{0.02, 0.02, 0.02}};
      pad.position = {0, 0, i == 0 ? -0.125 : 0.125};  // 5 mm from the pressed box.
      PatchDef<double> patch;
      patch.sensors.add(Vec3<double>::Zero(), {0, 0, i == 0 ? 1.0 : -1.0}, 0.03);
      patch.parameters = {4500, 0, 1, 0, 1e-3};
      patch.integration = Integration::automatic;
      world.add_patch(world.add_body(pad), patch);
    }
    world.step();
    return world.report();
  };
  CHECK(step(1).explicit_pairs == 1);
  CHECK(step(2).implicit_pairs == 2);
}
