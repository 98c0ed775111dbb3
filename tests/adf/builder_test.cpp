// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/io/adf.hpp>
#include <bristle/io/stl.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <scenes/adf_meshes.hpp>
#include <string>
#include <support/temp_folder.hpp>

using namespace bristle;

namespace {

const std::filesystem::path scenes = BRISTLE_SCENES_DIR;

using V = Vec3<double>;
using Q = Quat<double>;

AdfScene<double> add(World<double>& world, const std::string& text,
                     const AdfBuildDef<double>& def = {}) {
  return add_adf(world, read_adf(text, "scene.yaml"), def);
}

std::string error_of(const std::string& text, const AdfBuildDef<double>& def = {}) {
  World<double> world({.gravity = {0, 0, -9.81}});
  world.add_body({.mass = 1.0, .shape = Sphere<double>{1.0}});
  const std::uint64_t before = world.state_hash();
  std::string message = "no error";
  try {
    (void)add(world, text, def);
  } catch (const IoError& error) {
    message = error.what();
    CHECK(world.state_hash() == before);
    CHECK(world.body_count() == 1);
  }
  return message;
}

bool has_note(const AdfReport& report, const std::string& key, const std::string& reason) {
  for (const AdfNote& note : report.notes()) {
    if (note.key == key && note.reason.find(reason) != std::string::npos) return true;
  }
  return false;
}

/// A ball of 1 kg under a key.
std::string ball(const std::string& key, const std::string& more = "") {
  return key + ": {mass: 1, collision shape: SPHERE, collision geometry: {radius: 1}" + more +
         "}\n";
}

}  // namespace

TEST_CASE("examples/scenes: the meshes are those that tests/scenes/adf_meshes.hpp makes") {
  CHECK(read_file(scenes / "high_res" / "pad.stl") == write_stl(test::pad_mesh()));
  CHECK(read_file(scenes / "high_res" / "sole.stl") == write_stl(test::sole_mesh()));
}

