/// @file
/// When contacts with immovable bodies have a bound, and which.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/contact_island.hpp"
#include "support/relative.hpp"

#include <bristle/dynamics/solver/crushing_limit.hpp>
#include <bristle/dynamics/solver/solver_constants.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// A body of 2 kg between a floor (slot 0) and a plate (slot 2).
struct Press {
  std::array<SolverBody<double>, 3> bodies{};
  Constraints<double> constraints;
  std::array<std::uint32_t, 1> movable{1};
  std::array<std::uint32_t, 2> contacts{0, 1};

  Press() {
    bodies[1].moves = true;
    bodies[1].mass = 2;
    constraints.contacts.resize(2);
    for (std::uint32_t k = 0; k < 2; ++k) {
      constraints.contacts[k].body_a = k;
      constraints.contacts[k].body_b = k + 1;
      constraints.contacts[k].axes = {Vec3<double>(0, 0, 1), Vec3<double>(1, 0, 0),
                                      Vec3<double>(0, 1, 0)};
    }
    bodies[1].inverse_mass.setConstant(0.5);
    bodies[1].inertia = 0.02 * identity<Mat3<double>>();
    bodies[1].inverse_inertia = 50 * identity<Mat3<double>>();
  }
  void move_plate(const Twist<double>& twist) { bodies[2].start = bodies[2].free = twist; }
  [[nodiscard]] Island island() const { return {movable, contacts, {}, {}}; }
  [[nodiscard]] bool is_opposed() const {
    return are_movers_opposed<double>(island(), constraints, bodies);
  }
  void limit() { limit_crushing<double>(island(), constraints, bodies); }
};

}  // namespace

TEST_CASE("crushing_limit: immovable bodies are opposed if one moves against another") {
  Press press;
  CHECK_FALSE(press.is_opposed());
  press.move_plate({{0, 0, -0.1}, {0, 0, 0}});
  CHECK(press.is_opposed());
  // An elevator with a roof.
  press.bodies[0].start = press.bodies[0].free = press.bodies[2].free;
  CHECK_FALSE(press.is_opposed());
  press.move_plate({{0, 0, -0.1}, {0, 0, 1}});
  CHECK(press.is_opposed());
  // A single mover opposes nothing.
  press.constraints.contacts[0].body_a = 2;
  CHECK_FALSE(press.is_opposed());
}

TEST_CASE("crushing_limit: the bound is a multiple of all that acts on the island") {
  Press press;
  press.limit();
  for (const auto& c : press.constraints.contacts) CHECK(c.most_impulse == infinity<double>);
  press.move_plate({{0, 0, -0.1}, {0, 0, 0}});
  const auto bound = [&] {
    return press.constraints.contacts[0].most_impulse / chosen::most_leverage;
  };
  const double by_plate = 2 * 0.1;
  SUBCASE("of the mover's speed, for all bodies") {
    press.limit();
    CHECK(bound() == test::relative(by_plate));
    CHECK(press.constraints.contacts[1].most_impulse == press.constraints.contacts[0].most_impulse);
  }
  SUBCASE("of what stops bodies, and of what forces add") {
    press.bodies[1].start.linear = {3, 4, 0};
    press.bodies[1].free.linear = {3, 4, -0.04};
    press.limit();
    CHECK(bound() == test::relative(by_plate + 2 * 5 + 2 * 0.04));
  }
  SUBCASE("of spin, as a force at the radius of gyration, 0.1 m") {
    press.bodies[1].start.angular = press.bodies[1].free.angular = {0, 6, 8};
    press.limit();
    CHECK(bound() == test::relative(by_plate + 2 * 0.1 * 10));
  }
  SUBCASE("of the most that a motor may give, and of what soft blocks press") {
    press.constraints.rows.resize(2);
    press.constraints.rows[0].direction = {0, 0, 1};
    press.constraints.rows[1].angular_b = {0, 0, 1};
    ConstraintBlock<double> push;
    push.body_b = 1;
    push.count = 1;
    push.kind = BlockKind::bounded;
    push.lower = -3;
    push.upper = 5;
    ConstraintBlock<double> turn = push;
    turn.first = 1;
    turn.upper = 0.7;
    turn.lower = 0;
    ConstraintBlock<double> stop = push;
    stop.upper = infinity<double>;
    press.constraints.blocks = {push, turn, stop};
    SoftBlock<double> pad;
    pad.body_b = 1;
    pad.offset[0] = 3;
    pad.offset[1] = 4;
    press.constraints.soft = {pad};
    const std::array<std::uint32_t, 3> blocks{0, 1, 2};
    const std::array<std::uint32_t, 1> soft{0};
    limit_crushing<double>({press.movable, press.contacts, blocks, soft}, press.constraints,
                           press.bodies);
    CHECK(bound() == test::relative(by_plate + 5 + 0.7 / 0.1 + 5));
  }
}

