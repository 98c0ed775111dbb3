/// @file
/// Heaps of many bodies that bounce, too large for a factorisation: chains of impacts that Newton's
/// law of restitution has no solution for must not blow up, at any step, restitution and friction.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/bouncing_heap.hpp"
#include "support/rounds.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

using namespace bristle;
using namespace bristle::scenes;

namespace {

/// Lets heaps of a kind bounce for 3 s and checks that none has ever more than `most_energy` times
/// its first energy.
void check_heaps(BouncingHeapDef def, int base, double most_energy) {
  double highest = 0;
  for (const double time_step : {1.0 / 60, 1.0 / 240}) {
    for (const double restitution : {0.5, 0.8, 1.0}) {
      for (int i = 0; i < test::rounds(base); ++i) {
        def.time_step = time_step;
        def.restitution = restitution;
        def.seed = static_cast<std::uint64_t>(i) + 1;
        CAPTURE(time_step);
        CAPTURE(restitution);
        CAPTURE(def.seed);
        BouncingHeap heap = make_bouncing_heap(def);
        const double start = heap.energy();
        double most = 0;
        bool is_sound = true;
        const long steps = std::lround(3 / time_step);
        for (long n = 0; n < steps; ++n) {
          heap.world.step();
          const double energy = heap.energy();
          const StepReport<double>& report = heap.world.report();
          is_sound = is_sound && std::isfinite(energy) && report.frozen_bodies == 0 &&
                     report.discarded_islands == 0;
          most = std::max(most, energy / start);
        }
        CHECK(is_sound);
        CHECK(most <= most_energy);
        highest = std::max(highest, most);
      }
    }
  }
  MESSAGE(def.count, def.has_balls ? " boxes and balls" : " boxes", ", friction ", def.friction,
          ": highest energy ", highest);
}

BouncingHeapDef swept_heap() {
  BouncingHeapDef def;
  def.solver.max_direct_work = 0;
  return def;
}

/// By the settings that a world has by itself.
BouncingHeapDef large_heap() {
  BouncingHeapDef def;
  def.count = 160;
  return def;
}

}  // namespace

// Impacts of several bodies at once may give a little, which friction soon takes; in 72 heaps with
// friction, 0.5 % was the most.
TEST_CASE("bouncing_heaps: boxes with friction gain next to no energy") {
  check_heaps(swept_heap(), 4, 1.01);
  check_heaps(large_heap(), 2, 1.01);
}

TEST_CASE("bouncing_heaps: boxes and balls with friction gain next to no energy") {
  BouncingHeapDef def = swept_heap();
  def.has_balls = true;
  check_heaps(def, 4, 1.01);
  def = large_heap();
  def.has_balls = true;
  check_heaps(def, 2, 1.01);
}

// Bodies that bounce with all their energy and without friction never lose any: 4 % more was the
// most in 48 heaps.
TEST_CASE("bouncing_heaps: without friction they gain little") {
  BouncingHeapDef def = swept_heap();
  def.friction = 0;
  check_heaps(def, 4, 1.06);
  def.has_balls = true;
  check_heaps(def, 4, 1.06);
}
