/// @file
/// Patterns of sparse matrices, for tests of their factors.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/block_pattern.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace bristle::test {

/// Pattern of the factors of a matrix.
/// @param has_block  Returns whether the matrix has block (i, j), i > j.
template <typename HasBlock>
detail::BlockPattern pattern_with_fill(std::size_t rows, const HasBlock& has_block) {
  std::vector<std::vector<bool>> is_block(rows, std::vector<bool>(rows));
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < i; ++j) is_block[i][j] = has_block(i, j);
  }
  // Column k is eliminated: what it reaches becomes coupled.
  for (std::size_t k = 0; k < rows; ++k) {
    for (std::size_t i = k + 1; i < rows; ++i) {
      for (std::size_t j = k + 1; j < i; ++j) {
        if (is_block[i][k] && is_block[j][k]) is_block[i][j] = true;
      }
    }
  }
  detail::BlockPattern pattern;
  for (std::size_t i = 0; i < rows; ++i) {
    std::vector<std::uint32_t> columns;
    for (std::size_t j = 0; j < i; ++j) {
      if (is_block[i][j]) columns.push_back(static_cast<std::uint32_t>(j));
    }
    pattern.add_row(columns);
  }
  return pattern;
}

/// Pattern with all blocks.
inline detail::BlockPattern full_pattern(std::size_t rows) {
  return pattern_with_fill(rows, [](std::size_t, std::size_t) { return true; });
}

}  // namespace bristle::test
