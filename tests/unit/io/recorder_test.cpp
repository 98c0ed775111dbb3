/// @file
/// Tests of what is kept for a replay, and of its binary glTF.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/json.hpp"
#include "support/relative.hpp"

#include <bristle/io/glb.hpp>
#include <bristle/io/recorder.hpp>
#include <bristle/sensors/tuning.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

using namespace bristle;
using bristle::test::Json;

namespace {

/// A plate whose sensors come down on the ground and are pushed aside, and a ball.
template <typename S>
struct RecordedScene {
  World<S> world;
  BodyDef<S> ground_def, plate_def, ball_def;
  BodyId ground, plate, ball;
  PatchId patch;
  Recorder<S> recorder;

  explicit RecordedScene(double rate = 100) : recorder(rate) {
    world.set_time_step(S(1e-3));
    ground_def.motion = Motion::fixed;
    ground_def.shape = HalfSpace<S>{};
    ground = world.add_body(ground_def);
    plate_def.shape = Box<S>{{S(0.1), S(0.1), S(0.01)}};
    plate_def.mass = S(1);
    plate_def.center_of_mass = Vec3<S>(S(0.01), S(0.005), S(0));
    plate_def.position = {S(0), S(0), S(0.018)};
    plate = world.add_body(plate_def);
    ball_def.shape = Sphere<S>{S(0.05)};
    ball_def.position = {S(0.5), S(0), S(1)};
    ball = world.add_body(ball_def);
    PatchDef<S> pad;
    for (const int i : {-1, 1}) {
      for (const int j : {-1, 1}) {
        const S x = S(0.08) * S(i), y = S(0.08) * S(j);
        pad.sensors.add({x, y, S(0)}, {x, y, S(-0.02)});
      }
    }
    GripSpec<S> spec;
    spec.load = S(9.81);
    spec.mass = S(1);
    pad.parameters = tuned_for<S>(spec).parameters(pad.sensors);
    patch = world.add_patch(plate, pad);
  }
  void record_all() {
    recorder.add_body(ground, ground_def, "ground");
    recorder.add_body(plate, plate_def, "a \"plate\"\t");
    recorder.add_body(ball, ball_def, "ball");
    recorder.add_patch(world, patch, "pad");
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      world.apply_force(plate, {S(2), S(1), S(0)}, world.pose(plate).translation);
      world.step();
      recorder.observe(world);
    }
  }
};

/// A .glb file, taken apart.
struct Glb {
  Json json;
  std::string binary;

