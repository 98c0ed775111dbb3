/// @file
/// Tests of recordings as binary glTF.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/recorded_scene.hpp"
#include "support/glb_file.hpp"
#include "support/relative.hpp"

#include <bristle/io/glb.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

using namespace bristle;
using namespace bristle::test;

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
  CHECK(field([](Recording<double>& r) { r.patches[0].directions.pop_back(); }) ==
        "glb: Recording::Patch::directions.size()");
  CHECK(field([](Recording<double>& r) { r.patches[0].states.pop_back(); }) ==
        "glb: Recording::Patch::states.size()");
  CHECK(field([](Recording<double>& r) { r.patches[0].depths[1] = 1.5f; }) ==
        "glb: Recording::Patch::depths");
  CHECK(field([](Recording<double>& r) { r.contacts.pop_back(); }) ==
        "glb: Recording::contacts.size()");
  CHECK(field([](Recording<double>& r) { r.contacts[0].push_back({.body = 9}); }) ==
        "glb: Recording::Contact::body");
  CHECK(field([](Recording<double>& r) { r.joints.push_back({.name = "j", .body = 9}); }) ==
        "glb: Recording::Joint::body");
  CHECK(field([](Recording<double>& r) { r.joints.push_back({.name = "j", .positions = {1}}); }) ==
        "glb: Recording::Joint::positions.size()");
  CHECK(field([](Recording<double>& r) {
          r.channels.push_back({"c", "N", 0, {1, 2}});
        }) == "glb: Recording::Channel::values.size()");
  CHECK(field([](Recording<double>& r) {
          r.channels.push_back({"c", "N", 9, {1e39}});
        }) == "glb: Recording::Channel");
  // A name in Latin-1, whose bytes are no UTF-8.
  const std::string latin =
      "Pr\xfc"
      "fling";
  CHECK(field([&](Recording<double>& r) { r.bodies[1].name = latin; }) ==
        "glb: Recording::Body::name");
  CHECK(field([&](Recording<double>& r) { r.patches[0].name = latin; }) ==
        "glb: Recording::Patch::name");
  CHECK(field([&](Recording<double>& r) {
          r.channels.push_back({latin, "N", r.times.size(), {}});
        }) == "glb: Recording::Channel::name");
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
  const Glb file(glb(recording, {.longest_arrow = 0.05, .arrow_rate = 1e6}));
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

TEST_CASE("glb: tracks have every sensor in every frame") {
  RecordedScene<double> scene;
  scene.record_all();
  scene.run(600);
  const Recording<double>& recording = scene.recorder.recording();
  const Recording<double>::Patch& patch = recording.patches[0];
  const Glb file(glb(recording));
  const Json& extras = file.json["extras"]["bristle"];
  const Json& tracks = extras["patches"][0];
  CHECK(tracks["name"].text() == "pad");
  CHECK(tracks["node"].index() == file.node("a \"plate\"\t"));
  CHECK(file.values(extras["times"]).size() == recording.times.size());
  const std::vector<double> first = file.values(tracks["first"]);
  const std::vector<double> frame = file.values(tracks["frame"]);
  const std::vector<double> force = file.values(tracks["force"]);
  const std::vector<double> depth = file.values(tracks["depth"]);
  const std::vector<double> state = file.values(tracks["state"]);
  const double newton = tracks["newton"].number();
  REQUIRE(first.size() == 5);
  REQUIRE(first[4] == static_cast<double>(frame.size()));
  CHECK(newton > 0);
  CHECK(newton < 1e-3);
  std::size_t touching = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    auto row = static_cast<std::size_t>(first[i]);
    const auto end = static_cast<std::size_t>(first[i + 1]);
    Vec3<double> now = Vec3<double>::Zero();
    double deep = 0, is_in = 0;
    for (std::size_t f = 0; f < recording.times.size(); ++f) {
      if (row < end && frame[row] == static_cast<double>(f)) {
        now = newton * Vec3<double>(force[3 * row], force[3 * row + 1], force[3 * row + 2]);
        deep = depth[row] / 255;
        is_in = state[row];
        ++row;
      }
      const std::size_t at = 4 * f + i;
      CHECK((now - patch.forces[at]).cwiseAbs().maxCoeff() <= 0.51 * newton);
      CHECK(std::abs(deep - static_cast<double>(patch.depths[at])) <= 0.51 / 255);
      CHECK(is_in == static_cast<double>(patch.states[at]));
      if (patch.states[at] != SensorState::free) ++touching;
    }
    CHECK(row == end);
  }
  CHECK(touching > 50);
}

