/// @file
/// Ball joints in a world: what they hold and what they report. How well a swinging mechanism keeps
/// its energy is tested with `MechanismIntegrator`.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/momentum.hpp"
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>

using namespace bristle;
using namespace bristle::detail;

namespace {

template <typename S>
JointDef<S> ball(BodyId a, BodyId b, const Vec3<S>& in_a, const Vec3<S>& in_b) {
  JointDef<S> def;
  def.kind = JointKind::ball;
  def.body_a = a;
  def.body_b = b;
  def.X_AJ.translation = in_a;
  def.X_BJ.translation = in_b;
  return def;
}

template <typename S>
BodyDef<S> link(const Vec3<S>& position) {
  BodyDef<S> def;
  def.mass = S(2);
  def.shape = Box<S>{{S(0.1), S(0.02), S(0.02)}};
  def.position = position;
  return def;
}

}  // namespace

TEST_CASE_TEMPLATE("ball_joint: a hanging link stays, and its joint carries its weight", S, float,
                   double) {
  WorldDef<S> world_def;
  world_def.time_step = S(1) / S(240);
  world_def.gravity = {0, 0, S(-10)};
  World<S> world(world_def);
  const BodyId roof = world.add_body({.motion = Motion::fixed, .position = {0, 0, 1}});
  const BodyId body = world.add_body(link<S>({0, 0, S(0.9)}));
  const JointId joint = world.add_joint(ball<S>(roof, body, {0, 0, 0}, {0, 0, S(0.1)}));
  for (int i = 0; i < 240; ++i) world.step();
  const double eps = static_cast<double>(Tolerance<S>::round_off());
  CHECK(static_cast<double>((world.pose(body).translation - Vec3<S>(0, 0, S(0.9))).norm()) < eps);
  const JointReading<S> reading = world.reading(joint);
  CHECK(static_cast<double>(reading.reaction.force.z()) == test::relative(20).epsilon(100 * eps));
  CHECK(reading.reaction.torque.norm() == S(0));
  CHECK(reading.position == S(0));
  CHECK(reading.velocity == S(0));
}

TEST_CASE("ball_joint: a swinging link turns freely and its joint does not open") {
  WorldDef<double> world_def;
  world_def.time_step = 1e-3;
  World<double> world(world_def);
  const BodyId roof = world.add_body({.motion = Motion::fixed});
  const BodyId body = world.add_body(link<double>({0.1, 0, 0}));
  const JointId joint = world.add_joint(ball<double>(roof, body, {0, 0, 0}, {-0.1, 0, 0}));
  // Turning about its own axis is nobody's business but its own.
  world.set_velocity(body, {{0, 0, 0}, {5, 0, 0}});
  world.step();
  // Released level: alpha = m g r / (I + m r^2), I = m (0.1^2 + 0.02^2) / 3; the joint carries what
  // is left of the weight, m (g - alpha r).
  const double alpha = 9.81 * 0.1 / ((0.01 + 0.0004) / 3 + 0.01);
  CHECK(world.body(body).twist.angular.y() == test::relative(alpha * 1e-3).epsilon(1e-3));
  CHECK(world.body(body).twist.angular.x() == test::relative(5).epsilon(1e-6));
  CHECK(world.reading(joint).reaction.force.z() ==
        test::relative(2 * (9.81 - 0.1 * alpha)).epsilon(1e-3));
  double gap = 0;
  for (int i = 0; i < 2000; ++i) {
    world.step();
    gap = std::max(gap, (world.pose(body) * Vec3<double>(-0.1, 0, 0)).norm());
  }
  // A step turns the link by up to 0.012 rad; what the tangent leaves of the arc is closed within
  // the step, to the square of itself.
  CHECK(gap < 1e-5);
}

TEST_CASE("ball_joint: a joint between two free bodies keeps their momentum") {
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  world_def.time_step = 1e-3;
  World<double> world(world_def);
  const std::array<BodyId, 2> bodies{world.add_body(link<double>({0.1, 0, 0})),
                                     world.add_body(link<double>({0.3, 0, 0}))};
  world.add_joint(ball<double>(bodies[0], bodies[1], {0.1, 0, 0}, {-0.1, 0, 0}));
  world.set_velocity(bodies[0], {{0, 0.5, 0}, {1, 2, 3}});
  const auto before = test::momentum_of(world, std::span<const BodyId>(bodies));
  for (int i = 0; i < 1000; ++i) world.step();
  const auto after = test::momentum_of(world, std::span<const BodyId>(bodies));
  CHECK((after.force - before.force).norm() < 1e-12);
  // Of first order in the step, as for any joint between bodies that circle each other.
  CHECK((after.torque - before.torque).norm() < 2e-3 * before.torque.norm());
  const Vec3<double> gap = world.pose(bodies[0]) * Vec3<double>(0.1, 0, 0) -
                           world.pose(bodies[1]) * Vec3<double>(-0.1, 0, 0);
  CHECK(gap.norm() < 1e-5);
}
