/// @file
/// Nothing passes through a thin plate, however fast it comes or spins.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plates.hpp"
#include "support/random.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

using namespace bristle;
using namespace bristle::scenes;

namespace {

/// Shoots a needle, plate, rod or brick of 4 mm to 10 cm, turned anyhow and spinning, at 1 to 1000
/// m/s at a fixed plate of 1 cm.
/// @return Whether its middle has come out below, through the plate.
bool passes_when_hit_off_centre(test::Random& random, int shot, bool is_mesh) {
  const double size = std::pow(10.0, random.uniform(-2.7, -1.3));
  BodyDef<double> body{.mass = 0.1, .orientation = random.rotation<double>()};
  const Shape<double> shapes[] = {
      Capsule<double>{0.1 * size, size}, Box<double>{{size, size, 0.1 * size}},
      Cylinder<double>{0.5 * size, size}, Box<double>{{size, 0.7 * size, 0.5 * size}}};
  body.shape = shapes[shot % 4];
  const double speed = std::pow(10.0, random.uniform(0.0, 3.0));
  const double slant = random.uniform(-0.5, 0.5);
  const double height = 0.06 + 1.5 * size + random.uniform(0.0, 0.4);
  body.position = {-slant * height, 0, height};
  body.velocity = {slant * speed, 0, -speed};
  body.angular_velocity = random.in_cube(30.0);
  World<double> world({.gravity = {0, 0, 0}, .time_step = 1.0 / 60});
  world.add_body({.motion = Motion::fixed, .shape = thin_plate<double>(is_mesh)});
  const BodyId id = world.add_body(body);
  const auto steps = static_cast<int>(std::ceil(60 * height / speed)) + 10;
  Vec3<double> before = body.position;
  for (int i = 0; i < steps; ++i) {
    world.step();
    const Vec3<double> middle = world.pose(id).translation;
    if (middle.z() < -plate_half_thickness) {
      const double part = (before.z() + plate_half_thickness) / (before.z() - middle.z());
      const Vec3<double> crossing = before + part * (middle - before);
      return std::max(std::abs(crossing.x()), std::abs(crossing.y())) < 2;
    }
    before = middle;
  }
  return false;
}

}  // namespace

TEST_CASE("tunnelling: a ball of 5 cm at 100 m/s does not pass a plate of 1 cm") {
  // From all phases of the step, straight and aslant.
  for (const bool is_mesh : {false, true}) {
    for (int i = 0; i < 25; ++i) {
      CAPTURE(is_mesh);
      CAPTURE(i);
      check_fast_ball<AnalyticBackend>(is_mesh, 0.04 + 0.13 * i, 0);
      check_fast_ball<AnalyticBackend>(is_mesh, 0.04 + 0.13 * i, 60);
    }
  }
}

TEST_CASE("tunnelling: rods of 1 m that spin at 100 rad/s do not pass a plate of 1 cm") {
  for (const bool is_mesh : {false, true}) {
    for (int i = 0; i < 12; ++i) {
      CAPTURE(is_mesh);
      CAPTURE(i);
      check_spinning_rod<AnalyticBackend>(Capsule<double>{0.02, 0.48}, is_mesh, i);
      check_spinning_rod<AnalyticBackend>(Box<double>{{0.02, 0.02, 0.5}}, is_mesh, i);
    }
  }
}

// A hit far from the middle turns a body by radians in the step, for which no correction of its
// position holds. It moved by the mean of its velocities before and after the hit then: 96 of these
// 200 passed, by metres. Two do still, as their middle is carried through while they turn about a
// corner that is not. Which ones depends on last bits.
TEST_CASE("tunnelling: what is hit off its centre does not pass a plate of 1 cm") {
  for (const bool is_mesh : {false, true}) {
    CAPTURE(is_mesh);
    test::Random random(1);
    int passed = 0;
    for (int shot = 0; shot < 200; ++shot) {
      passed += passes_when_hit_off_centre(random, shot, is_mesh) ? 1 : 0;
    }
    CHECK(passed <= 5);
  }
}
