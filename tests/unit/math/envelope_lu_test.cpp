// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/math/envelope_lu.hpp>

#include <Eigen/Dense>
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

using Dense = Eigen::MatrixXd;

/// A matrix of blocks in an arrow's envelope, and the same without one.
struct Arrow {
  EnvelopeLu<double> sparse;
  Dense dense;

  Arrow(std::size_t blocks, double diagonal, double asymmetry) {
    test::Random random(1);
    const std::size_t n = 6 * blocks;
    std::vector<std::uint32_t> first(blocks);
    for (std::size_t i = 0; i < blocks; ++i) {
      first[i] = i + 1 == blocks || i == 0 ? 0 : static_cast<std::uint32_t>(i - 1);
    }
    EnvelopeMatrix<double> symmetric;
    symmetric.reset(first);
    dense = Dense::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 6 * first[i / 6]; j <= i; ++j) {
        const double x = i == j ? diagonal : random.uniform(-1.0, 1.0);
        symmetric.at(i, j) = x;
        at(i, j) = at(j, i) = x;
      }
    }
    sparse.assign(symmetric, symmetric);
    for (std::size_t i = 0; i < blocks; ++i) {
      for (std::size_t j = first[i]; j <= i; ++j) {
        add(i, j, asymmetry, random);
        if (i != j) add(j, i, asymmetry, random);
      }
    }
  }

  double& at(std::size_t i, std::size_t j) {
    return dense(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  }

 private:
  void add(std::size_t row, std::size_t column, double size, test::Random& random) {
    Block6<double> block;
    for (std::size_t k = 0; k < 36; ++k) {
      const double x = random.uniform(-size, size);
      block.row(k / 6)[k % 6] = x;
      at(6 * row + k / 6, 6 * column + k % 6) += x;
    }
    sparse.add(row, column, block);
  }
};

}  // namespace

TEST_CASE("EnvelopeLu: solves what is not symmetric as a dense factorisation does") {
  for (const std::size_t blocks : {1u, 2u, 5u, 12u}) {
    // Dominant diagonals, and ones that are zero but for the asymmetry: pivots within blocks.
    for (const double diagonal : {200.0, 0.0}) {
      CAPTURE(blocks);
      CAPTURE(diagonal);
      Arrow arrow(blocks, diagonal, 1.0);
      const auto n = arrow.dense.rows();
      Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, -1, 2);
      Eigen::VectorXd b = arrow.dense * x;
      REQUIRE(arrow.sparse.factor());
      arrow.sparse.solve(b.data());
      // Pivots that stay within their blocks may make the factors grow: by no more than the
      // condition of a random matrix of this size, with a margin.
      const double condition = arrow.dense.jacobiSvd().singularValues()(0) /
                               arrow.dense.jacobiSvd().singularValues()(n - 1);
      CHECK((b - x).norm() < 1e3 * condition * Tolerance<double>::round_off() * x.norm());
    }
  }
}

TEST_CASE("EnvelopeLu: refuses singular blocks and numbers that are none") {
  const std::vector<std::uint32_t> first(1, 0);
  EnvelopeMatrix<double> matrix;
  EnvelopeLu<double> lu;
  const auto factor = [&](double last) {
    matrix.reset(first);
    for (std::size_t i = 0; i < 6; ++i) matrix.at(i, i) = i < 5 ? 1.0 : last;
    lu.assign(matrix, matrix);
    return lu.factor();
  };
  CHECK(factor(-2.0));
  CHECK_FALSE(factor(0.0));
  CHECK_FALSE(factor(infinity<double>));
  CHECK_FALSE(factor(std::numeric_limits<double>::quiet_NaN()));
}
