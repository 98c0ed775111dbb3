/// @file
/// Two patches wrapped around one finger: each resists sliding by its own friction.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/wrapping.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>

using namespace bristle;

TEST_CASE("wrapped patches: regions of one body have frictions of their own") {
  // The finger is a round bar about y. One strip of 20 degrees lies left of its top, one right.
  constexpr double radius = 0.02;
  constexpr double sigma = 1e-4;
  constexpr double degree = std::numbers::pi / 180;
  constexpr std::array<double, 2> friction{0.5, 1.5};
  TriangleMesh<double> finger = cylinder_mesh<double>({.radius = radius, .half_length = 0.04}, 72);
  const Quat<double> lying = exp_rotation<double>({std::numbers::pi / 2, 0, 0});
  for (Vec3<double>& p : finger.vertices) p = lying * p;

  for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
    World<double> world({.gravity = {0, 0, 0}, .time_step = 1e-3});
    const BodyId bar = world.add_body({.motion = Motion::fixed, .shape = finger});
    std::array<PatchId, 2> strips;
    for (std::size_t side = 0; side < 2; ++side) {
      const double turn = (side == 0 ? -10 : 10) * degree;
      WrapReport report;
      const TriangleMesh<double> skin = wrap_patch<double>(
          cylinder_patch<double>(
              {.radius = 0.03, .length = 0.03, .arc = 20 * degree, .cells = {4, 6}}),
          finger, {.X_SM = {exp_rotation<double>({0, turn, 0}), {0, 0, 0}}}, &report);
      REQUIRE(report.discarded() == 0);
      PatchDef<double> def;
      def.sensors = sensors_from_mesh<double>(skin, {.depth = 2e-3, .range = 4e-3});
      def.parameters = {.normal_stiffness = 1,
                        .normal_damping = 0,
                        .static_friction = friction[side] / sigma,
                        .sliding_friction = 0,
                        .breakaway_distance = sigma};
      // Along the rays: a smooth plate on oblique ones gives no shear.
      def.options = {.reset = SlipReset::drag, .normal = NormalDirection::ray};
      def.integration = integration;
      strips[side] = world.add_patch(bar, def);
    }
    // A plate presses 1.5 mm into their reach and slides along the bar, across no ray of theirs.
    world.add_body({.motion = Motion::kinematic,
                    .shape = Box<double>{{0.05, 0.2, 0.01}},
                    .filter = {1, 0, 0},
                    .position = {0, 0, radius + 0.5e-3 + 0.01},
                    .velocity = {0, 0.05, 0}});
    for (int i = 0; i < 200; ++i) world.step();
    for (std::size_t side = 0; side < 2; ++side) {
      const PatchReading<double> reading = world.reading(strips[side]);
      REQUIRE(reading.total_normal() > 1);
      CHECK(reading.shear_W.y() ==
            test::relative(friction[side] * reading.total_normal()).epsilon(1e-6));
      CHECK(std::abs(reading.shear_W.x()) < 1e-6 * reading.shear_W.y());
    }
    // The strips are mirror images, so they press alike.
    CHECK(world.reading(strips[0]).total_normal() ==
          test::relative(world.reading(strips[1]).total_normal()).epsilon(1e-6));
  }
}
