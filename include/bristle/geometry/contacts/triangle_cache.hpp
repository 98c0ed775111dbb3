/// @file
/// Cache of the triangles that a ray may meet. It is valid while the ray stays near its place.
///
/// A segment whose ends move by at most a margin moves by at most that anywhere. Until an end has
/// left the margin, it can meet only the triangles within. Lists change the cost of a query, never
/// its results (docs/decisions/0029-kept-candidates.md).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/rays/mesh_rays.hpp>
#include <bristle/geometry/rays/ray_mesh.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace bristle::inline BRISTLE_ABI::detail {

/// The triangles near one ray, in the frame of their mesh. They are copies, since a large mesh is
/// in no cache of the processor.
template <Scalar S>
struct alignas(64) TrianglesNearRay {
  /// [-] Most triangles of the cache.
  static constexpr std::size_t capacity = 16;

  /// [m] Corners of the triangles, as the rows of a leaf.
  std::array<std::array<S, capacity>, 9> rows;
  /// [m] Ends of the segment that was searched around. `reserve` bounds the distance of the ray's
  /// ends from them, along each axis. A negative `reserve` means an empty cache.
  Vec3<S> start = zero<Vec3<S>>();
  Vec3<S> end = zero<Vec3<S>>();
  S reserve = S(-1);
  /// [-] Number of triangles. More than `capacity` if there were too many.
  std::uint32_t count = 0;
  /// [-] Numbers of the triangles, and the children of the tree's nodes that are their leaves.
  std::array<std::uint32_t, capacity> number;
  std::array<std::uint32_t, capacity> leaf;

  [[nodiscard]] bool is_complete() const { return count <= capacity; }
  [[nodiscard]] std::array<Vec3<S>, 3> corners(std::size_t at) const {
    return {Vec3<S>{rows[0][at], rows[1][at], rows[2][at]},
            Vec3<S>{rows[3][at], rows[4][at], rows[5][at]},
            Vec3<S>{rows[6][at], rows[7][at], rows[8][at]}};
  }
  [[nodiscard]] bool serves(const Vec3<S>& ray_start, const Vec3<S>& ray_end) const {
    return cwise_abs(ray_start - start).maxCoeff() <= reserve &&
           cwise_abs(ray_end - end).maxCoeff() <= reserve;
  }

  /// Searches anew, around the place where the ray is going.
  void search(const WideTree<S>& tree, const Ray<S>& ray, const Vec3<S>& ray_end);

 private:
  void add(const WideTree<S>& tree, const TriangleRange& range, std::size_t place, std::size_t of);
};

/// Test for boxes near a segment. It serves nodes of the tree and triangles in leaves.
template <Scalar S>
class NearSegmentTest {
 public:
  NearSegmentTest(const Vec3<S>& start, const Vec3<S>& end, S margin)
      : inverse_(cwise_inverse(end - start)) {
    for (int i = 0; i < 3; ++i) {
      const S inwards = inverse_[i] < S(0) ? -margin : margin;
      near_origin_[i] = start[i] + inwards;
      far_origin_[i] = start[i] - inwards;
    }
  }

  /// @param lower, upper  Callables: Pack<S> lower(axis), coordinates of boxes in lanes.
  template <typename Lower, typename Upper>
  [[nodiscard]] BRISTLE_FORCE_INLINE std::uint32_t operator()(const Lower& lower,
                                                              const Upper& upper) const {
    Pack<S> first(S(0));
    Pack<S> last(S(1));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int i = static_cast<int>(axis);
      const bool is_down = inverse_[i] < S(0);
      const Pack<S> near = is_down ? upper(axis) : lower(axis);
      const Pack<S> far = is_down ? lower(axis) : upper(axis);
      // min and max ignore a NaN here, as from 0 times infinity.
      first = max((near - near_origin_[i]) * inverse_[i], first);
      last = min((far - far_origin_[i]) * inverse_[i], last);
    }
    return bits(first <= last);
  }

 private:
  Vec3<S> near_origin_;
  Vec3<S> far_origin_;
  Vec3<S> inverse_;
};

/// Triangles of one mesh near the rays of one batch. Losing the cache costs time and changes
/// nothing. One thread at a time may use it.
template <Scalar S>
class TriangleCache {
 public:
  /// Prepares for a query. Allocates if the batch has more rays than any before.
  /// @param tag, life  Id of the mesh. A mesh that reuses a tag has another `life`.
  /// @return True if it serves that mesh. It stays with one mesh as long as that is queried.
  [[nodiscard]] bool begin(std::size_t rays, std::uint32_t tag, std::uint32_t life);

