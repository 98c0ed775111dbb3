/// @file
/// Plane cache: hits of rays kept for several steps, each as a plane on its body.
///
/// Between two casts a surface is replaced by its tangent plane at the hit. That is exact within
/// flat faces. It leaves d^2 / 2R of a surface of radius R after a slide by d.
/// `PlaneCacheShape::covers` bounds how far bodies may move before rays are cast anew. Planes have
/// no edges. The next cast notices a surface that comes over a sensor from the side, or leaves it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/sensor_packets.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Planes that the sensors of a packet met.
template <Scalar S>
struct PlaneCachePacket {
  /// [-] Index of the packet; lanes with a hit.
  std::uint32_t packet = 0;
  LaneBits is_hit = 0;
  /// [m], [1] Point and outward normal, from the hit body's centre of mass, in its axes.
  Row3<S> point, normal;
  /// [-] Tags of the shapes.
  Row<std::uint32_t> tag;
};

/// A shape in range when the rays were cast.
template <Scalar S>
struct PlaneCacheShape {
  std::uint32_t tag = 0;
  std::uint32_t generation = 0;
  /// Pose of its body B at the cast.
  PairPose<S> pose{};
  /// [m] Extra length of the cast rays: the shape may come closer by this much before rays miss it.
  /// Negative where a ray starts inside it, which tells nothing of its surface.
  S reserve = S(0);

  /// Returns whether its planes still predict the hits of rays, to first order.
  /// @param now       Present pose of its body.
  /// @param approach  [m] Farthest it can come closer within the step.
  /// @param reach     [m] Farthest point of the rays from A's centre of mass.
  [[nodiscard]] bool covers(const PairPose<S>& now, S approach, S reach) const {
    // A point of B at r moves to T r + p' - T p, with T = R' R^T.
    const Mat3<S> turn = now.R_AB * pose.R_AB.transpose();
    const S moved =
        (now.p_AB - turn * pose.p_AB).norm() + (turn - identity<Mat3<S>>()).norm() * reach;
    return moved + approach <= reserve;
  }
};

/// Hits of the last cast, as planes. Empty: the rays have to be cast.
template <Scalar S>
struct PlaneCache {
  DynamicArray<PlaneCacheShape<S>> shapes;
  DynamicArray<PlaneCachePacket<S>> packets;

  void clear() {
    shapes.clear();
    packets.clear();
  }

  /// Stores the near packets' hits on `shapes`.
  template <typename Scratch>
  void keep(const Scratch& scratch);

  /// Sets the hits and the near packets of `scratch` to the hits of the rays on the stored planes.
  /// @param reach_of  Callable: S reach_of(tag, PairPose<S>& pose). Sets the present pose of a
  ///                  shape's body, and returns the extra length [m] of the rays.
  template <typename Scratch, typename ReachOf>
  void advance(Scratch& scratch, ReachOf&& reach_of) const;
};

// Implementation ----------------------------------------------------------------------------------

/// Puts the distances of the planes of a pack into `hits`, where they are in range.
template <Scalar S>
BRISTLE_FORCE_INLINE void advance_pack(const RayPacket<S>& rays, const PlaneCachePacket<S>& kept,
                                       std::size_t at, const Mask<S>& is_of_shape,
                                       const PairPose<S>& pose, S extra_length, RayHits<S>& hits) {
  using T = Pack<S>;
  const std::size_t first = kept.packet * packet_size + at;
  const Pack3<S> n = load_pack(rays.direction, at);
  const Pack3<S> m = pose.R_AB * load_pack(kept.normal, at);
  const Pack3<S> point = pose.R_AB * load_pack(kept.point, at) + Pack3<S>::all(pose.p_AB);
  const T cosine = dot(m, n);
  const Mask<S> is_ahead = is_of_shape & (cosine < T(S(0)));
  const T height = dot(m, point - load_pack(rays.start, at));
  const T distance = max(height / select(is_ahead, cosine, T(S(-1))), T(S(0)));
  // Only inverse lengths are stored: d <= L + e  <=>  (d - e) / L <= 1.
  const T over = (distance - T(extra_length)) * load_pack(rays.inverse_length, at);
  const Mask<S> is_in_range = is_ahead & (over <= T(S(1)));
  const auto put = [&](S* row, const T& value) {
    select(is_in_range, value, T::load(row + first)).store(row + first);
  };
  put(hits.distance.data(), distance);
  put(hits.normal.x.data(), m.x);
  put(hits.normal.y.data(), m.y);
  put(hits.normal.z.data(), m.z);
}

