/// @file
/// Events that wake islands; and a world that slept has the state of one that did not.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/grasp.hpp"
#include "scenes/tower.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("waking: a tower of ten goes on where it was when it wakes") {
  World<double> world(sleepy());
  World<double> twin;
  add_floor(world);
  add_floor(twin);
  const auto cubes = add_tower(world, 10);
  const auto twins = add_tower(twin, 10);
  while (!world.is_asleep(cubes[0])) {
    world.step();
    twin.step();
    REQUIRE(twin.report().awake_bodies == 10);
  }
  run(world, 5);
  world.wake(cubes[4]);
  double speed = 0, residual = 0, twin_speed = 0, twin_residual = 0;
  for (int i = 0; i < 100; ++i) {
    world.step();
    twin.step();
    CHECK_FALSE(world.is_asleep(cubes[0]));
    speed = std::max(speed, fastest(world, cubes));
    residual = std::max(residual, world.report().residual);
    twin_speed = std::max(twin_speed, fastest(twin, twins));
    twin_residual = std::max(twin_residual, twin.report().residual);
  }
  // It starts from rest with the impulses that the twin has, too.
  INFO("awake: ", twin_speed, " m/s, residual ", twin_residual);
  INFO("woken: ", speed, " m/s, residual ", residual);
  CHECK(speed <= 2 * twin_speed + 1e-9);
  CHECK(residual <= 2 * twin_residual + 1e-9);
}

TEST_CASE("waking: a tower of ten woken by a feather is as quiet as one that never slept") {
  const auto drop = [](bool sleeps, double& speed, double& residual) {
    World<double> world(sleeps ? sleepy() : WorldDef<double>{});
    add_floor(world);
    const auto cubes = add_tower(world, 10);
    run(world, 2);
    REQUIRE(world.is_asleep(cubes[0]) == sleeps);
    const double before = world.pose(cubes[9]).translation.z();
    BodyDef<double> feather;
    feather.mass = 1e-4;
    feather.shape = Sphere<double>{0.01};
    feather.position = {0.02, 0.01, 2.0101};
    world.add_body(feather);
    speed = residual = 0;
    bool was_woken = false;
    for (int i = 0; i < 100; ++i) {
      world.step();
      was_woken = was_woken || !world.is_asleep(cubes[0]);
      CHECK(world.is_asleep(cubes[9]) == world.is_asleep(cubes[0]));
      speed = std::max(speed, fastest(world, cubes));
      residual = std::max(residual, world.report().residual);
    }
    CHECK(was_woken);
    CHECK(std::abs(world.pose(cubes[9]).translation.z() - before) < 1e-6);
  };
  double speed[2], residual[2];
  drop(false, speed[0], residual[0]);
  drop(true, speed[1], residual[1]);
  INFO("never slept: ", speed[0], " m/s, residual ", residual[0]);
  INFO("slept: ", speed[1], " m/s, residual ", residual[1]);
  CHECK(speed[1] <= 2 * speed[0] + 1e-9);
  CHECK(residual[1] <= 2 * residual[0] + 1e-9);
}

TEST_CASE("waking: what is gripped by sensors is gripped when it wakes") {
  for (const double finger_mass : {0.0, 0.3}) {
    GraspDef<double> def;
    def.finger_mass = finger_mass;
    def.sleep.time = nap;
    auto slept = make_grasp<double>(def);
    slept.run(3);
    REQUIRE(slept.world.is_asleep(slept.part));
    const double sag = slept.sag();
    const double normal = slept.total_normal();
    const auto shear = slept.world.reading(slept.pads[0]).shear_W;
    slept.run(5);
    CHECK(slept.world.report().rays_cast == 0);
    CHECK(slept.total_normal() == normal);
    CHECK(slept.world.reading(slept.pads[0]).shear_W == shear);
    slept.world.wake(slept.part);
    CHECK_FALSE(slept.world.is_asleep(slept.part));
    if (finger_mass > 0) CHECK_FALSE(slept.world.is_asleep(slept.fingers[0]));
    slept.run(0.3);
    INFO("finger ", finger_mass);
    // The first steps are the next ones of a hold at rest.
    CHECK(std::abs(slept.sag() - sag) < 1e-9);
    CHECK(std::abs(slept.total_normal() - normal) < 1e-6 * normal);
    CHECK(slept.world.reading(slept.pads[0]).slipping() == 0);
    CHECK(slept.world.body(slept.part).twist.linear.norm() < 1e-8);
  }
}

