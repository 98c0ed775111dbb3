/// @file
/// Numbers recorded over time: named channels with units, written as CSV.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/io/file.hpp>

#include <charconv>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// One column of a trace.
struct TraceChannel {
  /// [-] Name. Unique in the trace.
  std::string name;
  /// [-] Unit. Empty for none.
  std::string unit;

  /// Label in plots and tables: "height [m]", or the name alone without a unit.
  [[nodiscard]] std::string label() const { return unit.empty() ? name : name + " [" + unit + "]"; }
};

}  // namespace detail

/// A table that grows by rows and is read by columns.
///
///     Trace trace{{"time", "s"}, {"height", "m"}};
///     trace.add_row({t, z});
///     trace.write_csv("fall.csv");
///     const auto heights = trace.column("height");
///
/// Values are kept as double, whatever scalar the simulation uses. A value that is not finite is
/// kept too, and written as `nan`, `inf` or `-inf`: a gap in a record is part of the record.
class Trace {
 public:
  /// @throws InvalidArgument when there is no channel, or one has no name or that of another.
  Trace(std::initializer_list<detail::TraceChannel> channels)
      : Trace(std::vector<detail::TraceChannel>(channels)) {}
  /// @throws InvalidArgument when there is no channel, or one has no name or that of another.
  explicit Trace(std::vector<detail::TraceChannel> channels);

  /// Appends one value per channel, in the order of the channels.
  /// @throws InvalidArgument if there are more or fewer values than channels.
  void add_row(std::span<const double> values);
  /// The same for a list of values.
  void add_row(std::initializer_list<double> values) {
    add_row(std::span<const double>(values.begin(), values.size()));
  }

  /// Allocates memory for rows, so that adding them does not.
  void reserve(std::size_t rows) {
    for (std::vector<double>& column : columns_) column.reserve(rows);
  }

  /// Channels in the order of their columns.
  [[nodiscard]] const std::vector<detail::TraceChannel>& channels() const noexcept {
    return channels_;
  }
  /// [-] Number of rows.
  [[nodiscard]] std::size_t size() const noexcept { return columns_.front().size(); }

  /// Returns all values of a channel, oldest first. Valid until the next row is added.
  /// @throws InvalidArgument if no channel has the name.
  [[nodiscard]] const std::vector<double>& column(std::string_view name) const;

  /// Returns the table as comma-separated values (RFC 4180, lines ending in LF). The labels of the
  /// channels come first, then the rows.
  ///
  /// @param digits  [-] Significant digits, 1 to 17. 9 distinguish any two floats, 17 any two
  ///                doubles.
  /// @note A dot is the decimal point in every locale.
  /// @throws InvalidArgument if the digits are out of range.
  [[nodiscard]] std::string csv(int digits = 9) const;

  /// Writes `csv` to a file, replacing an existing one.
  /// @throws IoError if it cannot be written in full.
  void write_csv(const std::string& path, int digits = 9) const { write_file(path, csv(digits)); }

 private:
  std::vector<detail::TraceChannel> channels_;
  std::vector<std::vector<double>> columns_;
};

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// Appends a number like "%.*g" in the C locale. A NaN has no sign.
inline void append_general(std::string& text, double value, int digits) {
  if (std::isnan(value)) {
    text += "nan";
    return;
  }
  // A sign, 17 digits, a point and an exponent are 24 characters.
  char buffer[32];
  const auto result =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, digits);
  text.append(buffer, result.ptr);
}

/// Appends a field of a CSV file, in quotes if necessary.
inline void append_csv_field(std::string& text, std::string_view field) {
  if (field.find_first_of(",\"\r\n") == std::string_view::npos) {
    text += field;
    return;
  }
  text += '"';
  for (const char c : field) {
    if (c == '"') text += '"';
    text += c;
  }
  text += '"';
}

}  // namespace detail

inline Trace::Trace(std::vector<detail::TraceChannel> channels)
    : channels_(std::move(channels)), columns_(channels_.size()) {
  detail::require(!channels_.empty(), "Trace: number of channels", 0, "must be > 0");
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const auto fail = [&](const char* rule) {
      detail::raise(InvalidArgument("TraceChannel[" + std::to_string(i) + "]::name",
                                    '"' + channels_[i].name + '"', rule));
    };
    if (channels_[i].name.empty()) fail("must not be empty");
    for (std::size_t k = 0; k < i; ++k) {
      if (channels_[k].name == channels_[i].name) fail("must be unique in the trace");
    }
  }
}

inline void Trace::add_row(std::span<const double> values) {
  detail::require(values.size() == columns_.size(), "Trace::add_row: number of values",
                  values.size(),
                  "must be the number of channels, " + std::to_string(columns_.size()));
  for (std::size_t i = 0; i < values.size(); ++i) columns_[i].push_back(values[i]);
}

inline const std::vector<double>& Trace::column(std::string_view name) const {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (channels_[i].name == name) return columns_[i];
  }
  detail::raise(InvalidArgument("Trace::column: name", '"' + std::string(name) + '"',
                                "must be that of a channel"));
}

inline std::string Trace::csv(int digits) const {
  detail::require(digits >= 1 && digits <= 17, "Trace::csv: digits", digits, "must be in [1, 17]");
  std::string text;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (i > 0) text += ',';
    detail::append_csv_field(text, channels_[i].label());
  }
  text += '\n';
  for (std::size_t row = 0; row < size(); ++row) {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (i > 0) text += ',';
      detail::append_general(text, columns_[i][row], digits);
    }
    text += '\n';
  }
  return text;
}

}  // namespace bristle::inline BRISTLE_ABI
