/// @file
/// Runs scenes with each chosen constant at half and at twice its value.
///
/// Prints, for each, how many scenes changed, the largest error relative to what it was and where,
/// the solver's work and the processor time relative to what they were, the scenes that passed and
/// no longer do, and those that take more work than `is_dearer` allows. `--check` fails if there
/// are any of these. `--all` adds scenes that take long and need not pass, `--constants TEXT`
/// selects by name, and `--markdown` prints tables for a page.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/benchmark_table.hpp"
#include "benchmarks/thread_clock.hpp"
#include "benchmarks/work_precision/drivers/bristle_driver.hpp"
#include "constants/scaled.hpp"
#include "scenes/rigid/catalogue.hpp"
#include "scenes/shots.hpp"
#include "support/random.hpp"
#include "support/ray_patches.hpp"

#include <bristle/core/core_constants.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/hosts/hosts_constants.hpp>
#include <bristle/io/io_constants.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/ray_fan.hpp>
#include <bristle/world/proximity.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace {

using namespace bristle;
using benchmarks::in_full;
using benchmarks::in_short;
using benchmarks::Table;

/// [1] Bound on the work of a scene, relative to that with the constants as they are, and how many
/// sweeps and factorisations more are no matter: some scenes have a handful.
constexpr double most_work = 2.5;
constexpr double more_sweeps = 600;
constexpr double more_factorisations = 60;

/// Smaller errors [m, m/s, 1] matter to nobody: a ratio is that to this.
constexpr double least_error = 1e-6;

/// What a scene costs.
struct Work {
  double factorisations = 0;
  double sweeps = 0;
  /// [s] Processor time.
  double seconds = 0;

  Work& operator+=(const Work& more) {
    factorisations += more.factorisations;
    sweeps += more.sweeps;
    seconds += more.seconds;
    return *this;
  }
};

/// Returns whether the solver works more than the bound allows.
bool is_dearer(const Work& now, const Work& before) {
  return now.factorisations > most_work * before.factorisations + more_factorisations ||
         now.sweeps > most_work * before.sweeps + more_sweeps;
}

/// Outcome of a scene.
struct Result {
  double error = 0;
  bool passes = false;
  Work work{};
};

/// A scene by name.
struct Scene {
  std::string name;
  std::function<Result()> run;
};

// Scenes of the work-precision benchmark ----------------------------------------------------------

/// A scene of the catalogue, and the step that it is run at.
struct Case {
  const char* scene;
  double dt;
  bool is_long = false;
};

constexpr Case cases[] = {{"slide30", 1.0 / 60},
                          {"incline_stick", 1.0 / 60},
                          {"incline_slip", 1.0 / 60},
                          {"roll", 1.0 / 60},
                          {"bounce08", 1.0 / 60},
                          {"chain10", 1.0 / 60},
                          {"stack10", 1.0 / 60},
                          {"stack1000", 1.0 / 60},
                          {"gripload90", 1.0 / 60},
                          {"gripoff", 1.0 / 60},
                          {"dragged", 1.0 / 60},
                          {"hand128", 1.0 / 240},
                          {"bricks20", 1.0 / 240},
                          {"pinched", 1.0 / 240},
                          {"pendulum_motor", 1.0 / 60},
                          {"pendulum_sensor", 1.0 / 60},
                          {"groove", 1.0 / 60},
                          {"cradle", 1.0 / 60},
                          {"overhang", 1.0 / 60},
                          {"lintel", 1.0 / 60},
                          {"wedge", 1.0 / 60},
                          {"toss", 1.0 / 60},
                          {"push24", 1.0 / 240, true},
                          {"belt48", 1.0 / 240, true},
                          {"pile200", 1.0 / 60, true},
                          {"bin64", 1.0 / 240, true},
                          {"ragdolls20", 1.0 / 240, true},
                          {"chain100", 1.0 / 240, true},
                          {"pyramid20", 1.0 / 60, true}};

Result run_trial(const scenes::Recipe& recipe, double dt) {
  Result result;
  const std::unique_ptr<scenes::Trial> trial = recipe.make(0);
  work_precision::BristleEngine<double> engine(trial->scene(), dt, "def");
  const long steps = std::lround(trial->scene().duration / dt);
  trial->observe(engine, {0, dt, 0});
  for (long i = 0; i < steps; ++i) {
    const double time = static_cast<double>(i) * dt;
    trial->prepare(engine, {time, dt, i});
    engine.step();
    result.work.factorisations += static_cast<double>(engine.counters().factorisations);
    result.work.sweeps += static_cast<double>(engine.counters().sweeps);
    trial->observe(engine, {time + dt, dt, i + 1});
  }
  const scenes::Outcome outcome = trial->outcome();
  result.error = outcome.error;
  result.passes = outcome.passes && std::isfinite(outcome.error);
  return result;
}

// Scenes for what no solver does ------------------------------------------------------------------

/// A number that constants may only change by so much [1] of what it was in the first run.
class FirstValue {
 public:
  explicit FirstValue(double may_change) : may_change_(may_change) {}
  [[nodiscard]] Result judge(double value) {
    if (!has_first_) first_ = value;
    has_first_ = true;
    Result result;
    result.error = std::abs(value - first_) / std::abs(first_);
    result.passes = result.error <= may_change_;
    return result;
  }

