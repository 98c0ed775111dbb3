/// @file
/// Nothing passes through a thin plate, however fast it comes or spins.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plates.hpp"

#include <doctest/doctest.h>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("tunnelling: a ball of 5 cm at 100 m/s does not pass a plate of 1 cm") {
  // In one step of 1/60 s it flies 1.7 m: 33 times its size. From all phases of the step, straight
  // and aslant.
  const Sphere<double> ball{0.025};
  for (const bool is_mesh : {false, true}) {
    for (int i = 0; i < 25; ++i) {
      for (const double aside : {0.0, 60.0}) {
        CAPTURE(is_mesh);
        CAPTURE(i);
        CAPTURE(aside);
        BodyDef<double> body;
        body.position = {-0.3, 0.17, 0.04 + 0.13 * i};
        body.velocity = {aside, 0, -100};
        body.gravity_scale = 0;
        // Aslant it may leave over the plate's edge, 2.3 m away, after two steps.
        const Flight flight =
            fly_at_plate<AnalyticBackend>(ball, body, is_mesh, aside > 0 ? 2 : 30);
        // A contact ends at its gap, to what the solver leaves: 1e-9 of the way of a step.
        CHECK(flight.lowest_clearance > -1e-8);
      }
    }
  }
}

TEST_CASE("tunnelling: rods of 1 m that spin at 100 rad/s do not pass a plate of 1 cm") {
  // Their ends move at 50 m/s and they turn by 1.7 rad in a step, while contacts are linear in the
  // step. So an end may dip into the plate; but no rod gets to its other side, and what dips in
  // comes out.
  const Capsule<double> capsule{0.02, 0.48};
  const Box<double> box{{0.02, 0.02, 0.5}};
  for (const bool is_mesh : {false, true}) {
    for (int i = 0; i < 12; ++i) {
      for (const bool is_box : {false, true}) {
        CAPTURE(is_mesh);
        CAPTURE(i);
        CAPTURE(is_box);
        BodyDef<double> body;
        body.position = {0, 0, 0.6 + 0.07 * i};
        body.orientation = exp_rotation<double>({0.4 * i, 0.3, 0});
        body.velocity = {0, 0, -5};
        body.angular_velocity = {100, 0, 0};
        // Else they drive off the plate.
        body.material.friction = 0;
        const Flight flight = is_box ? fly_at_plate<AnalyticBackend>(box, body, is_mesh, 90)
                                     : fly_at_plate<AnalyticBackend>(capsule, body, is_mesh, 90);
        CHECK(flight.contacts > 0);
        CHECK(flight.lowest_middle > 0);
        CHECK(flight.last_clearance > -1e-4);
      }
    }
  }
}
