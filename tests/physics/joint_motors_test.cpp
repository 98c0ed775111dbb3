/// @file
/// Motors that are springs with dampers and a force limit, and limits of motors in islands that are
/// swept in parts.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/numbers.hpp"
#include "support/relative.hpp"

#include <bristle/math/rotation.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace bristle;
using bristle::test::g;

namespace {

/// A cube of 2 kg that slides along z, or turns about it, on a fixed frame.
template <typename S>
struct Driven {
  World<S> world;
  BodyId body{};
  JointId joint{};

  Driven(JointKind kind, const WorldDef<S>& def, const JointMotor<S>& motor) : world(def) {
    const BodyId frame = world.add_body({.motion = Motion::fixed});
    BodyDef<S> cube;
    cube.mass = S(2);
    cube.inertia = Mat3<S>(S(0.3) * Mat3<S>::Identity());
    body = world.add_body(cube);
    JointDef<S> slide;
    slide.kind = kind;
    slide.body_a = frame;
    slide.body_b = body;
    // x of the joint is z of the world.
    slide.X_AJ.rotation = slide.X_BJ.rotation =
        exp_rotation<S>(shortest_turn<S>(Vec3<S>::UnitX(), Vec3<S>::UnitZ()));
    slide.motor = motor;
    joint = world.add_joint(slide);
  }
};

}  // namespace

// Both at the end of the step: m (v' - v) = dt (k (target - x - dt v') - d v' + load).
TEST_CASE_TEMPLATE("joint_motors: a spring motor follows implicit Euler", S, float, double) {
  for (const JointKind kind : {JointKind::prismatic, JointKind::revolute}) {
    for (const S dt : {S(1e-3), S(1.0 / 60)}) {
      CAPTURE(dt);
      const bool slides = kind == JointKind::prismatic;
      const S m = slides ? S(2) : S(0.3);
      const S load = slides ? S(-2 * g) : S(0);
      JointMotor<S> motor{MotorMode::spring, S(0.4), S(1e6)};
      motor.stiffness = S(150);
      motor.damping = S(3);
      WorldDef<S> def;
      def.time_step = dt;
      Driven<S> driven(kind, def, motor);
      // The solver leaves a part of what forces change velocities by in a step, or their rounding;
      // damping forgets that within 2 m / d < 2 s, so places stay within 2 s of it.
      const double change = double(dt) * (double(motor.stiffness * motor.target / m) + g);
      const double left = 4 * (double(def.solver.tolerance) * change +
                               300 * double(std::numeric_limits<S>::epsilon()));
      double x = 0, v = 0;
      for (int i = 0; i < 300; ++i) {
        driven.world.step();
        const double k = double(motor.stiffness), d = double(motor.damping), h = double(dt);
        v = (double(m) * v + h * (k * (double(motor.target) - x) + double(load))) /
            (double(m) + h * (h * k + d));
        x += h * v;
        const JointReading<S> reading = driven.world.reading(driven.joint);
        CHECK(std::abs(double(reading.position) - x) < 2 * left);
        CHECK(std::abs(double(reading.velocity) - v) < left);
      }
    }
  }
}

TEST_CASE("joint_motors: a loaded spring motor sags by load over stiffness, at any gains") {
  for (const double k : {1e2, 1e5, 1e9, 1e13}) {
    CAPTURE(k);
    JointMotor<double> motor{MotorMode::spring, 0.1, 1e15};
    motor.stiffness = k;
    motor.damping = 2 * std::sqrt(k * 2);
    Driven<double> driven(JointKind::prismatic, {.time_step = 1.0 / 60}, motor);
    for (int i = 0; i < 600; ++i) driven.world.step();
    const auto reading = driven.world.reading(driven.joint);
    CHECK(reading.position == test::relative(0.1 - 2 * g / k).epsilon(1e-9));
    CHECK(reading.motor_force == test::relative(2 * g).epsilon(1e-9));
    CHECK(std::abs(reading.velocity) < 1e-9);
  }
}