TEST_CASE("waking: every call that changes an island wakes it, and none that does not") {
  struct Scene {
    World<double> world{sleepy()};
    BodyId floor, table, low, high, hung, bystander;
    JointId joint;
    PatchId patch;
    ShapeId extra;
  };
  const auto build = [] {
    Scene s;
    s.floor = add_floor(s.world);
    BodyDef<double> table = box_def(1, {0.3, 0.3, 0.05}, {0, 0, 0.05});
    table.motion = Motion::fixed;
    s.table = s.world.add_body(table);
    s.low = s.world.add_body(box_def(1, {0.1, 0.1, 0.1}, {0, 0, 0.2}));
    s.high = s.world.add_body(box_def(1, {0.1, 0.1, 0.1}, {0, 0, 0.4}));
    s.hung = s.world.add_body(box_def(0.2, {0.02, 0.02, 0.02}, {0.15, 0, 0.4}));
    s.bystander = s.world.add_body(box_def(1, {0.1, 0.1, 0.1}, {2, 0, 0.1}));
    JointDef<double> joint;
    joint.kind = JointKind::prismatic;
    joint.body_a = s.high;
    joint.body_b = s.hung;
    joint.X_AJ.translation = {0.15, 0, 0};
    joint.motor = {MotorMode::position, 0, 50, 1};
    s.joint = s.world.add_joint(joint);
    PatchDef<double> patch;
    patch.sensors.add({0, 0, -0.095}, {0, 0, -1}, 0.01);
    patch.parameters = {1, 0.01, 1000, 0.1, 1e-3};
    s.patch = s.world.add_patch(s.high, patch);
    ShapeDef<double> extra;
    extra.shape = Sphere<double>{0.01};
    s.extra = s.world.add_shape(s.table, extra);
    run(s.world, 2);
    return s;
  };
  const Vec3<double> zero = Vec3<double>::Zero();
  struct Call {
    const char* name;
    std::function<void(Scene&)> call;
    bool wakes = true;
    bool wakes_all = false;
  };
  const std::vector<Call> calls = {
      {"apply_force",
       [&](Scene& s) {
         s.world.apply_force(s.low, {0, 0, 1}, zero);
       }},
      {"apply_wrench",
       [&](Scene& s) {
         s.world.apply_wrench(s.high, {zero, {0, 0, 0.1}});
       }},
      {"apply no wrench", [&](Scene& s) { s.world.apply_wrench(s.high, {}); }, false},
      {"set_velocity", [&](Scene& s) { s.world.set_velocity(s.hung, {}); }},
      {"set_pose", [&](Scene& s) { s.world.set_pose(s.low, s.world.pose(s.low)); }},
      {"set_pose of the table",
       [&](Scene& s) { s.world.set_pose(s.table, s.world.pose(s.table)); }},
      {"set_filter", [&](Scene& s) { s.world.set_filter(s.low, {}); }},
      {"set_filter of the table", [&](Scene& s) { s.world.set_filter(s.table, {}); }},
      {"set_motor", [&](Scene& s) { s.world.set_motor(s.joint, {}); }},
      {"set_parameters", [&](Scene& s) { s.world.set_parameters(s.patch, {}); }},
      {"add_shape", [&](Scene& s) { s.world.add_shape(s.high, {.shape = Sphere<double>{0.1}}); }},
      {"remove_shape of the table", [&](Scene& s) { s.world.remove_shape(s.extra); }},
      {"remove_body of the table", [&](Scene& s) { s.world.remove_body(s.table); }},
      {"remove_body", [&](Scene& s) { s.world.remove_body(s.hung); }},
      {"remove_joint", [&](Scene& s) { s.world.remove_joint(s.joint); }},
      {"add_joint",
       [&](Scene& s) {
         JointDef<double> def;
         def.body_a = s.high;
         def.body_b = s.table;
         s.world.add_joint(def);
       }},
      {"remove_patch", [&](Scene& s) { s.world.remove_patch(s.patch); }},
      {"add_patch",
       [&](Scene& s) {
         PatchDef<double> def{.may_point_inwards = true};
         def.sensors.add({0, 0, 0}, {0, 0, -1}, 0.01);
         s.world.add_patch(s.low, def);
       }},
      {"wake", [&](Scene& s) { s.world.wake(s.low); }},
      {"set_gravity",
       [&](Scene& s) {
         s.world.set_gravity({0, 0, -9});
       },
       true, true},
      {"set_time_step", [&](Scene& s) { s.world.set_time_step(1e-3); }, true, true},
      {"a body added elsewhere",
       [&](Scene& s) {
         s.world.add_body(box_def(1, {0.1, 0.1, 0.1}, {-2, 0, 0.1}));
       },
       false},
      {"a query", [&](Scene& s) { (void)s.world.reading(s.patch); }, false},
  };
  const Scene asleep = build();
  REQUIRE(asleep.world.report().sleeping_bodies == 4);
  for (const Call& call : calls) {
    INFO(call.name);
    Scene s = asleep;
    call.call(s);
    CHECK(s.world.is_asleep(s.low) == !call.wakes);
    CHECK(s.world.is_asleep(s.high) == !call.wakes);
    CHECK(s.world.is_asleep(s.bystander) == !call.wakes_all);
    s.world.step();
    CHECK(s.world.is_asleep(s.low) == !call.wakes);
    CHECK(s.world.is_asleep(s.bystander) == !call.wakes_all);
    // And nothing is out of step for it.
    run(s.world, 0.1);
    CHECK(s.world.report().frozen_bodies == 0);
    CHECK(s.world.report().sleeping_bodies + s.world.report().awake_bodies ==
          s.world.body_count() - 1 - (s.world.contains(s.table) ? 1u : 0u));
  }
}