/// Puts the planes that a pack of sensors met on one body into `kept`.
/// @return True if a ray starts inside.
template <Scalar S>
BRISTLE_FORCE_INLINE bool keep_pack(const RayPacket<S>& rays, const RayHits<S>& hits,
                                    std::size_t at, const Mask<S>& is_of_shape,
                                    const PairPose<S>& pose, const Mat3<S>& R_BA,
                                    PlaneCachePacket<S>& kept) {
  using T = Pack<S>;
  const std::size_t first = kept.packet * packet_size + at;
  // Lanes without a hit use one at the start, which keeps them finite.
  const T distance = select(is_of_shape, T::load(hits.distance.data() + first), T(S(0)));
  const Pack3<S> normal_A = Pack3<S>::load(
      hits.normal.x.data() + first, hits.normal.y.data() + first, hits.normal.z.data() + first);
  const Pack3<S> point_A = load_pack(rays.start, at) + distance * load_pack(rays.direction, at);
  const Pack3<S> point = R_BA * (point_A - Pack3<S>::all(pose.p_AB));
  const Pack3<S> normal = R_BA * normal_A;
  store_pack(kept.point, at, select(is_of_shape, point, load_pack(kept.point, at)));
  store_pack(kept.normal, at, select(is_of_shape, normal, load_pack(kept.normal, at)));
  return any(is_of_shape & (distance <= T(S(0))));
}

template <Scalar S>
template <typename Scratch>
void PlaneCache<S>::keep(const Scratch& scratch) {
  packets.clear();
  const RayHits<S>& hits = scratch.hits;
  for (const std::uint32_t number : scratch.near) {
    const std::size_t first = number * packet_size;
    std::uint32_t is_hit = 0;
    for (std::size_t at = 0; at < packet_size; at += lanes<S>) {
      const auto distance = Pack<S>::load(hits.distance.data() + first + at);
      is_hit |= bits(distance < Pack<S>(infinity<S>)) << at;
    }
    if (is_hit == 0) continue;
    PlaneCachePacket<S>& kept = packets.emplace_back();
    kept.packet = number;
    kept.is_hit = static_cast<LaneBits>(is_hit);
    std::copy_n(hits.tag.begin() + static_cast<std::ptrdiff_t>(first), packet_size,
                kept.tag.begin());
  }
  for (PlaneCacheShape<S>& shape : shapes) {
    const Mat3<S> R_BA = transposed(shape.pose.R_AB);
    for (PlaneCachePacket<S>& kept : packets) {
      const auto of_shape =
          static_cast<LaneBits>(kept.is_hit & equal_lanes(kept.tag.data(), shape.tag));
      for (std::size_t at = 0; at < packet_size && of_shape != 0; at += lanes<S>) {
        if (pack_bits<S>(of_shape, at) == 0) continue;
        const bool starts_inside = keep_pack(scratch.geometry->packets[kept.packet], hits, at,
                                             load_mask<S>(of_shape, at), shape.pose, R_BA, kept);
        if (starts_inside) shape.reserve = S(-1);
      }
    }
  }
}

template <Scalar S>
template <typename Scratch, typename ReachOf>
void PlaneCache<S>::advance(Scratch& scratch, ReachOf&& reach_of) const {
  RayHits<S>& hits = scratch.hits;
  scratch.near.clear();
  for (const PlaneCachePacket<S>& kept : packets) {
    scratch.near.push_back(kept.packet);
    const auto first = static_cast<std::ptrdiff_t>(kept.packet * packet_size);
    std::fill_n(hits.distance.begin() + first, packet_size, infinity<S>);
    std::copy(kept.tag.begin(), kept.tag.end(), hits.tag.begin() + first);
  }
  for (const PlaneCacheShape<S>& shape : shapes) {
    PairPose<S> pose;
    const S extra_length = reach_of(shape.tag, pose);
    for (const PlaneCachePacket<S>& kept : packets) {
      const auto of_shape =
          static_cast<LaneBits>(kept.is_hit & equal_lanes(kept.tag.data(), shape.tag));
      for (std::size_t at = 0; at < packet_size && of_shape != 0; at += lanes<S>) {
        if (pack_bits<S>(of_shape, at) == 0) continue;
        advance_pack(scratch.geometry->packets[kept.packet], kept, at, load_mask<S>(of_shape, at),
                     pose, extra_length, hits);
      }
    }
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
