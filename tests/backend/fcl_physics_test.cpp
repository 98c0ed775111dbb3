// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <scenes/drops.hpp>
#include <scenes/plates.hpp>
// FCL passes tests of the analytic backend from tests/physics: rest_on_table, tunnelling.

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("FclBackend: dropped shapes rest on a table without sinking or drifting") {
  for (const DropDef<double>& def : drops<double>()) {
    CAPTURE(def.name);
    for (const bool is_mesh : {false, true}) check_drop<FclBackend>(def, is_mesh);
  }
}

TEST_CASE("FclBackend: fast balls and spinning rods do not pass a thin plate") {
  for (const bool is_mesh : {false, true}) {
    for (int i = 0; i < 12; ++i) {
      CAPTURE(is_mesh);
      CAPTURE(i);
      check_fast_ball<FclBackend>(is_mesh, 0.04 + 0.26 * i, 0);
      check_spinning_rod<FclBackend>(Capsule<double>{0.02, 0.48}, is_mesh, i);
      check_spinning_rod<FclBackend>(Box<double>{{0.02, 0.02, 0.5}}, is_mesh, i);
    }
  }
}

TEST_CASE(
    "FclBackend: sensors that end inside their own body are refused, and all others are not") {
  const Vec3<double> half(0.03, 0.03, 0.03);
  const Shape<double> shapes[] = {Box<double>{half}, box_mesh<double>(half)};
  for (const Shape<double>& shape : shapes) {
    World<double, FclBackend> world;
    BodyDef<double> def;
    def.mass = 0.5;
    def.shapes.push_back({.shape = shape, .X_BS = {Quat<double>::Identity(), {0, 0, 0.1}}});
    const BodyId body = world.add_body(def);
    PatchDef<double> out, in;
    out.parameters.normal_stiffness = in.parameters.normal_stiffness = 10.0;
    out.sensors.add(Vec3<double>(0, 0, 0.075), Vec3<double>(0, 0, 0.065));
    in.sensors.add(Vec3<double>(0, 0, 0.065), Vec3<double>(0, 0, 0.075));
    CHECK_NOTHROW(world.add_patch(body, out));
    CHECK_THROWS_AS(world.add_patch(body, in), InvalidArgument);
    in.may_point_inwards = true;
    CHECK_NOTHROW(world.add_patch(body, in));
  }
}
