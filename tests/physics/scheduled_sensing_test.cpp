/// @file
/// Patches that cast their rays every so many steps, are switched off, or are large and hardly
/// touched.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/grasp.hpp"
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/sensors/placement.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

/// Two fingers that stand still hold a ball or a box of 60 mm; pads cast every k-th step.
struct ScheduledGrip {
  World<double> world{WorldDef<double>{.time_step = 1e-3}};
  BodyId part{};
  PatchId pads[2]{};

  ScheduledGrip(std::uint32_t cast_every, bool is_ball) {
    const double half = 0.03;
    part =
        world.add_body({.mass = 0.5,
                        .shape = is_ball ? OptionalShape<double>(Sphere<double>{half})
                                         : OptionalShape<double>(Box<double>{{half, half, half}})});
    for (const int k : {0, 1}) {
      const double side = k == 0 ? -1 : 1;
      const BodyId finger = world.add_body({.motion = Motion::kinematic});
      PatchDef<double> pad;
      // Rays start 35 % of their length under the surface that the fingers press.
      for (int i = -2; i <= 2; ++i) {
        for (int j = -2; j <= 2; ++j) {
          pad.sensors.add({side * 0.0365, 0.004 * i, 0.004 * j}, {-side, 0, 0}, 0.01);
        }
      }
      pad.parameters = {1.2, 0.02, 1000, 0.5, 1e-3};
      // Between castings planes are kept: of a ball's they lean by d / R, and so would its
      // gradient.
      pad.options.normal = NormalDirection::ray;
      pad.cast_every = cast_every;
      pads[k] = world.add_patch(finger, pad);
    }
  }
  /// One second, in which the part is pulled to and fro; forces of the first pad.
  std::vector<double> run(std::uint64_t& rays) {
    std::vector<double> forces;
    for (int i = 0; i < 1000; ++i) {
      const double t = 1e-3 * i;
      world.apply_wrench(part, {{1.5 * std::sin(25 * t), 0, std::sin(40 * t)}, {0, 0, 0}});
      world.step();
      rays += world.report().rays_cast;
      forces.push_back(world.reading(pads[0]).total_normal());
    }
    return forces;
  }
};

/// By how much a grip that casts every k-th step departs from one that casts in each.
struct Departure {
  double force = 0;           // [N] Of the first pad, the worst in a second.
  double relative_force = 0;  // [-]
  double place = 0;           // [m] Of the part, at the end.
};

/// Calls check(departure) for several k. Rays are cast in a k-th of the steps at most.
template <typename Check>
void for_each_schedule(bool is_ball, const Check& check) {
  std::uint64_t all_rays = 0;
  ScheduledGrip reference(1, is_ball);
  const std::vector<double> expected = reference.run(all_rays);
  for (const std::uint32_t k : {2u, 4u, 8u}) {
    CAPTURE(k);
    ScheduledGrip grip(k, is_ball);
    std::uint64_t rays = 0;
    const std::vector<double> forces = grip.run(rays);
    Departure worst;
    for (std::size_t i = 0; i < forces.size(); ++i) {
      const double difference = std::abs(forces[i] - expected[i]);
      worst.force = std::max(worst.force, difference);
      worst.relative_force = std::max(worst.relative_force, difference / expected[i]);
    }
    worst.place =
        (grip.world.pose(grip.part).translation - reference.world.pose(reference.part).translation)
            .norm();
    check(worst);
    CHECK(rays <= all_rays / k + 100);
  }
}

/// A skin of 100 x 100 sensors that look up from z = 0, 1 mm apart and 10 mm long.
PatchDef<double> skin() {
  PatchDef<double> def;
  def.sensors = sensor_grid<double>({.center = {0, 0, 0.005},
                                     .side_u = {0.1, 0, 0},
                                     .side_v = {0, 0.1, 0},
                                     .count_u = 100,
                                     .count_v = 100});
  def.parameters = {0.1, 0.001, 1000, 0.1, 1e-3};
  // Shear is friction then, and nothing of a ball's round side.
  def.options.normal = NormalDirection::ray;
  return def;
}

}  // namespace

// On flat faces planes are exact: every k gives what k = 1 gives, to the rounding that a second of
// steps lets grow.
TEST_CASE("scheduled_sensing: a box held by pads that cast every k-th step") {
  for_each_schedule(false, [](const Departure& worst) {
    CHECK(worst.force < 1e-7);
    CHECK(worst.place < 1e-9);
  });
}

// On a ball the distance is off by d^2 / 2R after the part slid by d between castings; it moves at
// most at v, so d <= k dt v.
TEST_CASE("scheduled_sensing: a ball held by pads that cast every k-th step") {
  for_each_schedule(true, [](const Departure& worst) {
    CHECK(worst.relative_force < 0.005);
    CHECK(worst.place < 1e-8);
  });
}

