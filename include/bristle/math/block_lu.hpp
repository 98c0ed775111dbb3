/// @file
/// LU factorisation of a sparse matrix of 6x6 blocks.
///
/// The pattern of the matrix is symmetric, its numbers are not. Lower blocks are stored in rows,
/// upper blocks in block columns. Pivots are chosen within the blocks of the diagonal. A single
/// diagonal entry can be zero. That of a contact which slides at the friction angle is.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/math/block6.hpp>
#include <bristle/math/block_cholesky.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// The matrix, and its factors in place. A = L U, with unit blocks on the diagonal of L.
template <Scalar S>
class BlockLu {
 public:
  /// Sets the shape, and the numbers of a symmetric matrix. That one is not factored.
  /// @param pattern  Has all blocks of `numbers`. It has to last as long as the matrix and its
  ///                 copies do.
  void assign(const BlockPattern& pattern, const BlockCholesky<S>& numbers) {
    pattern_ = &pattern;
    blocks_ = pattern.rows();
    lower_.assign(36 * pattern.size(), S(0));
    upper_.assign(6 * stride * (pattern.size() - blocks_), S(0));
    inverses_.resize(blocks_);
    for (std::size_t i = 0; i < blocks_; ++i) {
      numbers.pattern().for_each_below(i, [&](std::size_t j, std::size_t number) {
        const std::size_t own = pattern.block(i, j);
        const S* const from = numbers.block(number);
        for (std::size_t a = 0; a < 6; ++a) {
          for (std::size_t b = 0; b < 6; ++b) {
            row(i, own, a)[b] = column(i, own)[stride * b + a] = from[stride * b + a];
          }
        }
      });
      const S* const from = numbers.block(numbers.pattern().diagonal(i));
      for (std::size_t a = 0; a < 6; ++a) {
        for (std::size_t b = 0; b < 6; ++b) {
          row(i, pattern.diagonal(i), a)[b] = from[stride * std::min(a, b) + std::max(a, b)];
        }
      }
    }
  }

  /// Reserves memory for `assign`, so that it allocates nothing. The fill varies as contacts come
  /// and go. So there is twice as much where it grows.
  void reserve(const BlockPattern& pattern) {
    const std::size_t lower = 36 * pattern.size();
    const std::size_t upper = 6 * stride * (pattern.size() - pattern.rows());
    if (lower_.capacity() < lower) lower_.reserve(2 * lower);
    if (upper_.capacity() < upper) upper_.reserve(2 * upper);
    inverses_.reserve(pattern.rows());
  }

  /// Adds to a block of the pattern, or to one that mirrors it.
  void add(std::size_t block_row, std::size_t block_column, const Block6<S>& x) {
    const bool is_lower = block_row >= block_column;
    const std::size_t number = is_lower ? pattern_->block(block_row, block_column)
                                        : pattern_->block(block_column, block_row);
    for (std::size_t i = 0; i < 6; ++i) {
      S* const out =
          is_lower ? row(block_row, number, i) : column(block_column, number) + stride * i;
      for (std::size_t j = 0; j < 6; ++j) out[j] += x.row(i)[j];
    }
  }

  /// Replaces the matrix by its factors.
  /// @return False if a block of the diagonal is singular or not finite. The matrix is then spoilt.
  [[nodiscard]] bool factor() {
    for (std::size_t i = 0; i < blocks_; ++i) {
      pattern_->for_each_below(i, [&](std::size_t j, std::size_t number) {
        Block6<S> below = lower_block(i, number);
        S* const above = column(i, number);
        pattern_->for_each_common(
            i, j, [&](std::size_t own, std::size_t other, std::size_t columns) {
              add_product<-1>(row(i, own, 0), width(i), 1, column(j, other), 6 * columns,
                              below.row(0));
              add_product<-1>(row(j, other, 0), width(j), 1, column(i, own), 6 * columns, above);
            });
        Block6<S> quotient;
        add_product<1>(below.row(0), stride, 1, inverses_[j].row(0), 6, quotient.row(0));
        for (std::size_t a = 0; a < 6; ++a) std::copy_n(quotient.row(a), 6, row(i, number, a));
      });
      Block6<S> pivot = lower_block(i, pattern_->diagonal(i));
      pattern_->for_each_common(i, i, [&](std::size_t own, std::size_t, std::size_t columns) {
        add_product<-1>(row(i, own, 0), width(i), 1, column(i, own), 6 * columns, pivot.row(0));
      });
      if (!invert(pivot, inverses_[i])) return false;
    }
    return true;
  }

