/// @file
/// Damaged files: a few random changes to a text that was good.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/random.hpp"

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>

namespace bristle::test {

/// A text with one to four changes: a byte replaced, a piece left out or repeated, the end cut off,
/// or one of `words` put in.
inline std::string damaged(std::string text, Random& random, std::span<const char* const> words) {
  const std::size_t changes = 1 + random.index(4);
  for (std::size_t i = 0; i < changes && !text.empty(); ++i) {
    const std::size_t at = random.index(text.size());
    const std::size_t length = random.index(std::min<std::size_t>(text.size() - at, 200) + 1);
    switch (random.index(6)) {
      case 0:
        text[at] = static_cast<char>(random.index(256));
        break;
      case 1:
        text.resize(at);
        break;
      case 2:
        text.erase(at, length);
        break;
      case 3:
        text.insert(random.index(text.size()), text.substr(at, length));
        break;
      default:
        text.insert(at, words[random.index(words.size())]);
        break;
    }
  }
  return text;
}

}  // namespace bristle::test
