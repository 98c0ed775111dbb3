// Runs a scene for a number of steps and does nothing else: under callgrind, two runs tell what a
// step costs in instructions, which do not depend on what else the machine does.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/engines.hpp"
#include "benchmarks/work_precision/row.hpp"
#include "scenes/rigid/catalogue.hpp"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>

using namespace bristle;

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) {
    std::fputs(
        "Usage: benchmark_plain_run GROUP/SCENE STEPS [DT]\n\n"
        "Steps a scene with the library's defaults in double, without measuring anything. The "
        "work\n"
        "of a step is the difference of two runs by that of their steps:\n\n"
        "  valgrind --tool=callgrind benchmark_plain_run matrix/slide 240 1/240\n"
        "  valgrind --tool=callgrind benchmark_plain_run matrix/slide 1200 1/240\n",
        stderr);
    return 2;
  }
  try {
    const long steps = std::strtol(argv[2], nullptr, 10);
    const double dt = argc > 3 ? work_precision::parse_time_step(argv[3]) : 1.0 / 240;
    if (steps <= 0 || !(dt > 0)) throw std::invalid_argument("STEPS and DT must be > 0");
    for (const scenes::Recipe& recipe : scenes::catalogue()) {
      if (recipe.group + '/' + recipe.name != argv[1]) continue;
      const auto trial = recipe.make(0);
      const work_precision::EngineFamily family = work_precision::engine_families().front();
      const auto engine = family.make(trial->scene(), dt, family.settings.front());
      for (long i = 0; i < steps; ++i) {
        trial->prepare(*engine, {static_cast<double>(i) * dt, dt, i});
        engine->step();
      }
      return 0;
    }
    throw std::invalid_argument(std::string(argv[1]) +
                                ": no such scene; benchmark_work_precision --list");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "benchmark_plain_run: %s\n", e.what());
    return 2;
  }
}
