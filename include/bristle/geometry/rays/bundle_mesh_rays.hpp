/// @file
/// Bundles of rays against a solid mesh: one search for many rays, triangles against rays in lanes.
///
/// Answers are those of `ray_cast_mesh` for each ray alone, to round-off: what the lanes cannot
/// tell with certainty is asked again that way.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/kept_candidates.hpp>
#include <bristle/geometry/rays/bundle_leaves.hpp>
#include <bristle/geometry/rays/bundle_triangles.hpp>
#include <bristle/geometry/rays/mesh_rays.hpp>
#include <bristle/geometry/rays/ray_bundles.hpp>
#include <bristle/geometry/rays/ray_mesh.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// Offers to `hits` the nearest hit of each ray with a solid at X_RC, as `ShapeBackend::cast_rays`
/// does; in bundles where the rays have them. Allocates nothing.
template <Scalar S>
void cast_rays_at_mesh(const RayMesh<S>& mesh, const Transform<S>& X_RC, const RayBatch<S>& rays,
                       std::uint32_t tag, RayHits<S>& hits);

/// Whether no ray of a batch can meet a solid at X_RC. A look at boxes: mostly true where it is,
/// and never where it is not. False for rays without bundles.
template <Scalar S>
[[nodiscard]] bool is_clear_of_mesh(const RayMesh<S>& mesh, const Transform<S>& X_RC,
                                    const RayBatch<S>& rays);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// Where the rays of a bundle start, as seen from a solid.
enum class Side { unknown, outside, inside };

/// What is known of a bundle from the one that it is a part of.
template <Scalar S>
struct KnownOfBundle {
  /// Leaves that it may meet, if they were sought; [-] how many lists are in use.
  const LeafList<S>* list = nullptr;
  std::size_t lists = 0;
  Side side = Side::unknown;
  /// A box in its frame, if the whole has that frame.
  const BoxInTree<S>* framed = nullptr;
};

/// Room for the lists of leaves that are made on the way down. Below, the last one serves.
template <Scalar S>
using LeafLists = std::array<LeafList<S>, 4>;

