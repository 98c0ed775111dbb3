// How many of a thousand bodies that are shot at thin walls come out behind them, for several
// walls and steps, and whether energy comes from it. Then balls at rest before a wall that are hit.
//
//     benchmark_tunnelling [shots] [--markdown]
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/benchmark_table.hpp"
#include "scenes/shots.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>

using namespace bristle;

namespace {

/// [m] How far a ball of 5 cm and 0.1 kg gets into or past a wall of 5 mm if 10 kg hit it.
/// @param speed  [m/s] Of what hits it.
/// @param gap    [m] From the ball to the wall.
double way_past_wall(double speed, double gap, double dt) {
  World<double> world({.gravity = Vec3<double>::Zero(), .time_step = dt});
  world.add_body({.motion = Motion::fixed,
                  .shape = Box<double>{{0.0025, 0.5, 0.5}},
                  .position = {0.0525 + gap, 0, 0}});
  const BodyId ball = world.add_body({.mass = 0.1, .shape = Sphere<double>{0.05}});
  world.add_body({.mass = 10,
                  .shape = Sphere<double>{0.05},
                  .position = {-0.101, 0, 0},
                  .velocity = {speed, 0, 0}});
  double past = 0;
  for (int n = 0; n * dt < 0.3; ++n) {
    world.step();
    past = std::max(past, world.body(ball).center_pose.translation.x() - gap);
  }
  return past;
}

void shoot_at_walls(std::uint64_t shots, bool is_markdown) {
  struct Named {
    scenes::ShotWall wall;
    const char* name;
  };
  constexpr Named walls[] = {{scenes::ShotWall::fixed, "fixed box"},
                             {scenes::ShotWall::mesh, "fixed mesh"},
                             {scenes::ShotWall::free, "free box of 20 kg"},
                             {scenes::ShotWall::hinged, "hinged box of 20 kg"},
                             {scenes::ShotWall::ground, "rough ground"}};
  benchmarks::Table table(
      is_markdown, {"               wall", "step [s]", "shots", "passed", "most energy / start"});
  for (const Named& named : walls) {
    for (const double rate : {60.0, 240.0, 1000.0}) {
      std::uint64_t passed = 0;
      double energy = 0;
      for (std::uint64_t number = 0; number < shots; ++number) {
        const double dt = 1 / rate;
        const scenes::ShotResult result =
            scenes::shoot(scenes::shot_of(number, dt), named.wall, dt);
        passed += result.has_passed ? 1u : 0u;
        energy = std::max(energy, result.energy);
      }
      table.add({named.name, "1/" + benchmarks::in_full(rate), std::to_string(shots),
                 std::to_string(passed), benchmarks::in_full(energy)});
    }
  }
}

void hit_before_wall(bool is_markdown) {
  benchmarks::Table table(
      is_markdown, {"hit at [m/s]", "step [s]", "farthest past the wall [mm]: 1, 5, 20 mm away"});
  for (const double speed : {2.0, 4.0, 8.0, 16.0}) {
    for (const double rate : {60.0, 240.0}) {
      std::string past;
      for (const double gap : {0.001, 0.005, 0.02}) {
        past += (past.empty() ? "" : ", ") +
                benchmarks::in_short(1e3 * way_past_wall(speed, gap, 1 / rate));
      }
      table.add({benchmarks::in_full(speed), "1/" + benchmarks::in_full(rate), past});
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t shots = 1000;
  bool is_markdown = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--markdown") is_markdown = true;
    if (argument != "--markdown") shots = std::strtoull(argv[i], nullptr, 10);
  }
  shoot_at_walls(shots, is_markdown);
  hit_before_wall(is_markdown);
}
