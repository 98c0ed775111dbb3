/// @file
/// Single rays, and batches of many as structures of arrays.
///
/// A batch lies in one frame and queries one shape at a time. Hits accumulate. So querying several
/// shapes in turn leaves the nearest hit of each ray.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/math/types.hpp>

#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI {

/// A ray of finite length.
template <Scalar S>
struct Ray {
  /// [m] Start.
  Vec3<S> origin = detail::zero<Vec3<S>>();
  /// [1] Unit direction.
  Vec3<S> direction = detail::unit_x<Vec3<S>>();
  /// [m] Length from the start. Hits farther away do not count. May be infinite.
  S length = infinity<S>;
};

/// Nearest hit of one ray.
template <Scalar S>
struct RayHit {
  /// [m] Distance from the ray's start. Zero if the start is inside the solid.
  S distance = infinity<S>;
  /// [1] Unit outward normal of the surface there, against the ray (normal . direction <= 0). If
  /// the start is inside, minus the ray's direction.
  Vec3<S> normal = detail::zero<Vec3<S>>();
};

namespace detail {

/// Many vectors as three arrays of coordinates of one length.
template <Scalar S>
struct Vec3Array {
  /// Coordinates.
  detail::LineArray<S> x, y, z;

  /// [-] Number of vectors.
  [[nodiscard]] std::size_t size() const { return x.size(); }
  /// Sets the number of vectors.
  void resize(std::size_t n) {
    x.resize(n);
    y.resize(n);
    z.resize(n);
  }
  /// Returns vector i.
  [[nodiscard]] Vec3<S> operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
  /// Sets vector i.
  void set(std::size_t i, const Vec3<S>& v) {
    x[i] = v.x();
    y[i] = v.y();
    z[i] = v.z();
  }
};

template <Scalar S>
class RayTree;
template <Scalar S>
class TriangleCache;
/// Some rays of a batch, so that threads can share a query. They are [first, end) in the order of
/// the query. Meshes use the order of the nodes, other shapes that of the batch. So all ranges must
/// finish one shape before the next begins. They need not if ranges are the same rays for both
/// (`RayTree::has_packets_in_ranges`).
struct RayRange {
  /// [-] First ray, and the end. Both are multiples of the rays in a node, or the end of the batch.
  std::uint32_t first = 0;
  std::uint32_t end = 0xffffffffu;
};

}  // namespace detail

/// [-] Rays of a packet, and sensors. They are neighbours in a batch and queried together. It is
/// the number of lanes in the widest register (float, 512 bits).
inline constexpr std::size_t packet_size = 16;

/// Many rays in one frame. All spans have the same length and outlive the query.
template <Scalar S>
struct RayBatch {
  /// [m] A coordinate of each start.
  /// @{
  std::span<const S> origin_x, origin_y, origin_z;
  /// @}
  /// [1] A component of each unit direction.
  /// @{
  std::span<const S> direction_x, direction_y, direction_z;
  /// @}
  /// [m] Length of each ray.
  std::span<const S> length;
  /// [m] Added to the length of every ray.
  S extra_length = S(0);
  /// The same rays in nodes (ray_tree.hpp). They change the cost of a query and not its hits. Null
  /// or empty: one ray after the other.
  const detail::RayTree<S>* ray_tree = nullptr;
  /// Rays that are cast: all, unless the backend `asks_ranges`.
  detail::RayRange range{};
  /// [-] Numbers of the packets that may meet anything, ascending. Hits of other packets may be
  /// left out. Null: all packets.
  const detail::DynamicArray<std::uint32_t>* near_packets = nullptr;
  /// Triangles that these rays keep from query to query (triangle_cache.hpp). Null: none. Used only
  /// if one thread casts all rays at once.
  detail::TriangleCache<S>* triangle_cache = nullptr;
  /// [-] Number of reuses of the shape's tag. Another life is another shape.
  std::uint32_t shape_life = 0;

  /// [-] Number of rays.
  [[nodiscard]] std::size_t size() const { return length.size(); }
  /// Returns ray i, with its length extended.
  [[nodiscard]] Ray<S> operator[](std::size_t i) const {
    return {{origin_x[i], origin_y[i], origin_z[i]},
            {direction_x[i], direction_y[i], direction_z[i]},
            length[i] + extra_length};
  }
};

/// Nearest hits of a batch so far, in the frame of its rays.
template <Scalar S>
struct RayHits {
  /// [m] Distance of the nearest hit so far. Infinite if there is none.
  detail::LineArray<S> distance;
  /// [1] Outward unit surface normals, valid if the distance is finite.
  detail::Vec3Array<S> normal;
  /// [-] Tag of the hit shape, as given to the query.
  detail::LineArray<std::uint32_t> tag;

  /// Removes all hits and allocates for `n` rays. Keeps its memory.
  void reset(std::size_t n) {
    distance.assign(n, infinity<S>);
    normal.resize(n);
    tag.assign(n, detail::no_index);
  }
  /// Returns whether ray i has a hit.
  [[nodiscard]] bool is_hit(std::size_t i) const { return distance[i] < infinity<S>; }
  /// Records a hit if it is nearer than the known one. On equal distance the earlier hit stays. So
  /// querying shapes in order of their tags breaks ties by tag.
  void offer(std::size_t i, const RayHit<S>& hit, std::uint32_t hit_tag) {
    if (hit.distance < distance[i]) {
      distance[i] = hit.distance;
      normal.set(i, hit.normal);
      tag[i] = hit_tag;
    }
  }
};

}  // namespace bristle::inline BRISTLE_ABI
