/// @file
/// Islands too large for a factorisation: swept sensors must not give energy, however far from
/// converged the sweeps are.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/bouncing_heap.hpp"
#include "support/momentum.hpp"
#include "support/relative.hpp"

#include <bristle/sensors/placement.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

using namespace bristle;

namespace {

/// `count` boxes of 1 kg over each other, each on a stiff pad, with `gap` m between pad and box.
struct PadStack {
  PadStack(int count, double gap, std::uint64_t max_direct_work)
      : world(world_def(max_direct_work)) {
    BodyDef<double> floor;
    floor.motion = Motion::fixed;
    floor.shape = HalfSpace<double>{};
    world.add_body(floor);
    for (int i = 0; i < count; ++i) {
      BodyDef<double> def;
      def.mass = 1;
      def.shape = Box<double>{{0.1, 0.1, 0.05}};
      def.filter.mask = 0;
      def.position = {0, 0, 0.05 + 0.002 + gap + (0.102 + gap) * i};
      bodies.push_back(world.add_body(def));
      SensorGridDef<double> grid;
      grid.center = {0, 0, -0.05};
      grid.side_u = {0, 0.2, 0};
      grid.side_v = {0.2, 0, 0};
      grid.count_u = grid.count_v = 3;
      grid.depth = 0.002;
      grid.range = 0.004;
      GripSpec<double> spec;
      spec.load = 9.81 * (count - i);
      spec.mass = count - i;
      world.add_patch(bodies.back(), sensor_grid(grid), tuned_for(spec));
    }
  }
  static WorldDef<double> world_def(std::uint64_t max_direct_work) {
    WorldDef<double> def;
    def.time_step = 1.0 / 60;
    def.solver.max_direct_work = max_direct_work;
    return def;
  }
  double energy() const {
    double sum = 0;
    for (const BodyId id : bodies) {
      sum += world.body(id).kinetic_energy() + 9.81 * world.body(id).center_pose.translation.z();
    }
    return sum;
  }
  World<double> world;
  std::vector<BodyId> bodies;
};

}  // namespace

TEST_CASE("swept_islands: a dropped stack of more bodies than are factored gains no energy") {
  // Islands of about ten pads are below the second bound, the whole stack is above it.
  for (const std::uint64_t max_direct : {std::uint64_t{0}, std::uint64_t{10000}}) {
    PadStack stack(40, 0.003, max_direct);
    // Elastic energy of the pads is missing from the sum, so it may fall and rise, but never above
    // where it started.
    const double initial = stack.energy();
    double highest = initial;
    bool was_swept = false;
    for (int i = 0; i < 120; ++i) {
      stack.world.step();
      highest = std::max(highest, stack.energy());
      was_swept = was_swept || stack.world.report().direct_islands < stack.world.report().islands;
    }
    CHECK(was_swept);
    CHECK(highest <= initial * (1 + 1e-12));
    CHECK(stack.world.report().frozen_bodies == 0);
  }
}

TEST_CASE("swept_islands: at rest, sweeps start from the impulses of the last step") {
  PadStack stack(12, 0, 0);
  for (int i = 0; i < 600; ++i) stack.world.step();
  CHECK(stack.world.report().direct_islands == 0);
  double fastest = 0;
  for (const BodyId id : stack.bodies) {
    fastest = std::max(fastest, stack.world.body(id).twist.linear.norm());
  }
  CHECK(fastest < 1e-6);
}

// Two balls that meet off centre, with nothing else about: all momentum stays, whatever the number
// of parts a swept island's step is cut into (one, two and four here).
TEST_CASE("swept islands: parts of a step keep momentum and angular momentum") {
  for (const double dt : {1.0 / 240, 1.0 / 120, 1.0 / 60}) {
    CAPTURE(dt);
    WorldDef<double> def;
    def.gravity.setZero();
    def.time_step = dt;
    def.solver.max_direct_work = 0;
    World<double> world(def);
    BodyDef<double> ball;
    ball.mass = 1;
    ball.shape = Sphere<double>{0.1};
    ball.position = {-0.1005, 0.1, 0};
    ball.velocity = {1, 0, 0};
    std::vector<BodyId> bodies{world.add_body(ball)};
    ball.position = {0.1005, 0, 0};
    ball.velocity = {-1, 1, 0};
    bodies.push_back(world.add_body(ball));
    const auto momentum = [&] { return test::momentum_of(world, std::span<const BodyId>(bodies)); };
    const Wrench<double> before = momentum();
    for (int i = 0; i < 10; ++i) world.step();
    REQUIRE(world.body(bodies[0]).twist.linear.x() < 0.9);  // They met.
    CHECK((momentum().force - before.force).norm() < 1e-12);
    CHECK((momentum().torque - before.torque).norm() < 1e-12);
  }
}

// Bounces are placed in time in each part of a step, here one and four.
TEST_CASE("swept islands: a ball bounces as high as one that is factored") {
  for (const double dt : {1.0 / 60, 1.0 / 240}) {
    for (const double e : {0.5, 0.8, 1.0}) {
      CAPTURE(dt);
      CAPTURE(e);
      WorldDef<double> def;
      def.gravity = {0, 0, -9.81};
      def.time_step = dt;
      def.solver.max_direct_work = 0;
      World<double> world(def);
      world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
      const BodyId id = world.add_body({.mass = 0.5,
                                        .shape = Sphere<double>{0.1},
                                        .material = {.restitution = e},
                                        .position = {0, 0, 1.1}});
      int peaks = 0;
      double last_speed = 0;
      for (int n = 0; n < 5 / dt && peaks < 3; ++n) {
        world.step();
        const double v = world.body(id).twist.linear.z();
        const double h = world.body(id).center_pose.translation.z() - 0.1;
        CHECK(h > -1e-14);
        if (last_speed > 0 && v <= 0) {
          ++peaks;
          CHECK(h + v * v / (2 * 9.81) == test::relative(std::pow(e, 2 * peaks)).epsilon(1e-12));
        }
        last_speed = v;
      }
      CHECK(peaks == 3);
    }
  }
}

// Bouncing boxes press on single points, where a manifold has no torsion to give.
TEST_CASE("swept islands: boxes that bounce between walls gain no energy") {
  for (const std::uint64_t seed : {1u, 4u}) {
    CAPTURE(seed);
    scenes::BouncingHeapDef def;
    def.seed = seed;
    def.solver.max_direct_work = 0;
    auto heap = scenes::make_bouncing_heap(def);
    const double initial = heap.energy();
    double highest = 0;
    for (int n = 0; n < 600; ++n) {
      heap.world.step();
      highest = std::max(highest, heap.energy());
    }
    // Several impacts at once may give a little; what they lose is more.
    CHECK(highest < 1.001 * initial);
    CHECK(heap.world.report().frozen_bodies == 0);
  }
}

TEST_CASE("swept islands: an elastic heap without friction keeps its energy") {
  // The same bound as in stress/bouncing_heaps_test.cpp, which has more of them.
  scenes::BouncingHeapDef def;
  def.solver.max_direct_work = 0;
  def.friction = 0;
  def.seed = 4;
  scenes::BouncingHeap heap = scenes::make_bouncing_heap(def);
  const double start = heap.energy();
  double most = start;
  for (int i = 0; i < 3 * 240; ++i) {
    heap.world.step();
    most = std::max(most, heap.energy());
  }
  CHECK(most <= 1.06 * start);
}
