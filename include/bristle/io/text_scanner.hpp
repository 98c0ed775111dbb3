/// @file
/// Words and numbers of a line-oriented text file, with their line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/math/types.hpp>

#include <charconv>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <system_error>

namespace bristle::inline BRISTLE_ABI::detail {

/// Converts A-Z to a-z, in any locale.
[[nodiscard]] inline std::string to_lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

/// Reads a text word by word. A backslash at the end of a line joins it with the next. Numbers are
/// read the same way in every locale.
class TextScanner {
 public:
  /// @param file  Name for error messages.
  TextScanner(std::string_view text, std::string_view file) : text_(text), file_(file) {}

  /// 1-based line of the last word.
  [[nodiscard]] std::size_t line() const { return word_line_; }

  /// Next word on any line. Empty at the end of the text.
  [[nodiscard]] std::string_view word() {
    while (skip_space() || skip_line_break()) {
    }
    return take_word();
  }

  /// Next word on the current line. Empty at its end.
  [[nodiscard]] std::string_view word_on_line() {
    while (skip_space()) {
    }
    return take_word();
  }

  /// Skips to the end of the current line, ignoring joins.
  void skip_line() {
    while (position_ < text_.size() && text_[position_] != '\n') ++position_;
  }

  /// Parses a word as a finite number of scalar S.
  template <Scalar S>
  [[nodiscard]] S number(std::string_view word) const {
    double value = 0.0;
    // from_chars rejects a leading plus; "+-1" stays an error.
    const std::string_view digits =
        word.size() > 1 && word[0] == '+' && word[1] != '-' ? word.substr(1) : word;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool is_read = error == std::errc{} && end == digits.data() + digits.size();
    if (!is_read || !has_finite_square(S(value))) {
      fail(word.empty() ? "number missing" : quoted(word) + " is not a finite number");
    }
    return S(value);
  }

  [[noreturn]] void fail(const std::string& what) const {
    raise(IoError(std::string(file_), word_line_, what));
  }

  /// A word for messages: in quotes, short, and without control characters.
  [[nodiscard]] static std::string quoted(std::string_view word) {
    constexpr std::size_t longest_shown = 40;
    std::string text("'");
    for (const char c : word.substr(0, longest_shown)) text += c < ' ' || c > '~' ? '?' : c;
    return text += "'";
  }

 private:
  [[nodiscard]] bool is_at(char c) const {
    return position_ < text_.size() && text_[position_] == c;
  }
  [[nodiscard]] bool is_at_space() const {
    return is_at(' ') || is_at('\t') || is_at('\r') || is_at('\v') || is_at('\f');
  }
  /// Length of a backslash and the line break after it, which join two lines; 0 if there is none.
  [[nodiscard]] std::size_t joint_size() const {
    if (!is_at('\\')) return 0;
    const std::string_view rest = text_.substr(position_ + 1, 2);
    if (rest.starts_with('\n')) return 2;
    return rest == "\r\n" ? 3 : 0;
  }

  /// Skips one space or line join. Returns whether there was one.
  bool skip_space() {
    const std::size_t joint = joint_size();
    if (joint > 0) {
      position_ += joint;
      ++line_;
      return true;
    }
    if (!is_at_space()) return false;
    ++position_;
    return true;
  }
  bool skip_line_break() {
    if (!is_at('\n')) return false;
    ++position_;
    ++line_;
    return true;
  }

  [[nodiscard]] std::string_view take_word() {
    const std::size_t start = position_;
    while (position_ < text_.size() && !is_at_space() && !is_at('\n') && joint_size() == 0) {
      ++position_;
    }
    word_line_ = line_;
    return text_.substr(start, position_ - start);
  }

  std::string_view text_;
  std::string_view file_;
  std::size_t position_ = 0;
  std::size_t line_ = 1;
  std::size_t word_line_ = 1;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