/// One query.
template <Scalar S>
class BundleMeshQuery {
 public:
  /// @param hits  Null where it is only asked whether there is anything to meet.
  BundleMeshQuery(const RayMesh<S>& mesh, const Transform<S>& X_RC, const RayBatch<S>& rays,
                  std::uint32_t tag, RayHits<S>* hits, LeafLists<S>& lists)
      : mesh_(mesh),
        rays_(rays),
        lists_(lists),
        tag_(tag),
        hits_(hits),
        R_RC_(X_RC.rotation_matrix()),
        R_CR_(R_RC_.transpose()),
        p_RC_(X_RC.translation) {
    const Aabb<S> box = mesh.root_box();
    mesh_size_ = box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).sum() + p_RC_.cwiseAbs().sum();
  }

  void run() {
    if (rays_.bundles == nullptr || rays_.bundles->is_empty()) {
      const std::size_t end = std::min<std::size_t>(rays_.slice.end, rays_.size());
      for (std::size_t i = rays_.slice.first; i < end; ++i) cast_alone(i);
    } else {
      visit(0, {});
    }
  }

  [[nodiscard]] bool is_clear() {
    if (rays_.bundles == nullptr || rays_.bundles->is_empty()) return false;
    visit(0, {});
    return !may_meet_;
  }

 private:
  using Bundle = RayBundle<S>;
  using Bundles = RayBundles<S>;
  using Known = KnownOfBundle<S>;
  using Candidates = std::array<std::uint8_t, BundleTriangles<S>::capacity>;
  /// Rays of a block, as bits.
  using BlockBits = std::uint16_t;

  /// [-] A list of so few leaves is not worth shortening.
  static constexpr std::size_t short_list = 24;
  /// [-] Of how many leaves at most the triangles are sought for a bundle that is asked as a whole.
  static constexpr std::size_t most_leaves = 48;
  /// [1] With more triangles than this for each ray, rays have too little in common.
  static constexpr S sparse_from = S(10);
  /// [-] A divided bundle is asked as a whole if at most about so many triangles lie across its
  /// box.
  static constexpr S few_triangles = S(64);
  /// [-] Rays of a bundle that is worth finding out where they all start.
  static constexpr std::size_t fewest_to_ask = 65;

  /// What the rays of a block have met.
  struct BlockFindings {
    /// [-] Which of them have met nothing, and so do not tell where they start.
    BlockBits unmet = 0;
    /// Where one starts that has met something.
    Side side = Side::unknown;
  };

  void visit(std::size_t id, Known known);
  [[nodiscard]] bool cast_together(const Bundle& bundle, const BoxInTree<S>& box,
                                   const LeafList<S>& list, Side side);
  void cast_undivided(const Bundle& bundle, const BoxInTree<S>& box, const LeafList<S>* list,
                      Side side);
  void cast_blocks(const Bundle& bundle, std::size_t first, std::size_t end, Side side);
  [[nodiscard]] Side common_side(const Bundle& bundle, const BoxInTree<S>& box,
                                 const LeafList<S>* list);
  BRISTLE_INLINE void settle(std::size_t place, std::size_t count, const LaneCrossings<S>& found,
                             BlockFindings& findings);
  BRISTLE_INLINE void offer_in_order(std::size_t first, std::uint32_t offered,
                                     const LaneCrossings<S>& found);
  void decide(std::size_t place, BlockBits unmet, Side& side);
  void decide_empty(const Bundle& bundle, Side side);
  void cast_alone(std::size_t i, Side side = Side::unknown);
  [[nodiscard]] RayHit<S> hit_of(std::size_t i, Ray<S> ray, S best, Side side);
  void cast_one_by_one(std::size_t first, std::size_t end, Side side);

  /// Calls visit(ray, lane) for some rays from a place on, given as bits.
  template <typename Visit>
  void for_each_ray(std::size_t place, std::uint32_t lanes, Visit&& visit) const {
    const std::uint32_t* const rays = rays_.bundles->rays_from(place);
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      visit(rays[lane], lane);
    }
  }
  /// [-] How many triangles there are in a box of rays, if the surface lies across it.
  [[nodiscard]] S triangles_across(const Aabb<S>& box) const {
    const Vec3<S> extent = box.upper - box.lower;
    return extent.x() * extent.y() / mesh_.tree().mean_area();
  }
  /// Whether none of a bundle's rays is asked.
  [[nodiscard]] bool is_left_out(const Bundle& bundle) const {
    return bundle.first >= rays_.slice.end || bundle.first + bundle.count <= rays_.slice.first;
  }
  /// The places of a bundle's rays that are asked. What is known of a bundle is found out from all
  /// of them, so that the answers do not depend on the slice.
  [[nodiscard]] RaySlice asked_of(const Bundle& bundle) const {
    return {std::max(bundle.first, rays_.slice.first),
            std::min(bundle.first + bundle.count, rays_.slice.end)};
  }
  [[nodiscard]] BoxInTree<S> box_of(const Bundle& bundle, const BoxInTree<S>* framed) const;
  /// [m] Around the rays of the block that a place of a bundle lies in, in the bundle's frame.
  [[nodiscard]] Aabb<S> block_box(const Bundle& bundle, std::size_t place) const {
    return bundle.lengthened(rays_.bundles->block_box(place), rays_.extra_length)
        .inflated(margin(bundle));
  }
  [[nodiscard]] bool is_any_triangle_in(const BoxInTree<S>& box, const LeafList<S>& list) const;
  [[nodiscard]] bool gather(const BoxInTree<S>& box, const LeafList<S>& list);
  [[nodiscard]] Ray<S> ray_in_mesh(std::size_t i) const {
    const Vec3<S> origin(rays_.origin_x[i], rays_.origin_y[i], rays_.origin_z[i]);
    const Vec3<S> direction(rays_.direction_x[i], rays_.direction_y[i], rays_.direction_z[i]);
    return {R_CR_ * (origin - p_RC_), R_CR_ * direction, rays_.length[i] + rays_.extra_length};
  }
  [[nodiscard]] Side side_of(std::size_t i) const {
    const bool is_inside = ray_cast_mesh(mesh_, ray_in_mesh(i)).distance == S(0);
    return is_inside ? Side::inside : Side::outside;
  }
  void hit_inside(std::size_t i) {
    const Vec3<S> back(-rays_.direction_x[i], -rays_.direction_y[i], -rays_.direction_z[i]);
    hits_->offer(i, {S(0), back}, tag_);
  }
  /// [m] What rounding may do to coordinates in a bundle's frame.
  [[nodiscard]] S margin(const Bundle& bundle) const {
    return Tolerance<S>::round_off() * size_near(bundle);
  }
  [[nodiscard]] S size_near(const Bundle& bundle) const {
    return mesh_size_ + bundle.center.cwiseAbs().sum();
  }

  const RayMesh<S>& mesh_;
  const RayBatch<S>& rays_;
  LeafLists<S>& lists_;
  std::uint32_t tag_;
  RayHits<S>* hits_;
  /// Without hits: whether something was found that rays may meet.
  bool may_meet_ = false;
  Mat3<S> R_RC_;
  Mat3<S> R_CR_;
  Vec3<S> p_RC_;
  S mesh_size_ = S(0);
  /// Whether what rays keep is of this mesh: only rays that walk alone ask for it.
  bool keeps_ = false;
  LeafList<S> start_leaves_;
  BundleTriangles<S> triangles_;
};

