/// @file
/// The two exceptions that a caller can meet, and the checks that raise them.
///
/// A caller's bad data ends in `InvalidArgument` or `IoError`. The call that brought it throws in
/// every build type. It throws before it changes anything. Nothing from `World::step` down ever
/// throws.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

/// A caller's value breaks a rule. Reads "BodyDef::mass = -1: must be finite and > 0".
class InvalidArgument : public std::invalid_argument {
 public:
  /// The three parts of the message, as `field()`, `value()` and `rule()` return them.
  InvalidArgument(std::string field, std::string value, std::string rule)
      : std::invalid_argument(field + " = " + value + ": " + rule),
        field_(std::move(field)),
        value_(std::move(value)),
        rule_(std::move(rule)) {}

  /// Name of the offending field or argument, with its struct ("BodyDef::mass").
  [[nodiscard]] const std::string& field() const noexcept { return field_; }
  /// The offending value as text.
  [[nodiscard]] const std::string& value() const noexcept { return value_; }
  /// The rule it breaks ("must be finite and > 0").
  [[nodiscard]] const std::string& rule() const noexcept { return rule_; }

 private:
  std::string field_;
  std::string value_;
  std::string rule_;
};

/// A file could not be read, written or understood. Reads "part.obj:12: face with 2 corners".
class IoError : public std::runtime_error {
 public:
  /// @param line  1-based line of a text file. It is 0 where lines have no meaning.
  IoError(std::string file, std::size_t line, const std::string& what)
      : std::runtime_error(file + (line > 0 ? ":" + std::to_string(line) : "") + ": " + what),
        file_(std::move(file)),
        line_(line) {}

  /// The file as the caller named it.
  [[nodiscard]] const std::string& file() const noexcept { return file_; }
  /// 1-based line, or 0 where lines have no meaning.
  [[nodiscard]] std::size_t line() const noexcept { return line_; }

 private:
  std::string file_;
  std::size_t line_;
};

namespace detail {

/// Largest number that a definition may hold, and largest inverse of a divisor. The squares of
/// three such numbers have a finite sum. So has any product of two. 6.7e153 in double, 9.2e18 in
/// float.
template <typename S>
inline constexpr S largest_number = [] {
  S result(1);
  for (int i = 0; i < (std::numeric_limits<S>::max_exponent - 2) / 2; ++i) result = result * S(2);
  return result;
}();

/// Returns whether a number and its square are finite (`largest_number`).
template <typename S>
[[nodiscard]] bool has_finite_square(const S& value) {
  return value <= largest_number<S> && value >= -largest_number<S>;
}

/// Throws `error`, or ends the program where exceptions are compiled away.
template <typename Exception>
[[noreturn]] inline void raise(const Exception& error) {
#if defined(__cpp_exceptions)
  throw error;
#else
  BRISTLE_FATAL(error.what());
#endif
}

/// Text of a number that reads back as the same float ("%.9g"), or has all digits of an integer.
template <typename S>
[[nodiscard]] std::string to_text(const S& value) {
  char buffer[32];
  // In a host's object file snprintf leaves less than std::to_string, which is inline.
  if constexpr (std::is_unsigned_v<S>) {
    std::snprintf(buffer, sizeof buffer, "%llu", static_cast<unsigned long long>(value));
  } else if constexpr (std::is_integral_v<S>) {
    std::snprintf(buffer, sizeof buffer, "%lld", static_cast<long long>(value));
  } else {
    std::snprintf(buffer, sizeof buffer, "%.9g", static_cast<double>(value));
  }
  return buffer;
}

/// Text of a value: returns text unchanged.
[[nodiscard]] inline std::string to_text(const char* value) { return value; }

/// Raises InvalidArgument{field, value, rule}. Functions of their own raise, so that
/// the many checks stay small.
template <typename S>
[[noreturn]] BRISTLE_COLD void raise_invalid(std::string_view field, const S& value,
                                             std::string_view rule) {
  raise(InvalidArgument(std::string(field), to_text(value), std::string(rule)));
}
/// The same for a number whose square is not finite.
template <typename S>
[[noreturn]] BRISTLE_COLD void raise_too_large(std::string_view field, const S& value) {
  raise_invalid(
      field, value,
      "must be at most " + to_text(largest_number<S>) + " in size: its square has to be finite");
}
/// The same for a divisor whose inverse has no finite square.
template <typename S>
[[noreturn]] BRISTLE_COLD void raise_too_small(std::string_view field, const S& value) {
  raise_invalid(field, value,
                "must be at least " + to_text(S(1) / largest_number<S>) +
                    ": the square of its inverse has to be finite");
}

/// Raises InvalidArgument{field, value, rule} unless `holds`.
template <typename S>
void require(bool holds, std::string_view field, const S& value, std::string_view rule) {
  if (!holds) raise_invalid(field, value, rule);
}

/// Raises InvalidArgument{field} unless a value is an enumerator, of those from zero to `last`.
template <typename Enum>
void require_enumerator(std::string_view field, Enum value, Enum last) {
  const auto number = static_cast<long long>(value);
  require(number >= 0 && number <= static_cast<long long>(last), field, number,
          "must be an enumerator");
}
/// Raises InvalidArgument{field, value} unless `count` things can be numbered in 32 bits.
template <typename S>
void require_countable(std::string_view field, const S& value, std::uint64_t count) {
  require(count <= std::numeric_limits<std::uint32_t>::max(), field, value,
          "must be smaller: vertices are numbered in 32 bits");
}

/// Returns whether a number is finite and has all its digits. It is then neither zero nor
/// subnormal.
template <typename S>
[[nodiscard]] bool is_normal(const S& value) {
  using Limits = std::numeric_limits<S>;
  const S size = value < S(0) ? -value : value;
  return size >= Limits::min() && size <= Limits::max();
}

/// Raises InvalidArgument if the square of a finite number is not finite.
template <typename S>
void require_finite_square(std::string_view field, const S& value) {
  if (!has_finite_square(value)) raise_too_large(field, value);
}

/// Raises InvalidArgument unless a number and its square are finite.
template <typename S>
void require_finite(std::string_view field, const S& value) {
  using std::isfinite;
  require(isfinite(value), field, value, "must be finite");
  require_finite_square(field, value);
}

/// Raises InvalidArgument unless a number is finite and > 0. Its square and that of its inverse
/// must be finite, too.
template <typename S>
void require_positive(std::string_view field, const S& value) {
  using std::isfinite;
  require(isfinite(value) && value > S(0), field, value, "must be finite and > 0");
  require_finite_square(field, value);
  if (!(value * largest_number<S> >= S(1))) raise_too_small(field, value);
}

/// Raises InvalidArgument unless a number is finite and >= 0. Its square must be finite, too.
template <typename S>
void require_not_negative(std::string_view field, const S& value) {
  using std::isfinite;
  require(isfinite(value) && value >= S(0), field, value, "must be finite and >= 0");
  require_finite_square(field, value);
}

/// Raises what is wrong with number `i` of a field.
template <typename S>
BRISTLE_COLD void raise_entry(std::string_view field, std::ptrdiff_t i, const S& value) {
  require_finite(std::string(field) + "[" + std::to_string(i) + "]", value);
}

/// Applies `require_finite` to every coefficient of an Eigen expression. The message names the
/// first one that fails.
template <typename Matrix>
void require_all_finite(std::string_view field, const Matrix& values) {
  for (std::ptrdiff_t i = 0; i < values.size(); ++i) {
    if (!has_finite_square(values.coeff(i))) raise_entry(field, i, values.coeff(i));
  }
}

}  // namespace detail
}  // namespace bristle::inline BRISTLE_ABI
