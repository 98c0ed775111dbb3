// SPDX-License-Identifier: BSD-3-Clause
#include "support/example_scenes.hpp"
#include "support/relative.hpp"

#include <bristle/io/adf.hpp>
#include <bristle/io/stl.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <scenes/adf_meshes.hpp>

using namespace bristle;
using bristle::test::example_scenes;

namespace {

using V = Vec3<double>;
using Q = Quat<double>;

}  // namespace

TEST_CASE("examples/scenes: the meshes are those that tests/scenes/adf_meshes.hpp makes") {
  CHECK(read_file(example_scenes / "high_res" / "pad.stl") == write_stl(test::pad_mesh()));
  CHECK(read_file(example_scenes / "high_res" / "sole.stl") == write_stl(test::sole_mesh()));
}

TEST_CASE("add_adf: a gripper from a file is, bit by bit, the gripper made by hand") {
  const WorldDef<double> world_def{.gravity = {0, 0, -9.81}, .time_step = 1e-3};
  World<double> loaded(world_def);
  AdfScene<double> scene = add_adf<double>(loaded, example_scenes / "parallel_gripper.yaml");

  World<double> built(world_def);
  const Material<double> plain{.friction = 0.25, .restitution = 0.1 * 0.1};
  const Material<double> hard{.friction = 0.25, .restitution = 0.0};
  const Material<double> smooth{.friction = 0.0, .restitution = 0.0};
  const auto box = [&](double mass, const V& half, const V& at, const Material<double>& material) {
    BodyDef<double> def;
    def.motion = mass > 0 ? Motion::dynamic : Motion::fixed;
    if (mass > 0) {
      def.mass = mass;
      def.center_of_mass = V::Zero();
    }
    def.shapes = {{.shape = Box<double>{half}, .material = material}};
    def.position = at;
    if (mass > 0) {
      def.linear_damping = -std::log1p(-0.04);
      def.angular_damping = -std::log1p(-0.1);
    }
    return built.add_body(def);
  };
  const BodyId base = box(0, {0.05, 0.05, 0.01}, {0, 0, 0.4}, plain);
  const BodyId palm = box(0.5, {0.025, 0.1, 0.015}, {0, 0, 0.13}, plain);
  const BodyId left = box(0.2, {0.02, 0.005, 0.05}, {0, 0.04, 0.065}, smooth);
  const BodyId right = box(0.2, {0.02, 0.005, 0.05}, {0, -0.04, 0.065}, smooth);
  built.add_body(
      {.motion = Motion::fixed, .shapes = {{.shape = HalfSpace<double>{}, .material = plain}}});
  const BodyId part = box(0.1, {0.02, 0.02, 0.02}, {0, 0, 0.02}, hard);

  const auto slide = [&](BodyId a, BodyId b, const V& pivot, const Q& R, double low, double high) {
    return built.add_joint({.kind = JointKind::prismatic,
                            .body_a = a,
                            .body_b = b,
                            .X_AJ = {R, pivot},
                            .X_BJ = {R, V::Zero()},
                            .lower_limit = low,
                            .upper_limit = high});
  };
  const JointId lift = slide(base, palm, {0, 0, -0.27}, Q(1, 0, -1, 0).normalized(), -0.01, 0.2);
  const JointId close_left =
      slide(palm, left, {0, 0.04, -0.065}, Q(1, 0, 0, -1).normalized(), -0.02, 0.03);
  const JointId close_right =
      slide(palm, right, {0, -0.04, -0.065}, Q(1, 0, 0, 1).normalized(), -0.02, 0.03);

  // 20 N s a step of 1 ms are 0.02 N s.
  const SensorParameters<double> skin{.normal_stiffness = 2.0,
                                      .normal_damping = 20.0 * 1e-3,
                                      .static_friction = 1000.0,
                                      .sliding_friction = 0.5,
                                      .breakaway_distance = 1e-3};
  SensorLayout<double> array;
  for (const double z : {-0.04, -0.02}) {
    for (const double x : {-0.012, 0.012}) array.add({x, -0.003, z}, {0, -1, 0}, 0.006);
  }
  const PatchId left_pad = built.add_patch(left, array, skin);
  const Q half_turn(Eigen::AngleAxis<double>(3.14159265358979, V::UnitZ()));
  const PatchId right_pad = built.add_patch(
      right,
      sensors_from_mesh(
          weld(read_stl<double>(write_stl(test::pad_mesh()))),
          {.depth = 0.0, .range = 0.006, .X_AM = {half_turn.normalized(), {0, 0.003, -0.03}}}),
      skin);

  CHECK(loaded.state_hash() == built.state_hash());
  const JointMotor<double> close{
      .mode = MotorMode::position, .target = 0.03, .max_force = 5.0, .max_speed = 0.2};
  const JointMotor<double> raise{
      .mode = MotorMode::position, .target = 0.1, .max_force = 50.0, .max_speed = 0.2};
  loaded.set_motor(scene.joints.at("Left"), close);
  loaded.set_motor(scene.joints.at("Right"), close);
  built.set_motor(close_left, close);
  built.set_motor(close_right, close);
  for (int i = 0; i < 1500; ++i) {
    if (i == 500) {
      loaded.set_motor(scene.joints.at("Lift"), raise);
      built.set_motor(lift, raise);
    }
    loaded.step();
    built.step();
  }
  CHECK(loaded.state_hash() == built.state_hash());

  // And it holds what it gripped. The lift had sunk by 10 mm to its stop before it rose to 0.1 m;
  // the part follows but for the sag of the skin, m g / (mu_S sum F_N).
  const double height = loaded.pose(scene.bodies.at("Part")).translation.z();
  const double sag = 0.1 * 9.81 / (1000.0 * 10.0);
  CHECK(height == built.pose(part).translation.z());
  CHECK(std::abs(height - (0.13 - sag)) < 0.1 * sag);
  CHECK(loaded.reading(scene.patches.at("LeftPad")).total_normal() ==
        test::relative(5.0).epsilon(1e-3));
  CHECK(loaded.reading(scene.patches.at("RightPad")).touching() == 8);
  CHECK(built.reading(left_pad).touching() == 4);
  CHECK(built.reading(right_pad).touching() == 8);

  // The scanner looks down from the palm, 16 mm below its middle: straight at the part.
  AdfProximity<double>& scanner = scene.proximity.at("Scanner");
  loaded.sense(scanner.carrier, scanner.rays);
  REQUIRE(scanner.rays.size() == 9);
  const double palm_z = loaded.pose(scene.bodies.at("Palm")).translation.z();
  CHECK(scanner.rays.distance()[4] == test::relative(palm_z - 0.016 - height - 0.02).epsilon(1e-6));
  CHECK(scanner.rays.body()[4] == scene.bodies.at("Part"));
}

