/// @file
/// Fig. 7 (a): the stairs of a box that a constant force pushes over its sensors.
// SPDX-License-Identifier: BSD-3-Clause
#include "fig7_stick_slip/stairs.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

using fig7::Push;
using fig7::Stairs;

TEST_CASE("fig7_stick_slip: the equation of the stairs has the reference values") {
  // Near-stops of a plate with half and 0.7 of critical damping; the mean speed of fast stairs is
  // (F - F_max / 2) / c.
  CHECK(fig7::StairEquation({0.9, 0.5}).steady().period ==
        bristle::test::relative(12.3e-3).epsilon(1e-2));
  CHECK(fig7::StairEquation({1, 0.7}).steady().period ==
        bristle::test::relative(14.4e-3).epsilon(1e-2));
  const double c = 16 * 0.1;
  CHECK(fig7::StairEquation({0.6, fig7::papers_damping_ratio()}).steady().speed ==
        bristle::test::relative(0.1 * fig7::StairEquation::full_load / c).epsilon(1e-4));
}

TEST_CASE("fig7_stick_slip: height, period and friction are those of the equation") {
  struct Force {
    double part;
    double damping_ratio;
  };
  for (const Force force : {Force{0.55, fig7::papers_damping_ratio()}, Force{0.9, 0.5}}) {
    for (const double dt : {1e-4, 1e-3, 1.0 / 240}) {
      for (const auto integration :
           {bristle::Integration::explicit_, bristle::Integration::implicit}) {
        const Push push{force.part, force.damping_ratio, dt, integration};
        const Stairs measured = fig7::climb(push, 0.5);
        CAPTURE(force.part);
        CAPTURE(dt);
        CAPTURE(measured.height);
        CAPTURE(measured.period);
        CHECK(fig7::is_right(push, measured, fig7::StairEquation(push).steady()));
      }
    }
  }
}
