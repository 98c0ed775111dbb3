/// @file
/// Which islands are factorised, which are swept, and which are held.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/contact_island.hpp"

#include <bristle/dynamics/solver/method_choice.hpp>

#include <doctest/doctest.h>

#include <cstdint>
#include <limits>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// A floor, and boxes side by side on it, each beside all others: a full matrix.
struct Heap {
  test::ContactIsland<double> island;
  SolveContext<double> context;

  explicit Heap(std::uint32_t count) {
    test::Random random(7);
    island = test::random_pile<double>(random, count, 4, 0.5, 1.0);
    auto& contacts = island.constraints.contacts;
    const ContactConstraint<double> contact = contacts.front();
    for (std::uint32_t a = 1; a <= count; ++a) {
      for (std::uint32_t b = a + 2; b <= count; ++b) {
        island.contacts.push_back(static_cast<std::uint32_t>(contacts.size()));
        contacts.push_back(contact);
        contacts.back().body_a = a;
        contacts.back().body_b = b;
      }
    }
    for (auto& c : contacts) c.impulse = {1, 0, 0};
    context.dt = 1.0 / 240;
    context.speed_change = 9.81 / 240;
    context.velocity_tolerance = 1e-8 * context.speed_change;
  }
  /// All slide along the floor and past each other.
  void slide(double speed) {
    for (std::uint32_t i = 1; i < island.bodies.size(); ++i) {
      const auto& c = island.constraints.contacts.front();
      island.bodies[i].start.linear = (i * speed) * c.axes[1];
    }
  }
  bool is_swept() {
    SolveContext<double> c = context;
    MethodChoice<double>().make(island.island(), island.constraints, island.bodies, c);
    return c.is_swept;
  }
};

}  // namespace

TEST_CASE("MethodChoice: a heap is swept while it slides, and only then") {
  Heap heap(16);
  CHECK_FALSE(heap.is_swept());
  heap.slide(0.5 * heap.context.speed_change / 16);
  CHECK_FALSE(heap.is_swept());
  heap.slide(2 * heap.context.speed_change);
  CHECK(heap.is_swept());
  // What forces change is what counts, and nothing is the round-off of the velocities.
  heap.context.speed_change = 100;
  CHECK_FALSE(heap.is_swept());
  heap.context.speed_change = 0;
  CHECK(heap.is_swept());
  heap.slide(1e-3 * heap.context.velocity_tolerance);
  CHECK_FALSE(heap.is_swept());
}

TEST_CASE("is_held: surfaces slide if their friction is at its bound and they move") {
  test::Random random(3);
  auto island = test::random_pile<double>(random, 3, 4, 0.5, 1.0);
  SolveContext<double> context;
  context.velocity_tolerance = 1e-9;
  const double friction = island.constraints.contacts.front().friction;
  const auto is_held_with = [&](double speed, double normal, double tangential) {
    for (auto& body : island.bodies) body.start = {};
    for (auto& c : island.constraints.contacts) c.impulse = {1, 0, 0};
    auto& c = island.constraints.contacts.front();
    c.impulse = {normal, 0, tangential * friction * normal};
    island.bodies[c.body_b].start.linear = speed * c.axes[1];
    return is_held<double>(island.island(), island.constraints, island.bodies, context);
  };
  CHECK(is_held_with(0, 2, 0.5));
  CHECK(is_held_with(1, 2, 0.5));
  CHECK(is_held_with(0, 2, 1));
  CHECK(is_held_with(1e-10, 2, -1));
  CHECK_FALSE(is_held_with(1e-8, 2, 1));
  CHECK_FALSE(is_held_with(1, 2, -1));
  // What carries nothing cannot slide, nor what is smooth.
  CHECK(is_held_with(1, 0, 0));
  for (auto& c : island.constraints.contacts) c.friction = 0;
  CHECK(is_held_with(1, 2, 0));
}

TEST_CASE("MethodChoice: what parts, or neither touches nor presses, does not slide") {
  Heap heap(16);
  heap.slide(1);
  for (auto& c : heap.island.constraints.contacts) {
    c.impulse = {};
    c.gap = 1e-3;
  }
  CHECK_FALSE(heap.is_swept());
  // One that closes within the step does.
  const auto& c = heap.island.constraints.contacts.front();
  heap.island.bodies[c.body_b].start.linear -= 1.0 * c.axes[0];
  CHECK(heap.is_swept());
}