TEST_CASE("add_adf: a gripper from a file is, bit by bit, the gripper made by hand") {
  const WorldDef<double> world_def{.gravity = {0, 0, -9.81}, .time_step = 1e-3};
  World<double> loaded(world_def);
  AdfScene<double> scene = add_adf<double>(loaded, scenes / "parallel_gripper.yaml");

  World<double> built(world_def);
  const Material<double> plain{.friction = 0.25, .restitution = 0.1 * 0.1};
  const Material<double> hard{.friction = 0.25, .restitution = 0.0};
  const Material<double> smooth{.friction = 0.0, .restitution = 0.0};
  const CollisionFilter filter{.category = 1, .mask = 1};
  const auto box = [&](double mass, const V& half, const V& at, const Material<double>& material) {
    BodyDef<double> def;
    def.motion = mass > 0 ? Motion::dynamic : Motion::fixed;
    if (mass > 0) {
      def.mass = mass;
      def.center_of_mass = V::Zero();
    }
    def.shapes = {{.shape = Box<double>{half}, .material = material}};
    def.filter = filter;
    def.position = at;
    return built.add_body(def);
  };
  const BodyId base = box(0, {0.05, 0.05, 0.01}, {0, 0, 0.4}, plain);
  const BodyId palm = box(0.5, {0.025, 0.1, 0.015}, {0, 0, 0.13}, plain);
  const BodyId left = box(0.2, {0.02, 0.005, 0.05}, {0, 0.04, 0.065}, smooth);
  const BodyId right = box(0.2, {0.02, 0.005, 0.05}, {0, -0.04, 0.065}, smooth);
  built.add_body({.motion = Motion::fixed,
                  .shapes = {{.shape = HalfSpace<double>{}, .material = plain}},
                  .filter = filter});
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
  const JointDrive<double> close{
      .mode = DriveMode::position, .target = 0.03, .max_force = 5.0, .max_speed = 0.2};
  const JointDrive<double> raise{
      .mode = DriveMode::position, .target = 0.1, .max_force = 50.0, .max_speed = 0.2};
  loaded.set_drive(scene.joints.at("Left"), close);
  loaded.set_drive(scene.joints.at("Right"), close);
  built.set_drive(close_left, close);
  built.set_drive(close_right, close);
  for (int i = 0; i < 1500; ++i) {
    if (i == 500) {
      loaded.set_drive(scene.joints.at("Lift"), raise);
      built.set_drive(lift, raise);
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
        doctest::Approx(5.0).epsilon(1e-3));
  CHECK(loaded.reading(scene.patches.at("RightPad")).touching() == 8);
  CHECK(built.reading(left_pad).touching() == 4);
  CHECK(built.reading(right_pad).touching() == 8);

  // The scanner looks down from the palm, 16 mm below its middle: straight at the part.
  AdfProximity<double>& scanner = scene.proximity.at("Scanner");
  loaded.sense(scanner.carrier, scanner.rays);
  REQUIRE(scanner.rays.size() == 9);
  const double palm_z = loaded.pose(scene.bodies.at("Palm")).translation.z();
  CHECK(scanner.rays.distance()[4] ==
        doctest::Approx(palm_z - 0.016 - height - 0.02).epsilon(1e-6));
  CHECK(scanner.rays.body()[4] == scene.bodies.at("Part"));
}

TEST_CASE("add_adf: the box on the incline stays on its sole") {
  World<double> world({.gravity = {0, 0, -9.81}, .time_step = 1e-3});
  const AdfScene<double> scene = add_adf<double>(world, scenes / "inclined_box.yaml");
  const BodyId box = scene.bodies.at("Box");
  for (int i = 0; i < 1000; ++i) world.step();
  const V before = world.pose(box).translation;
  for (int i = 0; i < 2000; ++i) world.step();
  CHECK((world.pose(box).translation - before).norm() < 1e-9);
  const auto felt = world.reading(scene.patches.at("Box"));
  CHECK(felt.size() == 32);
  // All rays are parallel, so the two are perpendicular and carry the weight.
  CHECK(std::hypot(felt.total_normal(), felt.total_shear()) ==
        doctest::Approx(0.5 * 9.81).epsilon(1e-6));
  CHECK(felt.total_shear() > 0.5 * 9.81 * std::sin(0.349));
}

TEST_CASE_TEMPLATE("add_adf: every scene runs in every scalar", S, float, double) {
  for (const char* name : {"parallel_gripper.yaml", "chain.yaml", "inclined_box.yaml"}) {
    CAPTURE(name);
    World<S> world({.gravity = {0, 0, S(-9.81)}, .time_step = S(1e-3)});
    const AdfScene<S> scene = add_adf(world, scenes / name);
    for (int i = 0; i < 500; ++i) world.step();
    for (const auto& body : scene.bodies) {
      // Slower than what has fallen all the time.
      CHECK(world.body(body.value).twist.linear.norm() < S(0.5 * 9.81));
    }
  }
}

TEST_CASE("add_adf: a sensor of today's form supersedes the one in its body") {
  World<double> world;
  const auto path = scenes / "scene.yaml";
  const std::string body =
      "high resolution path: high_res\nbodies: [A]\nA: {mass: 1, collision shape: SPHERE, "
      "collision "
      "geometry: {radius: 1}, resistive surface: {mesh: pad.stl, range: 0.02}}\n";
  const std::string sensor = "sensors: [S]\nS: {type: Resistance, parent: A, mesh: sole.stl}\n";
  const AdfScene<double> old = add_adf(world, read_adf(body, path));
  CHECK(old.patches.size() == 1);
  CHECK(world.reading(old.patches.at("A/resistive surface")).size() == 8);
  const AdfScene<double> both = add_adf(world, read_adf(body + sensor, path));
  CHECK(both.patches.size() == 1);
  CHECK(world.reading(both.patches.at("S")).size() == 32);
  CHECK(has_note(both.report, "A/resistive surface", "a sensor of today's form"));
}

TEST_CASE("add_adf: joints stand at zero where axes and offsets say") {
  // Parent axis p, child axis c and offset t: the child's attitude at zero is that of c turned the
  // shortest way onto p, then turned by t about p.
  struct Case {
    const char* parent;
    const char* child;
    double offset;
    Q R_AB;
  };
  const double quarter = std::numbers::pi / 2;
  const Q x90(Eigen::AngleAxis<double>(quarter, V::UnitX()));
  const Q z180(0, 0, 0, 1);
  const Q y180(0, 0, 1, 0);
  const Q x180(0, 1, 0, 0);
  for (const Case& c :
       {Case{"{x: 0, y: 0, z: 1}", "{x: 0, y: 0, z: 1}", 0, Q::Identity()},
        Case{"{x: 0, y: -1, z: 0}", "{x: 0, y: 0, z: 1}", 0, x90},
        // Opposite axes: half a turn about child x X, or about child x Y where X is along it.
        Case{"{x: 0, y: -1, z: 0}", "{x: 0, y: 1, z: 0}", 0, z180},
        Case{"{x: 0, y: 0, z: -1}", "{x: 0, y: 0, z: 1}", 0, y180},
        Case{"{x: -1, y: 0, z: 0}", "{x: 1, y: 0, z: 0}", 0, z180},
        Case{"{x: 0, y: -1, z: 0}", "{x: 0, y: 1, z: 0}", std::numbers::pi, x180},
        Case{"{x: 2, y: 0, z: 0}", "{x: 3, y: 0, z: 0}", quarter, x90}}) {
    CAPTURE(c.parent);
    CAPTURE(c.child);
    AdfJoint joint =
        read_adf(std::string("joints: [J]\nJ: {type: hinge, parent: A, child: B, parent pivot: {x: "
                             "1, y: 2, z: 3}, child pivot: {x: 0, y: 1, z: 0}, parent axis: ") +
                     c.parent + ", child axis: " + c.child +
                     ", offset: " + detail::to_text(c.offset) + "}\n",
                 "scene.yaml")
            .joints.at(0);
    joint.offset = c.offset;
    const auto frames = detail::joint_frames<double>(joint, 2.0, 3.0);
    // At zero the two frames coincide.
    const Q R = frames.X_AJ.rotation * frames.X_BJ.rotation.conjugate();
    CHECK(R.angularDistance(c.R_AB) < 1e-15);
    // The free axis is the x axis of both.
    CHECK((frames.X_AJ.rotate(V::UnitX()) - joint.parent_axis).norm() < 1e-15);
    CHECK((frames.X_BJ.rotate(V::UnitX()) - joint.child_axis).norm() < 1e-15);
    CHECK(frames.X_AJ.translation == V(2, 4, 6));
    CHECK(frames.X_BJ.translation == V(0, 3, 0));
  }
}

TEST_CASE("axis_turn: brings any direction onto any other") {
  for (int i = 0; i < 100; ++i) {
    const double t = std::numbers::pi * i / 99.0;
    const V from = V(0.3, -0.5, 0.8).normalized();
    const V side = from.cross(V(0.1, 0.9, 0.2)).normalized();
    const V to = std::cos(t) * from + std::sin(t) * side;
    const Q q = detail::axis_turn(from, to.normalized());
    CHECK((q * from - to).norm() < 1e-14);
    // By the shortest way, but for the last degree before the opposite.
    if (t < 3.12) CHECK(q.angularDistance(Q::Identity()) == doctest::Approx(t).epsilon(1e-9));
  }
}

TEST_CASE("add_adf: joints of each kind") {
  World<double> world({.gravity = {0, 0, 0}});
  const std::string common =
      "parent: P, child: C, parent pivot: {x: 0, y: 0, z: 0}, child pivot: {x: 0, y: 0, z: 0}, "
      "parent axis: {x: 0, y: 0, z: 1}, child axis: {x: 0, y: 0, z: 1}";
  const auto joint_of = [&](const std::string& type, const std::string& more,
                            const AdfBuildDef<double>& def = {}) {
    const AdfModel model =
        read_adf("bodies: [P, C]\n" + ball("P") + ball("C") + "joints: [J]\nJ: {type: " + type +
                     ", " + common + more + "}\n",
                 "scene.yaml");
    AdfReport report;
    detail::AdfJointBuilder<double> builder(def, report);
    // The child stands 0.25 m along and 0.5 rad about the axis from zero.
    const Transform<double> X_WB{Q(Eigen::AngleAxis<double>(0.5, V::UnitZ())), {0, 0, 0.25}};
    return builder.joint(model.joints.at(0), model.bodies[0], model.bodies[1], {}, X_WB);
  };
  CHECK(joint_of("fixed", "").kind == JointKind::fixed);
  CHECK(joint_of("p2p", "").kind == JointKind::ball);
  CHECK(joint_of("six dof", "").kind == JointKind::six_dof);
  CHECK_FALSE(joint_of("fixed", "").bodies_collide);
  CHECK(joint_of("fixed", ", ignore inter-collision: false").bodies_collide);

  const JointDef<double> hinge =
      joint_of("hinge", ", joint limits: {low: -4, high: 5}, stiffness: 2, damping: 3");
  CHECK(hinge.kind == JointKind::revolute);
  CHECK(hinge.lower_limit == -4.0);
  CHECK(hinge.upper_limit == 5.0);
  CHECK(hinge.spring.stiffness == 2.0);
  CHECK(hinge.spring.damping == 3.0);
  CHECK(hinge.spring.rest == 0.5);
  CHECK(hinge.drive.mode == DriveMode::none);
  CHECK(joint_of("linear spring", ", stiffness: 2").kind == JointKind::prismatic);
  CHECK(joint_of("torsion spring", ", stiffness: 2").kind == JointKind::revolute);

  const JointDef<double> cone = joint_of("cone twist", ", joint limits: {x: 0.1, y: 0.3, z: 0.2}");
  CHECK(cone.kind == JointKind::cone_twist);
  CHECK(cone.lower_limit == -0.1);
  CHECK(cone.upper_limit == 0.1);
  CHECK(cone.swing_limit == 0.2);

  const JointDef<double> bushing = joint_of(
      "six dof spring", ", stiffness: {linear: {x: 1, y: 2, z: 3}, angular: {x: 4, y: 5, z: 6}}");
  CHECK(bushing.kind == JointKind::six_dof);
  CHECK(bushing.bushing.stiffness[2] == 3.0);
  CHECK(bushing.bushing.stiffness[3] == 4.0);

  // Held where they stand, beside a spring of their own.
  const AdfBuildDef<double> held{.hold_joints = true};
  const JointDef<double> slide = joint_of("slider", ", controller: {P: 100, D: 7}", held);
  CHECK(slide.spring.stiffness == 100.0);
  CHECK(slide.spring.damping == 7.0);
  CHECK(slide.spring.rest == doctest::Approx(0.25));
  const JointDef<double> both = joint_of(
      "hinge", ", controller: {P: 30, D: 7}, stiffness: 10, equilibrium point: 0.1, damping: 1",
      held);
  CHECK(both.spring.stiffness == 40.0);
  CHECK(both.spring.damping == 8.0);
  CHECK(both.spring.rest == doctest::Approx(0.4));  // (10 x 0.1 + 30 x 0.5) / 40
  // Of the turns an angle can mean, the one at the limits.
  CHECK(joint_of("hinge", ", controller: {P: 1}, joint limits: {low: 6, high: 7}", held)
            .spring.rest == doctest::Approx(0.5 + 2 * std::numbers::pi));
  const JointDef<double> motor = joint_of("hinge", ", max motor impulse: 0.02", held);
  CHECK(motor.drive.mode == DriveMode::velocity);
  CHECK(motor.drive.target == 0.0);
  CHECK(motor.drive.max_force == doctest::Approx(20.0));
}

TEST_CASE("add_adf: groups and exclusions become filters") {
  World<double> world;
  const AdfScene<double> scene =
      add(world, "bodies: [A, B, C, D]\n" + ball("A") + ball("B", ", collision groups: [1]") +
                     ball("C", ", collision groups: [0, 1]") +
                     ball("D", ", collision groups: [31, 700]"));
  const auto meet = [&](const char* a, const char* b) {
    return may_meet(world.body(scene.bodies.at(a)).filter, world.body(scene.bodies.at(b)).filter);
  };
  CHECK_FALSE(meet("A", "B"));
  CHECK(meet("A", "C"));
  CHECK(meet("B", "C"));
  CHECK_FALSE(meet("A", "D"));
  CHECK_FALSE(meet("C", "D"));
  // A body from elsewhere is of group 0.
  CHECK(may_meet(CollisionFilter{}, world.body(scene.bodies.at("A")).filter));
  CHECK_FALSE(may_meet(CollisionFilter{}, world.body(scene.bodies.at("B")).filter));
  // Groups above 31 take bits from the last down.
  CHECK(world.body(scene.bodies.at("D")).filter.category == 0xc0000000u);

  // Two models none of whose own bodies touch each other, but those of the other.
  const std::string shy = "ignore inter-collision: true\nbodies: [X, Y]\n" + ball("X") + ball("Y");
  const AdfScene<double> one = add(world, shy);
  const AdfScene<double> two = add(world, shy);
  const auto filter = [&](const AdfScene<double>& s, const char* name) {
    return world.body(s.bodies.at(name)).filter;
  };
  CHECK_FALSE(may_meet(filter(one, "X"), filter(one, "Y")));
  CHECK_FALSE(may_meet(filter(two, "X"), filter(two, "Y")));
  CHECK(may_meet(filter(one, "X"), filter(two, "X")));

  std::string many = "collision groups: [0";
  for (int g = 1; g < 33; ++g) many += ", " + std::to_string(g);
  CHECK(error_of("bodies: [A]\n" + ball("A", ", " + many + "]")) ==
        "scene.yaml:2: A/collision groups = 32: must not be the 33rd different one of the model");
}

TEST_CASE("add_adf: mass, inertia, scale and gravity") {
  World<double> world({.gravity = {0, 0, -10}});
  const AdfBuildDef<double> def{.X_WM = {Q(Eigen::AngleAxis<double>(0.5, V::UnitX())), {1, 2, 3}}};
  const AdfScene<double> scene = add(
      world,
      "gravity: {x: 0, y: 0, z: -5}\nbodies: [A, B, C]\n"
      "A: {mass: 2, inertia: {ix: 1, iy: 2, iz: 2.5}, scale: 2, gravity: {x: 0, y: 0, z: 20}, "
      "location: {position: {x: 1, y: 0, z: 0}, orientation: {r: 0, p: 0, y: 0}}, "
      "inertial offset: {position: {x: 0.1, y: 0, z: 0}, orientation: {r: 1.5707963267948966, p: "
      "0, y: 0}}, collision shape: BOX, collision geometry: {x: 1, y: 2, z: 3}}\n"
      "B: {mass: 0, collision shape: SPHERE, collision geometry: {radius: 1}, collision groups: "
      "[2]}\n" +
          ball("C", ", collision groups: [3], collision offset: {position: {x: 0, y: 0, z: 1}}"),
      def);
  const Body<double>& a = world.body(scene.bodies.at("A"));
  CHECK(a.mass == 2.0);
  CHECK((a.center_B - V(0.2, 0, 0)).norm() < 1e-15);
  // Principal axes turned by a quarter about x: y and z change places.
  CHECK((a.inertia_B - V(1, 2.5, 2).asDiagonal().toDenseMatrix()).norm() < 1e-14);
  CHECK(a.gravity_scale == -2.0);
  CHECK((world.pose(scene.bodies.at("A")).translation - V(2, 2, 3)).norm() < 1e-15);
  CHECK(world.pose(scene.bodies.at("A")).rotation.angularDistance(def.X_WM.rotation) < 1e-15);
  CHECK(world.body(scene.bodies.at("B")).motion == Motion::fixed);
  CHECK(world.body(scene.bodies.at("C")).gravity_scale == 0.5);
  // A ball 1 m from the body's origin, about which it is to turn: 2/5 m r^2 + m d^2.
  CHECK(world.body(scene.bodies.at("C")).center_B == V::Zero());
  CHECK(world.body(scene.bodies.at("C")).inertia_B(0, 0) == doctest::Approx(1.4));
  CHECK(world.body(scene.bodies.at("C")).inertia_B(2, 2) == doctest::Approx(0.4));
  // The box lies along the principal axes and was scaled: a ray along y meets it at 3 / 2 x 2 m.
  const auto hit = world.cast_ray({.origin = world.pose(scene.bodies.at("A")) * V(0.2, 10, 0),
                                   .direction = def.X_WM.rotate(V(0, -1, 0)),
                                   .length = 20});
  CHECK(hit.body == scene.bodies.at("A"));
  CHECK(hit.distance == doctest::Approx(7.0));
}

TEST_CASE("add_adf: meshes are found by their folders, and closed ones stay as they are") {
  const test::TempFolder folder;
  std::filesystem::create_directories(folder.path() / "low");
  std::filesystem::create_directories(folder.path() / "high");
  save_stl(folder.path() / "low" / "a.stl", box_mesh<double>({1, 1, 1}));
  save_stl(folder.path() / "high" / "a.stl", box_mesh<double>({2, 2, 2}));
  save_stl(folder.path() / "b.stl", box_mesh<double>({3, 3, 3}));
  TriangleMesh<double> open = box_mesh<double>({1, 1, 1});
  open.triangles.pop_back();
  save_stl(folder.path() / "low" / "open.stl", open);
  TriangleMesh<double> inside_out = box_mesh<double>({1, 1, 1});
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  save_stl(folder.path() / "low" / "inside_out.stl", inside_out);
  write_file(folder.path() / "low" / "broken.stl", "solid\nfacet normal");

  const auto model_of = [&](const std::string& text) {
    return read_adf("high resolution path: ./high/\nlow resolution path: low\n" + text,
                    folder.path() / "scene.yaml");
  };
  const auto mass_moment = [&](const std::string& body, const std::string& kind) {
    World<double> world;
    const AdfScene<double> scene = add_adf<double>(world, model_of("bodies: [A]\nA: " + body));
    CHECK(has_note(scene.report, "A/collision mesh", "convex hull") == (kind == "open"));
    return world.body(scene.bodies.at("A")).inertia_B(0, 0);
  };
  // m (b^2 + c^2) / 12 of a cube with the side 2 h: 2/3 m h^2.
  CHECK(mass_moment("{mass: 3, mesh: a.stl}\n", "") == doctest::Approx(2.0));
  CHECK(mass_moment("{mass: 3, mesh: b.stl}\n", "") == doctest::Approx(18.0));
  CHECK(mass_moment("{mass: 3, mesh: a.stl, low resolution path: high}\n", "") ==
        doctest::Approx(8.0));
  CHECK(mass_moment("{mass: 3, mesh: a.stl, scale: 2}\n", "") == doctest::Approx(8.0));
  CHECK(mass_moment("{mass: 3, mesh: open.stl}\n", "open") == doctest::Approx(2.0));
  CHECK(mass_moment("{mass: 3, mesh: inside_out.stl}\n", "") == doctest::Approx(2.0));
  CHECK(mass_moment("{mass: 3, mesh: open.stl, collision mesh type: CONVEX_HULL}\n", "") ==
        doctest::Approx(2.0));

  const auto rays_of = [&](const std::string& mesh) {
    World<double> world;
    AdfScene<double> scene =
        add_adf<double>(world, model_of("bodies: [A]\n" + ball("A") +
                                        "sensors: [S]\nS: {type: Proximity, parent: "
                                        "A, range: 1, mesh: " +
                                        mesh + "}\n"));
    return scene.proximity.at("S").rays.rays();
  };
  const SensorLayout<double> rays = rays_of("a.stl");
  CHECK(rays.size() == 12);
  CHECK(rays.start[0].cwiseAbs().maxCoeff() == 2.0);  // on the fine mesh, from the faces outwards
  CHECK(rays.direction[0].dot(rays.start[0]) > 0.0);

  World<double> world;
  CHECK_THROWS_WITH_AS(add_adf<double>(world, model_of("bodies: [A]\nA: {mesh: none.stl}\n")),
                       doctest::Contains("A/mesh = none.stl: must be a file; none of these is: "),
                       AdfError);
  CHECK_THROWS_WITH_AS(add_adf<double>(world, model_of("bodies: [A]\nA: {mesh: broken.stl}\n")),
                       doctest::Contains("broken.stl:"), IoError);
  AdfBuildDef<double> small;
  small.limits.max_mesh_bytes = 100;
  CHECK_THROWS_AS(add_adf(world, model_of("bodies: [A]\nA: {mesh: a.stl}\n"), small), AdfError);
  CHECK(world.body_count() == 0);
}

TEST_CASE("add_adf: fans reach from the first angle to the last") {
  World<double> world;
  AdfScene<double> scene = add(world, "bodies: [A]\n" + ball("A") +
                                          "sensors: [S]\nS: {type: Proximity, parent: A, range: 2, "
                                          "parametric: {resolution: 3, horizontal angle: 1, "
                                          "vertical angle: 0.5, start offset: 0.25}}\n");
  const SensorLayout<double>& rays = scene.proximity.at("S").rays.rays();
  REQUIRE(rays.size() == 9);
  CHECK((rays.direction[4] - V::UnitX()).norm() < 1e-15);
  CHECK((rays.start[4] - V(0.25, 0, 0)).norm() < 1e-15);
  // Rz(-0.5) Ry(-0.25) x
  const V first(std::cos(0.5) * std::cos(0.25), -std::sin(0.5) * std::cos(0.25), std::sin(0.25));
  CHECK((rays.direction[0] - first).norm() < 1e-15);
  CHECK(rays.length[0] == 2.0);
}

TEST_CASE("add_adf: what names nothing is left out, and said") {
  World<double> world;
  const std::string axes =
      "parent pivot: {x: 0, y: 0, z: 0}, child pivot: {x: 0, y: 0, z: 0}, parent axis: {x: 0, y: "
      "0, z: 1}, child axis: {x: 0, y: 0, z: 1}}\n";
  const AdfScene<double> scene =
      add(world, "namespace: /n/\nbodies: [Left Tip, Right Tip]\n" + ball("Left Tip") +
                     ball("Right Tip") +
                     "joints: [J1, J2]\nJ1: {type: fixed, parent: Left, child: Right, " + axes +
                     "J2: {type: fixed, parent: Left, child: Tip, " + axes +
                     "sensors: [S]\nS: {type: Proximity, parent: Thumb, array: [{offset: {x: 0, y: "
                     "0, z: 0}, direction: {x: 1, y: 0, z: 0}}]}\n");
  CHECK(scene.joints.size() == 1);
  CHECK(scene.joints.find("J1") != nullptr);
  CHECK(has_note(scene.report, "J2", "no body, or several, by the name Tip"));
  CHECK(has_note(scene.report, "S", "no body, or several, by the name Thumb"));
  CHECK(scene.bodies.find("/n/Left Tip") == scene.bodies.find("Left Tip"));
  CHECK(scene.bodies.find("Left") == scene.bodies.find("Left Tip"));
  CHECK(scene.bodies.find("Tip") == nullptr);
  CHECK(scene.bodies.find("LeftTip") == scene.bodies.find("Left Tip"));  // what it calls itself
  CHECK_THROWS_AS((void)scene.bodies.at("Tip"), InvalidArgument);
}

TEST_CASE("add_adf: what the world refuses is an error of its block, and the world stays") {
  CHECK(error_of("bodies: [A, B]\n" + ball("A") + "B: {mass: 1}\n") ==
        "scene.yaml:3: B: BodyDef::inertia = unset: must be set where there is no shape with a "
        "finite volume");
  CHECK(error_of("bodies: [A]\nA: {mass: 1, collision shape: PLANE, collision geometry: {normal: "
                 "{x: 0, y: 0, z: 1}, offset: 0}}\n")
            .find("scene.yaml:2: A: ") == 0);
  AdfBuildDef<double> few;
  few.limits.max_rays = 3;
  CHECK(error_of("bodies: [A]\n" + ball("A") +
                     "sensors: [S]\nS: {type: Resistance, parent: A, parametric: {resolution: 2, "
                     "horizontal angle: 1, vertical angle: 1, start offset: 0}}\n",
                 few) == "scene.yaml:4: S: more than 3 rays");
}
