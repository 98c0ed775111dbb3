// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/adf/adf_reader.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <support/temp_folder.hpp>
#include <variant>

using namespace bristle;

using namespace bristle::detail;

namespace {

AdfModel read(const std::string& text, const AdfLimits& limits = {}) {
  return read_adf(text, "scene.yaml", limits);
}

std::string error_of(const std::string& text, const AdfLimits& limits = {}) {
  try {
    (void)read(text, limits);
  } catch (const IoError& error) {
    return error.what();
  }
  return "no error";
}

/// A file with one body, whose block has these lines.
std::string with_body(const std::string& lines) {
  return "bodies: [BODY A]\nBODY A:\n  mass: 1\n" + lines;
}
AdfBody body_of(const std::string& lines) { return read(with_body(lines)).bodies.at(0); }

const std::string pivots =
    "  parent: BODY A\n  child: BODY B\n"
    "  parent pivot: {x: 1, y: 2, z: 3}\n  child pivot: {x: 4, y: 5, z: 6}\n"
    "  parent axis: {x: 0, y: 0, z: 2}\n  child axis: {x: 0, y: 3, z: 0}\n";
AdfJoint joint_of(const std::string& lines) {
  return read("joints: [J]\nJ:\n" + pivots + lines).joints.at(0);
}
AdfSensor sensor_of(const std::string& lines) {
  return read("sensors: [S]\nS:\n  parent: BODY A\n" + lines).sensors.at(0);
}

/// The note of a key; null where there is none.
const AdfNote* note_of(const AdfReport& report, const std::string& key) {
  for (const AdfNote& note : report.notes()) {
    if (note.key == key) return &note;
  }
  return nullptr;
}

}  // namespace

TEST_CASE("read_adf: defaults are those of the format") {
  const AdfModel model = read("bodies: [BODY A]\nBODY A: {}\n");
  const AdfBody& body = model.bodies.at(0);
  CHECK(body.key == "BODY A");
  CHECK(body.name == "BODYA");
  CHECK(body.line == 2);
  CHECK(body.mass == 1.0);
  CHECK(body.scale == 1.0);
  CHECK(body.friction == 0.5);
  CHECK(body.restitution == 0.1);
  CHECK(body.linear_damping == 0.04);
  CHECK(body.angular_damping == 0.1);
  CHECK(body.location.translation == Vec3<double>::Zero());
  CHECK_FALSE(body.inertia.has_value());
  CHECK_FALSE(body.inertial_offset.has_value());
  CHECK(body.mesh_type == AdfMeshType::concave);
  CHECK_FALSE(model.ignore_inter_collision);
  const AdfNote* mass = note_of(model.report, "body/mass");
  REQUIRE(mass != nullptr);
  CHECK(mass->kind == AdfNoteKind::changed);

  const AdfSensor sensor = sensor_of("  type: Resistance\n  mesh: pad.stl\n");
  CHECK(sensor.range == 0.5);
  CHECK(sensor.contact_area == 0.1);
  CHECK(sensor.friction_damping == 0.1);
  CHECK(sensor.static_friction == 0.0);
  CHECK_FALSE(sensor.variable_friction);

  const AdfJoint joint = joint_of("  type: hinge\n");
  CHECK(joint.max_motor_impulse == 0.1);
  CHECK(joint.ignore_inter_collision);
  CHECK_FALSE(joint.limits.has_value());
  CHECK_FALSE(joint.controller.has_value());
}

TEST_CASE("read_adf: roll, pitch and yaw turn about the axes that stay, in this order") {
  const AdfBody body = body_of(
      "  location: {position: {x: 1, y: 2, z: 3}, orientation: {r: 0.3, p: -0.7, y: 1.9}}\n");
  CHECK(body.location.translation == Vec3<double>(1, 2, 3));
  // R = Rz Ry Rx, written out.
  const double sr = std::sin(0.3), cr = std::cos(0.3), sp = std::sin(-0.7), cp = std::cos(-0.7),
               sy = std::sin(1.9), cy = std::cos(1.9);
  Mat3<double> R;
  R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  CHECK((body.location.rotation_matrix() - R).cwiseAbs().maxCoeff() < 1e-15);
}

