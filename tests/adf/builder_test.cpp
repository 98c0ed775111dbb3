// SPDX-License-Identifier: BSD-3-Clause
#include "support/example_scenes.hpp"
#include "support/relative.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/io/adf.hpp>
#include <bristle/io/stl.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <support/temp_folder.hpp>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::example_scenes;

namespace {

using V = Vec3<double>;
using Q = Quat<double>;

AdfScene<double> add(World<double>& world, const std::string& text,
                     const AdfBuildDef<double>& def = {}) {
  return add_adf(world, read_adf(text, "scene.yaml"), def);
}

std::string build_error(const std::string& text, const AdfBuildDef<double>& def = {}) {
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

TEST_CASE("add_adf: joints whose bodies stand elsewhere are named, with how far") {
  const auto notes = [](const std::string& child) {
    World<double> world;
    return add(world, "bodies: [A, B]\n" + ball("A") +
                          ball("B", ", location: {position: {x: 2, y: 0, z: 0}}") +
                          "joints: [J]\nJ: {type: hinge, parent: A, child: B, parent pivot: {x: 1, "
                          "y: 0, z: 0}, parent axis: {x: 0, y: 0, z: 1}, child pivot: " +
                          child + "}\n")
        .report;
  };
  CHECK(has_note(notes("{x: -0.997, y: 0, z: 0}, child axis: {x: 0, y: 0, z: 1}"), "J",
                 "0.003 m and 0 rad"));
  CHECK(has_note(notes("{x: -1, y: 0, z: 0}, child axis: {x: 0, y: 0.1, z: 1}"), "J",
                 "m and 0.1 rad"));
  CHECK_FALSE(has_note(notes("{x: -1, y: 0, z: 0}, child axis: {x: 0, y: 0, z: 1}"), "J", "apart"));
}

TEST_CASE("add_adf: a sensor of today's form supersedes the one in its body") {
  World<double> world;
  const auto path = example_scenes / "scene.yaml";
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

TEST_CASE("add_adf: groups and exclusions become filters") {
  World<double> world;
  const AdfScene<double> scene = add(
      world, "bodies: [A, B, C, D, E]\n" + ball("A", ", collision groups: [0]") +
                 ball("B", ", collision groups: [1]") + ball("C", ", collision groups: [0, 1]") +
                 ball("D", ", collision groups: [30, 700]") + ball("E"));
  const auto meet = [&](const char* a, const char* b) {
    return may_meet(world.body(scene.bodies.at(a)).filter, world.body(scene.bodies.at(b)).filter);
  };
  CHECK_FALSE(meet("A", "B"));
  CHECK(meet("A", "C"));
  CHECK(meet("B", "C"));
  CHECK_FALSE(meet("A", "D"));
  CHECK_FALSE(meet("C", "D"));
  // A body without groups meets all, and so does one from elsewhere.
  for (const char* name : {"A", "B", "C", "D", "E"}) {
    CAPTURE(name);
    CHECK(meet("E", name));
    CHECK(may_meet(CollisionFilter{}, world.body(scene.bodies.at(name)).filter));
  }
  // Small groups have the bit after their number, others take bits from the last down.
  CHECK(world.body(scene.bodies.at("C")).filter.category == 0x00000006u);
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
  for (int g = 1; g < 32; ++g) many += ", " + std::to_string(g);
  CHECK(build_error("bodies: [A]\n" + ball("A", ", " + many + "]")) ==
        "scene.yaml:2: A/collision groups = 31: must not be one of more than 31 different ones in "
        "a world");
}

TEST_CASE("add_adf: a ball with a group lies on floors without one") {
  // The file's own floor, or one of the caller's.
  const std::string floor =
      "Floor: {mass: 0, collision shape: PLANE, collision geometry: {normal: {x: 0, y: 0, z: 1}, "
      "offset: 0}}\n";
  const std::string dropped =
      ball("Ball", ", collision groups: [1], location: {position: {x: 0, y: 0, z: 1.01}}");
  for (const bool is_own : {true, false}) {
    CAPTURE(is_own);
    World<double> world({.gravity = {0, 0, -10}, .time_step = 1e-3});
    if (!is_own) world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    const AdfScene<double> scene = add(
        world, is_own ? "bodies: [Ball, Floor]\n" + dropped + floor : "bodies: [Ball]\n" + dropped);
    for (int i = 0; i < 1000; ++i) world.step();
    // 5 m below but for the floor, where it stands at its radius.
    CHECK(world.pose(scene.bodies.at("Ball")).translation.z() == test::relative(1.0).epsilon(1e-4));
  }
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
  CHECK(world.body(scene.bodies.at("C")).inertia_B(0, 0) == test::relative(1.4));
  CHECK(world.body(scene.bodies.at("C")).inertia_B(2, 2) == test::relative(0.4));
  // The box lies along the principal axes and was scaled: a ray along y meets it at 3 / 2 x 2 m.
  const auto hit = world.cast_ray({.origin = world.pose(scene.bodies.at("A")) * V(0.2, 10, 0),
                                   .direction = def.X_WM.rotate(V(0, -1, 0)),
                                   .length = 20});
  CHECK(hit.body == scene.bodies.at("A"));
  CHECK(hit.distance == test::relative(7.0));
}

TEST_CASE("add_adf: bodies lose the part of their speed that the format has") {
  for (const double dt : {1e-3, 1.0 / 60.0, 0.5}) {
    CAPTURE(dt);
    World<double> world({.gravity = {0, 0, 0}, .time_step = dt});
    const AdfScene<double> scene =
        add(world, "bodies: [A, B, C, D]\n" + ball("A") +
                       ball("B",
                            ", damping: {linear: 0, angular: 0}, location: {position: {x: 10, "
                            "y: 0, z: 0}}") +
                       ball("C",
                            ", damping: {linear: 0.9, angular: 0.5}, location: {position: {x: "
                            "20, y: 0, z: 0}}") +
                       ball("D",
                            ", damping: {linear: 3, angular: 1}, location: {position: {x: 30, "
                            "y: 0, z: 0}}"));
    CHECK(has_note(scene.report, "body/damping/linear", "1, as in Bullet"));
    CHECK_FALSE(has_note(scene.report, "body/damping/angular", ""));
    for (const auto& body : scene.bodies) {
      world.set_velocity(body.value, {{0, 1, 0}, {0, 0, 1}});
    }
    const int steps = static_cast<int>(std::lround(1.0 / dt));
    for (int i = 0; i < steps; ++i) world.step();
    // Bullet has (1 - d)^dt in each step, so that 1 - d is left of both after a second.
    const auto left = [&](const char* name) {
      const Twist<double>& twist = world.body(scene.bodies.at(name)).twist;
      return V(twist.linear.y(), twist.angular.z(), 0);
    };
    CHECK((left("A") - V(0.96, 0.9, 0)).norm() < 1e-12);
    CHECK((left("B") - V(1, 1, 0)).norm() < 1e-12);
    CHECK((left("C") - V(0.1, 0.5, 0)).norm() < 1e-12);
    CHECK(left("D").norm() < 1e-12);
  }
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
  CHECK(mass_moment("{mass: 3, mesh: a.stl}\n", "") == test::relative(2.0));
  CHECK(mass_moment("{mass: 3, mesh: b.stl}\n", "") == test::relative(18.0));
  CHECK(mass_moment("{mass: 3, mesh: a.stl, low resolution path: high}\n", "") ==
        test::relative(8.0));
  CHECK(mass_moment("{mass: 3, mesh: a.stl, scale: 2}\n", "") == test::relative(8.0));
  CHECK(mass_moment("{mass: 3, mesh: open.stl}\n", "open") == test::relative(2.0));
  CHECK(mass_moment("{mass: 3, mesh: inside_out.stl}\n", "") == test::relative(2.0));
  CHECK(mass_moment("{mass: 3, mesh: open.stl, collision mesh type: CONVEX_HULL}\n", "") ==
        test::relative(2.0));

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
  // The whole path, however long, and in its own letters.
  const std::string deep =
      "gr\xc3\xb6\xc3\x9f"
      "e/" +
      std::string(100, 'd');
  CHECK_THROWS_WITH_AS(
      add_adf<double>(world, model_of("bodies: [A]\nA: {mesh: " + deep + "/none.stl}\n")),
      doctest::Contains((folder.path() / "low" / deep / "none.stl").string().c_str()), AdfError);
  CHECK_THROWS_WITH_AS(add_adf<double>(world, model_of("bodies: [A]\nA: {mesh: broken.stl}\n")),
                       doctest::Contains("scene.yaml:4: A/mesh = broken.stl: must be a mesh that "
                                         "can be read: "),
                       AdfError);
  CHECK_THROWS_WITH_AS(
      add_adf<double>(world, model_of("bodies: [A]\nA: {collision mesh: broken.stl}\n")),
      doctest::Contains("scene.yaml:4: A/collision mesh = broken.stl: "), AdfError);
  TriangleMesh<double> sheet = box_mesh<double>({1, 1, 1});
  for (V& v : sheet.vertices) v.z() = 0.0;
  save_stl(folder.path() / "low" / "sheet.stl", sheet);
  CHECK_THROWS_WITH_AS(add_adf<double>(world, model_of("bodies: [A]\nA: {mesh: sheet.stl}\n")),
                       doctest::Contains("A/mesh = sheet.stl: must have a convex hull: "),
                       AdfError);
  AdfBuildDef<double> small;
  small.limits.max_mesh_bytes = 100;
  CHECK_THROWS_AS(add_adf(world, model_of("bodies: [A]\nA: {mesh: a.stl}\n"), small), AdfError);
  CHECK(world.body_count() == 0);
}

TEST_CASE("add_adf: damping of bristles joins sliding friction where both are unscaled") {
  const auto parameters = [](const std::string& variable, Law law, bool is_reported) {
    const AdfModel model = read_adf(
        "sensors: [S]\nS: {type: Resistance, parent: A, friction: {dynamic: 2, damping: "
        "30, variable: " +
            variable + "}, array: [{offset: {x: 0, y: 0, z: 0}, direction: {x: 1, y: 0, z: 0}}]}\n",
        "scene.yaml");
    AdfBuildDef<double> def;
    def.law.law = law;
    detail::AdfMeshes<double> meshes(model, def.limits);
    AdfReport report;
    const PatchDef<double> patch = detail::AdfSensorBuilder<double>(model, def, meshes, report)
                                       .patch(model.sensors[0], nullptr);
    CHECK(has_note(report, "sensor/friction/damping", "not taken") == is_reported);
    return patch.parameters.sliding_friction;
  };
  // 30 N/m a step of 1 ms.
  CHECK(parameters("false", Law::paper, false) == test::relative(2.03));
  CHECK(parameters("true", Law::paper, false) == test::relative(2.03));
  CHECK(parameters("false", Law::ambf, false) == test::relative(2.03));
  CHECK(parameters("true", Law::ambf, true) == 2.0);
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
  CHECK(has_note(scene.report, "J2", "several bodies by the name Tip"));
  CHECK(has_note(scene.report, "S", "no body by the name Thumb"));
  CHECK(scene.bodies.find("/n/Left Tip") == scene.bodies.find("Left Tip"));
  CHECK(scene.bodies.find("Left") == scene.bodies.find("Left Tip"));
  CHECK(scene.bodies.find("Tip") == nullptr);
  CHECK(scene.bodies.find("LeftTip") == scene.bodies.find("Left Tip"));  // what it calls itself
  CHECK_THROWS_AS((void)scene.bodies.at("Tip"), InvalidArgument);
}

TEST_CASE("add_adf: what the world refuses is an error of its block, and the world stays") {
  CHECK(build_error("bodies: [A, B]\n" + ball("A") + "B: {mass: 1}\n") ==
        "scene.yaml:3: B/inertia = not given: must be set where there is no shape with a "
        "finite volume");
  CHECK(
      build_error("bodies: [A]\nA: {mass: 1, collision shape: PLANE, collision geometry: {normal: "
                  "{x: 0, y: 0, z: 1}, offset: 0}}\n")
          .find("scene.yaml:2: A/collision shape = ") == 0);
  // Each number is finite, their products are not.
  CHECK(build_error("bodies: [A]\nA: {mass: 1, scale: 1e308, collision shape: BOX, collision "
                    "geometry: {x: 100, y: 1, z: 1}}\n")
            .find("scene.yaml:2: A/collision geometry = ") == 0);
  CHECK(build_error(
            "bodies: [A]\nA: {mass: 1, collision shape: BOX, collision geometry: {x: 1, y: 1, "
            "z: 1}, inertial offset: {position: {x: 1e308, y: 0, z: 0}, orientation: {r: 0, "
            "p: 0, y: 0}}}\n")
            .find("scene.yaml:2: A/collision offset = {x: 1e+308, y: 0, z: 0}: must be") == 0);
  CHECK(
      build_error("bodies: [A, B]\nA: {mass: 0, scale: 1e308}\n" + ball("B") +
                  "joints: [J]\nJ: {type: fixed, parent: A, child: B, parent pivot: {x: 100, y: 0, "
                  "z: 0}, child pivot: {x: 0, y: 0, z: 0}, parent axis: {x: 0, y: 0, z: 1}, child "
                  "axis: {x: 0, y: 0, z: 1}}\n")
          .find("scene.yaml:5: J/parent pivot = {x: 100, y: 0, z: 0}: must be ") == 0);
  // Its author gave whole extents.
  CHECK(
      build_error("bodies: [A]\nA: {mass: 1, collision shape: BOX, collision geometry: {x: 1e300, "
                  "y: 1, z: 1}}\n")
          .find("scene.yaml:2: A/collision geometry = {x: 1e+300, y: 1, z: 1}: must be at most ") ==
      0);
  CHECK(
      build_error("bodies: [A]\nA: {mass: 1, collision shape: BOX, collision geometry: {x: 1e100, "
                  "y: 1e100, z: 1}}\n")
          .find("scene.yaml:2: A/collision geometry = {x: 1e+100, y: 1e+100, z: 1}: must have "
                "moments of inertia") == 0);
  CHECK(build_error(
            "bodies: [A]\n" + ball("A") +
            "joints: [J]\nJ: {type: hinge, parent: A, child: A, parent pivot: {x: 0, y: 0, z: "
            "0}, child pivot: {x: 1, y: 0, z: 0}, parent axis: {x: 0, y: 0, z: 1}, child "
            "axis: {x: 0, y: 0, z: 1}}\n") ==
        "scene.yaml:4: J/child = A: must not be the parent as well");
  AdfBuildDef<double> slow;
  slow.authored_step = 1e10;
  CHECK(build_error(
            "bodies: [A]\n" + ball("A") +
                "sensors: [S]\nS: {type: Resistance, parent: A, contact damping: 1e300, array: "
                "[{offset: {x: 0, y: 0, z: 0}, direction: {x: 1, y: 0, z: 0}}]}\n",
            slow) ==
        "scene.yaml:4: S/contact damping = 1e+300: must be finite and >= 0 (inf in the world)");
  AdfBuildDef<double> few;
  few.limits.max_rays = 3;
  CHECK(
      build_error("bodies: [A]\n" + ball("A") +
                      "sensors: [S]\nS: {type: Resistance, parent: A, parametric: {resolution: 2, "
                      "horizontal angle: 1, vertical angle: 1, start offset: 0}}\n",
                  few) == "scene.yaml:4: S: more than 3 rays");
}
