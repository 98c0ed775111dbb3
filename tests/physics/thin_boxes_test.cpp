/// @file
/// Wires: boxes a thousand to a hundred thousand times as long as thick.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using namespace bristle;

// About its axis a wire has some 1e-10 of its other moments. Momentum that contacts gave it in the
// last step lies along its axis by no more than the axis turned since, and still spins it by
// radians: a spin that contacts turn into a fall upwards, 5e12 times the energy at 1:10000. No
// force here gives energy, so there is never more than at the start.
TEST_CASE("wires: fall, lean on each other and come to rest without a gain of energy") {
  for (const double dt : {1.0 / 60, 1.0 / 240, 1e-3}) {
    for (const double slenderness : {1e3, 1e4, 1e5}) {
      CAPTURE(dt);
      CAPTURE(slenderness);
      World<double> world({.gravity = {0, 0, -9.81}, .time_step = dt});
      world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
      std::vector<BodyId> wires;
      for (int i = 0; i < 6; ++i) {
        wires.push_back(world.add_body(
            {.density = 8000,
             .shape = Box<double>{{0.5, 0.5 / slenderness, 0.5 / slenderness}},
             .position = {0.01 * i, 0.02 * i, 0.5 + 0.1 * i},
             .orientation = Quat<double>(1, 0.1, 0.2 + 0.05 * i, 0.3 * i).normalized()}));
      }
      const auto energy = [&] {
        double sum = 0;
        for (const BodyId id : wires) {
          const Body<double>& wire = world.body(id);
          sum += wire.kinetic_energy() + wire.mass * 9.81 * wire.center_pose.translation.z();
        }
        return sum;
      };
      const double start = energy();
      double most = 0;
      for (double t = 0; t < 1.5; t += dt) {
        world.step();
        most = std::max(most, energy());
      }
      CHECK(most <= start * (1 + 1e-9));
      // They lie about by now: what is left of the energy is the lean of a wire on another.
      CHECK(energy() < 0.1 * start);
    }
  }
}
