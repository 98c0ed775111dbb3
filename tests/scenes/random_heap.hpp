/// @file
/// Random bodies that fall on a floor: every kind of shape, bodies of several shapes, joints,
/// patches of sensors; one number makes one scene.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/random.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace bristle::scenes {

/// Kinds of parts in a random scene.
struct HeapKind {
  /// [-] True if bodies may have several shapes, are joined to chains, carry sensors.
  bool compounds = false;
  bool joints = false;
  bool sensors = false;
  /// [-] Largest restitution of a material.
  double restitution = 0.9;
};

/// The built scene.
struct RandomHeap {
  World<double> world;
  std::vector<BodyId> bodies{};
  std::vector<JointId> joints{};
  /// [m] Largest half size of a body.
  double size = 0;
  /// [s] How long it runs.
  double duration = 0;
};

/// Builds scene `seed` of a kind: 3 to 10 bodies of 2 to 30 cm and 0.1 to 8 t/m^3 that fly about
/// above a floor, apart from each other, at steps of 1 ms to 1/60 s.
[[nodiscard]] RandomHeap make_random_heap(std::uint64_t seed, const HeapKind& kind);

// Implementation ----------------------------------------------------------------------------------

namespace parts {

/// A shape of about `size`, of any kind that a moving body can have. Meshes are convex or not.
[[nodiscard]] inline Shape<double> random_shape(test::Random& random, double size) {
  const auto part = [&] { return size * random.uniform(0.3, 1.0); };
  switch (random.index(9)) {
    case 0:
      return Sphere<double>{part()};
    case 1:
      return Capsule<double>{0.5 * part(), 0.5 * part()};
    case 2:
      return Cylinder<double>{part(), part()};
    case 3:
      return Cone<double>{part(), part()};
    case 4:
      return Ellipsoid<double>{{part(), part(), part()}};
    case 5: {
      std::vector<Vec3<double>> points;
      for (int i = 0; i < 12; ++i) points.push_back(size * random.direction<double>());
      return convex_hull<double>(std::span<const Vec3<double>>(points));
    }
    case 6:
      return box_mesh<double>({part(), part(), part()});
    default:
      return Box<double>{{part(), part(), part()}};
  }
}

[[nodiscard]] inline PatchDef<double> random_patch(test::Random& random, double size,
                                                   double weight) {
  PatchDef<double> patch;
  patch.may_point_inwards = true;  // Some start beside a shape and look through it.
  const int per_side = 3;
  const double ray = 0.3 * size;
  for (int i = 0; i < per_side; ++i) {
    for (int j = 0; j < per_side; ++j) {
      patch.sensors.add(Vec3<double>(0.5 * size * (i - 1), 0.5 * size * (j - 1), -0.9 * size),
                        Vec3<double>(0, 0, -1), ray);
    }
  }
  const double stiffness = weight / (per_side * per_side) * random.uniform(1.0, 10.0);
  patch.parameters = {stiffness, 0.05 * stiffness * random.uniform(0.0, 1.0),
                      random.uniform(5e2, 1e4), random.uniform(0.05, 1.0), 1e-3};
  patch.integration = Integration::implicit;
  return patch;
}

}  // namespace parts

inline RandomHeap make_random_heap(std::uint64_t seed, const HeapKind& kind) {
  test::Random random(seed);
  constexpr double time_steps[] = {1e-3, 1.0 / 240, 1.0 / 120, 1.0 / 60};
  WorldDef<double> world_def;
  world_def.time_step = time_steps[random.index(4)];
  RandomHeap heap{World<double>(world_def)};
  // As many steps in each.
  heap.duration = std::min(2.0, 200 * world_def.time_step);
  heap.size = random.uniform(0.04, 0.3);
  BodyDef<double> floor;
  floor.motion = Motion::fixed;
  if (random.index(2) == 0) {
    floor.shape = HalfSpace<double>{};
  } else {
    floor.shape = Box<double>{{50, 50, 1}};
    floor.position = {0, 0, -1};
  }
  floor.material = {random.uniform(0.0, 1.5), random.uniform(0.0, kind.restitution)};
  heap.world.add_body(floor);

  const std::size_t count = 3 + random.index(8);
  const double cell = 2.2 * heap.size;
  for (std::size_t i = 0; i < count; ++i) {
    // One above the other, a little aside, so that they meet.
    const bool is_joined = kind.joints && i > 0 && random.index(2) == 0;
    BodyDef<double> def;
    const double size = heap.size * random.uniform(0.2, 1.0);
    def.shape = parts::random_shape(random, size / std::sqrt(3.0));
    def.material = {random.uniform(0.0, 1.5), random.uniform(0.0, kind.restitution)};
    if (kind.compounds && random.index(2) == 0) {
      for (std::size_t k = 0; k < 1 + random.index(2); ++k) {
        ShapeDef<double> more;
        more.shape = parts::random_shape(random, 0.5 * size / std::sqrt(3.0));
        more.X_BS = random.pose(0.3 * size);
        more.material = def.material;
        def.shapes.push_back(more);
      }
    }
    def.density = 100 * std::pow(80, random.uniform(0.0, 1.0));
    const double height = cell * (0.55 + static_cast<double>(i));
    def.position = Vec3<double>(0.5 * heap.size * random.uniform(-1.0, 1.0),
                                0.5 * heap.size * random.uniform(-1.0, 1.0), height);
    def.orientation = random.rotation<double>();
    def.velocity = random.in_cube(2.0);
    def.angular_velocity = random.in_cube(8.0);
    const BodyId id = heap.world.add_body(def);
    if (is_joined) {
      JointDef<double> joint;
      constexpr JointKind kinds[] = {JointKind::ball, JointKind::ball, JointKind::fixed,
                                     JointKind::prismatic};
      joint.kind = kinds[random.index(4)];
      joint.body_a = heap.bodies.back();
      joint.body_b = id;
      // As they stand, at a point between them.
      const Transform<double> X_A = heap.world.pose(joint.body_a);
      const Transform<double> X_B = heap.world.pose(id);
      const Vec3<double> between = 0.5 * (X_A.translation + X_B.translation);
      const Transform<double> X_WJ{random.rotation<double>(), between};
      joint.X_AJ = X_A.inverse() * X_WJ;
      joint.X_BJ = X_B.inverse() * X_WJ;
      joint.X_AJ.rotation.normalize();
      joint.X_BJ.rotation.normalize();
      if (joint.kind == JointKind::prismatic) {
        joint.lower_limit = -0.3 * heap.size;
        joint.upper_limit = 0.3 * heap.size;
      }
      joint.bodies_collide = random.index(2) == 0;
      heap.joints.push_back(heap.world.add_joint(joint));
    }
    if (kind.sensors && random.index(2) == 0) {
      const double weight = heap.world.body(id).mass * 9.81;
      heap.world.add_patch(id, parts::random_patch(random, size / std::sqrt(3.0), weight));
    }
    heap.bodies.push_back(id);
  }
  return heap;
}

}  // namespace bristle::scenes