TEST_CASE("joint_motors: a spring motor gives no more than its limit") {
  JointMotor<double> motor{MotorMode::spring, 10.0, 2 * g + 3};
  motor.stiffness = 1e6;
  Driven<double> driven(JointKind::prismatic, {.time_step = 1e-3}, motor);
  for (int i = 0; i < 100; ++i) driven.world.step();
  // 3 N beyond the weight for 0.1 s.
  CHECK(driven.world.reading(driven.joint).velocity == test::relative(3 * 0.1 / 2).epsilon(1e-9));
  CHECK(driven.world.reading(driven.joint).motor_force == test::relative(2 * g + 3));
}

// Such islands are solved in four parts of a step of 1/60 s; each part may give a fourth.
TEST_CASE("joint_motors: swept in parts a motor gives no more than its limit") {
  for (const MotorMode mode : {MotorMode::velocity, MotorMode::spring}) {
    JointMotor<double> motor{mode, 10.0, 2 * g + 3};
    motor.stiffness = 1e6;
    WorldDef<double> def;
    def.time_step = 1.0 / 60;
    def.solver.max_direct_work = 0;
    Driven<double> driven(JointKind::prismatic, def, motor);
    for (int i = 0; i < 6; ++i) driven.world.step();
    CHECK(driven.world.reading(driven.joint).velocity == test::relative(3 * 0.1 / 2).epsilon(1e-6));
  }
}

TEST_CASE("joint_motors: gains are checked") {
  Driven<double> driven(JointKind::prismatic, {}, {});
  const auto is_refused = [&](double stiffness, double damping) {
    JointMotor<double> motor{MotorMode::spring, 0, 1};
    motor.stiffness = stiffness;
    motor.damping = damping;
    CHECK_THROWS_AS(driven.world.set_motor(driven.joint, motor), InvalidArgument);
  };
  is_refused(-1, 0);
  is_refused(0, -1);
  is_refused(std::numeric_limits<double>::quiet_NaN(), 0);
  // Without gains there is no force.
  driven.world.set_motor(driven.joint, {MotorMode::spring, 1.0, 1.0});
  driven.world.step();
  CHECK(driven.world.reading(driven.joint).motor_force == 0);
}

// Nothing moved or pressed before the first step, so nothing there tells how small a speed is none.
TEST_CASE_TEMPLATE("joint_motors: a finger that begins to close needs no sweeps", S, float,
                   double) {
  World<S> world({.gravity = bristle::detail::zero<Vec3<S>>(), .time_step = S(1e-3)});
  const S half = S(0.025);
  const Vec3<S> root(S(0.062), S(0), S(0.2));
  BodyId previous = world.add_body({.motion = Motion::fixed, .position = root});
  for (int k = 0; k < 3; ++k) {
    BodyDef<S> link;
    link.shape = Box<S>{{S(0.008), S(0.009), S(0.024)}};
    link.mass = S(0.04);
    link.position = root - Vec3<S>(S(0), S(0), S(2 * k + 1) * half);
    JointDef<S> hinge;
    hinge.kind = JointKind::revolute;
    hinge.body_a = previous;
    hinge.body_b = previous = world.add_body(link);
    hinge.X_AJ.translation.z() = k == 0 ? S(0) : -half;
    hinge.X_BJ.translation.z() = half;
    hinge.X_AJ.rotation = hinge.X_BJ.rotation =
        exp_rotation<S>(shortest_turn<S>(Vec3<S>::UnitX(), Vec3<S>::UnitY()));
    hinge.motor = {MotorMode::spring, k == 0 ? S(0.6) : S(0.1), S(10)};
    hinge.motor.stiffness = S(4);
    hinge.motor.damping = S(0.1);
    world.add_joint(hinge);
  }
  world.step();
  CHECK(world.report().sweeps == 0);
  CHECK(world.report().factorisations < 8);
}
