// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

using namespace bristle;

// Every member compiles, for both scalars; see support/worlds.hpp.
template class bristle::World<double>;
template class bristle::World<float>;

TEST_CASE_TEMPLATE("World: an empty one steps and reports nothing", S, float, double) {
  World<S> world;
  world.step();
  CHECK(world.body_count() == 0);
  CHECK(world.report().pairs_tested == 0);
  CHECK(world.report().patches == 0);
  CHECK(world.report().islands == 0);
  CHECK(world.report().residual == S(0));
}
