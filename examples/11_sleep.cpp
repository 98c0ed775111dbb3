// Boxes at rest fall asleep, cost nothing, and wake when something touches them.
//
// Expected output: 11_sleep.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstdio>

int main() {
  using namespace bristle;
  World<double> world({.sleep = {.time = 0.5}});  // [s] Infinite, that is off, unless set.
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const auto add_box = [&](double x, double z) {
    return world.add_body({.mass = 1.0,
                           .shape = Box<double>{.half_extents = {0.1, 0.1, 0.1}},
                           .position = {x, 0, z}});
  };
  const BodyId lower = add_box(0, 0.1);
  const BodyId upper = add_box(0, 0.3);
  add_box(1, 0.1);

  const auto run = [&](const char* when) {
    for (int i = 0; i < 480; ++i) world.step();
    const auto& report = world.report();
    std::printf("%-13s asleep %d, awake %d, pairs %d, rows %d\n", when,
                static_cast<int>(report.sleeping_bodies), static_cast<int>(report.awake_bodies),
                static_cast<int>(report.pairs_collided), static_cast<int>(report.rows));
  };
  run("after 2 s:");
  // Asleep, contacts still say what they carry.
  std::printf("the lower one carries %.2f N\n",
              -world.contact_impulse(lower, upper).force.z() / world.time_step());
  world.apply_force(upper, {0, 0, 1}, {0, 0, 0.3});
  std::printf("lower one asleep after a touch of the upper one: %s\n",
              world.is_asleep(lower) ? "yes" : "no");
  run("2 s later:");
}
