/// @file
/// Fixed and prismatic joints: what they hold, what they let go, what they report.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/momentum.hpp"
#include "support/relative.hpp"

#include <bristle/math/rotation.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>

using namespace bristle;
using namespace bristle::detail;

namespace {

template <typename S>
BodyDef<S> block(S mass, const Vec3<S>& position) {
  BodyDef<S> def;
  def.mass = mass;
  def.shape = Box<S>{{S(0.05), S(0.04), S(0.03)}};
  def.position = position;
  return def;
}

template <typename S>
void run_for(World<S>& world, double seconds) {
  const long steps = std::lround(seconds / static_cast<double>(world.time_step()));
  for (long i = 0; i < steps; ++i) world.step();
}

/// A block that slides along an axis of a fixed frame.
template <typename S>
struct Slide {
  World<S> world;
  BodyId frame{}, body{};
  JointId joint{};
};

/// @param axis  Direction of the slide; gravity points along -z.
template <typename S>
Slide<S> make_slide(const Vec3<S>& axis, const JointMotor<S>& motor, S lower = -infinity<S>,
                    S upper = infinity<S>, S dt = S(1e-3)) {
  WorldDef<S> world_def;
  world_def.time_step = dt;
  world_def.gravity = {0, 0, S(-10)};
  Slide<S> slide{World<S>(world_def), {}, {}, {}};
  slide.frame = slide.world.add_body({.motion = Motion::fixed});
  slide.body = slide.world.add_body(block<S>(2, {0, 0, 0}));
  JointDef<S> def;
  def.kind = JointKind::prismatic;
  def.body_a = slide.frame;
  def.body_b = slide.body;
  def.X_AJ.rotation = def.X_BJ.rotation = exp_rotation<S>(shortest_turn<S>(Vec3<S>::UnitX(), axis));
  def.motor = motor;
  def.lower_limit = lower;
  def.upper_limit = upper;
  slide.joint = slide.world.add_joint(def);
  return slide;
}

}  // namespace

TEST_CASE_TEMPLATE("joints: a fixed joint holds a cantilever and reports its weight", S, float,
                   double) {
  WorldDef<S> world_def;
  world_def.time_step = S(1) / S(60);
  world_def.gravity = {0, 0, S(-10)};
  World<S> world(world_def);
  const BodyId wall = world.add_body({.motion = Motion::fixed, .position = {1, 1, 1}});
  const BodyId arm = world.add_body(block<S>(2, {S(1.3), 1, 1}));
  JointDef<S> def;
  def.body_a = wall;
  def.body_b = arm;
  def.X_BJ.translation = {S(-0.3), 0, 0};
  const JointId joint = world.add_joint(def);
  run_for(world, 5);
  const double eps = static_cast<double>(Tolerance<S>::round_off());
  CHECK(static_cast<double>((world.pose(arm).translation - Vec3<S>(S(1.3), 1, 1)).norm()) <
        4 * eps);
  CHECK(static_cast<double>(log_rotation<S>(world.pose(arm).rotation).norm()) < 4 * eps);
  // On B about B's joint origin: the wall lifts 20 N, and turns against 20 N at 0.3 m, about -y.
  const JointReading<S> reading = world.reading(joint);
  const double tolerance = 100 * eps;
  CHECK(static_cast<double>(reading.reaction.force.z()) == test::relative(20).epsilon(tolerance));
  CHECK(static_cast<double>(reading.reaction.torque.y()) == test::relative(-6).epsilon(tolerance));
  CHECK(reading.position == S(0));
}

TEST_CASE("joints: a pushed fixed joint comes back to where it was") {
  WorldDef<double> world_def;
  world_def.time_step = 1.0 / 60;
  World<double> world(world_def);
  const BodyId wall = world.add_body({.motion = Motion::fixed});
  const BodyId arm = world.add_body(block<double>(2, {0.3, 0, 0}));
  JointDef<double> def;
  def.body_a = wall;
  def.body_b = arm;
  def.X_AJ.translation = {0.3, 0, 0};
  const JointId joint = world.add_joint(def);
  world.set_pose(arm, {exp_rotation<double>({0.02, -0.03, 0.01}), {0.31, 0.02, -0.01}});
  world.set_velocity(arm, {{0.5, 0, 0}, {1, 2, 3}});
  run_for(world, 1);
  CHECK((world.pose(arm).translation - Vec3<double>(0.3, 0, 0)).norm() < 1e-9);
  CHECK(log_rotation<double>(world.pose(arm).rotation).norm() < 1e-9);
  world.remove_joint(joint);
  run_for(world, 1);
  CHECK(world.pose(arm).translation.z() < -4);
}