template <Scalar S>
BoxInTree<S> BundleMeshQuery<S>::box_of(const Bundle& bundle, const BoxInTree<S>* framed) const {
  const Aabb<S> box = bundle.lengthened(bundle.box, rays_.extra_length).inflated(margin(bundle));
  if (framed != nullptr) return {framed->R_GC(), framed->p_GC(), box};
  return {bundle.axes * R_RC_, bundle.axes * (p_RC_ - bundle.center), box};
}

template <Scalar S>
void BundleMeshQuery<S>::visit(std::size_t id, Known known) {
  const Bundle& bundle = rays_.bundles->bundles()[id];
  if (may_meet_ || is_left_out(bundle)) return;
  const BoxInTree<S> box = box_of(bundle, known.framed);
  // Sought where they are not known yet, and handed on to the parts.
  const LeafList<S>*& list = known.list;
  Side& side = known.side;
  if (!box.box_C().overlaps(mesh_.root_box())) return;
  // [1] How many triangles there are for a ray.
  const S density = triangles_across(bundle.box) / S(bundle.count);
  const bool is_sparse = density > sparse_from;
  if (list == nullptr) {
    const bool fits = density * S(bundle.count) < S(LeafList<S>::capacity * 8);
    if (!is_sparse && fits && lists_[known.lists].search(mesh_.tree(), box)) {
      list = &lists_[known.lists++];
    }
  } else if (list->size() > short_list && known.lists < lists_.size()) {
    lists_[known.lists].filter(*list, box);
    list = &lists_[known.lists++];
  }
  if (list != nullptr && list->size() == 0) return decide_empty(bundle, side);
  const bool is_small = !bundle.is_divided() || density * S(bundle.count) <= few_triangles;
  if (hits_ != nullptr && !is_sparse && list != nullptr && is_small &&
      cast_together(bundle, box, *list, side)) {
    return;
  }
  // A look at the triangles costs less than going down to all bundles below where there is nothing
  // to be found, and ends with the first triangle where there is.
  if (bundle.is_divided() && list != nullptr &&
      (hits_ == nullptr || list->size() <= bundle.count / Bundles::bundle_size * 2) &&
      !is_any_triangle_in(box, *list)) {
    return decide_empty(bundle, side);
  }
  if (side == Side::unknown && bundle.is_narrow) side = common_side(bundle, box, list);
  if (hits_ == nullptr && (is_sparse || !bundle.is_divided())) {
    may_meet_ = list == nullptr || is_any_triangle_in(box, *list);
    return may_meet_ ? void() : decide_empty(bundle, side);
  }
  if (is_sparse) {
    const RaySlice asked = asked_of(bundle);
    const bool asks_all = rays_.slice.first == 0 && rays_.slice.end >= rays_.size();
    keeps_ = keeps_ || (rays_.kept != nullptr && asks_all &&
                        rays_.kept->begin(rays_.size(), tag_, rays_.shape_life));
    cast_one_by_one(asked.first, asked.end, side);
    return;
  }
  if (!bundle.is_divided()) return cast_undivided(bundle, box, list, side);
  known.framed = bundle.has_one_frame ? &box : nullptr;
  visit(id + 1, known);
  visit(bundle.second, known);
}

