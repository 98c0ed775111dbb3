/// @file
/// Runs scenes with each measured constant at half and at twice its value.
///
/// Prints the scenes that no longer pass and the work of the solver, as parts of what it was.
/// With `--check` it fails if a scene that passed no longer does, or if the work is more than
/// `most_work` times what it was. `--scenes a,b` and `--constants text` select.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/thread_clock.hpp"
#include "benchmarks/work_precision/drivers/bristle_driver.hpp"
#include "constants/scaled.hpp"
#include "scenes/rigid/catalogue.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace bristle;

/// [1] Bound on the work of all scenes, relative to that with the constants as they are.
constexpr double most_work = 1.5;

/// A scene, and the step that it is run at.
struct Case {
  const char* scene;
  double dt;
};

/// Scenes that reach each table's constants, and are short.
constexpr Case cases[] = {
    {"slide30", 1.0 / 60},  {"incline_stick", 1.0 / 60},  {"incline_slip", 1.0 / 60},
    {"roll", 1.0 / 60},     {"bounce08", 1.0 / 60},       {"chain10", 1.0 / 60},
    {"stack10", 1.0 / 60},  {"stack1000", 1.0 / 60},      {"gripload90", 1.0 / 60},
    {"gripoff", 1.0 / 60},  {"push24", 1.0 / 240},        {"belt48", 1.0 / 240},
    {"dragged", 1.0 / 60},  {"hand128", 1.0 / 240},       {"ragdolls20", 1.0 / 60},
    {"chain100", 1.0 / 60}, {"bricks20", 1.0 / 60},       {"bin64", 1.0 / 60},
    {"drum60", 1.0 / 60},   {"pinched", 1.0 / 240},       {"topple20", 1.0 / 240},
    {"pile200", 1.0 / 60},  {"pendulum_motor", 1.0 / 60}, {"pendulum_sensor", 1.0 / 60},
    {"groove", 1.0 / 60},   {"cradle", 1.0 / 60},         {"overhang", 1.0 / 60},
    {"lintel", 1.0 / 60},   {"wedge", 1.0 / 60},          {"toss", 1.0 / 60},
};

/// Outcome of a case.
struct Result {
  double error = 0;
  bool passes = false;
  double factorisations = 0;
  double sweeps = 0;
  double seconds = 0;
};

Result run(const scenes::Recipe& recipe, double dt) {
  Result result;
  const std::unique_ptr<scenes::Trial> trial = recipe.make(0);
  work_precision::BristleEngine<double> engine(trial->scene(), dt, "def");
  const double start = benchmarks::thread_seconds();
  const long steps = std::lround(trial->scene().duration / dt);
  trial->observe(engine, {0, dt, 0});
  for (long i = 0; i < steps; ++i) {
    const double time = static_cast<double>(i) * dt;
    trial->prepare(engine, {time, dt, i});
    engine.step();
    result.factorisations += static_cast<double>(engine.counters().factorisations);
    result.sweeps += static_cast<double>(engine.counters().sweeps);
    trial->observe(engine, {time + dt, dt, i + 1});
  }
  result.seconds = benchmarks::thread_seconds() - start;
  const scenes::Outcome outcome = trial->outcome();
  result.error = outcome.error;
  result.passes = outcome.passes && std::isfinite(outcome.error);
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  std::string only_scenes, only_constants;
  bool checks = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--check") checks = true;
    if (option == "--scenes" && i + 1 < argc) only_scenes = "," + std::string(argv[++i]) + ",";
    if (option == "--constants" && i + 1 < argc) only_constants = argv[++i];
  }
  const std::vector<scenes::Recipe> catalogue = scenes::catalogue();
  std::vector<const scenes::Recipe*> recipes;
  std::vector<Case> chosen;
  std::vector<Result> before;
  for (const Case& c : cases) {
    if (!only_scenes.empty() &&
        only_scenes.find("," + std::string(c.scene) + ",") == std::string::npos)
      continue;
    const auto found = std::find_if(catalogue.begin(), catalogue.end(),
                                    [&](const auto& recipe) { return recipe.name == c.scene; });
    if (found == catalogue.end()) {
      std::printf("no scene %s\n", c.scene);
      return 1;
    }
    chosen.push_back(c);
    recipes.push_back(&*found);
    before.push_back(run(*found, c.dt));
    const Result& r = before.back();
    std::printf("%-16s %10.3g %s %8.0f factorisations %8.0f sweeps %.3f s\n", c.scene, r.error,
                r.passes ? "passes" : "FAILS ", r.factorisations, r.sweeps, r.seconds);
  }
  std::printf("%zu constants\n", bristle_constants::all().size());
  bool is_good = true;
  for (const bristle_constants::Constant& constant : bristle_constants::all()) {
    if (constant.name.find(only_constants) == std::string::npos) continue;
    for (const double factor : {0.5, 2.0}) {
      constant.scale(factor);
      double factorisations = 0, sweeps = 0, seconds = 0, f0 = 0, s0 = 0, t0 = 0;
      std::string lost;
      double worst = 0;
      std::size_t worst_at = 0, changed = 0;
      for (std::size_t k = 0; k < recipes.size(); ++k) {
        const Result r = run(*recipes[k], chosen[k].dt);
        factorisations += r.factorisations, sweeps += r.sweeps, seconds += r.seconds;
        f0 += before[k].factorisations, s0 += before[k].sweeps, t0 += before[k].seconds;
        if (r.error != before[k].error) ++changed;
        const double ratio = r.error / std::max(before[k].error, 1e-12);
        if (ratio > worst) worst = ratio, worst_at = k;
        if (before[k].passes && !r.passes) lost += std::string(" ") + chosen[k].scene;
      }
      constant.scale(1);
      const bool holds =
          lost.empty() && factorisations <= most_work * f0 && sweeps <= most_work * s0;
      is_good = is_good && holds;
      std::printf(
          "%-32s %9.3g x %.1f: %2zu change, error <= %9.3g (%s), factorisations %.3f, sweeps %.3f, "
          "time %.2f%s%s%s\n",
          constant.name.c_str(), constant.value, factor, changed, worst,
          changed ? chosen[worst_at].scene : "-", factorisations / f0, sweeps / s0, seconds / t0,
          holds ? "" : " MATTERS", lost.empty() ? "" : ", lost:", lost.c_str());
      std::fflush(stdout);
    }
  }
  return checks && !is_good ? 1 : 0;
}
