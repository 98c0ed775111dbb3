/// @file
/// What a host adds to a world: its own numbers, its own rules for pairs, joints to the world, and
/// events that wait until it reads them.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/ground.hpp"
#include "support/relative.hpp"

#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using bristle::scenes::add_ground;

namespace {

constexpr double host_step = 1.0 / 240;

BodyDef<double> unit_cube(const Vec3<double>& position) {
  return {.mass = 1.0, .shape = Box<double>{{0.1, 0.1, 0.1}}, .position = position};
}

/// [m/s] Speed of a box of friction 0.6 after a quarter of a second on a floor of 0.2.
double speed_after_sliding(Material<double> (*combine)(const Material<double>&,
                                                       const Material<double>&)) {
  World<double> world({.time_step = host_step, .combine = combine});
  add_ground(world, {.friction = 0.2});
  BodyDef<double> def = unit_cube({0, 0, 0.1});
  def.material = {.friction = 0.6};
  def.velocity = {4, 0, 0};
  const BodyId box = world.add_body(def);
  for (int i = 0; i < 60; ++i) world.step();
  return world.body(box).twist.linear.x();
}

}  // namespace

TEST_CASE("user data: of bodies, shapes, joints and patches; copied, and no part of the state") {
  World<double> world;
  BodyDef<double> def = unit_cube({0, 0, 1});
  def.user_data = 7;
  const BodyId body = world.add_body(def);
  const ShapeId shape =
      world.add_shape(body, {.shape = Sphere<double>{0.1}, .user_data = ~std::uint64_t{0}});
  const JointId joint = world.add_joint({.body_b = body, .user_data = 3});
  PatchDef<double> pad;
  pad.sensors.add(Vec3<double>(0, 0, -0.1), Vec3<double>(0, 0, -0.12));
  pad.parameters.normal_stiffness = 10;
  pad.user_data = 4;
  const PatchId patch = world.add_patch(body, pad);
  CHECK(world.user_data(body) == 7);
  CHECK(world.user_data(shape) == ~std::uint64_t{0});
  CHECK(world.user_data(joint) == 3);
  CHECK(world.user_data(patch) == 4);
  std::vector<std::uint64_t> numbers;
  world.for_each_shape(body, [&](ShapeId id, const ShapeDef<double>& each) {
    CHECK(world.user_data(id) == each.user_data);
    numbers.push_back(each.user_data);
  });
  CHECK(numbers == std::vector<std::uint64_t>{7, ~std::uint64_t{0}});
  const auto hash = world.state_hash();
  world.set_user_data(body, 70);
  world.set_user_data(shape, 71);
  world.set_user_data(joint, 72);
  world.set_user_data(patch, 73);
  CHECK(world.state_hash() == hash);
  const World<double> copy = world;
  CHECK(copy.user_data(body) + copy.user_data(shape) + copy.user_data(joint) +
            copy.user_data(patch) ==
        286);
  world.remove_body(body);
  CHECK_THROWS_AS((void)world.user_data(body), InvalidArgument);
  CHECK_THROWS_AS(world.set_user_data(shape, 1), InvalidArgument);
  CHECK_THROWS_AS((void)world.user_data(PatchId{}), InvalidArgument);
}

TEST_CASE("user data: handles of shapes tell whether they are there") {
  World<double> world;
  const BodyId body = world.add_body(unit_cube({0, 0, 1}));
  const ShapeId shape = world.add_shape(body, {.shape = Sphere<double>{0.1}});
  CHECK(world.contains(shape));
  world.remove_shape(shape);
  CHECK(!world.contains(shape));
  CHECK_THROWS_WITH_AS((void)world.user_data(BodyId{}), doctest::Contains("unset"),
                       InvalidArgument);
}

TEST_CASE("user data: a contact leads to the host's objects") {
  World<double> world({.time_step = host_step});
  add_ground(world);
  BodyDef<double> def = unit_cube({0, 0, 0.1});
  def.user_data = 5;
  world.add_body(def);
  world.step();
  int contacts = 0;
  world.for_each_contact([&](const ContactReading<double>& contact) {
    ++contacts;
    CHECK(world.user_data(contact.body_b) == 5);
    CHECK(world.user_data(contact.shape_b) == 5);
  });
  CHECK(contacts == 1);
}

// Coulomb's law: v = v0 - mu g t.
TEST_CASE("combine: the host's rule decides the friction and the bounce of a pair") {
  const auto check = [](double friction, auto combine) {
    CHECK(speed_after_sliding(combine) == test::relative(4 - friction * 9.81 * 0.25).epsilon(1e-9));
  };
  check(std::sqrt(0.2 * 0.6), combined<double>);
  check(0.2, [](const Material<double>& a, const Material<double>& b) {
    return Material<double>{.friction = std::min(a.friction, b.friction)};
  });
  check(0.6, [](const Material<double>& a, const Material<double>& b) {
    return Material<double>{.friction = std::max(a.friction, b.friction)};
  });
  check(0.4, [](const Material<double>& a, const Material<double>& b) {
    return Material<double>{.friction = (a.friction + b.friction) / 2};
  });
  // No material: as if there were no rule.
  check(std::sqrt(0.2 * 0.6), [](const Material<double>&, const Material<double>&) {
    return Material<double>{.friction = std::numeric_limits<double>::quiet_NaN()};
  });
  CHECK_THROWS_WITH_AS(World<double>({.combine = nullptr}), doctest::Contains("WorldDef::combine"),
                       InvalidArgument);
}