TEST_CASE("waking: a fixed body put next to a sleeper wakes it, one put elsewhere does not") {
  for (const double x : {0.25, 1.0}) {
    World<double> world(sleepy());
    add_floor(world);
    const auto cube = add_tower(world, 1);
    run(world, 2);
    REQUIRE(world.is_asleep(cube[0]));
    BodyDef<double> wall = box_def(1, {0.2, 0.2, 0.2}, {x, 0, 0.2});
    wall.motion = Motion::fixed;
    world.add_body(wall);
    world.step();
    CHECK(world.is_asleep(cube[0]) == (x > 0.5));
    // Pushed out by the wall that stands in it.
    run(world, 1);
    const double moved = world.pose(cube[0]).translation.x();
    CHECK((moved < -0.04) == (x < 0.5));
  }
}

TEST_CASE("waking: a body without a shape moves in a world that sleeps") {
  World<double> world(sleepy());
  add_floor(world);
  const auto cubes = add_tower(world, 1);
  run(world, 2);
  REQUIRE(world.is_asleep(cubes[0]));
  BodyDef<double> point;
  point.mass = 1;
  point.inertia = Mat3<double>::Identity();
  const BodyId id = world.add_body(point);
  world.step();
  CHECK(world.report().awake_bodies == 1);
  CHECK(world.body(id).twist.linear.z() < 0);
  CHECK(world.is_asleep(cubes[0]));
}

TEST_CASE("waking: a fast body wakes what it hits in the very step, and what that hits") {
  const auto shoot = [](bool sleeps) {
    World<double> world(sleeps ? sleepy(1.0 / 60) : WorldDef<double>{.time_step = 1.0 / 60});
    add_floor(world);
    std::vector<BodyId> row;
    for (int k = 0; k < 3; ++k) {
      row.push_back(world.add_body(box_def(0.5, {0.05, 0.05, 0.05}, {0.1 * k, 0, 0.05})));
    }
    run(world, 2);
    REQUIRE(world.is_asleep(row[0]) == sleeps);
    BodyDef<double> bullet;
    bullet.mass = 0.1;
    bullet.shape = Sphere<double>{0.02};
    bullet.position = {-1, 0, 0.05};
    bullet.velocity = {30, 0, 0};  // Half a metre a step.
    row.push_back(world.add_body(bullet));
    run(world, 0.3);
    std::vector<double> x;
    for (const BodyId id : row) x.push_back(world.pose(id).translation.x());
    return x;
  };
  const auto slept = shoot(true);
  const auto awake = shoot(false);
  CHECK(slept[0] > 0.02);
  for (std::size_t k = 0; k < slept.size(); ++k) {
    // Both start from rest to round-off and what sweeps leave.
    CHECK(slept[k] == test::relative(awake[k]).epsilon(1e-5));
  }
}

