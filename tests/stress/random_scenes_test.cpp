/// @file
/// A thousand random scenes: whatever falls on whatever, nothing breaks. A scene that fails is
/// named by its class and seed.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/random_heap.hpp"
#include "support/momentum.hpp"
#include "support/rounds.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

using namespace bristle;
using namespace bristle::scenes;

namespace {

/// What one scene did.
struct Findings {
  std::uint64_t frozen = 0;
  std::uint64_t discarded = 0;
  std::uint64_t backend_failures = 0;
  bool is_finite = true;
  /// [1] Highest energy, relative to the one at the start; both from the floor.
  double energy = 0;
  /// [1] Lowest centre of mass, relative to the size of a body.
  double lowest = 0;
  /// [1] Deepest overlap, relative to the size of a body.
  double deepest = 0;
};

Findings run_scene(std::uint64_t seed, const HeapKind& kind) {
  RandomHeap heap = make_random_heap(seed, kind);
  World<double>& world = heap.world;
  const std::span<const BodyId> bodies(heap.bodies);
  const double start = test::energy_of(world, bodies);
  Findings found;
  const long steps = std::lround(heap.duration / world.time_step());
  for (long i = 0; i < steps; ++i) {
    world.step();
    const StepReport<double>& report = world.report();
    found.frozen += report.frozen_bodies;
    found.discarded += report.discarded_islands;
    found.backend_failures += report.backend_failures;
    const double energy = test::energy_of(world, bodies);
    if (!std::isfinite(energy)) found.is_finite = false;
    found.energy = std::max(found.energy, energy / start);
    for (const BodyId id : bodies) {
      const Body<double>& body = world.body(id);
      if (!body.center_pose.translation.allFinite() || !body.twist.angular.allFinite()) {
        found.is_finite = false;
      }
      found.lowest = std::min(found.lowest, body.center_pose.translation.z() / heap.size);
    }
    world.for_each_contact([&](const ContactReading<double>& contact) {
      contact.for_each_point([&](const ContactPointReading<double>& point) {
        found.deepest = std::max(found.deepest, -point.gap / heap.size);
      });
    });
  }
  return found;
}

/// Runs scenes of a class and checks that none breaks.
void check_class(const char* name, const HeapKind& kind, std::uint64_t first, int base,
                 double energy_bound, double depth_bound) {
  const int count = test::rounds(base);
  int failures = 0;
  Findings worst;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t seed = first + static_cast<std::uint64_t>(i);
    const Findings f = run_scene(seed, kind);
    worst.energy = std::max(worst.energy, f.energy);
    worst.deepest = std::max(worst.deepest, f.deepest);
    worst.lowest = std::min(worst.lowest, f.lowest);
    const bool is_good = f.is_finite && f.frozen == 0 && f.discarded == 0 &&
                         f.backend_failures == 0 && f.energy <= energy_bound && f.lowest >= 0 &&
                         f.deepest <= depth_bound;
    if (is_good) continue;
    ++failures;
    MESSAGE(name, " seed ", seed, ": finite ", f.is_finite, ", frozen ", f.frozen, ", discarded ",
            f.discarded, ", backend failures ", f.backend_failures, ", energy ", f.energy,
            ", lowest ", f.lowest, ", depth ", f.deepest);
  }
  MESSAGE(name, ": ", count, " scenes, highest energy ", worst.energy, ", lowest centre ",
          worst.lowest, ", deepest overlap ", worst.deepest);
  CHECK(failures == 0);
}

}  // namespace

TEST_CASE("random_scenes: single shapes of all kinds") {
  check_class("shapes", {}, 1, 400, 1.001, 0.05);
}
TEST_CASE("random_scenes: bodies of several shapes") {
  check_class("compounds", {.compounds = true}, 10001, 200, 1.001, 0.05);
}
TEST_CASE("random_scenes: joints") {
  check_class("joints", {.compounds = true, .joints = true}, 20001, 200, 1.001, 0.05);
}
TEST_CASE("random_scenes: sensors") {
  check_class("sensors", {.compounds = true, .joints = true, .sensors = true}, 30001, 200, 1.001,
              0.05);
}
