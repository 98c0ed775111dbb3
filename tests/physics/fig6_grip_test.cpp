/// @file
/// Fig. 6 (b): a gripper holds parts however they lie in it, and resists torsion as a disk does.
// SPDX-License-Identifier: BSD-3-Clause
#include "fig6_grip/grip.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

using bristle::Integration;
using bristle::SlipReset;

TEST_CASE("fig6_grip: parts of every posture hang where statics puts them, and stay") {
  for (const fig6::Posture posture : fig6::postures) {
    for (const double dt : {1e-3, 1.0 / 240, 1.0 / 60}) {
      CAPTURE(fig6::name_of(posture));
      CAPTURE(dt);
      const fig6::Held held = fig6::hold({.posture = posture, .time_step = dt}, 1, 1);
      CAPTURE(held.sag);
      CAPTURE(held.turn);
      CAPTURE(held.drift);
      CHECK(held.is_right());
    }
    CHECK(fig6::hold({.posture = posture, .integration = Integration::explicit_}, 1, 1).is_right());
  }
}

TEST_CASE("fig6_grip: bristles that drag resist torsion with 2/3 mu F R, those that release less") {
  for (const SlipReset reset : {SlipReset::drag, SlipReset::release}) {
    const fig6::Torsion torsion = fig6::twist({.time_step = 1.0 / 240, .reset = reset});
    CHECK(torsion.is_right());
    // The grid of sensors is a disk to a few parts in a thousand.
    const double disk = (reset == SlipReset::drag ? 4.0 / 3 : 1.0) * 10 * fig6::pad_radius;
    CHECK(torsion.expected_limit == bristle::test::relative(disk).epsilon(5e-3));
  }
}