TEST_CASE("read_adf: primitives are halved, and capsules lose their caps") {
  const auto shape_of = [](const std::string& kind, const std::string& geometry) {
    return body_of("  collision shape: " + kind + "\n  collision geometry: " + geometry + "\n")
        .shapes.at(0);
  };
  CHECK(std::get<Box<double>>(shape_of("BOX", "{x: 2, y: 4, z: 6}").shape).half_extents ==
        Vec3<double>(1, 2, 3));
  CHECK(std::get<Sphere<double>>(shape_of("Sphere", "{radius: 2}").shape).radius == 2.0);
  CHECK(std::get<Cylinder<double>>(shape_of("cylinder", "{radius: 2, height: 3}").shape)
            .half_length == 1.5);
  CHECK(std::get<Cone<double>>(shape_of("CONE", "{radius: 2, height: 3}").shape).half_length ==
        1.5);
  CHECK(
      std::get<Capsule<double>>(shape_of("CAPSULE", "{radius: 1, height: 5}").shape).half_length ==
      1.5);
  const AdfShape plane = shape_of("PLANE", "{normal: {x: 0, y: 3, z: 4}, offset: 2}");
  CHECK(std::get<HalfSpace<double>>(plane.shape).normal == Vec3<double>(0, 0.6, 0.8));
  CHECK(std::get<HalfSpace<double>>(plane.shape).offset == 2.0);

  for (const auto& [axis, direction] :
       {std::pair{"x", Vec3<double>::UnitX().eval()}, std::pair{"Y", Vec3<double>::UnitY().eval()},
        std::pair{"z", Vec3<double>::UnitZ().eval()}}) {
    const AdfShape turned =
        shape_of("CONE", std::string("{radius: 2, height: 3, axis: ") + axis + "}");
    CHECK((turned.X_BS.rotate(Vec3<double>::UnitZ()) - direction).norm() < 1e-15);
  }
}

TEST_CASE("read_adf: a single shape sits on the centre of mass unless it has a place of its own") {
  const std::string sphere = "  collision shape: SPHERE\n  collision geometry: {radius: 1}\n";
  const std::string offset = "  inertial offset: {position: {x: 0, y: 0, z: 0.5}}\n";
  CHECK(body_of(sphere + offset).shapes.at(0).X_BS.translation == Vec3<double>(0, 0, 0.5));
  CHECK(body_of(sphere + offset + "  collision offset: {position: {x: 1, y: 0, z: 0}}\n")
            .shapes.at(0)
            .X_BS.translation == Vec3<double>(1, 0, 0));
  const AdfBody compound = body_of(
      "  compound collision shape:\n"
      "    - {shape: SPHERE, geometry: {radius: 1}}\n"
      "    - {shape: BOX, geometry: {x: 1, y: 1, z: 1}, offset: {position: {x: 3, y: 0, z: 0}}}\n" +
      offset);
  REQUIRE(compound.shapes.size() == 2);
  CHECK(compound.shapes[0].X_BS.translation == Vec3<double>::Zero());
  CHECK(compound.shapes[1].X_BS.translation == Vec3<double>(3, 0, 0));
}

TEST_CASE("read_adf: of several kinds of collision geometry the first of the order counts") {
  const std::string mesh = "  mesh: seen.obj\n";
  const std::string other = "  collision mesh: felt.obj\n  collision mesh type: CONVEX_HULL\n";
  CHECK(body_of(mesh).collision_mesh == "seen.obj");
  CHECK(body_of(mesh + other).collision_mesh == "felt.obj");
  CHECK(body_of(mesh + other).mesh_type == AdfMeshType::convex_hull);
  const std::string shape = "  collision shape: SPHERE\n  collision geometry: {radius: 1}\n";
  CHECK(body_of(mesh + other + shape).collision_mesh.empty());
  CHECK(body_of(mesh + other + shape).shapes.size() == 1);
}

