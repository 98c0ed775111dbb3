/// @file
/// Tests of what a world tells to a renderer.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/io/drawn_world.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/placement.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

using namespace bristle;
using bristle::test::relative;

namespace {

struct DrawnLine {
  Drawn of;
  Vec3<double> begin, end;
};
struct DrawnMesh {
  Drawn of;
  TriangleMesh<double> mesh;
  Transform<double> X_WM;
};

/// Keeps all that it is told.
struct Sketch {
  std::vector<DrawnLine> lines;
  std::vector<DrawnLine> points;
  std::vector<DrawnMesh> meshes;
  std::vector<std::string> texts;

  void line(const Drawn& drawn, const Vec3<double>& a, const Vec3<double>& b) {
    lines.push_back({drawn, a, b});
  }
  void point(const Drawn& drawn, const Vec3<double>& p) { points.push_back({drawn, p, p}); }
  void triangles(const Drawn& drawn, const TriangleMesh<double>& mesh,
                 const Transform<double>& X_WM) {
    meshes.push_back({drawn, mesh, X_WM});
  }
  void text(const Drawn&, const Vec3<double>&, std::string_view words) {
    texts.emplace_back(words);
  }

  [[nodiscard]] std::vector<DrawnLine> lines_of(DrawnKind kind) const {
    std::vector<DrawnLine> found;
    for (const DrawnLine& line : lines) {
      if (line.of.kind == kind) found.push_back(line);
    }
    return found;
  }
  [[nodiscard]] std::size_t points_of(DrawnKind kind) const {
    std::size_t count = 0;
    for (const DrawnLine& point : points) {
      if (point.of.kind == kind) ++count;
    }
    return count;
  }
};

/// A block whose centre of mass is off its middle leans on sensors that push and some that do not,
/// beside a ball on the floor; a hand slides above them.
struct DrawnScene {
  World<double> world;
  BodyId floor, block, ball, hand;
  PatchId pad, idle;
  JointId slide;

  DrawnScene() {
    world.set_time_step(1e-3);
    floor = world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    BodyDef<double> def;
    def.mass = 0.5;
    def.center_of_mass = Vec3<double>(0.002, 0.001, 0);
    def.shape = Box<double>{{0.03, 0.03, 0.01}};
    def.position = {0, 0, 0.0125};
    def.orientation = exp_rotation<double>({0, 0, 0.4});
    block = world.add_body(def);
    PatchDef<double> patch;
    patch.sensors = sensor_grid<double>({.center = {0, 0, -0.01},
                                         .side_u = {0.05, 0, 0},
                                         .side_v = {0, -0.05, 0},
                                         .count_u = 5,
                                         .count_v = 5,
                                         .depth = 0.004,
                                         .range = 0.008});
    // One more, which looks away from the floor.
    patch.sensors.add({0, 0, 0.008}, {0, 0, 0.016});
    patch.parameters = {.normal_stiffness = 0.8, .normal_damping = 0.02, .static_friction = 1000};
    pad = world.add_patch(block, patch);
    ball = world.add_body(
        {.mass = 0.2, .shape = Sphere<double>{.radius = 0.02}, .position = {0.1, 0, 0.02}});
    hand = world.add_body(
        {.mass = 0.1, .shape = Sphere<double>{.radius = 0.01}, .position = {0, 0, 0.2}});
    patch.sensors = {};
    patch.sensors.add({0, 0, 0}, {0, 0, -0.02});
    idle = world.add_patch(hand, patch);
    JointDef<double> joint;
    joint.kind = JointKind::prismatic;
    joint.body_a = floor;
    joint.body_b = hand;
    joint.X_AJ = {exp_rotation<double>({0, -1.5707963267948966, 0}), {0, 0, 0.2}};
    joint.X_BJ.rotation = joint.X_AJ.rotation;
    joint.motor = {MotorMode::position, 0, 10};
    slide = world.add_joint(joint);
    for (int i = 0; i < 3000; ++i) {
      world.apply_force(block, {1, 0.5, 0}, world.pose(block).translation);
      world.step();
    }
  }
  [[nodiscard]] Sketch sketch(const DrawDef<double>& def = {}) const {
    Sketch drawn;
    for_each_drawn(world, drawn, def);
    return drawn;
  }
};

}  // namespace

