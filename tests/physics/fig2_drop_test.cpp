/// @file
/// Fig. 2: what falls on a plane does not sink into it, whatever the rate and the mesh.
// SPDX-License-Identifier: BSD-3-Clause
#include "fig2_drop/drop.hpp"

#include <doctest/doctest.h>

TEST_CASE("fig2_drop: ball and meshes stop at the plane at every rate") {
  // A step at the speed of the impact is 104 mm long at 60 Hz and 6 mm at 1 kHz.
  for (const double rate : {60.0, 120.0, 240.0, 1000.0}) {
    for (const std::uint32_t frequency : {0u, 2u, 8u}) {
      CAPTURE(rate);
      CAPTURE(frequency);
      const fig2::Depth depth = fig2::worst_drop(frequency, rate, 4);
      CHECK(depth.deepest < 1e-9);
      CHECK(depth.below_rest < 1e-9);
      CHECK(depth.rest_gap < 1e-6);
    }
  }
}
