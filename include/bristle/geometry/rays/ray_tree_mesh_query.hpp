/// @file
/// Nodes of rays against a solid mesh. One search serves many rays. Triangles are tested against
/// rays in lanes.
///
/// Hits are those of `ray_cast_mesh` for each ray alone, to round-off. Rays that the lanes cannot
/// decide are cast again alone.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/triangle_cache.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/rays/mesh_rays.hpp>
#include <bristle/geometry/rays/node_triangles.hpp>
#include <bristle/geometry/rays/ray_mesh.hpp>
#include <bristle/geometry/rays/ray_tree.hpp>
#include <bristle/geometry/rays/ray_tree_leaves.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace bristle::inline BRISTLE_ABI::detail {

/// Offers to `hits` the nearest hit of each ray with a solid at X_RC, as `ShapeBackend::cast_rays`
/// does. Uses the rays' nodes if they have any. Allocates nothing.
template <Scalar S>
void cast_rays_at_mesh(const RayMesh<S>& mesh, const Transform<S>& X_RC, const RayBatch<S>& rays,
                       std::uint32_t tag, RayHits<S>& hits);

/// Returns true only if no ray of a batch can meet a solid at X_RC. Tests boxes. Mostly true if no
/// ray can, never true if one can. False for rays without nodes.
template <Scalar S>
[[nodiscard]] bool misses_mesh(const RayMesh<S>& mesh, const Transform<S>& X_RC,
                               const RayBatch<S>& rays);

// Implementation ----------------------------------------------------------------------------------

/// One query of the rays of a batch at a mesh.
template <Scalar S>
class RayTreeMeshQuery {
 public:
  /// @param hits  Null if the query only tests whether rays may meet the mesh.
  RayTreeMeshQuery(const RayMesh<S>& mesh, const Transform<S>& X_RC, const RayBatch<S>& rays,
                   std::uint32_t tag, RayHits<S>* hits, LeafLists<S>& lists)
      : mesh_(mesh),
        rays_(rays),
        lists_(lists),
        tag_(tag),
        hits_(hits),
        R_RC_(X_RC.rotation_matrix()),
        R_CR_(transposed(R_RC_)),
        p_RC_(X_RC.translation) {
    const Aabb<S> box = mesh.root_box();
    mesh_size_ =
        cwise_max(cwise_abs(box.lower), cwise_abs(box.upper)).sum() + cwise_abs(p_RC_).sum();
  }

  void run() {
    if (rays_.ray_tree == nullptr || rays_.ray_tree->is_empty()) {
      const std::size_t end = std::min<std::size_t>(rays_.range.end, rays_.size());
      for (std::size_t i = rays_.range.first; i < end; ++i) cast_alone(i);
    } else {
      visit(0, {});
    }
  }

  /// The early out: returns whether surely no ray meets the mesh.
  [[nodiscard]] bool misses() {
    if (rays_.ray_tree == nullptr || rays_.ray_tree->is_empty()) return false;
    visit(0, {});
    return !may_meet_;
  }

 private:
  using Node = RayTreeNode<S>;
  using Tree = RayTree<S>;
  using Known = KnownOfNode<S>;
  using Candidates = std::array<std::uint8_t, NodeTriangles<S>::capacity>;
  /// Rays of a packet, as bits.
  using PacketBits = std::uint16_t;

  /// Results of the rays of a packet.
  struct PacketFindings {
    /// [-] Rays that have met nothing, so that the side of their start is unknown.
    PacketBits unmet = 0;
    /// Side of the start of a ray that has met something.
    Side side = Side::unknown;
  };

  void visit(std::size_t id, Known known);
  [[nodiscard]] bool cast_together(const Node& node, const BoxInTree<S>& box,
                                   const LeafList<S>& list, Side side);
  void cast_undivided(const Node& node, const BoxInTree<S>& box, const LeafList<S>* list,
                      Side side);
  void cast_packets(const Node& node, std::size_t first, std::size_t end, Side side);
  [[nodiscard]] Side common_side(const Node& node, const BoxInTree<S>& box,
                                 const LeafList<S>* list);
  BRISTLE_FORCE_INLINE void settle(std::size_t place, std::size_t count,
                                   const LaneCrossings<S>& found, PacketFindings& findings);
  BRISTLE_FORCE_INLINE void offer_in_order(std::size_t first, std::uint32_t offered,
                                           const LaneCrossings<S>& found);
  void decide(std::size_t place, PacketBits unmet, Side& side);
  void decide_empty(const Node& node, Side side);
  void cast_alone(std::size_t i, Side side = Side::unknown);
  [[nodiscard]] RayHit<S> hit_of(std::size_t i, Ray<S> ray, S best, Side side);
  void cast_one_by_one(std::size_t first, std::size_t end, Side side);