TEST_CASE("read_adf: joints of every spelling") {
  const std::pair<const char*, AdfJointType> spellings[] = {
      {"hinge", AdfJointType::revolute},
      {"revolute", AdfJointType::revolute},
      {"Continuous", AdfJointType::revolute},
      {"slider", AdfJointType::prismatic},
      {"prismatic", AdfJointType::prismatic},
      {"fixed", AdfJointType::fixed},
      {"spring", AdfJointType::linear_spring},
      {"linear spring", AdfJointType::linear_spring},
      {"torsion spring", AdfJointType::torsion_spring},
      {"torsional spring", AdfJointType::torsion_spring},
      {"angular spring", AdfJointType::torsion_spring},
      {"p2p", AdfJointType::point_to_point},
      {"cone twist", AdfJointType::cone_twist},
      {"six dof", AdfJointType::six_dof},
      {"six dof spring", AdfJointType::six_dof_spring}};
  for (const auto& spelling : spellings) {
    CAPTURE(spelling.first);
    CHECK(joint_of(std::string("  type: ") + spelling.first + "\n").type == spelling.second);
  }
  const AdfJoint joint = joint_of(
      "  type: torsion spring\n  joint limits: {low: -1, high: 3}\n  stiffness: 5\n  damping: 6\n"
      "  controller: {P: 7, I: 0, D: 8}\n  offset: 0.25\n  ignore inter-collision: False\n");
  CHECK(joint.parent_pivot == Vec3<double>(1, 2, 3));
  CHECK(joint.child_pivot == Vec3<double>(4, 5, 6));
  CHECK(joint.parent_axis == Vec3<double>::UnitZ());
  CHECK(joint.child_axis == Vec3<double>::UnitY());
  REQUIRE(joint.limits.has_value());
  CHECK(joint.limits->low == -1.0);
  CHECK(joint.equilibrium == 1.0);  // the middle of the range
  CHECK(joint.stiffness == 5.0);
  CHECK(joint.damping == 6.0);
  REQUIRE(joint.controller.has_value());
  CHECK(joint.controller->P == 7.0);
  CHECK(joint.offset == 0.25);
  // Two names for where the child stands; the other is the frame's.
  const AdfJoint turned = joint_of("  type: hinge\n  child offset: 1\n  joint offset: 2\n");
  CHECK(turned.offset == 1.0);
  CHECK(turned.frame_offset == 2.0);
  CHECK(joint_of("  type: hinge\n  child offset: 1\n  offset: 3\n").offset == 3.0);
  CHECK_FALSE(joint.ignore_inter_collision);
  // Limits count only as a pair.
  CHECK_FALSE(joint_of("  type: hinge\n  joint limits: {}\n").limits.has_value());
  CHECK_FALSE(joint_of("  type: hinge\n  joint limits:\n").limits.has_value());
  CHECK_FALSE(joint_of("  type: hinge\n  joint limits: {low: 1}\n").limits.has_value());
  // Those that no position meets are none, as in Bullet. The spring still rests in their middle.
  const AdfJoint crossed =
      joint_of("  type: hinge\n  stiffness: 1\n  joint limits: {low: 2, high: 1}\n");
  CHECK_FALSE(crossed.limits.has_value());
  CHECK(crossed.equilibrium == 1.5);
  CHECK(joint_of("  type: hinge\n  joint limits: {low: 2, high: 2}\n").limits.has_value());

  const AdfJoint six = joint_of(
      "  type: six dof spring\n"
      "  stiffness: {linear: {x: 1, y: 2, z: 3}, angular: {x: 4, y: 5, z: 6}}\n");
  CHECK(six.six_stiffness == std::array<double, 6>{1, 2, 3, 4, 5, 6});
}

