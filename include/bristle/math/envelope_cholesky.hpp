/// @file
/// Cholesky factorisation of a sparse symmetric matrix of 6x6 blocks within its envelope.
///
/// Each block row is stored from its first nonzero block to the diagonal. All fill of the
/// factorisation falls inside (Jennings 1966). Stacks and chains numbered end to end have narrow
/// envelopes. Their cost grows with their length and not with its cube.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/math/block6.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Lower triangle of a symmetric positive definite matrix, and its factor in place.
template <Scalar S>
class EnvelopeMatrix {
 public:
  /// Sets the shape and all entries to zero.
  /// @param first  Column of the first block of each block row. At most the row's own number.
  void reset(std::span<const std::uint32_t> first) {
    first_.assign(first.begin(), first.end());
    start_.resize(first.size());
    std::size_t size = 0;
    for (std::size_t i = 0; i < first.size(); ++i) {
      start_[i] = size - 6 * stride * first[i];  // Wraps around; only sums with a column are used.
      size += 6 * stride * (i - first[i] + 1);
    }
    values_.assign(size, S(0));
  }

  /// Reserves as much as `other` has, so that copying it allocates nothing.
  void reserve(const EnvelopeMatrix& other) {
    first_.reserve(other.first_.capacity());
    start_.reserve(other.start_.capacity());
    values_.reserve(other.values_.capacity());
  }

  /// [-] Block rows.
  [[nodiscard]] std::size_t blocks() const { return first_.size(); }
  /// [-] Rows.
  [[nodiscard]] std::size_t size() const { return 6 * first_.size(); }
  /// First block of a block row.
  [[nodiscard]] std::uint32_t first(std::size_t block) const { return first_[block]; }
  /// Entry of the lower triangle: 6 first(i / 6) <= j <= i. The entries of a block row in one
  /// column are side by side. In diagonal blocks, those above the diagonal have no meaning.
  [[nodiscard]] S& at(std::size_t i, std::size_t j) { return column(i / 6, j)[i % 6]; }
  [[nodiscard]] const S& at(std::size_t i, std::size_t j) const { return column(i / 6, j)[i % 6]; }

  /// y := A x, before `factor`.
  void multiply(const S* x, S* y) const {
    for (std::size_t i = 0; i < blocks(); ++i) {
      S sum[Block6<S>::stride] = {};
      Six<S> sums = Six<S>::load(sum);
      for (std::size_t j = 6 * first_[i]; j < 6 * i; ++j) {
        sums.add(x[j], Six<S>::load(column(i, j)));
        y[j] += dot6(column(i, j), x + 6 * i);
      }
      sums.store(sum);
      for (std::size_t a = 0; a < 6; ++a) {
        y[6 * i + a] = sum[a];
        for (std::size_t b = 0; b < 6; ++b) {
          y[6 * i + a] += at(6 * i + std::max(a, b), 6 * i + std::min(a, b)) * x[6 * i + b];
        }
      }
    }
  }

  /// Replaces the matrix A by its factor L, A = L L^T.
  /// @return False if a pivot is not positive or not finite. The matrix is then spoilt.
  [[nodiscard]] bool factor() {
    for (std::size_t i = 0; i < blocks(); ++i) {
      for (std::size_t j = first_[i]; j < i; ++j) {
        const std::size_t from = 6 * std::max(first_[i], first_[j]);
        add_product<-1>(column(j, from), 1, stride, column(i, from), 6 * j - from,
                        column(i, 6 * j));
        divide(column(j, 6 * j), column(i, 6 * j));
      }
      S* const pivot = column(i, 6 * i);
      const std::size_t from = 6 * first_[i];
      add_product<-1>(column(i, from), 1, stride, column(i, from), 6 * i - from, pivot);
      if (!factor_diagonal(pivot)) return false;
    }
    return true;
  }

  /// x := A^-1 x, after `factor`.
  void solve(S* x) const {
    for (std::size_t i = 0; i < blocks(); ++i) solve_lower(i, first_[i], x);
    for (std::size_t i = blocks(); i-- > 0;) {
      for (std::size_t a = 6; a-- > 0;) {
        const S* const below = column(i, 6 * i + a);
        for (std::size_t b = a + 1; b < 6; ++b) x[6 * i + a] -= below[b] * x[6 * i + b];
        x[6 * i + a] /= below[a];
      }
      for (std::size_t j = 6 * first_[i]; j < 6 * i; ++j) x[j] -= dot6(column(i, j), x + 6 * i);
    }
  }

  /// Returns whether x^T A^-1 x > bound, after `factor`. That is the square of L^-1 x, a sum that
  /// only grows, so that its first blocks mostly tell.
  /// @param x      Is overwritten.
  /// @param start  First block of x that is not zero.
  [[nodiscard]] bool responds_by(const S& bound, S* x, std::size_t start) const {
    S sum = S(0);
    for (std::size_t i = start; i < blocks(); ++i) {
      solve_lower(i, std::max<std::size_t>(start, first_[i]), x);
      sum += dot6(x + 6 * i, x + 6 * i);
      if (sum > bound) return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t stride = Block6<S>::stride;

  /// Finds block i of L^-1 x from those before it. Those before `from` are zero.
  void solve_lower(std::size_t i, std::size_t from, S* x) const {
    S own[Block6<S>::stride] = {};
    std::copy_n(x + 6 * i, 6, own);
    Six<S> rest = Six<S>::load(own);
    for (std::size_t j = 6 * from; j < 6 * i; ++j) rest.subtract(x[j], Six<S>::load(column(i, j)));
    rest.store(own);
    for (std::size_t a = 0; a < 6; ++a) {
      const S* const below = column(i, 6 * i + a);
      x[6 * i + a] = own[a] / below[a];
      for (std::size_t b = a + 1; b < 6; ++b) own[b] -= below[b] * x[6 * i + a];
    }
  }

  /// The six entries of a block row in a column.
  [[nodiscard]] S* column(std::size_t block, std::size_t j) {
    return values_.data() + (start_[block] + stride * j);
  }
  [[nodiscard]] const S* column(std::size_t block, std::size_t j) const {
    return values_.data() + (start_[block] + stride * j);
  }

  /// x := x L^-T for a factored diagonal block L. Both are stored by columns.
  static void divide(const S* factor, S* x) {
    Six<S> columns[6];
    for (std::size_t b = 0; b < 6; ++b) {
      columns[b] = Six<S>::load(x + stride * b);
      for (std::size_t c = 0; c < b; ++c) columns[b].subtract(factor[stride * c + b], columns[c]);
      const Pack<S> pivot(factor[stride * b + b]);
      for (Pack<S>& part : columns[b].part) part /= pivot;
      columns[b].store(x + stride * b);
    }
  }

  /// Factors a diagonal block, stored by columns.
  [[nodiscard]] static bool factor_diagonal(S* block) {
    using std::sqrt;
    for (std::size_t b = 0; b < 6; ++b) {
      S* const below = block + stride * b;
      for (std::size_t c = 0; c < b; ++c) {
        const S* const before = block + stride * c;
        for (std::size_t a = b; a < 6; ++a) below[a] -= before[b] * before[a];
      }
      if (!(below[b] > S(0)) || !(below[b] < infinity<S>)) return false;
      const S root = sqrt(below[b]);
      below[b] = root;
      for (std::size_t a = b + 1; a < 6; ++a) below[a] /= root;
    }
    return true;
  }

  DynamicArray<std::uint32_t> first_;
  DynamicArray<std::size_t> start_;  // Index of each block row in `values_`, less its first column.
  DynamicArray<S> values_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
