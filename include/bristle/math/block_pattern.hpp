/// @file
/// Where the blocks of a sparse matrix and of its factors are.
///
/// A block row is a list of runs of neighbouring columns, the last of which ends at the diagonal.
/// The products of a factorisation are then those of a full matrix, over the columns that two runs
/// have in common. A full row is one run.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Blocks of the lower triangle of a symmetric matrix that has its own fill: where two rows have a
/// block in one column, the later row has one in the column of the earlier. Rows and columns count
/// blocks. Blocks are numbered row by row.
class BlockPattern {
 public:
  /// Neighbouring blocks of a row: those of the columns from `first` up to `end`.
  struct Run {
    std::uint32_t first;
    std::uint32_t end;
    std::size_t block;  ///< Number of the first one.
  };

  void clear() {
    runs_.clear();
    run_starts_.assign(1, 0);
    block_starts_.assign(1, 0);
  }
  /// Appends a row.
  /// @param columns  Those of its blocks below the diagonal, in ascending order. The block of the
  ///                 diagonal is added.
  void add_row(std::span<const std::uint32_t> columns) {
    const auto row = static_cast<std::uint32_t>(rows());
    std::size_t block = block_starts_.back();
    const auto add = [&](std::uint32_t column) {
      if (runs_.size() > run_starts_.back() && runs_.back().end == column) {
        ++runs_.back().end;
      } else {
        runs_.push_back({column, column + 1, block});
      }
      ++block;
    };
    for (const std::uint32_t column : columns) add(column);
    add(row);
    run_starts_.push_back(static_cast<std::uint32_t>(runs_.size()));
    block_starts_.push_back(block);
  }

  [[nodiscard]] std::size_t rows() const { return run_starts_.size() - 1; }
  /// [-] Blocks of all rows.
  [[nodiscard]] std::size_t size() const { return block_starts_.back(); }
  /// Number of the first block of a row. That of the next row follows its diagonal block.
  [[nodiscard]] std::size_t start(std::size_t row) const { return block_starts_[row]; }
  /// Number of the diagonal block of a row.
  [[nodiscard]] std::size_t diagonal(std::size_t row) const { return block_starts_[row + 1] - 1; }
  /// Number of a block of the pattern.
  [[nodiscard]] std::size_t block(std::size_t row, std::size_t column) const {
    if (column == row) return diagonal(row);
    const Run& run = *first_run_past(row, column);
    BRISTLE_CHECK_INDEX(column, row + 1);
    BRISTLE_CHECK_INDEX(column - run.first, std::size_t(run.end - run.first));
    return run.block + (column - run.first);
  }

  /// Calls use(column, number) for the blocks of a row below the diagonal.
  template <typename Use>
  void for_each_below(std::size_t row, Use&& use) const {
    for (std::size_t r = run_starts_[row]; r < run_starts_[row + 1]; ++r) {
      const Run& run = runs_[r];
      const std::size_t end = std::min<std::size_t>(run.end, row);
      for (std::size_t column = run.first; column < end; ++column) {
        use(column, run.block + (column - run.first));
      }
    }
  }
  /// Calls use(number in row, number in other row, columns) for the runs of columns that both rows
  /// have before the diagonal of the other.
  /// @param other  At most `row`.
  template <typename Use>
  void for_each_common(std::size_t row, std::size_t other, Use&& use) const {
    const Run* b = runs_.data() + run_starts_[other];
    const Run* a = first_run_past(row, b->first);
    const Run* const end_b = runs_.data() + run_starts_[other + 1];
    // The last run of `row` reaches its diagonal. No run of the other row ends later.
    while (b != end_b && a->first < other) {
      const std::uint32_t first = std::max(a->first, b->first);
      const std::uint32_t end = std::min({a->end, b->end, static_cast<std::uint32_t>(other)});
      if (first < end) {
        use(a->block + (first - a->first), b->block + (first - b->first), end - first);
      }
      if (a->end < b->end) {
        ++a;
      } else {
        ++b;
      }
    }
  }

 private:
  /// First run of a row that ends past a column.
  [[nodiscard]] const Run* first_run_past(std::size_t row, std::size_t column) const {
    return std::partition_point(runs_.data() + run_starts_[row],
                                runs_.data() + run_starts_[row + 1],
                                [&](const Run& run) { return run.end <= column; });
  }

  DynamicArray<Run> runs_;
  DynamicArray<std::uint32_t> run_starts_{0};  // First run of each row, and past the last.
  DynamicArray<std::size_t> block_starts_{0};  // First block of each row, and past the last.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
