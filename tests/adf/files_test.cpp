// Scenes of several descriptions: files in one world, launch files, documents of one file, and
// meshes that are not there.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/io/adf.hpp>
#include <bristle/io/adf/adf_launch_reader.hpp>
#include <bristle/io/stl.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <string>
#include <support/temp_folder.hpp>

using namespace bristle;

using namespace bristle::detail;

namespace {

using V = Vec3<double>;

/// A ball of 1 kg and 0.1 m under a key.
std::string small_ball(const std::string& key, const std::string& more = "") {
  return key + ": {mass: 1, collision shape: SPHERE, collision geometry: {radius: 0.1}" + more +
         "}\n";
}

std::string at_x(double x) { return ", location: {position: {x: " + to_text(x) + ", y: 0, z: 0}}"; }

/// A weld 1 m beside a parent's middle.
std::string weld_to(const std::string& parent, const std::string& child) {
  return "joints: [J]\nJ: {type: fixed, parent: " + parent + ", child: " + child +
         ", parent pivot: {x: 1, y: 0, z: 0}, child pivot: {x: 0, y: 0, z: 0}, parent axis: {x: 0, "
         "y: 0, z: 1}, child axis: {x: 0, y: 0, z: 1}}\n";
}

std::string proximity_on(const std::string& parent) {
  return "sensors: [S]\nS: {type: Proximity, parent: " + parent +
         ", range: 1, array: [{offset: {x: 0, y: 0, z: 0}, direction: {x: 1, y: 0, z: 0}}]}\n";
}

bool is_noted(const AdfReport& report, AdfNoteKind kind, const std::string& key,
              const std::string& reason) {
  for (const AdfNote& note : report.notes()) {
    if (note.kind == kind && note.key == key && note.reason.find(reason) != std::string::npos) {
      return true;
    }
  }
  return false;
}

}  // namespace

TEST_CASE("add_adf: joints and sensors may name bodies of files before") {
  World<double> world;
  AdfScene<double> scene;
  // Scaled, so that pivots of the other file are, too.
  add_adf(world, scene,
          read_adf("namespace: /a/\nbodies: [Arm]\n" + small_ball("Arm", ", scale: 2"), "a.yaml"));
  const std::string tool = "namespace: /b/\nbodies: [Tool]\n" + small_ball("Tool", at_x(2));
  add_adf(world, scene, read_adf(tool + weld_to("/a/Arm", "Tool") + proximity_on("Arm"), "b.yaml"));
  CHECK(scene.bodies.size() == 2);
  REQUIRE(scene.joints.size() == 1);
  CHECK(world.reading(scene.joints.at("J")).gap < 1e-15);
  REQUIRE(scene.proximity.size() == 1);
  CHECK(scene.proximity.at("S").carrier == scene.bodies.at("/a/Arm"));

  // The same file again: its joint holds its own Tool, not the first. Names of both mean neither.
  add_adf(world, scene, read_adf(tool + weld_to("Arm", "Tool"), "b.yaml"));
  CHECK(scene.bodies.size() == 3);
  CHECK(scene.bodies.find("Tool") == nullptr);
  CHECK(scene.joints.find("J") == nullptr);
  CHECK(world.joint(scene.joints.begin()[1].value).def.body_b == scene.bodies.begin()[2].value);

  // Now two have the name, and a third file cannot mean one of them.
  add_adf(world, scene,
          read_adf("bodies: [Cap]\n" + small_ball("Cap") + weld_to("Tool", "Cap"), "c.yaml"));
  CHECK(is_noted(scene.report, AdfNoteKind::left_out, "J", "several bodies by the name Tool"));
  // Of several files the report names each.
  CHECK(scene.report.text().find("c.yaml:4: left out: J: several") != std::string::npos);

  // A body that is gone is not found.
  world.remove_body(scene.bodies.at("/a/Arm"));
  add_adf(world, scene,
          read_adf("bodies: [Hat]\n" + small_ball("Hat") + weld_to("/a/Arm", "Hat"), "d.yaml"));
  CHECK(is_noted(scene.report, AdfNoteKind::left_out, "J", "no body by the name /a/Arm"));

  // All or nothing.
  const std::uint64_t before = world.state_hash();
  CHECK_THROWS_AS(add_adf(world, scene,
                          read_adf("bodies: [Good, Bad]\n" + small_ball("Good") +
                                       small_ball("Bad", ", scale: 1e308"),
                                   "e.yaml")),
                  AdfError);
  CHECK(world.state_hash() == before);
  CHECK(scene.bodies.find("Good") == nullptr);
}