  explicit Glb(const std::string& bytes) : json(chunk(bytes, 12, "JSON")) {
    REQUIRE(bytes.substr(0, 4) == "glTF");
    REQUIRE(number<std::uint32_t>(bytes, 4) == 2);
    REQUIRE(number<std::uint32_t>(bytes, 8) == bytes.size());
    const std::size_t second = 20 + number<std::uint32_t>(bytes, 12);
    REQUIRE(second % 4 == 0);
    binary = chunk(bytes, second, std::string("BIN\0", 4));
    REQUIRE(second + 8 + binary.size() == bytes.size());
    REQUIRE(json["buffers"][0]["byteLength"].index() == binary.size());
  }
  template <typename T>
  static T number(const std::string& bytes, std::size_t at) {
    T value;
    REQUIRE(at + sizeof value <= bytes.size());
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  }
  static std::string chunk(const std::string& bytes, std::size_t at, const std::string& type) {
    REQUIRE(bytes.substr(at + 4, 4) == type);
    return bytes.substr(at + 8, number<std::uint32_t>(bytes, at));
  }
  /// All numbers of an accessor, one value after another.
  [[nodiscard]] std::vector<double> values(const Json& index) const {
    const Json& accessor = json["accessors"][index.index()];
    const Json& view = json["bufferViews"][accessor["bufferView"].index()];
    const std::string& type = accessor["type"].text();
    const std::size_t width = type == "SCALAR" ? 1 : type == "VEC3" ? 3 : 4;
    const std::size_t start = view["byteOffset"].index();
    const std::size_t kind = accessor["componentType"].index();
    const std::size_t size = kind == 5122 ? 2 : 4;
    const std::size_t count = accessor["count"].index() * width;
    REQUIRE(start % 4 == 0);
    REQUIRE(count * size == view["byteLength"].index());
    std::vector<double> out;
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = start + i * size;
      out.push_back(kind == 5126   ? static_cast<double>(number<float>(binary, at))
                    : kind == 5122 ? number<std::int16_t>(binary, at) / 32767.0
                                   : static_cast<double>(number<std::uint32_t>(binary, at)));
    }
    for (std::size_t k = 0; accessor.has("min") && k < width; ++k) {
      for (std::size_t i = k; i < out.size(); i += width) {
        CHECK(out[i] >= static_cast<double>(static_cast<float>(accessor["min"][k].number())));
        CHECK(out[i] <= static_cast<double>(static_cast<float>(accessor["max"][k].number())));
      }
    }
    return out;
  }
  [[nodiscard]] std::size_t node(const std::string& name) const {
    for (std::size_t i = 0; i < json["nodes"].size(); ++i) {
      if (json["nodes"][i]["name"].text() == name) return i;
    }
    FAIL("no node " << name);
    return 0;
  }
  /// A property of a node at a time [s], as a viewer finds it.
  [[nodiscard]] std::vector<double> at(std::size_t node, const std::string& path, double t) const {
    std::vector<double> out;
    const Json& animation = json["animations"][0];
    for (const Json& channel : animation["channels"].items()) {
      if (channel["target"]["node"].index() != node || channel["target"]["path"].text() != path) {
        continue;
      }
      const Json& sampler = animation["samplers"][channel["sampler"].index()];
      const std::vector<double> times = values(sampler["input"]);
      const std::vector<double> keys = values(sampler["output"]);
      const std::size_t width = keys.size() / times.size();
      std::size_t i = 0;
      while (i + 2 < times.size() && times[i + 1] <= t) ++i;
      REQUIRE(times[i + 1] > times[i]);
      double u = (t - times[i]) / (times[i + 1] - times[i]);
      if (sampler["interpolation"].text() == "STEP") u = u < 1 ? 0 : 1;
      for (std::size_t k = 0; k < width; ++k) {
        out.push_back((1 - u) * keys[i * width + k] + u * keys[(i + 1) * width + k]);
      }
      return out;
    }
    for (const Json& x : json["nodes"][node][path.c_str()].items()) out.push_back(x.number());
    return out;
  }
};

Quat<double> quaternion(const std::vector<double>& x) {
  return Quat<double>(x[3], x[0], x[1], x[2]).normalized();
}

}  // namespace

TEST_CASE_TEMPLATE("Recorder: frames at its rate, with poses and forces as the world has them", S,
                   float, double) {
  RecordedScene<S> scene(30);
  scene.record_all();
  std::uint64_t hash = 0;
  {
    RecordedScene<S> alone(30);
    alone.run(1000);
    hash = alone.world.state_hash();
  }
  scene.run(1000);
  CHECK(scene.world.state_hash() == hash);
  const Recording<S>& recording = scene.recorder.recording();
  REQUIRE(recording.times.size() == 30);
  for (std::size_t i = 0; i < 30; ++i) {
    CHECK(std::abs(recording.times[i] - recording.times[0] - static_cast<double>(i) / 30) < 5.1e-4);
  }
  // On to the next frame.
  while (recording.times.size() == 30) scene.run(1);
  const typename Recording<S>::Body& plate = recording.bodies[1];
  CHECK(plate.name == "a \"plate\"\t");
  CHECK(plate.moves);
  CHECK_FALSE(recording.bodies[0].moves);
  CHECK(plate.poses.back().translation == scene.world.pose(scene.plate).translation);
  // All that the sensors push the ground with is what it pushes the plate back with.
  const typename Recording<S>::Patch& pad = recording.patches[0];
  REQUIRE(pad.forces.size() == 31 * 4);
  Vec3<S> sum = Vec3<S>::Zero();
  for (std::size_t i = 0; i < 4; ++i) sum += pad.forces[30 * 4 + i];
  const Vec3<S> given = scene.world.reading(scene.patch).wrench.force;
  CHECK(given.norm() > 5);
  CHECK((plate.poses.back().rotation * sum + given).norm() <
        S(10) * Tolerance<S>::round_off() * given.norm());
  CHECK((pad.ends[3] - Vec3<S>(S(0.08), S(0.08), S(-0.02))).norm() < S(1e-7));
}

