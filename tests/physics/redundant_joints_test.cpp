// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <random>

using namespace bristle;

namespace {

/// Two boxes of 1 kg side by side, the first one fixed or not, and many joints between them whose
/// frames disagree by `disagreement`.
struct Pair {
  World<double> world;
  BodyId a, b;
  std::vector<JointId> joints;

  Pair(Motion motion, int count, double disagreement, double height = 1.0)
      : world({.time_step = 1.0 / 240}) {
    const Box<double> box{.half_extents = {0.1, 0.1, 0.1}};
    a = world.add_body({.motion = motion, .mass = 1.0, .shape = box, .position = {0, 0, height}});
    b = world.add_body({.mass = 1.0, .shape = box, .position = {0.3, 0, height}});
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto vector = [&] {
      return Vec3<double>(uniform(random), uniform(random), uniform(random));
    };
    for (int i = 0; i < count; ++i) {
      JointDef<double> def;
      def.kind = JointKind::fixed;
      def.body_a = a;
      def.body_b = b;
      const Vec3<double> p = Vec3<double>(0.15, 0, 0) + 0.1 * vector();
      def.X_AJ.translation = p;
      def.X_BJ.translation = p - Vec3<double>(0.3, 0, 0) + disagreement * vector();
      def.X_BJ.rotation = exp_rotation<double>(disagreement * vector());
      joints.push_back(world.add_joint(def));
    }
  }
};

}  // namespace

// Each of these steps would take hours if its cost grew with the cube of the number of joints.
TEST_CASE("redundant joints: 10,000 between two bodies hold them and carry the weight") {
  Pair pair(Motion::fixed, 10'000, 0.0);
  for (int i = 0; i < 3; ++i) pair.world.step();
  Wrench<double> total;
  for (const JointId joint : pair.joints) {
    const Wrench<double> reaction = pair.world.reading(joint).reaction;
    total += reaction;
  }
  // A sum of ten thousand terms, each of them known to the accuracy of contradictions.
  CHECK(total.force.z() == test::relative(9.81).epsilon(1e-6));
  CHECK(pair.world.pose(pair.b).translation.z() == test::relative(1.0).epsilon(1e-12));
}

TEST_CASE("redundant joints: joints that disagree hold a body at their mean, at rest") {
  for (const double disagreement : {1e-15, 1e-12, 1e-9, 1e-6}) {
    CAPTURE(disagreement);
    Pair pair(Motion::fixed, 100, disagreement);
    for (int i = 0; i < 240; ++i) {
      pair.world.step();
      const Twist<double> twist = pair.world.body(pair.b).twist;
      // Closing disagreements leaves no velocity; 1e-8 is the solver's tolerance, of 0.04 m/s.
      CHECK(twist.linear.norm() < 1e-8 * 9.81 / 240);
    }
    // No joint can ask for more than its own disagreement, seen over arms of 0.3 m.
    const Vec3<double> off = pair.world.pose(pair.b).translation - Vec3<double>(0.3, 0, 1);
    CHECK(off.norm() < 2 * disagreement + 1e-14);
  }
}

TEST_CASE("redundant joints: two bodies on 100 joints fall as one") {
  Pair pair(Motion::dynamic, 100, 1e-12);
  for (int i = 0; i < 240; ++i) pair.world.step();
  const Vec3<double> a = pair.world.pose(pair.a).translation;
  const Vec3<double> b = pair.world.pose(pair.b).translation;
  CHECK(a.z() == test::relative(1.0 - 0.5 * 9.81).epsilon(1e-9));
  CHECK((b - a - Vec3<double>(0.3, 0, 0)).norm() < 1e-11);
}

TEST_CASE("redundant joints: a hub of 1000 arms steps, by the solver whose cost has a bound") {
  World<double> world({.gravity = {0, 0, 0}, .time_step = 1.0 / 240});
  const BodyId hub = world.add_body({.mass = 10.0, .shape = Sphere<double>{.radius = 0.5}});
  for (int i = 0; i < 1000; ++i) {
    const Vec3<double> out(std::cos(0.00628 * i), std::sin(0.00628 * i), 0);
    const BodyId arm =
        world.add_body({.mass = 1.0, .shape = Sphere<double>{.radius = 1e-3}, .position = out});
    JointDef<double> def;
    def.kind = JointKind::ball;
    def.body_a = hub;
    def.body_b = arm;
    def.X_AJ.translation = 0.5 * out;
    def.X_BJ.translation = -0.5 * out;
    world.add_joint(def);
  }
  world.step();
  CHECK(world.report().mechanism_evaluations == 0);
  CHECK(world.report().frozen_bodies == 0);
  CHECK(world.body(hub).twist.linear.norm() < 1e-12);
}
