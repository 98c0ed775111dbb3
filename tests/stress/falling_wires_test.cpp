/// @file
/// Wires that fall on each other at short steps; `physics/thin_boxes_test.cpp` has long ones.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/falling_wires.hpp"

#include <doctest/doctest.h>

using namespace bristle;

TEST_CASE("falling_wires: come to rest without a gain of energy") {
  for (const double time_step : {1.0 / 240, 1e-3}) {
    for (const double slenderness : {1e3, 1e4, 1e5}) {
      CAPTURE(time_step);
      CAPTURE(slenderness);
      scenes::FallingWires wires(slenderness, time_step);
      const double start = wires.energy();
      CHECK(wires.run(1.5) <= start * (1 + 1e-9));
      CHECK(wires.energy() < 0.1 * start);
    }
  }
}