TEST_CASE(
    "Recorder: what comes later was not there before, and what is removed stays where it was") {
  RecordedScene<double> scene;
  scene.recorder.add_body(scene.plate, scene.plate_def, "plate");
  scene.run(50);
  scene.recorder.add_body(scene.ball, scene.ball_def, "ball");
  scene.recorder.add_patch(scene.world, scene.patch, "pad");
  scene.run(50);
  const Vec3<double> last = scene.world.pose(scene.ball).translation;
  scene.world.remove_body(scene.ball);
  scene.world.remove_patch(scene.patch);
  scene.run(50);
  const Recording<double>& recording = scene.recorder.recording();
  REQUIRE(recording.times.size() == 15);
  const std::vector<bool> there{false, false, false, false, false, true,  true, true,
                                true,  true,  false, false, false, false, false};
  CHECK(recording.bodies[1].was_there == there);
  REQUIRE(recording.bodies[1].poses.size() == 15);
  CHECK(recording.bodies[1].poses[14].translation == recording.bodies[1].poses[9].translation);
  CHECK((recording.bodies[1].poses[9].translation - last).norm() < 0.01);
  REQUIRE(recording.patches[0].forces.size() == 15 * 4);
  CHECK(recording.patches[0].forces[14 * 4].isZero(0));
  CHECK_FALSE(recording.patches[0].forces[9 * 4].isZero(0));
}

TEST_CASE("Recorder: frames that long steps missed are not made up for") {
  RecordedScene<double> scene(50);
  scene.record_all();
  scene.world.set_time_step(0.1);
  scene.run(10);
  CHECK(scene.recorder.recording().times.size() == 10);
  scene.world.set_time_step(1e-3);
  scene.run(1000);
  CHECK(std::abs(static_cast<int>(scene.recorder.recording().times.size()) - 60) <= 1);
}

TEST_CASE("glb: recordings that do not fit together are refused") {
  RecordedScene<double> scene;
  scene.record_all();
  scene.run(100);
  const auto field = [&](const auto& change) -> std::string {
    Recording<double> recording = scene.recorder.recording();
    change(recording);
    try {
      (void)glb(recording);
    } catch (const InvalidArgument& error) {
      return error.field();
    }
    return {};
  };
  CHECK(field([](Recording<double>&) {}).empty());
  CHECK(field([](Recording<double>& r) { r.times[3] = r.times[2]; }) == "glb: Recording::times");
  CHECK(field([](Recording<double>& r) { r.bodies[1].poses.pop_back(); }) ==
        "glb: Recording::Body::poses.size()");
  CHECK(field([](Recording<double>& r) { r.bodies[1].poses[2].translation.x() = 1e39; }) ==
        "glb: Recording::Body::poses");
  CHECK(field([](Recording<double>& r) { r.patches[0].body = 3; }) ==
        "glb: Recording::Patch::body");
  CHECK(field([](Recording<double>& r) { r.patches[0].forces.pop_back(); }) ==
        "glb: Recording::Patch::forces.size()");
  CHECK(field([](Recording<double>& r) { r.patches[0].forces[2].x() = 1e30; }) ==
        "glb: Recording::Patch");
}

TEST_CASE("Recorder: what cannot be recorded is refused by name") {
  RecordedScene<double> scene;
  CHECK_THROWS_WITH_AS(Recorder<double>(0), doctest::Contains("rate"), InvalidArgument);
  CHECK_THROWS_WITH_AS(scene.recorder.add_patch(scene.world, scene.patch, "pad"),
                       doctest::Contains("must be on a body that is recorded"), InvalidArgument);
  CHECK_THROWS_AS(scene.recorder.add_body(scene.ball, scene.ball_def, "ball", -1.0),
                  InvalidArgument);
  scene.record_all();
  CHECK_THROWS_WITH_AS(scene.recorder.add_body(scene.ball, scene.ball_def, "ball"),
                       doctest::Contains("already"), InvalidArgument);
  CHECK_THROWS_WITH_AS(scene.recorder.add_patch(scene.world, scene.patch, "pad"),
                       doctest::Contains("already"), InvalidArgument);
  World<double> other;
  const BodyId body = other.add_body(scene.plate_def);
  PatchDef<double> small;
  small.sensors.add({0, 0, 0}, {0, 0, -0.02});
  small.parameters = scene.world.patch(scene.patch).def.parameters;
  REQUIRE(other.add_patch(body, small) == scene.patch);
  CHECK_THROWS_WITH_AS(scene.recorder.observe(other), doctest::Contains("the world it was added"),
                       InvalidArgument);
  CHECK(scene.recorder.recording().times.empty());
  scene.world.remove_patch(scene.patch);
  CHECK_THROWS_AS(scene.recorder.add_patch(scene.world, scene.patch, "pad"), InvalidArgument);
  CHECK_THROWS_WITH_AS((void)glb(scene.recorder.recording()), doctest::Contains("times"),
                       InvalidArgument);
  scene.run(1);
  CHECK_THROWS_WITH_AS((void)glb(scene.recorder.recording(), {.longest_arrow = 0}),
                       doctest::Contains("longest_arrow"), InvalidArgument);
  CHECK(scene.recorder.recording().bodies.size() == 3);
}

