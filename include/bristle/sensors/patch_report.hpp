/// @file
/// Likely faults of a patch where it sits.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/math/types.hpp>
#include <bristle/sensors/sensor_constants.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Figures of a patch on its body and in its world, from `World::patch_report`. Such a patch is
/// valid, but may not do what its author wants: `warnings` says where.
template <Scalar S>
struct PatchReport {
  /// [1] Share of each ray's length, from its end, up to where it last leaves the shapes of its own
  /// body: 0 if it ends inside, 1 if it meets none of them.
  std::vector<S> share_outside{};
  /// [N] Sum of all normal forces at depth 1: the patch can carry no more.
  S largest_load = S(0);
  /// [N] Load that the constants are for (`PatchDef::load`); 0 where that is not known.
  S intended_load = S(0);
  /// [N] Weight of the lightest dynamic body among the patch's own and those that it may sense. 0
  /// without one, and without gravity.
  S least_weight = S(0);
  /// [N] Weight of the heaviest of them.
  S largest_weight = S(0);
  /// [N] Sum of the normal forces in the last step.
  S load = S(0);
  /// [-] Sensors pressed in over their whole length in the last step.
  std::size_t bottomed_out = 0;

  /// Indices of the sensors whose rays are buried.
  [[nodiscard]] std::vector<std::uint32_t> buried() const {
    std::vector<std::uint32_t> found;
    for (std::size_t i = 0; i < share_outside.size(); ++i) {
      if (share_outside[i] < S(detail::chosen::buried_ray_share))
        found.push_back(static_cast<std::uint32_t>(i));
    }
    return found;
  }

  /// A sentence for each thing that is likely to be wrong; none if nothing is.
  [[nodiscard]] std::vector<std::string> warnings() const;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
std::vector<std::string> PatchReport<S>::warnings() const {
  using detail::to_text;
  std::vector<std::string> lines;
  const auto of_all = [&](std::size_t count) {
    return to_text(count) + " of " + to_text(share_outside.size()) + " sensors";
  };
  if (const std::vector<std::uint32_t> in = buried(); !in.empty()) {
    lines.push_back(
        of_all(in.size()) + " have less than " + to_text(S(detail::chosen::buried_ray_share)) +
        " of their ray outside of their own body, sensor " + to_text(in.front()) + " the first");
  }
  if (largest_load < least_weight) {
    lines.push_back("all sensors fully pressed give " + to_text(largest_load) +
                    " N, less than the weight of the lightest body, " + to_text(least_weight) +
                    " N");
  }
  if (largest_weight > S(0) &&
      intended_load > S(detail::chosen::suspicious_load_ratio) * largest_weight) {
    lines.push_back("the constants are for a load of " + to_text(intended_load) + " N, more than " +
                    to_text(S(detail::chosen::suspicious_load_ratio)) +
                    " times the weight of the heaviest body, " + to_text(largest_weight) + " N");
  }
  if (bottomed_out > 0) {
    lines.push_back(of_all(bottomed_out) + " were fully pressed in the last step, under " +
                    to_text(load) + " N: a larger GripSpec::load carries it, or GripSpec::radius " +
                    "where what is touched meets few of them");
  }
  return lines;
}

}  // namespace bristle::inline BRISTLE_ABI