  /// Returns the hit of ray i, equal to `ray_cast_mesh_from_outside` bit by bit. It is nullopt if
  /// the caller has to call that.
  /// @param ray    In the mesh's frame, starting outside, of the largest length that may be
  ///               queried.
  /// @param reach  [m] Length of this query.
  [[nodiscard]] std::optional<RayHit<S>> cast(const RayMesh<S>& mesh, std::size_t i,
                                              const Ray<S>& ray, S reach);

  /// [-] Rays so far that were searched around, and rays served from a list of an earlier query.
  [[nodiscard]] std::size_t searched() const { return searched_; }
  [[nodiscard]] std::size_t reused() const { return reused_; }

 private:
  DynamicArray<TrianglesNearRay<S>> rays_;
  std::uint32_t tag_ = 0;
  std::uint32_t life_ = 0;
  /// [-] Queries of other meshes in a row.
  int refused_ = chosen::cache_refused_queries;
  int paused_ = 0;
  int poor_ = 0;
  /// [1] Searches cost credit, and each use of a list gains some. If searches have not paid, there
  /// are none for a while. Then a few test for slow motion.
  std::int64_t credit_ = 0;
  std::size_t searched_ = 0;
  std::size_t reused_ = 0;
  std::size_t reused_before_ = 0;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
BRISTLE_NOINLINE void TrianglesNearRay<S>::search(const WideTree<S>& tree, const Ray<S>& ray,
                                                  const Vec3<S>& ray_end) {
  using Tree = WideTree<S>;
  using std::sqrt;
  const S ahead = S(chosen::cache_lead);
  const S margin = S(chosen::cache_margin) * sqrt(tree.mean_area());
  const auto move = [&](Vec3<S>& cached, const Vec3<S>& current) {
    const Vec3<S> moved = current - cached;
    cached = current;
    if (!(reserve >= S(0)) ||
        !(cwise_abs(moved).maxCoeff() <= S(chosen::cache_longest_motion) * margin)) {
      return;
    }
    cached += ahead * cwise_clamp(moved, margin);
  };
  move(start, ray.origin);
  move(end, ray_end);
  // Rounding of the coordinates of rays, boxes and crossings.
  const S size = cwise_max(cwise_abs(tree.box().lower), cwise_abs(tree.box().upper)).sum() +
                 cwise_abs(start).sum() + cwise_abs(end).sum();
  reserve = margin - S(chosen::cache_margin_error) * Tolerance<S>::round_off() * size;
  count = 0;
  if (!(reserve >= S(1 - chosen::cache_margin_loss) * margin)) {
    // The mesh is too fine for its coordinates, or the ray is not finite.
    reserve = S(-1);
    count = capacity + 1;
    return;
  }
  const NearSegmentTest<S> is_near(start, end, margin);
  std::array<std::uint32_t, Tree::stack_size> stack;
  std::size_t height = 0;
  if (!tree.nodes().empty()) stack[height++] = 0;
  while (height > 0 && is_complete()) {
    const std::uint32_t id = stack[--height];
    const typename Tree::Node& node = tree.nodes()[id];
    for (std::size_t k = 0; k < node.children; k += lanes<S>) {
      const auto lower = [&](std::size_t axis) { return Pack<S>::load(&node.lower[axis][k]); };
      const auto upper = [&](std::size_t axis) { return Pack<S>::load(&node.upper[axis][k]); };
      std::uint32_t left = is_near(lower, upper) & first_bits(node.children - k);
      for (; left != 0; left &= left - 1) {
        const std::size_t i = k + static_cast<std::size_t>(std::countr_zero(left));
        if (node.triangles[i] == 0) {
          stack[height++] = node.first[i];
          continue;
        }
        const TriangleRange range{node.first[i], node.triangles[i]};
        for (std::size_t t = 0; t < range.count; t += lanes<S>) {
          const auto corners = [&](std::size_t c, std::size_t axis) {
            return Pack<S>::load(tree.row(range, c, axis) + t);
          };
          const auto least = [&](std::size_t axis) {
            return min(corners(0, axis), min(corners(1, axis), corners(2, axis)));
          };
          const auto most = [&](std::size_t axis) {
            return max(corners(0, axis), max(corners(1, axis), corners(2, axis)));
          };
          std::uint32_t near = is_near(least, most) & first_bits(range.count - t);
          for (; near != 0; near &= near - 1) {
            add(tree, range, t + static_cast<std::size_t>(std::countr_zero(near)),
                id * Tree::width + i);
          }
        }
      }
    }
  }
}

template <Scalar S>
void TrianglesNearRay<S>::add(const WideTree<S>& tree, const TriangleRange& range,
                              std::size_t place, std::size_t of) {
  if (count >= capacity) {
    count = capacity + 1;
    return;
  }
  for (std::size_t r = 0; r < 9; ++r) rows[r][count] = tree.row(range, r / 3, r % 3)[place];
  number[count] = tree.number(range.first + place);
  leaf[count] = static_cast<std::uint32_t>(of);
  ++count;
}

template <Scalar S>
bool TriangleCache<S>::begin(std::size_t rays, std::uint32_t tag, std::uint32_t life) {
  const auto most_credit = static_cast<std::int64_t>(rays) * chosen::cache_search_price *
                           chosen::cache_most_searches;
  if (tag != tag_ || life != life_ || rays != rays_.size()) {
    if (rays == rays_.size() && ++refused_ <= chosen::cache_refused_queries) return false;
    tag_ = tag;
    life_ = life;
    rays_.resize(rays);
    for (TrianglesNearRay<S>& ray : rays_) ray.reserve = S(-1);
    credit_ = most_credit / 2;
    paused_ = poor_ = 0;
  }
  refused_ = 0;
  if (paused_ > 0) {
    --paused_;
    return false;
  }
  // A list serves in the query after its search at the earliest.
  const bool is_poor = credit_ < chosen::cache_search_price &&
                       (reused_ - reused_before_) * chosen::cache_poor_divisor < rays;
  poor_ = is_poor ? poor_ + 1 : 0;
  reused_before_ = reused_;
  credit_ = std::min(credit_, most_credit);
  if (poor_ < chosen::cache_poor_queries) return true;
  poor_ = 0;
  paused_ = chosen::cache_pause_queries;
  credit_ = most_credit / chosen::cache_retry_divisor;
  return false;
}

template <Scalar S>
BRISTLE_NOINLINE std::optional<RayHit<S>> TriangleCache<S>::cast(const RayMesh<S>& mesh,
                                                                 std::size_t i, const Ray<S>& ray,
                                                                 S reach) {
  TrianglesNearRay<S>& near = rays_[i];
  const WideTree<S>& tree = mesh.tree();
  const Vec3<S> end = ray.origin + ray.length * ray.direction;
  if (near.serves(ray.origin, end)) {
    if (near.is_complete()) {
      ++reused_;
      credit_ += chosen::cache_reuse_gain;
    }
  } else if (credit_ < chosen::cache_search_price) {
    return std::nullopt;
  } else {
    near.search(tree, ray, end);
    ++searched_;
    credit_ -= chosen::cache_search_price;
  }
  if (!near.is_complete()) return std::nullopt;

  const Ray<S> asked{ray.origin, ray.direction, reach};
  const WideTriangleFilter<S> filter(asked);
  std::uint32_t left = filter.among(near.rows[0].data(), near.capacity, near.count, reach);
  if (left == 0) return RayHit<S>{};
  const WideSlabTest<S> slabs(asked);
  CrossingCollector<S> collector(asked);
  S entered = S(0);
  std::size_t nearest = 0;
  int visits = 0;
  for (; left != 0; left &= left - 1) {
    const auto at = static_cast<std::size_t>(std::countr_zero(left));
    // Tests whether a traversal could reach the triangle's leaf. Only the ray counts here, not the
    // order.
    const std::size_t child = near.leaf[at] % WideTree<S>::width;
    const std::size_t lane = child % lanes<S>;
    std::array<S, lanes<S>> enter;
    const std::uint32_t passes =
        slabs(tree.nodes()[near.leaf[at] / WideTree<S>::width], child - lane, reach, enter.data());
    if ((passes >> lane & 1u) == 0) continue;
    collector.visit(near.number[at], near.corners(at), reach);
    ++visits;
    if (collector.found.triangle == near.number[at]) {
      entered = enter[lane];
      nearest = at;
    }
  }
  // A traversal skips boxes behind a known crossing. Its order differs from this one. Rounding may
  // put a crossing in front of its leaf's box. The traversal might have skipped that one.
  if (visits > 1 && !(entered <= collector.found.distance)) return std::nullopt;
  if (!collector.found.is_within(asked)) return RayHit<S>{};
  return hit_on<S>(near.corners(nearest), asked, collector.found.distance);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
