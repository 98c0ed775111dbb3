// A table of measured figures: on the screen with aligned columns, in a CSV file with all digits,
// and with a verdict on each row that has one.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/file.hpp>
#include <bristle/sensors/sensor_parameters.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace figure {

/// One cell: its text in the table, and its entry in the file.
struct Cell {
  std::string shown;
  std::string recorded;

  Cell() = default;
  Cell(const char* words) : shown(words), recorded(words) {}
  Cell(std::string words) : shown(words), recorded(std::move(words)) {}
};

/// How a row calls the way its patches were integrated.
inline const char* name_of(bristle::Integration integration) {
  return integration == bristle::Integration::implicit ? "implicit" : "explicit";
}

/// Text of a number by a format of printf for a double.
inline std::string text(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

/// A number: shown by a format, or as less than `floor` where rounding decides its digits.
inline Cell number(const char* format, double value, double floor = 0) {
  Cell cell;
  cell.shown = std::abs(value) < floor ? "< " + text("%g", floor) : text(format, value);
  cell.recorded = text("%.9g", value);
  return cell;
}

class Table {
 public:
  /// @param heads  One for each column, with its unit: "dt [ms]".
  explicit Table(std::vector<Cell> heads) : rows_{std::move(heads)} {}

  void add(std::vector<Cell> cells) {
    cells.resize(rows_.front().size());
    rows_.push_back(std::move(cells));
  }
  /// The same with a verdict, which stands in a last column.
  void add(std::vector<Cell> cells, bool is_good) {
    if (!has_verdicts_) rows_.front().push_back("as it should");
    has_verdicts_ = true;
    cells.resize(rows_.front().size() - 1);
    cells.push_back(is_good ? "yes" : "NO");
    add(std::move(cells));
    is_good_ = is_good_ && is_good;
  }

  /// Returns whether no verdict was bad.
  [[nodiscard]] bool is_good() const { return is_good_; }

  void print() const {
    std::vector<std::size_t> widths(rows_.front().size());
    for (const auto& row : rows_) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        widths[i] = std::max(widths[i], row[i].shown.size());
      }
    }
    for (const auto& row : rows_) {
      std::string line;
      for (std::size_t i = 0; i < row.size(); ++i) {
        const std::string blank(widths[i] - row[i].shown.size(), ' ');
        // Names to the left, numbers to the right.
        line += i == 0 ? row[i].shown + blank : "  " + blank + row[i].shown;
      }
      line.erase(line.find_last_not_of(' ') + 1);
      std::puts(line.c_str());
    }
  }

  void write_csv(const std::filesystem::path& path) const {
    std::string csv;
    for (const auto& row : rows_) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        const std::string& field = row[i].recorded;
        if (i > 0) csv += ',';
        csv += field.find(',') == std::string::npos ? field : '"' + field + '"';
      }
      csv += '\n';
    }
    bristle::write_file(path, csv);
  }

 private:
  std::vector<std::vector<Cell>> rows_;
  bool has_verdicts_ = false;
  bool is_good_ = true;
};

}  // namespace figure
