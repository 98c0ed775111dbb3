// Tries three pushes from one state: a snapshot brings the world back, bit by bit.
//
// A box of 2 kg on a floor with friction 0.5 holds up to mu m g = 9.81 N, and from then on slides
// by t^2 (F / m - mu g) / 2: with 12 N, 0.1369 m in 0.5 s.
//
// Expected output: 12_snapshot.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cstdio>

int main() {
  using namespace bristle;
  World<double> world({.time_step = 1e-3});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId box = world.add_body({.mass = 2.0,
                                     .shape = Box<double>{.half_extents = {0.1, 0.1, 0.02}},
                                     .position = {0, 0, 0.02}});
  for (int i = 0; i < 200; ++i) world.step();

  const std::vector<std::byte> start = world.snapshot();
  const std::uint64_t hash = world.state_hash();
  for (const double force : {5.0, 9.0, 12.0}) {
    world.restore(start);
    for (int i = 0; i < 500; ++i) {
      world.apply_wrench(box, {{force, 0, 0}, {0, 0, 0}});
      world.step();
    }
    const double moved = world.pose(box).translation.x();
    std::printf("%4.1f N: %s\n", force, moved > 1e-3 ? "slides" : "holds");
  }
  world.restore(start);
  std::puts(world.state_hash() == hash ? "back at the start" : "lost");
}
