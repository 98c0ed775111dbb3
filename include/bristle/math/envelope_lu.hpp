/// @file
/// LU factorisation of a sparse matrix of 6x6 blocks within its envelope.
///
/// The pattern of the matrix is symmetric, its numbers are not. Lower blocks are stored in rows,
/// upper blocks in block columns. Both go from the first nonzero block to the diagonal. All fill
/// falls inside (Jennings 1966). Pivots are chosen within the blocks of the diagonal. A single
/// diagonal entry can be zero. That of a contact which slides at the friction angle is.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/math/block6.hpp>
#include <bristle/math/envelope_cholesky.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// The matrix, and its factors in place. A = L U, with unit blocks on the diagonal of L.
template <Scalar S>
class EnvelopeLu {
 public:
  /// Takes the shape of one symmetric matrix and the numbers of another, whose envelope lies
  /// within. Neither is factored.
  void assign(const EnvelopeMatrix<S>& shape, const EnvelopeMatrix<S>& numbers) {
    blocks_ = shape.blocks();
    first_.resize(blocks_);
    lower_start_.resize(blocks_);
    upper_start_.resize(blocks_);
    std::size_t lower_size = 0;
    std::size_t upper_size = 0;
    for (std::size_t i = 0; i < blocks_; ++i) {
      first_[i] = shape.first(i);
      // Both may wrap around. Only sums with a row or a column are used.
      lower_start_[i] = lower_size - 6 * first_[i];
      upper_start_[i] = upper_size - 6 * first_[i] * stride;
      lower_size += 6 * width(i);
      upper_size += 6 * (i - first_[i]) * stride;
    }
    lower_.assign(lower_size, S(0));
    upper_.assign(upper_size, S(0));
    inverses_.resize(blocks_);
    for (std::size_t i = 0; i < 6 * blocks_; ++i) {
      const std::size_t diagonal = i / 6 * 6;
      for (std::size_t j = 6 * numbers.first(i / 6); j < diagonal; ++j) {
        *row(i, j) = column(i / 6, j)[i % 6] = numbers.at(i, j);
      }
      for (std::size_t j = diagonal; j <= i; ++j) *row(i, j) = *row(j, i) = numbers.at(i, j);
    }
  }

  /// Reserves memory for `assign`, so that it allocates nothing.
  void reserve(const EnvelopeMatrix<S>& shape) {
    const std::size_t blocks = shape.blocks();
    std::size_t size = 0;
    for (std::size_t i = 0; i < blocks; ++i) size += i - shape.first(i) + 1;
    first_.reserve(blocks);
    lower_start_.reserve(blocks);
    upper_start_.reserve(blocks);
    lower_.reserve(36 * size);
    upper_.reserve(6 * stride * size);
    inverses_.reserve(blocks);
  }

  /// Adds to a block within the envelope.
  void add(std::size_t block_row, std::size_t block_column, const Block6<S>& x) {
    const bool is_lower = block_row >= block_column;
    for (std::size_t i = 0; i < 6; ++i) {
      S* const out = is_lower ? row(6 * block_row + i, 6 * block_column)
                              : column(block_column, 6 * block_row + i);
      for (std::size_t j = 0; j < 6; ++j) out[j] += x.row(i)[j];
    }
  }

  /// Replaces the matrix by its factors.
  /// @return False if a block of the diagonal is singular or not finite. The matrix is then spoilt.
  [[nodiscard]] bool factor() {
    for (std::size_t i = 0; i < blocks_; ++i) {
      for (std::size_t j = first_[i]; j < i; ++j) {
        const std::size_t from = 6 * std::max(first_[i], first_[j]);
        const std::size_t count = 6 * j - from;
        Block6<S> below = lower_block(i, j);
        add_product<-1>(row(6 * i, from), width(i), 1, column(j, from), count, below.row(0));
        Block6<S> quotient;
        add_product<1>(below.row(0), stride, 1, inverses_[j].row(0), 6, quotient.row(0));
        for (std::size_t a = 0; a < 6; ++a) {
          std::copy_n(quotient.row(a), 6, row(6 * i + a, 6 * j));
        }
        add_product<-1>(row(6 * j, from), width(j), 1, column(i, from), count, column(i, 6 * j));
      }
      const std::size_t from = 6 * first_[i];
      Block6<S> pivot = lower_block(i, i);
      add_product<-1>(row(6 * i, from), width(i), 1, column(i, from), 6 * i - from, pivot.row(0));
      if (!invert(pivot, inverses_[i])) return false;
    }
    return true;
  }

