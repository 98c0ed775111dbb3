/// @file
/// Split of a set of boxes between the two children of a tree node.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/trees/aabb.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// [m] Limit that no scene reaches, small enough that sums of areas of such boxes are finite. Its
/// square is 2^-32 of the largest number. A box has an area of at most 24 squares, so a hundred
/// million boxes have a finite sum. It is a function, not a constant. A constant computed at
/// program start would be 0 for a world that other constants build before.
template <Scalar S>
[[nodiscard]] inline S tree_extent_limit() {
  using std::sqrt;
  return sqrt(std::numeric_limits<S>::max()) / S(65536);
}

/// The box clamped to a finite size, so that infinite boxes can be compared.
template <Scalar S>
[[nodiscard]] Aabb<S> finite_part(const Aabb<S>& box) {
  const S limit = tree_extent_limit<S>();
  return {cwise_clamp(box.lower, limit), cwise_clamp(box.upper, limit)};
}

/// Middle of a box. Finite even if the box is not.
template <Scalar S>
[[nodiscard]] Vec3<S> finite_center(const Aabb<S>& box) {
  return finite_part(box).center();
}

/// A leaf that is being sorted into a tree. Its sort key is computed once and stored. Computed anew
/// for each comparison it may be rounded in another way. The order would be lost.
template <Scalar S>
struct SplitLeaf {
  std::uint32_t number = 0;
  S key = S(0);
};

/// Sets the key of each leaf to the middle of its box, along the axis of largest spread.
/// @param box_of  Callable: the box of the leaf of a number.
template <Scalar S, typename BoxOf>
void key_by_center(std::span<SplitLeaf<S>> leaves, const BoxOf& box_of) {
  Aabb<S> centers;
  for (const SplitLeaf<S>& leaf : leaves) centers.include(finite_center<S>(box_of(leaf.number)));
  int axis = 0;
  (centers.upper - centers.lower).maxCoeff(&axis);
  for (SplitLeaf<S>& leaf : leaves) leaf.key = finite_center<S>(box_of(leaf.number))[axis];
}

/// Sorts leaves by their keys. This is a total order. So the result does not depend on the standard
/// library.
template <Scalar S>
void sort_by_key(std::span<SplitLeaf<S>> leaves) {
  std::sort(leaves.begin(), leaves.end(), [](const SplitLeaf<S>& a, const SplitLeaf<S>& b) {
    return a.key < b.key || (a.key == b.key && a.number < b.number);
  });
}

/// Orders `leaves` along their longest extent, by the boxes that `box_of(number)` returns.
/// @return Number of leaves of the first child: half of them.
template <Scalar S, typename BoxOf>
[[nodiscard]] std::size_t split_in_halves(std::span<SplitLeaf<S>> leaves, const BoxOf& box_of) {
  key_by_center(leaves, box_of);
  sort_by_key(leaves);
  return leaves.size() / 2;
}

/// Orders `leaves` so that two groups have the least total of surface times number. Tests 16 bins
/// along the longest extent (Wald 2007, "On fast Construction of SAH-based Bounding Volume
/// Hierarchies").
/// @return Number of leaves of the first child, at least 1 and less than all of two or more.
template <Scalar S, typename BoxOf>
[[nodiscard]] std::size_t split_by_surface(std::span<SplitLeaf<S>> leaves, const BoxOf& box_of) {
  key_by_center(leaves, box_of);
  S lowest = infinity<S>;
  S highest = -infinity<S>;
  for (const SplitLeaf<S>& leaf : leaves) {
    lowest = std::min(lowest, leaf.key);
    highest = std::max(highest, leaf.key);
  }
  const S extent = highest - lowest;
  if (!(extent > S(0))) return leaves.size() / 2;

  constexpr int bin_count = 16;
  struct Bin {
    Aabb<S> box;
    std::size_t count = 0;

    void include(const Bin& other) {
      box.include(other.box);
      count += other.count;
    }
    [[nodiscard]] S cost() const { return count > 0 ? S(count) * box.half_area() : S(0); }
  };
  // From here on the key of a leaf is the number of its bin.
  std::array<Bin, bin_count> bins;
  for (SplitLeaf<S>& leaf : leaves) {
    const S place = (leaf.key - lowest) / extent;
    const int bin = std::min(bin_count - 1, static_cast<int>(place * S(bin_count)));
    leaf.key = S(bin);
    bins[static_cast<std::size_t>(bin)].include({finite_part(box_of(leaf.number)), 1});
  }

  std::array<S, bin_count> cost_of_rest{};
  Bin rest;
  for (std::size_t i = bin_count; i-- > 1;) {
    rest.include(bins[i]);
    cost_of_rest[i] = rest.cost();
  }
  // The first and the last bin hold the extreme middles: every cut leaves leaves on both sides.
  Bin first;
  std::size_t cut = 1;
  S least_cost = infinity<S>;
  for (std::size_t i = 1; i < bin_count; ++i) {
    first.include(bins[i - 1]);
    if (first.cost() + cost_of_rest[i] < least_cost) {
      least_cost = first.cost() + cost_of_rest[i];
      cut = i;
    }
  }
  std::size_t begin = 0;
  std::size_t end = leaves.size();
  while (begin < end) {
    if (leaves[begin].key < S(cut)) {
      ++begin;
    } else {
      std::swap(leaves[begin], leaves[--end]);
    }
  }
  return begin;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
