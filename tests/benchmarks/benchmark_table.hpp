/// @file
/// Tables of a benchmark: on the screen, and as markdown.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace bristle::benchmarks {

/// A number with three significant digits, without an exponent where that is readable.
[[nodiscard]] inline std::string in_short(double value) {
  char text[32];
  const bool is_plain = value == 0 || (value >= 0.01 && value < 1e7);
  std::snprintf(text, sizeof text, !is_plain ? "%.0e" : value >= 100 ? "%.0f" : "%.3g", value);
  return text;
}

/// A number with all digits that matter.
[[nodiscard]] inline std::string in_full(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// Prints each row as soon as it is known.
class Table {
 public:
  Table(bool is_markdown, std::vector<std::string> columns)
      : is_markdown_(is_markdown), columns_(std::move(columns)) {
    print(columns_);
    if (!is_markdown_) return;
    for (std::size_t i = 0; i < columns_.size(); ++i) std::fputs("|---", stdout);
    std::puts("|");
  }
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;
  ~Table() { std::puts(""); }

  void add(const std::vector<std::string>& cells) { print(cells); }

 private:
  void print(const std::vector<std::string>& cells) const {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (is_markdown_) {
        std::printf("| %s ",
                    cells[i].c_str() + std::min(cells[i].find_first_not_of(' '), cells[i].size()));
      } else {
        const int width = std::max(8, static_cast<int>(columns_[i].size()));
        std::printf("%*s  ", width, cells[i].c_str());
      }
    }
    std::puts(is_markdown_ ? "|" : "");
    std::fflush(stdout);
  }

  bool is_markdown_;
  std::vector<std::string> columns_;
};

}  // namespace bristle::benchmarks
