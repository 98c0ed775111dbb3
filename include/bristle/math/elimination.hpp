/// @file
/// Linear equations with a general matrix.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <cmath>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Solves A X = B by elimination with row pivots. B becomes X; A is overwritten. Eigen's own solver
/// works in blocks. It costs a compiler more than the rest of its caller. X is not finite if A is
/// singular.
template <typename MatrixA, typename MatrixB>
void eliminate(MatrixA& A, MatrixB& B) {
  using std::abs;
  using S = typename MatrixA::Scalar;
  const Eigen::Index size = A.rows();
  const Eigen::Index columns = B.cols();
  for (Eigen::Index k = 0; k < size; ++k) {
    Eigen::Index pivot = k;
    for (Eigen::Index i = k + 1; i < size; ++i) {
      if (abs(A(i, k)) > abs(A(pivot, k))) pivot = i;
    }
    for (Eigen::Index j = 0; j < size; ++j) std::swap(A(k, j), A(pivot, j));
    for (Eigen::Index j = 0; j < columns; ++j) std::swap(B(k, j), B(pivot, j));
    for (Eigen::Index i = k + 1; i < size; ++i) {
      const S factor = A(i, k) / A(k, k);
      for (Eigen::Index j = k + 1; j < size; ++j) A(i, j) -= factor * A(k, j);
      for (Eigen::Index j = 0; j < columns; ++j) B(i, j) -= factor * B(k, j);
    }
  }
  for (Eigen::Index k = size; k-- > 0;) {
    for (Eigen::Index j = 0; j < columns; ++j) {
      for (Eigen::Index i = k + 1; i < size; ++i) B(k, j) -= A(k, i) * B(i, j);
      B(k, j) /= A(k, k);
    }
  }
}

/// Returns X of A X = B, of sizes known at compile time.
template <Scalar S, int size, int columns, int options>
[[nodiscard]] Eigen::Matrix<S, size, columns, options> solved(
    Eigen::Matrix<S, size, size, options> A, Eigen::Matrix<S, size, columns, options> B) {
  eliminate(A, B);
  return B;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
