/// @file
/// Ball joints within a cone and a range of twist.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;
using std::numbers::pi;
using V = Vec3<double>;

namespace {

/// A rod of 2 kg, 0.2 m along its x axis, hangs by its end from something fixed at the origin. The
/// joint's x axes point upwards on the frame, and from the hanging end into the rod.
struct Hanging {
  World<double> world;
  BodyId body{};
  JointId joint{};

  [[nodiscard]] JointReading<double> reading() const { return world.reading(joint); }
  [[nodiscard]] V along() const { return world.pose(body).rotate(V::UnitX()); }
};

/// @param angle  [rad] From upright, about y.
Hanging make_hanging(JointDef<double> def, double angle, double dt = 1.0 / 240) {
  WorldDef<double> world_def;
  world_def.time_step = dt;
  world_def.gravity = {0, 0, -10};
  Hanging hanging{World<double>(world_def), {}, {}};
  const BodyId frame = hanging.world.add_body({.motion = Motion::fixed});
  const Quat<double> upright = exp_rotation<double>({0, -pi / 2, 0});
  BodyDef<double> rod;
  rod.mass = 2;
  rod.shape = Box<double>{{0.1, 0.02, 0.02}};
  rod.orientation = exp_rotation<double>({0, angle, 0}) * upright;
  rod.position = rod.orientation * V(0.1, 0, 0);
  hanging.body = hanging.world.add_body(rod);
  def.kind = JointKind::cone_twist;
  def.body_a = frame;
  def.body_b = hanging.body;
  def.X_AJ.rotation = upright;
  def.X_BJ.translation = {-0.1, 0, 0};
  hanging.joint = hanging.world.add_joint(def);
  return hanging;
}

}  // namespace

TEST_CASE("cone_twist: a rod that topples rests on its cone") {
  for (const double limit : {0.05, 0.5, 1.5, 2.5}) {
    CAPTURE(limit);
    Hanging hanging = make_hanging({.swing_limit = limit}, limit / 2);
    double farthest = 0;
    for (int i = 0; i < 1200; ++i) {
      hanging.world.step();
      farthest = std::max(farthest, hanging.reading().swing);
    }
    CHECK(farthest < limit + 1e-6);
    const JointReading<double> reading = hanging.reading();
    CHECK(reading.swing == test::relative(limit).epsilon(1e-6));
    CHECK(hanging.world.body(hanging.body).twist.angular.norm() < 1e-6);
    // It topples about y, and the cone turns against m g r sin.
    CHECK(reading.reaction.force.z() == test::relative(20).epsilon(1e-6));
    CHECK((reading.reaction.torque - V(0, -2 * std::sin(limit), 0)).norm() < 1e-5);
    CHECK(std::abs(reading.position) < 1e-6);
  }
}

TEST_CASE("cone_twist: three rows are locked, and stops add one each") {
  CHECK(locked_rows(JointKind::cone_twist) == 3);
  Hanging all = make_hanging({.lower_limit = -1, .upper_limit = 1, .swing_limit = 1}, 0.1);
  all.world.step();
  CHECK(all.world.report().rows == 6);
  Hanging none = make_hanging({.swing_limit = pi}, 0.1);
  none.world.step();
  CHECK(none.world.report().rows == 3);
}

TEST_CASE("cone_twist: a rod outside its cone comes back, from the opposite side too") {
  for (const double angle : {0.8, 2.0, pi - 1e-9, pi}) {
    CAPTURE(angle);
    Hanging hanging = make_hanging({.swing_limit = 0.7}, angle);
    hanging.world.set_gravity(V::Zero());
    CHECK(hanging.reading().swing == test::relative(angle));
    for (int i = 0; i < 240; ++i) hanging.world.step();
    CHECK(hanging.reading().swing == test::relative(0.7).epsilon(1e-6));
  }
}

TEST_CASE("cone_twist: a rod swinging about stays within its cone") {
  const double limit = 2.5;  // It hangs at pi.
  Hanging hanging = make_hanging({.swing_limit = limit}, 1);
  hanging.world.set_velocity(hanging.body, {V(0, 0.8, 0), V::Zero()});
  double farthest = 0;
  const double start = hanging.world.body(hanging.body).kinetic_energy() +
                       20 * hanging.world.pose(hanging.body).translation.z();
  for (int i = 0; i < 2400; ++i) {
    hanging.world.step();
    farthest = std::max(farthest, hanging.reading().swing);
    const double energy = hanging.world.body(hanging.body).kinetic_energy() +
                          20 * hanging.world.pose(hanging.body).translation.z();
    REQUIRE(energy < start + 1e-3);
  }
  CHECK(farthest > limit - 1e-3);
  // A step turns it by up to 0.08 rad, around the cone too: what its tangent leaves of the circle.
  CHECK(farthest < limit + 0.08 * 0.08);
}

TEST_CASE("cone_twist: twist is stopped at its limits, swung or not") {
  for (const double swing : {0.0, 0.6, 1.2}) {
    for (const double side : {-1.0, 1.0}) {
      CAPTURE(swing);
      CAPTURE(side);
      Hanging hanging = make_hanging(
          {.lower_limit = -0.7, .upper_limit = 0.7, .swing_limit = swing + 1e-3}, swing);
      hanging.world.set_gravity(V::Zero());
      // 0.01 N m of what turns the twist alone: along (a + b) / (1 + a . b).
      const auto twisting = [&] {
        const V a = V::UnitZ(), b = hanging.along();
        return V(0.01 / (1 + a.dot(b)) * (a + b));
      };
      double farthest = 0;
      for (int i = 0; i < 240; ++i) {
        hanging.world.apply_wrench(hanging.body, {V::Zero(), side * twisting()});
        hanging.world.step();
        farthest = std::max(farthest, side * hanging.reading().position);
      }
      CHECK(farthest < 0.7 + 1e-6);
      CHECK(side * hanging.reading().position == test::relative(0.7).epsilon(1e-6));
      CHECK((hanging.reading().reaction.torque + side * twisting()).norm() < 1e-6);
      // Meeting the stop has left a little of a drift around the cone, which nothing brakes.
      CHECK(hanging.world.body(hanging.body).twist.angular.norm() < 1e-3);
    }
  }
}

TEST_CASE("cone_twist: the twist and swing are those of the turn, and so are their rates") {
  const JointDef<double> def{.swing_limit = 3};
  Hanging hanging = make_hanging(def, 0);
  const double h = 1e-6;
  const V w(1.3, -0.8, 2.1);
  const Quat<double> upright = exp_rotation<double>({0, -pi / 2, 0});
  for (const double swing : {0.3, 1.0, 2.4}) {
    for (const double twist : {-2.0, 0.4, 2.8}) {
      CAPTURE(swing);
      CAPTURE(twist);
      const Quat<double> turn =
          exp_rotation<double>(swing * V(0, 0.6, 0.8)) * exp_rotation<double>({twist, 0, 0});
      const auto place = [&](double t) {
        const Quat<double> rotation = exp_rotation<double>(t * w) * upright * turn;
        hanging.world.set_pose(hanging.body, {rotation, rotation * V(0.1, 0, 0)});
        return hanging.reading();
      };
      const double ahead = place(h).position, behind = place(-h).position;
      const JointReading<double> reading = place(0);
      hanging.world.set_velocity(hanging.body,
                                 {w.cross(hanging.world.pose(hanging.body).translation), w});
      CHECK(reading.position == test::relative(twist));
      CHECK(reading.swing == test::relative(swing));
      CHECK((ahead - behind) / (2 * h) == test::relative(hanging.reading().velocity).epsilon(1e-7));
    }
  }
}
