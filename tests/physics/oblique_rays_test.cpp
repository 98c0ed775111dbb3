/// @file
/// Rays that do not meet the surface head-on.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;
using namespace bristle::scenes;

namespace {

/// [m/s^2] Of a frictionless plate with rays at an angle, once its height has settled.
double acceleration(NormalDirection normal, Integration integration, double angle) {
  PlateDef<double> def;
  def.integration = integration;
  def.inertia_factor = 1e6;
  def.parameters.static_friction = 0;
  def.parameters.sliding_friction = 0;
  def.options.normal = normal;
  def.ray_angle = angle;
  auto scene = make_plate<double>(def);
  scene.run(1);
  const double before = scene.velocity().x();
  scene.run(1);
  return scene.velocity().x() - before;
}

}  // namespace

TEST_CASE(
    "oblique_rays: force along the ray pushes by -g tan(angle), along the gradient not (R15)") {
  for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
    for (const double degrees : {5.0, 15.0, 30.0}) {
      const double angle = degrees * std::numbers::pi / 180;
      const double closed = -9.81 * std::tan(angle);
      if (degrees == 15.0) CHECK(closed == test::relative(-2.6286).epsilon(1e-4));
      // Implicitly, the ray's direction enters with the impulse of the pass before.
      CHECK(std::abs(acceleration(NormalDirection::ray, integration, angle) - closed) < 1e-3);
      CHECK(std::abs(acceleration(NormalDirection::gradient, integration, angle)) < 1e-3);
    }
  }
}

TEST_CASE("oblique_rays: depth and point of touch follow the ray") {
  // A ray from 4 mm above the plane at 30 degrees meets it after 4 / cos 30 mm.
  World<double> world;
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId body = world.add_body({.motion = Motion::kinematic, .position = {0.1, 0.2, 0.004}});
  PatchDef<double> def;
  const double angle = std::numbers::pi / 6;
  def.sensors.add(Vec3<double>::Zero(), {std::sin(angle), 0, -std::cos(angle)}, 0.01);
  def.parameters.normal_stiffness = 2;
  const PatchId patch = world.add_patch(body, def);
  world.step();
  const auto reading = world.reading(patch);
  const double distance = 0.004 / std::cos(angle);
  CHECK(reading.depth[0] == test::relative(1 - distance / 0.01).epsilon(1e-12));
  CHECK(reading.normal_force[0] == test::relative(2 * reading.depth[0]).epsilon(1e-12));
  CHECK(reading.point_x[0] == test::relative(0.1 + 0.004 * std::tan(angle)).epsilon(1e-12));
  CHECK(reading.point_y[0] == test::relative(0.2).epsilon(1e-12));
  CHECK(std::abs(reading.point_z[0]) < 1e-15);
}

TEST_CASE("oblique_rays: a ray that grazes a surface feels nothing") {
  // Beyond m . n > -0.1, that is within 5.7 degrees of the surface.
  for (const double degrees : {80.0, 84.0, 85.0, 89.0}) {
    World<double> world;
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    const BodyId body = world.add_body({.motion = Motion::kinematic, .position = {0, 0, 1e-4}});
    PatchDef<double> def;
    const double angle = degrees * std::numbers::pi / 180;
    def.sensors.add(Vec3<double>::Zero(), {std::sin(angle), 0, -std::cos(angle)}, 0.02);
    def.parameters.normal_stiffness = 1;
    const PatchId patch = world.add_patch(body, def);
    world.step();
    CHECK((world.reading(patch).touching() == 1) == (std::cos(angle) >= 0.1));
  }
}