TEST_CASE("add_adf: collision groups are those of the world, whatever file has them") {
  World<double> world;
  AdfScene<double> scene;
  add_adf(world, scene,
          read_adf("bodies: [A]\n" + small_ball("A", ", collision groups: [700]"), "a.yaml"));
  // Group 30 would have the bit that 700 has taken.
  add_adf(world, scene,
          read_adf("bodies: [B, C]\n" + small_ball("B", ", collision groups: [30]") +
                       small_ball("C", ", collision groups: [700]"),
                   "b.yaml"));
  const auto filter = [&](const char* name) { return world.body(scene.bodies.at(name)).filter; };
  CHECK_FALSE(may_meet(filter("A"), filter("B")));
  CHECK(may_meet(filter("A"), filter("C")));
}

TEST_CASE("load_adf_launch: models, the world's floor and its gravity") {
  const test::TempFolder folder;
  std::filesystem::create_directories(folder.path() / "world");
  write_file(folder.path() / "world" / "floor.yaml",
             "bodies: [Floor]\nFloor: {mass: 0, collision shape: PLANE, collision geometry: "
             "{normal: {x: 0, y: 0, z: 1}, offset: -1}}\n");
  write_file(folder.path() / "world" / "world.yaml",
             "enclosure size: {length: 4, width: 4, height: 3}\nlights: [light1]\nlight1: {name: "
             "sun}\nenvironment: ./floor.yaml\ngravity: {x: 0, y: 0, z: -2}\n");
  write_file(folder.path() / "ball.yaml",
             "bodies: [Ball]\n" + small_ball("Ball", ", collision groups: [1]"));
  write_file(folder.path() / "tool.yaml", "bodies: [Tool]\ngravity: {x: 0, y: 0, z: 0}\n" +
                                              small_ball("Tool", at_x(1)) +
                                              weld_to("Ball", "Tool"));
  const auto path = folder.path() / "launch.yaml";
  write_file(path,
             "world config: ./world/world.yaml\ncolor config: ./none.yaml\ninput devices config: "
             "./none.yaml\nmultibody configs:\n  - \"./ball.yaml\" #0\n  - ./tool.yaml\n");

  const AdfLaunch launch = load_adf_launch(path);
  REQUIRE(launch.models.size() == 3);
  REQUIRE(launch.gravity.has_value());
  CHECK(*launch.gravity == V(0, 0, -2));
  CHECK(is_noted(launch.report, AdfNoteKind::unsupported, "enclosure size", "walls"));
  CHECK(is_noted(launch.report, AdfNoteKind::unsupported, "input devices config", "comm"));
  for (const AdfNote& note : launch.report.notes()) CHECK(note.kind != AdfNoteKind::unknown);

  World<double> world({.gravity = {0, 0, -10}, .time_step = 1e-3});
  const AdfScene<double> scene = add_adf(world, launch);
  CHECK(scene.bodies.size() == 3);
  CHECK(scene.joints.size() == 1);
  CHECK(world.body(scene.bodies.at("Ball")).gravity_scale == test::relative(0.2));
  CHECK(world.body(scene.bodies.at("Tool")).gravity_scale == 0.0);
  // 1 m/s^2 for both together; they come to the floor after 1.34 s, and lie on it.
  for (int i = 0; i < 3000; ++i) world.step();
  CHECK(world.pose(scene.bodies.at("Ball")).translation.z() == test::relative(-0.9).epsilon(1e-4));

  // Some of them, in one call.
  World<double> one;
  CHECK(add_adf_launch(one, path, {0}).bodies.size() == 2);
  CHECK(one.body_count() == 2);

  CHECK_THROWS_WITH_AS((void)load_adf_launch(path, {2}),
                       doctest::Contains("launch.yaml:5: multibody configs: has 2 files, and none "
                                         "of number 2"),
                       AdfError);
  CHECK_THROWS_WITH_AS((void)load_adf_launch(folder.path() / "ball.yaml"),
                       doctest::Contains("multibody configs: must be given"), AdfError);
  CHECK_THROWS_WITH_AS((void)load_adf(path), doctest::Contains("load_adf_launch reads launch"),
                       AdfError);
  write_file(path, "multibody configs: [./ball.yaml, ./lost.yaml]\n");
  CHECK(add_adf_launch(one, path, {0}).bodies.size() == 1);
  const std::uint64_t before = one.state_hash();
  const std::string lost = (folder.path() / "lost.yaml").string();
  CHECK_THROWS_WITH_AS((void)add_adf_launch(one, path),
                       doctest::Contains("must name files; this is none: "), AdfError);
  CHECK(one.state_hash() == before);
}

