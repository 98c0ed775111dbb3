/// @file
/// Bodies with locked axes: they move where they may, as far as the rest of their inertia lets
/// them, and nowhere else.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/sensors/placement.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;
using namespace bristle::detail;

namespace {

constexpr LockedAxes only_x{{false, true, true}, {true, true, true}};

BodyDef<double> locked_block(const LockedAxes& locked, const Vec3<double>& position) {
  BodyDef<double> def;
  def.mass = 2;
  def.shape = Box<double>{{0.03, 0.04, 0.05}};
  def.position = position;
  def.locked = locked;
  return def;
}

}  // namespace

TEST_CASE_TEMPLATE("locked_axes: a body free along x alone falls along x alone", S, float, double) {
  WorldDef<S> world_def;
  world_def.gravity = {S(-3), S(4), S(-9)};
  world_def.time_step = S(1) / S(256);
  World<S> world(world_def);
  BodyDef<S> def;
  def.mass = S(2);
  def.inertia = Mat3<S>::Identity();
  def.position = {S(0.1), S(0.2), S(0.3)};
  def.orientation = exp_rotation<S>({S(0.3), S(0.4), S(0.5)});
  def.velocity = {S(1), 0, 0};
  def.locked = only_x;
  const BodyId body = world.add_body(def);
  for (int i = 0; i < 256; ++i) {
    world.apply_wrench(body, {{S(2), S(7), S(7)}, {S(1), S(2), S(3)}});
    world.step();
  }
  // 1 m/s and (2 / 2 - 3) m/s^2 for a second.
  CHECK(static_cast<double>(world.body(body).twist.linear.x()) == test::relative(-1));
  const Transform<S> pose = world.pose(body);
  CHECK(pose.translation.y() == def.position.y());
  CHECK(pose.translation.z() == def.position.z());
  CHECK(world.body(body).twist.linear.y() == S(0));
  CHECK(world.body(body).twist.linear.z() == S(0));
  CHECK(world.body(body).twist.angular == Vec3<S>::Zero());
  CHECK(pose.rotation.angularDistance(def.orientation) < Tolerance<S>::equal());
  // 0.1 + 1 - 1 m, to the first order of the step.
  CHECK(static_cast<double>(pose.translation.x()) == test::relative(0.1).epsilon(0.05));
}

TEST_CASE("locked_axes: a planar body turns about z under an off-centre force") {
  WorldDef<double> world_def;
  world_def.time_step = 1.0 / 256;
  World<double> world(world_def);
  const BodyId body =
      world.add_body(locked_block({{false, false, true}, {true, true, false}}, {0, 0, 1}));
  const double inertia = 2.0 / 3 * (0.03 * 0.03 + 0.04 * 0.04);
  const int steps = 64;
  for (int i = 0; i < steps; ++i) {
    // At a point that turns with the body, so that the torque about z is steady.
    const Transform<double> pose = world.pose(body);
    world.apply_force(body, pose.rotate({0, 0.01, 0.02}), pose * Vec3<double>(0.02, 0, 0.01));
    world.step();
  }
  const double seconds = steps / 256.0;
  CHECK(world.body(body).twist.angular.z() ==
        test::relative(0.02 * 0.01 / inertia * seconds).epsilon(1e-9));
  CHECK(world.body(body).twist.angular.x() == 0);
  CHECK(world.body(body).twist.angular.y() == 0);
  CHECK(world.pose(body).translation.z() == 1);
  CHECK(world.body(body).twist.linear.norm() == test::relative(0.005 * seconds).epsilon(1e-3));
}

TEST_CASE("locked_axes: torques meet the inertia of the free axes among themselves") {
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  World<double> world(world_def);
  BodyDef<double> def;
  def.mass = 1;
  def.inertia = Mat3<double>{{2, 0.3, 0.5}, {0.3, 3, 0.4}, {0.5, 0.4, 4}};
  def.locked.angular = {false, true, false};
  const BodyId body = world.add_body(def);
  world.apply_wrench(body, {{0, 0, 0}, {1, 5, -2}});
  world.step();
  // Inverse of ((2, 0.5), (0.5, 4)) times (1, -2); the lock takes the 5 N m and the coupling.
  const double dt = world.time_step(), determinant = 2 * 4 - 0.5 * 0.5;
  const Vec3<double> w = world.body(body).twist.angular;
  CHECK(w.x() == test::relative(dt * (4 * 1 - 0.5 * -2) / determinant).epsilon(1e-12));
  CHECK(w.y() == 0);
  CHECK(w.z() == test::relative(dt * (-0.5 * 1 + 2 * -2) / determinant).epsilon(1e-12));
}

TEST_CASE("locked_axes: contact meets the free axis, and gives no energy") {
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  world_def.time_step = 1.0 / 240;
  World<double> world(world_def);
  // A finger on its slide hits a block of half its mass, off its centre.
  const BodyId finger = world.add_body(locked_block(only_x, {0, 0, 0}));
  BodyDef<double> part = locked_block({}, {0.08, 0.02, 0.01});
  part.mass = 1;
  const BodyId target = world.add_body(part);
  world.set_velocity(finger, {{1, 0, 0}, {0, 0, 0}});
  double energy = 1;
  for (int i = 0; i < 240; ++i) {
    world.step();
    const double now = world.body(finger).kinetic_energy() + world.body(target).kinetic_energy();
    CHECK(now <= energy * (1 + 1e-12));
    energy = now;
    CHECK(world.body(finger).twist.linear.tail<2>() == Vec2<double>::Zero());
    CHECK(world.body(finger).twist.angular == Vec3<double>::Zero());
    CHECK(world.pose(finger).translation.tail<2>() == Vec2<double>::Zero());
  }
  CHECK(world.body(target).twist.linear.x() > 0.5);
  CHECK(energy < 0.9);
  // The block has the momentum that the finger lost along x: the slide takes nothing there.
  CHECK(2 * world.body(finger).twist.linear.x() + world.body(target).twist.linear.x() ==
        test::relative(2).epsilon(1e-9));
}

