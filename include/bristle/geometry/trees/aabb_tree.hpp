/// @file
/// Binary tree of boxes: moving bodies in the broad phase and triangles of a mesh share it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/rays/ray_box.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/geometry/trees/aabb_split.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Boxes, each with a number that is its owner's (the payload), found by box or by ray.
///
/// Leaves are inserted where they add least surface (the heuristic of Goldsmith and Salmon 1987)
/// and the path above them is improved by rotations (Kopta et al. 2012; Catto, GDC 2019). The tree
/// is a function of the sequence of calls alone, and so is the order of visits.
///
/// Nodes are pooled: a tree that has once held n leaves does not allocate until it holds more. No
/// tree is higher than `max_height`: one that would grow beyond is built anew, balanced by count.
/// So queries run on a stack of fixed size.
///
/// Boxes may be infinite, and are found, but one that overlaps everything is a cost to every query
/// near it: a world keeps its half-spaces in a list beside the tree.
///
/// Queries change nothing and may run concurrently; a visitor must not change the tree.
template <Scalar S>
class AabbTree {
 public:
  /// Names a leaf until it is removed.
  using NodeId = std::uint32_t;
  /// Names no node.
  static constexpr NodeId null = 0xffffffffu;
  /// [-] Bound on the number of edges from the root to any leaf.
  static constexpr int max_height = 64;

  /// Adds a leaf. O(log n) on boxes that are spread out.
  NodeId insert(const Aabb<S>& box, std::uint32_t payload);

  /// Ends a leaf; its id may be given out again.
  void remove(NodeId leaf);

  /// Moves a leaf, which keeps its id. Where its parent still contains it the boxes above shrink to
  /// fit; otherwise it is inserted anew.
  void update(NodeId leaf, const Aabb<S>& box);

  /// Replaces all content by one leaf for each box, its place in `boxes` being its payload and its
  /// id. Gives better trees than insertion (binned surface-area heuristic, Wald 2007). O(n log n).
  void build(std::span<const Aabb<S>> boxes);

  /// Removes everything and keeps the memory.
  void clear();

  /// [-] Number of leaves.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// [-] Edges from the root to the deepest leaf; 0 for a tree of at most one.
  [[nodiscard]] int height() const { return root_ == null ? 0 : nodes_[root_].height; }
  /// Box of a leaf.
  [[nodiscard]] const Aabb<S>& box(NodeId leaf) const {
    BRISTLE_ASSERT(is_live_leaf(leaf));
    return nodes_[leaf].box;
  }
  /// Payload of a leaf.
  [[nodiscard]] std::uint32_t payload(NodeId leaf) const {
    BRISTLE_ASSERT(is_live_leaf(leaf));
    return nodes_[leaf].child[1];
  }
  /// Box around all leaves; empty for an empty tree.
  [[nodiscard]] Aabb<S> root_box() const { return root_ == null ? Aabb<S>{} : nodes_[root_].box; }

  /// Calls `visit(payload) -> bool` for every leaf whose box overlaps or touches `box`, until a
  /// visit returns false.
  template <typename Visit>
  void overlap(const Aabb<S>& box, Visit&& visit) const {
    find([&](const Aabb<S>& other) { return other.overlaps(box); }, visit);
  }

  /// Calls `visit(payload) -> bool` for every leaf that `accept(box) -> bool`s together with all
  /// boxes around it, until a visit returns false.
  template <typename Accept, typename Visit>
  void find(Accept&& accept, Visit&& visit) const;

  /// Calls `visit(payload, max_distance) -> new max_distance` for every leaf whose box the ray
  /// meets before max_distance [m], which starts as the ray's length; nearer boxes come first.
  ///
  /// No box that the ray touches is missed: what rounding may hide is visited too, up to
  /// `Tolerance::round_off` of the distance. A visit that wants no more returns a negative number.
  template <typename Visit>
  void walk_ray(const Ray<S>& ray, Visit&& visit) const;

 private:
  struct Node {
    Aabb<S> box;
    NodeId parent = null;                     // Next free node where height < 0.
    std::array<NodeId, 2> child{null, null};  // A leaf has null and its payload.
    std::int32_t height = 0;

    [[nodiscard]] bool is_leaf() const { return child[0] == null; }
  };

  [[nodiscard]] bool is_live_leaf(NodeId id) const {
    return id < nodes_.size() && nodes_[id].height == 0;
  }
  NodeId allocate();
  void release(NodeId id);

