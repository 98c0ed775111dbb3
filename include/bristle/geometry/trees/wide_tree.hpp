/// @file
/// A tree over triangles for ray casts. A node has many children, and vector registers test them
/// all at once.
///
/// It is flat, immutable and small: about 50 bytes a triangle in float and 90 in double. So a patch
/// that meets a fine mesh with cold caches does not wait for memory. Leaves keep their corners
/// beside each other, coordinate by coordinate, as the tests read them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/geometry/trees/aabb_split.hpp>
#include <bristle/math/pack3.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Some adjacent triangles, at most `WideTree::leaf_size` of them.
struct TriangleRange {
  std::uint32_t first;
  std::uint32_t count;
};

/// The tree. Immutable. The same triangles in the same order give the same tree.
template <Scalar S>
class WideTree {
 public:
  /// [-] Most children of a node, and most triangles of a leaf.
  static constexpr std::size_t width = 16;
  static constexpr std::size_t leaf_size = 16;

  /// Boxes of the children, coordinate by coordinate. The children come first. The other boxes are
  /// empty, and nothing overlaps them.
  struct alignas(64) Node {
    std::array<std::array<S, width>, 3> lower;
    std::array<std::array<S, width>, 3> upper;
    /// [-] First triangle of a leaf, or the node if the child's `triangles` are 0.
    std::array<std::uint32_t, width> first;
    std::array<std::uint8_t, width> triangles;
    std::uint32_t children;
  };

  WideTree() = default;
  /// @param corners_of  Callable: std::array<Vec3<S>, 3> corners_of(triangle), for each of `count`.
  template <typename CornersOf>
  WideTree(std::size_t count, const CornersOf& corners_of);

  /// [-] Number of triangles.
  [[nodiscard]] std::size_t size() const { return places_.size(); }
  /// [m] Box around all triangles.
  [[nodiscard]] const Aabb<S>& box() const { return box_; }
  /// [m^2] Mean area of a triangle.
  [[nodiscard]] S mean_area() const { return mean_area_; }
  /// [-] Root first. Empty if there are no triangles.
  [[nodiscard]] const DynamicArray<Node>& nodes() const { return nodes_; }

  /// [-] Number of the triangle at a position, as given to the constructor.
  [[nodiscard]] std::uint32_t number(std::size_t place) const { return numbers_[place]; }
  /// [-] The same from a position on. A pack may be loaded from any position.
  [[nodiscard]] const std::uint32_t* numbers(std::size_t place) const {
    return numbers_.data() + place;
  }
  /// [m] Coordinate `axis` of corner `corner` of the triangles of a leaf. A pack may be loaded from
  /// any of them. Its lanes beyond the last are garbage.
  [[nodiscard]] const S* row(const TriangleRange& leaf, std::size_t corner,
                             std::size_t axis) const {
    return corners_.data() + 9 * leaf.first + (3 * corner + axis) * leaf.count;
  }
  /// [m] Corners of a triangle, by its number as given to the constructor.
  [[nodiscard]] std::array<Vec3<S>, 3> corners(std::uint32_t number) const;

  /// [-] Stack entries of a depth-first traversal. Nodes are at most `max_height` deep, and each
  /// leaves all its children but one behind.
  static constexpr std::size_t max_height = 24;
  static constexpr std::size_t stack_size = max_height * (width - 1) + 1;

 private:
  struct Place {
    std::uint32_t row;  // Start of its corners.
    std::uint8_t stride;
  };

  std::uint32_t build(std::span<SplitLeaf<S>> triangles, std::size_t first,
                      const DynamicArray<Aabb<S>>& boxes, std::size_t depth);
  template <typename CornersOf>
  void store(const CornersOf& corners_of);

  DynamicArray<Node> nodes_;
  LineArray<S> corners_;
  DynamicArray<std::uint32_t> numbers_;
  DynamicArray<Place> places_;
  Aabb<S> box_;
  S mean_area_ = S(0);
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
template <typename CornersOf>
WideTree<S>::WideTree(std::size_t count, const CornersOf& corners_of) {
  DynamicArray<Aabb<S>> boxes(count);
  DynamicArray<SplitLeaf<S>> order(count);
  // Packs may be loaded up to their width beyond the last one.
  numbers_.assign(count + leaf_size, 0);
  places_.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto [a, b, c] = corners_of(i);
    boxes[i].include(a);
    boxes[i].include(b);
    boxes[i].include(c);
    box_.include(boxes[i]);
    mean_area_ += (b - a).cross(c - a).norm() / (S(2) * S(count));
    order[i].number = i;
  }
  if (count == 0) return;
  build(order, 0, boxes, 0);
  for (std::size_t i = 0; i < count; ++i) numbers_[i] = order[i].number;
  store(corners_of);
}