TEST_CASE("read_adf: sensors in all their forms") {
  const AdfSensor array = sensor_of(
      "  type: RESISTANCE\n  range: 0.02\n"
      "  location: {position: {x: 1, y: 0, z: 0}, orientation: {r: 0, p: 0, y: 0}}\n"
      "  array:\n"
      "    - offset: {x: 1, y: 2, z: 3}\n      direction: {x: 0, y: 0, z: -2}\n"
      "    - {offset: {x: 4, y: 5, z: 6}, direction: {x: 3, y: 0, z: 4}}\n"
      "  friction: {static: 10, dynamic: 20, damping: 30, variable: True}\n"
      "  contact area: 0.005\n  contact stiffness: 40\n  contact damping: 50\n");
  CHECK(array.type == AdfSensorType::resistance);
  REQUIRE(array.array.size() == 2);
  CHECK(array.array[0].offset == Vec3<double>(1, 2, 3));
  CHECK(array.array[0].direction == Vec3<double>(0, 0, -1));
  CHECK((array.array[1].direction - Vec3<double>(0.6, 0, 0.8)).norm() < 1e-15);
  CHECK(array.range == 0.02);
  CHECK(array.location.translation == Vec3<double>(1, 0, 0));
  CHECK(array.static_friction == 10.0);
  CHECK(array.dynamic_friction == 20.0);
  CHECK(array.friction_damping == 30.0);
  CHECK(array.variable_friction);
  CHECK(array.contact_area == 0.005);
  CHECK(array.contact_stiffness == 40.0);
  CHECK(array.contact_damping == 50.0);

  CHECK(sensor_of("  type: Proximity\n  mesh: skin.stl\n").mesh == "skin.stl");
  const AdfSensor fan = sensor_of(
      "  type: proximity\n"
      "  parametric: {resolution: 3, horizontal angle: 0.5, vertical angle: 0.25, start offset: "
      "1}\n");
  REQUIRE(fan.fan.has_value());
  CHECK(fan.fan->resolution == 3);
  CHECK(fan.fan->horizontal_angle == 0.5);

  // 2019: one ray, a flat location.
  const AdfSensor ray = sensor_of(
      "  type: Proximity\n  location: {x: 1, y: 2, z: 3}\n  direction: {x: 0, y: 2, z: 0}\n"
      "  range: 0.1\n");
  REQUIRE(ray.array.size() == 1);
  CHECK(ray.array[0].offset == Vec3<double>(1, 2, 3));
  CHECK(ray.array[0].direction == Vec3<double>::UnitY());
  CHECK(ray.location.translation == Vec3<double>::Zero());

  // 2019: the block in a body; its mesh is the body's unless it names one.
  const AdfModel model = read(
      with_body("  mesh: seen.stl\n  resistive surface: {range: 0.02, contact stiffness: 3}\n"));
  REQUIRE(model.sensors.size() == 1);
  CHECK(model.sensors[0].mesh == "seen.stl");
  CHECK(model.sensors[0].parent == "BODY A");
  CHECK(model.sensors[0].is_legacy_surface);
  CHECK(model.sensors[0].contact_area == 0.001);
  CHECK(model.sensors[0].static_friction == 1.0);
  CHECK(model.sensors[0].contact_stiffness == 3.0);
}

TEST_CASE("read_adf: aliases, and keys merged from other maps") {
  const AdfModel model = read(
      "bodies: [BODY A, BODY B]\n"
      "half: &half {mass: 2, friction: &f {static: 0.25}, scale: &s 3}\n"
      "BODY A: {<<: *half, mass: 5}\n"
      "BODY B: {<<: [*half, {mass: 7, restitution: 0.5}], scale: *s}\n");
  CHECK(model.bodies[0].mass == 5.0);  // its own key wins
  CHECK(model.bodies[0].friction == 0.25);
  CHECK(model.bodies[0].scale == 3.0);
  CHECK(model.bodies[1].mass == 2.0);  // the first of several sources wins
  CHECK(model.bodies[1].restitution == 0.5);
  // The target of an alias is no stray key.
  CHECK(model.report.notes().empty());
}

TEST_CASE("read_adf: names") {
  const AdfModel model = read(
      "namespace: /env/\nbodies: [BODY A, BODY B]\n"
      "BODY A: {mass: 1, name: Left Tip}\nBODY B: {mass: 1, namespace: /other/}\n");
  CHECK(model.bodies[0].qualified == "/env/BODY A");
  CHECK(model.bodies[0].name == "LeftTip");
  CHECK(model.bodies[1].qualified == "/other/BODY B");
}

