// SPDX-License-Identifier: BSD-3-Clause
#include "support/block_patterns.hpp"
#include "support/random.hpp"

#include <bristle/math/block_lu.hpp>

#include <Eigen/Dense>
#include <doctest/doctest.h>

#include <cstddef>
#include <limits>
#include <utility>

using namespace bristle;

using namespace bristle::detail;

namespace {

using Dense = Eigen::MatrixXd;

/// A sparse matrix of blocks, and the same with its zeros. Neighbours are coupled, the last row
/// reaches everything.
struct Arrow {
  BlockPattern pattern;
  BlockLu<double> sparse;
  Dense dense;

  Arrow(std::size_t blocks, double share, double diagonal, double asymmetry) {
    test::Random random(1);
    const std::size_t n = 6 * blocks;
    pattern = test::pattern_with_fill(blocks, [&](std::size_t i, std::size_t j) {
      return i + 1 == blocks || i - j == 1 || random.uniform(0.0, 1.0) < share;
    });
    BlockCholesky<double> symmetric;
    symmetric.reset(pattern);
    dense = Dense::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
    const auto set = [&](std::size_t i, std::size_t j) {
      const double x = i == j ? diagonal : random.uniform(-1.0, 1.0);
      symmetric.at(i, j) = x;
      at(i, j) = at(j, i) = x;
    };
    for (std::size_t i = 0; i < n; ++i) {
      pattern.for_each_below(i / 6, [&](std::size_t column, std::size_t) {
        for (std::size_t j = 6 * column; j < 6 * column + 6; ++j) set(i, j);
      });
      for (std::size_t j = i / 6 * 6; j <= i; ++j) set(i, j);
    }
    sparse.assign(pattern, symmetric);
    for (std::size_t i = 0; i < blocks; ++i) {
      pattern.for_each_below(i, [&](std::size_t j, std::size_t) {
        add(i, j, asymmetry, random);
        add(j, i, asymmetry, random);
      });
      add(i, i, asymmetry, random);
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

TEST_CASE("BlockLu: solves what is not symmetric as a dense factorisation does") {
  for (const std::size_t blocks : {1u, 2u, 5u, 12u}) {
    // Dominant diagonals, and ones that are zero but for the asymmetry: pivots within blocks.
    for (const auto& sizes :
         {std::pair(0.0, 200.0), {0.3, 200.0}, {1.0, 200.0}, {0.0, 0.0}, {0.1, 0.0}}) {
      // CAPTURE is a lambda, and structured bindings cannot be captured in C++20.
      const double share = sizes.first, diagonal = sizes.second;
      CAPTURE(blocks);
      CAPTURE(share);
      CAPTURE(diagonal);
      Arrow arrow(blocks, share, diagonal, 1.0);
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

TEST_CASE("BlockLu: refuses singular blocks and numbers that are none") {
  const BlockPattern pattern = test::full_pattern(1);
  BlockCholesky<double> matrix;
  BlockLu<double> lu;
  const auto factor = [&](double last) {
    matrix.reset(pattern);
    for (std::size_t i = 0; i < 6; ++i) matrix.at(i, i) = i < 5 ? 1.0 : last;
    lu.assign(pattern, matrix);
    return lu.factor();
  };
  CHECK(factor(-2.0));
  CHECK_FALSE(factor(0.0));
  CHECK_FALSE(factor(infinity<double>));
  CHECK_FALSE(factor(std::numeric_limits<double>::quiet_NaN()));
}
