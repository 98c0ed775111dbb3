/// @file
/// Wires: boxes a thousand to a hundred thousand times as long as thick.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/falling_wires.hpp"

#include <doctest/doctest.h>

using namespace bristle;

// About its axis a wire has some 1e-10 of its other moments. Momentum that contacts gave it in the
// last step lies along its axis by no more than the axis turned since, and still spins it by
// radians: a spin that contacts turn into a fall upwards, 5e12 times the energy at 1:10000. No
// force here gives energy, so there is never more than at the start. Shorter steps are in
// stress/falling_wires_test.cpp.
TEST_CASE("wires: fall, lean on each other and come to rest without a gain of energy") {
  for (const double slenderness : {1e3, 1e4, 1e5}) {
    CAPTURE(slenderness);
    scenes::FallingWires wires(slenderness, 1.0 / 60);
    const double start = wires.energy();
    CHECK(wires.run(1.5) <= start * (1 + 1e-9));
    // They lie about by now: what is left of the energy is the lean of a wire on another.
    CHECK(wires.energy() < 0.1 * start);
  }
}