TEST_CASE("may_collide: the host keeps a pair apart that filters let meet") {
  BodyId ghost, solid;
  std::size_t asked = 0;
  WorldDef<double> def{.time_step = host_step};
  def.may_collide = [&](std::uint64_t a, std::uint64_t b) {
    ++asked;
    return a != 1 && b != 1;
  };
  World<double> world(def);
  add_ground(world);
  world.add_body(unit_cube({0, 5, 50}));
  for (int i = 0; i < 10; ++i) world.step();
  CHECK(asked == 0);  // Nothing is near the floor.
  BodyDef<double> box = unit_cube({0, 0, 0.2});
  solid = world.add_body(box);
  box.position = {1, 0, 0.2};
  box.user_data = 1;
  ghost = world.add_body(box);
  for (int i = 0; i < 120; ++i) world.step();
  CHECK(asked > 0);
  CHECK(world.pose(solid).translation.z() == test::relative(0.1).epsilon(1e-6));
  CHECK(world.pose(ghost).translation.z() < -0.5);
}

TEST_CASE("kept events: nothing of several steps is lost, in their order") {
  World<double> world({.time_step = host_step, .keeps_contact_events = true});
  World<double> forgetful({.time_step = host_step});
  std::vector<BodyId> boxes;
  for (World<double>* each : {&world, &forgetful}) {
    add_ground(*each, {.restitution = 0.8});
    BodyDef<double> def = unit_cube({0, 0, 0.3});
    def.shape = Sphere<double>{0.1};
    boxes.push_back(each->add_body(def));
  }
  std::vector<ContactEvent> expected;
  for (int frame = 0; frame < 40; ++frame) {
    for (int i = 0; i < 4; ++i) {
      world.step();
      world.for_each_contact_event([&](const ContactEvent& event) {
        if (event.phase != ContactEvent::Phase::persist) expected.push_back(event);
      });
      forgetful.step();
    }
    if (frame % 2 == 0) continue;
    const auto kept = world.contact_events();
    REQUIRE(kept.size() == expected.size());
    for (std::size_t i = 0; i < kept.size(); ++i) {
      CHECK(kept[i].phase == expected[i].phase);
      CHECK(kept[i].body_b == expected[i].body_b);
    }
    world.clear_contact_events();
    expected.clear();
    CHECK(world.contact_events().empty());
  }
  CHECK(world.state_hash() == forgetful.state_hash());
  CHECK(forgetful.contact_events().empty());
  // An end by removal is kept, too.
  while (world.contact_events().empty()) world.step();
  world.clear_contact_events();
  world.remove_body(boxes[0]);
  world.step();
  REQUIRE(world.contact_events().size() == 1);
  CHECK(world.contact_events()[0].phase == ContactEvent::Phase::end);
}

TEST_CASE("ground: a joint to the world is one to a fixed body at its origin") {
  const auto swing = [](bool is_explicit, bool is_last) {
    World<double> world({.time_step = host_step});
    BodyId fixed{};
    if (is_explicit) fixed = world.add_body({.motion = Motion::fixed});
    const BodyId bob = world.add_body(unit_cube({0.5, 0.2, 1}));
    JointDef<double> def{.kind = JointKind::ball, .body_a = fixed, .body_b = bob};
    def.X_AJ.translation = {0, 0, 1};
    def.X_BJ.translation = {-0.5, -0.2, 0};
    if (is_last) {
      std::swap(def.body_a, def.body_b);
      std::swap(def.X_AJ, def.X_BJ);
    }
    world.add_joint(def);
    for (int i = 0; i < 240; ++i) world.step();
    CHECK(world.body_count() == 2);
    return world.pose(bob).translation;
  };
  CHECK(swing(false, false) == swing(true, false));
  CHECK((swing(false, true) - swing(true, true)).norm() < 1e-12);

  World<double> world;
  JointDef<double> def;
  CHECK_THROWS_AS(world.add_joint(def), InvalidArgument);
  CHECK(world.body_count() == 0);
  const BodyId ground = world.ground();
  CHECK(world.ground() == ground);
  const BodyId bob = world.add_body(unit_cube({0, 0, 0}));
  def.body_b = ground;
  CHECK_THROWS_AS(world.add_joint(def), InvalidArgument);
  def.body_b = bob;
  const JointId joint = world.add_joint(def);
  CHECK(world.joint(joint).def.body_a == ground);
  world.remove_body(ground);
  CHECK(!world.contains(joint));
  CHECK(world.contains(world.add_joint(def)));
}
