/// @file
/// One axis of a plot: its range, ticks and labels.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/bristle.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace figure {

inline constexpr double smallest_plotted = 1e-150;
inline constexpr double largest_plotted = 1e150;

/// A mark on an axis. The minor marks of a logarithmic axis have no label.
struct PlotTick {
  double value = 0;
  std::string label;
};

/// Range and ticks of one axis.
///
/// Widen it over the data with `include`, then `finish` it. A logarithmic axis takes only positive
/// values.
class PlotAxis {
 public:
  explicit PlotAxis(bool is_logarithmic = false) : is_logarithmic_(is_logarithmic) {}

  /// Returns whether a value has a position on the axis: finite, and > 0 on a logarithmic one.
  /// Values near the limits of a double have none: steps between ticks would leave its range.
  [[nodiscard]] bool shows(double value) const {
    return std::abs(value) < largest_plotted && (!is_logarithmic_ || value > smallest_plotted);
  }

  /// Widens the range to a value. Values without a position are ignored.
  void include(double value) {
    if (!shows(value)) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }

  /// Options that turn a range into an axis.
  struct Fit {
    /// [1] Part of the range that is added at both ends.
    double margin = 0;
    /// [-] Number of labels that fit. About as many or fewer are set.
    double room = 6;
    /// [-] Ends of the range; unset: those of the data with the margin.
    std::optional<double> low{};
    std::optional<double> high{};
  };

  /// Fixes the range and the ticks. A range without extent gets one.
  void finish(const Fit& fit);

  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double high() const { return high_; }
  [[nodiscard]] const std::vector<PlotTick>& ticks() const { return ticks_; }
  /// Name of the axis, followed by the power of ten that the tick labels leave out, if any.
  [[nodiscard]] std::string caption(const std::string& name) const;

  /// [1] Position of a value along the axis: 0 at its low end, 1 at its high end.
  [[nodiscard]] double place(double value) const {
    return (scaled(value) - scaled(low_)) / (scaled(high_) - scaled(low_));
  }

 private:
  [[nodiscard]] double scaled(double value) const {
    return is_logarithmic_ ? std::log10(value) : value;
  }
  void set_range(const Fit& fit);
  void set_linear_ticks(double room);
  void set_logarithmic_ticks(double room);

  bool is_logarithmic_;
  double low_ = std::numeric_limits<double>::infinity();
  double high_ = -std::numeric_limits<double>::infinity();
  int exponent_ = 0;  // of ten, a multiple of three; 0 for most data
  std::vector<PlotTick> ticks_;
};

// Implementation ----------------------------------------------------------------------------------

/// 10^exponent in Unicode superscripts.
[[nodiscard]] inline std::string power_of_ten(int exponent) {
  static constexpr const char* digits[] = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                           "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  std::string text = "10";
  for (const char c : std::to_string(exponent)) text += c == '-' ? "\u207b" : digits[c - '0'];
  return text;
}

/// A number with a fixed count of decimals and a real minus sign.
[[nodiscard]] inline std::string fixed_text(double value, int decimals) {
  char buffer[64];
  const auto result =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals);
  const std::string_view text(buffer, static_cast<std::size_t>(result.ptr - buffer));
  return text.starts_with('-') ? "\u2212" + std::string(text.substr(1)) : std::string(text);
}

inline std::string PlotAxis::caption(const std::string& name) const {
  return exponent_ == 0 ? name : name + " \u00d7 " + power_of_ten(exponent_);
}

inline void PlotAxis::finish(const Fit& fit) {
  set_range(fit);
  ticks_.clear();
  const double room = std::max(fit.room, 1.0);
  if (is_logarithmic_) {
    set_logarithmic_ticks(room);
  } else {
    set_linear_ticks(room);
  }
}

inline void PlotAxis::set_range(const Fit& fit) {
  if (low_ > high_) {  // no data
    low_ = is_logarithmic_ ? 1 : 0;
    high_ = is_logarithmic_ ? 10 : 1;
  }
  if (is_logarithmic_) {
    // At least one decade, so that there are labels to read values from.
    const double spread = std::log10(high_ / low_);
    const double factor = std::pow(10, std::max(fit.margin * spread, 0.5 * (1 - spread)));
    low_ = fit.low.value_or(low_ / factor);
    high_ = fit.high.value_or(high_ * factor);
    if (!(low_ < high_)) (fit.low ? high_ : low_) = fit.low ? 10 * low_ : high_ / 10;
  } else {
    const double extra = fit.margin * (high_ - low_);
    low_ = fit.low.value_or(low_ - extra);
    high_ = fit.high.value_or(high_ + extra);
    // A constant shows as a line in the middle, whatever its round-off.
    const double size = std::max(std::abs(low_), std::abs(high_));
    if (!(high_ - low_ > std::max(1e-12 * size, smallest_plotted))) {
      const double half = size > smallest_plotted ? 0.5 * size : 0.5;
      if (!fit.low) low_ = high_ - half;
      if (!fit.high || fit.low) high_ = low_ + 2 * half;
    }
  }
}

inline void PlotAxis::set_linear_ticks(double room) {
  // The smallest of 1, 2, 2.5 and 5 times a power of ten whose labels fit.
  const double least = (high_ - low_) / room;
  const double decade = std::pow(10, std::floor(std::log10(least)));
  double step = 10 * decade;
  for (const double multiple : {5.0, 2.5, 2.0, 1.0}) {
    if (multiple * decade >= least) step = multiple * decade;
  }
  const double size = std::max(std::abs(low_), std::abs(high_));
  const int magnitude = static_cast<int>(std::floor(std::log10(size)));
  exponent_ =
      magnitude >= 5 || magnitude < -3 ? 3 * static_cast<int>(std::floor(magnitude / 3.0)) : 0;
  const double unit = std::pow(10, exponent_);
  int decimals = 0;
  for (double rest = step / unit; decimals < 9; ++decimals, rest *= 10) {
    if (std::abs(rest - std::round(rest)) < 1e-6 * rest) break;
  }
  const double slack = 1e-9 * (high_ - low_);
  const double first = std::ceil((low_ - slack) / step);
  for (double k = first; k * step <= high_ + slack; k += 1) {
    const double value = k == 0 ? 0.0 : k * step;  // no minus zero
    ticks_.push_back({value, fixed_text(value / unit, decimals)});
  }
}

inline void PlotAxis::set_logarithmic_ticks(double room) {
  const double spread = std::log10(high_ / low_);
  const int stride = std::max(1, static_cast<int>(std::ceil(spread / room)));
  const int last = static_cast<int>(std::floor(std::log10(high_)));
  for (int decade = static_cast<int>(std::floor(std::log10(low_))); decade <= last; ++decade) {
    for (int digit = 1; digit <= 9; ++digit) {
      const double value = digit * std::pow(10, decade);
      if (value < low_ || value > high_) continue;
      // Less than two decades hold too few powers of ten to read values from.
      const bool has_label =
          digit == 1 ? decade % stride == 0 : spread < 2 && (digit == 2 || digit == 5);
      const std::string factor = digit == 1 ? "" : std::to_string(digit) + "\u00b7";
      if (digit > 1 && stride > 1) continue;
      ticks_.push_back({value, has_label ? factor + power_of_ten(decade) : ""});
    }
  }
}

}  // namespace figure
