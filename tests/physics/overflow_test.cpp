/// @file
/// Numbers that are fine by themselves and overflow in a step: nothing spreads from them.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/brick.hpp"
#include "scenes/plate.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cstdint>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

/// The largest number that a definition may hold.
constexpr double largest = largest_number<double>;

}  // namespace

TEST_CASE("overflow: what blows up freezes, and nothing spreads from it") {
  // An explicit patch far beyond its limit, and a calm one beside it.
  PlateDef<double> def;
  def.integration = Integration::explicit_;
  def.parameters.normal_damping = largest;
  def.drop = 1e-4;
  def.mass = 0.01;
  auto scene = make_plate<double>(def);
  BodyDef<double> other = brick();
  other.position = {5, 0, 0.1};
  other.filter.mask = 1;
  const BodyId calm = scene.world.add_body(other);
  std::uint64_t frozen = 0;
  for (int i = 0; i < 100; ++i) {
    scene.world.step();
    frozen += scene.world.report().frozen_bodies;
    for (const BodyId id : {scene.plate, calm}) {
      const Body<double>& body = scene.world.body(id);
      REQUIRE(body.center_pose.translation.allFinite());
      REQUIRE(body.center_pose.rotation.coeffs().allFinite());
      REQUIRE(body.twist.linear.allFinite());
      REQUIRE(body.twist.angular.allFinite());
    }
  }
  CHECK(frozen > 0);
  const double fallen = 9.81 * 0.1 * 0.1 / 2;
  CHECK(scene.world.pose(calm).translation.z() == test::relative(0.1 - fallen).epsilon(1e-9));
}

TEST_CASE("overflow: what flies beyond the largest number stops where it was") {
  // For 100 s; the velocity itself is a fine number.
  World<double> world({.gravity = {0, 0, 0}, .time_step = 100});
  BodyDef<double> def = brick();
  def.velocity = {largest, 0, 0};
  const BodyId dynamic = world.add_body(def);
  def.motion = Motion::kinematic;
  const BodyId kinematic = world.add_body(def);
  world.step();
  CHECK(world.report().frozen_bodies == 2);
  for (const BodyId id : {dynamic, kinematic}) {
    CHECK(world.pose(id).translation == Vec3<double>::Zero());
    CHECK(world.body(id).twist.linear == Vec3<double>::Zero());
  }
}

TEST_CASE("overflow: a force that overflows stops its body, and reaches nobody") {
  World<double> world({.time_step = 0.1, .sleep = {.time = 0.5}});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  BodyDef<double> def = brick();
  def.position = {5, 0, 0.1};
  const BodyId sleeper = world.add_body(def);
  for (int i = 0; i < 30; ++i) world.step();
  REQUIRE(world.is_asleep(sleeper));
  def.position = {0, 0, 3};
  def.mass = 1e-3;
  const BodyId pushed = world.add_body(def);
  world.apply_wrench(pushed, {.force = {largest, 0, 0}, .torque = {0, 0, 0}});
  world.step();
  CHECK(world.report().frozen_bodies == 1);
  CHECK(world.report().awake_bodies == 1);
  CHECK(world.pose(pushed).translation == Vec3<double>(0, 0, 3));
  CHECK(world.body(pushed).twist.linear == Vec3<double>::Zero());
  CHECK(world.is_asleep(sleeper));
  world.step();
  CHECK(world.body(pushed).twist.linear.z() == test::relative(-0.981));
}

TEST_CASE("overflow: an implicit patch refuses constants that have no square") {
  PlateDef<double> def;
  def.parameters = {1, 1e300, 5000, 1e300, 1e-3};
  CHECK_THROWS_AS((void)make_plate<double>(def), InvalidArgument);
}

TEST_CASE("overflow: an implicit patch takes constants beyond all reason") {
  for (const double huge : {1e6, 1e16, 1e40}) {
    PlateDef<double> def;
    def.parameters = {1, huge, 5000, huge, 1e-3};
    auto scene = make_plate<double>(def);
    scene.world.set_velocity(scene.plate, {{1, 0, -1}, {0, 1, 0}});
    for (int i = 0; i < 100; ++i) {
      scene.world.step();
      REQUIRE(scene.world.body(scene.plate).twist.linear.allFinite());
      REQUIRE(scene.world.body(scene.plate).twist.linear.norm() < 10);
    }
  }
}

TEST_CASE("overflow: contacts of what turns too fast for its way to have a square stay numbers") {
  int points = 0;
  for (const double turn : {1e108, -1e108, 1e112}) {
    for (const double half : {1e48, 1e50}) {
      CAPTURE(turn);
      CAPTURE(half);
      WorldDef<double> world_def;
      world_def.gravity = {0, 0, 0};
      World<double> world(world_def);
      // The middle of the box goes round its centre of mass.
      BodyDef<double> box;
      box.mass = 1;
      box.shape = Box<double>{{half, half, half}};
      box.center_of_mass = {0.5 * half, 0, 0};
      world.add_body(box);
      box.position = {0, 2.0001 * half, 0};
      box.angular_velocity = {0, 0, turn};
      world.add_body(box);
      for (int i = 0; i < 3; ++i) {
        world.step();
        for (const auto& point : world.contacts().points()) {
          ++points;
          CHECK(has_finite_square(point.arm_a));
          CHECK(has_finite_square(point.arm_b));
        }
      }
      CHECK_NOTHROW(world.restore(world.snapshot()));
    }
  }
  CHECK(points > 0);
}
