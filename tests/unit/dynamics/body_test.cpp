// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/dynamics/bodies/body.hpp>

#include <doctest/doctest.h>

using namespace bristle;

namespace {

/// Unit-density properties of a brick of 1 x 2 x 3 m.
template <typename S>
MassProperties<S> brick() {
  return {S(6), Vec3<S>::Zero(), Mat3<S>(Vec3<S>(S(6.5), S(5), S(2.5)).asDiagonal())};
}

}  // namespace

TEST_CASE_TEMPLATE("make_body: mass from the shape's volume, or inertia scaled to a given mass", S,
                   float, double) {
  BodyDef<S> def;
  def.density = S(2);
  const Body<S> dense = make_body(def, brick<S>());
  CHECK(dense.mass == S(12));
  CHECK(dense.inverse_mass == S(1) / S(12));
  CHECK(dense.inertia_B.isApprox(S(2) * brick<S>().inertia));
  def.mass = S(3);
  const Body<S> light = make_body(def, brick<S>());
  CHECK(light.mass == S(3));
  CHECK(light.inertia_B.isApprox(S(0.5) * brick<S>().inertia));
  CHECK((light.inertia_B * light.inverse_inertia_B).isApprox(Mat3<S>::Identity()));
}

TEST_CASE_TEMPLATE("make_body: a shifted centre of mass adds Steiner's part", S, float, double) {
  BodyDef<S> def;
  def.mass = S(3);
  def.center_of_mass = Vec3<S>(1, 0, 0);
  def.position = {0, 0, 5};
  const Body<S> body = make_body(def, brick<S>());
  CHECK(body.inertia_B.isApprox(S(0.5) * brick<S>().inertia +
                                Mat3<S>(Vec3<S>(0, 3, 3).asDiagonal())));
  CHECK(body.center_pose.translation == Vec3<S>(1, 0, 5));
  CHECK(body.pose().translation.isApprox(Vec3<S>(0, 0, 5)));
}

TEST_CASE_TEMPLATE("make_body: fixed and kinematic bodies have no inverse mass", S, float, double) {
  BodyDef<S> def;
  def.motion = Motion::kinematic;
  def.velocity = {1, 2, 3};
  const Body<S> kinematic = make_body(def, MassProperties<S>{});
  CHECK(kinematic.inverse_mass == S(0));
  CHECK(kinematic.inverse_inertia_B == Mat3<S>::Zero());
  CHECK(kinematic.twist.linear == Vec3<S>(1, 2, 3));
  CHECK_FALSE(kinematic.is_dynamic());
  def.motion = Motion::fixed;
  CHECK(make_body(def, MassProperties<S>{}).twist.linear == Vec3<S>::Zero());
}

TEST_CASE("Body: energy and angular momentum do not depend on the frame they are written in") {
  test::Random random(1);
  BodyDef<double> def;
  def.mass = 2;
  Body<double> body = make_body(def, brick<double>());
  const Vec3<double> w_B(0.3, -0.5, 0.7);
  body.twist = {{1, 2, 2}, w_B};
  const double energy = body.kinetic_energy();
  CHECK(energy == test::relative(9 + 0.5 * w_B.dot(body.inertia_B * w_B)));
  const Quat<double> R = random.rotation<double>();
  const Vec3<double> L = body.angular_momentum();
  body.center_pose.rotation = R;
  body.twist.angular = R * w_B;
  CHECK(body.kinetic_energy() == test::relative(energy).epsilon(1e-12));
  CHECK((body.angular_momentum() - R * L).norm() < 1e-14);
  CHECK((body.inverse_inertia_W() * body.angular_momentum() - body.twist.angular).norm() < 1e-14);
}

TEST_CASE("Body: set_pose moves the centre of mass with the body frame") {
  test::Random random(2);
  BodyDef<double> def;
  def.mass = 1;
  def.center_of_mass = Vec3<double>(0.1, 0.2, 0.3);
  Body<double> body = make_body(def, brick<double>());
  const Transform<double> X = random.pose(1.0);
  body.set_pose(X);
  CHECK((body.center_pose.translation - X * *def.center_of_mass).norm() < 1e-15);
  CHECK((body.pose().translation - X.translation).norm() < 1e-15);
}