TEST_CASE("read_adf: what is not read is reported, once each") {
  const AdfModel model = read(
      "bodies: [BODY A, BODY B]\nlights: [light]\nactuators: [glue]\nstray: 1\n"
      "light: {type: sun}\n"
      "glue: {type: Constraint, parent: BODY A, max impulse: 3}\n"
      "BODY A: {mass: 1, color: red, collision margin: 0.001, friction: {static: 1, kinetic: 2}}\n"
      "BODY B: {mass: 1, collision margin: 0.001, masss: 2}\n"
      "BODY C: {mass: 1}\n");
  const AdfReport& report = model.report;
  const AdfNote* margin = note_of(report, "body/collision margin");
  REQUIRE(margin != nullptr);
  CHECK(margin->kind == AdfNoteKind::unsupported);
  CHECK(margin->count == 2);
  CHECK(margin->line == 7);
  for (const char* key : {"stray", "BODY C", "body/masss", "body/friction/kinetic"}) {
    CAPTURE(key);
    REQUIRE(note_of(report, key) != nullptr);
    CHECK(note_of(report, key)->kind == AdfNoteKind::unknown);
  }
  for (const char* key : {"light", "glue"}) {
    CAPTURE(key);
    REQUIRE(note_of(report, key) != nullptr);
    CHECK(note_of(report, key)->kind == AdfNoteKind::left_out);
  }
  CHECK(report.notes().size() == 8);
  CHECK(report.text().find("line 7: unsupported: body/collision margin (2 times): ") !=
        std::string::npos);

  // Values that a type of joint does not use are reported, too.
  const AdfModel joints =
      read("joints: [J, K]\nJ:\n" + pivots + "  type: cone twist\n  damping: 1\nK:\n" + pivots +
           "  type: six dof\n  controller output type: FORCE\n");
  for (const char* key : {"joint/damping", "joint/controller output type"}) {
    CAPTURE(key);
    REQUIRE(note_of(joints.report, key) != nullptr);
    CHECK(note_of(joints.report, key)->kind == AdfNoteKind::unsupported);
  }
  REQUIRE(note_of(joints.report, "joint/type") != nullptr);
  CHECK(note_of(joints.report, "joint/type")->kind == AdfNoteKind::changed);
  const AdfModel crossed =
      read("joints: [J]\nJ:\n" + pivots + "  type: hinge\n  joint limits: {low: 2, high: 1}\n");
  REQUIRE(note_of(crossed.report, "joint/joint limits") != nullptr);
  CHECK(note_of(crossed.report, "joint/joint limits")->kind == AdfNoteKind::changed);

  // Of a key that stands twice the first counts.
  const AdfModel twice = read(with_body("  scale: 2\n  scale: 3\n"));
  CHECK(twice.bodies[0].scale == 2.0);
  CHECK(note_of(twice.report, "scale") != nullptr);
}

