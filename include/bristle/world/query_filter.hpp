/// @file
/// Filter of the bodies that rays, sensors and queries meet.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/body.hpp>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Bodies that a query meets: those of the categories in `sense_mask` that are not `excluded`.
struct QueryFilter {
  /// [-] Categories of the bodies that are met. Collision masks do not matter.
  std::uint32_t sense_mask = 0xffffffffu;
  /// [-] Bodies that are not met. A ray that starts on a body excludes it, as a rule.
  std::vector<BodyId> excluded{};
  /// [-] True if shapes that are triggers are met, too.
  bool meets_triggers = false;
};

namespace detail {

/// Returns whether a filter lets a query meet a body.
/// @param filter  Anything with `sense_mask` and `excluded`.
template <typename Filter, Scalar S>
[[nodiscard]] bool can_meet(const Filter& filter, BodyId id, const Body<S>& body) {
  return (filter.sense_mask & body.filter.category) != 0 &&
         std::find(filter.excluded.begin(), filter.excluded.end(), id) == filter.excluded.end();
}

/// Returns whether a query meets a shape.
/// @param shape  A `Collider`.
template <typename Shape, Scalar S>
[[nodiscard]] bool can_meet_shape(const QueryFilter& filter, const Shape& shape,
                                  const Body<S>& body) {
  return (filter.meets_triggers || !shape.is_trigger) && can_meet(filter, shape.body, body);
}

}  // namespace detail
}  // namespace bristle::inline BRISTLE_ABI