TEST_CASE("joints: a heavy body hangs from light ones without stretching the chain") {
  WorldDef<double> world_def;
  world_def.time_step = 1.0 / 60;
  World<double> world(world_def);
  BodyId last = world.add_body({.motion = Motion::fixed});
  JointId top{};
  for (int k = 1; k <= 4; ++k) {
    const BodyId next = world.add_body(block<double>(k == 4 ? 1000.0 : 0.1, {0, 0, -0.2 * k}));
    JointDef<double> def;
    def.body_a = last;
    def.body_b = next;
    def.X_AJ.translation = {0, 0, -0.2};
    const JointId joint = world.add_joint(def);
    if (k == 1) top = joint;
    last = next;
  }
  run_for(world, 3);
  CHECK((world.pose(last).translation - Vec3<double>(0, 0, -0.8)).norm() < 1e-9);
  CHECK(world.reading(top).reaction.force.z() == test::relative(1000.3 * 9.81).epsilon(1e-9));
}

TEST_CASE("joints: a joint between two free bodies keeps their momentum") {
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  world_def.time_step = 1e-3;
  World<double> world(world_def);
  std::array<BodyId, 2> bodies{world.add_body(block<double>(1, {1, 0, 0})),
                               world.add_body(block<double>(3, {1.2, 0.1, 0}))};
  JointDef<double> def;
  def.body_a = bodies[0];
  def.body_b = bodies[1];
  def.X_AJ.translation = {0.2, 0.1, 0};
  world.add_joint(def);
  world.set_velocity(bodies[0], {{0, 0.5, 0}, {1, 2, 3}});
  world.step();  // The jolt that makes them one body.
  const auto before = test::momentum_of(world, std::span<const BodyId>(bodies));
  const double energy = test::energy_of(world, std::span<const BodyId>(bodies));
  run_for(world, 2);
  const auto after = test::momentum_of(world, std::span<const BodyId>(bodies));
  CHECK((after.force - before.force).norm() < 1e-12);
  // Two bodies that circle each other leave their arc by (omega dt)^2 a step; the correction that
  // brings them back has no momentum, but moves the arms of it: of first order in the step.
  CHECK((after.torque - before.torque).norm() < 5e-4 * before.torque.norm());
  CHECK(test::energy_of(world, std::span<const BodyId>(bodies)) ==
        test::relative(energy).epsilon(1e-2));
  const Transform<double> X_AB = relative_pose(world.pose(bodies[0]), world.pose(bodies[1]));
  CHECK((X_AB.translation - Vec3<double>(0.2, 0.1, 0)).norm() < 1e-5);
}

TEST_CASE("joints: a slide falls freely along its axis and not across it") {
  auto slide = make_slide<double>(Vec3<double>(1, 0, -1).normalized(), {});
  run_for(slide.world, 0.5);
  // g sin 45 along the axis for 0.5 s; g cos 45 is the joint's, on 2 kg.
  const JointReading<double> reading = slide.world.reading(slide.joint);
  const double root_half = std::numbers::sqrt2 / 2;
  CHECK(reading.velocity == test::relative(10 * root_half * 0.5).epsilon(1e-9));
  CHECK(reading.position == test::relative(10 * root_half * 0.125).epsilon(3e-3));
  CHECK(reading.motor_force == 0);
  CHECK(reading.reaction.force.isApprox(20 * root_half * Vec3<double>(1, 0, 1).normalized(), 1e-9));
  CHECK(std::abs(slide.world.pose(slide.body).translation.y()) < 1e-12);
  CHECK(log_rotation<double>(slide.world.pose(slide.body).rotation).norm() < 1e-12);
}

TEST_CASE("joints: a velocity motor holds its speed within its force limit") {
  // Upwards at 0.1 m/s against 20 N: 50 N suffice.
  auto strong = make_slide<double>({0, 0, 1}, {MotorMode::velocity, 0.1, 50, 1});
  run_for(strong.world, 0.5);
  CHECK(strong.world.reading(strong.joint).velocity == test::relative(0.1).epsilon(1e-12));
  CHECK(strong.world.reading(strong.joint).motor_force == test::relative(20).epsilon(1e-9));
  // 12 N do not: it falls with (20 - 12) / 2 = 4 m/s^2.
  auto weak = make_slide<double>({0, 0, 1}, {MotorMode::velocity, 0.1, 12, 1});
  run_for(weak.world, 0.5);
  CHECK(weak.world.reading(weak.joint).velocity == test::relative(-2).epsilon(1e-9));
  CHECK(weak.world.reading(weak.joint).motor_force == test::relative(12).epsilon(1e-12));
}

