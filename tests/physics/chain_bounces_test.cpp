/// @file
/// Chains that fall on an end and bounce, with friction, give back no more energy than they had.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/random_heap.hpp"
#include "support/momentum.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

using namespace bristle;
using namespace bristle::scenes;

// By Newton's law of restitution alone these reached 1.49 and 2.74 times the energy they began
// with.
TEST_CASE("chain_bounces: struck aside of their centre chains gain nothing") {
  for (const std::uint64_t seed : {20375u, 20493u}) {
    CAPTURE(seed);
    RandomHeap heap = make_random_heap(seed, {.compounds = true, .joints = true});
    const std::span<const BodyId> bodies(heap.bodies);
    const double start = test::energy_of(heap.world, bodies);
    const long steps = std::lround(heap.duration / heap.world.time_step());
    double highest = 0;
    for (long i = 0; i < steps; ++i) {
      heap.world.step();
      highest = std::max(highest, test::energy_of(heap.world, bodies));
    }
    CHECK(highest < 1.001 * start);
    CHECK(highest > 0.5 * start);  // It is not that nothing moved.
  }
}

// Without friction, and struck at its centre, a chain bounces as one body: nothing is taken back.
TEST_CASE("chain_bounces: what gives no energy is left as it is") {
  for (const double e : {0.5, 1.0}) {
    CAPTURE(e);
    World<double> world({.gravity = {0, 0, 0}, .time_step = 1.0 / 240});
    world.add_body({.motion = Motion::fixed,
                    .shape = HalfSpace<double>{},
                    .material = {.friction = 0, .restitution = e}});
    BodyId above{};
    for (const double z : {0.3, 0.5}) {
      BodyDef<double> def;
      def.mass = 1;
      def.shape = Sphere<double>{0.1};
      def.position = {0, 0, z};
      def.velocity = {0, 0, -2};
      def.material = {.friction = 0, .restitution = e};
      const BodyId ball = world.add_body(def);
      if (z > 0.4) {
        world.add_joint({.kind = JointKind::fixed,
                         .body_a = above,
                         .body_b = ball,
                         .X_AJ = {},
                         .X_BJ = {Quat<double>::Identity(), {0, 0, -0.2}}});
      }
      above = ball;
    }
    for (int i = 0; i < 60; ++i) world.step();
    CHECK(world.body(above).twist.linear.z() == test::relative(2 * e).epsilon(1e-6));
  }
}
