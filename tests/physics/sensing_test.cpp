/// @file
/// Sensors: their sense mask, their memory, and their readings.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;
using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

/// A kinematic carriage with sensors that look down at z = 0, 10 mm long, starting at 4 mm: depth
/// 0.6 over the floor.
template <typename S>
struct Carriage {
  World<S> world;
  BodyId floor{}, body{};
  PatchId patch{};
};

template <typename S>
PatchDef<S> looking_down(int sensors = 1) {
  PatchDef<S> def;
  for (int i = 0; i < sensors; ++i) {
    def.sensors.add(Vec3<S>(S(0.02) * S(i), 0, 0), Vec3<S>(0, 0, -1), S(0.01));
  }
  def.parameters = {S(2), S(0), S(1000), S(0), S(1e-3)};
  return def;
}

template <typename S>
Carriage<S> make_carriage(const PatchDef<S>& patch) {
  WorldDef<S> world_def;
  world_def.time_step = S(1e-3);
  Carriage<S> c{World<S>(world_def), {}, {}, {}};
  c.floor = c.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  c.body = c.world.add_body({.motion = Motion::kinematic, .position = {0, 0, S(0.004)}});
  c.patch = c.world.add_patch(c.body, patch);
  return c;
}

template <typename S>
void motor(Carriage<S>& c, const Vec3<S>& velocity) {
  c.world.set_velocity(c.body, {velocity, Vec3<S>::Zero()});
}

}  // namespace

TEST_CASE_TEMPLATE("sensing: depth, force and shear of one sensor by hand", S, float, double) {
  auto c = make_carriage<S>(looking_down<S>());
  const double eps = 100 * static_cast<double>(Tolerance<S>::round_off());
  c.world.step();
  auto r = c.world.reading(c.patch);
  CHECK(static_cast<double>(r.depth[0]) == test::relative(0.6).epsilon(eps));
  CHECK(static_cast<double>(r.normal_force[0]) == test::relative(1.2).epsilon(eps));
  CHECK(r.total_shear() == S(0));
  CHECK(r.body[0] == c.floor);
  CHECK(r.state[0] == SensorState::stuck);
  // The carriage moves +x: the bristle pulls it back with mu_S F_N e_T, e_T known at the step's
  // start.
  motor<S>(c, {S(0.05), 0, 0});
  for (int i = 0; i < 11; ++i) c.world.step();
  r = c.world.reading(c.patch);
  const double stretch = 10 * 0.05e-3;
  CHECK(static_cast<double>(r.shear_W.x()) ==
        test::relative(-1000 * 1.2 * stretch).epsilon(1e3 * eps));
  CHECK(static_cast<double>(r.wrench.force.z()) == test::relative(1.2).epsilon(eps));
  CHECK(r.slipping() == 0);
}

TEST_CASE("sensing: sliding friction and normal damping are rates") {
  PatchDef<double> def = looking_down<double>();
  def.parameters = {2, 0.03, 0, 4, 1e-3};
  auto c = make_carriage<double>(def);
  motor<double>(c, {0.2, -0.1, -0.05});
  c.world.step();
  const auto r = c.world.reading(c.patch);
  // F_N = K_N e_N + K_D v / L with 0.05 m/s into the floor; F_V = mu_V v_T. Whatever the step.
  CHECK(r.normal_force[0] == test::relative(1.2 + 0.03 * 0.05 / 0.01).epsilon(1e-9));
  CHECK(r.shear_W.isApprox(Vec3<double>(-0.8, 0.4, 0), 1e-9));
  c.world.set_time_step(1e-4);
  motor<double>(c, {0.2, -0.1, 1});
  c.world.step();
  // Pulled away faster than the spring pushes: never adhesive.
  CHECK(c.world.reading(c.patch).normal_force[0] == 0);
}

