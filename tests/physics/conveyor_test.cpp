/// @file
/// Surfaces that run on their bodies: friction drags along what touches them.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

using namespace bristle;
using namespace bristle::detail;

namespace {

constexpr double belt_step = 1.0 / 240;
constexpr double belt_friction = 0.4;

Material<double> belt_surface(const Vec3<double>& velocity) {
  return {.friction = belt_friction, .surface_velocity = velocity};
}

/// A belt whose top is z = 0.
BodyDef<double> belt(const Vec3<double>& velocity) {
  return {.motion = Motion::fixed,
          .shape = Box<double>{{5, 5, 0.5}},
          .material = belt_surface(velocity),
          .position = {0, 0, -0.5}};
}

BodyDef<double> crate(const Vec3<double>& position) {
  return {.mass = 1.0,
          .shape = Box<double>{{0.1, 0.1, 0.1}},
          .material = {.friction = belt_friction},
          .position = position};
}

}  // namespace

// v = belt_friction g t until it rides along.
TEST_CASE("conveyor: a crate is dragged along by Coulomb's law, and then rides without slip") {
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    World<double> world({.time_step = belt_step, .integrator = integrator});
    world.add_body(belt({0, 1, 0}));
    const BodyId box = world.add_body(crate({0, 0, 0.1}));
    double way = 0;
    for (int i = 1; i <= 240; ++i) {
      world.step();
      const double expected = std::min(1.0, belt_friction * 9.81 * belt_step * i);
      CHECK(world.body(box).twist.linear.y() == test::relative(expected).epsilon(1e-6));
      way += belt_step * expected;
    }
    CHECK(std::abs(world.body(box).twist.linear.x()) < 1e-6);
    CHECK(world.pose(box).translation.y() == test::relative(way).epsilon(0.02));
    CHECK(std::abs(world.pose(box).translation.z() - 0.1) < 1e-6);
  }
}

