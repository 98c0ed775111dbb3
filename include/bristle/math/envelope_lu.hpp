/// @file
/// LU factorisation of a sparse matrix of 6x6 blocks within its envelope.
///
/// The pattern of the matrix is symmetric, its numbers are not. Lower blocks are stored in rows,
/// upper blocks in columns. Both go from the first nonzero block to the diagonal. All fill falls
/// inside (Jennings 1966), and every inner product runs over contiguous memory. Pivots are chosen
/// within the blocks of the diagonal. A single diagonal entry can be zero. That of a contact which
/// slides at the friction angle is.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/refill.hpp>
#include <bristle/math/envelope_cholesky.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// A 6x6 matrix, row by row.
template <Scalar S>
using Block6 = std::array<S, 36>;

/// The matrix, and its factors in place. A = L U, with unit blocks on the diagonal of L.
template <Scalar S>
class EnvelopeLu {
 public:
  /// Copies the shape and the numbers of a symmetric matrix that is not factored. Its rows begin at
  /// multiples of six.
  void assign(const EnvelopeMatrix<S>& symmetric) {
    blocks_ = symmetric.size() / 6;
    first_.resize(blocks_);
    start_.resize(6 * blocks_);
    std::size_t size = 0;
    for (std::size_t i = 0; i < blocks_; ++i) {
      first_[i] = symmetric.first(6 * i) / 6;
      for (std::size_t k = 6 * i; k < 6 * i + 6; ++k) {
        start_[k] = size - 6 * first_[i];  // Wraps around; only sums with a column are used.
        size += 6 * (i - first_[i] + 1);
      }
    }
    refill(rows_, size, S(0));
    refill(columns_, size, S(0));
    inverses_.resize(blocks_);
    for (std::size_t i = 0; i < 6 * blocks_; ++i) {
      const std::size_t diagonal = i / 6 * 6;
      for (std::size_t j = symmetric.first(i); j < diagonal; ++j) {
        row(i)[j] = column(i)[j] = symmetric.at(i, j);
      }
      for (std::size_t j = diagonal; j <= i; ++j) row(i)[j] = row(j)[i] = symmetric.at(i, j);
    }
  }

  /// Reserves memory for `assign`, so that it allocates nothing.
  void reserve(const EnvelopeMatrix<S>& symmetric) {
    const std::size_t blocks = symmetric.size() / 6;
    std::size_t size = 0;
    for (std::size_t i = 0; i < blocks; ++i) size += 36 * (i - symmetric.first(6 * i) / 6 + 1);
    first_.reserve(blocks);
    start_.reserve(6 * blocks);
    rows_.reserve(size);
    columns_.reserve(size);
    inverses_.reserve(blocks);
  }

