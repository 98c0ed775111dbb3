/// @file
/// Hits of rays that are kept for a while: what was met moves on as a plane on its body.
///
/// Between two castings a surface is taken for its tangent plane where the ray met it, which is
/// exact within flat faces and leaves d^2 / 2R of a surface of radius R after a slide by d. How far
/// bodies may move before rays are cast anew is bounded (`KeptShape::covers`). Planes have no
/// edges: what comes over a sensor from the side, or leaves it, does so at the next casting.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/ray.hpp>
#include <bristle/sensors/law.hpp>
#include <bristle/sensors/sensor_tiles.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// The planes that the sensors of a tile met.
template <Scalar S>
struct KeptTile {
  /// [-] Number of the tile, and which of its sensors met anything.
  std::uint32_t tile = 0;
  LaneBits is_hit = 0;
  /// [m], [1] Point and outward normal, from the centre of mass of the body met, in its axes.
  Row3<S> point, normal;
  /// [-] Tags of the shapes.
  Row<std::uint32_t> tag;
};

/// A shape that was in reach when the rays were cast.
template <Scalar S>
struct KeptShape {
  std::uint32_t tag = 0;
  std::uint32_t generation = 0;
  /// Where its body B was.
  PairPose<S> pose{};
  /// [m] How much longer rays were cast: by how much it may come closer until they miss it.
  /// Negative where a ray starts inside it, which tells nothing of its surface.
  S reserve = S(0);

  /// Whether its planes still say what rays would meet, to first order.
  /// @param now       Where its body is.
  /// @param approach  [m] By how much it can come closer within the step.
  /// @param reach     [m] Farthest point of the rays from A's centre of mass.
  [[nodiscard]] bool covers(const PairPose<S>& now, S approach, S reach) const {
    // What of B was at r is at T r + p' - T p now, with T = R' R^T.
    const Mat3<S> turn = now.R_AB * pose.R_AB.transpose();
    const S moved =
        (now.p_AB - turn * pose.p_AB).norm() + (turn - Mat3<S>::Identity()).norm() * reach;
    return moved + approach <= reserve;
  }
};

/// What the rays of a patch met when they were cast last. Empty: they have to be cast.
template <Scalar S>
struct KeptHits {
  std::vector<KeptShape<S>> shapes;
  std::vector<KeptTile<S>> tiles;

  void clear() {
    shapes.clear();
    tiles.clear();
  }

  /// Keeps the hits of the near tiles, which are of `shapes`.
  template <typename Patch>
  void keep(const Patch& patch);

  /// Makes `patch.hits` and `patch.near` what the rays would meet if all were planes.
  /// @param reach_of  Callable: S reach_of(tag, PairPose<S>& pose), sets where the body of a shape
  ///                  is now, and returns by how much [m] rays count as longer than they are.
  template <typename Patch, typename ReachOf>
  void advance(Patch& patch, ReachOf&& reach_of) const;
};

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// Puts the distances of the planes of a pack into `hits`, where they are within reach.
template <Scalar S>
BRISTLE_INLINE void advance_pack(const SensorTile<S>& sensors, const KeptTile<S>& kept,
                                 std::size_t at, const Mask<S>& is_of_shape,
                                 const PairPose<S>& pose, S extra_length, RayHits<S>& hits) {
  using T = Pack<S>;
  const std::size_t first = kept.tile * tile_size + at;
  const Pack3<S> n = load_pack(sensors.direction, at);
  const Pack3<S> m = pose.R_AB * load_pack(kept.normal, at);
  const Pack3<S> point = pose.R_AB * load_pack(kept.point, at) + Pack3<S>::all(pose.p_AB);
  const T cosine = dot(m, n);
  const Mask<S> is_ahead = is_of_shape & (cosine < T(S(0)));
  const T height = dot(m, point - load_pack(sensors.start, at));
  const T distance = max(height / select(is_ahead, cosine, T(S(-1))), T(S(0)));
  // Lengths are known by their inverses: d <= L + e  <=>  (d - e) / L <= 1.
  const T over = (distance - T(extra_length)) * load_pack(sensors.inverse_length, at);
  const Mask<S> is_met = is_ahead & (over <= T(S(1)));
  const auto put = [&](S* row, const T& value) {
    select(is_met, value, T::load(row + first)).store(row + first);
  };
  put(hits.distance.data(), distance);
  put(hits.normal.x.data(), m.x);
  put(hits.normal.y.data(), m.y);
  put(hits.normal.z.data(), m.z);
}