TEST_CASE("sensing: a bristle lets go beyond sigma_a and keeps the remainder, or drags") {
  for (const SlipReset reset : {SlipReset::release, SlipReset::drag}) {
    PatchDef<double> def = looking_down<double>();
    def.options.reset = reset;
    auto c = make_carriage<double>(def);
    motor<double>(c, {0.3, 0, 0});
    // Stretch at the start of step i is 0.3 i mm: 0, .3, .6, .9, then 1.2 -> .2 or 1.
    const double expected_release[] = {0, 0.3, 0.6, 0.9, 0.2, 0.5, 0.8, 0.1};
    const double expected_drag[] = {0, 0.3, 0.6, 0.9, 1, 1, 1, 1};
    for (int i = 0; i < 8; ++i) {
      c.world.step();
      const auto r = c.world.reading(c.patch);
      const double stretch = -r.shear_W.x() / 1.2;
      const double expected = reset == SlipReset::release ? expected_release[i] : expected_drag[i];
      CHECK(std::abs(stretch - expected) < 1e-9);
      const bool slips = reset == SlipReset::release ? i == 4 || i == 7 : i >= 4;
      CHECK((r.state[0] == SensorState::slipping) == slips);
    }
  }
}

TEST_CASE("sensing: what is lost and met again is met unstretched") {
  auto c = make_carriage<double>(looking_down<double>());
  motor<double>(c, {0.1, 0, 0});
  for (int i = 0; i < 5; ++i) c.world.step();
  REQUIRE(c.world.reading(c.patch).total_shear() > 0.1);
  const Transform<double> touching = c.world.pose(c.body);
  Transform<double> away = touching;
  away.translation.z() += 1;
  c.world.set_pose(c.body, away);
  c.world.step();
  CHECK(c.world.reading(c.patch).touching() == 0);
  CHECK(c.world.reading(c.patch).wrench.force.norm() == 0);
  c.world.set_pose(c.body, touching);
  c.world.step();
  CHECK(c.world.reading(c.patch).touching() == 1);
  CHECK(c.world.reading(c.patch).total_shear() == 0);
}

TEST_CASE("sensing: a bristle is anchored anew in another body") {
  auto c = make_carriage<double>(looking_down<double>());
  c.world.remove_body(c.floor);
  BodyId packets[2];
  for (int k = 0; k < 2; ++k) {
    packets[k] = c.world.add_body({.motion = Motion::fixed,
                                   .shape = Box<double>{{0.1, 0.1, 0.1}},
                                   .position = {k == 0 ? -0.0995 : 0.1005, 0, -0.1}});
  }
  motor<double>(c, {0.1, 0, 0});
  // The seam is at 0.5 mm, passed after five steps of 0.1 mm.
  double stretch = 0;
  for (int i = 0; i < 12; ++i) {
    const double x = c.world.pose(c.body).translation.x();
    if (std::abs(x - 0.5e-3) < 1e-9) {
      c.world.step();  // Exactly on the seam either packet is right.
      stretch = c.world.reading(c.patch).body[0] == packets[1] ? 0.1e-3 : stretch + 0.1e-3;
      continue;
    }
    c.world.step();
    const auto r = c.world.reading(c.patch);
    REQUIRE(r.touching() == 1);
    CHECK(r.body[0] == packets[x < 0.5e-3 ? 0 : 1]);
    const double now = r.total_shear() / 1200;
    if (i > 0 && x > 0.5e-3 && now < 1e-12) stretch = 0;  // Anchored anew.
    CHECK(now == test::relative(stretch).epsilon(1e-6));
    stretch += 0.1e-3;
  }
  CHECK(c.world.reading(c.patch).total_shear() / 1200 < 0.75e-3);
}

TEST_CASE("sensing: a removed body is let go, and its successor is another body") {
  auto c = make_carriage<double>(looking_down<double>());
  motor<double>(c, {0.1, 0, 0});
  for (int i = 0; i < 4; ++i) c.world.step();
  REQUIRE(c.world.reading(c.patch).total_shear() > 0);
  const BodyId old = c.floor;
  c.world.remove_body(c.floor);
  // In the same slot, but with another generation: the bristle must not take it for the old one.
  c.floor = c.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  REQUIRE(c.floor.index == old.index);
  c.world.step();
  CHECK(c.world.reading(c.patch).body[0] == c.floor);
  CHECK(c.world.reading(c.patch).total_shear() == 0);
  c.world.remove_body(c.floor);
  c.world.step();
  CHECK(c.world.reading(c.patch).touching() == 0);
}