TEST_CASE("joints: a position motor arrives at its speed limit and stays") {
  auto slide = make_slide<double>({0, 0, 1}, {MotorMode::position, 0.2, 100, 0.5});
  run_for(slide.world, 0.2);
  CHECK(slide.world.reading(slide.joint).velocity == test::relative(0.5).epsilon(1e-9));
  run_for(slide.world, 0.8);
  CHECK(slide.world.reading(slide.joint).position == test::relative(0.2).epsilon(1e-9));
  CHECK(std::abs(slide.world.reading(slide.joint).velocity) < 1e-9);
  slide.world.set_motor(slide.joint, {MotorMode::position, 0.0, 100, 0.5});
  run_for(slide.world, 1);
  CHECK(std::abs(slide.world.reading(slide.joint).position) < 1e-9);
}

TEST_CASE("joints: stops are met exactly and not passed") {
  for (const double dt : {1e-3, 1.0 / 60}) {
    auto slide = make_slide<double>({0, 0, 1}, {}, -0.1, 0.05, dt);
    double lowest = 0;
    for (int i = 0; i < 200; ++i) {
      slide.world.step();
      lowest = std::min(lowest, slide.world.reading(slide.joint).position);
    }
    // The tolerance is a millionth of the distance by which forces move a body in a step, about 10
    // m/s^2 dt^2 of two bodies (SolverDef::position_tolerance).
    CHECK(lowest >= -0.1 - 1e-4 * dt * dt);
    CHECK(slide.world.reading(slide.joint).position == test::relative(-0.1).epsilon(1e-9));
    CHECK(slide.world.reading(slide.joint).reaction.force.z() == test::relative(20).epsilon(1e-9));
    slide.world.set_velocity(slide.body, {{0, 0, 30}, {0, 0, 0}});
    slide.world.step();
    slide.world.step();
    CHECK(slide.world.reading(slide.joint).position <= 0.05 + 1e-12);
  }
}

TEST_CASE("joints: what is beyond a stop comes back without speed") {
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  World<double> world(world_def);
  const BodyId base = world.add_body({.motion = Motion::kinematic});
  const BodyId slider = world.add_body(block<double>(1, {-0.01, 0, 0}));
  JointDef<double> def;
  def.kind = JointKind::prismatic;
  def.body_a = base;
  def.body_b = slider;
  def.lower_limit = 0;
  def.upper_limit = 1;
  const JointId joint = world.add_joint(def);
  world.step();
  CHECK(std::abs(world.reading(joint).position) < 1e-15);
  CHECK(world.body(slider).twist.linear.norm() == 0);
}

TEST_CASE("joints: a position motor brakes in time, with the force it has") {
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  World<double> world(world_def);
  const BodyId base = world.add_body({.motion = Motion::kinematic});
  const BodyId slider = world.add_body(block<double>(1, {0, 0, 0}));
  JointDef<double> def;
  def.kind = JointKind::prismatic;
  def.body_a = base;
  def.body_b = slider;
  def.motor = {MotorMode::position, 0.5, 10};
  const JointId joint = world.add_joint(def);
  double highest = 0;
  // Accelerated at 10 m/s^2 and braked at 5 it takes sqrt(2 * 0.5 * (1/10 + 1/5)) = 0.55 s.
  for (int i = 0; i < 240; ++i) {
    world.step();
    highest = std::max(highest, world.reading(joint).position);
  }
  CHECK(highest < 0.5 + 1e-9);
  CHECK(world.reading(joint).position == test::relative(0.5).epsilon(1e-9));
}

TEST_CASE("joints: connected bodies touch only if told to") {
  for (const bool collide : {false, true}) {
    WorldDef<double> world_def;
    world_def.gravity.setZero();
    World<double> world(world_def);
    const BodyId a = world.add_body(block<double>(1, {0, 0, 0}));
    const BodyId b = world.add_body(block<double>(1, {0.09, 0, 0}));
    JointDef<double> def;
    def.kind = JointKind::prismatic;
    def.body_a = a;
    def.body_b = b;
    def.bodies_collide = collide;
    world.add_joint(def);
    run_for(world, 1);
    const double distance = world.pose(b).translation.x() - world.pose(a).translation.x();
    CHECK(distance == test::relative(collide ? 0.1 : 0.09).epsilon(1e-6));
  }
}

