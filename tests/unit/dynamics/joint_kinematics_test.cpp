// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/joints/joint_kinematics.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

namespace {

using V = Vec3<double>;

MechanismJoint<double> joint_of(JointKind kind) {
  MechanismJoint<double> joint;
  joint.kind = kind;
  joint.X_CmA_J = {exp_rotation<double>({0.3, -0.5, 0.2}), V(0.4, 0.1, -0.2)};
  joint.X_CmB_J = {exp_rotation<double>({-0.1, 0.7, 0.4}), V(-0.3, 0.2, 0.25)};
  return joint;
}

/// Bodies that satisfy the joint at t = 0 in position and velocity, moving with constant twists.
struct Pair {
  MechanismJoint<double> joint;
  Transform<double> start_a, start_b;
  Twist<double> twist_a, twist_b;

  [[nodiscard]] static BodyState<double> state(const Transform<double>& start,
                                               const Twist<double>& twist, double t) {
    BodyState<double> body;
    body.x = start.translation + t * twist.linear;
    body.set_axes(step_rotation<double>(start.rotation, twist.angular, t));
    body.twist = twist;
    return body;
  }
  [[nodiscard]] BodyState<double> a(double t) const { return state(start_a, twist_a, t); }
  [[nodiscard]] BodyState<double> b(double t) const { return state(start_b, twist_b, t); }
  [[nodiscard]] JointState<double> at(double t) const { return joint_state(joint, a(t), b(t)); }
};

Pair pair_of(JointKind kind) {
  Pair pair;
  pair.joint = joint_of(kind);
  pair.start_a = {exp_rotation<double>({0.8, 0.1, -0.6}), V(1, 2, 3)};
  pair.twist_a = {V(0.3, -0.2, 0.5), V(1.1, -0.7, 0.9)};
  pair.twist_b.angular = kind == JointKind::ball ? V(-0.4, 1.3, 0.6) : pair.twist_a.angular;
  const double slide = kind == JointKind::prismatic ? 0.35 : 0.0;
  const double turn = kind == JointKind::revolute ? 2.1 : 0.0;
  const Transform<double> X_WJ =
      pair.start_a * pair.joint.X_CmA_J *
      Transform<double>{exp_rotation<double>({turn, 0, 0}), V(slide, 0, 0)};
  if (kind == JointKind::revolute) pair.twist_b.angular += 1.7 * X_WJ.rotate(V::UnitX());
  pair.start_b = X_WJ * pair.joint.X_CmB_J.inverse();
  const JointState<double> at = pair.at(0);
  // B's origin moves with A, plus 0.8 m/s along the slide.
  pair.twist_b.linear =
      pair.twist_a.at(at.arm_a) + 0.8 * at.slide - pair.twist_b.angular.cross(at.arm_b);
  return pair;
}

constexpr JointKind kinds[] = {JointKind::fixed, JointKind::revolute, JointKind::prismatic,
                               JointKind::ball};

}  // namespace

TEST_CASE("joint kinematics: no gap and no velocity where the joint holds") {
  for (const JointKind kind : kinds) {
    CAPTURE(static_cast<int>(kind));
    const Pair pair = pair_of(kind);
    const Twist<double> gap = constraint_error(pair.joint, pair.at(0), pair.a(0), pair.b(0));
    const Twist<double> rate = constraint_velocity(kind, pair.at(0), pair.twist_a, pair.twist_b);
    CHECK(gap.linear.norm() + gap.angular.norm() < 1e-14);
    CHECK(rate.linear.norm() + rate.angular.norm() < 1e-14);
  }
}

TEST_CASE("joint kinematics: the velocity is the rate of the gap") {
  for (const JointKind kind : kinds) {
    CAPTURE(static_cast<int>(kind));
    Pair pair = pair_of(kind);
    pair.twist_b.linear += V(0.2, 0.4, -0.3);  // Breaks what the joint holds.
    pair.twist_b.angular += V(-0.5, 0.1, 0.2);
    const double h = 1e-6;
    const auto gap = [&](double t) {
      const Twist<double> g = constraint_error(pair.joint, pair.at(t), pair.a(t), pair.b(t));
      return Twist<double>{g.linear, g.angular};
    };
    const Twist<double> rate = constraint_velocity(kind, pair.at(0), pair.twist_a, pair.twist_b);
    // Central differences: h^2 from the method, 1e-16 / h from the arithmetic.
    CHECK(((gap(h).linear - gap(-h).linear) / (2 * h) - rate.linear).norm() < 1e-9);
    CHECK(((gap(h).angular - gap(-h).angular) / (2 * h) - rate.angular).norm() < 1e-9);
  }
}

TEST_CASE("joint kinematics: the bias is the rate of the velocity in A's axes") {
  for (const JointKind kind : kinds) {
    CAPTURE(static_cast<int>(kind));
    const Pair pair = pair_of(kind);
    const double h = 1e-6;
    // With constant twists J v' is zero, so what changes is J' v. In A's axes, as the joint holds.
    const auto velocity_A = [&](double t) -> Vec6<double> {
      const Twist<double> held = constraint_velocity(kind, pair.at(t), pair.twist_a, pair.twist_b);
      Vec6<double> both;
      both << pair.a(t).R.transpose() * held.linear, pair.a(t).R.transpose() * held.angular;
      return both;
    };
    const Vec6<double> rate = (velocity_A(h) - velocity_A(-h)) / (2 * h);
    const Twist<double> bias =
        constraint_acceleration_bias(kind, pair.at(0), pair.twist_a, pair.twist_b);
    CHECK((pair.a(0).R * rate.head<3>() - bias.linear).norm() < 1e-9);
    CHECK((pair.a(0).R * rate.tail<3>() - bias.angular).norm() < 1e-9);
    CHECK(bias.linear.norm() > 0.1);  // There is something to get wrong.
    if (kind == JointKind::revolute) CHECK(bias.angular.norm() > 0.1);
  }
}

TEST_CASE_TEMPLATE("BodyState: axes do not depend on the length of the quaternion", S, float,
                   double) {
  const Quat<S> q = exp_rotation<S>({S(0.3), S(-1.2), S(0.7)});
  BodyState<S> body;
  body.set_axes(Quat<S>(typename Quat<S>::Coefficients(S(1.7) * q.coeffs())));
  CHECK((body.R - q.toRotationMatrix()).norm() < Tolerance<S>::round_off());
}