TEST_CASE("glb: arrows have keys at their own rate, and are left out where they are too many") {
  RecordedScene<double> scene(60);
  scene.record_all();
  scene.run(1000);
  const Recording<double>& recording = scene.recorder.recording();
  const auto keys_of_arrows = [&](const Glb& file) {
    std::size_t most = 0;
    const Json& animation = file.json["animations"][0];
    for (const Json& channel : animation["channels"].items()) {
      const Json& node = file.json["nodes"][channel["target"]["node"].index()];
      if (!node.has("extras")) continue;
      const Json& sampler = animation["samplers"][channel["sampler"].index()];
      most = std::max(most, file.values(sampler["input"]).size());
    }
    return most;
  };
  CHECK(keys_of_arrows(Glb(glb(recording, {.arrow_rate = 60}))) > 20);
  const Glb file(glb(recording, {.arrow_rate = 10}));
  const std::size_t keys = keys_of_arrows(file);
  CHECK(keys >= 5);
  CHECK(keys <= 12);
  // The last frame is one of them, whatever the rate.
  const double last =
      static_cast<double>(static_cast<float>(recording.times.back() - recording.times.front()));
  const std::size_t node = file.node("pad 1");
  const double newtons = file.json["nodes"][node]["extras"]["newton_per_metre"].number() *
                         file.at(node, "scale", last)[2];
  const auto& forces = recording.patches[0].forces;
  CHECK(newtons == relative(forces[forces.size() - 3].norm()).epsilon(1e-5));

  const Glb without(glb(recording, {.most_arrows = 3}));
  CHECK(keys_of_arrows(without) == 0);
  CHECK(without.json["nodes"].size() == 4);
  CHECK(without.json["extras"]["bristle"]["patches"][0].has("force"));
}

TEST_CASE("glb: contacts, joints and channels are in the file") {
  RecordedScene<double> scene;
  scene.record_all();
  Recording<double> recording;
  scene.run(40);
  recording = scene.recorder.recording();
  const std::size_t frames = recording.times.size();
  REQUIRE(frames == 4);
  recording.contacts = {
      {}, {{1, {1, 2, 3}, {4, 5, 6}}, {2, {0, 0, 1}, {0, 0, 7}}}, {}, {{.body = 0}}};
  recording.joints.push_back({.name = "hinge",
                              .body = 1,
                              .X_BJ = {Quat<double>::Identity(), {0.1, 0.2, 0.3}},
                              .turns = true,
                              .positions = {1, 2, 3, 4},
                              .motor_forces = {0, 0, 0.5, 0}});
  recording.channels.push_back({"grip \xc2\xb5", "N", 1, {10, 11, 12}});
  const Glb file(glb(recording));
  const Json& extras = file.json["extras"]["bristle"];
  using Numbers = std::vector<double>;
  CHECK(file.values(extras["contacts"]["first"]) == Numbers{0, 0, 2, 2, 3});
  const double plate = static_cast<double>(file.node("a \"plate\"\t"));
  const double ball = static_cast<double>(file.node("ball"));
  const double ground = static_cast<double>(file.node("ground"));
  CHECK(file.values(extras["contacts"]["node"]) == Numbers{plate, ball, ground});
  CHECK(file.values(extras["contacts"]["point"]) == Numbers{1, 2, 3, 0, 0, 1, 0, 0, 0});
  CHECK(file.values(extras["contacts"]["force"]) == Numbers{4, 5, 6, 0, 0, 7, 0, 0, 0});
  const Json& joint = extras["joints"][0];
  CHECK(joint["kind"].text() == "turns");
  CHECK(file.values(joint["position"]) == Numbers{1, 2, 3, 4});
  CHECK(file.values(joint["motor_force"]) == Numbers{0, 0, 0.5, 0});
  CHECK(joint["node"].index() == file.node("hinge"));
  CHECK(file.json["nodes"][file.node("hinge")]["translation"][1].number() ==
        relative(0.2).epsilon(1e-6));
  const Json& channel = extras["channels"][0];
  CHECK(channel["name"].text() == "grip \xc2\xb5");
  CHECK(channel["first_frame"].index() == 1);
  CHECK(file.values(channel["values"]) == Numbers{10, 11, 12});
}

TEST_CASE("glb: 450 sensors that all change in each of 1200 frames take at most 10 MB") {
  Recording<float> recording;
  constexpr std::size_t sensors = 450, frames = 1200;
  recording.bodies.push_back({.name = "hand", .moves = true});
  recording.bodies[0].poses.resize(frames);
  recording.bodies[0].was_there.resize(frames, true);
  Recording<float>::Patch patch{.name = "pad"};
  for (std::size_t i = 0; i < sensors; ++i) {
    patch.ends.push_back({0.001f * static_cast<float>(i), 0, 0});
    patch.directions.push_back({0, 0, 1});
  }
  std::uint32_t random = 1;
  const auto next = [&random] {
    random = 1664525u * random + 1013904223u;
    return static_cast<float>(random >> 8) / static_cast<float>(1u << 24);
  };
  for (std::size_t frame = 0; frame < frames; ++frame) {
    recording.times.push_back(static_cast<double>(frame) / 60);
    for (std::size_t i = 0; i < sensors; ++i) {
      patch.forces.push_back({next(), next(), next()});
      patch.depths.push_back(next());
      patch.states.push_back(i % 2 == 0 ? SensorState::stuck : SensorState::slipping);
    }
  }
  recording.patches.push_back(patch);
  const std::string bytes = glb(recording);
  MESSAGE(bytes.size(), " bytes");
  CHECK(bytes.size() <= 10'000'000);
}
