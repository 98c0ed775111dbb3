/// @file
/// Calls a function with the shape that a variant holds.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>

#include <type_traits>
#include <variant>

namespace bristle::inline BRISTLE_ABI::detail {

/// Does what `std::visit` does for one variant of eight or nine shapes, by a switch. `std::visit`
/// makes a function and an entry of a table for each case, and a compiler cannot inline what it
/// calls through the table (decision 0045). Throws std::bad_variant_access where the variant holds
/// nothing, as it may after an assignment that threw.
template <typename Visitor, typename... Shapes>
auto visit_shape(Visitor&& visitor, const std::variant<Shapes...>& shape)
    -> decltype(visitor(std::get<0>(shape))) {
  constexpr std::size_t count = sizeof...(Shapes);
  static_assert(count == 8 || count == 9, "a shape more needs a case more");
  switch (shape.index()) {
    case 0: return visitor(*std::get_if<0>(&shape));
    case 1: return visitor(*std::get_if<1>(&shape));
    case 2: return visitor(*std::get_if<2>(&shape));
    case 3: return visitor(*std::get_if<3>(&shape));
    case 4: return visitor(*std::get_if<4>(&shape));
    case 5: return visitor(*std::get_if<5>(&shape));
    case 6: return visitor(*std::get_if<6>(&shape));
    case 7:
      if constexpr (count == 9) return visitor(*std::get_if<7>(&shape));
      [[fallthrough]];
    default: return visitor(std::get<count - 1>(shape));
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
