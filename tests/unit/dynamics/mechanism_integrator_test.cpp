// SPDX-License-Identifier: BSD-3-Clause
#include "support/mechanism.hpp"
#include "support/numbers.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <numbers>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::g;
using test::Mechanism;
using V = Vec3<double>;

TEST_CASE("MechanismIntegrator: a pendulum keeps its period at large swings") {
  // A bob that counts as a point, and a rod about its end; both start 120 degrees from hanging.
  for (const bool is_point : {true, false}) {
    CAPTURE(is_point);
    Mechanism<double> m;
    m.add_fixed();
    const double arm = 0.5, angle = 2 * std::numbers::pi / 3;
    const V along(std::sin(angle), 0, -std::cos(angle));
    const double inertia = is_point ? 1e-9 : 0.02;
    m.add(2, inertia * Mat3<double>::Identity(), arm * along);
    m.join(JointKind::ball, 0, 1, V::Zero());
    const double w0 = std::sqrt(2 * g * arm / (inertia + 2 * arm * arm));
    const double period = test::pendulum_period(w0, angle);
    REQUIRE(m.run(period / 2, period / 400));
    const V other(-along.x(), 0, along.z());
    CHECK((m.bodies[1].center_pose.translation - arm * other).norm() < 1e-8);
    CHECK(m.bodies[1].twist.linear.norm() < 1e-6);
    REQUIRE(m.run(period / 2, period / 400));
    CHECK((m.bodies[1].center_pose.translation - arm * along).norm() < 1e-8);
  }
}

/// A chain of ball joints, of hinges in a plane, and of hinges that each are turned from the last.
struct ChainKind {
  JointKind kind;
  double turn;
};
constexpr ChainKind chain_kinds[] = {
    {JointKind::ball, 0}, {JointKind::revolute, 0}, {JointKind::revolute, 0.6}};

TEST_CASE("MechanismIntegrator: swinging chains keep their energy") {
  struct Bar {
    int links;
    double rate, seconds, error;
  };
  for (const ChainKind& kind : chain_kinds) {
    // Chain of ten at 1/60: adaptive substeps, whose errors the whip of the chain multiplies.
    for (const Bar& bar :
         {Bar{2, 60, 10, 2.1e-3}, Bar{2, 240, 10, 2e-6}, Bar{2, 1000, 10, 1e-9},
          Bar{10, 60, 10, 6e-3}, Bar{10, 240, 10, 1e-3}, Bar{10, 1000, 3, 1.1e-5}}) {
      CAPTURE(kind.turn);
      CAPTURE(bar.links);
      CAPTURE(bar.rate);
      auto m = test::chain<double>(bar.links, true, kind.kind, kind.turn);
      CHECK(test::chain_energy_error(m, bar.links, bar.seconds, 1 / bar.rate) < bar.error);
      CHECK(m.largest_gap() < 1e-9);
      CHECK(m.largest_tilt() < 1e-9);
    }
  }
}

TEST_CASE("MechanismIntegrator: works in float") {
  for (const ChainKind& kind : chain_kinds) {
    auto m = test::chain<float>(10, true, kind.kind, static_cast<float>(kind.turn));
    CHECK(test::chain_energy_error(m, 10, 3, 1.0 / 240) < 1e-3);
    CHECK(m.largest_gap() < 1e-4f);
    CHECK(m.largest_tilt() < 1e-4f);
  }
}

// A chain of balls, and one of hinges each of which is turned from the one before.
TEST_CASE("MechanismIntegrator: one substep a step is of fifth order") {
  for (const JointKind kind : {JointKind::ball, JointKind::revolute}) {
    const auto tip_after = [&](double dt) {
      auto m = kind == JointKind::ball ? test::chain<double>(2)
                                       : test::chain<double>(3, true, kind, 0.6);
      m.integrator = MechanismIntegrator<double>(1e6);
      REQUIRE(m.run(0.4, dt));
      return m.bodies.back().center_pose.translation;
    };
    const V exact = tip_after(0.4 / 640);
    const double coarse = (tip_after(0.4 / 40) - exact).norm();
    const double fine = (tip_after(0.4 / 80) - exact).norm();
    CHECK(std::log2(coarse / fine) > 4.5);
    CHECK(coarse < 1e-4);
  }
}

