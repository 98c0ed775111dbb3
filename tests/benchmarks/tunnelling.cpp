// How many of a thousand bodies that are shot at thin walls come out behind them, for several
// walls and steps, and whether energy comes from it.
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

int main(int argc, char** argv) {
  std::uint64_t shots = 1000;
  bool is_markdown = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--markdown") is_markdown = true;
    if (argument != "--markdown") shots = std::strtoull(argv[i], nullptr, 10);
  }
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
