/// @file
/// Cholesky factorisation of a sparse symmetric matrix of 6x6 blocks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/unrolled.hpp>
#include <bristle/math/block6.hpp>
#include <bristle/math/block_pattern.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// Lower triangle of a symmetric positive definite matrix, and its factor in place.
template <Scalar S>
class BlockCholesky {
 public:
  /// Sets the shape and all entries to zero.
  /// @param pattern  Blocks of the matrix and of its factor. It has to last as long as they and
  ///                 their copies do.
  void reset(const BlockPattern& pattern) {
    pattern_ = &pattern;
    values_.assign(6 * stride * pattern.size(), S(0));
  }

  /// Takes the blocks of a pattern from a matrix that has others, too.
  void assign(const BlockPattern& pattern, const BlockCholesky& other) {
    reset(pattern);
    for (std::size_t i = 0; i < blocks(); ++i) {
      const auto copy = [&](std::size_t j, std::size_t number) {
        std::copy_n(other.block(other.pattern_->block(i, j)), 6 * stride, block(number));
      };
      pattern.for_each_below(i, copy);
      copy(i, pattern.diagonal(i));
    }
  }

  /// Reserves as much as `other` has, so that copying it allocates nothing.
  void reserve(const BlockCholesky& other) { values_.reserve(other.values_.capacity()); }

  [[nodiscard]] const BlockPattern& pattern() const { return *pattern_; }
  /// [-] Block rows.
  [[nodiscard]] std::size_t blocks() const { return pattern_->rows(); }
  /// [-] Rows.
  [[nodiscard]] std::size_t size() const { return 6 * blocks(); }
  /// First entry of a block of the pattern, by its number. The six entries of a column are side by
  /// side, the next column follows after `Block6<S>::stride`. In diagonal blocks, entries above the
  /// diagonal have no meaning.
  [[nodiscard]] S* block(std::size_t number) { return values_.data() + 6 * stride * number; }
  [[nodiscard]] const S* block(std::size_t number) const {
    return values_.data() + 6 * stride * number;
  }
  /// Entry of the lower triangle, in a block of the pattern.
  [[nodiscard]] S& at(std::size_t i, std::size_t j) {
    return block(pattern_->block(i / 6, j / 6))[stride * (j % 6) + i % 6];
  }
  [[nodiscard]] const S& at(std::size_t i, std::size_t j) const {
    return block(pattern_->block(i / 6, j / 6))[stride * (j % 6) + i % 6];
  }

  /// y := A x, before `factor`.
  void multiply(const S* x, S* y) const {
    for (std::size_t i = 0; i < blocks(); ++i) {
      S sum[Block6<S>::stride] = {};
      Six<S> sums = Six<S>::load(sum);
      pattern_->for_each_below(i, [&](std::size_t j, std::size_t number) {
        const S* const entries = block(number);
        unrolled<6>([&](auto b) {
          sums.add(x[6 * j + b], Six<S>::load(entries + stride * b));
          y[6 * j + b] += dot6(entries + stride * b, x + 6 * i);
        });
      });
      sums.store(sum);
      const S* const diagonal = block(pattern_->diagonal(i));
      unrolled<6>([&](auto a) {
        const auto entry = [&](std::size_t b) {
          return diagonal[stride * std::min<std::size_t>(a, b) + std::max<std::size_t>(a, b)];
        };
        const S row[6] = {entry(0), entry(1), entry(2), entry(3), entry(4), entry(5)};
        y[6 * i + a] = sum[a] + dot6(row, x + 6 * i);
      });
    }
  }

  /// Replaces the matrix A by its factor L, A = L L^T. L is stored with the inverse of its
  /// diagonal.
  /// @return False if a pivot is not positive or not finite. The matrix is then spoilt.
  [[nodiscard]] bool factor() {
    for (std::size_t i = 0; i < blocks(); ++i) {
      pattern_->for_each_below(i, [&](std::size_t j, std::size_t number) {
        S* const entries = block(number);
        pattern_->for_each_common(
            i, j, [&](std::size_t own, std::size_t other, std::size_t columns) {
              add_product<-1>(block(other), 1, stride, block(own), 6 * columns, entries);
            });
        divide(block(pattern_->diagonal(j)), entries);
      });
      S* const pivot = block(pattern_->diagonal(i));
      pattern_->for_each_common(i, i, [&](std::size_t own, std::size_t, std::size_t columns) {
        add_product<-1>(block(own), 1, stride, block(own), 6 * columns, pivot);
      });
      if (!factor_diagonal(pivot)) return false;
    }
    return true;
  }

