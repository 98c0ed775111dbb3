/// @file
/// The smallest scene there is.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

using namespace bristle;

TEST_CASE_TEMPLATE("empty_world: it steps and reports nothing", S, float, double) {
  World<S> world;
  world.step();
  CHECK(world.body_count() == 0);
  CHECK(world.report().pairs_tested == 0);
  CHECK(world.report().patches == 0);
  CHECK(world.report().islands == 0);
  CHECK(world.report().residual == S(0));
}
