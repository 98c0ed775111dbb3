// Limits of a description, and items that are made once however often they are named.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/io/adf.hpp>
#include <bristle/io/stl.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <support/temp_folder.hpp>

using namespace bristle;

using namespace bristle::detail;

namespace {

const std::string axes =
    "parent pivot: {x: 0, y: 0, z: 0}, child pivot: {x: 0, y: 0, z: 0}, parent axis: {x: 0, y: 0, "
    "z: 1}, child axis: {x: 0, y: 0, z: 1}}\n";

std::string limit_error(const AdfModel& model, const AdfBuildDef<double>& def = {}) {
  World<double> world;
  std::string message = "no error";
  try {
    (void)add_adf(world, model, def);
  } catch (const AdfError& error) {
    message = error.what();
  }
  CHECK(world.body_count() == 0);
  return message;
}

AdfItem item(const std::string& key, const std::string& qualified, const std::string& name) {
  AdfItem result;
  result.key = key;
  result.qualified = qualified;
  result.name = name;
  return result;
}

}  // namespace

TEST_CASE("AdfNames: whole names are found without a search, parts by one pass over the names") {
  AdfNames<int> names;
  names.add(item("BODY Left Tip", "/n/BODY Left Tip", "LeftTip"), 1);
  names.add(item("BODY Right Tip", "/n/BODY Right Tip", "RightTip"), 2);
  names.add(item("A", "/n/A", "Twin"), 3);
  names.add(item("B", "/n/B", "Twin"), 4);
  std::size_t searched = 0;
  const auto found = [&](std::string_view name) {
    const auto match = names.match(name, searched);
    return match.entry == nullptr ? 0 : match.entry->value;
  };
  CHECK(found("/n/BODY Left Tip") == 1);
  CHECK(found("BODY Right Tip") == 2);
  CHECK(found("RightTip") == 2);
  CHECK(found("Twin") == 0);
  CHECK(names.match("Twin", searched).is_several);
  CHECK(searched == 0);
  CHECK(found("Left") == 1);
  CHECK(searched == 16 + 17 + 4 + 4);
  searched = 0;
  CHECK(found("Tip") == 0);
  CHECK(searched == 16 + 17);  // the second match settles it
  CHECK(names.match("Tip", searched).is_several);
  CHECK_FALSE(names.match("Thumb", searched).is_several);
  // A part that begins again within itself.
  names.add(item("C", "/n/aabaabaaa", "C"), 5);
  CHECK(found("aabaaa") == 5);
  CHECK(found("aabab") == 0);
  // Two files may have one key, and then it means neither.
  AdfNames<int> other;
  other.add(item("A", "/m/A", "Single"), 6);
  names.append(other);
  CHECK(names.find("A") == nullptr);
  CHECK(*names.find("/n/A") == 3);
  CHECK(*names.find("Single") == 6);
}

TEST_CASE("add_adf: names that repeat one letter are not searched for ever") {
  // 2000 bodies whose names begin with a kilobyte of B, and joints that name B...BX.
  const std::size_t count = 2000;
  AdfModel model;
  model.file = "scene.yaml";
  for (std::size_t i = 0; i < count; ++i) {
    AdfBody& body = model.bodies.emplace_back();
    body.key = "body" + std::to_string(i);
    body.name = body.key;
    body.qualified = std::string(1000, 'B') + body.key;
    body.shapes.push_back({Sphere<double>{1.0}, {}});
    // None touches another.
    body.location.translation.x() = 10.0 * static_cast<double>(i);
  }
  const auto add_joints = [&](std::size_t joints) {
    for (std::size_t i = 0; i < joints; ++i) {
      AdfJoint& joint = model.joints.emplace_back();
      joint.key = "joint" + std::to_string(i);
      joint.line = i + 1;
      joint.parent = std::string(500 + i, 'B') + "X";
      joint.child = joint.parent;
    }
  };
  // Parent and child are one name, so that each joint costs one pass over the names.
  std::size_t bytes = 0;
  for (const AdfBody& body : model.bodies) bytes += body.qualified.size();
  add_joints(10);
  AdfBuildDef<double> def;
  def.limits.max_searched_bytes = 10 * bytes;
  World<double> world;
  const AdfScene<double> scene = add_adf(world, model, def);
  CHECK(scene.joints.size() == 0);
  CHECK(scene.report.notes().size() == 10);
  def.limits.max_searched_bytes = 10 * bytes - 1;
  const std::string message = limit_error(model, def);
  CHECK(message.find("scene.yaml:10: joint9/parent = BBB") == 0);
  CHECK(message.find("must be a whole name") != std::string::npos);
  // The default limit applies too.
  model.joints.clear();
  add_joints(AdfLimits{}.max_searched_bytes / bytes + 1);
  CHECK(limit_error(model).find("must be a whole name") != std::string::npos);
}

TEST_CASE("add_adf: triangles are bounded over all bodies, and solids are made once") {
  const test::TempFolder folder;
  // Its hull has one triangle for each of the mesh, no two in one plane.
  const TriangleMesh<double> ball = sphere_mesh<double>(1.0, 4);
  const std::size_t n = ball.triangles.size();
  save_stl(folder.path() / "ball.stl", ball);
  const auto model_of = [&](const std::string& more, const std::string& last) {
    return read_adf("bodies: [A, B, C]\nA: &a {mass: 1, mesh: ball.stl" + more +
                        "}\nB: *a\nC:\n  <<: *a\n  " + last + "\n",
                    folder.path() / "scene.yaml");
  };
  const auto at_least = [&](const AdfModel& model, std::size_t triangles) {
    World<double> world;
    AdfBuildDef<double> def;
    def.limits.max_triangles = triangles;
    CHECK(add_adf(world, model, def).bodies.size() == 3);
    def.limits.max_triangles = triangles - 1;
    CHECK(limit_error(model, def) ==
          (folder.path() / "scene.yaml").string() + ":5: C/mesh = ball.stl: more than " +
              std::to_string(triangles - 1) + " triangles that bodies collide with");
  };
  for (const char* type : {"", ", collision mesh type: CONVEX_HULL"}) {
    CAPTURE(type);
    // The mesh once, and the solid of each body; a file under another name is the same.
    at_least(model_of(type, "mass: 2"), n + 3 * n);
    at_least(model_of(type, "low resolution path: ./."), n + 3 * n);
    at_least(model_of(type, "scale: 2"), 2 * n + 3 * n);
  }
}
