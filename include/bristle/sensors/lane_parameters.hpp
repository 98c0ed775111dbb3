/// @file
/// The constants of a patch's sensors as kernels read them: shared by all, or each its own.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/patch.hpp>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// One set of constants for all lanes of all tiles.
template <Scalar S>
class SharedParameters {
 public:
  explicit SharedParameters(const SensorParameters<S>& p)
      : all_{p.normal_stiffness, p.normal_damping, p.static_friction, p.sliding_friction,
             p.breakaway_distance} {}

  [[nodiscard]] BRISTLE_INLINE const SensorParameters<Pack<S>>& operator()(std::size_t,
                                                                           std::size_t) const {
    return all_;
  }

 private:
  SensorParameters<Pack<S>> all_;
};

/// Constants for each sensor, gathered.
template <Scalar S>
class OwnParameters {
 public:
  explicit OwnParameters(const std::vector<SensorParameters<S>>& own) : own_(&own) {}

  /// Of the sensors from lane `at` of a tile; lanes behind the last sensor have its constants.
  [[nodiscard]] SensorParameters<Pack<S>> operator()(std::size_t tile, std::size_t at) const {
    Row<S> rows[5];
    for (std::size_t i = 0; i < lanes<S>; ++i) {
      const SensorParameters<S>& p = (*own_)[std::min(tile * tile_size + at + i, own_->size() - 1)];
      rows[0][i] = p.normal_stiffness;
      rows[1][i] = p.normal_damping;
      rows[2][i] = p.static_friction;
      rows[3][i] = p.sliding_friction;
      rows[4][i] = p.breakaway_distance;
    }
    return {load_pack(rows[0], 0), load_pack(rows[1], 0), load_pack(rows[2], 0),
            load_pack(rows[3], 0), load_pack(rows[4], 0)};
  }

 private:
  const std::vector<SensorParameters<S>>* own_;
};

/// Calls call(parameters) with what `parameters(tile, at)` gives the constants of a pack.
template <Scalar S, typename Call>
decltype(auto) with_parameters(const PatchDef<S>& def, Call&& call) {
  if (def.per_sensor.empty()) return call(SharedParameters<S>(def.parameters));
  return call(OwnParameters<S>(def.per_sensor));
}

}  // namespace bristle::inline BRISTLE_ABI::detail
