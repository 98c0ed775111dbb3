/// @file
/// Names must be UTF-8, since the files that keep them are.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace bristle::inline BRISTLE_ABI::detail {

/// Number of the first byte of `text` that is no UTF-8 (RFC 3629), or its size where all is:
/// neither overlong forms, nor surrogates, nor anything above U+10FFFF.
[[nodiscard]] inline std::size_t first_not_utf8(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  for (std::size_t i = 0; i < text.size();) {
    const unsigned char lead = byte(i);
    const std::size_t length = lead < 0x80                   ? 1
                               : lead >= 0xc2 && lead < 0xe0 ? 2
                               : lead >= 0xe0 && lead < 0xf0 ? 3
                               : lead >= 0xf0 && lead < 0xf5 ? 4
                                                             : 0;
    if (length == 0 || i + length > text.size()) return i;
    for (std::size_t k = 1; k < length; ++k) {
      // The second byte has a smaller range where the first alone would let wrong forms pass.
      const bool is_second = k == 1;
      const unsigned char low = is_second && lead == 0xe0   ? 0xa0
                                : is_second && lead == 0xf0 ? 0x90
                                                            : 0x80;
      const unsigned char high = is_second && lead == 0xed   ? 0x9f
                                 : is_second && lead == 0xf4 ? 0x8f
                                                             : 0xbf;
      if (byte(i + k) < low || byte(i + k) > high) return i;
    }
    i += length;
  }
  return text.size();
}

/// Raises InvalidArgument, unless a name is UTF-8. It shows the other bytes in hexadecimal.
inline void require_utf8(std::string_view field, std::string_view name) {
  if (first_not_utf8(name) == name.size()) return;
  std::string shown;
  for (std::string_view rest = name; !rest.empty();) {
    const std::size_t good = first_not_utf8(rest);
    shown += rest.substr(0, good);
    if (good == rest.size()) break;
    constexpr char digits[] = "0123456789abcdef";
    const auto wrong = static_cast<unsigned char>(rest[good]);
    shown += "\\x";
    shown += digits[wrong >> 4];
    shown += digits[wrong & 15];
    rest.remove_prefix(good + 1);
  }
  raise(InvalidArgument(std::string(field), shown, "must be UTF-8"));
}

}  // namespace bristle::inline BRISTLE_ABI::detail