TEST_CASE("for_each_drawn: lengths of lines over metres a newton are forces") {
  const DrawnScene scene;
  const double scale = 0.003;
  const Sketch sketch = scene.sketch({.metres_per_newton = scale});
  const PatchReading<double> reading = scene.world.reading(scene.pad);
  Vec3<double> sum = Vec3<double>::Zero();
  std::set<std::size_t> drawn;
  for (const DrawnLine& line : sketch.lines_of(DrawnKind::touch_force)) {
    REQUIRE(line.of.patch == scene.pad);
    const std::size_t i = line.of.sensor;
    CHECK(drawn.insert(i).second);
    const Vec3<double> force = (line.end - line.begin) / scale;
    const double across =
        reading.shear_1[i] * reading.shear_1[i] + reading.shear_2[i] * reading.shear_2[i];
    CHECK(force.squaredNorm() ==
          relative(reading.normal_force[i] * reading.normal_force[i] + across).epsilon(1e-9));
    CHECK(line.begin == Vec3<double>(reading.point_x[i], reading.point_y[i], reading.point_z[i]));
    sum += force;
  }
  // All that push are drawn, and some do not.
  for (std::size_t i = 0; i < reading.size(); ++i) {
    CHECK((drawn.count(i) == 1) == (reading.normal_force[i] > 0));
  }
  CHECK(drawn.size() < reading.size());
  CHECK(drawn.size() > 10);
  CHECK(sketch.points_of(DrawnKind::touch) == reading.touching());
  // Rays are drawn where the step ended, and pushed as it began: the block still creeps.
  CHECK((sum + reading.wrench.force).norm() < 1e-5 * reading.wrench.force.norm());
  CHECK(sum.z() == relative(-0.5 * 9.81).epsilon(1e-3));

  Vec3<double> contacts = Vec3<double>::Zero();
  for (const DrawnLine& line : sketch.lines_of(DrawnKind::contact_force)) {
    CHECK(line.of.body == scene.ball);
    contacts += (line.end - line.begin) / scale;
  }
  CHECK(contacts.z() == relative(0.2 * 9.81).epsilon(1e-3));
  CHECK(sketch.points_of(DrawnKind::contact) == sketch.lines_of(DrawnKind::contact_force).size());
}

TEST_CASE("for_each_drawn: every sensor is a line along its ray, in the kind of its state") {
  DrawnScene scene;
  // Slips in the last step.
  scene.world.apply_force(scene.block, {400, 0, 0}, scene.world.pose(scene.block).translation);
  scene.world.step();
  const PatchReading<double> reading = scene.world.reading(scene.pad);
  REQUIRE(reading.slipping() > 0);
  REQUIRE(reading.touching() < reading.size());
  const Sketch sketch = scene.sketch();
  std::size_t rays = 0;
  for (const DrawnLine& line : sketch.lines) {
    const bool is_ray = line.of.kind == DrawnKind::free_sensor ||
                        line.of.kind == DrawnKind::stuck_sensor ||
                        line.of.kind == DrawnKind::slipping_sensor;
    if (!is_ray || line.of.patch != scene.pad) continue;
    ++rays;
    const SensorState state = reading.state[line.of.sensor];
    CHECK(line.of.kind == (state == SensorState::free    ? DrawnKind::free_sensor
                           : state == SensorState::stuck ? DrawnKind::stuck_sensor
                                                         : DrawnKind::slipping_sensor));
    CHECK(line.of.body == scene.block);
    const Vec3<double> begin = scene.world.pose(scene.block).inverse() * line.begin;
    const Vec3<double> end = scene.world.pose(scene.block).inverse() * line.end;
    const double sign = line.of.sensor == 25 ? 1 : -1;
    CHECK((end - begin - Vec3<double>(0, 0, sign * 0.008)).norm() < 1e-12);
    CHECK(begin.z() == relative(line.of.sensor == 25 ? 0.008 : -0.006).epsilon(1e-9));
  }
  CHECK(rays == 26);
}

