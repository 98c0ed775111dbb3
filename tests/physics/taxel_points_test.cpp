/// @file
/// Readings as sets of points: what gives way how far, and the force on it.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/toy_pinch.hpp"
#include "support/relative.hpp"

#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <vector>

using namespace bristle;

namespace {

std::vector<double> points_of(const World<double>& world, PatchId patch) {
  std::vector<double> points(6 * world.patch(patch).size(), -1);
  world.taxel_points(patch, points);
  return points;
}

}  // namespace

TEST_CASE("taxel_points: in a pinch skin sags with the part, and pulls as its bristles do") {
  scenes::ToyPinch pinch({});
  pinch.run(1);
  const double start = pinch.place().z();
  pinch.gravity = {0, 0, -9.81};
  pinch.run(2);
  const double sag = start - pinch.place().z();
  const double mu_S = pinch.world().patch(pinch.patches[0]).def.parameters.static_friction;
  for (std::size_t k = 0; k < 2; ++k) {
    CAPTURE(k);
    const double side = k == 0 ? 1 : -1;
    const PatchReading<double> reading = pinch.reading(k);
    const std::vector<double> points = points_of(pinch.world(), pinch.patches[k]);
    Vec3<double> sum = Vec3<double>::Zero();
    for (std::size_t i = 0; i < reading.size(); ++i) {
      const double* p = &points[6 * i];
      // Rays of 8 mm along x. The part is pressed into them, and hangs on them.
      CHECK(p[0] == test::relative(-side * 0.008 * reading.depth[i]).epsilon(1e-12));
      CHECK(p[2] == test::relative(-sag).epsilon(1e-6));
      CHECK(p[3] == test::relative(-side * reading.normal_force[i]).epsilon(1e-12));
      CHECK(p[5] == test::relative(mu_S * reading.normal_force[i] * p[2]).epsilon(1e-6));
      sum += Vec3<double>(p[3], p[4], p[5]);
    }
    CHECK((sum - reading.wrench.force).norm() < 1e-12 * sum.norm());
  }
}

TEST_CASE("taxel_points: they are in the axes of the patch's body, and zero without a contact") {
  // A plate that is turned and held, on which a ball lies by some of its sensors.
  World<double> world;
  const Quat<double> turn(Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, 0).normalized()));
  const BodyId plate = world.add_body({.motion = Motion::fixed, .orientation = turn});
  SensorLayout<double> sensors;
  for (int i = 0; i < 25; ++i) {
    const double x = 0.008 * (i % 5 - 2), y = 0.008 * (i / 5 - 2);
    sensors.add({x, y, 0}, {x, y, 0.01});
  }
  PatchDef<double> def;
  def.parameters = tuned_for<double>({.friction = 0.9, .load = 1, .mass = 0.1}).parameters(sensors);
  def.sensors = sensors;
  const PatchId patch = world.add_patch(plate, def);
  (void)world.add_body({.mass = 0.1,
                        .shape = Sphere<double>{0.02},
                        .position = turn * Vec3<double>(0.003, 0.002, 0.026)});
  for (int i = 0; i < 20; ++i) world.step();
  const PatchReading<double> reading = world.reading(patch);
  REQUIRE(reading.touching() > 3);
  REQUIRE(reading.touching() < 25);
  REQUIRE(reading.total_shear() > 0.01);
  const std::vector<double> points = points_of(world, patch);
  Vec3<double> sum = Vec3<double>::Zero();
  for (std::size_t i = 0; i < 25; ++i) {
    const double* p = &points[6 * i];
    sum += Vec3<double>(p[3], p[4], p[5]);
    if (reading.state[i] != SensorState::free) {
      CHECK(p[2] == test::relative(-0.01 * reading.depth[i]).epsilon(1e-12));
      continue;
    }
    for (int k = 0; k < 6; ++k) CHECK(p[k] == 0);
  }
  CHECK((turn * sum - reading.wrench.force).norm() < 1e-12 * sum.norm());
  std::vector<double> wrong(6 * 25 - 1);
  CHECK_THROWS_WITH_AS(world.taxel_points(patch, wrong), doctest::Contains("out.size()"),
                       InvalidArgument);
}

TEST_CASE("taxel_points: they are of the last step, whatever is changed after it") {
  // A block slides over a pad at 0.2 m/s: bristles let go at 1 mm.
  World<double> world;
  const BodyId plate = world.add_body({.motion = Motion::fixed});
  PatchDef<double> def;
  for (int i = 0; i < 16; ++i) {
    const double x = 0.01 * (i % 4), y = 0.01 * (i / 4);
    def.sensors.add({x, y, 0}, {x, y, 0.01});
  }
  def.parameters =
      tuned_for<double>({.friction = 0.2, .load = 10, .mass = 1}).parameters(def.sensors);
  def.options.reset = SlipReset::drag;
  const PatchId patch = world.add_patch(plate, def);
  const BodyId block = world.add_body({.mass = 1,
                                       .shape = Box<double>{{0.06, 0.06, 0.01}},
                                       .position = {0.015, 0.015, 0.017},
                                       .velocity = {0.2, 0, 0}});
  for (int i = 0; i < 10; ++i) {
    world.step();
    const std::vector<double> points = points_of(world, patch);
    const double sigma = def.parameters.breakaway_distance;
    for (std::size_t k = 0; k < 16; ++k) {
      CHECK(points[6 * k] <= sigma * (1 + 1e-12));
      CHECK(points[6 * k] >= 0);
    }
    if (i > 3) CHECK(points[0] > 0.9 * sigma);
  }
  const std::vector<double> before = points_of(world, patch);
  world.set_pose(block, {Quat<double>::Identity(), {0.5, 0, 0}});
  CHECK(points_of(world, patch) == before);
}
