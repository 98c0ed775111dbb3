// Drops a box with a skin of 25 sensors on a table, and asks the skin what it feels.
//
// At rest the sensors carry the weight, sum F_N = m g = 4.905 N, each pressed in by
// e = m g / (25 K_N) = 0.3 of its 10 mm (what `tuned_for` aims at). The rays reach 5 mm out of the
// box, so its underside stays 5 mm - 0.3 * 10 mm = 2 mm above the table.
//
// Expected output: 01_falling_box.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstdio>

int main() {
  using namespace bristle;
  World<double> world({.gravity = {0, 0, -9.81}, .time_step = 1e-3});

  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId box = world.add_body({.mass = 0.5,
                                     .shape = Box<double>{.half_extents = {0.03, 0.03, 0.03}},
                                     .position = {0, 0, 0.1}});
  const PatchId skin =
      world.add_patch(box,
                      sensor_grid<double>({.center = {0, 0, -0.03},
                                           .side_u = {0, 0.06, 0},
                                           .side_v = {0.06, 0, 0},
                                           .count_u = 5,
                                           .count_v = 5}),
                      tuned_for<double>({.friction = 0.8, .creep = 1e-3, .load = 0.5 * 9.81}));

  std::puts("time [s]  height [mm]  normal force [N]  touching");
  for (int i = 1; i <= 1000; ++i) {
    world.step();
    if (i % 100 != 0) continue;
    const auto reading = world.reading(skin);
    std::printf("%8.1f  %11.1f  %16.3f  %5zu of %zu\n", 1e-3 * i,
                1e3 * world.pose(box).translation.z(), reading.total_normal(), reading.touching(),
                reading.size());
  }
}