/// On which side all rays of a bundle start, if no triangle is between their starts.
template <Scalar S>
auto BundleMeshQuery<S>::common_side(const Bundle& bundle, const BoxInTree<S>& box,
                                     const LeafList<S>* list) -> Side {
  // Bundles of a few rays learn it from what these meet.
  if (bundle.count < fewest_to_ask) return Side::unknown;
  Aabb<S> starts = bundle.box.inflated(margin(bundle));
  starts.upper.z() = bundle.highest_start + margin(bundle);
  const BoxInTree<S> start_box(box.R_GC(), box.p_GC(), starts);
  if (list == nullptr && !start_leaves_.search(mesh_.tree(), start_box)) return Side::unknown;
  if (list == nullptr) list = &start_leaves_;
  if (is_any_triangle_in(start_box, *list)) return Side::unknown;
  return side_of(rays_.bundles->ray_at(bundle.first));
}

template <Scalar S>
bool BundleMeshQuery<S>::is_any_triangle_in(const BoxInTree<S>& box,
                                            const LeafList<S>& list) const {
  return !list.for_each(box, [&](std::size_t i) {
    return !BundleTriangles<S>::is_any_in(mesh_.tree(), list[i], box);
  });
}

template <Scalar S>
bool BundleMeshQuery<S>::gather(const BoxInTree<S>& box, const LeafList<S>& list) {
  triangles_.clear();
  return list.for_each(box,
                       [&](std::size_t i) { return triangles_.add(mesh_.tree(), list[i], box); });
}

/// Casts all rays of a bundle at the triangles in its box, if these are few.
/// @return Whether it has.
template <Scalar S>
bool BundleMeshQuery<S>::cast_together(const Bundle& bundle, const BoxInTree<S>& box,
                                       const LeafList<S>& list, Side side) {
  if (!bundle.has_one_frame || list.size() > most_leaves || !gather(box, list)) return false;
  const RaySlice asked = asked_of(bundle);
  triangles_.size() > 0 ? cast_blocks(bundle, asked.first, asked.end, side)
                        : decide_empty(bundle, side);
  return true;
}

/// Casts the rays of an undivided bundle that are not asked together.
template <Scalar S>
void BundleMeshQuery<S>::cast_undivided(const Bundle& bundle, const BoxInTree<S>& box,
                                        const LeafList<S>* list, Side side) {
  const std::size_t end = bundle.first + bundle.count;
  if (list == nullptr || !bundle.is_narrow) return cast_one_by_one(bundle.first, end, side);
  for (std::size_t place = bundle.first; place < end; place += Bundles::block_size) {
    const Aabb<S> block = block_box(bundle, place);
    const std::size_t block_end = std::min(end, place + Bundles::block_size);
    // Rays that are lengthened by much fan out and leave the solid again: with twice two layers of
    // triangles in sight, each of them alone costs less than to gather what then is too much.
    const bool is_few = S(4) * triangles_across(block) < S(BundleTriangles<S>::capacity);
    if (is_few && gather({box.R_GC(), box.p_GC(), block}, *list)) {
      cast_blocks(bundle, place, block_end, side);
    } else {
      cast_one_by_one(place, block_end, side);
    }
  }
}