  /// Calls visit(ray, lane) for the rays of a mask, from a position on.
  template <typename Visit>
  void for_each_ray(std::size_t place, std::uint32_t lanes, Visit&& visit) const {
    const std::uint32_t* const rays = rays_.ray_tree->rays_from(place);
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      visit(rays[lane], lane);
    }
  }
  /// [-] Number of triangles in a box of rays, if the surface lies across it.
  [[nodiscard]] S triangles_across(const Aabb<S>& box) const {
    const Vec3<S> extent = box.upper - box.lower;
    return extent.x() * extent.y() / mesh_.tree().mean_area();
  }
  /// Returns whether all of a node's rays are outside the range.
  [[nodiscard]] bool is_left_out(const Node& node) const {
    return node.first >= rays_.range.end || node.first + node.count <= rays_.range.first;
  }
  /// The positions of a node's rays in the range. Knowledge about a node comes from all of its
  /// rays. So results do not depend on the range.
  [[nodiscard]] RayRange asked_of(const Node& node) const {
    return {std::max(node.first, rays_.range.first),
            std::min(node.first + node.count, rays_.range.end)};
  }
  [[nodiscard]] BoxInTree<S> box_of(const Node& node, const BoxInTree<S>* framed) const;
  /// [m] Box around the rays of the packet at a position of a node, in the node's frame.
  [[nodiscard]] Aabb<S> packet_box(const Node& node, std::size_t place) const {
    return node.lengthened(rays_.ray_tree->packet_box(place), rays_.extra_length)
        .inflated(margin(node));
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
  /// [m] Error bound of coordinates in a node's frame.
  [[nodiscard]] S margin(const Node& node) const {
    return Tolerance<S>::round_off() * size_near(node);
  }
  [[nodiscard]] S size_near(const Node& node) const {
    return mesh_size_ + cwise_abs(node.center).sum();
  }

  const RayMesh<S>& mesh_;
  const RayBatch<S>& rays_;
  LeafLists<S>& lists_;
  std::uint32_t tag_;
  RayHits<S>* hits_;
  /// Set by a query without hits if rays may meet something.
  bool may_meet_ = false;
  Mat3<S> R_RC_;
  Mat3<S> R_CR_;
  Vec3<S> p_RC_;
  S mesh_size_ = S(0);
  /// Says whether the rays' triangle cache is of this mesh, once that was asked. Only rays that are
  /// cast alone use it.
  std::optional<bool> uses_triangle_cache_;
  LeafList<S> start_leaves_;
  NodeTriangles<S> triangles_;
};

template <Scalar S>
BoxInTree<S> RayTreeMeshQuery<S>::box_of(const Node& node, const BoxInTree<S>* framed) const {
  const Aabb<S> box = node.lengthened(node.box, rays_.extra_length).inflated(margin(node));
  if (framed != nullptr) return {framed->R_GC(), framed->p_GC(), box};
  return {node.axes * R_RC_, node.axes * (p_RC_ - node.center), box};
}

