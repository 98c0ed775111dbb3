/// @file
/// The few forms of JSON that glTF is written with.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <charconv>
#include <concepts>
#include <cstddef>
#include <string>
#include <string_view>

namespace bristle::inline BRISTLE_ABI::detail {

/// All of the parts, one after another.
template <typename... Parts>
[[nodiscard]] std::string joined_text(const Parts&... parts) {
  std::string out;
  ((out += parts), ...);
  return out;
}

/// A comma-separated list of JSON values.
class JsonList {
 public:
  /// Appends a value and returns its number.
  std::size_t add(std::string_view value) {
    if (count_ > 0) text_ += ',';
    text_ += value;
    return count_++;
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] std::string array() const { return joined_text('[', text_, ']'); }

 private:
  std::string text_;
  std::size_t count_ = 0;
};

[[nodiscard]] inline std::string json_text(std::string_view text) {
  std::string json = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') json += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      constexpr char digits[] = "0123456789abcdef";
      json += joined_text("\\u00", digits[c >> 4], digits[c & 15]);
    } else {
      json += c;
    }
  }
  json += '"';
  return json;
}

template <std::integral T>
[[nodiscard]] std::string json_number(T x) {
  return std::to_string(x);
}
[[nodiscard]] inline std::string json_number(float x) {
  // The shortest text of a float has at most 15 characters.
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, x).ptr};
}

template <typename Values>
[[nodiscard]] std::string json_numbers(const Values& values) {
  JsonList list;
  for (const auto x : values) (void)list.add(json_number(x));
  return list.array();
}

}  // namespace bristle::inline BRISTLE_ABI::detail