  void attach(NodeId leaf);
  void detach(NodeId leaf);
  [[nodiscard]] NodeId best_sibling(const Aabb<S>& box) const;
  bool fit(NodeId id);
  void fit_upwards(NodeId id);
  void rotate(NodeId id);
  void swap_subtrees(NodeId a, NodeId b);

  void rebuild();
  NodeId build_range(std::span<detail::SplitLeaf<S>> leaves, int depth);

  std::vector<Node> nodes_;
  std::vector<detail::SplitLeaf<S>> order_;  // Scratch of rebuild(), kept as large as the pool.
  NodeId root_ = null;
  NodeId free_ = null;
  std::size_t size_ = 0;
};

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// What a node costs a query: in proportion to its surface.
template <Scalar S>
[[nodiscard]] S tree_cost(const Aabb<S>& box) {
  const S area = box.half_area();
  // Not so where it overflows or is no number.
  if (area <= tree_extent_limit<S>() * tree_extent_limit<S>()) return area;
  return finite_part(box).half_area();
}

template <Scalar S>
[[nodiscard]] Aabb<S> merged(Aabb<S> a, const Aabb<S>& b) {
  a.include(b);
  return a;
}

/// What a node around two boxes costs. The edges stay scalars: a box that goes through memory is
/// written in other pieces than it is read in, and that takes longer than all of this. Boxes beyond
/// bounds go the long way.
template <Scalar S>
[[nodiscard]] S merged_cost(const Aabb<S>& a, const Aabb<S>& b) {
  const auto edge = [&](Eigen::Index i) {
    return std::max(a.upper[i], b.upper[i]) - std::min(a.lower[i], b.lower[i]);
  };
  const S area = Aabb<S>::half_area_of(edge(0), edge(1), edge(2));
  if (area <= tree_extent_limit<S>() * tree_extent_limit<S>()) return area;
  return tree_cost(merged(a, b));
}

}  // namespace detail

template <Scalar S>
auto AabbTree<S>::insert(const Aabb<S>& box, std::uint32_t payload) -> NodeId {
  BRISTLE_ASSERT(!box.is_empty());
  const NodeId leaf = allocate();
  nodes_[leaf].box = box;
  nodes_[leaf].child = {null, payload};
  attach(leaf);
  ++size_;
  return leaf;
}

template <Scalar S>
void AabbTree<S>::remove(NodeId leaf) {
  BRISTLE_ASSERT(is_live_leaf(leaf));
  detach(leaf);
  release(leaf);
  --size_;
}

template <Scalar S>
void AabbTree<S>::update(NodeId leaf, const Aabb<S>& box) {
  BRISTLE_ASSERT(is_live_leaf(leaf) && !box.is_empty());
  const NodeId parent = nodes_[leaf].parent;
  if (parent == null) {
    nodes_[leaf].box = box;
  } else if (nodes_[parent].box.contains(box)) {
    nodes_[leaf].box = box;
    fit_upwards(parent);
  } else {
    detach(leaf);
    nodes_[leaf].box = box;
    attach(leaf);
  }
}

template <Scalar S>
void AabbTree<S>::build(std::span<const Aabb<S>> boxes) {
  clear();
  nodes_.reserve(2 * boxes.size());
  for (const Aabb<S>& box : boxes) {
    BRISTLE_ASSERT(!box.is_empty());
    const NodeId leaf = allocate();
    nodes_[leaf].box = box;
    nodes_[leaf].child = {null, leaf};
  }
  size_ = boxes.size();
  rebuild();
}

template <Scalar S>
void AabbTree<S>::clear() {
  nodes_.clear();
  root_ = null;
  free_ = null;
  size_ = 0;
}

template <Scalar S>
template <typename Accept, typename Visit>
void AabbTree<S>::find(Accept&& accept, Visit&& visit) const {
  if (root_ == null) return;
  std::array<NodeId, max_height + 1> stack;
  std::size_t count = 0;
  stack[count++] = root_;
  while (count > 0) {
    const Node& node = nodes_[stack[--count]];
    if (!accept(node.box)) continue;
    if (node.is_leaf()) {
      if (!visit(node.child[1])) return;
    } else {
      stack[count++] = node.child[1];
      stack[count++] = node.child[0];
    }
  }
}