TEST_CASE("read_adf: an error names file, line, key, value and rule") {
  CHECK(error_of(with_body("  scale: -1\n")) ==
        "scene.yaml:4: BODY A/scale = -1: must be finite and > 0");
  CHECK(error_of(with_body("  friction: {static: x}\n")) ==
        "scene.yaml:4: BODY A/friction/static = x: must be finite and >= 0");
  CHECK(error_of(with_body("  gravity: {x: 1, y: 2}\n")) ==
        "scene.yaml:4: BODY A/gravity/z: must be given");
  CHECK(error_of(with_body("  location: 3\n")) ==
        "scene.yaml:4: BODY A/location = 3: must be a map of keys");
  CHECK(error_of(with_body("  collision groups: [0, 1000]\n")) ==
        "scene.yaml:4: BODY A/collision groups[1] = 1000: must be a whole number from 0 to 999");
  CHECK(error_of(with_body("  collision groups: 0\n")) ==
        "scene.yaml:4: BODY A/collision groups = 0: must be a list");
  CHECK(error_of(with_body("  collision shape: BLOB\n  collision geometry: {}\n")) ==
        "scene.yaml:4: BODY A/collision shape = BLOB: must be BOX, SPHERE, CYLINDER, CAPSULE, CONE "
        "or PLANE");
  CHECK(error_of(with_body("  collision shape: CAPSULE\n"
                           "  collision geometry: {radius: 1, height: 2}\n")) ==
        "scene.yaml:5: BODY A/collision geometry/height = 2: must exceed the diameter, which it "
        "includes");
  CHECK(error_of(with_body("  collision shape: PLANE\n  collision geometry:\n"
                           "    normal: {x: 0, y: 0, z: 0}\n    offset: 0\n")) ==
        "scene.yaml:6: BODY A/collision geometry/normal: must not be zero");
  CHECK(error_of(with_body("  mass: .nan\n")).find("scene.yaml") == std::string::npos);
  CHECK(error_of("bodies: [A]\nA: {mass: .nan}\n") ==
        "scene.yaml:2: A/mass = .nan: must be finite and >= 0");
  CHECK(error_of("bodies: [A]\nA: {mass: 1e999}\n") ==
        "scene.yaml:2: A/mass = 1e999: must be finite and >= 0");
  CHECK(error_of("bodies:\n- A\n- A\nA: {mass: 1}\n") ==
        "scene.yaml:3: bodies = A: must be named once");
  CHECK(error_of("bodies: [A, B]\nA: {mass: 1}\n") ==
        "scene.yaml:1: bodies = B: must be a key of this file");
  CHECK(error_of("ignore inter-collision: maybe\n") ==
        "scene.yaml:1: ignore inter-collision = maybe: must be true or false");
  CHECK(error_of("joints: [J]\nJ:\n" + pivots) == "scene.yaml:3: J/type: must be given");
  CHECK(error_of("joints: [J]\nJ:\n" + pivots + "  type: weld\n")
            .find("J/type = weld: must be one "
                  "of hinge") != std::string::npos);
  CHECK(error_of("joints: [J]\nJ:\n" + pivots +
                 "  type: cone twist\n  joint limits: {x: 0, y: 0, z: 1}\n") ==
        "scene.yaml:10: J/joint limits: must have x >= 0, y and z > 0");
  CHECK(error_of("sensors: [S]\nS: {parent: A, type: Proximity}\n") ==
        "scene.yaml:2: S/array: must be given, or mesh, or parametric: where the rays are");
  CHECK(error_of("sensors: [S]\nS: {parent: A, type: Proximity, range: 0}\n") ==
        "scene.yaml:2: S/range = 0: must be finite and > 0");
  CHECK(error_of("sensors: [S]\nS: {parent: A, type: Sonar}\n") ==
        "scene.yaml:2: S/type = Sonar: must be Proximity or Resistance");
  CHECK(error_of("a: [1, 2\n").find("scene.yaml:2: no YAML: ") == 0);
  CHECK(error_of("a: *b\n").find("scene.yaml:1: no YAML: ") == 0);
  CHECK(error_of("") == "scene.yaml: file is empty");
  CHECK(error_of("[1]: 2\n") == "scene.yaml:1: a key must be a scalar");
  CHECK(error_of("3\n") == "scene.yaml:1: 3: must be a map of keys");

  try {
    (void)read(with_body("  scale: -1\n"));
    FAIL("no error");
  } catch (const AdfError& error) {
    CHECK(error.file() == "scene.yaml");
    CHECK(error.line() == 4);
    CHECK(error.key() == "BODY A/scale");
    CHECK(error.value() == "-1");
    CHECK(error.rule() == "must be finite and > 0");
  }
}

