// Cost of sensing that is not done for all sensors in every step.
//
//   near    a skin of 10,000 sensors under a small body: only the packets near it are looked at
//   every   the same skin under a plate with a curved mesh, rays cast every k-th step
//   substep    one substep of a haptic loop, rays cast in each or once a step
//   off     a patch that is switched off
//
// Times are processor time of the thread, medians of 11 runs, in microseconds.
// Usage: benchmark_sensing_rate_cost [near|every|substep|off]
//        benchmark_sensing_rate_cost near|near_mesh|wide|wide_mesh STEPS
// The second takes that many steps under a small ball or one of 0.5 m and prints nothing, for
// `valgrind --tool=callgrind`.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/thread_clock.hpp"

#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

using namespace bristle;

namespace {

/// `side` x `side` sensors that look up from z = 0, 1 mm apart and 10 mm long.
template <Scalar S>
PatchDef<S> skin(std::size_t side) {
  PatchDef<S> def;
  const S width = S(0.001) * S(side);
  def.sensors = sensor_grid<S>({.center = {0, 0, S(0.005)},
                                .side_u = {width, 0, 0},
                                .side_v = {0, width, 0},
                                .count_u = side,
                                .count_v = side});
  def.parameters = {S(0.1), S(0.001), S(1000), S(0.1), S(1e-3)};
  def.integration = Integration::explicit_;
  return def;
}

/// A skin on a fixed body, and a kinematic one that slides over it to and fro.
template <Scalar S>
struct Sliding {
  World<S> world{WorldDef<S>{.time_step = S(1e-3)}};
  PatchId patch{};
  BodyId body{};
  int steps = 0;

  Sliding(const PatchDef<S>& def, const Shape<S>& shape, S height) {
    patch = world.add_patch(world.add_body({.motion = Motion::fixed}), def);
    body =
        world.add_body({.motion = Motion::kinematic, .shape = shape, .position = {0, 0, height}});
  }
  void step() {
    const S speed = S(0.05) * (++steps / 200 % 2 == 0 ? S(1) : S(-1));
    world.set_velocity(body, {{speed, 0, 0}, Vec3<S>::Zero()});
    world.step();
  }
};

/// A ball, or its mesh, 0.4 mm deep in the reach of the skin (5 mm where it is wide): some 25
/// sensors touch it, or all.
template <Scalar S>
Sliding<S> ball(bool is_wide, bool is_mesh, std::uint32_t cast_every = 1) {
  const S radius = is_wide ? S(0.5) : S(0.01);
  PatchDef<S> def = skin<S>(100);
  def.cast_every = cast_every;
  return {def, is_mesh ? Shape<S>(sphere_mesh<S>(radius, 22)) : Shape<S>(Sphere<S>{radius}),
          is_wide ? S(0.505) : S(0.0196)};
}

template <Scalar S>
void measure_near(const char* scalar) {
  auto scene = ball<S>(false, false);
  for (int i = 0; i < 100; ++i) scene.step();
  const double step = benchmarks::median_nanoseconds([&] { scene.step(); });
  std::printf("near   %-6s  10000 sensors, %zu touch: %.2f us a step, %llu rays\n", scalar,
              scene.world.reading(scene.patch).touching(), step / 1000,
              static_cast<unsigned long long>(scene.world.report().rays_cast));
}

template <Scalar S>
void measure_every(const char* scalar) {
  for (const bool is_mesh : {false, true}) {
    for (const std::uint32_t k : {1u, 2u, 4u, 8u}) {
      auto scene = ball<S>(true, is_mesh, k);
      for (int i = 0; i < 100; ++i) scene.step();
      // Whole rounds of k steps.
      const double step = benchmarks::median_nanoseconds([&] {
                            for (int i = 0; i < 8; ++i) scene.step();
                          }) /
                          8;
      std::printf("every  %-6s  %-6s  k = %u: %.1f us a step, %zu touch\n", scalar,
                  is_mesh ? "mesh" : "sphere", k, step / 1000,
                  scene.world.reading(scene.patch).touching());
    }
  }
}

template <Scalar S>
void measure_substep(const char* scalar) {
  for (const std::size_t side : {4u, 10u, 32u, 100u}) {
    for (const std::uint32_t every : {1u, 16u}) {
      World<S> world({.time_step = S(1) / S(60)});
      world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
      world.add_body({.mass = S(0.5),
                      .shape = Box<S>{{S(0.06), S(0.06), S(0.02)}},
                      .position = {0, 0, S(0.02)}});
      const BodyId stylus =
          world.add_body({.motion = Motion::kinematic, .position = {0, 0, S(0.046)}});
      HapticLoop<S> loop({.substeps = 16});
      const ToolId tool = loop.add_tool(stylus);
      PatchDef<S> pad = skin<S>(side);
      pad.cast_every = every;
      pad.parameters.normal_stiffness = S(10) / S(side * side);
      const ToolPatchId patch = loop.add_patch(tool, pad);
      const Quat<S> upside_down(0, 1, 0, 0);
      world.open(loop);
      const auto run = [&] {
        for (int i = 0; i < 16; ++i) {
          loop.move(tool, {upside_down, {0, 0, S(0.046)}});
          loop.substep();
        }
      };
      run();
      world.step(loop);
      // Without the steps of the world: the loop is opened anew.
      const double substep = benchmarks::median_nanoseconds([&] {
                               world.open(loop);
                               run();
                             }) /
                             16;
      std::printf("substep   %-6s  %5zu sensors, rays every %2u: %.2f us, %zu touch\n", scalar,
                  side * side, every, substep / 1000, loop.reading(patch).touching());
    }
  }
}

template <Scalar S>
void measure_off(const char* scalar) {
  World<S> world({.time_step = S(1e-3)});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  const auto step = [&] { return benchmarks::median_nanoseconds([&] { world.step(); }); };
  const BodyId body = world.add_body({.motion = Motion::kinematic, .position = {0, 0, S(-0.005)}});
  const double without = step();
  const int patches = 100;
  for (int i = 0; i < patches; ++i) world.set_active(world.add_patch(body, skin<S>(10)), false);
  std::printf("off    %-6s  a patch of 100 sensors on the floor, switched off: %.2f ns\n", scalar,
              (step() - without) / patches);
}

}  // namespace

int main(int argc, char** argv) {
  const std::string only = argc > 1 ? argv[1] : "";
  if (argc > 2) {
    auto scene = ball<double>(only.starts_with("wide"), only.ends_with("_mesh"));
    for (int i = 0; i < std::atoi(argv[2]); ++i) scene.step();
    return 0;
  }
  const auto is_chosen = [&](const char* name) { return only.empty() || only == name; };
  if (is_chosen("near")) measure_near<double>("double"), measure_near<float>("float");
  if (is_chosen("every")) measure_every<double>("double"), measure_every<float>("float");
  if (is_chosen("substep")) measure_substep<double>("double"), measure_substep<float>("float");
  if (is_chosen("off")) measure_off<double>("double"), measure_off<float>("float");
}
