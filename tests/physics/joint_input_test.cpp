/// @file
/// Joints that cannot be: each is refused by the name of the field, and the world stays as it was.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/numbers.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

using namespace bristle;
using bristle::test::nan_;

namespace {

constexpr double none_ = infinity<double>;

struct JointMistake {
  std::string field;
  JointKind kind;
  std::function<void(JointDef<double>&)> change;
};

}  // namespace

TEST_CASE("joint_input: limits, springs and bushings that a joint cannot have") {
  World<double> world;
  BodyDef<double> body;
  body.shape = Sphere<double>{0.1};
  const BodyId a = world.add_body(body), b = world.add_body(body);
  using K = JointKind;
  using D = JointDef<double>;
  const std::vector<JointMistake> mistakes{
      {"JointDef::lower_limit", K::revolute, [](D& d) { d.lower_limit = none_; }},
      {"JointDef::lower_limit", K::revolute, [](D& d) { d.lower_limit = nan_; }},
      {"JointDef::upper_limit", K::revolute, [](D& d) { d.lower_limit = d.upper_limit = -none_; }},
      {"JointDef::lower_limit", K::fixed, [](D& d) { d.lower_limit = -1; }},
      {"JointDef::upper_limit", K::ball, [](D& d) { d.upper_limit = 1; }},
      {"JointDef::upper_limit", K::six_dof, [](D& d) { d.upper_limit = 1; }},
      {"JointDef::swing_limit", K::cone_twist, [](D& d) { d.swing_limit = 0; }},
      {"JointDef::swing_limit", K::cone_twist, [](D& d) { d.swing_limit = nan_; }},
      {"JointDef::swing_limit", K::ball, [](D& d) { d.swing_limit = 1; }},
      {"JointSpring::stiffness", K::revolute, [](D& d) { d.spring.stiffness = -1; }},
      {"JointSpring::damping", K::prismatic, [](D& d) { d.spring.damping = nan_; }},
      {"JointSpring::rest", K::revolute, [](D& d) { d.spring.rest = none_; }},
      {"JointDef::spring", K::ball, [](D& d) { d.spring.stiffness = 1; }},
      {"JointDef::spring", K::cone_twist, [](D& d) { d.spring.damping = 1; }},
      {"JointBushing::stiffness[4]", K::six_dof, [](D& d) { d.bushing.stiffness[4] = -1; }},
      {"JointBushing::damping[0]", K::six_dof, [](D& d) { d.bushing.damping[0] = nan_; }},
      {"JointDef::bushing", K::revolute, [](D& d) { d.bushing.damping[5] = 1; }},
  };
  const auto before = world.state_hash();
  for (const JointMistake& mistake : mistakes) {
    CAPTURE(mistake.field);
    D def{.kind = mistake.kind, .body_a = a, .body_b = b};
    mistake.change(def);
    std::string field;
    try {
      world.add_joint(def);
    } catch (const InvalidArgument& error) {
      field = error.field();
    }
    CHECK(field == mistake.field);
    CHECK(world.state_hash() == before);
  }
}

TEST_CASE("joint_input: a motor needs an axis, when a joint is made and later") {
  World<double> world;
  BodyDef<double> body;
  body.shape = Sphere<double>{0.1};
  JointDef<double> def;
  def.body_a = world.add_body(body);
  def.body_b = world.add_body(body);
  for (const JointKind kind :
       {JointKind::fixed, JointKind::ball, JointKind::cone_twist, JointKind::six_dof}) {
    def.kind = kind;
    const JointId joint = world.add_joint(def);
    const std::uint64_t before = world.state_hash();
    CHECK_THROWS_AS(world.set_motor(joint, {.mode = MotorMode::velocity}), InvalidArgument);
    CHECK(world.state_hash() == before);
    CHECK_NOTHROW(world.set_motor(joint, {}));
  }
}
