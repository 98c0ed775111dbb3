/// @file
/// Bodies between a floor and a plate that comes down on them, which no solver can keep apart.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/crushed.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

using namespace bristle;

TEST_CASE("crushing: a body between two that nothing stops is pressed by a bounded impulse") {
  for (const double dt : {1.0 / 60, 1.0 / 1000}) {
    for (const Shape<double>& shape :
         {Shape<double>(Box<double>{{0.1, 0.1, 0.1}}), Shape<double>(Sphere<double>{0.1})}) {
      CAPTURE(dt);
      scenes::Crushed one = scenes::CrushedTowers{.shape = shape}.make(dt, 0, 1.5);
      one.run(1.5);
      // Ten times what stops a body of 1 kg, at most as fast as the plate, and brings it to the
      // plate's speed, with the fall of one step.
      const double most = 10 * (0.1 + 0.1 + 9.81 * dt);
      CHECK(one.largest_impulse > 0.1 * most);
      CHECK(one.largest_impulse <= most * (1 + 1e-6));
      // It is between both, and goes no faster than the plate.
      CHECK(one.fastest <= 0.1 * (1 + 1e-6));
      CHECK(one.largest_gain < 0.5 * 0.1 * 0.1);
      // What was pressed together comes to rest once it is let go.
      one.run(2);
      CHECK(one.world.body(one.bodies[0]).twist.linear.norm() < 1e-6);
      CHECK(one.world.pose(one.bodies[0]).translation.z() == test::relative(0.1).epsilon(1e-3));
    }
  }
}

TEST_CASE(
    "crushing: towers that are crushed are not thrown out, whatever shape and step they have") {
  struct Run {
    scenes::CrushedTowers towers;
    double dt;
    std::vector<double> asides = {0.0, 1e-5, 1e-4};
    double share = 0.8;  // [1] Of the height that the plate goes through.
  };
  // Small ones are factorised, wide ones swept.
  const Run runs[] = {
      {{.layers = 3, .shape = Sphere<double>{0.1}}, 1.0 / 240},
      {{.side = 2, .layers = 2}, 1.0 / 60},
      {{.side = 3, .layers = 3, .speed = 0.3}, 1.0 / 240},
      {{.side = 4, .layers = 3}, 1.0 / 60},
      {{.side = 3, .layers = 3}, 1.0 / 60, {2.4e-6}},
      {{.side = 5, .layers = 5, .shape = Sphere<double>{0.1}}, 1.0 / 240, {8.64e-5}, 0.05}};
  for (const Run& run : runs) {
    CAPTURE(run.towers.side);
    for (const double aside : run.asides) {
      CAPTURE(aside);
      scenes::Crushed scene = run.towers.make(run.dt, aside);
      scene.run(run.towers.time_of(run.share));
      // What is squeezed out falls from no higher than it stood, and slides as fast as the plate
      // and a lever let it.
      const double most = std::sqrt(2 * 9.81 * run.towers.height()) + 3 * run.towers.speed;
      CHECK(scene.fastest < most);
      // It turns no faster than it would roll.
      CHECK(scene.fastest_spin < most / 0.1);
    }
  }
}

TEST_CASE("crushing: loads below the bound do not know of it") {
  // Two movers, opposed, and a load that friction balances: boxes that a plate pushes along.
  World<double> world({.time_step = 1.0 / 240});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  std::vector<BodyId> boxes;
  for (int i = 0; i < 6; ++i) {
    boxes.push_back(world.add_body({.mass = i % 2 == 0 ? 1.0 : 50.0,
                                    .shape = Box<double>{{0.1, 0.1, 0.1}},
                                    .material = {.friction = 0.9},
                                    .position = {0.2 * i, 0, 0.1}}));
  }
  const BodyId plate = world.add_body({.motion = Motion::kinematic,
                                       .shape = Box<double>{{0.1, 1, 0.5}},
                                       .position = {-0.2, 0, 0.6}});
  // So slowly that the weight alone decides on the bound. The load is 0.9 times the weight.
  world.set_velocity(plate, {{1e-3, 0, 0}, {0, 0, 0}});
  for (int i = 0; i < 240; ++i) world.step();
  for (const BodyId id : boxes) {
    CHECK(world.body(id).twist.linear.x() == test::relative(1e-3).epsilon(1e-6));
  }
  for (const auto& point : world.contacts().points()) CHECK(point.gap > -1e-5);
}