/// Casts the rays of some blocks of a bundle with one frame at the candidates.
template <Scalar S>
void BundleMeshQuery<S>::cast_blocks(const Bundle& bundle, std::size_t first, std::size_t end,
                                     Side side) {
  triangles_.finish(bundle, bundle.axes.transpose(), size_near(bundle));
  const typename Bundles::Lines& lines = rays_.bundles->lines();
  const S lowest_start = bundle.box.lower.z() - margin(bundle);
  const S highest_start = bundle.highest_start + margin(bundle);
  const auto is_clear_of_starts = [&](std::size_t i) {
    return triangles_.lowest(i) > highest_start || triangles_.highest(i) < lowest_start;
  };
  bool is_uniform = true;
  for (std::size_t i = 0; i < triangles_.size() && side == Side::unknown; ++i) {
    is_uniform = is_uniform && is_clear_of_starts(i);
  }
  std::array<BlockBits, Bundles::frame_size / Bundles::block_size> unmet;
  std::size_t blocks = 0;
  for (std::size_t place = first; place < end; place += Bundles::block_size) {
    Candidates near;
    const std::size_t count = triangles_.within(block_box(bundle, place), near);
    const std::size_t block_end = std::min(end, place + Bundles::block_size);
    BlockFindings block;
    for (std::size_t k = place; k < block_end; k += lanes<S>) {
      const LaneRays<S> rays{Pack<S>::load(&lines.x[k]),
                             Pack<S>::load(&lines.y[k]),
                             Pack<S>::load(&lines.slope_x[k]),
                             Pack<S>::load(&lines.slope_y[k]),
                             Pack<S>::load(&lines.start[k]),
                             Pack<S>::load(&lines.stretch[k]),
                             Pack<S>::load(&lines.length[k]) + rays_.extra_length};
      LaneCrossings<S> found;
      for (std::size_t i = 0; i < count; ++i) triangles_.test(near[i], rays, found);
      settle(k, block_end - k, found, block);
    }
    if (is_uniform) {
      // What this block cannot tell another one may.
      unmet[blocks++] = block.unmet;
      if (block.side != Side::unknown) side = block.side;
    } else if (std::all_of(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count),
                           is_clear_of_starts)) {
      decide(place, block.unmet, block.side);
    } else {
      // They may start on the surface, which lanes may have seen behind them.
      for_each_ray(place, block.unmet, [&](std::size_t i, std::size_t) { cast_alone(i); });
    }
  }
  for (std::size_t k = 0; k < blocks; ++k) {
    decide(first + k * Bundles::block_size, unmet[k], side);
  }
}

/// Offers what rays in lanes have met.
template <Scalar S>
BRISTLE_INLINE void BundleMeshQuery<S>::settle(std::size_t place, std::size_t count,
                                               const LaneCrossings<S>& found,
                                               BlockFindings& findings) {
  const std::uint32_t there = first_bits(std::min(count, lanes<S>));
  const std::uint32_t met = bits(min(found.front, found.back) < Pack<S>(infinity<S>));
  const Pack<S> apart = S(2) * found.uncertainty;
  const std::uint32_t from_outside = bits(found.front + apart < found.back);
  const std::uint32_t from_inside = bits(found.back + apart < found.front);
  const std::uint32_t doubtful = bits(found.is_doubtful);
  const std::uint32_t outside = there & from_outside & ~doubtful;
  const std::uint32_t inside = there & from_inside & ~doubtful;
  const std::uint32_t unmet = there & ~met & ~doubtful;
  if (outside != 0) findings.side = Side::outside;
  if (inside != 0) findings.side = Side::inside;
  findings.unmet |= static_cast<BlockBits>(unmet << place % Bundles::block_size);
  if (outside != 0 && rays_.bundles->is_in_order(place)) {
    offer_in_order(rays_.bundles->ray_at(place), outside, found);
  } else if (outside != 0) {
    std::array<S, lanes<S>> distance, x, y, z;
    found.front.store(distance.data());
    found.normal.store(x.data(), y.data(), z.data());
    for_each_ray(place, outside, [&](std::size_t i, std::size_t lane) {
      hits_->offer(i, {distance[lane], {x[lane], y[lane], z[lane]}}, tag_);
    });
  }
  for_each_ray(place, inside, [&](std::size_t i, std::size_t) { hit_inside(i); });
  for_each_ray(place, there & ~(outside | inside | unmet),
               [&](std::size_t i, std::size_t) { cast_alone(i); });
}

