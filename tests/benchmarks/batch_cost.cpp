// Cost of a batch of worlds: two pads of n x n sensors hold a part, in 1024 worlds that differ in
// its mass. The fingers of `pads` stand still; those of `grip` are driven along slides by motors.
//
//   one      a single world, warm
//   loop     a loop over worlds, one step each
//   batch    WorldBatch: one step each; eight steps each; the same on two threads (by the clock on
//            the wall, so only on a machine that does nothing else)
//   reset    all worlds put back
//   gather   all taxels copied out
//
// Times are medians of seven runs, microseconds a world and step; memory is what the C library has
// given out, kB a world. `error` is the number of worlds of a batch on two threads whose state is
// not that of the same world stepped alone, to the last bit. Where MuJoCo is installed it steps as
// many grips by its own contacts, without taxels.
// Usage: benchmark_batch_cost [WORLDS]
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/thread_clock.hpp"
#if defined(BRISTLE_WITH_MUJOCO)
#include "benchmarks/mujoco_batch.hpp"
#endif

#include <bristle/bristle.hpp>
#include <bristle/core/thread_pool.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <malloc.h>
#include <vector>

using namespace bristle;

namespace {

[[nodiscard]] double wall_seconds() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double>(now).count();
}

/// [us] Median of seven runs, shared by `parts`.
template <typename Clock, typename Call>
[[nodiscard]] double median(const Clock& clock, double parts, Call&& call) {
  std::array<double, 7> times;
  for (double& time : times) {
    const double start = clock();
    call();
    time = clock() - start;
  }
  std::sort(times.begin(), times.end());
  return 1e6 * times[3] / parts;
}

/// How the pads are pressed.
enum class Fingers { still, driven };

template <typename S>
struct Grip {
  World<S> world{WorldDef<S>{.time_step = S(1e-3)}};
  BodyId part{};
  std::array<PatchId, 2> pads{};

  Grip(int side, Fingers fingers) {
    const S half = S(0.03);
    part = world.add_body({.mass = S(0.5), .shape = Box<S>{{half, half, half}}});
    for (const int k : {0, 1}) {
      const S inwards = k == 0 ? S(1) : S(-1);
      const bool is_driven = fingers == Fingers::driven;
      const BodyId finger =
          world.add_body({.motion = is_driven ? Motion::dynamic : Motion::kinematic,
                          .mass = is_driven ? S(0.1) : S(0),
                          .shape = Box<S>{{S(0.01), S(0.02), S(0.02)}},
                          .position = {-inwards * S(0.046), S(0), S(0)}});
      if (is_driven) {
        JointDef<S> slide;
        slide.kind = JointKind::prismatic;
        slide.body_b = finger;
        slide.X_AJ.translation = world.body(finger).pose().translation;
        slide.motor = {.mode = MotorMode::velocity, .target = inwards, .max_force = S(20)};
        (void)world.add_joint(slide);
      }
      PatchDef<S> pad;
      for (int i = 0; i < side * side; ++i) {
        const S u = (S(i % side) + S(0.5)) / S(side) - S(0.5);
        const S v = (S(i / side) + S(0.5)) / S(side) - S(0.5);
        pad.sensors.add({inwards * S(0.0095), S(0.036) * u, S(0.036) * v}, {inwards, S(0), S(0)},
                        S(0.01));
      }
      const S share = S(20) / S(side * side);
      pad.parameters = {share / S(0.35), S(0.005) * share, S(1000), S(0.5), S(1e-3)};
      pads[static_cast<std::size_t>(k)] = world.add_patch(finger, pad);
    }
    for (int i = 0; i < 200; ++i) world.step();
  }
};

[[nodiscard]] double megabytes_in_use() {
  const struct mallinfo2 info = mallinfo2();
  return 1e-6 * static_cast<double>(info.uordblks + info.hblkhd);
}