 private:
  double may_change_;
  double first_ = 0;
  bool has_first_ = false;
};

/// Shots at walls: the error is the number of those that pass.
Result shots() {
  Result result;
  for (std::uint64_t k = 0; k < 60; ++k) {
    const double dt = k % 2 == 0 ? 1.0 / 60 : 1.0 / 240;
    const auto wall = static_cast<scenes::ShotWall>(k % 4);
    if (scenes::shoot(scenes::shot_of(k, dt), wall, dt).has_passed) ++result.error;
  }
  result.passes = result.error == 0;
  return result;
}

/// Shapes that overlap at random: mean depth [m] of their deepest points. Other searches may end at
/// another of several equally deep places, and no search may end at deeper ones.
double mean_depth() {
  test::Random random(7);
  const auto shape = [&](std::uint64_t kind) -> Shape<double> {
    switch (kind) {
      case 0:
        return Box<double>{{0.1, 0.07, 0.05}};
      case 1:
        return Sphere<double>{0.08};
      case 2:
        return Capsule<double>{0.04, 0.08};
      case 3:
        return Cylinder<double>{0.06, 0.07};
      case 4:
        return Cone<double>{0.08, 0.16};
      case 5:
        return Ellipsoid<double>{{0.1, 0.07, 0.05}};
      default:
        return convex_hull(sphere_mesh<double>(0.08, 2));
    }
  };
  double sum = 0;
  for (std::uint64_t k = 0; k < 140; ++k) {
    World<double> world({.gravity = Vec3<double>::Zero(), .time_step = 1e-4});
    const Vec3<double> apart = random.direction<double>() * random.uniform(0.06, 0.11);
    (void)world.add_body({.mass = 1.0, .shape = shape(k % 7)});
    (void)world.add_body({.mass = 1.0,
                          .shape = shape(k / 7 % 7),
                          .position = apart,
                          .orientation = random.rotation<double>()});
    world.step();
    double deepest = 0;
    world.for_each_contact([&](const ContactReading<double>& contact) {
      contact.for_each_point([&](const auto& point) { deepest = std::min(deepest, point.gap); });
    });
    sum -= deepest;
  }
  return sum / 140;
}

/// Rings fall into a bowl of triangles: error is how far [m] a ring is from where it may be.
Result rings() {
  World<double> world({.time_step = 1.0 / 240});
  for (const double side : {-1.0, 1.0}) {
    world.add_body({.motion = Motion::fixed,
                    .shape = HalfSpace<double>{Vec3<double>(side, 0, 1).normalized(), 0}});
    world.add_body({.motion = Motion::fixed,
                    .shape = HalfSpace<double>{Vec3<double>(0, side, 1).normalized(), 0}});
  }
  TriangleMesh<double> ring = test::torus_mesh(16, 6);
  for (int i = 0; i < 3; ++i) {
    (void)world.add_body({.mass = 1.0,
                          .shape = ring,
                          .position = {0.01 * i, 0, 0.2 + 0.12 * i},
                          .orientation = exp_rotation<double>({1.0 * i, 2.0 * i, 1})});
  }
  Result result;
  for (int n = 0; n < 120; ++n) world.step();
  world.for_each_contact([&](const ContactReading<double>& contact) {
    contact.for_each_point(
        [&](const auto& point) { result.error = std::max(result.error, -point.gap); });
  });
  result.passes = result.error < 0.01;
  return result;
}

/// A pad of 900 rays that follows a ball of 2880 triangles, near and far, rolls over its edge and
/// lifts off; and a fan around 40 balls: sum of the readings.
double readings() {
  World<double> world({.gravity = Vec3<double>::Zero(), .time_step = 1e-3});
  (void)world.add_body({.motion = Motion::fixed, .shape = sphere_mesh<double>(0.05, 12)});
  const BodyId pad = world.add_body({.motion = Motion::kinematic, .position = {0, 0, 0.055}});
  PatchDef<double> def;
  def.sensors = sensor_grid<double>({.side_u = {0, 0.04, 0},
                                     .side_v = {0.04, 0, 0},
                                     .count_u = 30,
                                     .count_v = 30,
                                     .depth = 0.004,
                                     .range = 0.008});
  def.parameters = {0.1, 0.01, 500, 0.1, 1e-3};
  const PatchId patch = world.add_patch(pad, def);
  double sum = 0;
  for (int n = 0; n < 40; ++n) {
    const double way = 2e-4 * n * (n < 20 ? 1 : 10);
    world.move_to(pad, {Quat<double>::Identity(), {way, 0, 0.055 + 0.2 * way}});
    world.step();
    sum += world.reading(patch).wrench.force.norm();
  }
  test::Random random(3);
  for (int i = 0; i < 40; ++i) {
    (void)world.add_body({.motion = Motion::fixed,
                          .shape = sphere_mesh<double>(0.2, 5),
                          .position = random.direction<double>() * 3.0});
  }
  ProximityArray<double> fan(ray_fan<double>({.width = 2 * std::numbers::pi,
                                              .height = 1,
                                              .columns = 120,
                                              .rows = 8,
                                              .start = 0.1,
                                              .range = 5}));
  world.sense(pad, fan);
  for (std::size_t i = 0; i < fan.size(); ++i) {
    if (std::isfinite(fan.distance()[i])) sum += fan.distance()[i];
  }
  return sum;
}