TEST_CASE("read_adf_documents: each document of a text is a description") {
  const std::string text = "---\nbodies: [A]\n" + small_ball("A", at_x(-1)) + "---\n" +
                           "bodies: [B]\nstray: 1\n" + small_ball("B") + weld_to("A", "B") +
                           "...\n---\n";
  const std::vector<AdfModel> models = read_adf_documents(text, "scene.yaml");
  REQUIRE(models.size() == 2);
  CHECK(models[1].bodies.at(0).line == 7);
  CHECK(is_noted(models[1].report, AdfNoteKind::unknown, "stray", ""));
  // One model alone says what it is not.
  const AdfModel first = read_adf(text, "scene.yaml");
  CHECK(first.bodies.size() == 1);
  CHECK(is_noted(first.report, AdfNoteKind::left_out, "document 2", "read_adf_documents"));
  // A file is all of them, and names are searched across.
  const test::TempFolder folder;
  write_file(folder.path() / "scene.yaml", text);
  World<double> world;
  const AdfScene<double> scene = add_adf<double>(world, folder.path() / "scene.yaml");
  CHECK(scene.bodies.size() == 2);
  CHECK(scene.joints.size() == 1);

  const auto error_of = [](const std::string& bad, const AdfLimits& limits = {}) -> std::string {
    try {
      (void)read_adf_documents(bad, "scene.yaml", limits);
    } catch (const AdfError& error) {
      return error.what();
    }
    return "no error";
  };
  // Limits hold for all of a text together.
  AdfLimits small;
  small.max_items = 1;
  CHECK(error_of("bodies: [A]\nA: {}\n---\nbodies: [B]\nB: {}\n", small) ==
        "scene.yaml:5: B: more than 1 bodies, shapes, joints, sensors and actuators");
  small = {};
  small.max_nodes = 6;
  CHECK(error_of("a: 1\n---\nb: 1\n", small) == "no error");
  CHECK(error_of("a: 1\n---\nb: 1\n---\nc: 1\n", small) ==
        "scene.yaml:5: more than 6 maps, lists and scalars");
  // Brackets that close nothing are no documents without end.
  CHECK(error_of("a: 1\n]\n").find("scene.yaml:2: no YAML: ") == 0);
  CHECK(error_of("--- ]\n--- ]\n").find("scene.yaml:1: no YAML: ") == 0);
  CHECK(error_of("--- 1\n--- 2\n") == "scene.yaml:1: 1: must be a map of keys");
  CHECK(error_of("# nothing\n---\n---\n") == "scene.yaml: file is empty");
}

TEST_CASE("add_adf: scenes go on without missing meshes, where that is allowed") {
  const test::TempFolder folder;
  save_stl(folder.path() / "there.stl", box_mesh<double>({1, 1, 1}));
  const std::string text =
      "bodies: [Wall, Arm, Hand, Box]\nWall: {mass: 0, mesh: lost.stl}\nArm: {mass: 2, mesh: "
      "lost.stl, inertia: {ix: 1, iy: 1, iz: 1}}\nHand: {mass: 1, mesh: lost.stl}\nBox: {mass: 1, "
      "mesh: there.stl}\nsensors: [Skin, Pad]\nSkin: {type: Proximity, parent: Box, range: 1, "
      "mesh: lost.stl}\nPad: {type: Proximity, parent: Box, range: 1, mesh: there.stl}\n" +
      weld_to("Hand", "Box");
  const AdfModel model = read_adf(text, folder.path() / "scene.yaml");
  World<double> world;
  CHECK_THROWS_WITH_AS((void)add_adf(world, model), doctest::Contains("Wall/mesh = lost.stl"),
                       AdfError);
  CHECK(world.body_count() == 0);
  const AdfScene<double> scene = add_adf(world, model, {.allow_missing_meshes = true});
  CHECK(scene.bodies.size() == 3);
  CHECK(scene.bodies.find("Hand") == nullptr);
  CHECK(world.body(scene.bodies.at("Arm")).mass == 2.0);
  CHECK(scene.joints.size() == 0);
  CHECK(scene.proximity.size() == 1);
  const std::string place = (folder.path() / "lost.stl").string();
  CHECK(is_noted(scene.report, AdfNoteKind::changed, "Wall", "it has no shape: none of"));
  CHECK(is_noted(scene.report, AdfNoteKind::changed, "Arm", place));
  CHECK(is_noted(scene.report, AdfNoteKind::left_out, "Hand", "its inertia is not given"));
  CHECK(is_noted(scene.report, AdfNoteKind::left_out, "Skin", place));
  CHECK(is_noted(scene.report, AdfNoteKind::left_out, "J", "no body by the name Hand"));
}