TEST_CASE("conveyor: runs in the axes of its shape, and up a slope steeper than it has to") {
  const double slope = 0.3;  // tan(slope) < belt_friction
  World<double> world({.time_step = belt_step});
  BodyDef<double> def = belt({0, 0, 0});
  const Quat<double> tilt(std::cos(slope / 2), 0, -std::sin(slope / 2), 0);  // +x goes up.
  // The shape is turned on its body about z: its own y axis is the body's -x axis.
  ShapeDef<double> shape;
  shape.shape = *def.shape;
  shape.X_BS.rotation = Quat<double>(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  shape.material = belt_surface({0, -0.5, 0});
  def.shape = {};
  def.shapes = {shape};
  def.orientation = tilt;
  def.position = tilt * Vec3<double>(0, 0, -0.5);
  world.add_body(def);
  BodyDef<double> box = crate(tilt * Vec3<double>(0, 0, 0.1));
  box.orientation = tilt;
  const Vec3<double> up = tilt * Vec3<double>(1, 0, 0);
  box.velocity = 0.5 * up;
  const BodyId id = world.add_body(box);
  for (int i = 0; i < 480; ++i) world.step();
  CHECK((world.body(id).twist.linear - 0.5 * up).norm() < 1e-6);
  CHECK((world.pose(id).translation - (box.position + up)).norm() < 1e-5);
}

TEST_CASE("conveyor: pushes nothing along its normal, and a body that it carries nothing at rest") {
  World<double> world({.gravity = {0, 0, 0}, .time_step = belt_step});
  world.add_body(belt({0, 0, 3}));
  const BodyId above = world.add_body(crate({0, 0, 0.1}));
  for (int i = 0; i < 60; ++i) world.step();
  CHECK(world.pose(above).translation == Vec3<double>(0, 0, 0.1));
  CHECK(world.body(above).twist.linear == Vec3<double>(0, 0, 0));
}

// A vehicle with a belt on its back, on ice: momentum of both is that of gravity alone.
TEST_CASE(
    "conveyor: on a body that moves, momentum is kept, and the relative speed is the belt's") {
  World<double> world({.time_step = belt_step});
  world.add_body(
      {.motion = Motion::fixed, .shape = HalfSpace<double>{}, .material = {.friction = 0}});
  BodyDef<double> car{.mass = 4.0,
                      .shape = Box<double>{{1, 0.5, 0.1}},
                      .material = belt_surface({1, 0, 0}),
                      .position = {0, 0, 0.1}};
  const BodyId lower = world.add_body(car);
  const BodyId upper = world.add_body(crate({-0.5, 0, 0.3}));
  for (int i = 0; i < 120; ++i) world.step();
  const double v = world.body(lower).twist.linear.x();
  const double u = world.body(upper).twist.linear.x();
  CHECK(std::abs(4 * v + u) < 1e-6);
  CHECK(u - v == test::relative(1).epsilon(1e-6));
}

// Islands that are swept have rows of their own. Friction of the pair is sqrt(0.4 0.025) = 0.1.
TEST_CASE("conveyor: a pyramid of 120 crates is dragged as one, and then rides along") {
  World<double> world({.time_step = belt_step});
  BodyDef<double> def = belt({1, 0, 0});
  def.material.friction = 0.025;
  world.add_body(def);
  std::vector<BodyId> boxes;
  for (int k = 0; k < 15; ++k) {
    for (int i = 0; i < 15 - k; ++i) {
      boxes.push_back(world.add_body(crate({-2 + 0.201 * i + 0.1005 * k, 0, 0.1 + 0.2 * k})));
    }
  }
  const auto mean_speed = [&] {
    double sum = 0;
    for (const BodyId id : boxes) sum += world.body(id).twist.linear.x();
    return sum / static_cast<double>(boxes.size());
  };
  for (int i = 0; i < 120; ++i) world.step();
  CHECK(world.report().direct_islands == 0);
  CHECK(mean_speed() == test::relative(0.1 * 9.81 * 0.5).epsilon(0.01));
  for (int i = 0; i < 360; ++i) world.step();
  for (const BodyId id : boxes) {
    CHECK(world.body(id).twist.linear.x() == test::relative(1).epsilon(0.01));
  }
}

TEST_CASE("conveyor: two belts on one body drag two crates both ways") {
  World<double> world({.time_step = belt_step});
  BodyDef<double> def{.motion = Motion::fixed};
  for (const double side : {-1.0, 1.0}) {
    ShapeDef<double> shape;
    shape.shape = Box<double>{{5, 0.5, 0.5}};
    shape.X_BS.translation = {0, side, -0.5};
    shape.material = belt_surface({side, 0, 0});
    def.shapes.push_back(shape);
  }
  world.add_body(def);
  const BodyId left = world.add_body(crate({0, -1, 0.1}));
  const BodyId right = world.add_body(crate({0, 1, 0.1}));
  for (int i = 0; i < 240; ++i) world.step();
  CHECK(world.body(left).twist.linear.x() == test::relative(-1).epsilon(1e-6));
  CHECK(world.body(right).twist.linear.x() == test::relative(1).epsilon(1e-6));
}

TEST_CASE("conveyor: starts, stops and is restored by the material of its body") {
  World<double> world({.time_step = belt_step});
  const BodyId line = world.add_body(belt({0, 0, 0}));
  const BodyId box = world.add_body(crate({0, 0, 0.1}));
  for (int i = 0; i < 60; ++i) world.step();
  const auto still = world.snapshot();
  CHECK(world.body(box).twist.linear.norm() < 1e-9);
  world.set_material(line, belt_surface({1, 0, 0}));
  for (int i = 0; i < 120; ++i) world.step();
  CHECK(world.body(box).twist.linear.x() == test::relative(1).epsilon(1e-6));
  const auto running = world.snapshot();
  world.restore(still);
  for (int i = 0; i < 60; ++i) world.step();
  CHECK(world.body(box).twist.linear.norm() < 1e-9);
  world.restore(running);
  world.step();
  CHECK(world.body(box).twist.linear.x() == test::relative(1).epsilon(1e-6));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH_AS(world.set_material(line, belt_surface({0, nan, 0})),
                       doctest::Contains("Material::surface_velocity"), InvalidArgument);
}

TEST_CASE("conveyor: what a slow belt carries does not fall asleep, and one belt of two may stop") {
  World<double> world({.time_step = belt_step, .sleep = {.time = 0.2}});
  BodyDef<double> def{.motion = Motion::fixed};
  def.shapes = {{.shape = Box<double>{{5, 0.5, 0.5}}, .X_BS = {.translation = {0, -1, -0.5}}},
                {.shape = Box<double>{{5, 0.5, 0.5}}, .X_BS = {.translation = {0, 1, -0.5}}}};
  const BodyId line = world.add_body(def);
  std::vector<ShapeId> belts;
  world.for_each_shape(line, [&](ShapeId id, const ShapeDef<double>&) { belts.push_back(id); });
  REQUIRE(belts.size() == 2);
  for (const ShapeId id : belts) world.set_material(id, belt_surface({0.008, 0, 0}));
  const BodyId left = world.add_body(crate({0, -1, 0.1}));
  const BodyId right = world.add_body(crate({0, 1, 0.1}));
  for (int i = 0; i < 240; ++i) world.step();
  CHECK(world.pose(left).translation.x() == test::relative(0.008).epsilon(0.01));
  CHECK(world.pose(right).translation.x() == test::relative(0.008).epsilon(0.01));
  world.set_material(belts[0], belt_surface({0, 0, 0}));
  for (int i = 0; i < 240; ++i) world.step();
  CHECK(world.is_asleep(left));
  CHECK(world.pose(right).translation.x() == test::relative(0.016).epsilon(0.01));
  CHECK_THROWS_AS(world.set_material(ShapeId{}, {}), InvalidArgument);
}

/// [m] Distance from where it belongs, of a crate that a belt on a turntable carries outwards.
double error_on_turntable(double step) {
  World<double> world({.gravity = {0, 0, -50}, .time_step = step});
  BodyDef<double> def = belt({0.2, 0, 0});
  def.motion = Motion::kinematic;
  def.angular_velocity = {0, 0, 1};
  world.add_body(def);
  BodyDef<double> box = crate({0, 0, 0.1});
  box.velocity = {0.2, 0, 0};
  box.angular_velocity = {0, 0, 1};
  const BodyId id = world.add_body(box);
  const int steps = static_cast<int>(std::lround(1 / step));
  for (int i = 0; i < steps; ++i) world.step();
  return (world.pose(id).translation - Vec3<double>(0.2 * std::cos(1), 0.2 * std::sin(1), 0.1))
      .norm();
}

TEST_CASE("conveyor: on a turntable it is of second order in the step") {
  const double coarse = error_on_turntable(1.0 / 60);
  const double fine = error_on_turntable(1.0 / 240);
  CHECK(coarse < 1.0 / 3600);  // h^2 w^2 times a metre; of first order it is 3.3e-3.
  CHECK(coarse / fine > 8);
}
