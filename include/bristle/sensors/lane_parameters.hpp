/// @file
/// The constants of a patch's sensors as kernels read them, lane by lane.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/patch.hpp>

#include <algorithm>
#include <cstddef>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Constants of all sensors, or of each one. One type for both: kernels are compiled once.
template <Scalar S>
class LaneParameters {
 public:
  explicit LaneParameters(const PatchDef<S>& def)
      : shared_{def.parameters.normal_stiffness, def.parameters.normal_damping,
                def.parameters.static_friction, def.parameters.sliding_friction,
                def.parameters.breakaway_distance},
        own_(def.per_sensor) {}

  /// Constants from lane `at` of a packet on. Lanes behind the last sensor repeat its constants.
  /// @param scratch  Receives them if each sensor has its own.
  [[nodiscard]] BRISTLE_FORCE_INLINE const SensorParameters<Pack<S>>& operator()(
      std::size_t packet, std::size_t at, SensorParameters<Pack<S>>& scratch) const {
    if (own_.empty()) return shared_;
    gather(packet * packet_size + at, scratch);
    return scratch;
  }

 private:
  void gather(std::size_t first, SensorParameters<Pack<S>>& out) const {
    Row<S> rows[5];
    for (std::size_t i = 0; i < lanes<S>; ++i) {
      const SensorParameters<S>& p = own_[std::min(first + i, own_.size() - 1)];
      rows[0][i] = p.normal_stiffness;
      rows[1][i] = p.normal_damping;
      rows[2][i] = p.static_friction;
      rows[3][i] = p.sliding_friction;
      rows[4][i] = p.breakaway_distance;
    }
    out = {load_pack(rows[0], 0), load_pack(rows[1], 0), load_pack(rows[2], 0),
           load_pack(rows[3], 0), load_pack(rows[4], 0)};
  }

  SensorParameters<Pack<S>> shared_;
  std::span<const SensorParameters<S>> own_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