template <Scalar S>
void RayTreeMeshQuery<S>::visit(std::size_t id, Known known) {
  const Node& node = rays_.ray_tree->nodes()[id];
  if (may_meet_ || is_left_out(node)) return;
  const BoxInTree<S> box = box_of(node, known.framed);
  // Searched if still unknown, and handed on to the children.
  const LeafList<S>*& list = known.list;
  Side& side = known.side;
  if (!box.box_C().overlaps(mesh_.root_box())) return;
  // [1] Triangles for each ray.
  const S density = triangles_across(node.box) / S(node.count);
  const bool is_sparse = density > S(chosen::sparse_ray_triangles);
  if (list == nullptr) {
    const bool fits = density * S(node.count) < S(LeafList<S>::capacity * chosen::leaf_triangles);
    if (!is_sparse && fits && lists_[known.lists].search(mesh_.tree(), box)) {
      list = &lists_[known.lists++];
    }
  } else if (list->size() > chosen::short_leaf_list && known.lists < lists_.size()) {
    lists_[known.lists].filter(*list, box);
    list = &lists_[known.lists++];
  }
  if (list != nullptr && list->size() == 0) return decide_empty(node, side);
  const bool is_small =
      !node.is_divided() || density * S(node.count) <= S(chosen::whole_node_triangles);
  if (hits_ != nullptr && !is_sparse && list != nullptr && is_small &&
      cast_together(node, box, *list, side)) {
    return;
  }
  // If nothing is in the box, testing the triangles costs less than descending to all nodes below.
  // If something is, the test ends with the first triangle.
  if (node.is_divided() && list != nullptr &&
      (hits_ == nullptr ||
       list->size() <= node.count / Tree::leaf_size * chosen::empty_test_leaves) &&
      !is_any_triangle_in(box, *list)) {
    return decide_empty(node, side);
  }
  if (side == Side::unknown && node.is_narrow) side = common_side(node, box, list);
  if (hits_ == nullptr && (is_sparse || !node.is_divided())) {
    may_meet_ = list == nullptr || is_any_triangle_in(box, *list);
    return may_meet_ ? void() : decide_empty(node, side);
  }
  // Of a fan most nodes pass by the mesh: finding them costs less than casting their rays.
  if (is_sparse && !node.is_divided()) {
    const RayRange asked = asked_of(node);
    const bool asks_all = rays_.range.first == 0 && rays_.range.end >= rays_.size();
    // Once a query: the cache counts how often it is asked.
    if (!uses_triangle_cache_) {
      uses_triangle_cache_ = rays_.triangle_cache != nullptr && asks_all &&
                             rays_.triangle_cache->begin(rays_.size(), tag_, rays_.shape_life);
    }
    cast_one_by_one(asked.first, asked.end, side);
    return;
  }
  if (!node.is_divided()) return cast_undivided(node, box, list, side);
  known.framed = node.has_one_frame ? &box : nullptr;
  visit(id + 1, known);
  visit(node.second, known);
}

/// Side on which all rays of a node start, if no triangle is between their starts.
template <Scalar S>
auto RayTreeMeshQuery<S>::common_side(const Node& node, const BoxInTree<S>& box,
                                      const LeafList<S>* list) -> Side {
  // A few rays learn their side from their own crossings.
  if (node.count < chosen::common_side_rays) return Side::unknown;
  Aabb<S> starts = node.box.inflated(margin(node));
  starts.upper.z() = node.highest_start + margin(node);
  const BoxInTree<S> start_box(box.R_GC(), box.p_GC(), starts);
  if (list == nullptr && !start_leaves_.search(mesh_.tree(), start_box)) return Side::unknown;
  if (list == nullptr) list = &start_leaves_;
  if (is_any_triangle_in(start_box, *list)) return Side::unknown;
  return side_of(rays_.ray_tree->ray_at(node.first));
}

template <Scalar S>
bool RayTreeMeshQuery<S>::is_any_triangle_in(const BoxInTree<S>& box,
                                             const LeafList<S>& list) const {
  return !list.for_each(
      box, [&](std::size_t i) { return !NodeTriangles<S>::is_any_in(mesh_.tree(), list[i], box); });
}

template <Scalar S>
bool RayTreeMeshQuery<S>::gather(const BoxInTree<S>& box, const LeafList<S>& list) {
  triangles_.clear();
  return list.for_each(box,
                       [&](std::size_t i) { return triangles_.add(mesh_.tree(), list[i], box); });
}

/// Casts all rays of a node at the triangles in its box, if these are few.
/// @return True if it has.
template <Scalar S>
bool RayTreeMeshQuery<S>::cast_together(const Node& node, const BoxInTree<S>& box,
                                        const LeafList<S>& list, Side side) {
  if (!node.has_one_frame || list.size() > chosen::whole_node_leaves) return false;
  if (!gather(box, list)) return false;
  const RayRange asked = asked_of(node);
  triangles_.size() > 0 ? cast_packets(node, asked.first, asked.end, side)
                        : decide_empty(node, side);
  return true;
}

