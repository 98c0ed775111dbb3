/// @file
/// Who may touch, and sense, whom.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// Categories and groups of a body. Two bodies meet when each one's mask has a bit of the other's
/// category and they are not of the same negative group.
struct CollisionFilter {
  /// [-] Bits that say what this body is.
  std::uint32_t category = 1;
  /// [-] Bits of the categories this body meets.
  std::uint32_t mask = 0xffffffffu;
  /// [-] Bodies of one negative group never meet, whatever the bits say; 0 and positive groups mean
  /// nothing. For the links of one hand, say.
  std::int32_t group = 0;
};

[[nodiscard]] constexpr bool may_meet(const CollisionFilter& a, const CollisionFilter& b) {
  if (a.group < 0 && a.group == b.group) return false;
  return (a.mask & b.category) != 0 && (b.mask & a.category) != 0;
}

}  // namespace bristle::inline BRISTLE_ABI
