/// @file
/// The same calls give the same bits: run to run, and from a copy.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/grasp.hpp"
#include "scenes/medley.hpp"

#include <doctest/doctest.h>

using namespace bristle;
using namespace bristle::scenes;

namespace {

template <typename S>
std::uint64_t medley_hash(const Medley<S>& m) {
  return m.world.state_hash();
}

template <typename S>
void run(Medley<S>& m, int steps) {
  for (int i = 0; i < steps; ++i) m.world.step();
}

}  // namespace

TEST_CASE_TEMPLATE("determinism: a second run gives the same bits", S, float, double) {
  auto first = make_medley<S>();
  auto second = make_medley<S>();
  CHECK(medley_hash(first) == medley_hash(second));
  const std::uint64_t start = medley_hash(first);
  run(first, 300);
  run(second, 300);
  CHECK(medley_hash(first) == medley_hash(second));
  CHECK(medley_hash(first) != start);
}

TEST_CASE_TEMPLATE("determinism: a copy steps on as the original does", S, float, double) {
  auto original = make_medley<S>();
  run(original, 100);
  auto copy = original;
  CHECK(medley_hash(copy) == medley_hash(original));
  run(original, 100);
  // The copy is not touched by what the original does, and then does the same.
  CHECK(medley_hash(copy) != medley_hash(original));
  run(copy, 100);
  CHECK(medley_hash(copy) == medley_hash(original));
}

TEST_CASE("determinism: the order of bodies matters no more than round-off") {
  auto forward = make_medley<double>();
  auto reversed = make_medley<double>({}, true);
  run(forward, 60);
  run(reversed, 60);
  for (std::size_t k = 0; k < forward.bodies.size(); ++k) {
    const Transform<double> a = forward.world.pose(forward.bodies[k]);
    const Transform<double> b = reversed.world.pose(reversed.bodies[k]);
    INFO("body ", k);
    // Sweeps end at a tolerance of 1e-9 of the speed that gravity gives in a step.
    CHECK((a.translation - b.translation).norm() < 1e-8);
    CHECK(log_rotation<double>(a.rotation.conjugate() * b.rotation).norm() < 1e-7);
  }
}

TEST_CASE("determinism: a grasp repeats its bits at both steps and all ways to integrate") {
  for (const double dt : {1e-3, 1.0 / 60}) {
    for (const Integration integration : {Integration::implicit, Integration::automatic}) {
      std::uint64_t hashes[2];
      for (std::uint64_t& hash : hashes) {
        GraspDef<double> def;
        def.time_step = dt;
        def.integration = integration;
        def.finger_mass = 0.3;
        auto scene = make_grasp<double>(def);
        scene.run(0.5);
        hash = scene.world.state_hash();
      }
      CHECK(hashes[0] == hashes[1]);
    }
  }
}
