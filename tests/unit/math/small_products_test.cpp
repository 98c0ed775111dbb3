// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/math/small_products.hpp>

#include <doctest/doctest.h>

#include <limits>

using namespace bristle;

TEST_CASE_TEMPLATE("product: M v", S, float, double) {
  Mat3<S> M;
  M << S(1), S(2), S(3), S(4), S(5), S(6), S(7), S(8), S(10);
  // Small whole numbers: exact.
  CHECK(product<S>(M, Vec3<S>(1, -2, 3)) == Vec3<S>(6, 12, 21));
}

TEST_CASE_TEMPLATE("rotated: R M R^T of a symmetric M", S, float, double) {
  Mat3<S> M;
  M << S(3), S(0.5), S(-0.25), S(0.5), S(2), S(0.125), S(-0.25), S(0.125), S(1);
  const Mat3<S> R = Quat<S>(S(0.5), S(-0.1), S(0.7), S(0.3)).normalized().toRotationMatrix();
  const Mat3<S> difference = rotated<S>(R, M) - R * M * R.transpose();
  // Entries of order 3, sums of nine products.
  CHECK(difference.cwiseAbs().maxCoeff() < S(3) * Tolerance<S>::round_off());
  CHECK(rotated<S>(R, M) == rotated<S>(R, M).transpose());
}

TEST_CASE_TEMPLATE("all_finite: finds an infinite or undefined component in any place", S, float,
                   double) {
  const S most = std::numeric_limits<S>::max();
  CHECK(all_finite<S>(Vec3<S>(most, -most, most)));
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (const S bad : {infinity<S>, -infinity<S>, std::numeric_limits<S>::quiet_NaN()}) {
      Vec3<S> v(1, 2, 3);
      v[i] = bad;
      CHECK_FALSE(all_finite<S>(v));
    }
  }
}
