// The same pile on one thread and on four: the same bits.
//
// Expected output: 13_threads.expected
// SPDX-License-Identifier: BSD-3-Clause
#define BRISTLE_WITH_THREADS 1  // for ThreadPool
#include <bristle/bristle.hpp>

#include <cstdio>

using namespace bristle;

std::uint64_t run(const ParallelFor& parallel_for) {
  World<double> world({.parallel_for = parallel_for});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  for (int i = 0; i < 100; ++i) {
    world.add_body({.mass = 0.1,
                    .shape = Sphere<double>{.radius = 0.05},
                    .position = {0.09 * (i % 5), 0.09 * (i / 5 % 5), 0.06 + 0.1 * (i / 25)}});
  }
  for (int i = 0; i < 300; ++i) world.step();
  return world.state_hash();
}

int main() {
  ThreadPool pool(4);
  std::puts(run(serial_for) == run(pool.hook()) ? "the same bits" : "other bits");
}
