/// @file
/// Shapes that are dropped on a table.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <vector>

namespace bristle::scenes {

/// A shape and how it lies when it is at rest.
template <Scalar S>
struct DropDef {
  std::string name;
  Shape<S> shape;
  /// [m] Height of its centre of mass above the table at rest.
  S rest_height = S(0);
  /// [1] Attitude at rest, near which it is dropped.
  Quat<S> attitude = Quat<S>::Identity();
  /// [rad] How far from it.
  S tilt = S(0.05);
};

/// Shapes of about 10 cm, each on a face, or on its lowest point.
template <Scalar S>
[[nodiscard]] std::vector<DropDef<S>> drops() {
  const S quarter = S(std::numbers::pi / 2);
  const Quat<S> lying = exp_rotation<S>({quarter, S(0), S(0)});
  const Cylinder<S> cylinder{S(0.05), S(0.06)};
  const Cone<S> cone{S(0.05), S(0.06)};
  std::vector<Vec3<S>> corners;
  for (int i = 0; i < 3; ++i) {
    corners.push_back(S(0.06) * Vec3<S>::Unit(i));
    corners.push_back(S(-0.06) * Vec3<S>::Unit(i));
  }
  const ConvexHull<S> octahedron = convex_hull<S>(std::span<const Vec3<S>>(corners));
  // Its face (-1, -1, -1) down.
  const Vec3<S> face = Vec3<S>::Constant(-std::sqrt(S(1) / S(3)));
  const Vec3<S> axis = face.cross(Vec3<S>(S(0), S(0), S(-1)));
  const Quat<S> on_face = Quat<S>(S(1) - face.z(), axis.x(), axis.y(), axis.z()).normalized();
  std::vector<DropDef<S>> all;
  const auto add = [&](const char* name, const Shape<S>& shape, S height,
                       const Quat<S>& attitude = Quat<S>::Identity()) {
    all.push_back({name, shape, height, attitude});
  };
  add("cylinder upright", cylinder, S(0.06));
  add("cylinder lying", cylinder, S(0.05), lying);
  // The centre of mass of a cone is at a quarter of its height.
  add("cone on its base", cone, S(0.03));
  // Tilted it would rock for ever: nothing resists rolling.
  add("ellipsoid", Ellipsoid<S>{{S(0.06), S(0.05), S(0.03)}}, S(0.03));
  all.back().tilt = S(0);
  add("octahedron on a face", octahedron, S(0.06) / std::sqrt(S(3)), on_face);
  add("capsule lying", Capsule<S>{S(0.03), S(0.05)}, S(0.03), lying);
  add("block", box_mesh<S>({S(0.05), S(0.04), S(0.03)}), S(0.03));
  return all;
}

/// A body above a table.
template <Scalar S, typename Backend>
struct Drop {
  World<S, Backend> world;
  BodyId body{};
  /// [m] Height of the table's top.
  S table_top = S(0);
};

/// A shape 2 cm above a table, tilted a little.
template <typename Backend, Scalar S>
[[nodiscard]] Drop<S, Backend> make_drop(const DropDef<S>& def, bool is_mesh) {
  const Vec3<S> half(S(0.5), S(0.4), S(0.05));
  Drop<S, Backend> drop{World<S, Backend>(WorldDef<S>{}), {}, half.z()};
  BodyDef<S> table;
  table.motion = Motion::fixed;
  table.shape = is_mesh ? Shape<S>(box_mesh<S>(half)) : Shape<S>(Box<S>{half});
  drop.world.add_body(table);
  BodyDef<S> body;
  body.shape = def.shape;
  // Turned about the vertical and tilted.
  body.orientation = exp_rotation<S>({S(0.6) * def.tilt, S(0.8) * def.tilt, S(0)}) *
                     exp_rotation<S>({S(0), S(0), S(0.4)}) * def.attitude;
  body.position = {S(0.03), S(-0.02), half.z() + def.rest_height + S(0.02)};
  drop.body = drop.world.add_body(body);
  return drop;
}

/// Checks that a dropped shape lies still at its height after 3 s.
template <typename Backend, Scalar S>
void check_drop(const DropDef<S>& def, bool is_mesh) {
  auto [world, id, table_top] = make_drop<Backend>(def, is_mesh);
  const auto run = [&world = world](S seconds) {
    for (S t = S(0); t < seconds; t += world.time_step()) world.step();
  };
  run(S(3));
  const Transform<S> settled = world.body(id).center_pose;
  CHECK(std::abs(settled.translation.z() - table_top - def.rest_height) < S(1e-6));
  CHECK(world.body(id).twist.linear.norm() < S(1e-5));
  run(S(1));
  const Transform<S> later = world.body(id).center_pose;
  CHECK((later.translation - settled.translation).norm() < S(1e-6));
  CHECK(later.rotation.angularDistance(settled.rotation) < S(1e-5));
  CHECK(world.report().contact_points > 0);
}

}  // namespace bristle::scenes
