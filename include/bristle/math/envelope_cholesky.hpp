/// @file
/// Cholesky factorisation of a sparse symmetric matrix within its envelope.
///
/// Row i is stored from its first nonzero entry to the diagonal. All fill of the factorisation
/// falls inside (Jennings 1966). Stacks and chains numbered end to end have narrow envelopes. Their
/// cost grows with their length and not with its cube.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/refill.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Sum of products, as four sums side by side. The compiler may not reorder one sum to fill its
/// vector lanes.
template <Scalar S>
[[nodiscard]] S sum_of_products(const S* a, const S* b, std::size_t n) {
  S sum[4] = {S(0), S(0), S(0), S(0)};
  std::size_t i = 0;
  for (; i + 4 <= n; i += 4) {
    for (std::size_t k = 0; k < 4; ++k) sum[k] += a[i + k] * b[i + k];
  }
  for (; i < n; ++i) sum[0] += a[i] * b[i];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// Lower triangle of a symmetric positive definite matrix, and its factor in place.
template <Scalar S>
class EnvelopeMatrix {
 public:
  /// Sets the shape and all entries to zero.
  /// @param first  Column of the first entry of each row. At most the row's own number.
  void reset(std::span<const std::uint32_t> first) {
    first_.assign(first.begin(), first.end());
    start_.resize(first.size());
    std::size_t size = 0;
    for (std::size_t i = 0; i < first.size(); ++i) {
      start_[i] = size - first[i];  // Wraps around; only sums with a column are used.
      size += i - first[i] + 1;
    }
    refill(values_, size, S(0));
  }

  /// Reserves as much as `other` has, so that copying it allocates nothing.
  void reserve(const EnvelopeMatrix& other) {
    first_.reserve(other.first_.capacity());
    start_.reserve(other.start_.capacity());
    values_.reserve(other.values_.capacity());
  }

  [[nodiscard]] std::size_t size() const { return first_.size(); }
  [[nodiscard]] std::uint32_t first(std::size_t row) const { return first_[row]; }
  /// Entry of the lower triangle: first(i) <= j <= i.
  [[nodiscard]] S& at(std::size_t i, std::size_t j) { return values_[start_[i] + j]; }
  [[nodiscard]] S at(std::size_t i, std::size_t j) const { return values_[start_[i] + j]; }

  /// y := A x, before `factor`.
  void multiply(const S* x, S* y) const {
    for (std::size_t i = 0; i < size(); ++i) {
      const S* row_i = row(i);
      y[i] = sum_of_products(row_i + first_[i], x + first_[i], i - first_[i] + 1);
      for (std::size_t k = first_[i]; k < i; ++k) y[k] += row_i[k] * x[i];
    }
  }

  /// Replaces the matrix A by its factor L, A = L L^T.
  /// @param floor  [1] As for `factor_cholesky`.
  /// @return False if a pivot is not positive or not finite. The matrix is then spoilt.
  [[nodiscard]] bool factor(S floor = S(0)) {
    using std::sqrt;
    for (std::size_t i = 0; i < size(); ++i) {
      S* row_i = row(i);
      for (std::size_t j = first_[i]; j < i; ++j) {
        const S* row_j = row(j);
        const std::size_t from = std::max(first_[i], first_[j]);
        row_i[j] = (row_i[j] - sum_of_products(row_i + from, row_j + from, j - from)) / row_j[j];
      }
      const S diagonal = row_i[i];
      S pivot = diagonal - sum_of_products(row_i + first_[i], row_i + first_[i], i - first_[i]);
      if (pivot < floor * diagonal) pivot = floor * diagonal;
      if (!(pivot > S(0)) || !(pivot < infinity<S>)) return false;
      row_i[i] = sqrt(pivot);
    }
    return true;
  }

  /// x := A^-1 x, after `factor`.
  void solve(S* x) const {
    for (std::size_t i = 0; i < size(); ++i) {
      const S* row_i = row(i);
      x[i] = (x[i] - sum_of_products(row_i + first_[i], x + first_[i], i - first_[i])) / row_i[i];
    }
    for (std::size_t i = size(); i-- > 0;) {
      const S* row_i = row(i);
      x[i] /= row_i[i];
      for (std::size_t k = first_[i]; k < i; ++k) x[k] -= row_i[k] * x[i];
    }
  }

 private:
  /// Pointer such that row(i)[j] is entry (i, j).
  [[nodiscard]] S* row(std::size_t i) { return values_.data() + start_[i]; }
  [[nodiscard]] const S* row(std::size_t i) const { return values_.data() + start_[i]; }

  std::vector<std::uint32_t> first_;
  std::vector<std::size_t> start_;  // Index of each row in `values_`, less its first column.
  std::vector<S> values_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