TEST_CASE("add_adf: the box on the incline stays on its sole") {
  World<double> world({.gravity = {0, 0, -9.81}, .time_step = 1e-3});
  const AdfScene<double> scene = add_adf<double>(world, example_scenes / "inclined_box.yaml");
  const BodyId box = scene.bodies.at("Box");
  for (int i = 0; i < 1000; ++i) world.step();
  const V before = world.pose(box).translation;
  for (int i = 0; i < 2000; ++i) world.step();
  CHECK((world.pose(box).translation - before).norm() < 1e-9);
  const auto reading = world.reading(scene.patches.at("Box"));
  CHECK(reading.size() == 32);
  // All rays are parallel, so the two are perpendicular and carry the weight: what is left of it
  // when a step's damping has had its part of the speed that it gives.
  const double loss = -std::log1p(-0.04) * world.time_step();
  CHECK(std::hypot(reading.total_normal(), reading.total_shear()) ==
        test::relative(0.5 * 9.81 * -std::expm1(-loss) / loss).epsilon(1e-6));
  CHECK(reading.total_shear() > 0.5 * 9.81 * std::sin(0.349));
}

TEST_CASE_TEMPLATE("add_adf: every scene runs in every scalar", S, float, double) {
  for (const char* name : {"parallel_gripper.yaml", "chain.yaml", "inclined_box.yaml"}) {
    CAPTURE(name);
    World<S> world({.gravity = {0, 0, S(-9.81)}, .time_step = S(1e-3)});
    const AdfScene<S> scene = add_adf(world, example_scenes / name);
    for (int i = 0; i < 500; ++i) world.step();
    for (const auto& body : scene.bodies) {
      // Slower than what has fallen all the time.
      CHECK(world.body(body.value).twist.linear.norm() < S(0.5 * 9.81));
    }
  }
}