TEST_CASE("MechanismIntegrator: a free chain keeps its momenta in every step") {
  for (const JointKind kind : {JointKind::ball, JointKind::revolute}) {
    auto m = test::chain<double>(6, false, kind, kind == JointKind::ball ? 0.0 : 0.6);
    for (MechanismBody<double>& body : m.bodies) body.load = {};
    m.bodies[0].twist = {V(1, -2, 0.5), V(3, 8, -5)};
    m.bodies[4].twist = {V(0.2, 1, 3), V(-4, 1, 6)};
    REQUIRE(m.step(1.0 / 60));  // The jolt that makes velocities what joints allow.
    const double energy = m.energy();
    for (int i = 0; i < 240; ++i) {
      const Wrench<double> before = m.momentum();
      REQUIRE(m.step(1.0 / 60));
      const Wrench<double> after = m.momentum();
      CHECK((after.force - before.force).norm() < 1e-12 * before.force.norm());
      CHECK((after.torque - before.torque).norm() < 1e-12 * before.torque.norm());
    }
    if (kind == JointKind::revolute) {
      CHECK(m.energy() == test::relative(energy).epsilon(1e-2));
      CHECK(m.largest_tilt() < 1e-9);
    }
  }
}

TEST_CASE("MechanismIntegrator: loads give a free chain the momentum they should") {
  auto m = test::chain<double>(4, false);
  m.bodies[3].load.force += V(0, 5, 0);
  m.bodies[1].load.torque = V(0.1, 0.2, -0.3);
  Wrench<double> expected = m.momentum();
  const double dt = 1.0 / 2000;
  for (int i = 0; i < 1000; ++i) {
    // Trapezoidal rule for the torque of the forces: errors of dt^2 / 12 times its slope.
    for (int half = 0; half < 2; ++half) {
      for (const MechanismBody<double>& body : m.bodies) {
        expected.force += dt / 2 * body.load.force;
        expected.torque +=
            dt / 2 * (body.load.torque + body.center_pose.translation.cross(body.load.force));
      }
      if (half == 0) REQUIRE(m.step(dt));
    }
  }
  CHECK((m.momentum().force - expected.force).norm() < 1e-11);
  CHECK((m.momentum().torque - expected.torque).norm() < 1e-5 * expected.torque.norm());
}

TEST_CASE("MechanismIntegrator: a slider on a spinning carrier flies outwards as it must") {
  Mechanism<double> m;
  m.gravity.setZero();
  const double w = 3, start = 0.2;
  m.add_fixed();
  m.bodies[0].twist.angular = {0, 0, w};
  m.add(1.5, V(0.01, 0.02, 0.03).asDiagonal(), {start, 0, 0});
  m.bodies[1].twist = {V(0, w * start, 0), V(0, 0, w)};
  m.join(JointKind::prismatic, 0, 1, V::Zero());
  const double dt = 1.0 / 120;
  for (int i = 1; i <= 60; ++i) {
    const V before = m.bodies[1].twist.linear;
    REQUIRE(m.step(dt));
    // r'' = w^2 r from rest; the rail pushes across itself alone.
    const double t = dt * i, r = start * std::cosh(w * t), v = start * w * std::sinh(w * t);
    const V out(std::cos(w * t), std::sin(w * t), 0), across(-out.y(), out.x(), 0);
    const MechanismBody<double>& body = m.bodies[1];
    CHECK((body.center_pose.translation - r * out).norm() < 1e-9 * r);
    CHECK((body.twist.linear - (v * out + w * r * across)).norm() < 1e-8 * w * r);
    CHECK((m.impulses[0].force - 1.5 * (body.twist.linear - before)).norm() < 1e-12);
  }
  CHECK((m.bodies[0].center_pose.rotation.angularDistance(exp_rotation<double>({0, 0, w * 0.5}))) <
        1e-12);
}

