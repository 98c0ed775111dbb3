/// @file
/// Fig. 7 (b): a box that is set down on an incline stays where statics puts it.
// SPDX-License-Identifier: BSD-3-Clause
#include "fig7_incline/hold.hpp"

#include <doctest/doctest.h>

using bristle::Integration;
using bristle::Law;

TEST_CASE("fig7_incline: the box stands still on every incline") {
  for (const double angle : {5.0, 20.0, 45.0}) {
    for (const double dt : {1e-3, 1.0 / 240, 1.0 / 60}) {
      CAPTURE(angle);
      CAPTURE(dt);
      const fig7::Hold hold = fig7::hold({.degrees = angle, .time_step = dt}, 16, 2);
      CAPTURE(hold.shift);
      CHECK(fig7::holds(hold));
    }
    CHECK(
        fig7::holds(fig7::hold({.degrees = angle, .integration = Integration::explicit_}, 16, 2)));
  }
}

TEST_CASE("fig7_incline: under AMBF's law it never comes to rest") {
  // Bars from the simulator itself: 3 to 160 mm/s rms.
  for (const int per_side : {2, 5}) {
    const fig7::Hold hold = fig7::hold(
        {.law = Law::ambf, .integration = Integration::explicit_, .per_side = per_side}, 0, 5);
    CHECK(hold.jitter > 1e-3);
  }
}
