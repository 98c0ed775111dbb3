// A user with a haptic device presses on a box and drags it: the sensors of the stylus at 960 Hz,
// the world at 60 Hz. Prints what the hand feels, the energy at its port, and the real-time factor.
//
// The user is played: a hand that comes down, presses, wiggles and drags. With --paced the loop
// keeps up with the clock on the wall, as it would with a device; without, it runs as fast as it
// can, and the real-time factor says how much time there is to spare.
// SPDX-License-Identifier: BSD-3-Clause
#define BRISTLE_WITH_THREADS 1  // for RealTimePacer
#include <bristle/bristle.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>

using namespace bristle;

/// [m] Where the hand has the stylus.
Vec3<double> hand(double time) {
  const double down = std::min(time, 0.5) * 0.016;
  const double drag = std::max(time - 1.5, 0.0) * 0.03;
  const double wiggle = std::clamp(time - 0.7, 0.0, 0.3) / 0.3;
  return {drag + 2e-4 * wiggle * std::sin(50 * time), 0,
          0.054 - down + 1e-3 * wiggle * std::sin(20 * time)};
}

int main(int argc, char** argv) {
  const bool is_paced = argc > 1 && std::strcmp(argv[1], "--paced") == 0;
  World<double> world({.time_step = 1.0 / 60});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId box = world.add_body({.mass = 0.2,
                                     .shape = Box<double>{{0.03, 0.03, 0.02}},
                                     .material = {.friction = 0.3},
                                     .position = {0, 0, 0.02}});
  // The tool: a body that goes where it is told, with 25 sensors that look down from its tip.
  const BodyId stylus = world.add_body({.motion = Motion::kinematic, .position = {0, 0, 0.1}});
  PatchDef<double> pad;
  pad.sensors = sensor_grid<double>({.center = {0, 0, -0.005},
                                     .side_u = {0.01, 0, 0},
                                     .side_v = {0, -0.01, 0},
                                     .count_u = 5,
                                     .count_v = 5});
  pad.parameters = tuned_for<double>({.load = 5, .mass = 0.2}).parameters(pad.sensors);
  pad.cast_every = 16;  // Once a step; the law in every substep.

  HapticLoop<double> loop({.substeps = 16});
  const ToolId tool = loop.add_tool(stylus);
  loop.add_patch(tool, pad);
  for (int i = 0; i < 60; ++i) world.step();  // The box comes to rest.
  world.open(loop);

  const double h = loop.substep_length();
  PassivityObserver<double> observer;
  RealTimePacer<> pacer(h);
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  Wrench<double> sent;
  Vec3<double> last = hand(0);
  std::puts("time [s]  force [N]             box at x [mm]  port [mJ]");
  int substeps = 0;
  for (int step = 0; step < 180; ++step) {
    for (int i = 0; i < 16; ++i, ++substeps) {
      const Vec3<double> now = hand(substeps * h);
      const Twist<double> moved{(now - last) / h, Vec3<double>::Zero()};
      last = now;
      loop.move(tool, {Quat<double>::Identity(), now});
      loop.substep();
      sent = observer.control(loop.wrench(tool), moved, h);  // Here it goes to the device.
      if (is_paced) pacer.wait();
    }
    world.step(loop);
    if (step % 20 != 19) continue;
    const Vec3<double>& f = sent.force;
    std::printf("%8.2f  %6.3f %6.3f %6.3f  %13.3f  %9.3f\n", substeps * h, f.x(), f.y(), f.z(),
                1000 * world.pose(box).translation.x(), 1000 * observer.energy());
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  std::printf("the port gave %s\n", observer.is_passive() ? "no energy" : "energy");
  // Simulated time over real time, as the paper plots it (Fig. 9); not the same in every run.
  std::fprintf(stderr, "real-time factor %.2f\n",
               is_paced ? pacer.real_time_factor() : substeps * h / seconds);
  if (is_paced) {
    std::fprintf(
        stderr, "substeps began late by [us]: %.1f half of them, %.1f 99 %%, %.1f at most\n",
        1e6 * pacer.start_delay(0.5), 1e6 * pacer.start_delay(0.99), 1e6 * pacer.start_delay(1));
  }
}