/// All scenes, or those that are short.
std::vector<Scene> make_scenes(bool with_long) {
  std::vector<Scene> scenes;
  const std::vector<scenes::Recipe> catalogue = scenes::catalogue();
  for (const Case& c : cases) {
    if (c.is_long && !with_long) continue;
    const auto found = std::find_if(catalogue.begin(), catalogue.end(),
                                    [&](const auto& recipe) { return recipe.name == c.scene; });
    if (found == catalogue.end()) {
      std::fprintf(stderr, "no scene %s\n", c.scene);
      std::exit(2);
    }
    scenes.push_back({c.scene, [recipe = *found, c] { return run_trial(recipe, c.dt); }});
  }
  scenes.push_back({"shots", shots});
  scenes.push_back({"rings", rings});
  // Depth is that of a point found by search, to the accuracy of the search.
  scenes.push_back(
      {"depths", [first = FirstValue(0.01)]() mutable { return first.judge(mean_depth()); }});
  // No reading depends on how rays are cast, but by round-off.
  scenes.push_back(
      {"readings", [first = FirstValue(1e-6)]() mutable { return first.judge(readings()); }});
  return scenes;
}

[[nodiscard]] Result timed(Scene& scene) {
  const double start = benchmarks::thread_seconds();
  Result result = scene.run();
  result.work.seconds = benchmarks::thread_seconds() - start;
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  std::string only;
  bool checks = false;
  bool with_long = false;
  bool is_markdown = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--check") {
      checks = true;
    } else if (option == "--all") {
      with_long = true;
    } else if (option == "--markdown") {
      is_markdown = true;
    } else if (option == "--constants" && i + 1 < argc) {
      only = argv[++i];
    } else {
      std::fprintf(stderr,
                   "usage: half_and_twice [--check] [--all] [--markdown] [--constants TEXT]\n");
      return 2;
    }
  }
  std::vector<Scene> all_scenes = make_scenes(with_long);
  std::vector<Result> before;
  Work total;
  {
    Table table(is_markdown, {"           scene", "    error", "passes", "factorisations",
                              "  sweeps", "time [ms]"});
    for (Scene& scene : all_scenes) {
      (void)timed(scene);  // The first run finds cold caches.
      before.push_back(timed(scene));
      const Result& r = before.back();
      total += r.work;
      table.add({scene.name, in_short(r.error), r.passes ? "yes" : "no",
                 in_full(r.work.factorisations), in_full(r.work.sweeps),
                 in_short(1e3 * r.work.seconds)});
    }
  }
  if (bristle_constants::all().size() != CONSTANT_ROWS) {
    std::fprintf(stderr, "%zu constants are seen, and the tables have %d\n",
                 bristle_constants::all().size(), CONSTANT_ROWS);
    return 1;
  }
  bool is_good = std::all_of(before.begin(), before.end(),
                             [&](const Result& r) { return r.passes || with_long; });
  int seen = 0;
  Table table(is_markdown, {"                    constant", "    value", "times", "scenes changed",
                            "largest error", "           there", "factorisations", "sweeps",
                            "    time", "lost", "dearer"});
  for (const bristle_constants::Constant& constant : bristle_constants::all()) {
    if (constant.name.find(only) == std::string::npos) continue;
    ++seen;
    for (const double factor : {0.5, 2.0}) {
      constant.scale(factor);
      Work work;
      std::string lost;
      std::string dearer;
      double largest = 0;
      std::string where;
      int changed = 0;
      for (std::size_t k = 0; k < all_scenes.size(); ++k) {
        const Result r = timed(all_scenes[k]);
        work += r.work;
        if (before[k].passes && !r.passes) lost += " " + all_scenes[k].name;
        if (is_dearer(r.work, before[k].work)) dearer += " " + all_scenes[k].name;
        if (r.error == before[k].error) continue;
        ++changed;
        const double ratio = r.error / std::max(before[k].error, least_error);
        if (ratio > largest) {
          largest = ratio;
          where = all_scenes[k].name;
        }
      }
      constant.scale(1);
      const double factorisations = work.factorisations / total.factorisations;
      const double sweeps = work.sweeps / total.sweeps;
      is_good = is_good && lost.empty() && dearer.empty();
      table.add({constant.name, in_full(constant.value), factor < 1 ? "1/2" : "2",
                 std::to_string(changed), changed > 0 ? in_short(largest) : "", where,
                 in_short(factorisations), in_short(sweeps), in_short(work.seconds / total.seconds),
                 lost, dearer});
    }
  }
  if (seen == 0) {
    std::fprintf(stderr, "no constant is named like %s\n", only.c_str());
    return 2;
  }
  return checks && !is_good ? 1 : 0;
}
