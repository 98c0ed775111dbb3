/// @file
/// Bodies of any size and speed that are shot at a thin wall.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/momentum.hpp"
#include "support/random.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/terrain.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

namespace bristle::scenes {

/// What is shot at. All but the ground are a slab of 4 x 4 m below z = 0.
enum class ShotWall { fixed, mesh, free, hinged, ground };

/// A shot that does not depend on the wall.
struct Shot {
  BodyDef<double> body;
  /// [m] Of the wall.
  double thickness = 0;
  std::uint64_t ground_seed = 0;
};

/// A ball, needle, plate, rod or brick.
/// @param size  [m] Half of its length, about.
[[nodiscard]] inline Shape<double> shot_shape(std::uint64_t kind, double size) {
  switch (kind % 5) {
    case 0:
      return Sphere<double>{size};
    case 1:
      return Capsule<double>{0.1 * size, size};
    case 2:
      return Box<double>{{size, size, 0.1 * size}};
    case 3:
      return Cylinder<double>{0.5 * size, size};
    default:
      return Box<double>{{size, 0.7 * size, 0.5 * size}};
  }
}

/// The shot of a number: a body of 4 mm to 10 cm, turned anyhow, at 1 to 1000 m/s at a wall of 1 to
/// 10 mm, up to 27 degrees aslant. It spins by up to half a radian a step about each axis.
/// @param dt  [s] The step.
[[nodiscard]] inline Shot shot_of(std::uint64_t number, double dt) {
  test::Random random(number);
  const double size = std::pow(10.0, random.uniform(-2.7, -1.3));
  Shot shot;
  shot.thickness = std::pow(10.0, random.uniform(-3.0, -2.0));
  shot.ground_seed = number;
  BodyDef<double>& body = shot.body;
  body.mass = 0.1;
  body.shape = shot_shape(number, size);
  body.orientation = random.rotation<double>();
  const double speed = std::pow(10.0, random.uniform(0.0, 3.0));
  const double slant = random.uniform(-0.5, 0.5);
  const double height = 0.06 + 1.5 * size + random.uniform(0.0, 0.4);
  body.position = {-slant * height, 0, height};
  body.velocity = {slant * speed, 0, -speed};
  body.angular_velocity = random.in_cube(0.5 / dt);
  return shot;
}

/// Adds the wall of a shot.
[[nodiscard]] inline BodyId add_wall(World<double>& world, ShotWall wall, const Shot& shot) {
  const Vec3<double> half(2, 2, shot.thickness / 2);
  BodyDef<double> def{.motion = Motion::fixed,
                      .mass = 20,
                      .shape = Box<double>{half},
                      .position = {0, 0, -shot.thickness / 2}};
  if (wall == ShotWall::mesh) def.shape = box_mesh<double>(half);
  if (wall == ShotWall::free || wall == ShotWall::hinged) def.motion = Motion::dynamic;
  if (wall == ShotWall::ground) {
    constexpr std::array<std::uint32_t, 2> cells{40, 40};
    test::Random random(shot.ground_seed);
    std::vector<double> heights((cells[0] + 1) * (cells[1] + 1));
    for (double& height : heights) height = random.uniform(-0.04, 0.0);
    const auto surface = height_field_mesh<double>({4, 4}, cells, heights);
    def.shape = extruded_mesh<double>(surface, {0, 0, -0.5});
    def.position = {0, 0, 0};
  }
  const BodyId id = world.add_body(def);
  if (wall == ShotWall::hinged) {
    // Along x, at the edge of largest y.
    const Quat<double> z_along_x(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3<double>::UnitY()));
    JointDef<double> hinge;
    hinge.kind = JointKind::revolute;
    hinge.body_b = id;
    hinge.X_AJ = {z_along_x, {0, half.y(), def.position.z()}};
    hinge.X_BJ = {z_along_x, {0, half.y(), 0}};
    world.add_joint(hinge);
  }
  return id;
}

/// What came of a shot.
struct ShotResult {
  /// True if the middle of the body came out behind the wall, and through it.
  bool has_passed = false;
  /// [1] Highest energy of body and wall, by that of the start.
  double energy = 1;
};

/// Shoots, and follows the body until it would be a way beyond, or has passed.
[[nodiscard]] inline ShotResult shoot(const Shot& shot, ShotWall wall, double dt) {
  World<double> world({.gravity = {0, 0, 0}, .time_step = dt});
  const BodyId wall_id = add_wall(world, wall, shot);
  const BodyId id = world.add_body(shot.body);
  const std::array<BodyId, 2> both{wall_id, id};
  const auto energy = [&] { return test::energy_of(world, std::span<const BodyId>(both)); };
  const auto seen_from_wall = [&]() -> Vec3<double> {
    return world.pose(wall_id).inverse() * world.pose(id).translation;
  };
  const double start = energy();
  const double behind = wall == ShotWall::ground ? -0.06 : -shot.thickness;
  const double speed = -shot.body.velocity.z();
  const auto steps = static_cast<int>(std::ceil(shot.body.position.z() / (speed * dt))) + 10;
  ShotResult result;
  Vec3<double> before = seen_from_wall();
  for (int i = 0; i < steps && !result.has_passed; ++i) {
    world.step();
    result.energy = std::max(result.energy, energy() / start);
    const Vec3<double> now = seen_from_wall();
    if (now.z() < behind && before.z() >= behind) {
      const double part = (before.z() - behind) / (before.z() - now.z());
      const Vec3<double> crossing = before + part * (now - before);
      result.has_passed = std::max(std::abs(crossing.x()), std::abs(crossing.y())) < 2;
    }
    before = now;
  }
  return result;
}

}  // namespace bristle::scenes
