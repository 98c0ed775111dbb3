/// @file
/// Mechanisms of revolute joints, integrated.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/mechanism.hpp"
#include "support/numbers.hpp"

#include <doctest/doctest.h>

#include <numbers>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::g;
using test::Mechanism;
using V = Vec3<double>;

TEST_CASE("MechanismIntegrator: in a plane hinges do what ball joints do") {
  auto hinges = test::chain<double>(4, true, JointKind::revolute);
  auto balls = test::chain<double>(4);
  for (auto* m : {&hinges, &balls}) {
    m->integrator = MechanismIntegrator<double>(1e-10);
    REQUIRE(m->run(0.6, 1.0 / 240));
  }
  for (std::size_t i = 0; i < hinges.bodies.size(); ++i) {
    CHECK((hinges.bodies[i].center_pose.translation - balls.bodies[i].center_pose.translation)
              .norm() < 1e-8);
  }
  for (std::size_t i = 0; i < hinges.impulses.size(); ++i) {
    CHECK((hinges.impulses[i].force - balls.impulses[i].force).norm() < 1e-6);
    CHECK(hinges.impulses[i].torque.norm() < 1e-10);
  }
}

TEST_CASE("MechanismIntegrator: a hinge on a spinning carrier turns freely about its own axis") {
  // A carrier spins about z; on it, at its centre, a disk about an axis across. Without friction
  // the disk keeps its rate about that axis, and the joint turns its angular momentum around:
  // w x L = w I s about the third axis.
  Mechanism<double> m;
  m.gravity.setZero();
  const double w = 3, spin = 40;
  m.add_fixed();
  m.bodies[0].twist.angular = {0, 0, w};
  const V inertia(0.02, 0.01, 0.01);
  m.add(1.5, inertia.asDiagonal(), V::Zero());
  m.bodies[1].twist.angular = {spin, 0, w};
  m.join(JointKind::revolute, 0, 1, V::Zero());
  const double dt = 1.0 / 240;
  for (int i = 1; i <= 60; ++i) {
    REQUIRE(m.step(dt));
    const double t = dt * i;
    const V out(std::cos(w * t), std::sin(w * t), 0);
    CHECK((m.bodies[1].twist.angular - V(spin * out + w * V::UnitZ())).norm() < 1e-6 * spin);
    // The torque turns with the carrier: its mean over a step is at the middle of it.
    const double middle = w * (t - dt / 2);
    const V about(-std::sin(middle), std::cos(middle), 0);
    CHECK((m.impulses[0].torque - dt * w * inertia.x() * spin * about).norm() <
          1e-4 * dt * w * inertia.x() * spin);
  }
}

TEST_CASE("MechanismIntegrator: a parallelogram of hinges swings like the pendulum it is") {
  // Two cranks of 1 kg and 0.2 m, and a coupler of 2 kg that does not turn. One motion is free and
  // 20 rows hold 18 unknowns: three rows too many, which must do no harm. Moments about the pivots
  // 2 (I + m l^2/4) + M l^2, torque (2 m l/2 + M l) g sin.
  Mechanism<double> m;
  const double l = 0.2, angle = 1.0;
  const V down(std::sin(angle), 0, -std::cos(angle)), y = V::UnitY();
  const double turn = angle - std::numbers::pi / 2;  // About -y from x.
  const Quat<double> tilt = exp_rotation<double>({0, -turn, 0});
  m.add_fixed();
  m.add_fixed({1, 0, 0});
  const std::uint32_t left = m.add(1, test::link_inertia<double>(), l / 2 * down, tilt);
  const std::uint32_t right =
      m.add(1, test::link_inertia<double>(), V(1, 0, 0) + l / 2 * down, tilt);
  const std::uint32_t coupler = m.add(2, V(0.001, 0.2, 0.2).asDiagonal(), V(0.5, 0, 0) + l * down);
  m.join(JointKind::revolute, 0, left, V::Zero(), y);
  m.join(JointKind::revolute, 1, right, V(1, 0, 0), y);
  m.join(JointKind::revolute, left, coupler, l * down, y);
  m.join(JointKind::revolute, right, coupler, V(1, 0, 0) + l * down, y);
  const double inertia = 2 * (0.0104 / 3 + l * l / 4) + 2 * l * l;
  const double w0 = std::sqrt((l + 2 * l) * g / inertia);
  const double period = test::pendulum_period(w0, angle);
  REQUIRE(m.run(period / 2, period / 200));
  const V other(-down.x(), 0, down.z());
  CHECK((m.bodies[coupler].center_pose.translation - (V(0.5, 0, 0) + l * other)).norm() < 1e-6);
  CHECK(m.bodies[coupler].twist.linear.norm() < 1e-5);
  CHECK(m.largest_gap() < 1e-9);
  CHECK(m.largest_tilt() < 1e-9);
}
