/// @file
/// Binary tree of boxes, for moving bodies in the broad phase and triangles of a mesh.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
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

namespace bristle::inline BRISTLE_ABI::detail {

/// Boxes with their owners' numbers (payloads), found by box or by ray.
///
/// A leaf is inserted where it adds the least surface (the heuristic of Goldsmith and Salmon 1987).
/// Rotations improve the path above it (Kopta et al. 2012; Catto, GDC 2019). The tree depends only
/// on the sequence of calls. So does the order of visits.
///
/// Nodes are pooled. A tree that has once held n leaves does not allocate until it holds more. No
/// tree is higher than `max_height`: it is rebuilt, balanced by count, before that. So queries use
/// a stack of fixed size.
///
/// Boxes may be infinite, and are found. A box that overlaps everything costs every query near it.
/// So a world keeps its half-spaces in a list beside the tree.
///
/// Queries change nothing and may run concurrently. A visitor must not change the tree.
template <Scalar S>
class AabbTree {
 public:
  /// Id of a leaf until it is removed.
  using NodeId = std::uint32_t;
  /// [-] Bound on the number of edges from the root to any leaf.
  static constexpr int max_height = 64;

  /// Adds a leaf. O(log n) on boxes that are spread out.
  NodeId insert(const Aabb<S>& box, std::uint32_t payload);

  /// Removes a leaf. Its id may be reused.
  void remove(NodeId leaf);

  /// Moves a leaf, which keeps its id. If its parent still contains it, the boxes above shrink to
  /// fit. Otherwise it is inserted anew.
  void update(NodeId leaf, const Aabb<S>& box);

  /// Replaces all content by one leaf for each box. Its index in `boxes` is its payload and its id.
  /// Gives better trees than insertion (binned surface-area heuristic, Wald 2007). O(n log n).
  void build(std::span<const Aabb<S>> boxes);

  /// Removes everything and keeps the memory.
  void clear();

  /// [-] Number of leaves.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// [-] Edges from the root to the deepest leaf; 0 for a tree of at most one.
  [[nodiscard]] int height() const { return root_ == detail::no_index ? 0 : nodes_[root_].height; }
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
  /// Box around all leaves. Empty for an empty tree.
  [[nodiscard]] Aabb<S> root_box() const {
    return root_ == detail::no_index ? Aabb<S>{} : nodes_[root_].box;
  }

  /// Calls `visit(payload) -> bool` for every leaf whose box overlaps or touches `box`, until a
  /// visit returns false.
  template <typename Visit>
  void overlap(const Aabb<S>& box, Visit&& visit) const {
    find([&](const Aabb<S>& other) { return other.overlaps(box); }, visit);
  }

  /// Calls `visit(payload) -> bool` for every leaf that `accept(box) -> bool` takes together with
  /// all boxes around it, until a visit returns false.
  template <typename Accept, typename Visit>
  void find(Accept&& accept, Visit&& visit) const;

  /// Calls `visit(payload, max_distance) -> new max_distance` for every leaf whose box the ray
  /// meets before max_distance [m]. It starts as the ray's length. Nearer boxes come first. A visit
  /// ends the traversal by a negative number.
  ///
  /// No box that the ray touches is missed. Boxes beyond it by up to `Tolerance::round_off` of the
  /// distance are visited, too.
  template <typename Visit>
  void walk_ray(const Ray<S>& ray, Visit&& visit) const;

 private:
  struct Node {
    Aabb<S> box;
    NodeId parent = detail::no_index;  // Next free node if height < 0.
    std::array<NodeId, 2> child{detail::no_index,
                                detail::no_index};  // A leaf has `no_index` and its payload.
    std::int32_t height = 0;

    [[nodiscard]] bool is_leaf() const { return child[0] == detail::no_index; }
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
  NodeId build_range(std::span<SplitLeaf<S>> leaves, int depth);