  /// x := A^-1 x, after `factor`.
  void solve(S* x) const {
    for (std::size_t i = 0; i < 6 * blocks_; ++i) {
      for (std::size_t j = 6 * first_[i / 6]; j < i / 6 * 6; j += 6) {
        x[i] -= dot6(row(i, j), x + j);
      }
    }
    for (std::size_t i = blocks_; i-- > 0;) {
      S found[6];
      for (std::size_t a = 0; a < 6; ++a) found[a] = dot6(inverses_[i].row(a), x + 6 * i);
      std::copy_n(found, 6, x + 6 * i);
      for (std::size_t k = 6 * first_[i]; k < 6 * i; ++k) x[k] -= dot6(column(i, k), found);
    }
  }

 private:
  static constexpr std::size_t stride = Block6<S>::stride;

  /// [-] Numbers in each row of a block row, up to the end of the diagonal block.
  [[nodiscard]] std::size_t width(std::size_t block) const {
    return 6 * (block - first_[block] + 1);
  }
  /// Entry (i, j) up to the end of the diagonal block. The others of the row follow.
  [[nodiscard]] S* row(std::size_t i, std::size_t j) {
    return lower_.data() + (lower_start_[i / 6] + i % 6 * width(i / 6) + j);
  }
  [[nodiscard]] const S* row(std::size_t i, std::size_t j) const {
    return lower_.data() + (lower_start_[i / 6] + i % 6 * width(i / 6) + j);
  }
  /// Entry (j, 6 block), above the diagonal block. The other five columns of the block follow.
  [[nodiscard]] S* column(std::size_t block, std::size_t j) {
    return upper_.data() + (upper_start_[block] + stride * j);
  }
  [[nodiscard]] const S* column(std::size_t block, std::size_t j) const {
    return upper_.data() + (upper_start_[block] + stride * j);
  }

  [[nodiscard]] Block6<S> lower_block(std::size_t i, std::size_t j) const {
    Block6<S> block;
    for (std::size_t a = 0; a < 6; ++a) std::copy_n(row(6 * i + a, 6 * j), 6, block.row(a));
    return block;
  }

  /// Inverse by Gauss-Jordan elimination, with the largest pivot of each column. False if singular.
  [[nodiscard]] static bool invert(Block6<S>& m, Block6<S>& inverse) {
    using std::abs;
    inverse = Block6<S>{};
    for (std::size_t i = 0; i < 6; ++i) inverse.row(i)[i] = S(1);
    for (std::size_t c = 0; c < 6; ++c) {
      std::size_t best = c;
      for (std::size_t i = c + 1; i < 6; ++i) {
        if (abs(m.row(i)[c]) > abs(m.row(best)[c])) best = i;
      }
      const S pivot = m.row(best)[c];
      if (!(abs(pivot) > S(0)) || !(abs(pivot) < infinity<S>)) return false;
      if (best != c) {
        std::swap_ranges(m.row(c), m.row(c) + 6, m.row(best));
        std::swap_ranges(inverse.row(c), inverse.row(c) + 6, inverse.row(best));
      }
      const S scale = S(1) / pivot;
      for (std::size_t k = 0; k < 6; ++k) {
        m.row(c)[k] *= scale;
        inverse.row(c)[k] *= scale;
      }
      for (std::size_t i = 0; i < 6; ++i) {
        if (i == c) continue;
        const S share = m.row(i)[c];
        for (std::size_t k = 0; k < 6; ++k) {
          m.row(i)[k] -= share * m.row(c)[k];
          inverse.row(i)[k] -= share * inverse.row(c)[k];
        }
      }
    }
    return true;
  }

  std::size_t blocks_ = 0;
  DynamicArray<std::size_t> first_;  // First block of each block row.
  // Index of each block row in `lower_`, less its first column, and of each block column in
  // `upper_`, less its first row.
  DynamicArray<std::size_t> lower_start_, upper_start_;
  DynamicArray<S> lower_, upper_;     // Lower blocks with the diagonal; upper blocks.
  DynamicArray<Block6<S>> inverses_;  // Inverses of the diagonal blocks of U.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
