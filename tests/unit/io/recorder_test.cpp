/// @file
/// Tests of what is kept for a replay.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/recorded_scene.hpp"
#include "support/relative.hpp"

#include <bristle/io/glb.hpp>
#include <bristle/io/recorder.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using namespace bristle::test;

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
  CHECK_THROWS_WITH_AS(scene.recorder.observe(other),
                       doctest::Contains("the world it was added from"), InvalidArgument);
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

TEST_CASE_TEMPLATE("Recorder: bodies of a world look as their definitions say", S, float, double) {
  World<S> world;
  BodyDef<S> def;
  def.center_of_mass = Vec3<S>(S(0.3), S(0), S(0.1));
  def.shapes.push_back(
      {Box<S>{{S(0.1), S(0.2), S(0.3)}}, {Quat<S>::Identity(), {S(1), S(0), S(0)}}});
  def.shapes.push_back({box_mesh<S>({S(1), S(1), S(2)}), {}});
  def.position = {S(3), S(2), S(1)};
  const BodyId body = world.add_body(def);
  Recorder<S> told, asked;
  told.add_body(body, def, "told");
  asked.add_body(world, body, "asked");
  const TriangleMesh<S>& a = told.recording().bodies[0].mesh;
  const TriangleMesh<S>& b = asked.recording().bodies[0].mesh;
  CHECK(a.triangles == b.triangles);
  REQUIRE(a.vertices.size() == b.vertices.size());
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    CHECK((a.vertices[i] - b.vertices[i]).norm() < S(4) * Tolerance<S>::round_off());
  }
  CHECK(asked.recording().bodies[0].moves);
}

TEST_CASE("Recorder: contacts are forces on what moves, and carry it") {
  RecordedScene<double> scene;
  scene.record_all();
  scene.run(2500);
  const Recording<double>& recording = scene.recorder.recording();
  REQUIRE(recording.contacts.size() == recording.times.size());
  CHECK(recording.contacts.front().empty());
  Vec3<double> sum = Vec3<double>::Zero();
  for (const Recording<double>::Contact& contact : recording.contacts.back()) {
    if (contact.body != 2) continue;
    CHECK(std::abs(contact.point.z()) < 1e-3);
    sum += contact.force;
  }
  const double weight = 9.81 * scene.world.body(scene.ball).mass;
  CHECK(sum.z() == relative(weight).epsilon(0.01));
}