  DynamicArray<Node> nodes_;
  DynamicArray<SplitLeaf<S>> order_;  // Scratch of rebuild(), as large as the pool.
  NodeId root_ = detail::no_index;
  NodeId free_ = detail::no_index;
  std::size_t size_ = 0;
};

// Implementation ----------------------------------------------------------------------------------

/// Cost of a node for a query, in proportion to its surface.
template <Scalar S>
[[nodiscard]] S tree_cost(const Aabb<S>& box) {
  const S area = box.half_area();
  // Clamped if it overflows or is NaN.
  if (area <= tree_extent_limit<S>() * tree_extent_limit<S>()) return area;
  return finite_part(box).half_area();
}

template <Scalar S>
[[nodiscard]] Aabb<S> merged(Aabb<S> a, const Aabb<S>& b) {
  a.include(b);
  return a;
}

/// Cost of a node around two boxes. The edges stay scalars: a box in memory is written in other
/// pieces than it is read in, and that stall exceeds all of this. Boxes beyond bounds take the slow
/// branch.
template <Scalar S>
[[nodiscard]] S merged_cost(const Aabb<S>& a, const Aabb<S>& b) {
  const auto edge = [&](Eigen::Index i) {
    return std::max(a.upper[i], b.upper[i]) - std::min(a.lower[i], b.lower[i]);
  };
  const S area = Aabb<S>::half_area_of(edge(0), edge(1), edge(2));
  if (area <= tree_extent_limit<S>() * tree_extent_limit<S>()) return area;
  return tree_cost(merged(a, b));
}

template <Scalar S>
auto AabbTree<S>::insert(const Aabb<S>& box, std::uint32_t payload) -> NodeId {
  BRISTLE_ASSERT(!box.is_empty());
  const NodeId leaf = allocate();
  nodes_[leaf].box = box;
  nodes_[leaf].child = {detail::no_index, payload};
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
  if (parent == detail::no_index) {
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
    nodes_[leaf].child = {detail::no_index, leaf};
  }
  size_ = boxes.size();
  rebuild();
}

template <Scalar S>
void AabbTree<S>::clear() {
  nodes_.clear();
  root_ = detail::no_index;
  free_ = detail::no_index;
  size_ = 0;
}

template <Scalar S>
template <typename Accept, typename Visit>
void AabbTree<S>::find(Accept&& accept, Visit&& visit) const {
  if (root_ == detail::no_index) return;
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
  if (root_ == detail::no_index) return;
  const SlabTest<S> slabs(ray);
  // Finite, so that planes at infinity are beyond it.
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
  if (free_ == detail::no_index) {
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

/// Inserts a detached leaf.
template <Scalar S>
void AabbTree<S>::attach(NodeId leaf) {
  if (root_ == detail::no_index) {
    nodes_[leaf].parent = detail::no_index;
    root_ = leaf;
    return;
  }
  const NodeId sibling = best_sibling(nodes_[leaf].box);
  const NodeId parent = allocate();
  const NodeId grandparent = nodes_[sibling].parent;
  nodes_[parent].parent = grandparent;
  nodes_[parent].child = {sibling, leaf};
  if (grandparent == detail::no_index) {
    root_ = parent;
  } else {
    auto& child = nodes_[grandparent].child;
    child[child[0] == sibling ? 0 : 1] = parent;
  }
  nodes_[sibling].parent = parent;
  nodes_[leaf].parent = parent;
  for (NodeId id = parent; id != detail::no_index; id = nodes_[id].parent) {
    fit(id);
    rotate(id);
  }
  if (nodes_[root_].height > max_height) rebuild();
}

/// Removes a leaf from the tree. Its parent goes, and its sibling moves up.
template <Scalar S>
void AabbTree<S>::detach(NodeId leaf) {
  const NodeId parent = nodes_[leaf].parent;
  if (parent == detail::no_index) {
    root_ = detail::no_index;
    return;
  }
  const auto& child = nodes_[parent].child;
  const NodeId sibling = child[child[0] == leaf ? 1 : 0];
  const NodeId grandparent = nodes_[parent].parent;
  nodes_[sibling].parent = grandparent;
  release(parent);
  if (grandparent == detail::no_index) {
    root_ = sibling;
  } else {
    auto& uncle = nodes_[grandparent].child;
    uncle[uncle[0] == parent ? 0 : 1] = sibling;
    fit_upwards(grandparent);
  }
}

/// Returns the node beside which a new leaf adds the least surface, searched down one path. The
/// cost of a sibling is the surface of the common parent plus the growth of all nodes above.
template <Scalar S>
auto AabbTree<S>::best_sibling(const Aabb<S>& box) const -> NodeId {
  const S box_cost = tree_cost(box);
  const auto distance_of = [&](NodeId child) {
    return (finite_center(nodes_[child].box) - finite_center(box)).squaredNorm();
  };
  NodeId best = root_;
  NodeId id = root_;
  S with_box = merged_cost(nodes_[root_].box, box);
  S best_cost = with_box;
  S growth_above = S(0);
  while (!nodes_[id].is_leaf()) {
    growth_above += with_box - tree_cost(nodes_[id].box);
    NodeId next = detail::no_index;
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
      // Lower bound of the cost below the child: at least that of the leaf itself. Boxes that
      // contain the leaf tie. Then the one with the nearer middle goes first.
      const S bound = growth_above + (cost - tree_cost(node.box)) + box_cost;
      const bool is_nearer =
          bound == next_bound && next != detail::no_index && distance_of(child) < distance_of(next);
      if (bound < next_bound || is_nearer) {
        next = child;
        next_bound = bound;
        next_with_box = cost;
      }
    }
    if (next == detail::no_index || !(next_bound < best_cost)) break;
    id = next;
    with_box = next_with_box;
  }
  return best;
}

/// Fits box and height of an inner node to its children. Returns whether they changed.
template <Scalar S>
bool AabbTree<S>::fit(NodeId id) {
  Node& node = nodes_[id];
  const Node& a = nodes_[node.child[0]];
  const Node& b = nodes_[node.child[1]];
  const Aabb<S> box = merged(a.box, b.box);
  const std::int32_t height = 1 + std::max(a.height, b.height);
  if (height == node.height && box.lower == node.box.lower && box.upper == node.box.upper) {
    return false;
  }
  node.box = box;
  node.height = height;
  return true;
}

/// Fits a node and its ancestors, up to the first that does not change.
template <Scalar S>
void AabbTree<S>::fit_upwards(NodeId id) {
  while (id != detail::no_index && fit(id)) id = nodes_[id].parent;
}

/// Exchanges a child with a grandchild from the other side if that makes the child's box smaller.
/// The node's own box stays.
template <Scalar S>
void AabbTree<S>::rotate(NodeId id) {
  NodeId best_child = detail::no_index;
  NodeId best_grandchild = detail::no_index;
  S best_gain = S(0);
  for (std::size_t side = 0; side < 2; ++side) {
    const NodeId child = nodes_[id].child[side];
    const NodeId other = nodes_[id].child[1 - side];
    if (nodes_[other].is_leaf()) continue;
    const S cost = tree_cost(nodes_[other].box);
    for (std::size_t i = 0; i < 2; ++i) {
      const NodeId stays = nodes_[other].child[1 - i];
      const S gain = cost - merged_cost(nodes_[child].box, nodes_[stays].box);
      if (gain > best_gain) {
        best_gain = gain;
        best_child = child;
        best_grandchild = nodes_[other].child[i];
      }
    }
  }
  if (best_child == detail::no_index) return;
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

/// Rebuilds all inner nodes over the present leaves.
template <Scalar S>
void AabbTree<S>::rebuild() {
  order_.clear();
  for (NodeId id = 0; id < nodes_.size(); ++id) {
    if (nodes_[id].height > 0) release(id);
    if (nodes_[id].height == 0) order_.push_back({id});
  }
  root_ = order_.empty() ? detail::no_index : build_range(order_, 0);
  if (root_ != detail::no_index) nodes_[root_].parent = detail::no_index;
}

template <Scalar S>
auto AabbTree<S>::build_range(std::span<SplitLeaf<S>> leaves, int depth) -> NodeId {
  if (leaves.size() == 1) return leaves.front().number;
  const NodeId id = allocate();
  const auto box_of = [this](NodeId leaf) -> const Aabb<S>& { return nodes_[leaf].box; };
  // From half the height on, halves: 2^32 leaves then end at the full height.
  const std::size_t middle = depth < max_height / 2 ? split_by_surface<S>(leaves, box_of)
                                                    : split_in_halves<S>(leaves, box_of);
  const NodeId a = build_range(leaves.first(middle), depth + 1);
  const NodeId b = build_range(leaves.subspan(middle), depth + 1);
  nodes_[id].child = {a, b};
  nodes_[a].parent = id;
  nodes_[b].parent = id;
  fit(id);
  return id;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
