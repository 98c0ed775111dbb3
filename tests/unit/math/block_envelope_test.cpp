// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/math/block_envelope.hpp>

#include <Eigen/Cholesky>
#include <doctest/doctest.h>

#include <array>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE_TEMPLATE("BlockEnvelope: solves what a dense factorisation solves", S, float, double) {
  // Row 3 reaches back to row 1 past row 2, and row 2 starts anew: both kinds of envelope.
  const std::array<std::uint32_t, 5> first{0, 0, 2, 1, 3};
  using Dense = Eigen::Matrix<S, 15, 15>;
  const Dense seed = Dense::Random();
  Dense a = Dense::Zero();
  BlockEnvelope<S> matrix;
  matrix.set_shape(first);
  matrix.set_zero();
  for (int i = 0; i < 5; ++i) {
    for (int j = static_cast<int>(first[static_cast<std::size_t>(i)]); j <= i; ++j) {
      Mat3<S> block = seed.template block<3, 3>(3 * i, 3 * j);
      if (i == j) block = Mat3<S>(block * block.transpose()) + S(8) * Mat3<S>::Identity();
      a.template block<3, 3>(3 * i, 3 * j) = block;
      a.template block<3, 3>(3 * j, 3 * i) = block.transpose();
      matrix.at(static_cast<std::size_t>(i), static_cast<std::size_t>(j)) = block;
    }
  }
  REQUIRE(matrix.factor());
  const Eigen::Matrix<S, 15, 1> b = Eigen::Matrix<S, 15, 1>::Random();
  std::array<Vec3<S>, 5> x;
  for (int i = 0; i < 5; ++i) x[static_cast<std::size_t>(i)] = b.template segment<3>(3 * i);
  matrix.solve(x);
  const Eigen::Matrix<S, 15, 1> expected = a.llt().solve(b);
  for (int i = 0; i < 5; ++i) {
    CHECK((x[static_cast<std::size_t>(i)] - expected.template segment<3>(3 * i)).norm() <
          S(10) * Tolerance<S>::round_off());
  }
}

TEST_CASE("BlockEnvelope: refuses what is not positive definite or not finite") {
  BlockEnvelope<double> matrix;
  matrix.set_shape(std::array<std::uint32_t, 1>{0});
  matrix.at(0, 0) = Vec3<double>(1, 1, -1).asDiagonal();
  CHECK_FALSE(matrix.factor());
  matrix.at(0, 0) = Mat3<double>::Ones();
  CHECK_FALSE(matrix.factor());
  matrix.at(0, 0) = std::numeric_limits<double>::quiet_NaN() * Mat3<double>::Identity();
  CHECK_FALSE(matrix.factor());
  matrix.at(0, 0) = infinity<double> * Mat3<double>::Identity();
  CHECK_FALSE(matrix.factor());
}
