/// @file
/// Rings that lie in each other are pushed apart both ways at once.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/rigid/tumbling.hpp"
#include "support/random.hpp"

#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
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
