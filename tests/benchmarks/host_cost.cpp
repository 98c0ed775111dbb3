// Cost of sensors in somebody else's engine: a step of two pads that hold a part, and the same with
// the pads switched off, which is the engine's own cost and that of the mirror. The creep of the
// part is printed, too. The engine is the tests' own, which moves two pads and a part and nothing
// else.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/toy_pinch.hpp"
#include "thread_clock.hpp"

#include <cstdio>

using namespace bristle;
using namespace bristle::scenes;

namespace {

void measure(int across) {
  ToyPinch pinch({.dt = 1e-3, .across = across});
  pinch.run(1);
  pinch.gravity = {0, 0, -9.81};
  pinch.run(2);
  const Vec3<double> there = pinch.place();
  long steps = 0;
  const double held = benchmarks::median_nanoseconds([&] {
    pinch.step();
    ++steps;
  });
  const double creep = (pinch.place() - there).norm() / (1e-3 * static_cast<double>(steps));
  pinch.world().set_active(pinch.patches[0], false);
  pinch.world().set_active(pinch.patches[1], false);
  const double empty = benchmarks::median_nanoseconds([&] { pinch.step(); });
  std::printf("2 x %-4d  %10.2f  %14.2f  %10.2g\n", across * across, 1e-3 * held, 1e-3 * empty,
              creep);
}

}  // namespace

int main() {
  std::printf("sensors   held [us]  switched off [us]  creep [m/s]\n");
  for (const int across : {6, 10, 22, 40}) measure(across);
}
