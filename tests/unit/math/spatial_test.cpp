// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/math/spatial.hpp>

#include <doctest/doctest.h>

using namespace bristle;

TEST_CASE_TEMPLATE("Twist: the velocity of a point is v + w x r", S, float, double) {
  const Twist<S> twist{{1, 0, 0}, {0, 0, 2}};
  CHECK(twist.at({3, 0, 0}) == Vec3<S>(1, 6, 0));
  CHECK(twist.shifted({3, 0, 0}).linear == Vec3<S>(1, 6, 0));
  CHECK(twist.shifted({3, 0, 0}).angular == twist.angular);
  CHECK((twist - twist).linear == Vec3<S>::Zero());
  CHECK((twist + twist).angular == Vec3<S>(0, 0, 4));
}

TEST_CASE_TEMPLATE("Wrench: a force at a point turns as r x F", S, float, double) {
  const Wrench<S> w = Wrench<S>::at({2, 0, 0}, {0, 3, 0});
  CHECK(w.force == Vec3<S>(0, 3, 0));
  CHECK(w.torque == Vec3<S>(0, 0, 6));
  // About the point where it acts it does not turn.
  CHECK(w.shifted({2, 0, 0}).torque == Vec3<S>::Zero());
  CHECK((-w).force == Vec3<S>(0, -3, 0));
  CHECK((w + w).torque == Vec3<S>(0, 0, 12));
  CHECK((S(2) * w).force == Vec3<S>(0, 6, 0));
}

TEST_CASE("Wrench and Twist: power does not depend on the reference point") {
  test::Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Twist<double> V{random.in_cube(1.0), random.in_cube(1.0)};
    const Wrench<double> F{random.in_cube(1.0), random.in_cube(1.0)};
    const Vec3<double> r = random.in_cube(1.0);
    const auto power = [](const Twist<double>& v, const Wrench<double>& f) {
      return v.linear.dot(f.force) + v.angular.dot(f.torque);
    };
    CHECK(power(V, F) == test::relative(power(V.shifted(r), F.shifted(r))).epsilon(1e-12));
  }
}

TEST_CASE_TEMPLATE("Wrench and Twist: are halves of a vector, as quarters are of a matrix", S,
                   float, double) {
  const Twist<S> twist{{1, 2, 3}, {4, 5, 6}};
  const Vec6<S> v = detail::stacked(twist);
  for (int i = 0; i < 6; ++i) CHECK(v[i] == S(i + 1));
  CHECK(detail::first_half<S>(v) == twist.linear);
  CHECK(detail::twist_of<S>(v).angular == twist.angular);
  CHECK(detail::wrench_of<S>(v).torque == twist.angular);
  CHECK(detail::stacked(Wrench<S>{twist.linear, twist.angular}) == v);
  const Mat6<S> m = v * v.transpose();
  CHECK(detail::quarter<0, 3, S>(m) == twist.linear * twist.angular.transpose());
  Mat6<S> turned = Mat6<S>::Zero();
  detail::set_quarter<3, 0, S>(turned, detail::quarter<0, 3, S>(m));
  CHECK(turned.template bottomLeftCorner<3, 3>() == m.template topRightCorner<3, 3>());
  CHECK(turned.template topRows<3>() == Eigen::Matrix<S, 3, 6>::Zero());
}