TEST_CASE("locked_axes: a finger pushed along its axis grips with all of its force by sensors") {
  WorldDef<double> world_def;
  World<double> world(world_def);
  BodyDef<double> wall;
  wall.motion = Motion::fixed;
  wall.shape = Box<double>{{0.05, 0.2, 0.2}};
  wall.position = {0.1, 0, 0};
  wall.filter = {1, 2, 0};
  world.add_body(wall);
  BodyDef<double> def = locked_block(only_x, {0.005, 0, 0});  // Rays end 5 mm before the wall.
  def.filter = {4, 0, 0};
  const BodyId finger = world.add_body(def);
  PatchDef<double> pad;
  for (int i = -1; i <= 1; ++i) {
    for (int j = -1; j <= 1; ++j) {
      pad.sensors.add({0.03, 0.01 * i, 0.01 * j}, {1, 0, 0}, 0.01);
    }
  }
  pad.parameters = {5, 0.1, 1000, 2, 1e-3};
  pad.sense_mask = 1;
  const PatchId patch = world.add_patch(finger, pad);
  double most = 0, travelled = 0;
  for (int i = 0; i < 3000; ++i) {
    const double before = world.pose(finger).translation.x();
    world.apply_force(finger, {10, 0, 0}, world.pose(finger).translation);
    world.step();
    travelled += world.pose(finger).translation.x() - before;
    // Never more than the work of the 10 N, which symplectic Euler gives to half a step's force.
    most = std::max(most, world.body(finger).kinetic_energy() - 10 * travelled);
  }
  CHECK(most < 1e-12);
  CHECK(world.reading(patch).total_normal() == test::relative(10).epsilon(1e-6));
  CHECK(world.body(finger).twist.linear.norm() < 1e-9);
  CHECK(world.pose(finger).translation.tail<2>() == Vec2<double>::Zero());
}

TEST_CASE("locked_axes: a velocity along a locked axis is refused") {
  World<double> world;
  BodyDef<double> def = locked_block(only_x, {0, 0, 0});
  def.velocity = {0, 1, 0};
  CHECK_THROWS_AS(world.add_body(def), InvalidArgument);
  def.velocity = {1, 0, 0};
  def.angular_velocity = {0, 0, 1};
  CHECK_THROWS_AS(world.add_body(def), InvalidArgument);
  def.angular_velocity.setZero();
  const BodyId body = world.add_body(def);
  CHECK_THROWS_AS(world.set_velocity(body, {{1, 0, 1e-9}, {0, 0, 0}}), InvalidArgument);
  CHECK(world.body(body).twist.linear == Vec3<double>(1, 0, 0));
  CHECK_NOTHROW(world.set_velocity(body, {{2, 0, 0}, {0, 0, 0}}));
  // A body that forces do not move has no axes to lock.
  def.motion = Motion::kinematic;
  def.velocity = {0, 1, 0};
  CHECK_NOTHROW(world.add_body(def));
}

TEST_CASE("locked_axes: joints whose free axis is all that locks leave move as without locks") {
  // A slide along x of a body that can move along x alone; the joint's frames are turned by what
  // round-off makes of a full turn, or not at all.
  for (const double turn : {0.0, 1e-12, 2 * std::numbers::pi}) {
    CAPTURE(turn);
    WorldDef<double> world_def;
    world_def.gravity = {-9.81, 0, 0};
    world_def.time_step = 1.0 / 256;
    World<double> world(world_def);
    JointDef<double> slide;
    slide.kind = JointKind::prismatic;
    slide.body_b =
        world.add_body(locked_block({{false, true, true}, {false, false, false}}, {0, 0, 0}));
    slide.X_AJ.rotation = Eigen::AngleAxisd(turn, Vec3<double>::UnitY());
    slide.X_BJ = slide.X_AJ;
    const JointId joint = world.add_joint(slide);
    for (int i = 0; i < 256; ++i) world.step();
    CHECK(world.reading(joint).position == test::relative(-0.5 * 9.81).epsilon(1e-9));
  }
}

TEST_CASE("locked_axes: a pendulum that locks keep in its plane swings as one that a hinge keeps") {
  const auto swing = [](const LockedAxes& locked) {
    WorldDef<double> world_def;
    world_def.time_step = 1.0 / 256;
    World<double> world(world_def);
    // The hinge's axis is the x axis of its frames: y of the world.
    const Quat<double> x_along_y(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3<double>::UnitZ()));
    JointDef<double> hinge;
    hinge.kind = JointKind::revolute;
    hinge.body_b = world.add_body(locked_block(locked, {0.1, 0, 0}));
    hinge.X_AJ = {x_along_y, {0, 0, 0}};
    hinge.X_BJ = {x_along_y, {-0.1, 0, 0}};
    world.add_joint(hinge);
    for (int i = 0; i < 40; ++i) world.step();
    return world.pose(hinge.body_b).translation;
  };
  const Vec3<double> free = swing({});
  CHECK(free.z() < -0.05);
  CHECK((swing({{false, true, false}, {true, false, true}}) - free).norm() < 1e-9);
}
