/// @file
/// The chosen constants of headers that `instrument.cmake` has made variables of.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

namespace bristle_constants {

/// A constant that can be scaled.
struct Constant {
  std::string name;
  double value = 0;
  /// Sets it to this many times its value. An integer is rounded, and stays at least 1.
  std::function<void(double)> scale{};
};

/// All of them, in the order of their headers.
inline std::vector<Constant>& all() {
  static std::vector<Constant> constants;
  return constants;
}

/// Lists one of them.
struct Row {
  template <typename T>
  Row(const char* name, T& variable) {
    const T value = variable;
    all().push_back({name, static_cast<double>(value), [&variable, value](double factor) {
                       const double scaled = factor * static_cast<double>(value);
                       if constexpr (static_cast<T>(0.5) > T(0)) {
                         variable = static_cast<T>(scaled);
                       } else {
                         variable = std::max(T(1), static_cast<T>(scaled + 0.5));
                       }
                     }});
  }
};

}  // namespace bristle_constants
