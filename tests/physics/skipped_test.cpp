/// @file
/// A step skips work that the scene does not need; the report shows it.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"
#include "scenes/stack.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>

#include <doctest/doctest.h>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("skipped: a patch with nothing in reach casts no ray") {
  PlateDef<double> def;
  def.drop = 1;
  auto scene = make_plate<double>(def);
  scene.world.step();
  const StepReport<double>& report = scene.world.report();
  CHECK(report.patches == 1);
  CHECK(report.patches_near == 0);
  CHECK(report.rays_cast == 0);
  CHECK(report.sensors_skipped == 16);
  CHECK(report.sensors_touching == 0);
  CHECK(report.islands == 0);
  CHECK(report.factorisations == 0);
}

TEST_CASE("skipped: a patch in reach casts one ray a sensor and shape") {
  auto scene = make_plate<double>({});
  scene.world.step();
  CHECK(scene.world.report().patches_near == 1);
  CHECK(scene.world.report().rays_cast == 16);
  CHECK(scene.world.report().sensors_skipped == 0);
  CHECK(scene.world.report().sensors_touching == 16);
  CHECK(scene.world.report().implicit_pairs == 1);
  CHECK(scene.world.report().direct_islands == 1);
}

// The boxes of the two meet; the surface is beyond the rays, then within their reach, then beyond
// them again.
TEST_CASE_TEMPLATE("skipped: a patch beside a mesh asks none of its sensors", S, float, double) {
  World<S> world({.gravity = Vec3<S>::Zero(), .time_step = S(1e-3)});
  const BodyId floor = world.add_body({.motion = Motion::fixed});
  PatchDef<S> def;
  for (int i = 0; i < 400; ++i) {
    def.sensors.add({S(1e-3) * S(i % 20), S(1e-3) * S(i / 20), 0}, {0, 0, 1}, S(0.005));
  }
  def.parameters.normal_stiffness = S(1);
  world.add_patch(floor, def);
  BodyDef<S> ball;
  ball.motion = Motion::kinematic;
  ball.shape = sphere_mesh<S>(S(0.05), 12);
  ball.position = {S(0.05), S(0.05), S(0.04)};
  const BodyId id = world.add_body(ball);
  const auto step_at = [&](S x) {
    Transform<S> pose = world.pose(id);
    pose.translation.x() = x;
    world.set_pose(id, pose);
    world.step();
    return world.report();
  };
  const StepReport<S> beside = step_at(S(0.05));
  CHECK(beside.patches_near == 1);
  CHECK(beside.rays_cast == 0);
  CHECK(beside.sensors_skipped == 400);
  const StepReport<S> over = step_at(S(0.01));
  CHECK(over.rays_cast > 0);
  CHECK(over.sensors_touching > 0);
  // A body that was met is queried once more, then no longer.
  CHECK(step_at(S(0.05)).sensors_touching == 0);
  const StepReport<S> again = step_at(S(0.05));
  CHECK(again.patches_near == 1);
  CHECK(again.rays_cast == 0);
  CHECK(again.sensors_touching == 0);
  // Within the ball all are pressed in fully, though no surface is near.
  ball.shape = sphere_mesh<S>(S(0.5), 12);
  ball.position = Vec3<S>::Zero();
  world.add_body(ball);
  CHECK(step_at(S(0.05)).sensors_touching == 400);
}

TEST_CASE("skipped: an explicit patch needs no solver") {
  PlateDef<double> def;
  def.integration = Integration::explicit_;
  auto scene = make_plate<double>(def);
  scene.world.step();
  CHECK(scene.world.report().explicit_pairs == 1);
  CHECK(scene.world.report().rows == 0);
  CHECK(scene.world.report().islands == 0);
  CHECK(scene.world.report().sweeps == 0);
}

TEST_CASE("skipped: between bodies that forces do not move there is nothing to solve") {
  World<double> world;
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  const BodyId body = world.add_body({.motion = Motion::kinematic, .position = {0, 0, 0.004}});
  PatchDef<double> def;
  def.sensors.add(Vec3<double>::Zero(), {0, 0, -1}, 0.01);
  def.parameters.normal_stiffness = 1;
  def.integration = Integration::implicit;
  world.add_patch(body, def);
  world.step();
  CHECK(world.report().sensors_touching == 1);
  CHECK(world.report().implicit_pairs == 0);
  CHECK(world.report().islands == 0);
}

TEST_CASE("skipped: bodies at rest on hard contact take one sweep a step") {
  StackDef<double> def;
  def.masses = {1};
  auto scene = make_stack<double>(def);
  scene.run(2);
  scene.world.step();
  CHECK(scene.world.report().contact_points == 4);
  CHECK(scene.world.report().rows == 12);
  CHECK(scene.world.report().sweeps <= 2);
  CHECK(scene.world.report().position_sweeps == 0);
  CHECK(scene.world.report().direct_islands == 0);
  CHECK(scene.world.report().backend_failures == 0);
}

TEST_CASE("skipped: fixed bodies are not tested against each other") {
  World<double> world;
  for (int i = 0; i < 5; ++i) {
    world.add_body({.motion = Motion::fixed, .shape = Box<double>{{1, 1, 1}}});
  }
  world.step();
  CHECK(world.report().pairs_tested == 0);
  CHECK(world.report().pairs_collided == 0);
}

TEST_CASE("skipped: an island at rest under implicit sensors is solved once a step") {
  auto scene = make_plate<double>({});
  scene.run(2);
  CHECK(scene.world.report().factorisations == 1);
}
