/// @file
/// Errors name the handle, the kind or the motion that was given, and not a number in its place.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/brick.hpp"
#include "scenes/medley.hpp"

#include <doctest/doctest.h>

#include <string>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("messages: they show what was given") {
  auto m = make_medley<double>();
  const BodyId body = m.bodies[0];
  const auto message_of = [&](auto call) {
    try {
      call(m.world);
    } catch (const InvalidArgument& error) {
      return std::string(error.what());
    }
    return std::string("nothing thrown");
  };
  const std::string handle =
      "{" + std::to_string(body.index) + ", " + std::to_string(body.generation) + "}";
  CHECK(message_of([&](auto& w) { w.move_to(body, {}); }) ==
        "BodyId = " + handle + ": must name a kinematic body, not a dynamic one");
  CHECK(message_of([&](auto& w) {
          w.set_velocity(BodyId{0, 0}, {});
        }) == "BodyId = {0, 0}: must not name a fixed body");
  CHECK(message_of([&](auto& w) {
          w.add_joint(JointDef<double>{.body_a = body, .body_b = body});
        }) == "JointDef::body_b = " + handle + ": must not equal body_a");
  BodyDef<double> plane = brick();
  plane.shape = HalfSpace<double>{};
  CHECK(message_of([&](auto& w) { w.add_body(plane); }) ==
        "BodyDef::motion = dynamic: must not be dynamic with a HalfSpace, which has no mass");
  JointDef<double> ball{.kind = JointKind::ball, .body_a = body, .body_b = m.bodies[1]};
  ball.motor.mode = MotorMode::velocity;
  CHECK(message_of([&](auto& w) { w.add_joint(ball); }) ==
        "JointDef::motor = ball: needs a revolute or prismatic joint");
}