TEST_CASE("MethodChoice: surfaces that run along with what lies on them do not slide") {
  Heap heap(16);
  heap.slide(0);
  for (auto& c : heap.island.constraints.contacts) c.drift = {1, 0};
  CHECK(heap.is_swept());
  for (auto& body : heap.island.bodies) body.start = {};
  for (auto& c : heap.island.constraints.contacts) c.drift = {};
  CHECK_FALSE(heap.is_swept());
}

TEST_CASE("MethodChoice: small heaps, chains, bounces and symplectic Euler are factorised") {
  Heap small(5);
  small.slide(1);
  CHECK_FALSE(small.is_swept());

  // A full matrix of as many unknowns would be too much work. That of a chain is not.
  test::Random random(8);
  Heap chain(5);
  chain.island = test::random_pile<double>(random, 24, 4, 0.5, 1.0);
  for (auto& c : chain.island.constraints.contacts) c.impulse = {1, 0, 0};
  chain.slide(1);
  CHECK_FALSE(chain.is_swept());

  Heap heap(16);
  heap.slide(1);
  REQUIRE(heap.is_swept());
  heap.context.integrator = Integrator::symplectic_euler;
  CHECK_FALSE(heap.is_swept());
  heap.context.integrator = Integrator::trapezoidal;
  heap.island.constraints.contacts.back().restitution = 0.5;
  CHECK_FALSE(heap.is_swept());
  // Large ones are swept in any case.
  heap.context.settings.max_direct_work = 0;
  CHECK(heap.is_swept());
}

TEST_CASE("MethodChoice: heaps of short mechanisms are large sooner") {
  // A chain of 24 boxes that all touch the first. To eliminate all but two takes 675 multiply-adds,
  // as each has the next one and the first in its column.
  test::Random random(9);
  Heap chain(5);
  chain.island = test::random_pile<double>(random, 24, 1, 0.5, 1.0);
  auto& contacts = chain.island.constraints.contacts;
  for (std::uint32_t body = 3; body <= 24; ++body) {
    chain.island.contacts.push_back(static_cast<std::uint32_t>(contacts.size()));
    contacts.push_back(ContactConstraint<double>(contacts.front()));
    contacts.back().body_a = 1;
    contacts.back().body_b = body;
  }
  const std::uint64_t elimination = 22 * 675 + 243 + 27;
  ConstraintBlock<double> joint;
  joint.body_a = 1;
  joint.body_b = 2;
  chain.island.constraints.blocks.push_back(joint);
  const std::vector<std::uint32_t> joints{0};
  SolverDef<double>& settings = chain.context.settings;
  const auto is_large = [&](const Island& island) {
    SolveContext<double> c = chain.context;
    MethodChoice<double>().make(island, chain.island.constraints, chain.island.bodies, c);
    CHECK(c.is_swept == c.is_large());
    return c.is_large();
  };
  const Island heap = chain.island.island();
  Island jointed = heap;
  jointed.blocks = joints;
  settings.max_direct_work = 5 * elimination;
  CHECK_FALSE(is_large(jointed));
  settings.max_direct_work = 5 * elimination - 1;
  CHECK(is_large(jointed));
  CHECK_FALSE(is_large(heap));
  // Without contacts one factorisation solves it.
  Island rope = jointed;
  rope.contacts = {};
  CHECK_FALSE(is_large(rope));
  // Sweeps do not carry a load along a mechanism that has more bodies than they are. A fixed body
  // is no part of one.
  settings.large_sweeps = 2;
  CHECK(is_large(jointed));
  settings.large_sweeps = 1;
  CHECK_FALSE(is_large(jointed));
  chain.island.constraints.blocks.front().body_a = 0;
  CHECK(is_large(jointed));
}

TEST_CASE("SolveContext: position sweeps have a bound whatever the settings") {
  Heap heap(16);
  SolveContext<double>& c = heap.context;
  MethodChoice<double>().make(heap.island.island(), heap.island.constraints, heap.island.bodies, c);
  const int usual = c.affordable_sweeps(heap.island.island());
  CHECK(usual > 20);
  c.settings.max_newton_steps = 1;
  CHECK(c.affordable_sweeps(heap.island.island()) < usual);
  c.settings.max_newton_steps = std::numeric_limits<int>::max();
  c.settings.max_direct_work = std::numeric_limits<std::uint64_t>::max();
  CHECK(c.affordable_sweeps(heap.island.island()) == 10000);
}
