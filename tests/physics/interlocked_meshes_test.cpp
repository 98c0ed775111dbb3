/// @file
/// Rings that fall on other bodies, or lie in each other and are pushed apart both ways at once.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/rigid/tumbling.hpp"
#include "support/momentum.hpp"
#include "support/random.hpp"

#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

using namespace bristle;

// What such contacts ask for contradicts itself, and a correction that satisfies all of it turned
// rings by 24 rad and moved their neighbours by 0.9 m in one step: they left a bowl through its
// wall. A correction turns no body by more than half a radian.
TEST_CASE("interlocked meshes: no correction turns a body further than its directions hold") {
  const TriangleMesh<double> ring = scenes::parts::torus(0.05, 0.02, 16, 8).mesh;
  const double dt = 1.0 / 240;
  double farthest = 0;
  for (int seed = 1; seed <= 4; ++seed) {
    CAPTURE(seed);
    test::Random random(static_cast<std::uint64_t>(seed));
    World<double> world({.gravity = Vec3<double>::Zero(), .time_step = dt});
    std::vector<BodyId> rings;
    for (int i = 0; i < 12; ++i) {
      rings.push_back(
          world.add_body({.mass = 0.5,
                          .shape = ring,
                          .material = {0.7, 0},
                          .position = {0.06 * (i % 3), 0.06 * (i / 3 % 2), 0.06 * (i / 6)},
                          .orientation = random.rotation<double>()}));
    }
    for (int n = 0; n < 60; ++n) {
      std::vector<Body<double>> before;
      for (const BodyId id : rings) before.push_back(world.body(id));
      world.step();
      for (std::size_t i = 0; i < rings.size(); ++i) {
        const Body<double>& after = world.body(rings[i]);
        const double turned =
            before[i].center_pose.rotation.angularDistance(after.center_pose.rotation);
        // Velocities turn it as well, by their mean over the step.
        const double spin = std::max(before[i].twist.angular.norm(), after.twist.angular.norm());
        CHECK(turned < 0.5 + dt * spin + 1e-9);
        farthest = std::max(farthest, turned);
      }
    }
  }
  // The bound is reached.
  CHECK(farthest > 0.4);
}

// Triangles of a ring's far side took part, as if bodies beside it were 0.1 m deep in it. Single
// steps of these heaps gained up to 2.8 J.
TEST_CASE("interlocked meshes: a heap with rings gains no energy") {
  const TriangleMesh<double> ring = scenes::parts::torus(0.05, 0.02, 16, 8).mesh;
  const double dt = 1.0 / 60;
  const double gravity = 9.81;
  for (int seed = 1; seed <= 3; ++seed) {
    CAPTURE(seed);
    test::Random random(static_cast<std::uint64_t>(seed));
    World<double> world({.gravity = {0, 0, -gravity}, .time_step = dt});
    for (const double side : {-1.0, 1.0}) {
      for (const Vec3<double>& axis : {Vec3<double>(side, 0, 0), Vec3<double>(0, side, 0)}) {
        world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{axis, -0.16}});
      }
    }
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{Vec3<double>::UnitZ(), 0}});
    std::vector<BodyId> bodies;
    for (int i = 0; i < 24; ++i) {
      BodyDef<double> def{
          .mass = 0.5,
          .material = {0.5, 0},
          .position = {0.16 * (i % 2) - 0.08, 0.16 * (i / 2 % 2) - 0.08, 0.1 + 0.17 * (i / 4)},
          .orientation = random.rotation<double>()};
      if (i % 3 == 0) def.shape = ring;
      if (i % 3 == 1) def.shape = Box<double>{{0.05, 0.04, 0.035}};
      if (i % 3 == 2) def.shape = Sphere<double>{0.05};
      bodies.push_back(world.add_body(def));
    }
    const auto energy = [&] { return test::energy_of(world, std::span<const BodyId>(bodies)); };
    const double start = energy();
    double largest = 0;
    for (int n = 0; n < 120; ++n) {
      const double before = energy();
      world.step();
      largest = std::max(largest, energy() - before);
    }
    // Corrections lift the heap by less than a millimetre a step.
    CHECK(largest < 24 * 0.5 * gravity * 1e-3);
    CHECK(energy() < 0.5 * start);
  }
}
