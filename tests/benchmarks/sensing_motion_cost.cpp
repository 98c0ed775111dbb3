// Cost of sensing while bodies move: a pad of sensors on a bumpy ball of 9680 triangles.
//
//   held      both stand still, and the pad would fall if it were not put back: rays are lengthened
//             by what it would fall in a step
//   explicit  the ball passes across the pad; rays are as long as they are
//   implicit  the same; rays are lengthened by what bodies can approach in a step
//
// Times are processor time of the thread, medians of the later two thirds of the steps, in
// nanoseconds a sensor and step. Sensors that give a force are counted, too: more of them are more
// to solve.
// Usage: benchmark_sensing_motion_cost [held|explicit|implicit]
//        benchmark_sensing_motion_cost WAY SENSORS SPEED STEP STEPS
// The second takes that many steps and prints nothing, for `valgrind --tool=callgrind`.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/pad_workload.hpp"
#include "benchmarks/thread_clock.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

using namespace bristle;
using benchmarks::ball_radius;

namespace {

enum class Way { held, explicit_, implicit };
constexpr std::string_view names[] = {"held", "explicit", "implicit"};

/// The pad, whose rays look up, and the ball 1.5 mm into its reach.
class Passing {
 public:
  Passing(Way way, std::size_t sensors, double speed, double dt)
      : is_held_(way == Way::held), speed_(speed) {
    WorldDef<double> def;
    def.time_step = dt;
    if (!is_held_) def.gravity.setZero();
    world_ = World<double>(def);
    // So heavy that sensors do not move it.
    pad_ = world_.add_body({.mass = 1e6, .inertia = Mat3<double>(1e4 * Mat3<double>::Identity())});
    ball_ = world_.add_body({.motion = Motion::kinematic,
                             .shape = benchmarks::bumpy_ball(31),
                             .position = {0, 0, height},
                             .velocity = {speed, 0, 0}});
    PatchDef<double> patch;
    patch.sensors = benchmarks::pad_rays(sensors, false);
    const double load = 10 / (0.15 * double(patch.sensors.size()));
    patch.parameters = {load, 1e-3 * load, 5000, 1e-3, 1e-3};
    patch.integration = way == Way::explicit_ ? Integration::explicit_ : Integration::implicit;
    patch_ = world_.add_patch(pad_, patch);
  }
  /// One step, in which only the library is timed.
  /// @return [s]
  double step() {
    if (is_held_) {
      world_.set_pose(pad_, {});
      world_.set_velocity(pad_, {});
    } else {
      turn_back();
    }
    const double start = benchmarks::thread_seconds();
    world_.step();
    return benchmarks::thread_seconds() - start;
  }
  [[nodiscard]] std::size_t size() const { return world_.patch(patch_).size(); }
  [[nodiscard]] std::size_t touching() const { return world_.reading(patch_).touching(); }

 private:
  static constexpr double height = ball_radius + 0.0015;
  /// [m] The ball passes to and fro by so much.
  static constexpr double amplitude = 0.01;

  void turn_back() {
    const double x = world_.pose(ball_).translation.x();
    if (std::abs(x) < amplitude) return;
    const double side = x > 0 ? 1 : -1;
    world_.set_pose(ball_, {Quat<double>::Identity(), {side * amplitude, 0, height}});
    world_.set_velocity(ball_, {{-side * speed_, 0, 0}, {0, 0, 0}});
  }

  bool is_held_;
  double speed_;
  World<double> world_;
  BodyId pad_{}, ball_{};
  PatchId patch_{};
};

void print_row(Way way, std::size_t sensors, double speed, double dt) {
  Passing scene(way, sensors, speed, dt);
  const int steps = sensors > 5000 ? 150 : 600;
  std::vector<double> seconds;
  double touching = 0;
  for (int i = 0; i < steps; ++i) {
    const double time = scene.step();
    if (i < steps / 3) continue;
    seconds.push_back(time);
    touching += double(scene.touching());
  }
  touching /= double(seconds.size());
  std::nth_element(seconds.begin(), seconds.begin() + std::ptrdiff_t(seconds.size() / 2),
                   seconds.end());
  const double median = seconds[seconds.size() / 2];
  std::printf("%-8s  %7zu  %5.1f  %9.5f  %8.1f  %7.0f\n",
              names[static_cast<std::size_t>(way)].data(), scene.size(), speed, dt,
              1e9 * median / double(scene.size()), touching);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view only = argc > 1 ? argv[1] : "";
  if (argc > 1 && std::find(std::begin(names), std::end(names), only) == std::end(names)) {
    std::fprintf(stderr, "unknown way '%s'; see the top of sensing_motion_cost.cpp\n", argv[1]);
    return 2;
  }
  for (const Way way : {Way::held, Way::explicit_, Way::implicit}) {
    if (argc > 1 && names[static_cast<std::size_t>(way)] != only) continue;
    if (argc > 5) {
      Passing scene(way, std::strtoull(argv[2], nullptr, 10), std::atof(argv[3]),
                    std::atof(argv[4]));
      for (int i = 0; i < std::atoi(argv[5]); ++i) scene.step();
      return 0;
    }
    if (way == Way::held || argc > 1) {
      std::puts("way       sensors  [m/s]   step [s]  [ns]      touching");
    }
    for (const std::size_t sensors : {1024u, 10000u}) {
      for (const double dt : {1e-3, 1.0 / 240, 1.0 / 60}) {
        for (const double speed : {0.0, 1.0, 10.0}) {
          if (way != Way::held || speed == 0) print_row(way, sensors, speed, dt);
        }
      }
    }
  }
}