template <typename S>
void measure(const char* scalar, int side, Fingers fingers, std::size_t count) {
  const Grip<S> grip(side, fingers);
  const auto vary = [&](std::size_t i, World<S>& world) {
    world.set_mass(grip.part, S(0.2) + S(0.5) * S(i) / S(count));
  };
  const double worlds = static_cast<double>(count);
  World<S> single(grip.world);
  for (int i = 0; i < 100; ++i) single.step();
  const double one = median(benchmarks::thread_seconds, 500, [&] {
    for (int i = 0; i < 500; ++i) single.step();
  });

  std::vector<World<S>> loop(count, grip.world);
  for (std::size_t i = 0; i < count; ++i) vary(i, loop[i]);
  const auto step_loop = [&] {
    for (World<S>& world : loop) world.step();
  };
  for (int i = 0; i < 3; ++i) step_loop();
  const double of_loop = median(benchmarks::thread_seconds, worlds, step_loop);
  loop.clear();
  loop.shrink_to_fit();

  const double before = megabytes_in_use();
  WorldBatch<S> batch(grip.world, count);
  batch.for_each(vary);
  batch.step(3);
  const double kilobytes = 1e3 * (megabytes_in_use() - before) / worlds;
  const double by_one = median(benchmarks::thread_seconds, worlds, [&] { batch.step(); });
  const double by_eight = median(benchmarks::thread_seconds, 8 * worlds, [&] { batch.step(8); });
  const double by_eight_wall = median(wall_seconds, 8 * worlds, [&] { batch.step(8); });
  std::vector<S> taxels(count * 2 * tactile_channel_count * std::size_t(side * side));
  const double gather =
      median(benchmarks::thread_seconds, worlds, [&] { batch.gather_taxels(grip.pads, taxels); });
  const double reset = median(benchmarks::thread_seconds, worlds, [&] { batch.reset(); });

  ThreadPool pool(2);
  WorldBatch<S> shared(grip.world, count, pool.hook());
  shared.for_each(vary);
  shared.step(3);
  const double two = median(wall_seconds, 8 * worlds, [&] { shared.step(8); });
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < count; i += std::max<std::size_t>(1, count / 16)) {
    World<S> alone(grip.world);
    vary(i, alone);
    for (int k = 0; k < 3 + 7 * 8; ++k) alone.step();
    wrong += alone.state_hash() == shared.world(i).state_hash() ? 0u : 1u;
  }
  const double readings = 2.0 * side * side / by_eight;
  std::printf("%-7s%s 2x%-4d %6.2f %6.2f %6.2f %6.2f %6.2f %8.2f %7.2f %7.2f %7.0f %8.1f %6zu\n",
              scalar, fingers == Fingers::driven ? "grip" : "pads", side * side, one, of_loop,
              by_one, by_eight, two, by_eight_wall / two, reset, gather, kilobytes, readings,
              wrong);
}

#if defined(BRISTLE_WITH_MUJOCO)
void measure_mujoco(std::size_t count) {
  benchmarks::MujocoBatch batch(count);
  const double worlds = static_cast<double>(count);
  const double one = median(benchmarks::thread_seconds, 500, [&] { batch.step(0, 500); });
  const auto step_all = [&](int steps) {
    for (std::size_t i = 0; i < count; ++i) batch.step(i, steps);
  };
  const double by_one = median(benchmarks::thread_seconds, worlds, [&] { step_all(1); });
  const double by_eight = median(benchmarks::thread_seconds, 8 * worlds, [&] { step_all(8); });
  const double by_eight_wall = median(wall_seconds, 8 * worlds, [&] { step_all(8); });
  ThreadPool pool(2);
  const auto hook = pool.hook();
  const double two = median(wall_seconds, 8 * worlds,
                            [&] { hook(count, [&](std::size_t i) { batch.step(i, 8); }); });
  std::printf("MuJoCo grip %d con. %6.2f        %6.2f %6.2f %6.2f %8.2f\n", batch.contacts(0), one,
              by_one, by_eight, two, by_eight_wall / two);
}
#endif

}  // namespace

int main(int argc, char** argv) {
  const std::size_t count = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1024;
  if (count == 0) {
    std::fprintf(stderr, "WORLDS must be > 0\n");
    return 2;
  }
  std::puts("                                     batch                 threads");
  std::puts(
      "            taxels    one   loop    x1     x8   two x8   gain   reset  gather      kB  M "
      "taxel/s  error");
  for (const Fingers fingers : {Fingers::still, Fingers::driven}) {
    for (const int side : {6, 16}) {
      measure<float>("float", side, fingers, count);
      measure<double>("double", side, fingers, count);
    }
  }
#if defined(BRISTLE_WITH_MUJOCO)
  measure_mujoco(count);
#endif
}