TEST_CASE("sensing: a removed body leaves the reading at once, and nothing of it remains") {
  // A pad of two sensors over two plates: one under each.
  World<double> world;
  const BodyId pad = world.add_body({.motion = Motion::kinematic, .position = {0, 0, 0.104}});
  std::array<BodyId, 2> plates{};
  for (const int k : {0, 1}) {
    plates[static_cast<std::size_t>(k)] = world.add_body({.motion = Motion::fixed,
                                                          .shape = Box<double>{{0.09, 0.09, 0.1}},
                                                          .position = {k == 0 ? -0.1 : 0.1, 0, 0}});
  }
  PatchDef<double> def = looking_down<double>();
  def.sensors = {};
  for (const double x : {-0.02, 0.02, 0.03}) def.sensors.add({x, 0, 0}, {0, 0, -1}, 0.01);
  const PatchId patch = world.add_patch(pad, def);
  for (int i = 1; i < 4; ++i) {
    world.move_to(pad, {Quat<double>::Identity(), {1e-4 * i, 0, 0.104}});
    world.step();
  }
  const PatchReading<double> before = world.reading(patch);
  REQUIRE(before.touching() == 3);
  REQUIRE(before.shear_W.x() != 0);
  const double first = before.normal_force[0];
  const double shear_of_first = before.shear_1[0];

  world.remove_body(plates[1]);
  const PatchReading<double> after = world.reading(patch);
  CHECK(after.touching() == 1);
  for (const std::size_t i : {1u, 2u}) {
    CHECK(after.depth[i] == 0);
    CHECK(after.normal_force[i] == 0);
    CHECK(after.body[i] == BodyId{});
    CHECK(after.state[i] == SensorState::free);
  }
  // The wrench is now that of the first sensor, at its point.
  CHECK(after.normal_force[0] == first);
  CHECK(after.wrench.force.z() == test::relative(first));
  CHECK(after.wrench.torque.y() ==
        test::relative(0.02 * first - 0.004 * after.shear_W.x()).epsilon(1e-9));
  CHECK(after.shear_W.norm() == test::relative(std::abs(shear_of_first)));
  // The state is one that a snapshot may have, and goes on as itself.
  World<double> copy(world);
  copy.restore(world.snapshot());
  CHECK(copy.state_hash() == world.state_hash());
  copy.step();
  World<double> other(world);
  other.step();
  CHECK(copy.state_hash() == other.state_hash());

  world.remove_body(plates[0]);
  CHECK(world.reading(patch).touching() == 0);
  CHECK(world.reading(patch).wrench.force.norm() == 0);
  CHECK(world.reading(patch).wrench.torque.norm() == 0);
  CHECK(world.reading(patch).shear_W.norm() == 0);
  world.step();
  CHECK(world.reading(patch).touching() == 0);
}

TEST_CASE("sensing: a ray that starts inside is pressed in fully") {
  auto c = make_carriage<double>(looking_down<double>());
  Transform<double> X = c.world.pose(c.body);
  X.translation.z() = -0.003;
  c.world.set_pose(c.body, X);
  c.world.step();
  CHECK(c.world.reading(c.patch).depth[0] == 1);
  CHECK(c.world.reading(c.patch).normal_force[0] == test::relative(2));
  CHECK(c.world.reading(c.patch).wrench.force.z() == test::relative(2));
}