TEST_CASE("scheduled_sensing: patches take turns") {
  World<double> world({.gravity = {0, 0, 0}});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  for (int i = 0; i < 8; ++i) {
    const BodyId body = world.add_body({.motion = Motion::kinematic, .position = {0, 0, 0.005}});
    PatchDef<double> def;
    def.sensors.add({0, 0, 0}, {0, 0, -1}, 0.01);
    def.parameters.normal_stiffness = 1;
    def.cast_every = 4;
    world.add_patch(body, def);
  }
  // At first nobody knows anything.
  world.step();
  CHECK(world.report().rays_cast == 8);
  for (int i = 0; i < 12; ++i) {
    world.step();
    CHECK(world.report().rays_cast == 2);
    CHECK(world.report().sensors_touching == 8);
  }
}

TEST_CASE("scheduled_sensing: what comes into reach between castings is met at once") {
  World<double> world({.gravity = {0, 0, 0}, .time_step = 1e-3});
  const BodyId pad = world.add_body({.motion = Motion::kinematic});
  PatchDef<double> def;
  def.sensors.add({0, 0, 0}, {0, 0, 1}, 0.01);
  def.parameters.normal_stiffness = 1;
  def.cast_every = 1000;
  const PatchId patch = world.add_patch(pad, def);
  const BodyId ball = world.add_body(
      {.motion = Motion::kinematic, .shape = Sphere<double>{0.05}, .position = {0, 0, 0.1}});
  world.set_velocity(ball, {{0, 0, -0.5}, {0, 0, 0}});
  std::uint64_t casts = 0;
  for (int i = 0; i < 95; ++i) {
    const double height = world.pose(ball).translation.z() - 0.05;
    world.step();
    casts += world.report().rays_cast;
    const double expected = std::max(0.0, 1 - height / 0.01);
    CHECK(world.reading(patch).depth[0] == test::relative(expected).epsilon(1e-9));
  }
  // At 0.5 mm a step, a quarter of the ray lasts for five.
  CHECK(casts < 12);
  // Removed and replaced by another in its slot, it is not taken for the old one.
  world.remove_body(ball);
  world.step();
  CHECK(world.reading(patch).touching() == 0);
  world.add_body(
      {.motion = Motion::fixed, .shape = Sphere<double>{0.05}, .position = {0, 0, 0.058}});
  world.step();
  CHECK(world.reading(patch).depth[0] == test::relative(0.2).epsilon(1e-9));
  CHECK_THROWS_AS(
      [&] {
        def.cast_every = 0;
        world.add_patch(pad, def);
      }(),
      InvalidArgument);
}

TEST_CASE("scheduled_sensing: a restored world goes on with the same bits, between castings, too") {
  for (const int before : {40, 41, 42, 43}) {
    ScheduledGrip original(4, true);
    const auto run = [](ScheduledGrip& grip, int first, int steps) {
      std::vector<std::uint64_t> hashes;
      for (int i = first; i < first + steps; ++i) {
        grip.world.apply_wrench(grip.part, {{0, 0, std::sin(0.3 * i)}, {0.01, 0, 0}});
        grip.world.step();
        hashes.push_back(grip.world.state_hash());
      }
      return hashes;
    };
    run(original, 0, before);
    const std::vector<std::byte> snapshot = original.world.snapshot();
    const auto expected = run(original, before, 30);
    original.world.restore(snapshot);
    CHECK(run(original, before, 30) == expected);
    ScheduledGrip fresh(4, true);
    fresh.world.restore(snapshot);
    CHECK(run(fresh, before, 30) == expected);
    ScheduledGrip other(3, true);
    CHECK_THROWS_AS(other.world.restore(snapshot), InvalidArgument);
  }
}

TEST_CASE("scheduled_sensing: a patch that is switched off lets go, and costs nothing") {
  auto scene = make_grasp<double>({});
  scene.run(0.1);
  const double held = scene.world.reading(scene.pads[0]).total_shear();
  REQUIRE(held == test::relative(0.25 * 9.81).epsilon(1e-3));
  scene.world.set_active(scene.pads[0], false);
  CHECK_FALSE(scene.world.patch(scene.pads[0]).is_active);
  CHECK(scene.world.reading(scene.pads[0]).touching() == 0);
  scene.world.step();
  CHECK(scene.world.report().patches == 2);
  CHECK(scene.world.report().patches_near == 1);
  CHECK(scene.world.report().rays_cast == 25);
  CHECK(scene.world.reading(scene.pads[0]).total_normal() == 0);
  const std::vector<std::byte> snapshot = scene.world.snapshot();
  // Back on, its bristles start anew: what the part fell in a step is viscous friction.
  scene.world.set_active(scene.pads[0], true);
  scene.world.step();
  CHECK(scene.world.reading(scene.pads[0]).touching() == 25);
  CHECK(scene.world.reading(scene.pads[0]).total_shear() < 0.4 * held);
  scene.world.restore(snapshot);
  CHECK_FALSE(scene.world.patch(scene.pads[0]).is_active);
  CHECK_THROWS_AS(scene.world.set_active(PatchId{}, true), InvalidArgument);
}