template <Scalar S>
template <typename Visit>
void AabbTree<S>::walk_ray(const Ray<S>& ray, Visit&& visit) const {
  if (root_ == null) return;
  const SlabTest<S> slabs(ray);
  // A finite reach, so that planes at infinity are out of it.
  S reach = std::min(ray.length, std::numeric_limits<S>::max() / S(2));
  struct Entry {
    NodeId node;
    S enter;
  };
  std::array<Entry, max_height + 1> stack;
  std::size_t count = 0;
  stack[count++] = {root_, slabs.enter(nodes_[root_].box, reach)};
  while (count > 0) {
    const Entry entry = stack[--count];
    // The reach may have shrunk since the entry was computed.
    if (!(entry.enter <= reach * (S(1) + Tolerance<S>::round_off()))) continue;
    const Node& node = nodes_[entry.node];
    if (node.is_leaf()) {
      reach = visit(node.child[1], reach);
    } else {
      Entry near{node.child[0], slabs.enter(nodes_[node.child[0]].box, reach)};
      Entry far{node.child[1], slabs.enter(nodes_[node.child[1]].box, reach)};
      if (far.enter < near.enter) std::swap(near, far);
      if (far.enter < infinity<S>) stack[count++] = far;
      if (near.enter < infinity<S>) stack[count++] = near;
    }
  }
}

template <Scalar S>
auto AabbTree<S>::allocate() -> NodeId {
  if (free_ == null) {
    nodes_.emplace_back();
    if (order_.capacity() < nodes_.capacity()) order_.reserve(nodes_.capacity());
    return static_cast<NodeId>(nodes_.size() - 1);
  }
  const NodeId id = free_;
  free_ = nodes_[id].parent;
  nodes_[id] = Node{};
  return id;
}

template <Scalar S>
void AabbTree<S>::release(NodeId id) {
  nodes_[id].height = -1;
  nodes_[id].parent = free_;
  free_ = id;
}

/// Hangs a loose leaf into the tree.
template <Scalar S>
void AabbTree<S>::attach(NodeId leaf) {
  if (root_ == null) {
    nodes_[leaf].parent = null;
    root_ = leaf;
    return;
  }
  const NodeId sibling = best_sibling(nodes_[leaf].box);
  const NodeId parent = allocate();
  const NodeId grandparent = nodes_[sibling].parent;
  nodes_[parent].parent = grandparent;
  nodes_[parent].child = {sibling, leaf};
  if (grandparent == null) {
    root_ = parent;
  } else {
    auto& child = nodes_[grandparent].child;
    child[child[0] == sibling ? 0 : 1] = parent;
  }
  nodes_[sibling].parent = parent;
  nodes_[leaf].parent = parent;
  for (NodeId id = parent; id != null; id = nodes_[id].parent) {
    fit(id);
    rotate(id);
  }
  if (nodes_[root_].height > max_height) rebuild();
}

/// Takes a leaf out of the tree; its parent goes, its sibling moves up.
template <Scalar S>
void AabbTree<S>::detach(NodeId leaf) {
  const NodeId parent = nodes_[leaf].parent;
  if (parent == null) {
    root_ = null;
    return;
  }
  const auto& child = nodes_[parent].child;
  const NodeId sibling = child[child[0] == leaf ? 1 : 0];
  const NodeId grandparent = nodes_[parent].parent;
  nodes_[sibling].parent = grandparent;
  release(parent);
  if (grandparent == null) {
    root_ = sibling;
  } else {
    auto& uncle = nodes_[grandparent].child;
    uncle[uncle[0] == parent ? 0 : 1] = sibling;
    fit_upwards(grandparent);
  }
}

/// The node beside which a new leaf adds least surface, searched down one path: what a sibling
/// costs is the surface of the common parent plus the growth of all nodes above.
template <Scalar S>
auto AabbTree<S>::best_sibling(const Aabb<S>& box) const -> NodeId {
  using detail::merged_cost;
  using detail::tree_cost;
  const S box_cost = tree_cost(box);
  const auto distance_of = [&](NodeId child) {
    return (detail::finite_center(nodes_[child].box) - detail::finite_center(box)).squaredNorm();
  };
  NodeId best = root_;
  NodeId id = root_;
  S with_box = merged_cost(nodes_[root_].box, box);
  S best_cost = with_box;
  S growth_above = S(0);
  while (!nodes_[id].is_leaf()) {
    growth_above += with_box - tree_cost(nodes_[id].box);
    NodeId next = null;
    S next_bound = infinity<S>;
    S next_with_box = S(0);
    for (const NodeId child : nodes_[id].child) {
      const Node& node = nodes_[child];
      const S cost = merged_cost(node.box, box);
      if (cost + growth_above < best_cost) {
        best = child;
        best_cost = cost + growth_above;
      }
      if (node.is_leaf()) continue;
      // Below the child at least the leaf itself is paid for. Boxes that contain the leaf tie, and
      // then the one around it goes first.
      const S bound = growth_above + (cost - tree_cost(node.box)) + box_cost;
      const bool is_nearer =
          bound == next_bound && next != null && distance_of(child) < distance_of(next);
      if (bound < next_bound || is_nearer) {
        next = child;
        next_bound = bound;
        next_with_box = cost;
      }
    }
    if (next == null || !(next_bound < best_cost)) break;
    id = next;
    with_box = next_with_box;
  }
  return best;
}

