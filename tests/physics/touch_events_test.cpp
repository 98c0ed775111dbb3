/// @file
/// Events of patches: begins and ends of touches that a caller has not read yet.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/toy_pinch.hpp"

#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <vector>

using namespace bristle;

namespace {

/// A plate with twelve sensors that look up, and two boxes that fall on six of them each.
struct TouchScene {
  World<double> world;
  BodyId plate{}, left{}, right{};
  PatchId patch{};

  explicit TouchScene(const WorldDef<double>& settings = {}) : world(settings) {
    plate = world.add_body({.motion = Motion::fixed});
    PatchDef<double> def;
    for (int i = 0; i < 12; ++i) {
      const double x = 0.01 * (i % 4), y = 0.01 * (i / 4);
      def.sensors.add({x, y, 0}, {x, y, 0.01});
    }
    def.parameters =
        tuned_for<double>({.friction = 0.5, .load = 10, .mass = 0.5}).parameters(def.sensors);
    patch = world.add_patch(plate, def);
    left = world.add_body(
        {.mass = 0.5, .shape = Box<double>{{0.009, 0.02, 0.01}}, .position = {0.005, 0.01, 0.03}});
    right = world.add_body(
        {.mass = 0.5, .shape = Box<double>{{0.009, 0.02, 0.01}}, .position = {0.025, 0.01, 0.04}});
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) world.step();
  }
  /// The events since the last call.
  [[nodiscard]] std::vector<TouchEvent> take() {
    const auto events = world.touch_events();
    std::vector<TouchEvent> taken(events.begin(), events.end());
    world.clear_touch_events();
    return taken;
  }
};

bool is_touch(const TouchEvent& event, PatchId patch, BodyId body, bool begins) {
  return event.patch == patch && event.body == body && event.begins == begins;
}

}  // namespace

TEST_CASE("touch_events: bodies that fall on a patch begin in their order, and once") {
  TouchScene scene;
  const double dt = scene.world.time_step();
  scene.run(1);
  CHECK(scene.take().empty());
  scene.world.keep_touch_events(true);
  int steps = 1;
  while (scene.world.touch_events().empty() && steps < 1000) {
    scene.run(1);
    ++steps;
  }
  // In the step in which the fall of 10 mm ends.
  const double fall = std::sqrt(2 * 0.01 / 9.81);
  CHECK(steps * dt >= fall);
  CHECK((steps - 1) * dt < fall);
  CHECK(scene.world.reading(scene.patch).body[0] == scene.left);
  scene.run(300);
  const std::vector<TouchEvent> events = scene.take();
  REQUIRE(events.size() == 2);
  CHECK(is_touch(events[0], scene.patch, scene.left, true));
  CHECK(is_touch(events[1], scene.patch, scene.right, true));
  scene.run(100);
  CHECK(scene.take().empty());
}

TEST_CASE("touch_events: what is removed, lifted or switched off ends, and begins again") {
  TouchScene scene;
  scene.world.keep_touch_events(true);
  scene.run(300);
  CHECK(scene.take().size() == 2);
  // Both changes are seen in the next step, with the ends first, by body.
  scene.world.remove_body(scene.right);
  scene.world.set_pose(scene.left, {Quat<double>::Identity(), {0.005, 0.01, 0.1}});
  scene.run(1);
  std::vector<TouchEvent> events = scene.take();
  REQUIRE(events.size() == 2);
  CHECK(is_touch(events[0], scene.patch, scene.left, false));
  CHECK(is_touch(events[1], scene.patch, scene.right, false));
  CHECK(!scene.world.contains(events[1].body));
  scene.run(400);
  events = scene.take();
  REQUIRE(events.size() >= 1);
  CHECK(is_touch(events[0], scene.patch, scene.left, true));
  scene.world.set_active(scene.patch, false);
  scene.run(1);
  events = scene.take();
  REQUIRE(events.size() == 1);
  CHECK(is_touch(events[0], scene.patch, scene.left, false));
  scene.world.set_active(scene.patch, true);
  scene.world.set_pose(scene.left, {Quat<double>::Identity(), {0.005, 0.01, 0.018}});
  scene.run(1);
  CHECK(scene.take().size() == 1);
  scene.world.remove_patch(scene.patch);
  scene.run(1);
  events = scene.take();
  REQUIRE(events.size() == 1);
  CHECK(is_touch(events[0], scene.patch, scene.left, false));
}

TEST_CASE("touch_events: bodies that sleep on a patch make none, and a restore those that differ") {
  TouchScene scene({.gravity = {0, 0, -9.81}, .sleep = {.time = 0.5}});
  scene.world.keep_touch_events(true);
  scene.run(1);
  const auto above = scene.world.snapshot();
  scene.run(3000);
  CHECK(scene.world.report().sleeping_bodies == 2);
  CHECK(scene.take().size() == 2);
  scene.run(10);
  CHECK(scene.take().empty());
  scene.world.restore(above);
  CHECK(scene.take().empty());
  scene.run(1);
  const std::vector<TouchEvent> events = scene.take();
  REQUIRE(events.size() == 2);
  CHECK(is_touch(events[0], scene.patch, scene.left, false));
  CHECK(is_touch(events[1], scene.patch, scene.right, false));
}

TEST_CASE("touch_events: a new listener is told what is touched, and nobody when it ends") {
  TouchScene scene;
  scene.run(300);
  scene.world.keep_touch_events(true);
  CHECK(scene.take().empty());
  scene.run(1);
  CHECK(scene.world.touch_events().size() == 2);
  scene.world.keep_touch_events(false);
  CHECK(scene.world.touch_events().empty());
  scene.world.set_pose(scene.left, {Quat<double>::Identity(), {0.005, 0.01, 0.1}});
  scene.run(1);
  CHECK(scene.world.touch_events().empty());
}

TEST_CASE("touch_events: the sensors of an engine keep them, too") {
  scenes::ToyPinch pinch({});
  pinch.world().keep_touch_events(true);
  pinch.open(0.005, 0.2);
  pinch.run(0.2);
  const auto events = pinch.world().touch_events();
  REQUIRE(events.size() >= 2);
  for (std::size_t k = 0; k < 2; ++k) {
    CHECK(events[k].body == pinch.part_id);
    CHECK(events[k].begins);
  }
  CHECK(events[0].patch != events[1].patch);
}