  /// x := A^-1 x, after `factor`.
  void solve(S* x) const {
    for (std::size_t i = 0; i < blocks(); ++i) solve_lower(i, 0, x);
    for (std::size_t i = blocks(); i-- > 0;) {
      const S* const diagonal = block(pattern_->diagonal(i));
      S own[6];
      std::copy_n(x + 6 * i, 6, own);
      unrolled<6>([&](auto before) {
        constexpr std::size_t a = 5 - before;
        const S* const below = diagonal + stride * a;
        unrolled<before>([&](auto k) { own[a] -= below[5 - k] * own[5 - k]; });
        own[a] *= below[a];
      });
      std::copy_n(own, 6, x + 6 * i);
      pattern_->for_each_below(i, [&](std::size_t j, std::size_t number) {
        for (std::size_t b = 0; b < 6; ++b) {
          x[6 * j + b] -= dot6(block(number) + stride * b, own);
        }
      });
    }
  }

  /// Returns whether x^T A^-1 x > bound, after `factor`. That is the square of L^-1 x, a sum that
  /// only grows, so that its first blocks mostly tell.
  /// @param x      Is overwritten.
  /// @param start  First block of x that is not zero.
  [[nodiscard]] bool responds_by(const S& bound, S* x, std::size_t start) const {
    S sum = S(0);
    for (std::size_t i = start; i < blocks(); ++i) {
      solve_lower(i, start, x);
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
    pattern_->for_each_below(i, [&](std::size_t j, std::size_t number) {
      if (j < from) return;
      const S* const entries = block(number);
      for (std::size_t b = 0; b < 6; ++b) {
        rest.subtract(x[6 * j + b], Six<S>::load(entries + stride * b));
      }
    });
    rest.store(own);
    const S* const diagonal = block(pattern_->diagonal(i));
    unrolled<6>([&](auto a) {
      const S* const below = diagonal + stride * a;
      own[a] *= below[a];
      unrolled<5 - a>([&](auto k) { own[a + 1 + k] -= below[a + 1 + k] * own[a]; });
    });
    std::copy_n(own, 6, x + 6 * i);
  }

  /// x := x L^-T for a factored diagonal block. Both are stored by columns.
  static void divide(const S* factor, S* x) {
    Six<S> columns[6];
    unrolled<6>([&](auto b) {
      columns[b] = Six<S>::load(x + stride * b);
      unrolled<b>([&](auto c) { columns[b].subtract(factor[stride * c + b], columns[c]); });
      columns[b].scale(factor[stride * b + b]);
      columns[b].store(x + stride * b);
    });
  }

  /// Factors a diagonal block, stored by columns. On the diagonal the factor has its inverse, which
  /// takes one division for all that the pivot divides.
  [[nodiscard]] static bool factor_diagonal(S* block) {
    using std::sqrt;
    bool is_positive = true;
    Six<S> columns[6];
    unrolled<6>([&](auto b) {
      S* const below = block + stride * b;
      columns[b] = Six<S>::load(below);
      unrolled<b>([&](auto c) { columns[b].subtract(block[stride * c + b], columns[c]); });
      columns[b].store(below);
      is_positive = is_positive && below[b] > S(0) && below[b] < infinity<S>;
      // The rest is spoilt then, but traps no root of a negative number.
      const S inverse = S(1) / sqrt(is_positive ? below[b] : S(1));
      columns[b].scale(inverse);
      columns[b].store(below);
      below[b] = inverse;
    });
    return is_positive;
  }

  const BlockPattern* pattern_ = nullptr;
  DynamicArray<S> values_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
