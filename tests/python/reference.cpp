// The scene of examples/python/falling_box.py in C++: its state's hash and what sensors read, as
// bits.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <bit>
#include <cinttypes>
#include <cstdio>

using namespace bristle;

int main() {
  World<double> world({.time_step = 1e-3});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId box = world.add_body(
      {.mass = 0.5, .shape = Box<double>{{0.03, 0.03, 0.03}}, .position = {0, 0, 0.1}});
  const PatchId skin =
      world.add_patch(box,
                      sensor_grid<double>({.center = {0, 0, -0.03},
                                           .side_u = {0, 0.06, 0},
                                           .side_v = {0.06, 0, 0},
                                           .count_u = 5,
                                           .count_v = 5}),
                      tuned_for<double>({.friction = 0.8, .creep = 1e-3, .load = 0.5 * 9.81}));
  for (int i = 0; i < 1000; ++i) world.step();
  std::printf("%" PRIx64 "\n", world.state_hash());
  for (const double force : world.reading(skin).normal_force) {
    std::printf("%" PRIx64 "\n", std::bit_cast<std::uint64_t>(force));
  }
}