TEST_CASE("read_adf: limits hold against texts that ask for more than they are long") {
  // A billion by ten aliases of ten aliases: a tree without copies, so it is read, and quickly.
  std::string laughs = "a0: &a0 [x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    laughs += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + last;
    for (int k = 1; k < 10; ++k) laughs += ", " + last;
    laughs += "]\n";
  }
  CHECK(read(laughs).bodies.empty());
  // The same by merging, where keys are taken over: counted.
  std::string merged = "m0: &m0 {a: 1, b: 2, c: 3}\n";
  for (int i = 1; i < 300; ++i) {
    const std::string n = std::to_string(i);
    merged += "m" + n + ": &m" + n + " {<<: *m" + std::to_string(i - 1) + ", k" + n + ": 1}\n";
  }
  AdfLimits few;
  few.max_nodes = 10'000;
  CHECK(error_of(merged, few).find("more than 10000 maps, lists and scalars") != std::string::npos);
  CHECK(error_of(merged) == "no error");

  for (const char* open : {"[", "{a: ", "- ", "? ", "[{a: "}) {
    std::string deep;
    for (int i = 0; i < 100'000; ++i) deep += open;
    CAPTURE(open);
    CHECK(error_of(deep).find("scene.yaml:1: ") == 0);
  }
  for (const char open : {'[', '{', '"'}) {
    CAPTURE(open);
    CHECK(error_of(std::string(AdfLimits{}.max_bytes, open)).find("scene.yaml") == 0);
  }
  CHECK(error_of("a: &a [*a]\n") == "scene.yaml:1: alias within what it names");
  CHECK(error_of("a: &a {<<: *a}\n") == "scene.yaml:1: alias within what it names");
  CHECK(error_of("a: &a 1\nb: {<<: *a}\n") == "scene.yaml:1: <<: must name maps");

  // What the library says of a byte has no control characters.
  for (const char c : error_of("a: \"\\\x1b[2J\"\n")) CHECK_FALSE((c >= 0 && c < ' '));

  // Names are short, as each of many blocks may copy them.
  const std::string longest(1024, 'n');
  CHECK(error_of("namespace: " + longest + "\n") == "no error");
  CHECK(error_of("namespace: " + longest + "n\n").find("must not be longer than 1024 bytes") !=
        std::string::npos);
  std::string groups = "0";
  for (int i = 1; i < 1000; ++i) groups += ", 0";
  CHECK(error_of(with_body("  collision groups: [" + groups + "]\n")) == "no error");
  CHECK(error_of(with_body("  collision groups: [" + groups + ", 0]\n")) ==
        "scene.yaml:4: BODY A/collision groups: must have at most 1000 entries");

  AdfLimits small;
  small.max_bytes = 10;
  CHECK(error_of("a: 1234567\n", small) == "scene.yaml: larger than 10 bytes");
  small = {};
  small.max_items = 2;
  CHECK(error_of("bodies: [A, B, C]\nA: {}\nB: {}\nC: {}\n", small) ==
        "scene.yaml:4: C: more than 2 bodies, shapes, joints, sensors and actuators");
  small.max_rays = 8;
  CHECK(error_of("sensors: [S]\nS: {parent: A, type: Proximity, parametric: {resolution: 3, "
                 "horizontal angle: 1, vertical angle: 1, start offset: 0}}\n",
                 small) == "scene.yaml:2: S: more than 8 rays");
}

TEST_CASE("read_adf: what the Blender add-on writes for nothing") {
  const AdfModel model = read(
      "bodies: [BODY A]\ncameras: 'CAMERA '\nlights: []\n"
      "BODY A: {mass: 0.0, inertia: {ix: 0.0, iy: 0.0, iz: 0.0}}\n");
  CHECK(model.bodies.at(0).mass == 0.0);
  REQUIRE(note_of(model.report, "cameras") != nullptr);
  CHECK(note_of(model.report, "cameras")->kind == AdfNoteKind::unsupported);
  CHECK(note_of(model.report, "lights") == nullptr);
  CHECK(error_of("bodies: [A]\nA: {mass: 1, inertia: {ix: 0, iy: 1, iz: 1}}\n") ==
        "scene.yaml:2: A/inertia/ix = 0: must be finite and > 0");
}

TEST_CASE("load_adf: files") {
  const test::TempFolder folder;
  const auto path = folder.path() / "scene.yaml";
  write_file(path, "bodies: [A]\nA: {mass: 3}\n");
  const AdfModel model = load_adf(path);
  CHECK(model.bodies.at(0).mass == 3.0);
  CHECK(model.file == path);
  AdfLimits small;
  small.max_bytes = 10;
  CHECK_THROWS_AS((void)load_adf(path, small), AdfError);
  CHECK_THROWS_AS((void)load_adf(folder.path() / "none.yaml"), IoError);
}
