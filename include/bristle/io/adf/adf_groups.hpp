/// @file
/// Collision filters for the groups of AMBF descriptions.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/filter.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_report.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace bristle::inline BRISTLE_ABI::detail {

/// Category bits of collision groups, for all descriptions of a world.
///
/// A body without a group meets everything. It has the default filter, as bodies do that no
/// description knows of. A body with groups meets these two and bodies that share a group with it.
class AdfGroups {
 public:
  /// Gives the groups of a model their bits. Group g has bit g + 1 where that is free, so that the
  /// bits of small numbers do not depend on the order of bodies.
  void add(const AdfModel& model) {
    for (const AdfBody& body : model.bodies) {
      for (const std::size_t group : body.collision_groups) {
        if (group + 1 < bits) claim(group, std::uint32_t{2} << group);
      }
    }
    for (const AdfBody& body : model.bodies) {
      for (const std::size_t group : body.collision_groups) {
        if (claim(group, std::bit_floor(~used_))) continue;
        raise(AdfError(model.file.string(), body.line, body.key + "/collision groups",
                       std::to_string(group),
                       "must not be one of more than 31 different ones in a world"));
      }
    }
  }

  /// Filter of a body whose model was added.
  [[nodiscard]] CollisionFilter filter_of(const AdfBody& body) const {
    CollisionFilter filter;
    if (body.collision_groups.empty()) return filter;
    std::uint32_t own = 0;
    for (const std::size_t group : body.collision_groups) own |= bit_of_.at(group);
    const std::uint32_t everybody = filter.category;
    filter.category = own;
    filter.mask = everybody | own;
    return filter;
  }

 private:
  /// [-] Bits of a filter.
  static constexpr std::size_t bits = 32;

  /// Gives a group a bit unless it has one. False if the group is left without.
  bool claim(std::size_t group, std::uint32_t bit) {
    if (bit_of_.count(group) != 0) return true;
    if (bit == 0 || (used_ & bit) != 0) return false;
    used_ |= bit;
    bit_of_.emplace(group, bit);
    return true;
  }

  std::uint32_t used_ = CollisionFilter{}.category;
  std::map<std::size_t, std::uint32_t> bit_of_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