TEST_CASE("for_each_drawn: shapes, joints and names are where they are in the world") {
  const DrawnScene scene;
  const Sketch sketch = scene.sketch({.plane_size = 0.5, .joint_length = 0.06});
  REQUIRE(sketch.meshes.size() == 4);
  CHECK(sketch.meshes[0].of.kind == DrawnKind::fixed_shape);
  CHECK(sketch.meshes[1].of.kind == DrawnKind::moving_shape);
  CHECK(sketch.meshes[1].of.body == scene.block);
  CHECK(sketch.meshes[1].mesh.triangles.size() == 12);
  const Transform<double> X_WB = scene.world.pose(scene.block);
  for (const Vec3<double>& v : sketch.meshes[1].mesh.vertices) {
    CHECK(v.cwiseAbs() == Vec3<double>(0.03, 0.03, 0.01));
    CHECK((sketch.meshes[1].X_WM * v - X_WB * v).norm() < 1e-12);
  }
  const std::vector<DrawnLine> joints = sketch.lines_of(DrawnKind::joint);
  REQUIRE(joints.size() == 1);
  CHECK(joints[0].of.body == scene.hand);
  CHECK((joints[0].end - joints[0].begin - Vec3<double>(0, 0, 0.06)).norm() < 1e-9);
  const Vec3<double> middle = (joints[0].begin + joints[0].end) / 2;
  CHECK((middle - scene.world.pose(scene.hand).translation).norm() < 1e-9);
  REQUIRE(sketch.texts.size() == 6);
  CHECK(sketch.texts[1] == "body 1");
  CHECK(sketch.texts[5] == "patch 1: 0 N, 0 slip");
}

TEST_CASE("for_each_drawn: a trigger is not drawn, since it would hide what is in it") {
  DrawnScene scene;
  const std::size_t meshes = scene.sketch().meshes.size();
  ShapeDef<double> gate;
  gate.shape = Box<double>{{1, 1, 1}};
  scene.world.add_shape(scene.block, gate);
  CHECK(scene.sketch().meshes.size() == meshes + 1);
  gate.is_trigger = true;
  scene.world.add_shape(scene.block, gate);
  CHECK(scene.sketch().meshes.size() == meshes + 1);
}

TEST_CASE("for_each_drawn: draws what it is asked for, and refuses lengths that are none") {
  DrawnScene scene;
  const Sketch nothing = scene.sketch({.has_shapes = false,
                                       .has_sensors = false,
                                       .has_forces = false,
                                       .has_contacts = false,
                                       .has_joints = false,
                                       .has_names = false});
  CHECK(nothing.lines.empty());
  CHECK(nothing.points.empty());
  CHECK(nothing.meshes.empty());
  CHECK(nothing.texts.empty());
  scene.world.set_active(scene.idle, false);
  const Sketch active = scene.sketch({.has_shapes = false, .has_joints = false});
  // Without the idle sensor there is the one that looks away.
  CHECK(active.lines_of(DrawnKind::free_sensor).size() == 1);
  for (const DrawnLine& line : active.lines) CHECK_FALSE(line.of.patch == scene.idle);
  CHECK(active.texts.size() == 5);
  Sketch sketch;
  CHECK_THROWS_WITH_AS(for_each_drawn(scene.world, sketch, {.metres_per_newton = 0}),
                       doctest::Contains("DrawDef::metres_per_newton"), InvalidArgument);
  CHECK_THROWS_WITH_AS(for_each_drawn(scene.world, sketch, {.plane_size = -1}),
                       doctest::Contains("DrawDef::plane_size"), InvalidArgument);
  CHECK_THROWS_WITH_AS(for_each_drawn(scene.world, sketch, {.joint_length = 0}),
                       doctest::Contains("DrawDef::joint_length"), InvalidArgument);
  CHECK(sketch.lines.empty());
}
