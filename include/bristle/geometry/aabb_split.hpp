/// @file
/// How a set of boxes is divided between the two children of a tree node.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/aabb.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// [m] So large that no scene reaches it, and so small that sums of areas of such boxes are finite.
template <Scalar S>
inline const S tree_extent_limit = [] {
  using std::sqrt;
  return sqrt(std::numeric_limits<S>::max()) / S(65536);
}();

/// The box cut to a size that can be computed with, so that infinite boxes can be compared.
template <Scalar S>
[[nodiscard]] Aabb<S> finite_part(const Aabb<S>& box) {
  const S limit = tree_extent_limit<S>;
  return {box.lower.cwiseMax(-limit).cwiseMin(limit), box.upper.cwiseMax(-limit).cwiseMin(limit)};
}

/// Middle of a box, finite even where the box is not.
template <Scalar S>
[[nodiscard]] Vec3<S> finite_center(const Aabb<S>& box) {
  return finite_part(box).center();
}

/// Box around the middles of some boxes; the axis of its longest edge is the one to split along.
template <Scalar S, typename BoxOf>
[[nodiscard]] Aabb<S> box_of_centers(std::span<const std::uint32_t> leaves, const BoxOf& box_of) {
  Aabb<S> centers;
  for (const std::uint32_t leaf : leaves) centers.include(finite_center<S>(box_of(leaf)));
  return centers;
}

/// Orders `leaves` along their longest extent, by the boxes that `box_of(leaf)` returns.
/// @return How many go to the first child: half of them.
template <Scalar S, typename BoxOf>
[[nodiscard]] std::size_t split_in_halves(std::span<std::uint32_t> leaves, const BoxOf& box_of) {
  const Aabb<S> centers = box_of_centers<S>(leaves, box_of);
  int axis = 0;
  (centers.upper - centers.lower).maxCoeff(&axis);
  // A total order, so that the result does not depend on the standard library.
  std::sort(leaves.begin(), leaves.end(), [&](std::uint32_t a, std::uint32_t b) {
    const S center_a = finite_center<S>(box_of(a))[axis];
    const S center_b = finite_center<S>(box_of(b))[axis];
    return center_a < center_b || (center_a == center_b && a < b);
  });
  return leaves.size() / 2;
}

/// Orders `leaves` so that two groups have least total surface times number, over 16 bins along the
/// longest extent (Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies").
/// @return How many go to the first child, at least 1 and less than all of two or more.
template <Scalar S, typename BoxOf>
[[nodiscard]] std::size_t split_by_surface(std::span<std::uint32_t> leaves, const BoxOf& box_of) {
  const Aabb<S> centers = box_of_centers<S>(leaves, box_of);
  int axis = 0;
  const S extent = (centers.upper - centers.lower).maxCoeff(&axis);
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
  const auto bin_of = [&](std::uint32_t leaf) {
    const S place = (finite_center<S>(box_of(leaf))[axis] - centers.lower[axis]) / extent;
    return static_cast<std::size_t>(
        std::min(bin_count - 1, static_cast<int>(place * S(bin_count))));
  };
  std::array<Bin, bin_count> bins;
  for (const std::uint32_t leaf : leaves)
    bins[bin_of(leaf)].include({finite_part(box_of(leaf)), 1});

  std::array<S, bin_count> cost_of_rest{};
  Bin rest;
  for (std::size_t i = bin_count; i-- > 1;) {
    rest.include(bins[i]);
    cost_of_rest[i] = rest.cost();
  }
  // The first and the last bin hold the extreme middles: every cut leaves something on both sides.
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
    if (bin_of(leaves[begin]) < cut) {
      ++begin;
    } else {
      std::swap(leaves[begin], leaves[--end]);
    }
  }
  return begin;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
