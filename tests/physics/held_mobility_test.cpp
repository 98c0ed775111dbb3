/// @file
/// How a body under a haptic tool gives way: by its mass, less what holds it.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/stylus.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

constexpr double mass = 0.2;
/// [kg m^2] Of a cube of 40 mm.
constexpr double inertia = mass * 0.04 * 0.04 / 6;

BodyDef<double> cube(double z, double friction = 0.5) {
  return {.mass = mass,
          .shape = Box<double>{{0.02, 0.02, 0.02}},
          .material = {.friction = friction},
          .position = {0, 0, z}};
}

/// Mobility that a loop over the body finds after some steps of the world.
HeldMobility<double> mobility_of(StylusScene<double>& scene, BodyId body, int steps) {
  for (int i = 0; i < steps; ++i) scene.world.step();
  const Vec3<double> at = scene.world.pose(body).translation + Vec3<double>(0, 0, 0.03);
  scene.loop.move(scene.tool, {Quat<double>::Identity(), at});
  scene.world.open(scene.loop);
  for (const HapticBody<double>& near : scene.loop.bodies()) {
    if (near.id() == body) return near.held();
  }
  FAIL("not near");
  return {};
}

/// Checks that a matrix is diagonal with these numbers, relative to the free body's.
void check_diagonal(const Mat6<double>& matrix, const Vec6<double>& expected) {
  Vec6<double> scale;
  scale << Vec3<double>::Constant(1 / std::sqrt(mass)),
      Vec3<double>::Constant(1 / std::sqrt(inertia));
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      CAPTURE(i);
      CAPTURE(j);
      const double wanted = i == j ? expected[i] : 0;
      CHECK(std::abs(matrix(i, j) - wanted) < 1e-7 * scale[i] * scale[j]);
    }
  }
}

}  // namespace

TEST_CASE("held_mobility: in the air by mass and inertia") {
  StylusScene<double> scene({});
  const auto held = mobility_of(scene, scene.world.add_body(cube(1)), 5);
  CHECK_FALSE(held.is_held);
  Vec6<double> free;
  free << Vec3<double>::Constant(1 / mass), Vec3<double>::Constant(1 / inertia);
  check_diagonal(held.matrix, free);
}

TEST_CASE("held_mobility: at rest on a rough table not at all, on a smooth one along it") {
  for (const double friction : {0.5, 0.0}) {
    StylusScene<double> scene({});
    scene.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    // A touch of tilt leaves friction something to do.
    const BodyId box = scene.world.add_body(cube(0.02, friction));
    const auto held = mobility_of(scene, box, 60);
    CHECK(held.is_held);
    Vec6<double> expected = Vec6<double>::Zero();
    if (friction == 0) expected << 1 / mass, 1 / mass, 0, 0, 0, 1 / inertia;
    check_diagonal(held.matrix, expected);
  }
}

TEST_CASE("held_mobility: what slides is free to go on sliding, and what bounces off is free") {
  StylusScene<double> scene({});
  scene.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId box = scene.world.add_body(cube(0.02));
  for (int i = 0; i < 60; ++i) scene.world.step();
  scene.world.set_velocity(box, {{1, 0, 0}, {0, 0, 0}});
  const auto held = mobility_of(scene, box, 3);
  CHECK(held.matrix(0, 0) == test::relative(1 / mass));
  CHECK(std::abs(held.matrix(2, 2)) < 1e-7 / mass);

  StylusScene<double> drop({});
  drop.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId ball = drop.world.add_body({.mass = mass,
                                           .shape = Sphere<double>{0.02},
                                           .material = {.restitution = 0.8},
                                           .position = {0, 0, 0.06}});
  bool was_hit = false;
  for (int i = 0; i < 30; ++i) {
    const auto bounced = mobility_of(drop, ball, 1);
    if (drop.world.body(ball).twist.linear.z() < 0.1 || !bounced.was_hit) continue;
    was_hit = true;
    CHECK(bounced.matrix(2, 2) == test::relative(1 / mass));
  }
  CHECK(was_hit);
}

// A motor by a spring and a damper adds what it resists with over a step.
TEST_CASE("held_mobility: a slide leaves its axis, its motor takes that, too, up to its force") {
  const double dt = 1.0 / 60;
  const double k = 200, d = 2;
  struct Case {
    MotorMode mode;
    double max_force, mobility;
  };
  for (const Case& c : {Case{MotorMode::none, 0, 1 / mass}, Case{MotorMode::velocity, 1000, 0},
                        Case{MotorMode::velocity, 0.5, 1 / mass},
                        Case{MotorMode::spring, 1000, 1 / (mass + dt * dt * k + dt * d)},
                        Case{MotorMode::spring, 0.1, 1 / mass}}) {
    CAPTURE(c.mobility);
    StylusScene<double> scene({});
    const BodyId frame = scene.world.add_body({.motion = Motion::fixed});
    const BodyId box = scene.world.add_body(cube(1));
    JointDef<double> slide;
    slide.kind = JointKind::prismatic;
    slide.body_a = frame;
    slide.body_b = box;
    // Along z: gravity pulls with 1.96 N.
    slide.X_AJ.rotation = slide.X_BJ.rotation =
        exp_rotation<double>(-0.5 * 3.14159265358979323846 * Vec3<double>::UnitY());
    slide.X_AJ.translation = {0, 0, 1};
    slide.motor = {.mode = c.mode, .max_force = c.max_force, .stiffness = k, .damping = d};
    scene.world.add_joint(slide);
    const auto held = mobility_of(scene, box, 3);
    Vec6<double> expected = Vec6<double>::Zero();
    expected[2] = c.mobility;
    check_diagonal(held.matrix, expected);
  }
}

// Sixteen sensors of the world's under the box: their stiffness and damping over a step belong to
// the inertia, which along the rays makes 1 / (m + dt^2 K + dt D).
TEST_CASE("held_mobility: a patch of the world adds what it resists with over a step") {
  StylusScene<double> scene({});
  const BodyId pad = scene.world.add_body({.motion = Motion::fixed});
  PatchDef<double> def = StylusScene<double>::pad_def({});
  for (double& z : def.sensors.direction.z) z = 1;
  def.parameters.static_friction = def.parameters.sliding_friction = 0;
  // Along the gradient the cube would lean and slide off a pad so small and smooth.
  def.options.normal = NormalDirection::ray;
  scene.world.add_patch(pad, def);
  const BodyId box = scene.world.add_body(cube(0.028));
  const auto held = mobility_of(scene, box, 240);
  CHECK(held.is_held);
  const double dt = 1.0 / 60;
  const double K = 16 * 0.5 / 0.01;
  const double D = 16 * 0.005 / 0.01;
  CHECK(held.matrix(2, 2) == test::relative(1 / (mass + dt * dt * K + dt * D)).epsilon(1e-6));
  CHECK(held.matrix(0, 0) == test::relative(1 / mass).epsilon(1e-6));
}