TEST_CASE("MechanismIntegrator: two bodies fixed to each other move as one") {
  const Quat<double> tilt = exp_rotation<double>({0.4, -0.3, 0.9});
  Mechanism<double> two, one;
  const V first(0.1, 0.2, 0), second(0.4, -0.1, 0.3);
  const Mat3<double> inertia_1 = V(0.02, 0.03, 0.04).asDiagonal();
  const Mat3<double> inertia_2 = V(0.05, 0.03, 0.03).asDiagonal();
  two.add(1, inertia_1, first);
  two.add(2, inertia_2, second, tilt);
  two.join(JointKind::fixed, 0, 1, V(0.3, 0.3, 0.3));
  const V center = (first + 2 * second) / 3;
  const Mat3<double> R = tilt.toRotationMatrix();
  one.add(3,
          inertia_1 + R * inertia_2 * R.transpose() + point_inertia<double>(1, first - center) +
              point_inertia<double>(2, second - center),
          center);
  const Twist<double> twist{V(1, 0, 0), V(2, -5, 3)};
  one.bodies[0].twist = twist;
  two.bodies[0].twist = twist.shifted(first - center);
  two.bodies[1].twist = twist.shifted(second - center);
  REQUIRE(one.run(1, 1.0 / 240));
  REQUIRE(two.run(1, 1.0 / 240));
  const Transform<double>& X = one.bodies[0].center_pose;
  CHECK((two.bodies[0].center_pose.translation - X * V(first - center)).norm() < 1e-7);
  CHECK((two.bodies[1].center_pose.translation - X * V(second - center)).norm() < 1e-7);
  CHECK(two.bodies[0].center_pose.rotation.angularDistance(X.rotation) < 1e-6);
  CHECK(two.bodies[1].center_pose.rotation.angularDistance(X.rotation * tilt) < 1e-6);
}

TEST_CASE("MechanismIntegrator: the joints of a hanging chain carry what hangs below them") {
  Mechanism<double> m;
  m.add_fixed();
  const double dt = 1.0 / 60;
  for (std::uint32_t i = 1; i <= 10; ++i) {
    m.add(1, test::link_inertia<double>(), {0, 0, -0.2 * i + 0.1});
    m.join(JointKind::ball, i - 1, i, {0, 0, -0.2 * i + 0.2});
  }
  REQUIRE(m.run(1, dt));
  for (std::size_t i = 0; i < 10; ++i) {
    const double below = static_cast<double>(10 - i);
    CHECK((m.impulses[i].force - V(0, 0, below * g * dt)).norm() < 1e-10);
    CHECK(m.impulses[i].torque == V::Zero());
  }
  CHECK(m.bodies[10].twist.linear.norm() < 1e-12);
}

TEST_CASE("MechanismIntegrator: a stone on a string is held by its centripetal force") {
  Mechanism<double> m;
  m.gravity.setZero();
  m.add_fixed();
  m.add(2, 0.01 * Mat3<double>::Identity(), {0.5, 0, 0});
  m.bodies[1].twist = {V(0, 2, 0), V(0, 0, 4)};
  m.join(JointKind::ball, 0, 1, V::Zero());
  const double dt = 0.01;
  REQUIRE(m.step(dt));
  // m w^2 r = 16 N towards the centre, turning by w dt about its middle: a chord of that arc.
  const double half = 4 * dt / 2;
  const V towards(-std::cos(half), -std::sin(half), 0);
  CHECK((m.impulses[0].force - 2 * 2 * 2 * std::sin(half) * towards).norm() < 1e-9);
}

TEST_CASE("MechanismIntegrator: velocities that joints do not allow are closed at the start") {
  Mechanism<double> m;
  m.gravity.setZero();
  m.add_fixed();
  m.add(2, 0.01 * Mat3<double>::Identity(), {0.5, 0, 0});
  m.bodies[1].twist.linear = {3, 0, 0};  // Straight away from the joint.
  m.join(JointKind::ball, 0, 1, V::Zero());
  REQUIRE(m.step(0.01));
  CHECK((m.impulses[0].force - V(-6, 0, 0)).norm() < 1e-12);
  CHECK(m.bodies[1].twist.linear.norm() < 1e-12);
}