/// As `RayHits::offer`, for rays that follow each other.
/// @param offered  [-] Lanes that have met something.
template <Scalar S>
BRISTLE_INLINE void BundleMeshQuery<S>::offer_in_order(std::size_t first, std::uint32_t offered,
                                                       const LaneCrossings<S>& found) {
  S* const distance = hits_->distance.data() + first;
  const Pack<S> known = Pack<S>::load(distance);
  const Mask<S> is_nearer = Mask<S>::from_bits(offered) & (found.front < known);
  const auto put = [&](S* row, const Pack<S>& value) {
    select(is_nearer, value, Pack<S>::load(row)).store(row);
  };
  put(distance, found.front);
  put(hits_->normal.x.data() + first, found.normal.x);
  put(hits_->normal.y.data() + first, found.normal.y);
  put(hits_->normal.z.data() + first, found.normal.z);
  const std::uint32_t nearer = bits(is_nearer);
  std::uint32_t* const tag = hits_->tag.data() + first;
  for (std::uint32_t i = 0; i < lanes<S>; ++i) tag[i] = (nearer >> i & 1u) != 0 ? tag_ : tag[i];
}

/// Finds out where rays start that have met nothing within their reach, with no triangle between
/// their starts.
/// @param side  Where they all start, found out if it is not known.
template <Scalar S>
void BundleMeshQuery<S>::decide(std::size_t place, BlockBits unmet, Side& side) {
  if (unmet == 0 || side == Side::outside) return;
  if (side == Side::unknown) {
    const auto first = static_cast<std::size_t>(std::countr_zero(unmet));
    side = side_of(rays_.bundles->ray_at(place + first));
  }
  if (side == Side::outside) return;
  for_each_ray(place, unmet, [&](std::size_t i, std::size_t) { hit_inside(i); });
}

/// The same for all rays of a bundle whose box holds no triangle.
template <Scalar S>
void BundleMeshQuery<S>::decide_empty(const Bundle& bundle, Side side) {
  if (side == Side::unknown) side = side_of(rays_.bundles->ray_at(bundle.first));
  if (side == Side::outside) return;
  if (hits_ == nullptr) {
    may_meet_ = true;
    return;
  }
  const RaySlice asked = asked_of(bundle);
  for (std::size_t k = asked.first; k < asked.end; ++k) hit_inside(rays_.bundles->ray_at(k));
}

template <Scalar S>
void BundleMeshQuery<S>::cast_alone(std::size_t i, Side side) {
  const S best = hits_->distance[i];
  if (!(best > S(0))) return;
  if (side == Side::inside) return hit_inside(i);
  const RayHit<S> hit = hit_of(i, ray_in_mesh(i), best, side);
  if (hit.distance < best) {
    hits_->offer(i, {hit.distance, R_RC_ * hit.normal}, tag_);
  }
}

/// The hit of a ray if it is nearer than `best`: by what the ray kept, or by a walk.
template <Scalar S>
RayHit<S> BundleMeshQuery<S>::hit_of(std::size_t i, Ray<S> ray, S best, Side side) {
  const S reach = std::min(ray.length, best);
  if (keeps_ && (side == Side::outside || !mesh_.root_box().contains(ray.origin))) {
    if (const auto hit = rays_.kept->cast(mesh_, i, ray, reach)) return *hit;
  }
  ray.length = reach;
  return side == Side::outside ? ray_cast_mesh_from_outside(mesh_, ray) : ray_cast_mesh(mesh_, ray);
}

template <Scalar S>
void BundleMeshQuery<S>::cast_one_by_one(std::size_t first, std::size_t end, Side side) {
  for (std::size_t k = first; k < end; ++k) cast_alone(rays_.bundles->ray_at(k), side);
}

}  // namespace detail

template <Scalar S>
void cast_rays_at_mesh(const RayMesh<S>& mesh, const Transform<S>& X_RC, const RayBatch<S>& rays,
                       std::uint32_t tag, RayHits<S>& hits) {
  detail::LeafLists<S> lists;
  detail::BundleMeshQuery<S>(mesh, X_RC, rays, tag, &hits, lists).run();
}

template <Scalar S>
bool is_clear_of_mesh(const RayMesh<S>& mesh, const Transform<S>& X_RC, const RayBatch<S>& rays) {
  detail::LeafLists<S> lists;
  return detail::BundleMeshQuery<S>(mesh, X_RC, rays, 0, nullptr, lists).is_clear();
}

}  // namespace bristle::inline BRISTLE_ABI
