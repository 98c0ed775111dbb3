/// @file
/// Linear equations with a matrix of any kind, of a size that the compiler knows.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <cmath>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

/// X of A X = B, by elimination with pivots by row. Eigen's own takes blocks of any size, and a
/// compiler longer than the rest of what calls it.
///
/// @return  What is not finite where A is singular.
template <Scalar S, int size, int columns, int options>
[[nodiscard]] Eigen::Matrix<S, size, columns, options> solved(
    Eigen::Matrix<S, size, size, options> A, Eigen::Matrix<S, size, columns, options> B) {
  using std::abs;
  for (int k = 0; k < size; ++k) {
    int pivot = k;
    for (int i = k + 1; i < size; ++i) {
      if (abs(A(i, k)) > abs(A(pivot, k))) pivot = i;
    }
    for (int j = 0; j < size; ++j) std::swap(A(k, j), A(pivot, j));
    for (int j = 0; j < columns; ++j) std::swap(B(k, j), B(pivot, j));
    for (int i = k + 1; i < size; ++i) {
      const S factor = A(i, k) / A(k, k);
      for (int j = k + 1; j < size; ++j) A(i, j) -= factor * A(k, j);
      for (int j = 0; j < columns; ++j) B(i, j) -= factor * B(k, j);
    }
  }
  for (int k = size; k-- > 0;) {
    for (int j = 0; j < columns; ++j) {
      for (int i = k + 1; i < size; ++i) B(k, j) -= A(k, i) * B(i, j);
      B(k, j) /= A(k, k);
    }
  }
  return B;
}

}  // namespace bristle::inline BRISTLE_ABI