TEST_CASE("MechanismIntegrator: gaps are closed by the shortest motion, which leaves no speed") {
  Mechanism<double> m;
  m.gravity.setZero();
  m.add(1, Mat3<double>::Identity(), {0, 0, 0});
  m.add(3, Mat3<double>::Identity(), {1, 0, 0});
  m.join(JointKind::fixed, 0, 1, {0.5, 0, 0});
  m.bodies[1].center_pose.translation.x() = 1.04;
  REQUIRE(m.step(0.01));
  CHECK(m.bodies[0].center_pose.translation.x() == test::relative(0.03));
  CHECK(m.bodies[1].center_pose.translation.x() == test::relative(1.03));
  CHECK(m.bodies[1].twist.linear.norm() < 1e-13);
}

TEST_CASE("MechanismIntegrator: a parallelogram of ball joints swings like the pendulum it is") {
  // Two cranks of 1 kg and 0.2 m, and a coupler of 2 kg that does not turn: two loops' worth of
  // joints. Moments about the pivots 2 (I + m l^2/4) + M l^2, torque (2 m l/2 + M l) g sin.
  Mechanism<double> m;
  const double l = 0.2, angle = 1.0;
  const V down(std::sin(angle), 0, -std::cos(angle));
  const double turn = angle - std::numbers::pi / 2;  // About -y from x.
  const Quat<double> tilt = exp_rotation<double>({0, -turn, 0});
  m.add_fixed();
  m.add_fixed({1, 0, 0});
  const std::uint32_t left = m.add(1, test::link_inertia<double>(), l / 2 * down, tilt);
  const std::uint32_t right =
      m.add(1, test::link_inertia<double>(), V(1, 0, 0) + l / 2 * down, tilt);
  const std::uint32_t coupler = m.add(2, V(0.001, 0.2, 0.2).asDiagonal(), V(0.5, 0, 0) + l * down);
  m.join(JointKind::ball, 0, left, V::Zero());
  m.join(JointKind::ball, 1, right, V(1, 0, 0));
  m.join(JointKind::ball, left, coupler, l * down);
  m.join(JointKind::ball, right, coupler, V(1, 0, 0) + l * down);
  const double inertia = 2 * (0.0104 / 3 + l * l / 4) + 2 * l * l;
  const double w0 = std::sqrt((l + 2 * l) * g / inertia);
  const double period = test::pendulum_period(w0, angle);
  REQUIRE(m.run(period / 2, period / 200));
  const V other(-down.x(), 0, down.z());
  CHECK((m.bodies[coupler].center_pose.translation - (V(0.5, 0, 0) + l * other)).norm() < 1e-6);
  CHECK(m.bodies[coupler].twist.linear.norm() < 1e-5);
  CHECK(m.largest_gap() < 1e-9);
}

TEST_CASE("MechanismIntegrator: joints that hold more than there is share the load") {
  // A beam welded to two walls: six rows too many. By symmetry each wall carries half.
  Mechanism<double> m;
  m.add_fixed({-1, 0, 0});
  m.add_fixed({1, 0, 0});
  m.add(4, Mat3<double>::Identity(), V::Zero());
  m.join(JointKind::fixed, 0, 2, {-1, 0, 0});
  m.join(JointKind::fixed, 1, 2, {1, 0, 0});
  REQUIRE(m.run(1, 1.0 / 60));
  CHECK((m.impulses[0].force - V(0, 0, 2 * g / 60)).norm() < 1e-6);
  CHECK((m.impulses[1].force - V(0, 0, 2 * g / 60)).norm() < 1e-6);
  CHECK((m.impulses[0].force + m.impulses[1].force - V(0, 0, 4 * g / 60)).norm() < 1e-12);
  CHECK(m.bodies[2].center_pose.translation.norm() < 1e-12);
}