TEST_CASE("sensing: sensors never see their own body, excluded ones, or other categories") {
  for (int variant = 0; variant < 5; ++variant) {
    PatchDef<double> def = looking_down<double>();
    if (variant == 2) def.sense_mask = 2;
    auto c = make_carriage<double>(looking_down<double>());
    c.world.remove_patch(c.patch);
    if (variant == 1) def.excluded = {c.floor};
    // A mask of zero keeps bodies from touching, not from being sensed.
    if (variant == 3) c.world.set_filter(c.floor, {1, 0, 0});
    // Shapes of its own body lie in the way of every ray, and one of them around its end.
    def.may_point_inwards = true;
    c.world.add_shape(c.body, {Sphere<double>{0.02}, {}, {}});
    if (variant == 4) c.world.set_filter(c.floor, {4, 0, 0});
    if (variant == 4) def.sense_mask = 4;
    const PatchId patch = c.world.add_patch(c.body, def);
    c.world.step();
    const auto r = c.world.reading(patch);
    INFO("variant ", variant);
    if (variant == 1 || variant == 2) {
      CHECK(r.touching() == 0);
      CHECK(!r.body[0].generation);
    } else {
      CHECK(r.touching() == 1);
      CHECK(r.body[0] == c.floor);
      CHECK(r.depth[0] == test::relative(0.6));
    }
  }
}

TEST_CASE("sensing: sensors may have constants of their own") {
  PatchDef<double> def = looking_down<double>(3);
  def.per_sensor.assign(3, def.parameters);
  def.per_sensor[1].normal_stiffness = 6;
  def.per_sensor[2].breakaway_distance = 0.25e-3;
  auto c = make_carriage<double>(def);
  motor<double>(c, {0.1, 0, 0});
  for (int i = 0; i < 4; ++i) c.world.step();
  const auto r = c.world.reading(c.patch);
  CHECK(r.normal_force[0] == test::relative(1.2));
  CHECK(r.normal_force[1] == test::relative(3.6));
  const auto shear = [&](std::size_t i) { return std::hypot(r.shear_1[i], r.shear_2[i]); };
  CHECK(shear(0) == test::relative(1000 * 1.2 * 0.3e-3));
  CHECK(shear(1) == test::relative(3 * shear(0)));
  CHECK(shear(2) == test::relative(1000 * 1.2 * 0.05e-3));
  CHECK(r.slipping() == 1);
}

TEST_CASE("sensing: Eq. 11 scales friction with depth, for sensors that do not push") {
  PatchDef<double> def = looking_down<double>();
  def.options.scaling = FrictionScaling::depth;
  def.parameters.normal_stiffness = 0;
  auto c = make_carriage<double>(def);
  motor<double>(c, {0.1, 0, 0});
  for (int i = 0; i < 4; ++i) c.world.step();
  const auto r = c.world.reading(c.patch);
  CHECK(r.total_normal() == 0);
  CHECK(r.total_shear() == test::relative(1000 * 0.6 * 0.3e-3).epsilon(1e-9));
}

TEST_CASE("sensing: with K_N = 1 N and no damping, Eq. 1 and Eq. 11 are the same number") {
  for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
    Vec3<double> ends[2];
    for (int k = 0; k < 2; ++k) {
      PlateDef<double> def;
      def.integration = integration;
      def.incline = 0.4;
      def.parameters.normal_damping = 0;
      def.options.scaling = k == 0 ? FrictionScaling::normal_force : FrictionScaling::depth;
      auto scene = make_plate<double>(def);
      scene.run(0.3);
      ends[k] = scene.position();
    }
    // Implicitly, the depth is that at the start of the step and the force that at its end.
    const double tolerance = integration == Integration::explicit_ ? 1e-12 : 1e-5;
    CHECK((ends[0] - ends[1]).norm() < tolerance);
  }
}

TEST_CASE("sensing: constants can change while a bristle holds") {
  auto c = make_carriage<double>(looking_down<double>());
  motor<double>(c, {0.1, 0, 0});
  for (int i = 0; i < 4; ++i) c.world.step();
  const double before = c.world.reading(c.patch).total_shear();
  motor<double>(c, {0, 0, 0});
  c.world.step();
  const double held = c.world.reading(c.patch).total_shear();
  CHECK(held == test::relative(before * 4 / 3));
  auto parameters = looking_down<double>().parameters;
  parameters.static_friction = 500;
  c.world.set_parameters(c.patch, parameters);
  c.world.step();
  CHECK(c.world.reading(c.patch).total_shear() == test::relative(held / 2));
}
