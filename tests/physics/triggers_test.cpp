/// @file
/// Triggers: shapes that tell what is in them and push nothing.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>

using namespace bristle;
using namespace bristle::detail;

namespace {

constexpr double gate_step = 1.0 / 240;

/// A gate of 0.2 m about z = 1, which lies on the way of what falls along the z axis.
BodyId add_gate(World<double>& world, Motion motion = Motion::fixed) {
  BodyDef<double> def;
  def.motion = motion;
  def.position = {0, 0, 1};
  def.shapes = {{.shape = Box<double>{{0.5, 0.5, 0.1}}, .is_trigger = true}};
  return world.add_body(def);
}

BodyId add_ball(World<double>& world, double height) {
  return world.add_body(
      {.mass = 1.0, .shape = Sphere<double>{0.05}, .position = {0.01, 0.02, height}});
}

std::string phases(const World<double>& world, BodyId gate) {
  std::string text;
  world.for_each_contact_event([&](const ContactEvent& event) {
    if (event.body_a != gate && event.body_b != gate) return;
    text += event.phase == ContactEvent::Phase::begin     ? "b"
            : event.phase == ContactEvent::Phase::persist ? "p"
                                                          : "e";
  });
  return text;
}

}  // namespace

TEST_CASE("trigger: a ball falls through as through nothing, and is reported while it is inside") {
  World<double> world({.time_step = gate_step});
  World<double> empty({.time_step = gate_step});
  const BodyId gate = add_gate(world);
  const BodyId ball = add_ball(world, 1.5);
  const BodyId twin = add_ball(empty, 1.5);
  int first = 0, last = 0, begins = 0, ends = 0;
  for (int i = 1; i <= 200; ++i) {
    // A step looks at the positions that it starts from.
    const double height = world.pose(ball).translation.z();
    const bool is_inside = std::abs(height - 1) <= 0.15;
    world.step();
    empty.step();
    const std::string seen = phases(world, gate);
    CHECK((seen == "b" || seen == "p") == is_inside);
    CHECK(world.report().rows == 0);
    if (seen == "b") first = i, ++begins;
    if (seen == "e") last = i, ++ends;
  }
  CHECK(begins == 1);
  CHECK(ends == 1);
  CHECK(last > first);
  CHECK(world.body(ball).center_pose.translation == empty.body(twin).center_pose.translation);
  CHECK(world.body(ball).twist.linear == empty.body(twin).twist.linear);
}

TEST_CASE("trigger: adds no mass, and the solid shapes of its body push on") {
  World<double> world({.time_step = gate_step});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  BodyDef<double> def{.shape = Box<double>{{0.1, 0.1, 0.1}}, .position = {0, 0, 0.1}};
  const BodyId plain = world.add_body(def);
  def.position = {1, 0, 0.1};
  def.shapes = {{.shape = Sphere<double>{0.5}, .is_trigger = true}};
  const BodyId wide = world.add_body(def);
  CHECK(world.body(wide).mass == world.body(plain).mass);
  CHECK(world.body(wide).inertia_B == world.body(plain).inertia_B);
  for (int i = 0; i < 240; ++i) world.step();
  CHECK(std::abs(world.pose(wide).translation.z() - 0.1) < 1e-6);
  // A body of triggers alone has no mass of its own.
  BodyDef<double> hollow;
  hollow.shapes = def.shapes;
  CHECK_THROWS_AS(world.add_body(hollow), InvalidArgument);
}