TEST_CASE("waking: kinematic bodies wake while they move, and only then") {
  World<double> world(sleepy());
  BodyDef<double> def = box_def(1, {0.3, 0.3, 0.05}, {0, 0, -0.05});
  def.motion = Motion::kinematic;
  const BodyId plate = world.add_body(def);
  const auto cubes = add_tower(world, 2);
  run(world, 2);
  REQUIRE(world.is_asleep(cubes[0]));
  // Told to stay where it is, in every step.
  for (int i = 0; i < 10; ++i) {
    world.move_to(plate, world.pose(plate));
    world.set_velocity(plate, {});
    world.step();
  }
  CHECK(world.is_asleep(cubes[0]));
  // It carries them away.
  world.set_velocity(plate, {{0.1, 0, 0}, Vec3<double>::Zero()});
  CHECK_FALSE(world.is_asleep(cubes[0]));
  run(world, 2);
  CHECK_FALSE(world.is_asleep(cubes[1]));
  CHECK(world.pose(cubes[1]).translation.x() > 0.18);
  world.set_velocity(plate, {});
  run(world, 1);
  CHECK(world.is_asleep(cubes[1]));

  // A pusher from outside, and a floor that rises.
  def.shape = Box<double>{{0.05, 0.05, 0.05}};
  def.position = world.pose(cubes[1]).translation + Vec3<double>(0.3, 0, 0);
  const BodyId pusher = world.add_body(def);
  world.set_velocity(pusher, {{-0.5, 0, 0}, Vec3<double>::Zero()});
  run(world, 0.2);
  CHECK(world.is_asleep(cubes[1]));
  run(world, 0.2);
  CHECK_FALSE(world.is_asleep(cubes[1]));
  CHECK_FALSE(world.is_asleep(cubes[0]));

  World<double> lift(sleepy());
  const BodyId ground = add_floor(lift, Motion::kinematic);
  const auto load = add_tower(lift, 1);
  run(lift, 2);
  REQUIRE(lift.is_asleep(load[0]));
  lift.set_velocity(ground, {{0, 0, 0.1}, Vec3<double>::Zero()});
  run(lift, 1);
  CHECK(lift.pose(load[0]).translation.z() == test::relative(0.2).epsilon(1e-3));
}

TEST_CASE("waking: a sensor that comes near wakes what it will feel, and sleepers cast no rays") {
  WorldDef<double> world_def = sleepy(1e-3);
  World<double> world(world_def);
  add_floor(world);
  const BodyId part = world.add_body(box_def(0.5, {0.05, 0.05, 0.05}, {0, 0, 0.05}));
  // Also with sensors of its own, below.
  PatchDef<double> skin;
  skin.sensors.add({0, 0, -0.045}, {0, 0, -1}, 0.01);
  skin.parameters = {1, 0.01, 1000, 0.1, 1e-3};
  const PatchId below = world.add_patch(part, skin);
  BodyDef<double> finger = box_def(0.1, {0.01, 0.01, 0.01}, {-0.1, 0, 0.05});
  finger.motion = Motion::kinematic;
  finger.filter.mask = 0;
  const BodyId tip = world.add_body(finger);
  PatchDef<double> pad;
  pad.sensors.add({0, 0, 0}, {1, 0, 0}, 0.02);
  pad.parameters = {5, 0.05, 1000, 0.1, 1e-3};
  const PatchId touch = world.add_patch(tip, pad);
  run(world, 2);
  REQUIRE(world.is_asleep(part));
  const double reading = world.reading(below).total_normal();
  // The pad's end is 30 mm off; it comes at 0.1 m/s.
  world.set_velocity(tip, {{0.1, 0, 0}, Vec3<double>::Zero()});
  for (int i = 0; i < 290; ++i) {
    world.step();
    CHECK(world.report().rays_cast == 0);
  }
  CHECK(world.is_asleep(part));
  CHECK(world.reading(below).total_normal() == reading);
  run(world, 0.04);
  CHECK_FALSE(world.is_asleep(part));
  CHECK(world.reading(touch).total_normal() > 0);
  CHECK(world.report().rays_cast > 0);
  CHECK(world.pose(part).translation.x() >= 0);
  CHECK(world.reading(below).touching() == 1);
}

TEST_CASE(
    "sleep: what lies beside a moving hand's sensors does not fall asleep and wake in turns") {
  World<double> world(sleepy(1e-3));
  add_floor(world);
  const BodyId part = world.add_body(box_def(0.5, {0.05, 0.05, 0.05}, {0, 0, 0.05}));
  BodyDef<double> hand = box_def(0.1, {0.01, 0.01, 0.01}, {-0.08, 0, 0.05});
  hand.motion = Motion::kinematic;
  hand.filter.mask = 0;
  const BodyId tip = world.add_body(hand);
  PatchDef<double> pad;
  // Two rays that pass the part on both sides: it is in their box, and never hit.
  pad.sensors.add({0, -0.1, 0}, {1, 0, 0}, 0.05);
  pad.sensors.add({0, 0.1, 0}, {1, 0, 0}, 0.05);
  world.add_patch(tip, pad);
  world.set_velocity(tip, {{0, 0, 1e-6}, Vec3<double>::Zero()});
  int changes = 0;
  bool was_asleep = false;
  for (int i = 0; i < 3000; ++i) {
    world.step();
    changes += world.is_asleep(part) != was_asleep ? 1 : 0;
    was_asleep = world.is_asleep(part);
  }
  CHECK(changes == 0);
  world.set_velocity(tip, {});
  run(world, 1);
  CHECK(world.is_asleep(part));
}
