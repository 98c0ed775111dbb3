// Cost of sensors in somebody else's engine: a step of two pads that hold a part, and the same with
// the pads switched off, which is the engine's own cost and that of the mirror. Beside them: how
// fast the part creeps, and how far it drifts in 20 s where the engine's contacts stay.
// benchmark_host_cost has the tests' own engine, which moves two pads and a part and nothing else;
// benchmark_host_cost_bullet, _dart, _mujoco and _ode have these engines.
// SPDX-License-Identifier: BSD-3-Clause
#ifndef BRISTLE_ENGINE_PINCH
#define BRISTLE_ENGINE_PINCH ToyPinch
#define BRISTLE_ENGINE_HEADER "scenes/toy_pinch.hpp"
#define BRISTLE_ENGINE_IS_TOY
#endif
#include BRISTLE_ENGINE_HEADER
#include "thread_clock.hpp"

#include <cstdio>

using namespace bristle;
using namespace bristle::scenes;

namespace {

using EnginePinch = BRISTLE_ENGINE_PINCH;

void switch_off(EnginePinch& pinch) {
  for (const PatchId patch : pinch.patches) pinch.world().set_active(patch, false);
}

void measure(int across) {
  EnginePinch pinch({.dt = 1e-3, .across = across});
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
  switch_off(pinch);
  const double empty = benchmarks::median_nanoseconds([&] { pinch.step(); });
  std::printf("2 x %-4d  %10.2f  %18.2f  %12.2f  %12.2g\n", across * across, 1e-3 * held,
              1e-3 * empty, 1e-3 * (held - empty), creep);
}

/// [um] How far the part has moved along z at the end of 20 s.
double drift(double dt, bool has_contacts, bool has_sensors) {
  EnginePinch pinch({.dt = dt, .has_contacts = has_contacts});
  if (!has_sensors) switch_off(pinch);
  pinch.run(1);
  pinch.gravity = {0, 0, -9.81};
  pinch.run(5);
  const double start = pinch.place().z();
  pinch.run(20);
  return 1e6 * (pinch.place().z() - start);
}

}  // namespace

int main() {
  std::printf("sensors    held [us]  switched off [us]  sensors [us]  creep [m/s]\n");
  for (const int across : {6, 10, 22, 40}) measure(across);
#ifndef BRISTLE_ENGINE_IS_TOY
  std::printf("\nstep [ms]  drift in 20 s [um]: by contacts     by both   by sensors\n");
  for (const double dt : {1e-3, 1.0 / 240}) {
    std::printf("%9.2f  %30.4g  %10.4g  %11.4g\n", 1e3 * dt, drift(dt, true, false),
                drift(dt, true, true), drift(dt, false, true));
  }
#endif
}