  /// x := A^-1 x, after `factor`.
  void solve(S* x) const {
    for (std::size_t i = 0; i < blocks_; ++i) {
      pattern_->for_each_below(i, [&](std::size_t j, std::size_t number) {
        for (std::size_t a = 0; a < 6; ++a) x[6 * i + a] -= dot6(row(i, number, a), x + 6 * j);
      });
    }
    for (std::size_t i = blocks_; i-- > 0;) {
      S found[6];
      for (std::size_t a = 0; a < 6; ++a) found[a] = dot6(inverses_[i].row(a), x + 6 * i);
      std::copy_n(found, 6, x + 6 * i);
      pattern_->for_each_below(i, [&](std::size_t j, std::size_t number) {
        for (std::size_t b = 0; b < 6; ++b) {
          x[6 * j + b] -= dot6(column(i, number) + stride * b, found);
        }
      });
    }
  }

 private:
  static constexpr std::size_t stride = Block6<S>::stride;

  /// [-] Numbers in each row of a block row, up to the end of the diagonal block.
  [[nodiscard]] std::size_t width(std::size_t block_row) const {
    return 6 * (pattern_->start(block_row + 1) - pattern_->start(block_row));
  }
  /// Row a of a block of the lower triangle, by the block's row and number. Those of the blocks
  /// after it follow.
  [[nodiscard]] S* row(std::size_t block_row, std::size_t number, std::size_t a) {
    return lower_.data() + row_index(block_row, number, a);
  }
  [[nodiscard]] const S* row(std::size_t block_row, std::size_t number, std::size_t a) const {
    return lower_.data() + row_index(block_row, number, a);
  }
  [[nodiscard]] std::size_t row_index(std::size_t block_row, std::size_t number,
                                      std::size_t a) const {
    const std::size_t start = pattern_->start(block_row);
    return 36 * start + a * width(block_row) + 6 * (number - start);
  }
  /// First row of the block that mirrors one below the diagonal, by that block's row and number.
  /// Its other rows follow, then the blocks below it in its column.
  [[nodiscard]] S* column(std::size_t block_row, std::size_t number) {
    return upper_.data() + 6 * stride * (number - block_row);  // Diagonal blocks are left out.
  }
  [[nodiscard]] const S* column(std::size_t block_row, std::size_t number) const {
    return upper_.data() + 6 * stride * (number - block_row);
  }

  [[nodiscard]] Block6<S> lower_block(std::size_t block_row, std::size_t number) const {
    Block6<S> block;
    for (std::size_t a = 0; a < 6; ++a) {
      std::copy_n(row(block_row, number, a), 6, block.row(a));
    }
    return block;
  }

  /// to -= share * row.
  BRISTLE_FORCE_INLINE static void subtract(const S& share, const Six<S>& row, S* to) {
    Six<S> rest = Six<S>::load(to);
    rest.subtract(share, row);
    rest.store(to);
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
      Six<S> row = Six<S>::load(m.row(c));
      Six<S> inverse_row = Six<S>::load(inverse.row(c));
      const S scale = S(1) / pivot;
      row.scale(scale);
      inverse_row.scale(scale);
      row.store(m.row(c));
      inverse_row.store(inverse.row(c));
      for (std::size_t i = 0; i < 6; ++i) {
        if (i == c) continue;
        const S share = m.row(i)[c];
        subtract(share, row, m.row(i));
        subtract(share, inverse_row, inverse.row(i));
      }
    }
    return true;
  }

  const BlockPattern* pattern_ = nullptr;
  std::size_t blocks_ = 0;
  DynamicArray<S> lower_, upper_;     // Lower blocks with the diagonal; upper blocks.
  DynamicArray<Block6<S>> inverses_;  // Inverses of the diagonal blocks of U.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