// Where steps are straight, a link that turns by three radians in one ends three arms from its
// joint. Gaps are closed where it turns by more than a quarter; the chord of that misses the arc by
// 1 - cos 0.25 = 3.1 % of the arm.
TEST_CASE("joints: a link that turns by radians in a step stays on its joint") {
  for (const JointKind kind : {JointKind::ball, JointKind::revolute}) {
    WorldDef<double> world_def;
    world_def.time_step = 1.0 / 60;
    world_def.integrator = Integrator::symplectic_euler;
    World<double> world(world_def);
    const BodyId base = world.add_body(block<double>(1.0, {0, 0, 0}));
    BodyDef<double> light = block<double>(1e-3, {0.1, 0, 0});
    light.angular_velocity = {0, 0, 190};
    light.velocity = {0, 19, 0};
    const BodyId link = world.add_body(light);
    const Transform<double> X_J{
        exp_rotation<double>(shortest_turn<double>(Vec3<double>::UnitX(), Vec3<double>::UnitZ())),
        {0, 0, 0}};
    world.add_joint({.kind = kind,
                     .body_a = base,
                     .body_b = link,
                     .X_AJ = X_J,
                     .X_BJ = {X_J.rotation, {-0.1, 0, 0}}});
    for (int i = 0; i < 120; ++i) {
      world.step();
      const Vec3<double> end = world.pose(link) * Vec3<double>(-0.1, 0, 0);
      CHECK((end - world.pose(base).translation).norm() < 0.14 * 0.1);
    }
    CHECK(world.body(link).twist.angular.norm() > 1);
  }
}

TEST_CASE("joints: how far frames are apart is told before a step closes them") {
  // A tool stands 1 m from where its joint has it, turned by 0.3 rad about an axis that a hinge
  // locks. Frames at centres of mass have no arms that turns could show at.
  for (const JointKind kind : {JointKind::fixed, JointKind::revolute, JointKind::prismatic,
                               JointKind::ball, JointKind::six_dof}) {
    CAPTURE(static_cast<int>(kind));
    World<double> world({.gravity = Vec3<double>::Zero()});
    const BodyId base = world.add_body({.motion = Motion::fixed});
    const BodyId tool = world.add_body({.mass = 1.0,
                                        .shape = Sphere<double>{0.1},
                                        .position = {0.6, 0.0, 0.8},
                                        .orientation = exp_rotation<double>({0, 0.3, 0})});
    const JointId joint = world.add_joint({.kind = kind, .body_a = base, .body_b = tool});
    const bool is_slide = kind == JointKind::prismatic;
    const bool is_free = kind == JointKind::six_dof;
    const double gap = is_free ? 0 : is_slide ? 0.8 : 1.0;  // x is free along a slide
    const double tilt = is_free || kind == JointKind::ball ? 0 : 0.3;
    CHECK(world.reading(joint).gap == test::relative(gap));
    CHECK(world.reading(joint).tilt == test::relative(tilt));
    world.step();
    CHECK(world.report().joint_gap == test::relative(gap));
    CHECK(world.report().joint_tilt == test::relative(tilt));
    world.step();
    CHECK(world.report().joint_gap < 1e-9);
    CHECK(world.report().joint_tilt < 1e-9);
    CHECK(world.reading(joint).gap < 1e-9);
    // Closing the gap leaves no velocity.
    CHECK(world.body(tool).twist.linear.norm() < 1e-12);
  }
}

TEST_CASE("joints: a hinge whose axes are opposite says so") {
  World<double> world({.gravity = Vec3<double>::Zero()});
  const BodyId base = world.add_body({.motion = Motion::fixed});
  BodyDef<double> def{.mass = 1.0, .shape = Sphere<double>{0.1}};
  def.orientation = Quat<double>(0, 0, 1, 0);
  const BodyId tool = world.add_body(def);
  const JointId hinge =
      world.add_joint({.kind = JointKind::revolute, .body_a = base, .body_b = tool});
  CHECK(world.reading(hinge).tilt == test::relative(std::numbers::pi));
}
