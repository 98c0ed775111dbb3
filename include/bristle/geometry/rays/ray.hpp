/// @file
/// Rays: one, and batches of many as structures of arrays.
///
/// A batch lies in one frame and is asked of one shape at a time; answers accumulate, so that
/// asking several shapes in turn leaves the nearest hit of each ray.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/lane_vector.hpp>
#include <bristle/math/types.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// A ray of finite length.
template <Scalar S>
struct Ray {
  /// [m] Start.
  Vec3<S> origin = Vec3<S>::Zero();
  /// [1] Unit direction.
  Vec3<S> direction = Vec3<S>::UnitX();
  /// [m] Reach from the start; hits farther away do not count. May be infinite.
  S length = infinity<S>;
};

/// Nearest hit of one ray.
template <Scalar S>
struct RayHit {
  /// [m] Distance from the ray's start; 0 where the start lies inside the solid.
  S distance = infinity<S>;
  /// [1] Unit outward normal of the surface there, against the ray (normal . direction <= 0). Where
  /// the start lies inside, minus the ray's direction.
  Vec3<S> normal = Vec3<S>::Zero();
};

/// Three arrays of coordinates, to be read together.
template <Scalar S>
struct Vec3Array {
  LaneVector<S> x, y, z;

  [[nodiscard]] std::size_t size() const { return x.size(); }
  void resize(std::size_t n) {
    x.resize(n);
    y.resize(n);
    z.resize(n);
  }
  [[nodiscard]] Vec3<S> operator[](std::size_t i) const { return {x[i], y[i], z[i]}; }
  void set(std::size_t i, const Vec3<S>& v) {
    x[i] = v.x();
    y[i] = v.y();
    z[i] = v.z();
  }
};

template <Scalar S>
class RayBundles;
template <Scalar S>
class KeptCandidates;

/// Some rays of a batch, so that threads can share a query: [first, end) in the order in which the
/// query goes through them. That is the order of the bundles for meshes and of the batch for other
/// shapes, so the next shape may only be asked when all slices have asked this one, unless these
/// are the same rays (`RayBundles::has_runs_in_slices`).
struct RaySlice {
  /// [-] Both a multiple of the rays in a bundle, or at the end.
  std::uint32_t first = 0;
  std::uint32_t end = 0xffffffffu;
};

/// [-] Rays of a run: neighbours in a batch, of which all or none are asked.
inline constexpr std::size_t ray_run_size = 16;

/// Many rays in one frame. The spans have one length and outlive the query.
template <Scalar S>
struct RayBatch {
  /// [m] Starts.
  std::span<const S> origin_x, origin_y, origin_z;
  /// [1] Unit directions.
  std::span<const S> direction_x, direction_y, direction_z;
  /// [m] Reach of each ray.
  std::span<const S> length;
  /// [m] Added to the reach of every ray.
  S extra_length = S(0);
  /// The same rays in bundles (ray_bundles.hpp), where somebody has made them: they change what a
  /// query costs, not what it answers. Null or empty: one ray after the other.
  const RayBundles<S>* bundles = nullptr;
  /// Which rays are asked: all, unless the backend says that it `asks_slices`.
  RaySlice slice{};
  /// [-] Numbers of the runs that may meet anything, ascending; of others, hits may be left out.
  /// Null: all runs.
  const std::vector<std::uint32_t>* near_runs = nullptr;
  /// What these rays keep from query to query (kept_candidates.hpp), and which life of the shape it
  /// is that is asked, where its tag was another's before. Null: nothing. Used where all rays are
  /// asked at once, by one thread.
  KeptCandidates<S>* kept = nullptr;
  std::uint32_t shape_life = 0;

  [[nodiscard]] std::size_t size() const { return length.size(); }
  [[nodiscard]] Ray<S> operator[](std::size_t i) const {
    return {{origin_x[i], origin_y[i], origin_z[i]},
            {direction_x[i], direction_y[i], direction_z[i]},
            length[i] + extra_length};
  }
};

/// Nearest hits of a batch so far, in the frame of its rays.
template <Scalar S>
struct RayHits {
  /// [m] Distance of the nearest hit so far; infinite where there is none.
  LaneVector<S> distance;
  /// [1] Outward unit surface normals, valid where the distance is finite.
  Vec3Array<S> normal;
  /// [-] Tag of the shape that was hit, as given to the query.
  LaneVector<std::uint32_t> tag;

  /// Forgets all hits and makes room for `n` rays; keeps its memory.
  void reset(std::size_t n) {
    distance.assign(n, infinity<S>);
    normal.resize(n);
    tag.assign(n, 0xffffffffu);
  }
  [[nodiscard]] bool is_hit(std::size_t i) const { return distance[i] < infinity<S>; }
  /// Records a hit that is nearer than what is known. On equal distance the earlier answer stays,
  /// so asking shapes in order of their tags breaks ties by tag.
  void offer(std::size_t i, const RayHit<S>& hit, std::uint32_t hit_tag) {
    if (hit.distance < distance[i]) {
      distance[i] = hit.distance;
      normal.set(i, hit.normal);
      tag[i] = hit_tag;
    }
  }
};

}  // namespace bristle::inline BRISTLE_ABI