  /// Adds to a block within the envelope.
  void add(std::size_t block_row, std::size_t block_column, const Block6<S>& x) {
    const bool is_lower = block_row >= block_column;
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < 6; ++j) {
        if (is_lower) {
          row(6 * block_row + i)[6 * block_column + j] += x[6 * i + j];
        } else {
          column(6 * block_column + j)[6 * block_row + i] += x[6 * i + j];
        }
      }
    }
  }

  /// Replaces the matrix by its factors.
  /// @return False if a block of the diagonal is singular or not finite. The matrix is then spoilt.
  [[nodiscard]] bool factor() {
    for (std::size_t i = 0; i < blocks_; ++i) {
      for (std::size_t j = first_[i]; j < i; ++j) {
        const std::size_t from = 6 * std::max(first_[i], first_[j]);
        const std::size_t count = 6 * j - from;
        for (std::size_t k = 6 * i; k < 6 * i + 6; ++k) {
          S below[6];
          for (std::size_t b = 0; b < 6; ++b) {
            const std::size_t c = 6 * j + b;
            below[b] = row(k)[c] - sum_of_products(row(k) + from, column(c) + from, count);
            column(k)[c] -= sum_of_products(column(k) + from, row(c) + from, count);
          }
          times_inverse(below, inverses_[j], row(k) + 6 * j);
        }
      }
      const std::size_t from = 6 * first_[i];
      const std::size_t count = 6 * i - from;
      Block6<S> pivot;
      for (std::size_t a = 0; a < 6; ++a) {
        for (std::size_t b = 0; b < 6; ++b) {
          pivot[6 * a + b] =
              row(6 * i + a)[6 * i + b] -
              sum_of_products(row(6 * i + a) + from, column(6 * i + b) + from, count);
        }
      }
      if (!invert(pivot, inverses_[i])) return false;
    }
    return true;
  }

  /// x := A^-1 x, after `factor`.
  void solve(S* x) const {
    for (std::size_t i = 0; i < 6 * blocks_; ++i) {
      const std::size_t from = 6 * first_[i / 6];
      x[i] -= sum_of_products(row(i) + from, x + from, i / 6 * 6 - from);
    }
    for (std::size_t i = blocks_; i-- > 0;) {
      S found[6];
      for (std::size_t a = 0; a < 6; ++a)
        found[a] = sum_of_products(&inverses_[i][6 * a], x + 6 * i, 6);
      for (std::size_t a = 0; a < 6; ++a) {
        x[6 * i + a] = found[a];
        const S* above = column(6 * i + a);
        for (std::size_t k = 6 * first_[i]; k < 6 * i; ++k) x[k] -= above[k] * found[a];
      }
    }
  }

 private:
  /// Pointer row(i) gives entry (i, j) at j, up to the end of the diagonal block. Pointer column(i)
  /// gives entry (j, i) at j, above that block.
  [[nodiscard]] S* row(std::size_t i) { return rows_.data() + start_[i]; }
  [[nodiscard]] const S* row(std::size_t i) const { return rows_.data() + start_[i]; }
  [[nodiscard]] S* column(std::size_t i) { return columns_.data() + start_[i]; }
  [[nodiscard]] const S* column(std::size_t i) const { return columns_.data() + start_[i]; }

  /// out := x times `inverse`, for a row x.
  static void times_inverse(const S (&x)[6], const Block6<S>& inverse, S* out) {
    for (std::size_t b = 0; b < 6; ++b) {
      S sum = S(0);
      for (std::size_t k = 0; k < 6; ++k) sum += x[k] * inverse[6 * k + b];
      out[b] = sum;
    }
  }

  /// Inverse by Gauss-Jordan elimination, with the largest pivot of each column. False if singular.
  [[nodiscard]] static bool invert(Block6<S>& m, Block6<S>& inverse) {
    using std::abs;
    inverse.fill(S(0));
    for (std::size_t i = 0; i < 6; ++i) inverse[7 * i] = S(1);
    const auto swap_rows = [](Block6<S>& x, std::size_t i, std::size_t j) {
      for (std::size_t k = 0; k < 6; ++k) std::swap(x[6 * i + k], x[6 * j + k]);
    };
    for (std::size_t c = 0; c < 6; ++c) {
      std::size_t best = c;
      for (std::size_t i = c + 1; i < 6; ++i) {
        if (abs(m[6 * i + c]) > abs(m[6 * best + c])) best = i;
      }
      const S pivot = m[6 * best + c];
      if (!(abs(pivot) > S(0)) || !(abs(pivot) < infinity<S>)) return false;
      if (best != c) {
        swap_rows(m, c, best);
        swap_rows(inverse, c, best);
      }
      const S scale = S(1) / pivot;
      for (std::size_t k = 0; k < 6; ++k) {
        m[6 * c + k] *= scale;
        inverse[6 * c + k] *= scale;
      }
      for (std::size_t i = 0; i < 6; ++i) {
        if (i == c) continue;
        const S share = m[6 * i + c];
        for (std::size_t k = 0; k < 6; ++k) {
          m[6 * i + k] -= share * m[6 * c + k];
          inverse[6 * i + k] -= share * inverse[6 * c + k];
        }
      }
    }
    return true;
  }

  std::size_t blocks_ = 0;
  std::vector<std::size_t> first_;   // First block of each block row.
  std::vector<std::size_t> start_;   // Index of each row in `rows_`, less its first column.
  std::vector<S> rows_, columns_;    // Lower blocks with the diagonal; upper blocks.
  std::vector<Block6<S>> inverses_;  // Inverses of the diagonal blocks of U.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
