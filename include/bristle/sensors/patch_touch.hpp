/// @file
/// The hits of a patch as its sensors use them: contact state, depth, and gradient of the depth.
/// They are recomputed from the hit wherever needed. Large patches wait for memory, so storing them
/// would cost more (docs/decisions/0023-law-in-lanes.md).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/ray.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/patch_geometry.hpp>
#include <bristle/sensors/sensor_constants.hpp>
#include <bristle/sensors/sensor_packets.hpp>

#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// [m] Distances of the hits from ray `first` on; 0 in the lanes outside `asked`.
template <Scalar S>
[[nodiscard]] BRISTLE_FORCE_INLINE Pack<S> distances_of(const RayHits<S>& hits, std::size_t first,
                                                        const Mask<S>& asked) {
  return select(asked, Pack<S>::load(hits.distance.data() + first), Pack<S>(S(0)));
}

/// A sensor that meets a surface, in A's axes.
template <Value T>
struct SensorTouch {
  /// [1] Ray direction n and depth gradient g.
  Vector3<T> n, g;
  /// [m] From A's centre of mass to the contact point.
  Vector3<T> point;
  /// [1], [1/m] Depth e_N and inverse length of the ray.
  T depth, inverse_length;
};

/// Contact geometry of sensor `i`, which has a hit.
template <Scalar S>
[[nodiscard]] SensorTouch<S> touch_of(const PatchGeometry<S>& geometry, const RayHits<S>& hits,
                                      std::size_t i) {
  const RayPacket<S>& rays = geometry.packets[i / packet_size];
  const std::size_t lane = i % packet_size;
  const S distance = hits.distance[i];
  const Vec3<S> n = rays.direction[lane];
  return {n, depth_gradient<S>(n, hits.normal[i]), rays.start[lane] + distance * n,
          sensor_depth(distance, rays.inverse_length[lane]), rays.inverse_length[lane]};
}

/// Contact geometry of the sensors from lane `at` of a packet, and the lanes that have one.
/// Constructed in place: a return would go through memory.
template <Scalar S>
struct TouchPack : SensorTouch<Pack<S>> {
  /// Lanes that have a contact. The others use a head-on hit at the start of the ray, which keeps
  /// them finite.
  Mask<S> is_in_range;

  /// @param rays     Packet `number` of its rays; passed in to avoid a look-up for each pack.
  /// @param hit      Lanes that have a hit.
  /// @param decides  True to drop hits at a grazing angle. Dropped once a step; afterwards every
  ///                 hit counts.
  BRISTLE_FORCE_INLINE TouchPack(const RayHits<S>& hits, const RayPacket<S>& rays,
                                 std::size_t number, std::size_t at, LaneBits hit, bool decides) {
    using T = Pack<S>;
    const std::size_t first = number * packet_size + at;
    this->n = load_pack(rays.direction, at);
    const Pack3<S> surface = Pack3<S>::load(
        hits.normal.x.data() + first, hits.normal.y.data() + first, hits.normal.z.data() + first);
    const T cosine = dot(surface, this->n);
    is_in_range = load_mask<S>(hit, at);
    // Also false for a normal that is NaN.
    if (decides) is_in_range = is_in_range & (cosine <= T(S(-chosen::grazing_cosine)));
    const T distance = distances_of(hits, first, is_in_range);
    this->inverse_length = load_pack(rays.inverse_length, at);
    this->g = depth_gradient<T>(select(is_in_range, surface, -this->n),
                                select(is_in_range, cosine, T(S(-1))));
    this->depth = sensor_depth(distance, this->inverse_length);
    this->point = load_pack(rays.start, at) + distance * this->n;
  }
};

}  // namespace bristle::inline BRISTLE_ABI::detail
