/// @file
/// Stacks of cubes that are let go a little above each other, askew, land and stand.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/drivers/bristle_driver.hpp"
#include "scenes/rigid/stacks.hpp"

#include <doctest/doctest.h>

#include <algorithm>

using namespace bristle;
using namespace bristle::scenes;

// Ten cubes fall by 1 to 10 mm, up to 1 cm off centre: their middles are above each other to a
// tenth of a cube, so nothing makes them tip. Friction, mu = 0.5, makes at most half of the speed
// of the impact, 0.44 m/s, one of slip, which it stops within 0.22^2 / (2 mu g) = 5 mm; twice that
// is allowed. Contacts that were yet to close inherited impulses of ten thousand times the load; in
// float one stack in fifty was torn by what was left of them.
TEST_CASE_TEMPLATE("askew stacks: land and stand", S, float, double) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    CAPTURE(seed);
    StackSetup setup;
    setup.offset = 0.01;
    setup.yaw = 0.2;
    setup.gap = 0.001;
    setup.seed = seed;
    const double dt = 1.0 / 60;
    const Stack stack(setup);
    work_precision::BristleEngine<S> engine(stack.scene(), dt, "def");
    double drift = 0;
    double kinetic = 0;
    for (int n = 0; n < 120; ++n) {
      engine.step();
      kinetic = 0;
      for (std::size_t i = 1; i < stack.scene().bodies.size(); ++i) {
        const BodyState cube = engine.state(i);
        const Vector moved = cube.position - stack.scene().bodies[i].position;
        drift = std::max(drift, moved.head<2>().norm());
        kinetic += cube.velocity.squaredNorm() / 2;
      }
    }
    CHECK(drift < 0.01);
    CHECK(kinetic < 1e-6);
  }
}
