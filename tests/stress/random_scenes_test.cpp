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
#include <string>

using namespace bristle;
using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

/// Findings in one scene.
struct Findings {
  std::uint64_t frozen = 0;
  std::uint64_t discarded = 0;
  std::uint64_t backend_failures = 0;
  bool is_finite = true;
  /// True if no body is below the floor when it ends.
  bool ends_above = true;
  /// [1] Highest energy, relative to the one at the start; both from the floor.
  double energy = 0;
  /// [1] Lowest centre of mass, relative to the size of a body.
  double lowest = 0;
  /// [1] Deepest overlap, relative to the size of a body.
  double deepest = 0;

  [[nodiscard]] bool is_intact() const {
    return is_finite && frozen == 0 && discarded == 0 && backend_failures == 0;
  }
};

/// Bounds on the scenes of a class.
struct Bounds {
  /// [1] Energy, relative to that at the start. Bounces of spinning bodies are placed by the
  /// velocity at the start of the step, so they may give a little; so may bounces with friction by
  /// Newton's law, in any step (Kane and Levinson 1985).
  double energy = 1.1;
  /// [1] Depth of a centre of mass below the floor and of an overlap, relative to the largest body.
  /// A body that turns by a radian within a step of 1/60 s goes with other points below the floor
  /// than those that were near it when the step began; the next steps bring it back.
  double below = 0.5;
  double overlap = 0.8;
  /// [-] Scenes that are known to break a bound; 0 for classes that must hold.
  int known_failures = 0;
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
      const double z = body.center_pose.translation.z() / heap.size;
      found.lowest = std::min(found.lowest, z);
    }
    world.for_each_contact([&](const ContactReading<double>& contact) {
      contact.for_each_point([&](const ContactReading<double>::Point& point) {
        found.deepest = std::max(found.deepest, -point.gap / heap.size);
      });
    });
  }
  for (const BodyId id : bodies) {
    if (world.body(id).center_pose.translation.z() < -0.5 * heap.size) found.ends_above = false;
  }
  return found;
}

/// Runs scenes of a class and checks that none breaks.
void check_class(const std::string& name, const HeapKind& kind, std::uint64_t first, int base,
                 const Bounds& bounds) {
  const int count = test::rounds(base);
  int failures = 0;
  Findings worst;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t seed = first + static_cast<std::uint64_t>(i);
    const Findings f = run_scene(seed, kind);
    worst.energy = std::max(worst.energy, f.energy);
    worst.deepest = std::max(worst.deepest, f.deepest);
    worst.lowest = std::min(worst.lowest, f.lowest);
    if (f.is_intact() && f.energy <= bounds.energy && f.lowest >= -bounds.below && f.ends_above &&
        f.deepest <= bounds.overlap) {
      continue;
    }
    ++failures;
    MESSAGE(name, " seed ", seed, ": finite ", f.is_finite, ", frozen ", f.frozen, ", discarded ",
            f.discarded, ", backend failures ", f.backend_failures, ", energy ", f.energy,
            ", lowest centre ", f.lowest, ", ends above ", f.ends_above, ", overlap ", f.deepest);
  }
  MESSAGE(name, ": ", count, " scenes, highest energy ", worst.energy, ", lowest centre ",
          worst.lowest, ", deepest overlap ", worst.deepest);
  CHECK(failures <= bounds.known_failures * count / base);
}

}  // namespace

// One is known: at 321 a wedged body is pressed through the floor and comes back. Of 3000 scenes
// four break a bound, all in this way, and of 1500 of compounds one.
TEST_CASE("random_scenes: single shapes of all kinds") {
  check_class("shapes", {}, 1, 400, {.known_failures = 1});
}

TEST_CASE("random_scenes: bodies of several shapes") {
  check_class("compounds", {.compounds = true}, 10001, 200, {});
}

TEST_CASE("random_scenes: sensors") {
  check_class("sensors", {.compounds = true, .sensors = true}, 40001, 150, {});
}

// Two are known: at 20032 and 20085 the centre of a light link is 0.6 and 0.8 sizes below the floor
// for a few steps, where it was turned by radians in one. Of 600 scenes three break a bound, all in
// this way.
TEST_CASE("random_scenes: joints") {
  check_class("joints", {.compounds = true, .joints = true}, 20001, 150, {.known_failures = 2});
}

// Of 500 scenes one breaks a bound, by 6 % more energy than is allowed.
TEST_CASE("random_scenes: joints and sensors") {
  check_class("joints and sensors", {.compounds = true, .joints = true, .sensors = true}, 30001,
              100, {});
}

// Chains that fall on an end, with friction: Newton's law of restitution gave them 1.5, 2.7, 1.3
// and 1.5 times their energy.
TEST_CASE("random_scenes: bounces of chains give no energy") {
  for (const std::uint64_t seed : {20375u, 20493u, 30198u, 30345u}) {
    CAPTURE(seed);
    const bool has_sensors = seed > 30000;
    const Findings f = run_scene(seed, {.compounds = true, .joints = true, .sensors = has_sensors});
    CHECK(f.is_intact());
    CHECK(f.energy <= 1.1);
  }
}

// Islands of bodies of a gram on levers of a decimetre, struck at hundreds of radians per second,
// for which no solution was found: they gained energy without bound from what iterations left.
TEST_CASE("random_scenes: islands that do not converge gain no energy") {
  for (const std::uint64_t seed : {30121u, 30411u}) {
    CAPTURE(seed);
    const Findings f = run_scene(seed, {.compounds = true, .joints = true, .sensors = true});
    CHECK(f.is_intact());
    CHECK(f.energy <= 1.1);
  }
}
