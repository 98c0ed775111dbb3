// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/math/transform.hpp>

#include <doctest/doctest.h>

using namespace bristle;
using namespace bristle::detail;

TEST_CASE_TEMPLATE("Transform: composes, inverts and acts on points and vectors", S, float,
                   double) {
  test::Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Transform<S> X_AB = random.pose(S(1));
    const Transform<S> X_BC = random.pose(S(1));
    const Vec3<S> p = random.in_cube(S(1));
    const S eps = S(2) * Tolerance<S>::round_off();
    CHECK((X_AB * X_BC * p - X_AB * Vec3<S>(X_BC * p)).norm() < eps);
    CHECK((X_AB.inverse() * Vec3<S>(X_AB * p) - p).norm() < eps);
    CHECK((X_AB.rotate(p) - X_AB.rotation_matrix() * p).norm() < eps);
    CHECK((X_AB.rotate(p) - (X_AB * p - X_AB.translation)).norm() < eps);
    const Transform<S> X_BC2 = relative_pose(X_AB, Transform<S>(X_AB * X_BC));
    CHECK((X_BC2.translation - X_BC.translation).norm() < eps);
    CHECK((X_BC2.rotation_matrix() - X_BC.rotation_matrix()).norm() < eps);
  }
  CHECK(Transform<S>{} * Vec3<S>(1, 2, 3) == Vec3<S>(1, 2, 3));
}

TEST_CASE("relative_pose: loses nothing far from the origin") {
  Transform<float> X_WA, X_WB;
  X_WA.translation = {1000, 2000, -500};
  X_WB.translation = X_WA.translation + Vec3<float>(0.25F, 0.5F, -0.125F);
  CHECK(relative_pose(X_WA, X_WB).translation == Vec3<float>(0.25F, 0.5F, -0.125F));
}

TEST_CASE("Transform: casts between scalars") {
  test::Random random(2);
  const Transform<double> X = random.pose(1.0);
  const Transform<double> back = X.cast<float>().cast<double>();
  CHECK((back.translation - X.translation).norm() < 1e-6);
  CHECK((back.rotation.coeffs() - X.rotation.coeffs()).norm() < 1e-6);
}
