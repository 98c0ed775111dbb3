/// @file
/// Gain by wider registers: time of a step, and hash of the resulting state, for each instruction
/// set of the compiled library (preset `release`), or for the one that headers are compiled for
/// (preset `native`). Their difference is the loss of a program that is built for every processor.
///
///     benchmark_instruction_sets [part of a scene's name [instruction set]]
///
/// On a machine whose speed varies, run both programs in turn for one scene after the other.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/thread_clock.hpp"
#include "scenes/grasp.hpp"
#include "scenes/pile.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <string>

using namespace bristle;

namespace {

/// A ball of 1 kg on a pad of n sensors, as a sphere or as a mesh of 9680 triangles.
template <typename S>
World<S> ball_on_pad(std::size_t n, bool is_mesh, Integration integration) {
  World<S> world({.gravity = {0, 0, S(-9.81)}, .time_step = S(1e-3)});
  const BodyId pad =
      world.add_body({.motion = Motion::fixed, .shape = Box<S>{{S(0.1), S(0.1), S(0.01)}}});
  BodyDef<S> ball;
  ball.mass = S(1);
  ball.position = {S(0.003), S(0.002), S(0.0595)};
  if (is_mesh) {
    ball.shape = sphere_mesh<S>(S(0.05), 22);
  } else {
    ball.shape = Sphere<S>{S(0.05)};
  }
  world.add_body(ball);
  const auto side = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(n))));
  PatchDef<S> def;
  def.sensors = sensor_grid<S>({.center = {0, 0, S(0.01)},
                                .side_u = {S(0.1), 0, 0},
                                .side_v = {0, S(0.1), 0},
                                .count_u = side,
                                .count_v = side,
                                .depth = S(0.002),
                                .range = S(0.004)});
  def.parameters =
      tuned_for<S>({.friction = S(0.8), .creep = S(1e-3), .load = S(9.81)}).parameters(def.sensors);
  def.integration = integration;
  world.add_patch(pad, def);
  return world;
}

template <typename S>
World<S> pyramid(int rows) {
  World<S> world({.time_step = S(1) / S(240)});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < rows - i; ++k) {
      world.add_body({.mass = S(1),
                      .shape = Box<S>{{S(0.1), S(0.1), S(0.1)}},
                      .position = {S(0.201 * k - 0.1 * (rows - i)), 0, S(0.1 + 0.2 * i)}});
    }
  }
  return world;
}

template <typename S>
World<S> sliding_boxes() {
  World<S> world({.time_step = S(1) / S(240)});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  for (int i = 0; i < 16; ++i) {
    const BodyId box = world.add_body({.mass = S(1),
                                       .shape = Box<S>{{S(0.1), S(0.1), S(0.1)}},
                                       .position = {S(0.5 * i), 0, S(0.1)}});
    world.set_velocity(box, {{0, S(8), 0}, {0, 0, 0}});
  }
  return world;
}

/// A chain of twelve hinges that swings: the mechanism's own integrator.
template <typename S>
World<S> chain() {
  World<S> world({.time_step = S(1) / S(240)});
  BodyId last{};
  for (int i = 0; i < 12; ++i) {
    const BodyId link = world.add_body({.mass = S(0.2),
                                        .shape = Capsule<S>{S(0.02), S(0.05)},
                                        .position = {S(-0.15) * S(i + 1), 0, 0}});
    JointDef<S> joint;
    joint.kind = JointKind::revolute;
    joint.body_a = last;
    joint.body_b = link;
    joint.X_AJ.translation = {S(-0.075), 0, 0};
    joint.X_BJ.translation = {S(0.075), 0, 0};
    world.add_joint(joint);
    last = link;
  }
  return world;
}

/// What to measure; empty means all.
std::string wanted_scene, wanted_set;

/// Prints the least time of five runs. Where last bits decide a scene's course, as in a pile, one
/// course says little about registers: then the mean over `courses` scenes that start alike but for
/// a little, `make(0)` to `make(courses - 1)`.
template <typename Make>
void measure(const char* set, const char* scalar, const std::string& scene, int steps,
             const Make& make, int courses = 1) {
  if (scene.find(wanted_scene) == std::string::npos) return;
  double sum = 0;
  std::uint64_t hash = 0;
  for (int course = 0; course < courses; ++course) {
    double least = std::numeric_limits<double>::infinity();
    std::uint64_t end = 0;
    for (int run = 0; run < 5; ++run) {
      auto world = make(course);
      for (int i = 0; i < steps / 4; ++i) world.step();
      const double start = benchmarks::thread_seconds();
      for (int i = 0; i < steps; ++i) world.step();
      least = std::min(least, (benchmarks::thread_seconds() - start) / steps);
      end = world.state_hash();
    }
    sum += least;
    hash = 31 * hash + end;
  }
  std::printf("| %s | %s | %s | %.2f | %016llx |\n", scene.c_str(), scalar, set,
              1e6 * sum / courses, static_cast<unsigned long long>(hash));
}

template <typename S>
void measure_all(const char* set, const char* scalar) {
  for (const std::size_t n : {std::size_t{1024}, std::size_t{10000}}) {
    const std::string of = " of " + std::to_string(n);
    const int steps = n > 2000 ? 100 : 500;
    const auto pad = [&](bool is_mesh, Integration integration) {
      return [=](int) { return ball_on_pad<S>(n, is_mesh, integration); };
    };
    measure(set, scalar, "ball on a pad" + of, steps, pad(false, Integration::implicit));
    measure(set, scalar, "mesh on a pad" + of, steps, pad(true, Integration::implicit));
    measure(set, scalar, "mesh on an explicit pad" + of, steps, pad(true, Integration::explicit_));
  }
  measure(set, scalar, "pyramid of 210", 60, [](int) { return pyramid<S>(20); });
  measure(set, scalar, "pyramid of 15", 200, [](int) { return pyramid<S>(5); });
  measure(set, scalar, "16 boxes that slide", 150, [](int) { return sliding_boxes<S>(); });
  measure(set, scalar, "grip by two fingers", 500,
          [](int) { return scenes::make_grasp<S>({.finger_mass = S(0.2)}).world; });
  measure(set, scalar, "chain of 12 hinges", 200, [](int) { return chain<S>(); });
  // Gravity leans by some thousandths.
  const auto pile = [](int course) {
    return scenes::make_pile<S>(
               {.gravity = {S(0.01) * S(course), 0, S(-9.81)}, .time_step = S(1) / S(240)}, 6)
        .world;
  };
  measure(set, scalar, "piles of 96 and 7 patches", 150, pile, 12);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc > 1) wanted_scene = argv[1];
  if (argc > 2) wanted_set = argv[2];
  std::puts("| scene | scalar | registers | us a step | state |\n|---|---|---|---|---|");
#if defined(BRISTLE_COMPILED)
  for (const InstructionSet set :
       {InstructionSet::baseline, InstructionSet::v3, InstructionSet::v4}) {
    if (set > widest_instruction_set()) break;
    set_instruction_set(set);
    const std::string name(name_of(set));
    if (!wanted_set.empty() && wanted_set != name) continue;
    measure_all<float>(name.c_str(), "float");
    measure_all<double>(name.c_str(), "double");
  }
#else
  measure_all<float>("headers", "float");
  measure_all<double>("headers", "double");
#endif
}