TEST_CASE("glb: bodies and arrows are where they were recorded, at every frame") {
  RecordedScene<double> scene;
  scene.record_all();
  scene.run(400);
  scene.world.remove_body(scene.ball);
  scene.run(200);
  Recording<double> recording = scene.recorder.recording();
  // Arrows point everywhere, straight and nearly down, too.
  const std::array<Vec3<double>, 6> directions{Vec3<double>(0, 0, -5), {0, 0, 5}, {1e-6, 0, -5},
                                               {1e-3, -2e-3, -5},      {3, 0, 0}, {-1, -2, -0.01}};
  for (std::size_t i = 0; i < directions.size(); ++i) {
    recording.patches[0].forces[4 * (20 + i)] = directions[i];
  }
  const Glb file(glb(recording, {.longest_arrow = 0.05}));
  // The world's z is glTF's y.
  const std::size_t root = file.json["scenes"][0]["nodes"][0].index();
  CHECK((quaternion(file.at(root, "rotation", 0)) * Vec3<double>(1, 2, 3) - Vec3<double>(1, 3, -2))
            .norm() < 1e-7);
  double largest = 0;
  for (const Vec3<double>& force : recording.patches[0].forces) {
    largest = std::max(largest, force.norm());
  }
  for (std::size_t i = 0; i < recording.times.size(); ++i) {
    const double t =
        static_cast<double>(static_cast<float>(recording.times[i] - recording.times[0]));
    for (const Recording<double>::Body& body : recording.bodies) {
      const std::size_t node = file.node(body.name);
      const std::vector<double> x = file.at(node, "translation", t);
      const Quat<double> q = quaternion(file.at(node, "rotation", t));
      const Transform<double>& pose = body.poses[i];
      CHECK((Vec3<double>(x[0], x[1], x[2]) - pose.translation).norm() < 1e-6);
      CHECK(q.angularDistance(pose.rotation) < 1e-5);
      CHECK(file.at(node, "scale", t)[1] == (body.was_there[i] ? 1 : 0));
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t node = file.node("pad " + std::to_string(k));
      const Vec3<double> force = recording.patches[0].forces[4 * i + k];
      const double length = file.at(node, "scale", t)[2];
      CHECK(std::abs(length - 0.05 * force.norm() / largest) < 1e-7);
      const double newtons =
          file.json["nodes"][node]["extras"]["newton_per_metre"].number() * length;
      CHECK(std::abs(newtons - force.norm()) < 1e-5 * largest);
      if (force.norm() == 0) continue;
      const Vec3<double> along = quaternion(file.at(node, "rotation", t)) * Vec3<double>::UnitZ();
      // Rotations have steps of 1/32767.
      CHECK((along - force.normalized()).norm() < 1e-4);
    }
  }
}

TEST_CASE("glb: meshes are whole, and what stands still has no keys") {
  RecordedScene<double> scene;
  scene.record_all();
  scene.run(600);
  const Glb file(glb(scene.recorder.recording()));
  for (const Json& mesh : file.json["meshes"].items()) {
    const Json& part = mesh["primitives"][0];
    const std::vector<double> points = file.values(part["attributes"]["POSITION"]);
    const std::vector<double> corners = file.values(part["indices"]);
    REQUIRE(corners.size() % 3 == 0);
    for (const double corner : corners) CHECK(3 * corner + 2 < static_cast<double>(points.size()));
    CHECK(part["material"].index() < file.json["materials"].size());
  }
  const std::size_t ground = file.node("ground");
  for (const Json& channel : file.json["animations"][0]["channels"].items()) {
    CHECK(channel["target"]["node"].index() != ground);
  }
  RecordedScene<double> once;
  once.recorder.add_body(once.ground, once.ground_def, "ground");
  once.run(1);
  CHECK_FALSE(Glb(glb(once.recorder.recording())).json.has("animations"));
}
