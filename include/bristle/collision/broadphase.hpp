/// @file
/// Which shapes may touch: a tree of grown boxes, and a list of shapes without bounds beside it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/aabb_tree.hpp>

#include <algorithm>
#include <compare>
#include <cstdint>
#include <vector>

namespace bristle {

/// Two shapes that may touch, by their tags, a < b.
struct ShapePair {
  std::uint32_t a = 0;
  std::uint32_t b = 0;

  friend constexpr auto operator<=>(const ShapePair&, const ShapePair&) = default;
  friend constexpr bool operator==(const ShapePair&, const ShapePair&) = default;
};

/// Boxes of all shapes of a world. Tags are small numbers that the caller gives out and reuses.
template <Scalar S>
class BroadPhase {
 public:
  /// Adds a shape with its box in the world; an infinite box is kept in a list of its own.
  void insert(std::uint32_t tag, const Aabb<S>& box) {
    if (entries_.size() <= tag) entries_.resize(tag + 1);
    Entry& entry = entries_[tag];
    entry = Entry{};
    entry.swept = box;
    if (is_bounded(box)) {
      entry.node = tree_.insert(box, tag);
    } else {
      unbounded_.insert(std::lower_bound(unbounded_.begin(), unbounded_.end(), tag), tag);
    }
  }

  void remove(std::uint32_t tag) {
    Entry& entry = entries_[tag];
    if (entry.node != AabbTree<S>::null) {
      tree_.remove(entry.node);
    } else {
      unbounded_.erase(std::lower_bound(unbounded_.begin(), unbounded_.end(), tag));
    }
    entry = Entry{};
  }

  /// Sets the box that a shape may reach during the step. The tree keeps a larger one, so that slow
  /// shapes do not change it every step.
  void move(std::uint32_t tag, const Aabb<S>& swept) {
    Entry& entry = entries_[tag];
    entry.swept = swept;
    if (entry.node == AabbTree<S>::null) return;
    // A surplus of a tenth of the size: a shape then changes the tree once in the time it takes to
    // move by a tenth of itself, and the surplus costs few false pairs. A box left over from a fast
    // step shrinks again once it is several times too large.
    const S surplus = S(0.2) * swept.half_extents().maxCoeff();
    const Aabb<S>& box = tree_.box(entry.node);
    if (box.contains(swept) && swept.inflated(S(5) * surplus).contains(box)) return;
    tree_.update(entry.node, swept.inflated(surplus));
  }

  /// The box a shape was last given.
  [[nodiscard]] const Aabb<S>& swept(std::uint32_t tag) const { return entries_[tag].swept; }

  /// Calls visit(tag) -> bool for every shape whose swept box overlaps `box`, until it returns
  /// false; unbounded shapes come last, in order of their tags.
  template <typename Visit>
  void overlap(const Aabb<S>& box, Visit&& visit) const {
    bool goes_on = true;
    tree_.overlap(box, [&](std::uint32_t tag) {
      if (!entries_[tag].swept.overlaps(box)) return true;
      goes_on = visit(tag);
      return goes_on;
    });
    for (std::size_t i = 0; goes_on && i < unbounded_.size(); ++i) goes_on = visit(unbounded_[i]);
  }

  /// Appends to `out` every pair of a shape in `moving` with any other that overlaps it and that
  /// `accept(tag, other)` lets through, sorted, each once.
  /// @param[in,out] tested  Number of pairs of overlapping boxes, accepted or not.
  template <typename Accept>
  void find_pairs(const std::vector<std::uint32_t>& moving, Accept&& accept,
                  std::vector<ShapePair>& out, std::uint64_t& tested) const {
    const std::size_t first = out.size();
    for (const std::uint32_t tag : moving) {
      overlap(entries_[tag].swept, [&](std::uint32_t other) {
        if (other == tag) return true;
        ++tested;
        if (accept(tag, other)) out.push_back({std::min(tag, other), std::max(tag, other)});
        return true;
      });
    }
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end());
    out.erase(std::unique(out.begin() + static_cast<std::ptrdiff_t>(first), out.end()), out.end());
  }

  /// Calls visit(tag, max_distance) -> new max_distance for shapes that the ray may meet, nearer
  /// boxes first, unbounded shapes before all.
  template <typename Visit>
  void walk_ray(Ray<S> ray, Visit&& visit) const {
    for (const std::uint32_t tag : unbounded_) ray.length = visit(tag, ray.length);
    tree_.walk_ray(ray, visit);
  }

 private:
  struct Entry {
    typename AabbTree<S>::NodeId node = AabbTree<S>::null;
    Aabb<S> swept{};
  };

  [[nodiscard]] static bool is_bounded(const Aabb<S>& box) {
    return (box.upper.array() < infinity<S>).all() && (box.lower.array() > -infinity<S>).all();
  }

  AabbTree<S> tree_;
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> unbounded_;
};

}  // namespace bristle
