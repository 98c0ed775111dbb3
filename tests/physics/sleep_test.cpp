/// @file
/// Islands that fall asleep, and what it saves.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/medley.hpp"
#include "scenes/tower.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <string>

using namespace bristle;
using namespace bristle::scenes;

namespace {

/// Checks that a step did none of the work that costs.
void check_idle(const StepReport<double>& r) {
  CHECK(r.pairs_tested == 0);
  CHECK(r.pairs_collided == 0);
  CHECK(r.contact_points == 0);
  CHECK(r.rays_cast == 0);
  CHECK(r.rows == 0);
  CHECK(r.islands == 0);
  CHECK(r.sweeps == 0);
  CHECK(r.awake_bodies == 0);
}

}  // namespace

TEST_CASE("sleep: by default nobody ever does") {
  World<double> world;
  add_floor(world);
  const auto cubes = add_tower(world, 3);
  run(world, 20);
  CHECK(world.report().sleeping_bodies == 0);
  CHECK(world.report().awake_bodies == 3);
  CHECK(world.report().rows > 0);
  CHECK_FALSE(world.is_asleep(cubes[0]));
}

TEST_CASE("sleep: an island does as a whole, after its time, and then costs nothing") {
  World<double> world(sleepy());
  add_floor(world);
  const auto cubes = add_tower(world, 10);
  run(world, nap - 0.01);
  CHECK(world.report().sleeping_bodies == 0);
  // All or none, on the way there.
  for (int i = 0; i < 300; ++i) {
    world.step();
    CHECK(world.report().sleeping_bodies % 10 == 0);
    CHECK(world.report().sleeping_bodies + world.report().awake_bodies == 10);
  }
  REQUIRE(world.report().sleeping_bodies == 10);
  for (const BodyId id : cubes) {
    CHECK(world.is_asleep(id));
    CHECK(world.body(id).twist.linear.isZero(0));
    CHECK(world.body(id).twist.angular.isZero(0));
  }
  const std::uint64_t hash = world.state_hash();
  for (int i = 0; i < 100; ++i) {
    world.step();
    check_idle(world.report());
    CHECK(world.report().sleeping_bodies == 10);
  }
  // Not a bit has changed, and contacts still carry what they carried.
  CHECK(world.state_hash() == hash);
  const double load = world.contact_impulse(cubes[0]).force.z() / world.time_step();
  CHECK(load == test::relative(9.81).epsilon(1e-3));
  std::string events;
  world.for_each_contact_event(
      [&](const ContactEvent& e) { events += e.phase == ContactEvent::Phase::persist ? "p" : "?"; });
  CHECK(events == "pppppppppp");
}

TEST_CASE("sleep: one restless member keeps its island awake, and no other") {
  World<double> world(sleepy());
  add_floor(world);
  const auto still = add_tower(world, 2);
  const auto restless = add_tower(world, 2, 1);
  // Contacts of the awake then lie between those of sleepers in the order of pairs.
  const auto later = add_tower(world, 2, 2);
  for (int i = 0; i < 400; ++i) {
    world.apply_wrench(restless[1], {{0, 0, -1e-3}, Vec3<double>::Zero()});
    world.step();
  }
  for (const BodyId id : {still[0], still[1], later[0], later[1]}) CHECK(world.is_asleep(id));
  CHECK_FALSE(world.is_asleep(restless[0]));
  CHECK_FALSE(world.is_asleep(restless[1]));
  CHECK(world.report().awake_bodies == 2);
  // Their contacts carry what they carried, beside those of the awake.
  for (const BodyId id : {still[0], restless[0], later[0]}) {
    const double load = world.contact_impulse(id).force.z() / world.time_step();
    CHECK(load == test::relative(9.81).epsilon(2e-3));
  }
  int touches = 0;
  world.for_each_contact_event(
      [&](const ContactEvent& e) { touches += e.phase == ContactEvent::Phase::persist ? 1 : 100; });
  CHECK(touches == 6);
  CHECK(world.report().contact_points == 8);
  // Sleepers cost no pairs and no rows: as many as a world without them.
  World<double> alone(sleepy());
  add_floor(alone);
  const auto tower = add_tower(alone, 2, 1);
  for (int i = 0; i < 400; ++i) {
    alone.apply_wrench(tower[1], {{0, 0, -1e-3}, Vec3<double>::Zero()});
    alone.step();
  }
  CHECK(world.report().pairs_tested == alone.report().pairs_tested);
  CHECK(world.report().pairs_collided == alone.report().pairs_collided);
  CHECK(world.report().rows == alone.report().rows);
  CHECK(world.report().rows > 0);
  CHECK(world.body(restless[1]).center_pose.translation ==
        alone.body(tower[1]).center_pose.translation);
}

TEST_CASE("sleep: a bit of everything falls asleep and reads what it read") {
  WorldDef<double> def = sleepy();
  auto m = make_medley<double>(def);
  run(m.world, 6);
  REQUIRE(m.world.report().sleeping_bodies == m.bodies.size());
  const double normal = m.world.reading(m.patches[1]).total_normal();
  const double motor = m.world.reading(m.joints[0]).motor_force;
  const std::uint64_t hash = m.world.state_hash();
  run(m.world, 1);
  check_idle(m.world.report());
  CHECK(m.world.state_hash() == hash);
  CHECK(m.world.reading(m.patches[1]).total_normal() == normal);
  CHECK(normal == test::relative(0.5 * 9.81).epsilon(0.01));
  CHECK(m.world.reading(m.joints[0]).motor_force == motor);
}

TEST_CASE("sleep: a snapshot holds it, and a copy sleeps on") {
  const auto build = [] {
    World<double> world(sleepy());
    add_floor(world);
    add_tower(world, 3);
    const auto other = add_tower(world, 2, 1);
    run(world, 0.2);
    world.set_velocity(other[1], {{0, 0, 1}, Vec3<double>::Zero()});
    return world;
  };
  World<double> original = build();
  // One tower asleep, the other not yet: then both.
  for (const double until : {0.45, 2.0}) {
    run(original, until);
    const auto snapshot = original.snapshot();
    World<double> fresh = build();
    fresh.restore(snapshot);
    World<double> copy = original;
    CHECK(fresh.report().sleeping_bodies == 0);  // It did no step.
    for (int i = 0; i < 300; ++i) {
      fresh.step();
      copy.step();
      if (i == 150) {
        for (World<double>* w : {&fresh, &copy}) w->set_gravity({0.01, 0, -9.8});
      }
      REQUIRE(fresh.state_hash() == copy.state_hash());
      CHECK(fresh.report().sleeping_bodies == copy.report().sleeping_bodies);
    }
  }
}
