/// @file
/// A body at rest stays at rest for ever: a stack of ten for 1e5 steps, for 1e6 in the long run.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/stack.hpp"
#include "support/counted_new.hpp"
#include "support/rounds.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("long_rest: a stack of ten neither drifts nor allocates") {
  StackDef<double> def;
  def.masses.assign(10, 1);
  def.gap = 0.001;
  auto scene = make_stack<double>(def);
  scene.run(5);
  std::vector<Transform<double>> settled;
  for (const BodyId id : scene.cubes) settled.push_back(scene.world.pose(id));
  const std::size_t before = test::allocations;
  const int steps = test::rounds(100000);
  std::uint64_t sweeps = 0;
  for (int i = 0; i < steps; ++i) {
    scene.world.step();
    sweeps += scene.world.report().sweeps;
  }
  CHECK(test::allocations == before);
  CHECK(scene.world.report().sleeping_bodies == 0);
  // Four on average: nearly what the impulses of the last step leave to do.
  CHECK(sweeps < 6 * static_cast<std::uint64_t>(steps));
  double moved = 0;
  double turned = 0;
  for (std::size_t k = 0; k < scene.cubes.size(); ++k) {
    const Transform<double> X = scene.world.pose(scene.cubes[k]);
    moved = std::max(moved, (X.translation - settled[k].translation).norm());
    turned =
        std::max(turned, log_rotation<double>(X.rotation.conjugate() * settled[k].rotation).norm());
  }
  // Velocities are solved to 1e-8 of what gravity gives in a step (`SolverDef::tolerance`); were
  // all of them to point the same way, this is how far they would lead.
  const double dt = def.time_step;
  const double drift = 1e-8 * 9.81 * dt * dt * steps;
  CHECK(moved < drift);
  CHECK(turned < drift / 0.1);
}