TEST_CASE("MechanismIntegrator: fingers on slides take one evaluation and are exact") {
  Mechanism<double> m;
  m.add_fixed({0, 0, 1});
  m.bodies[0].twist.linear = {0, 0.3, 0};
  m.add(0.5, V(0.01, 0.02, 0.03).asDiagonal(), {0.2, 0, 1});
  m.bodies[1].twist.linear = {0.1, 0.3, 0};
  m.bodies[1].load.force += V(2, 0, 0);
  m.join(JointKind::prismatic, 0, 1, {0, 0, 1});
  const double dt = 0.25;
  REQUIRE(m.step(dt));
  CHECK(m.integrator.evaluations() == 1);
  CHECK(m.integrator.substeps() == 0);
  const MechanismBody<double>& finger = m.bodies[1];
  CHECK((finger.center_pose.translation - V(0.2 + 0.1 * dt + 2 * dt * dt, 0.3 * dt, 1)).norm() <
        1e-15);
  CHECK((finger.twist.linear - V(0.1 + 4 * dt, 0.3, 0)).norm() < 1e-15);
  CHECK(finger.twist.angular == V::Zero());
  // The rail carries the weight, and its moment about B's joint origin 0.2 m behind the finger:
  // on B the weight turns about +y, the rail against it.
  CHECK((m.impulses[0].force - V(0, 0, 0.5 * g * dt)).norm() < 1e-14);
  CHECK((m.impulses[0].torque - V(0, -0.2 * 0.5 * g * dt, 0)).norm() < 1e-14);
}

TEST_CASE("MechanismIntegrator: a carrier in uniform motion changes nothing") {
  const V velocity(30, -20, 10);
  auto still = test::chain<double>(3);
  auto moving = test::chain<double>(3);
  for (MechanismBody<double>& body : moving.bodies) body.twist.linear = velocity;
  REQUIRE(still.run(1, 1.0 / 60));
  REQUIRE(moving.run(1, 1.0 / 60));
  for (std::size_t i = 0; i < 4; ++i) {
    const V from_carrier = moving.bodies[i].center_pose.translation - velocity;
    CHECK((from_carrier - still.bodies[i].center_pose.translation).norm() < 1e-10);
  }
}

TEST_CASE(
    "MechanismIntegrator: locked axes give the planar motion that is there anyway, and no other") {
  auto free = test::chain<double>(3);
  auto planar = test::chain<double>(3);
  for (MechanismBody<double>& body : planar.bodies) {
    if (body.moves_by_forces) body.locked = {{false, true, false}, {true, false, true}};
  }
  REQUIRE(free.run(1, 1.0 / 240));
  REQUIRE(planar.run(1, 1.0 / 240));
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(
        (free.bodies[i].center_pose.translation - planar.bodies[i].center_pose.translation).norm() <
        1e-9);
  }
  planar.bodies[2].load.force.y() = 100;
  REQUIRE(planar.run(1, 1.0 / 240));
  for (std::size_t i = 1; i < 4; ++i) {
    CHECK(planar.bodies[i].center_pose.translation.y() == 0);
    CHECK(planar.bodies[i].twist.angular.x() == 0);
  }
}

TEST_CASE("MechanismIntegrator: what cannot be advanced is refused and nothing is written") {
  const auto refuses = [](const Mechanism<double>& start) {
    Mechanism<double> m = start;
    std::vector<Transform<double>> poses(m.bodies.size());
    std::vector<Twist<double>> twists(m.bodies.size());
    std::vector<Wrench<double>> impulses(m.joints.size());
    for (Transform<double>& pose : poses) pose.translation = {7, 7, 7};
    const bool done = m.integrator.advance(m.bodies, m.joints, 0.01, poses, twists, impulses);
    return !done && poses[1].translation == V(7, 7, 7) && impulses[0].force == V::Zero();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto chain = test::chain<double>(3);
  chain.bodies[2].twist.angular.y() = nan;
  CHECK(refuses(chain));
  chain = test::chain<double>(3);
  chain.bodies[2].center_pose.translation.x() = infinity<double>;
  CHECK(refuses(chain));
  chain = test::chain<double>(3);
  chain.bodies[1].load.force.z() = nan;
  CHECK(refuses(chain));
  chain = test::chain<double>(3);
  // Too fast for the substeps that a step may take.
  for (MechanismBody<double>& body : chain.bodies) body.twist.angular.y() = 1e6;
  CHECK(refuses(chain));
  // A finger whose rail wants it to move where it is locked.
  Mechanism<double> stuck;
  stuck.add_fixed();
  stuck.bodies[0].twist.linear = {0, 1, 0};
  stuck.add(1, Mat3<double>::Identity(), {0.1, 0, 0});
  stuck.bodies[1].locked = {{false, true, true}, {true, true, true}};
  stuck.join(JointKind::prismatic, 0, 1, V::Zero());
  CHECK(refuses(stuck));
}
