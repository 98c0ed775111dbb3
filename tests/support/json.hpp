/// @file
/// A reader of JSON, to look into what was written.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cctype>
#include <concepts>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace bristle::test {

/// A value with what is in it. Wrong JSON, keys that are not there and numbers out of range throw.
class Json {
 public:
  explicit Json(const std::string& text) {
    std::size_t at = 0;
    *this = Json(text, at);
    skip_space(text, at);
    if (at != text.size()) throw std::runtime_error("JSON: more after the value");
  }

  [[nodiscard]] const Json& operator[](const char* key) const { return members_.at(key); }
  template <std::integral I>
  [[nodiscard]] const Json& operator[](I i) const {
    return items_.at(static_cast<std::size_t>(i));
  }
  [[nodiscard]] bool has(const char* key) const { return members_.count(key) > 0; }
  [[nodiscard]] std::size_t size() const { return items_.size(); }
  [[nodiscard]] const std::vector<Json>& items() const { return items_; }
  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] double number() const {
    char* end = nullptr;
    const double x = std::strtod(text_.c_str(), &end);
    if (text_.empty() || *end != '\0') throw std::runtime_error("JSON: no number: " + text_);
    return x;
  }
  [[nodiscard]] std::size_t index() const { return static_cast<std::size_t>(number()); }

 private:
  Json(const std::string& text, std::size_t& at) {
    skip_space(text, at);
    const char first = text.at(at);
    if (first == '{' || first == '[') {
      const char last = first == '{' ? '}' : ']';
      ++at;
      for (skip_space(text, at); text.at(at) != last; skip_space(text, at)) {
        if (!items_.empty() || !members_.empty()) expect(text, at, ',');
        if (first == '[') {
          items_.push_back(Json(text, at));
          continue;
        }
        skip_space(text, at);
        const std::string key = quoted(text, at);
        expect(text, at, ':');
        if (!members_.emplace(key, Json(text, at)).second) {
          throw std::runtime_error("JSON: twice: " + key);
        }
      }
      ++at;
    } else if (first == '"') {
      text_ = quoted(text, at);
    } else {
      while (at < text.size() && std::string_view(",]} \n").find(text[at]) == std::string::npos) {
        text_ += text[at++];
      }
    }
  }
  static void skip_space(const std::string& text, std::size_t& at) {
    while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at]))) ++at;
  }
  static void expect(const std::string& text, std::size_t& at, char c) {
    skip_space(text, at);
    if (text.at(at++) != c) throw std::runtime_error(std::string("JSON: expected ") + c);
  }
  static std::string quoted(const std::string& text, std::size_t& at) {
    expect(text, at, '"');
    std::string out;
    while (text.at(at) != '"') {
      if (static_cast<unsigned char>(text[at]) < 0x20) throw std::runtime_error("JSON: a control");
      if (text[at] == '\\' && text.at(++at) == 'u') {
        out += static_cast<char>(std::stoi(text.substr(at + 1, 4), nullptr, 16));
        at += 5;
        continue;
      }
      out += text.at(at++);
    }
    ++at;
    return out;
  }

  std::string text_;
  std::vector<Json> items_;
  std::map<std::string, Json> members_;
};

}  // namespace bristle::test