TEST_CASE("scheduled_sensing: switching off wakes what was held") {
  GraspDef<double> def;
  def.sleep.time = 0.2;
  auto scene = make_grasp<double>(def);
  scene.run(3);
  REQUIRE(scene.world.is_asleep(scene.part));
  scene.world.set_active(scene.pads[0], false);
  scene.world.set_active(scene.pads[1], false);
  CHECK_FALSE(scene.world.is_asleep(scene.part));
  scene.run(0.1);
  CHECK(scene.sag() > 0.03);
}

// A small body over a large skin: sensors beside it are not looked at, and those below read what a
// ray of their own says.
TEST_CASE("scheduled_sensing: of a large skin only what is near is sensed") {
  World<double> world({.gravity = {0, 0, 0}});
  const BodyId plate = world.add_body({.motion = Motion::kinematic});
  const PatchId patch = world.add_patch(plate, skin());
  const BodyId ball = world.add_body({.motion = Motion::kinematic,
                                      .shape = Sphere<double>{.radius = 0.01},
                                      .position = {0, 0, 0.018}});
  const BodyId cube =
      world.add_body({.motion = Motion::kinematic, .shape = Box<double>{{0.004, 0.003, 0.002}}});
  const std::size_t n = world.patch(patch).size();
  REQUIRE(n == 10000);
  test::Random random(3);
  const auto anywhere = [&](double z) {
    return Vec3<double>(random.uniform(-0.055, 0.055), random.uniform(-0.055, 0.055), z);
  };
  for (int round = 0; round < 50; ++round) {
    world.set_pose(ball, {Quat<double>::Identity(), anywhere(0.016)});
    world.set_pose(cube, {exp_rotation<double>(anywhere(0.3) * 20), anywhere(0.008)});
    world.step();
    // The ball covers 21 rows of at most three packets, the cube 12 of two; both are asked of both.
    CHECK(world.report().rays_cast <= 2 * 16 * (21 * 3 + 12 * 2));
    CHECK(world.report().rays_cast + world.report().sensors_skipped >= n);
    const PatchReading<double> reading = world.reading(patch);
    const RayBatch<double> rays = world.patch(patch).geometry->rays(0);
    std::size_t touching = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const WorldHit<double> hit = world.cast_ray(rays[i]);
      // Grazing hits count as none (docs/sensors.md).
      const bool is_met = hit.distance < 0.01 * (1 - 1e-9) && hit.normal.z() <= -0.1;
      touching += is_met ? 1 : 0;
      const double depth = is_met ? 1 - hit.distance / 0.01 : 0;
      if (std::abs(reading.depth[i] - depth) > 1e-12) {
        CAPTURE(i);
        CHECK(reading.depth[i] == test::relative(depth));
      }
    }
    CHECK(reading.touching() >= touching);
  }
}

// Packets that are not looked at must not remember: a ball that was dragged there, taken away and
// put back meets bristles without stretch.
TEST_CASE("scheduled_sensing: far packets of a large skin have let go") {
  World<double> world({.gravity = {0, 0, 0}, .time_step = 1e-3});
  const PatchId patch = world.add_patch(world.add_body({.motion = Motion::fixed}), skin());
  const BodyId ball = world.add_body({.motion = Motion::kinematic,
                                      .shape = Sphere<double>{.radius = 0.01},
                                      .position = {0.02, 0.02, 0.018}});
  world.step();
  CHECK(world.reading(patch).total_shear() == 0);
  world.set_velocity(ball, {{0.1, 0, 0}, {0, 0, 0}});
  for (int i = 0; i < 6; ++i) world.step();
  // mu_S F_N e_T after 5 steps of 0.1 mm.
  const double normal = world.reading(patch).total_normal();
  CHECK(world.reading(patch).total_shear() ==
        test::relative(1000 * normal * 5e-4 + 0.1 * 0.1 * double(world.reading(patch).touching()))
            .epsilon(0.05));
  const Transform<double> there = world.pose(ball);
  world.set_velocity(ball, {});
  world.set_pose(ball, {Quat<double>::Identity(), {-0.03, -0.03, 0.018}});
  world.step();
  REQUIRE(world.reading(patch).touching() > 20);
  world.set_pose(ball, there);
  world.step();
  REQUIRE(world.reading(patch).touching() > 20);
  CHECK(world.reading(patch).total_shear() == 0);
}
