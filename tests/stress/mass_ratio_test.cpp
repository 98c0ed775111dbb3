/// @file
/// Heavy on light and light on heavy, on sensors, up to a ratio of 1e6.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/grasp.hpp"
#include "scenes/stack.hpp"

#include <doctest/doctest.h>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("mass_ratio: pairs of cubes rest at any ratio when factored") {
  for (const double ratio : {1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4, 1e6}) {
    for (const double dt : {1e-3, 1.0 / 60}) {
      StackDef<double> def;
      def.by = StackBy::sensors;
      def.masses = {1, ratio};
      def.time_step = dt;
      auto scene = make_stack<double>(def);
      scene.run(4);
      INFO("ratio ", ratio, ", dt ", dt);
      for (std::size_t k = 0; k < 2; ++k) {
        const double z = scene.world.pose(scene.cubes[k]).translation.z();
        CHECK(std::abs(z - scene.rest_heights[k]) < 1e-6);
      }
    }
  }
}

TEST_CASE("mass_ratio: swept islands rest up to a ratio of 30") {
  for (const double ratio : {0.01, 1.0, 10.0, 30.0}) {
    StackDef<double> def;
    def.by = StackBy::sensors;
    def.masses = {1, ratio};
    def.solver.max_direct_bodies = 0;
    auto scene = make_stack<double>(def);
    scene.run(4);
    INFO("ratio ", ratio);
    const double z = scene.world.pose(scene.cubes[1]).translation.z();
    CHECK(std::abs(z - scene.rest_heights[1]) < 1e-5);
  }
}

TEST_CASE("mass_ratio: fingers from 5 g to 50 t hold a part of 0.5 kg still") {
  for (const double finger_mass : {0.005, 0.5, 50.0, 5e4}) {
    for (const double dt : {1e-3, 1.0 / 60}) {
      GraspDef<double> def;
      def.finger_mass = finger_mass;
      def.time_step = dt;
      def.static_friction = 1e5;
      auto scene = make_grasp<double>(def);
      scene.run(6);
      INFO("finger ", finger_mass, ", dt ", dt);
      CHECK(scene.total_normal() == doctest::Approx(20).epsilon(1e-4));
      CHECK(scene.sag() == doctest::Approx(0.5 * 9.81 / (1e5 * 20)).epsilon(1e-4));
    }
  }
}