/// Box and height of an inner node from its children. Returns whether they are others than before.
template <Scalar S>
bool AabbTree<S>::fit(NodeId id) {
  Node& node = nodes_[id];
  const Node& a = nodes_[node.child[0]];
  const Node& b = nodes_[node.child[1]];
  const Aabb<S> box = detail::merged(a.box, b.box);
  const std::int32_t height = 1 + std::max(a.height, b.height);
  if (height == node.height && box.lower == node.box.lower && box.upper == node.box.upper) {
    return false;
  }
  node.box = box;
  node.height = height;
  return true;
}

/// Fits a node and those above it, as far as anything changes.
template <Scalar S>
void AabbTree<S>::fit_upwards(NodeId id) {
  while (id != null && fit(id)) id = nodes_[id].parent;
}

/// Exchanges a child with a grandchild from the other side where that makes the child's box
/// smaller; the node's own box stays.
template <Scalar S>
void AabbTree<S>::rotate(NodeId id) {
  NodeId best_child = null;
  NodeId best_grandchild = null;
  S best_gain = S(0);
  for (std::size_t side = 0; side < 2; ++side) {
    const NodeId child = nodes_[id].child[side];
    const NodeId other = nodes_[id].child[1 - side];
    if (nodes_[other].is_leaf()) continue;
    const S cost = detail::tree_cost(nodes_[other].box);
    for (std::size_t i = 0; i < 2; ++i) {
      const NodeId stays = nodes_[other].child[1 - i];
      const S gain = cost - detail::merged_cost(nodes_[child].box, nodes_[stays].box);
      if (gain > best_gain) {
        best_gain = gain;
        best_child = child;
        best_grandchild = nodes_[other].child[i];
      }
    }
  }
  if (best_child == null) return;
  const NodeId other = nodes_[best_grandchild].parent;
  swap_subtrees(best_child, best_grandchild);
  fit(other);
  fit(id);
}

template <Scalar S>
void AabbTree<S>::swap_subtrees(NodeId a, NodeId b) {
  const NodeId parent_a = nodes_[a].parent;
  const NodeId parent_b = nodes_[b].parent;
  auto& slot_a = nodes_[parent_a].child;
  auto& slot_b = nodes_[parent_b].child;
  slot_a[slot_a[0] == a ? 0 : 1] = b;
  slot_b[slot_b[0] == b ? 0 : 1] = a;
  nodes_[a].parent = parent_b;
  nodes_[b].parent = parent_a;
}

/// Builds all inner nodes anew over the leaves there are.
template <Scalar S>
void AabbTree<S>::rebuild() {
  order_.clear();
  for (NodeId id = 0; id < nodes_.size(); ++id) {
    if (nodes_[id].height > 0) release(id);
    if (nodes_[id].height == 0) order_.push_back({id});
  }
  root_ = order_.empty() ? null : build_range(order_, 0);
  if (root_ != null) nodes_[root_].parent = null;
}

template <Scalar S>
auto AabbTree<S>::build_range(std::span<detail::SplitLeaf<S>> leaves, int depth) -> NodeId {
  if (leaves.size() == 1) return leaves.front().number;
  const NodeId id = allocate();
  const auto box_of = [this](NodeId leaf) -> const Aabb<S>& { return nodes_[leaf].box; };
  // From half the height on, halves: 2^32 leaves then end at the full height.
  const std::size_t middle = depth < max_height / 2 ? detail::split_by_surface<S>(leaves, box_of)
                                                    : detail::split_in_halves<S>(leaves, box_of);
  const NodeId a = build_range(leaves.first(middle), depth + 1);
  const NodeId b = build_range(leaves.subspan(middle), depth + 1);
  nodes_[id].child = {a, b};
  nodes_[a].parent = id;
  nodes_[b].parent = id;
  fit(id);
  return id;
}

}  // namespace bristle::inline BRISTLE_ABI
