/// @file
/// Drives that are springs with dampers and a force limit, and limits of drives in islands that are
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

  Driven(JointKind kind, const WorldDef<S>& def, const JointDrive<S>& drive) : world(def) {
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
    slide.drive = drive;
    joint = world.add_joint(slide);
  }
};

}  // namespace

// Both at the end of the step: m (v' - v) = dt (k (target - x - dt v') - d v' + load).
TEST_CASE_TEMPLATE("joint_drives: a spring drive follows implicit Euler", S, float, double) {
  for (const JointKind kind : {JointKind::prismatic, JointKind::revolute}) {
    for (const S dt : {S(1e-3), S(1.0 / 60)}) {
      CAPTURE(dt);
      const bool slides = kind == JointKind::prismatic;
      const S m = slides ? S(2) : S(0.3);
      const S load = slides ? S(-2 * g) : S(0);
      JointDrive<S> drive{DriveMode::spring, S(0.4), S(1e6)};
      drive.stiffness = S(150);
      drive.damping = S(3);
      WorldDef<S> def;
      def.time_step = dt;
      Driven<S> driven(kind, def, drive);
      // The solver leaves a part of what forces change velocities by in a step, or their rounding;
      // damping forgets that within 2 m / d < 2 s, so places stay within 2 s of it.
      const double change = double(dt) * (double(drive.stiffness * drive.target / m) + g);
      const double left = 4 * (double(def.solver.tolerance) * change +
                               300 * double(std::numeric_limits<S>::epsilon()));
      double x = 0, v = 0;
      for (int i = 0; i < 300; ++i) {
        driven.world.step();
        const double k = double(drive.stiffness), d = double(drive.damping), h = double(dt);
        v = (double(m) * v + h * (k * (double(drive.target) - x) + double(load))) /
            (double(m) + h * (h * k + d));
        x += h * v;
        const JointReading<S> reading = driven.world.reading(driven.joint);
        CHECK(std::abs(double(reading.position) - x) < 2 * left);
        CHECK(std::abs(double(reading.velocity) - v) < left);
      }
    }
  }
}

TEST_CASE("joint_drives: a loaded spring drive sags by load over stiffness, at any gains") {
  for (const double k : {1e2, 1e5, 1e9, 1e13}) {
    CAPTURE(k);
    JointDrive<double> drive{DriveMode::spring, 0.1, 1e15};
    drive.stiffness = k;
    drive.damping = 2 * std::sqrt(k * 2);
    Driven<double> driven(JointKind::prismatic, {.time_step = 1.0 / 60}, drive);
    for (int i = 0; i < 600; ++i) driven.world.step();
    const auto reading = driven.world.reading(driven.joint);
    CHECK(reading.position == test::relative(0.1 - 2 * g / k).epsilon(1e-9));
    CHECK(reading.drive_force == test::relative(2 * g).epsilon(1e-9));
    CHECK(std::abs(reading.velocity) < 1e-9);
  }
}

TEST_CASE("joint_drives: a spring drive gives no more than its limit") {
  JointDrive<double> drive{DriveMode::spring, 10.0, 2 * g + 3};
  drive.stiffness = 1e6;
  Driven<double> driven(JointKind::prismatic, {.time_step = 1e-3}, drive);
  for (int i = 0; i < 100; ++i) driven.world.step();
  // 3 N beyond the weight for 0.1 s.
  CHECK(driven.world.reading(driven.joint).velocity == test::relative(3 * 0.1 / 2).epsilon(1e-9));
  CHECK(driven.world.reading(driven.joint).drive_force == test::relative(2 * g + 3));
}

// Such islands are solved in four parts of a step of 1/60 s; each part may give a fourth.
TEST_CASE("joint_drives: swept in parts a drive gives no more than its limit") {
  for (const DriveMode mode : {DriveMode::velocity, DriveMode::spring}) {
    JointDrive<double> drive{mode, 10.0, 2 * g + 3};
    drive.stiffness = 1e6;
    WorldDef<double> def;
    def.time_step = 1.0 / 60;
    def.solver.max_direct_work = 0;
    Driven<double> driven(JointKind::prismatic, def, drive);
    for (int i = 0; i < 6; ++i) driven.world.step();
    CHECK(driven.world.reading(driven.joint).velocity == test::relative(3 * 0.1 / 2).epsilon(1e-6));
  }
}

TEST_CASE("joint_drives: gains are checked") {
  Driven<double> driven(JointKind::prismatic, {}, {});
  const auto is_refused = [&](double stiffness, double damping) {
    JointDrive<double> drive{DriveMode::spring, 0, 1};
    drive.stiffness = stiffness;
    drive.damping = damping;
    CHECK_THROWS_AS(driven.world.set_drive(driven.joint, drive), InvalidArgument);
  };
  is_refused(-1, 0);
  is_refused(0, -1);
  is_refused(std::numeric_limits<double>::quiet_NaN(), 0);
  // Without gains there is no force.
  driven.world.set_drive(driven.joint, {DriveMode::spring, 1.0, 1.0});
  driven.world.step();
  CHECK(driven.world.reading(driven.joint).drive_force == 0);
}
