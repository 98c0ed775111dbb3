// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/math/elimination.hpp>
#include <bristle/math/finite.hpp>

#include <doctest/doctest.h>

#include <random>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE_TEMPLATE("solved: A X = B, where pivots have to be looked for, too", S, float, double) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int round = 0; round < 100; ++round) {
    Mat6<S> A, X;
    for (Eigen::Index i = 0; i < A.size(); ++i) {
      A.data()[i] = static_cast<S>(number(random));
      X.data()[i] = static_cast<S>(number(random));
    }
    A(0, 0) = S(0);  // No pivot in its place.
    const Mat6<S> B = A * X;
    const Mat6<S> found = solved(A, B);
    // Backward stable: what is left is rounding of the terms, 6 of at most |A| |X|.
    CHECK((A * found - B).norm() <= S(6) * Tolerance<S>::round_off() * A.norm() * found.norm());
    const Vec6<S> x = X.col(2);
    const Vec6<S> b = A * x;
    CHECK((A * solved(A, b) - b).norm() <=
          S(6) * Tolerance<S>::round_off() * A.norm() * solved(A, b).norm());
  }
}

TEST_CASE("solved: is not finite where there is no answer") {
  Mat6<double> A = Mat6<double>::Identity();
  A.row(3).setZero();
  CHECK_FALSE(all_finite(solved(A, Vec6<double>(Vec6<double>::Ones()))));
}
