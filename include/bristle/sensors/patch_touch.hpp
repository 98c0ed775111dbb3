/// @file
/// What the hits of a patch mean to its sensors: where they touch, how deep, and which way the
/// depth grows. Found from the hit wherever it is wanted: that costs less than to keep it, since
/// large patches wait for memory (docs/decisions/0023-law-in-lanes.md).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/sensors/patch.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI {

/// A sensor that meets a surface, in A's axes.
template <Value T>
struct SensorTouch {
  /// [1] Ray direction n and depth gradient g.
  Vector3<T> n, g;
  /// [m] From A's centre of mass to the point of touch.
  Vector3<T> point;
  /// [1], [1/m] Depth e_N and inverse length of the ray.
  T depth, inverse_length;
};

/// The touch of sensor `i`, which has a hit.
template <Scalar S>
[[nodiscard]] SensorTouch<S> touch_of(const SensorPatch<S>& patch, std::size_t i) {
  const SensorTile<S>& sensors = patch.tiles[i / tile_size];
  const std::size_t lane = i % tile_size;
  const S distance = patch.hits.distance[i];
  const Vec3<S> n = sensors.direction[lane];
  return {n, depth_gradient<S>(n, patch.hits.normal[i]), sensors.start[lane] + distance * n,
          sensor_depth(distance, sensors.inverse_length[lane]), sensors.inverse_length[lane]};
}

namespace detail {

/// Touches of the sensors from lane `at` of a tile, and which of them there are. Made in its place:
/// returned by a function, it would go through memory.
template <Scalar S>
struct TouchPack : SensorTouch<Pack<S>> {
  /// Lanes that have a contact. The others go on with a hit from ahead at the start of the ray, so
  /// that all is finite.
  Mask<S> is_met;

  /// @param sensors  Tile `number` of the patch, which the caller has at hand and need not look up
  ///                 again for each pack.
  /// @param hit      Lanes that have a hit.
  /// @param decides  Whether a contact is what is hit at more than a grazing angle. That is decided
  ///                 once a step; afterwards every hit counts.
  BRISTLE_INLINE TouchPack(const SensorPatch<S>& patch, const SensorTile<S>& sensors,
                           std::size_t number, std::size_t at, LaneBits hit, bool decides) {
    using T = Pack<S>;
    const std::size_t first = number * tile_size + at;
    const RayHits<S>& hits = patch.hits;
    this->n = load_pack(sensors.direction, at);
    const Pack3<S> surface = Pack3<S>::load(
        hits.normal.x.data() + first, hits.normal.y.data() + first, hits.normal.z.data() + first);
    const T cosine = dot(surface, this->n);
    is_met = load_mask<S>(hit, at);
    // False for a normal that is no number, too.
    if (decides) is_met = is_met & (cosine <= T(grazing_cosine<S>));
    const T distance = patch.distances_of(first, is_met);
    this->inverse_length = load_pack(sensors.inverse_length, at);
    this->g =
        depth_gradient<T>(select(is_met, surface, -this->n), select(is_met, cosine, T(S(-1))));
    this->depth = sensor_depth(distance, this->inverse_length);
    this->point = load_pack(sensors.start, at) + distance * this->n;
  }
};

}  // namespace detail

}  // namespace bristle::inline BRISTLE_ABI