TEST_CASE("Recorder: joints have position and drive, scalars their last value") {
  World<double> world({.gravity = {0, 0, 0}, .time_step = 1e-2});
  const BodyId base = world.add_body({.motion = Motion::fixed});
  const BodyId slider =
      world.add_body({.mass = 2.0, .shape = Sphere<double>{.radius = 0.1}, .position = {0, 0, 1}});
  JointDef<double> def;
  def.kind = JointKind::prismatic;
  def.body_a = base;
  def.body_b = slider;
  def.X_AJ.translation = {0, 0, 1};
  def.motor = {MotorMode::velocity, 0.5, 3};
  const JointId joint = world.add_joint(def);
  Recorder<double> recorder(100);
  CHECK_THROWS_WITH_AS(recorder.add_joint(world, joint, "slide"), doctest::Contains("body B"),
                       InvalidArgument);
  recorder.add_world(world);
  recorder.add_world(world);
  for (int i = 1; i <= 20; ++i) {
    world.step();
    if (i > 5) recorder.scalar("count", "", i);
    if (i == 12) recorder.scalar("late", "mm", 3);
    recorder.observe(world);
  }
  const Recording<double>& recording = recorder.recording();
  REQUIRE(recording.bodies.size() == 2);
  REQUIRE(recording.joints.size() == 1);
  CHECK(recording.bodies[1].name == "body 1");
  CHECK(recording.joints[0].name == "joint 0");
  CHECK(recording.joints[0].body == 1);
  CHECK(recording.joints[0].slides);
  CHECK_FALSE(recording.joints[0].turns);
  REQUIRE(recording.joints[0].positions.size() == 20);
  CHECK(recording.joints[0].positions.back() == world.reading(joint).position);
  CHECK(recording.joints[0].motor_forces[2] == relative(3.0).epsilon(1e-9));
  REQUIRE(recording.channels.size() == 2);
  CHECK(recording.channels[0].first_frame == 5);
  CHECK(recording.channels[0].values.size() == 15);
  CHECK(recording.channels[0].values.back() == 20);
  CHECK(recording.channels[1].first_frame == 11);
  CHECK(recording.channels[1].values == std::vector<double>(9, 3.0));

  CHECK_THROWS_WITH_AS(recorder.scalar("count", "N", 1), doctest::Contains("first call"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(recorder.scalar("count", "", std::numeric_limits<double>::quiet_NaN()),
                       doctest::Contains("must be finite"), InvalidArgument);
  CHECK_THROWS_WITH_AS(recorder.scalar("new", "", 1e300), doctest::Contains("must be finite"),
                       InvalidArgument);
  CHECK(recorder.recording().channels.size() == 2);
}

TEST_CASE("Recorder: another world is refused, and a moved one followed") {
  RecordedScene<double> scene;
  scene.record_all();
  scene.run(10);
  World<double> copy = scene.world;
  CHECK_THROWS_WITH_AS(scene.recorder.observe(copy), doctest::Contains("must be the world"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(scene.recorder.add_world(copy), doctest::Contains("must be the world"),
                       InvalidArgument);
  CHECK(scene.recorder.recording().times.size() == 1);
  World<double> moved = std::move(scene.world);
  scene.recorder.follow(moved);
  for (int i = 0; i < 10; ++i) {
    moved.step();
    scene.recorder.observe(moved);
  }
  CHECK(scene.recorder.recording().times.size() == 2);
}

TEST_CASE("Recorder: names that are not UTF-8 are refused, with their bytes") {
  RecordedScene<double> scene;
  const auto refused = [&](const std::string& name) -> std::string {
    try {
      scene.recorder.add_body(scene.ball, scene.ball_def, name);
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    return "taken";
  };
  // Latin-1, a byte that follows nothing, a character cut short, an overlong slash, a surrogate,
  // and what is above all characters.
  CHECK(refused("Pr\xfc"
                "fling") == "Recorder: name = Pr\\xfcfling: must be UTF-8");
  CHECK(refused("\x80") == "Recorder: name = \\x80: must be UTF-8");
  CHECK(refused("a\xe2\x82") == "Recorder: name = a\\xe2\\x82: must be UTF-8");
  CHECK(refused("\xc0\xaf") == "Recorder: name = \\xc0\\xaf: must be UTF-8");
  CHECK(refused("\xed\xa0\x80") == "Recorder: name = \\xed\\xa0\\x80: must be UTF-8");
  CHECK(refused("\xf4\x90\x80\x80") == "Recorder: name = \\xf4\\x90\\x80\\x80: must be UTF-8");
  CHECK(scene.recorder.recording().bodies.empty());
  scene.recorder.add_body(scene.plate, scene.plate_def, "plate");
  CHECK_THROWS_AS(scene.recorder.add_patch(scene.world, scene.patch, "\xff"), InvalidArgument);
  CHECK_THROWS_AS(scene.recorder.scalar("\xff", "N", 1), InvalidArgument);
  CHECK_THROWS_AS(scene.recorder.scalar("force", "\xff", 1), InvalidArgument);
  CHECK(scene.recorder.recording().patches.empty());
  CHECK(scene.recorder.recording().channels.empty());
  CHECK(refused("Pr\xc3\xbc"
                "fling \xe2\x82\xac \xf0\x9f\x96\x90") == "taken");
}

TEST_CASE("Recorder: a sensor that let go between two frames slips in the second") {
  RecordedScene<double> scene(20);
  scene.record_all();
  std::size_t slips = 0, seen = 0, frames = 0;
  std::vector<bool> slipped(4, false);
  for (int i = 0; i < 1500; ++i) {
    // Harder than bristles hold, one way and back.
    scene.world.apply_force(scene.plate, {i % 400 < 200 ? 14.0 : -14.0, 0, 0},
                            scene.world.pose(scene.plate).translation);
    scene.world.step();
    scene.recorder.observe(scene.world);
    const auto states = scene.world.reading(scene.patch).state;
    for (std::size_t k = 0; k < 4; ++k) {
      if (states[k] == SensorState::slipping) ++slips;
      slipped[k] = slipped[k] || states[k] == SensorState::slipping;
    }
    const Recording<double>& recording = scene.recorder.recording();
    if (recording.times.size() == frames) continue;
    frames = recording.times.size();
    for (std::size_t k = 0; k < 4; ++k) {
      const bool is_slipping =
          recording.patches[0].states[4 * (frames - 1) + k] == SensorState::slipping;
      CHECK(is_slipping == (slipped[k] && states[k] != SensorState::free));
      if (is_slipping) ++seen;
      slipped[k] = false;
    }
  }
  CHECK(slips > 20);
  CHECK(seen > 5);
}
