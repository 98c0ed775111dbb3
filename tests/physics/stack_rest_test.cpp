/// @file
/// Cubes on top of each other come to rest where they should and stay there.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/stack.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

using namespace bristle;
using namespace bristle::scenes;

namespace {

template <typename Scene>
double height_error(const Scene& scene) {
  double worst = 0;
  for (std::size_t k = 0; k < scene.cubes.size(); ++k) {
    const auto p = scene.world.pose(scene.cubes[k]).translation;
    worst = std::max(worst, std::abs(static_cast<double>(p.z() - scene.rest_heights[k])));
  }
  return worst;
}

}  // namespace

TEST_CASE("stack_rest: 1000 kg on 100 g rest on sensors at 1/60 s (R19)") {
  StackDef<double> def;
  def.by = StackBy::sensors;
  def.masses = {0.1, 1000};
  auto scene = make_stack<double>(def);
  scene.run(3);
  CHECK(height_error(scene) < 1e-6);
  CHECK(scene.world.report().direct_islands == 1);
}

TEST_CASE("stack_rest: a tall stack on sensors rests, light on heavy and heavy on light") {
  for (const auto& masses :
       {std::vector<double>{1, 1, 1, 1, 1}, std::vector<double>{16, 8, 4, 2, 1},
        std::vector<double>{1, 2, 4, 8, 16}}) {
    StackDef<double> def;
    def.by = StackBy::sensors;
    def.masses = masses;
    auto scene = make_stack<double>(def);
    scene.run(4);
    CHECK(height_error(scene) < 1e-6);
  }
}

TEST_CASE("stack_rest: swept instead of factored, moderate mass ratios rest too") {
  StackDef<double> def;
  def.by = StackBy::sensors;
  def.masses = {1, 10};
  def.solver.max_direct_work = 0;
  auto scene = make_stack<double>(def);
  scene.run(3);
  CHECK(height_error(scene) < 1e-6);
  CHECK(scene.world.report().direct_islands == 0);
  CHECK(scene.world.report().islands == 1);
}

TEST_CASE_TEMPLATE("stack_rest: five cubes on hard contact stand still", S, float, double) {
  StackDef<S> def;
  auto scene = make_stack<S>(def);
  scene.run(3);
  // Contacts close their gaps to what the solver's tolerance leaves: 1e-9 of g dt^2 a step.
  const double tolerance = std::is_same_v<S, double> ? 1e-7 : 2e-5;
  CHECK(height_error(scene) < tolerance);
  std::vector<Transform<S>> settled;
  for (const BodyId id : scene.cubes) settled.push_back(scene.world.pose(id));
  scene.run(5);
  for (std::size_t k = 0; k < scene.cubes.size(); ++k) {
    const Transform<S> X = scene.world.pose(scene.cubes[k]);
    CHECK(static_cast<double>((X.translation - settled[k].translation).norm()) < tolerance);
    CHECK(static_cast<double>(scene.world.body(scene.cubes[k]).twist.linear.norm()) < 1e-4);
  }
}

TEST_CASE("stack_rest: each contact carries what is above it") {
  StackDef<double> def;
  def.masses = {1, 2, 3};
  def.gap = 0;
  auto scene = make_stack<double>(def);
  scene.run(3);
  const double carried[] = {6, 5, 3};
  std::size_t k = 0;
  REQUIRE(scene.world.contacts().manifolds().size() == 3);
  for (const auto& manifold : scene.world.contacts().manifolds()) {
    double impulse = 0;
    for (std::uint32_t i = 0; i < manifold.count; ++i) {
      impulse += scene.world.contacts().points()[manifold.first + i].impulse[0];
    }
    CHECK(impulse == test::relative(carried[k++] * 9.81 / 60).epsilon(1e-5));
  }
}

TEST_CASE("stack_rest: 1000 kg on 1 kg come to rest, and then seldom need a factorisation") {
  for (const double hertz : {60, 240, 1000}) {
    StackDef<double> def;
    def.masses = {1, 1, 1, 1000};
    def.time_step = 1 / hertz;
    def.gap = 0;
    auto scene = make_stack<double>(def);
    scene.run(1);
    const int steps = 500;
    double factorisations = 0;
    for (int i = 0; i < steps; ++i) {
      scene.world.step();
      factorisations += double(scene.world.report().factorisations);
    }
    // Such a stack is a solver's inverted pendulum: what rounding moves it by grows until it is
    // seen. When each step started from the impulses of the last, it took one a step for ever.
    CHECK(factorisations < 0.6 * steps);
    CHECK(height_error(scene) < 1e-7);
  }
}
