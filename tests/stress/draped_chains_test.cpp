/// @file
/// Chains over a cylinder at steps that are too long for them: they may slide, and must not tear.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/draped_chain.hpp"

#include <doctest/doctest.h>

#include <algorithm>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("draped_chains: none tears, whatever hangs on one side") {
  for (const double steps_per_second : {50.0, 60.0, 80.0, 120.0}) {
    double widest = 0;
    for (const double shift : {0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0}) {
      CAPTURE(steps_per_second);
      CAPTURE(shift);
      DrapedChain chain(shift, 1 / steps_per_second);
      const double gap = chain.run(2);
      // Half of a link.
      CHECK(gap < link_pitch / 2);
      widest = std::max(widest, gap);
    }
    MESSAGE("1/", steps_per_second, " s: widest gap ", 1e3 * widest, " mm");
  }
}
