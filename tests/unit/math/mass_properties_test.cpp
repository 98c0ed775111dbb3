// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/math/mass_properties.hpp>

#include <doctest/doctest.h>

using namespace bristle;

TEST_CASE_TEMPLATE("MassProperties: two point masses make a dumbbell", S, float, double) {
  const MassProperties<S> a{S(1), Vec3<S>(-1, 0, 0), Mat3<S>::Zero()};
  const MassProperties<S> b{S(3), Vec3<S>(1, 0, 0), Mat3<S>::Zero()};
  const MassProperties<S> sum = a + b;
  CHECK(sum.mass == S(4));
  CHECK(sum.center.isApprox(Vec3<S>(S(0.5), 0, 0)));
  // Reduced mass 3/4 times distance squared 4.
  CHECK(sum.inertia.isApprox(Mat3<S>(Vec3<S>(0, 3, 3).asDiagonal())));
  CHECK((MassProperties<S>{} + MassProperties<S>{}).mass == S(0));
}

TEST_CASE("MassProperties: adding commutes with moving") {
  test::Random random(1);
  for (int i = 0; i < 20; ++i) {
    const auto any = [&] {
      const Mat3<double> R = random.rotation<double>().toRotationMatrix();
      const Mat3<double> I = R * Vec3<double>(2, 3, 4).asDiagonal() * R.transpose();
      return MassProperties<double>{random.uniform(0.5, 2.0), random.in_cube(1.0), I};
    };
    const MassProperties<double> a = any();
    const MassProperties<double> b = any();
    const Transform<double> X = random.pose(1.0);
    const MassProperties<double> moved = (a + b).transformed(X);
    const MassProperties<double> parts = a.transformed(X) + b.transformed(X);
    CHECK((moved.center - parts.center).norm() < 1e-14);
    CHECK((moved.inertia - parts.inertia).norm() < 1e-13);
    CHECK(a.scaled(2).inertia.isApprox(2 * a.inertia));
    CHECK(a.scaled(2).mass == 2 * a.mass);
  }
}

TEST_CASE_TEMPLATE("point_inertia: m (r^2 - r r^T)", S, float, double) {
  CHECK(point_inertia<S>(S(2), {3, 0, 0}).isApprox(Mat3<S>(Vec3<S>(0, 18, 18).asDiagonal())));
}
