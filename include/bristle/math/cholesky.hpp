/// @file
/// Cholesky factorisation of small dense matrices in the caller's memory.
///
/// Row-major lower triangles over a flat array. Nothing is allocated. Sizes are known only at run
/// time (a few bodies of an island).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// Replaces the lower triangle of the symmetric n x n matrix `a` by its factor L, a = L L^T.
///
/// @param floor  [1] Pivots below `floor` times their diagonal entry are raised to it. Use 0 for a
///               matrix that is positive definite. Use round-off for one that may be singular
///               (redundant constraints). The solution is then the one of least norm to working
///               precision.
/// @return False if a pivot is not positive or not finite. The matrix `a` is then spoilt.
template <Scalar S>
[[nodiscard]] bool factor_cholesky(S* a, std::size_t n, S floor = S(0)) {
  using std::sqrt;
  for (std::size_t i = 0; i < n; ++i) {
    S* row_i = a + i * n;
    for (std::size_t j = 0; j < i; ++j) {
      const S* row_j = a + j * n;
      S sum = row_i[j];
      for (std::size_t k = 0; k < j; ++k) sum -= row_i[k] * row_j[k];
      row_i[j] = sum / row_j[j];
    }
    const S diagonal = row_i[i];
    S pivot = diagonal;
    for (std::size_t k = 0; k < i; ++k) pivot -= row_i[k] * row_i[k];
    if (pivot < floor * diagonal) pivot = floor * diagonal;
    if (!(pivot > S(0)) || !(pivot < infinity<S>)) return false;
    row_i[i] = sqrt(pivot);
  }
  return true;
}

/// b := L^-1 b, where b is zero before entry `first`.
template <Scalar S>
void solve_lower(const S* l, std::size_t n, S* b, std::size_t first = 0) {
  for (std::size_t i = first; i < n; ++i) {
    const S* row = l + i * n;
    S sum = b[i];
    for (std::size_t k = first; k < i; ++k) sum -= row[k] * b[k];
    b[i] = sum / row[i];
  }
}

/// b := L^-T b.
template <Scalar S>
void solve_upper(const S* l, std::size_t n, S* b) {
  for (std::size_t i = n; i-- > 0;) {
    const S value = b[i] / l[i * n + i];
    b[i] = value;
    const S* row = l + i * n;
    for (std::size_t k = 0; k < i; ++k) b[k] -= row[k] * value;
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
