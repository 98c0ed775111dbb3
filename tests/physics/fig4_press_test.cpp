/// @file
/// Figs. 4 and 6 (a): sensors pressed into a box, and a wrapped skin into a plane.
// SPDX-License-Identifier: BSD-3-Clause
#include "fig4_press/press.hpp"

#include <doctest/doctest.h>

using bristle::Integration;

TEST_CASE("fig4_press: depths are those of statics, and forces balance the weight") {
  for (const auto& make : {fig4::press_on_box, fig4::press_skin}) {
    for (const double dt : {1e-3, 1.0 / 240, 1.0 / 60}) {
      for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
        // Explicit steps are stable to 11 ms here.
        if (integration == Integration::explicit_ && dt > 1e-2) continue;
        CAPTURE(dt);
        fig4::Press press = make({dt, integration});
        press.run(3);
        // The facets of the ball and of the skin are worth a few parts in ten thousand of a ray.
        CHECK(press.depth_error() < 1e-3);
        CHECK(press.imbalance() < 1e-6);
      }
    }
  }
}