TEST_CASE("trigger: sensors and queries go through it, unless a query asks for it") {
  World<double> world({.time_step = gate_step});
  const BodyId gate = add_gate(world);
  const BodyId hand = world.add_body({.motion = Motion::fixed, .position = {0, 0, 1.2}});
  PatchDef<double> def;
  def.sensors.add(Vec3<double>(0, 0, 0), Vec3<double>(0, 0, -0.5));
  def.parameters.normal_stiffness = 10;
  const PatchId patch = world.add_patch(hand, def);
  world.step();
  CHECK(world.reading(patch).touching() == 0);

  const Ray<double> ray{{0, 0, 3}, {0, 0, -1}, 10};
  QueryFilter with_triggers;
  with_triggers.meets_triggers = true;
  CHECK(!world.cast_ray(ray).is_hit());
  CHECK(world.cast_ray(ray, with_triggers).body == gate);
  CHECK(world.cast_ray_through(ray).empty());
  CHECK(world.cast_ray_through(ray, with_triggers).size() == 1);
  const Transform<double> at{.translation = {0, 0, 1}};
  CHECK(world.overlaps(Sphere<double>{0.1}, at).empty());
  CHECK(world.overlaps(Sphere<double>{0.1}, at, with_triggers).size() == 1);
  SensorLayout<double> layout;
  layout.add(Vec3<double>(0, 0, 0), Vec3<double>(0, 0, -0.5));
  for (const bool meets : {false, true}) {
    QueryFilter filter;
    filter.meets_triggers = meets;
    ProximityArray<double> array(layout, filter);
    world.sense(hand, array);
    CHECK((array.distance()[0] < infinity<double>) == meets);
  }
}

TEST_CASE("trigger: does not keep bodies awake, nor wake them") {
  World<double> world({.time_step = gate_step, .sleep = {.time = 0.1}});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId ball = add_ball(world, 0.05);
  const BodyId gate = add_gate(world, Motion::kinematic);
  for (int i = 0; i < 120; ++i) world.step();
  CHECK(world.is_asleep(ball));
  world.set_velocity(gate, {{0, 0, -1}, {0, 0, 0}});
  std::string seen;
  for (int i = 0; i < 480; ++i) {
    world.step();
    seen += phases(world, gate);
    CHECK(world.is_asleep(ball));
  }
  CHECK(seen.front() == 'b');
  CHECK(seen.back() == 'e');
  CHECK(std::count(seen.begin(), seen.end(), 'p') + 2 == static_cast<int>(seen.size()));
}

TEST_CASE("trigger: what puts, moves or removes one does not wake what sleeps in it") {
  for (const Motion motion : {Motion::fixed, Motion::kinematic}) {
    World<double> world({.time_step = gate_step, .sleep = {.time = 0.1}});
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    const BodyId ball = add_ball(world, 0.05);
    for (int i = 0; i < 120; ++i) world.step();
    REQUIRE(world.is_asleep(ball));
    const BodyId gate = add_gate(world, motion);
    std::string seen;
    const auto step = [&] {
      world.step();
      seen += phases(world, gate);
      CHECK(world.is_asleep(ball));
    };
    step();
    CHECK(seen.empty());
    world.set_pose(gate, {.translation = {0, 0, 0.1}});
    step();
    step();
    CHECK(seen == "bp");
    world.set_pose(gate, {.translation = {0, 0, 0.12}});
    step();
    world.set_pose(gate, {.translation = {0, 0, 2}});
    step();
    CHECK(seen == "bppe");
    world.set_pose(gate, {.translation = {0, 0, 0.1}});
    step();
    world.remove_body(gate);
    step();
    CHECK(seen == "bppebe");
  }
}

TEST_CASE("trigger: on the body of a patch it is not in the way of its rays") {
  World<double> world({.time_step = gate_step});
  BodyDef<double> def{.shape = Box<double>{{0.1, 0.1, 0.1}}};
  def.shapes = {{.shape = Sphere<double>{1}, .is_trigger = true}};
  const BodyId body = world.add_body(def);
  PatchDef<double> pad;
  pad.sensors.add(Vec3<double>(0, 0, -0.1), Vec3<double>(0, 0, -0.12));
  pad.parameters.normal_stiffness = 10;
  CHECK_NOTHROW(world.add_patch(body, pad));
}

TEST_CASE("trigger: none of a crowd is put off") {
  World<double> world({.gravity = {0, 0, 0}, .time_step = gate_step});
  constexpr int count = 40;
  for (int i = 0; i < count; ++i) {
    BodyDef<double> def;
    def.mass = 1.0;
    def.inertia = Mat3<double>(Mat3<double>::Identity());
    def.position = {0.02 * i, 0, 0};
    def.shapes = {{.shape = Sphere<double>{1}, .is_trigger = true}};
    world.add_body(def);
  }
  world.step();
  int begins = 0;
  world.for_each_contact_event([&](const ContactEvent&) { ++begins; });
  CHECK(begins == count * (count - 1) / 2);
  CHECK(world.report().pairs_put_off == 0);
}