/// Casts the rays of a leaf that are not cast together.
template <Scalar S>
void RayTreeMeshQuery<S>::cast_undivided(const Node& node, const BoxInTree<S>& box,
                                         const LeafList<S>* list, Side side) {
  const std::size_t end = node.first + node.count;
  if (list == nullptr || !node.is_narrow) return cast_one_by_one(node.first, end, side);
  for (std::size_t place = node.first; place < end; place += packet_size) {
    const Aabb<S> packet = packet_box(node, place);
    const std::size_t packet_end = std::min(end, place + packet_size);
    // Rays that are lengthened by much fan out and leave the solid again. With twice two layers of
    // triangles in sight, casting each ray alone costs less than gathering too many triangles.
    const bool is_few =
        S(chosen::layers_in_sight) * triangles_across(packet) < S(NodeTriangles<S>::capacity);
    if (is_few && gather({box.R_GC(), box.p_GC(), packet}, *list)) {
      cast_packets(node, place, packet_end, side);
    } else {
      cast_one_by_one(place, packet_end, side);
    }
  }
}

/// Casts the rays of some packets of a node with one frame at the candidates.
template <Scalar S>
void RayTreeMeshQuery<S>::cast_packets(const Node& node, std::size_t first, std::size_t end,
                                       Side side) {
  triangles_.finish(node, transposed(node.axes), size_near(node));
  const typename Tree::Lines& lines = rays_.ray_tree->lines();
  const S lowest_start = node.box.lower.z() - margin(node);
  const S highest_start = node.highest_start + margin(node);
  const auto is_clear_of_starts = [&](std::size_t i) {
    return triangles_.lowest(i) > highest_start || triangles_.highest(i) < lowest_start;
  };
  bool is_uniform = true;
  for (std::size_t i = 0; i < triangles_.size() && side == Side::unknown; ++i) {
    is_uniform = is_uniform && is_clear_of_starts(i);
  }
  std::array<PacketBits, Tree::frame_size / packet_size> unmet;
  std::size_t packets = 0;
  for (std::size_t place = first; place < end; place += packet_size) {
    Candidates near;
    const std::size_t count = triangles_.within(packet_box(node, place), near);
    const std::size_t packet_end = std::min(end, place + packet_size);
    PacketFindings packet;
    for (std::size_t k = place; k < packet_end; k += lanes<S>) {
      const LaneRays<S> rays{Pack<S>::load(&lines.x[k]),
                             Pack<S>::load(&lines.y[k]),
                             Pack<S>::load(&lines.slope_x[k]),
                             Pack<S>::load(&lines.slope_y[k]),
                             Pack<S>::load(&lines.start[k]),
                             Pack<S>::load(&lines.stretch[k]),
                             Pack<S>::load(&lines.length[k]) + rays_.extra_length};
      LaneCrossings<S> found;
      for (std::size_t i = 0; i < count; ++i) triangles_.test(near[i], rays, found);
      settle(k, packet_end - k, found, packet);
    }
    if (is_uniform) {
      // Another packet may decide for the rays that this one cannot.
      unmet[packets++] = packet.unmet;
      if (packet.side != Side::unknown) side = packet.side;
    } else if (std::all_of(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count),
                           is_clear_of_starts)) {
      decide(place, packet.unmet, packet.side);
    } else {
      // They may start on the surface. Lanes may have seen it behind them.
      for_each_ray(place, packet.unmet, [&](std::size_t i, std::size_t) { cast_alone(i); });
    }
  }
  for (std::size_t k = 0; k < packets; ++k) {
    decide(first + k * packet_size, unmet[k], side);
  }
}

