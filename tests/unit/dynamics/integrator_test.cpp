// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/bodies/integrator.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

namespace {

template <typename S>
Body<S> body_of(const Vec3<S>& moments) {
  BodyDef<S> def;
  def.mass = S(2);
  def.inertia = Mat3<S>(moments.asDiagonal());
  return make_body(def, MassProperties<S>{});
}

}  // namespace

TEST_CASE_TEMPLATE("free_twist: gravity and applied wrench for one step", S, float, double) {
  Body<S> body = body_of<S>({1, 2, S(2.5)});
  body.gravity_scale = S(0.5);
  body.applied = {{4, 0, 0}, {0, 4, 0}};
  const Twist<S> t = free_twist(body, Vec3<S>(0, 0, -8), decay_of(body, S(0.25)));
  CHECK(t.linear == Vec3<S>(S(0.5), 0, -1));
  CHECK(t.angular == Vec3<S>(0, S(0.5), 0));
  body.motion = Motion::kinematic;
  body.twist.linear = {7, 0, 0};
  CHECK(free_twist(body, Vec3<S>(0, 0, -8), decay_of(body, S(0.25))).linear == Vec3<S>(7, 0, 0));
}

TEST_CASE_TEMPLATE("step_pose: moves by the motion it is given, and velocities stay", S, float,
                   double) {
  Body<S> body = body_of<S>({1, 1, 1});
  body.twist = {{1, 0, 0}, {0, 0, 0}};
  step_pose(body, {{1, 2, 0}, {0, 0, 1}}, S(0.5));
  CHECK(body.center_pose.translation == Vec3<S>(S(0.5), 1, 0));
  CHECK(body.twist.linear == Vec3<S>(1, 0, 0));
  CHECK(body.twist.angular == Vec3<S>::Zero());
  CHECK((log_rotation<S>(body.center_pose.rotation) - Vec3<S>(0, 0, S(0.5))).norm() <
        S(4) * Tolerance<S>::round_off());
}

TEST_CASE_TEMPLATE("step_pose: an own momentum other than the motion's is kept all the same", S,
                   float, double) {
  Body<S> body = body_of<S>({1, 2, 3});
  body.twist.angular = {S(0.5), S(-1), S(2)};
  const Vec3<S> L = body.angular_momentum();
  step_pose(body, {Vec3<S>::Zero(), Vec3<S>(1, 1, S(0.5))}, S(0.1));
  CHECK((body.angular_momentum() - L).norm() < S(8) * Tolerance<S>::round_off() * L.norm());
}

TEST_CASE_TEMPLATE("step_pose: a symmetric top precesses about its momentum", S, float, double) {
  // Moments A, A, C: the axis goes round L at |L| / A.
  Body<S> body = body_of<S>({2, 2, 3});
  body.twist.angular = {S(0.3), 0, 1};
  const Vec3<S> L = body.angular_momentum();
  const double rate = static_cast<double>(L.norm()) / 2;
  const int steps = 400;
  const double period = 2 * 3.14159265358979 / rate;
  for (int i = 0; i < steps; ++i) step_pose(body, body.twist, S(period / steps));
  // After one period the axis is back.
  const Vec3<S> axis = body.center_pose.rotation * Vec3<S>(0, 0, 1);
  CHECK((axis - Vec3<S>(0, 0, 1)).norm() < (std::is_same_v<S, double> ? S(1e-7) : S(1e-3)));
  CHECK((body.angular_momentum() - L).norm() < S(steps) * Tolerance<S>::round_off() * L.norm());
}

TEST_CASE_TEMPLATE("step_pose: a ball turns about its axis exactly", S, float, double) {
  Body<S> body = body_of<S>({1, 1, 1});
  const Vec3<S> w(S(0.3), S(-0.4), S(1.2));
  body.twist.angular = w;
  for (int i = 0; i < 10; ++i) step_pose(body, body.twist, S(0.1));
  CHECK((log_rotation<S>(body.center_pose.rotation) - w).norm() <
        S(20) * Tolerance<S>::round_off());
  CHECK(body.twist.angular == w);
}
