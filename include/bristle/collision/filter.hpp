/// @file
/// Collision filters of bodies and sensors.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// Categories and groups of a body. Two bodies meet if each one's mask has a bit of the other's
/// category. They must not share a negative group.
struct CollisionFilter {
  /// [-] Category bits of this body.
  std::uint32_t category = 1;
  /// [-] Category bits of the bodies that it meets.
  std::uint32_t mask = 0xffffffffu;
  /// [-] Bodies of one negative group never meet, whatever the bits say. Other groups have no
  /// effect. For the links of one hand, say.
  std::int32_t group = 0;
};

/// Returns whether two bodies meet.
[[nodiscard]] constexpr bool may_meet(const CollisionFilter& a, const CollisionFilter& b) {
  if (a.group < 0 && a.group == b.group) return false;
  return (a.mask & b.category) != 0 && (b.mask & a.category) != 0;
}

}  // namespace bristle::inline BRISTLE_ABI