/// Offers the hits of rays in lanes.
template <Scalar S>
BRISTLE_FORCE_INLINE void RayTreeMeshQuery<S>::settle(std::size_t place, std::size_t count,
                                                      const LaneCrossings<S>& found,
                                                      PacketFindings& findings) {
  const std::uint32_t there = first_bits(std::min(count, lanes<S>));
  const std::uint32_t met = bits(min(found.front, found.back) < Pack<S>(infinity<S>));
  // Front and back may both be off.
  const Pack<S> apart = S(2) * found.uncertainty;
  const std::uint32_t from_outside = bits(found.front + apart < found.back);
  const std::uint32_t from_inside = bits(found.back + apart < found.front);
  const std::uint32_t doubtful = bits(found.is_doubtful);
  const std::uint32_t outside = there & from_outside & ~doubtful;
  const std::uint32_t inside = there & from_inside & ~doubtful;
  const std::uint32_t unmet = there & ~met & ~doubtful;
  if (outside != 0) findings.side = Side::outside;
  if (inside != 0) findings.side = Side::inside;
  findings.unmet |= static_cast<PacketBits>(unmet << place % packet_size);
  if (outside != 0 && rays_.ray_tree->is_in_order(place)) {
    offer_in_order(rays_.ray_tree->ray_at(place), outside, found);
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

/// As `RayHits::offer`, for consecutive rays.
/// @param offered  [-] Lanes with a hit.
template <Scalar S>
BRISTLE_FORCE_INLINE void RayTreeMeshQuery<S>::offer_in_order(std::size_t first,
                                                              std::uint32_t offered,
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

/// Decides on rays that have met nothing within their length, with no triangle between their
/// starts. They are hit at the start if that is inside.
/// @param side  Side on which they all start. Found if it is not known.
template <Scalar S>
void RayTreeMeshQuery<S>::decide(std::size_t place, PacketBits unmet, Side& side) {
  if (unmet == 0 || side == Side::outside) return;
  if (side == Side::unknown) {
    const auto first = static_cast<std::size_t>(std::countr_zero(unmet));
    side = side_of(rays_.ray_tree->ray_at(place + first));
  }
  if (side == Side::outside) return;
  for_each_ray(place, unmet, [&](std::size_t i, std::size_t) { hit_inside(i); });
}

/// The same for all rays of a node whose box holds no triangle.
template <Scalar S>
void RayTreeMeshQuery<S>::decide_empty(const Node& node, Side side) {
  if (side == Side::unknown) side = side_of(rays_.ray_tree->ray_at(node.first));
  if (side == Side::outside) return;
  if (hits_ == nullptr) {
    may_meet_ = true;
    return;
  }
  const RayRange asked = asked_of(node);
  for (std::size_t k = asked.first; k < asked.end; ++k) hit_inside(rays_.ray_tree->ray_at(k));
}

template <Scalar S>
void RayTreeMeshQuery<S>::cast_alone(std::size_t i, Side side) {
  const S best = hits_->distance[i];
  if (!(best > S(0))) return;
  if (side == Side::inside) return hit_inside(i);
  const RayHit<S> hit = hit_of(i, ray_in_mesh(i), best, side);
  if (hit.distance < best) {
    hits_->offer(i, {hit.distance, R_RC_ * hit.normal}, tag_);
  }
}

/// Returns the hit of a ray if it is nearer than `best`. It comes from the triangle cache or a
/// traversal.
template <Scalar S>
RayHit<S> RayTreeMeshQuery<S>::hit_of(std::size_t i, Ray<S> ray, S best, Side side) {
  const S reach = std::min(ray.length, best);
  if (uses_triangle_cache_.value_or(false) &&
      (side == Side::outside || !mesh_.root_box().contains(ray.origin))) {
    if (const auto hit = rays_.triangle_cache->cast(mesh_, i, ray, reach)) return *hit;
  }
  ray.length = reach;
  return side == Side::outside ? ray_cast_mesh_from_outside(mesh_, ray) : ray_cast_mesh(mesh_, ray);
}

template <Scalar S>
void RayTreeMeshQuery<S>::cast_one_by_one(std::size_t first, std::size_t end, Side side) {
  for (std::size_t k = first; k < end; ++k) cast_alone(rays_.ray_tree->ray_at(k), side);
}

template <Scalar S>
void cast_rays_at_mesh(const RayMesh<S>& mesh, const Transform<S>& X_RC, const RayBatch<S>& rays,
                       std::uint32_t tag, RayHits<S>& hits) {
  LeafLists<S> lists;
  RayTreeMeshQuery<S>(mesh, X_RC, rays, tag, &hits, lists).run();
}

template <Scalar S>
bool misses_mesh(const RayMesh<S>& mesh, const Transform<S>& X_RC, const RayBatch<S>& rays) {
  LeafLists<S> lists;
  return RayTreeMeshQuery<S>(mesh, X_RC, rays, 0, nullptr, lists).misses();
}

}  // namespace bristle::inline BRISTLE_ABI::detail