/// Puts the planes that a pack of sensors met on one body into `kept`.
/// @return Whether a ray starts inside.
template <Scalar S>
BRISTLE_INLINE bool keep_pack(const SensorTile<S>& sensors, const RayHits<S>& hits, std::size_t at,
                              const Mask<S>& is_of_shape, const PairPose<S>& pose,
                              const Mat3<S>& R_BA, KeptTile<S>& kept) {
  using T = Pack<S>;
  const std::size_t first = kept.tile * tile_size + at;
  // Lanes without a hit go on with one at the start: all is finite.
  const T distance = select(is_of_shape, T::load(hits.distance.data() + first), T(S(0)));
  const Pack3<S> normal_A = Pack3<S>::load(
      hits.normal.x.data() + first, hits.normal.y.data() + first, hits.normal.z.data() + first);
  const Pack3<S> point_A =
      load_pack(sensors.start, at) + distance * load_pack(sensors.direction, at);
  const Pack3<S> point = R_BA * (point_A - Pack3<S>::all(pose.p_AB));
  const Pack3<S> normal = R_BA * normal_A;
  store_pack(kept.point, at, select(is_of_shape, point, load_pack(kept.point, at)));
  store_pack(kept.normal, at, select(is_of_shape, normal, load_pack(kept.normal, at)));
  return any(is_of_shape & (distance <= T(S(0))));
}

}  // namespace detail

template <Scalar S>
template <typename Patch>
void KeptHits<S>::keep(const Patch& patch) {
  tiles.clear();
  const RayHits<S>& hits = patch.hits;
  for (const std::uint32_t number : patch.near) {
    const std::size_t first = number * tile_size;
    std::uint32_t is_hit = 0;
    for (std::size_t at = 0; at < tile_size; at += lanes<S>) {
      const auto distance = Pack<S>::load(hits.distance.data() + first + at);
      is_hit |= bits(distance < Pack<S>(infinity<S>)) << at;
    }
    if (is_hit == 0) continue;
    KeptTile<S>& kept = tiles.emplace_back();
    kept.tile = number;
    kept.is_hit = static_cast<LaneBits>(is_hit);
    std::copy_n(hits.tag.begin() + static_cast<std::ptrdiff_t>(first), tile_size, kept.tag.begin());
  }
  for (KeptShape<S>& shape : shapes) {
    Mat3<S> R_BA = shape.pose.R_AB;
    R_BA.transposeInPlace();  // At -O1 g++ 12 takes a transposed copy for uninitialised.
    for (KeptTile<S>& kept : tiles) {
      const auto of_shape =
          static_cast<LaneBits>(kept.is_hit & equal_lanes(kept.tag.data(), shape.tag));
      for (std::size_t at = 0; at < tile_size && of_shape != 0; at += lanes<S>) {
        if (detail::pack_bits<S>(of_shape, at) == 0) continue;
        const bool starts_inside =
            detail::keep_pack(patch.tiles[kept.tile], hits, at, detail::load_mask<S>(of_shape, at),
                              shape.pose, R_BA, kept);
        if (starts_inside) shape.reserve = S(-1);
      }
    }
  }
}

template <Scalar S>
template <typename Patch, typename ReachOf>
void KeptHits<S>::advance(Patch& patch, ReachOf&& reach_of) const {
  RayHits<S>& hits = patch.hits;
  patch.near.clear();
  for (const KeptTile<S>& kept : tiles) {
    patch.near.push_back(kept.tile);
    const auto first = static_cast<std::ptrdiff_t>(kept.tile * tile_size);
    std::fill_n(hits.distance.begin() + first, tile_size, infinity<S>);
    std::copy(kept.tag.begin(), kept.tag.end(), hits.tag.begin() + first);
  }
  for (const KeptShape<S>& shape : shapes) {
    PairPose<S> pose;
    const S extra_length = reach_of(shape.tag, pose);
    for (const KeptTile<S>& kept : tiles) {
      const auto of_shape =
          static_cast<LaneBits>(kept.is_hit & equal_lanes(kept.tag.data(), shape.tag));
      for (std::size_t at = 0; at < tile_size && of_shape != 0; at += lanes<S>) {
        if (detail::pack_bits<S>(of_shape, at) == 0) continue;
        detail::advance_pack(patch.tiles[kept.tile], kept, at, detail::load_mask<S>(of_shape, at),
                             pose, extra_length, hits);
      }
    }
  }
}

}  // namespace bristle::inline BRISTLE_ABI