TEST_CASE("crushing_limit: a mover that acts through a joint counts") {
  Press press;
  press.move_plate({{0, 0, -0.1}, {0, 0, 0}});
  press.constraints.contacts[1].body_b = 0;
  CHECK_FALSE(press.is_opposed());
  ConstraintBlock<double> joint;
  joint.body_a = 1;
  joint.body_b = 2;
  press.constraints.blocks = {joint};
  const std::array<std::uint32_t, 1> blocks{0};
  CHECK(are_movers_opposed<double>({press.movable, press.contacts, blocks, {}}, press.constraints,
                                   press.bodies));
}

TEST_CASE("crushing_limit: loads beyond the bound are cut back along themselves") {
  Press press;
  press.constraints.contacts[0].impulse = {1e6, 2e5, -3e5};
  press.constraints.contacts[1].impulse = {1, 0.2, -0.3};
  press.move_plate({{0, 0, -0.1}, {0, 0, 0}});
  press.limit();
  const auto& crushed = press.constraints.contacts[0].impulse;
  CHECK(crushed[0] == test::relative(2));
  CHECK(crushed[1] == test::relative(0.4));
  CHECK(crushed[2] == test::relative(-0.6));
  CHECK(press.constraints.contacts[1].impulse[0] == 1);
}

TEST_CASE("crushing_limit: contacts between bodies that move have no bound") {
  // Two bodies, one on the other, between the floor and the plate.
  Press press;
  std::array<SolverBody<double>, 4> bodies{press.bodies[0], press.bodies[1], press.bodies[1],
                                           press.bodies[2]};
  bodies[3].start = bodies[3].free = {{0, 0, -0.1}, {0, 0, 0}};
  auto& all = press.constraints.contacts;
  all.push_back(all[1]);
  all[2].body_a = 2;
  all[2].body_b = 3;
  const std::array<std::uint32_t, 2> movable{1, 2};
  const std::array<std::uint32_t, 3> contacts{0, 1, 2};
  limit_crushing<double>({movable, contacts, {}, {}}, press.constraints, bodies);
  CHECK(all[0].most_impulse == test::relative(chosen::most_leverage * 2 * 2 * 0.1));
  CHECK(all[1].most_impulse == infinity<double>);
  CHECK(all[2].most_impulse == all[0].most_impulse);
}

TEST_CASE("crushing_limit: what is no number bounds nothing") {
  Press press;
  press.move_plate({{0, 0, -0.1}, {0, 0, 0}});
  press.bodies[1].start.linear[0] = std::nan("");
  press.limit();
  CHECK(press.constraints.contacts[0].most_impulse == infinity<double>);
}

TEST_CASE("crushing_limit: the speed of a mover counts along the rows of its joints") {
  // The plate carries the body, which is 0.3 m from its axis and has a radius of gyration of 0.1 m.
  Press press;
  press.constraints.contacts[1].body_b = 0;
  press.constraints.rows.resize(2);
  press.constraints.rows[0].direction = {0, 1, 0};
  press.constraints.rows[0].angular_b = {0, 0, 0.3};
  press.constraints.rows[1].angular_a = press.constraints.rows[1].angular_b = {0, 0, 1};
  ConstraintBlock<double> joint;
  joint.body_a = 1;
  joint.body_b = 2;
  joint.count = 2;
  press.constraints.blocks = {joint};
  const std::array<std::uint32_t, 1> blocks{0};
  press.move_plate({{7, 4, 0}, {0, 0, 20}});
  limit_crushing<double>({press.movable, press.contacts, blocks, {}}, press.constraints,
                         press.bodies);
  const double speed = std::hypot(4 + 0.3 * 20, 0.1 * 20);
  CHECK(press.constraints.contacts[0].most_impulse ==
        test::relative(chosen::most_leverage * 2 * speed));
}