/// Divides triangles among the children of a new node. The one with the largest surface is divided
/// first, as it is met most often.
/// @param first  [-] Position of the first of these triangles among all.
template <Scalar S>
std::uint32_t WideTree<S>::build(std::span<SplitLeaf<S>> triangles, std::size_t first,
                                 const DynamicArray<Aabb<S>>& boxes, std::size_t depth) {
  const auto box_of = [&](std::uint32_t i) -> const Aabb<S>& { return boxes[i]; };
  struct Piece {
    std::span<SplitLeaf<S>> triangles;
    Aabb<S> box;
  };
  const auto piece_of = [&](std::span<SplitLeaf<S>> some) {
    Piece piece{some, {}};
    for (const auto& leaf : some) piece.box.include(boxes[leaf.number]);
    return piece;
  };
  std::array<Piece, width> pieces;
  pieces[0] = piece_of(triangles);
  std::size_t count = 1;
  while (count < width) {
    // From half the height on, halves of the most numerous: 16 to the power of 12 is enough.
    const bool is_deep = depth >= max_height / 2;
    Piece* largest = nullptr;
    S largest_cost = S(-1);
    for (std::size_t k = 0; k < count; ++k) {
      if (pieces[k].triangles.size() <= leaf_size) continue;
      const S cost =
          is_deep ? S(pieces[k].triangles.size()) : finite_part(pieces[k].box).half_area();
      if (cost > largest_cost) {
        largest = &pieces[k];
        largest_cost = cost;
      }
    }
    if (largest == nullptr) break;
    const auto all = largest->triangles;
    const std::size_t middle =
        is_deep ? split_in_halves<S>(all, box_of) : split_by_surface<S>(all, box_of);
    *largest = piece_of(all.first(middle));
    pieces[count++] = piece_of(all.subspan(middle));
  }
  const auto id = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_[id].children = static_cast<std::uint32_t>(count);
  for (std::size_t k = 0; k < width; ++k) {
    const Aabb<S> box = k < count ? pieces[k].box : Aabb<S>{};
    std::uint32_t child = 0;
    std::size_t leaf = 0;
    if (k < count) {
      const std::span<SplitLeaf<S>> some = pieces[k].triangles;
      const std::size_t place = first + static_cast<std::size_t>(some.data() - triangles.data());
      leaf = some.size() <= leaf_size ? some.size() : 0;
      child = leaf > 0 ? static_cast<std::uint32_t>(place) : build(some, place, boxes, depth + 1);
    }
    Node& node = nodes_[id];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.lower[axis][k] = box.lower[static_cast<int>(axis)];
      node.upper[axis][k] = box.upper[static_cast<int>(axis)];
    }
    node.first[k] = child;
    node.triangles[k] = static_cast<std::uint8_t>(leaf);
  }
  return id;
}

/// Copies the corners into the order of the leaves.
template <Scalar S>
template <typename CornersOf>
void WideTree<S>::store(const CornersOf& corners_of) {
  // Packs may be loaded up to their width beyond the last row.
  corners_.assign(9 * size() + 16, S(0));
  for (const Node& node : nodes_) {
    for (std::size_t k = 0; k < node.children; ++k) {
      const TriangleRange leaf{node.first[k], node.triangles[k]};
      for (std::uint32_t i = 0; i < leaf.count; ++i) {
        const std::uint32_t number = numbers_[leaf.first + i];
        places_[number] = {9 * leaf.first + i, static_cast<std::uint8_t>(leaf.count)};
        const std::array<Vec3<S>, 3> corners = corners_of(number);
        for (std::size_t c = 0; c < 9; ++c) {
          corners_[places_[number].row + c * leaf.count] = corners[c / 3][static_cast<int>(c % 3)];
        }
      }
    }
  }
}

template <Scalar S>
std::array<Vec3<S>, 3> WideTree<S>::corners(std::uint32_t number) const {
  const S* p = corners_.data() + places_[number].row;
  const std::size_t n = places_[number].stride;
  return {Vec3<S>(p[0], p[n], p[2 * n]), Vec3<S>(p[3 * n], p[4 * n], p[5 * n]),
          Vec3<S>(p[6 * n], p[7 * n], p[8 * n])};
}

}  // namespace bristle::inline BRISTLE_ABI::detail
