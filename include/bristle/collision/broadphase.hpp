/// @file
/// Which shapes may touch: a tree of grown boxes, and a list of shapes without bounds beside it.
///
/// Boxes are grown so that they seldom change, and which of them overlap is remembered: a step
/// looks into the tree only for shapes that left their box.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/trees/aabb_tree.hpp>
#include <bristle/math/finite.hpp>

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

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
    mark_stale(tag);
    Entry& entry = entries_[tag];
    entry.swept = box;
    if (is_bounded(box)) {
      entry.node = tree_.insert(box, tag);
    } else {
      unbounded_.insert(std::lower_bound(unbounded_.begin(), unbounded_.end(), tag), tag);
    }
  }

  void remove(std::uint32_t tag) {
    mark_stale(tag);
    Entry& entry = entries_[tag];
    if (entry.node != AabbTree<S>::null) {
      tree_.remove(entry.node);
    } else {
      unbounded_.erase(std::lower_bound(unbounded_.begin(), unbounded_.end(), tag));
    }
    entry = Entry{};
    entry.is_stale = true;
  }

  /// Sets the box that a shape may reach during the step. The tree keeps a larger one, so that slow
  /// shapes do not change it every step.
  /// @param reach   [m] By how much it was grown around the shape for the step.
  /// @param center  [m] Point from which the shape is followed, and about which it turns.
  void move(std::uint32_t tag, const Aabb<S>& swept, S reach, const Vec3<S>& center) {
    Entry& entry = entries_[tag];
    entry.swept = swept;
    entry.is_coarse = false;
    if (entry.node == AabbTree<S>::null) return;
    fit_tree(entry, tag, center - entry.center, reach);
    entry.center = center;
    entry.is_followed = true;
    const Aabb<S>& box = tree_.box(entry.node);
    const Vec3<S> margin = Vec3<S>::Constant(reach);
    entry.room = {center - ((swept.lower - box.lower) + margin),
                  center + ((box.upper - swept.upper) + margin)};
    entry.turned = S(0);
  }
  /// The same for a shape that is not followed.
  void move(std::uint32_t tag, const Aabb<S>& swept) {
    move(tag, swept, S(0), swept.center());
    entries_[tag].is_followed = false;
  }

  /// Whether a shape is alone in its box in the tree, and stays there while its points move by
  /// `reach` [m]: nothing more needs to be known of it then, and all of that box counts as swept.
  [[nodiscard]] bool stays(std::uint32_t tag, S reach, const Vec3<S>& center) {
    Entry& entry = entries_[tag];
    if (!entry.is_followed || has_company(entry) || !is_within(entry, center, reach)) return false;
    if (!entry.is_coarse) entry.swept = tree_.box(entry.node);
    entry.is_coarse = true;
    return true;
  }
  /// Whether that is so in this step.
  [[nodiscard]] bool is_coarse(std::uint32_t tag) const { return entries_[tag].is_coarse; }
  /// Sets the swept box after all, which will be needed again in the steps to come.
  void refine(std::uint32_t tag, const Aabb<S>& swept) {
    Entry& entry = entries_[tag];
    entry.swept = swept;
    entry.is_coarse = false;
    entry.is_needed = true;
  }

  /// Notes where a shape is after the step.
  /// @param shift, turn  [m] By how much its centre has moved, and other points about it at most.
  /// @return Whether its swept box holds it still, as far as that is known.
  [[nodiscard]] bool settle(std::uint32_t tag, const Vec3<S>& center, S shift, S turn, S reach) {
    Entry& entry = entries_[tag];
    entry.turned += turn;
    return entry.is_coarse ? is_within(entry, center, S(0)) : shift + turn <= reach;
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
  /// `accept(a, b)` lets through, a < b, sorted, each once.
  /// @param[in,out] tested  Number of pairs of overlapping boxes, accepted or not.
  template <typename Accept>
  void find_pairs(const std::vector<std::uint32_t>& moving, Accept&& accept,
                  std::vector<ShapePair>& out, std::uint64_t& tested) {
    for (const std::uint32_t tag : moving) {
      entries_[tag].is_moving = true;
      if (!entries_[tag].has_moved) mark_stale(tag);
      entries_[tag].has_moved = true;
    }
    refresh_near();
    found_.clear();
    const auto offer = [&](const ShapePair& pair) {
      ++tested;
      if (accept(pair.a, pair.b)) found_.push_back(pair);
    };
    for (const ShapePair& pair : near_) {
      const Entry& a = entries_[pair.a];
      const Entry& b = entries_[pair.b];
      if ((a.is_moving || b.is_moving) && a.swept.overlaps(b.swept)) offer(pair);
    }
    const std::size_t bounded = found_.size();
    for (const std::uint32_t tag : moving) {
      const auto offer_with = [&](std::uint32_t other) {
        // What else moves and is bounded meets this one as one of `unbounded_`; two unbounded ones
        // meet once.
        const bool meets_later = entries_[other].is_moving && (is_in_tree(other) || other < tag);
        if (other != tag && !meets_later) offer(ordered(tag, other));
        return true;
      };
      if (is_in_tree(tag)) {
        for (const std::uint32_t other : unbounded_) offer(ordered(tag, other));
      } else {
        overlap(entries_[tag].swept, offer_with);
      }
    }
    append_sorted(bounded, out);
    for (const std::uint32_t tag : moving) entries_[tag].is_moving = false;
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
    /// [m] Where it was when its box was last given, and where its centre may be without the shape
    /// leaving its box in the tree.
    Vec3<S> center = Vec3<S>::Zero();
    Aabb<S> room{};
    /// [m] By how much it has turned about its centre since then.
    S turned = S(0);
    /// Whether that is known.
    bool is_followed = false;
    /// When `near_` last named it.
    std::uint64_t met_at = 0;
    /// Whether its swept box was of use since its box in the tree changed.
    bool is_needed = false;
    /// Whether `swept` is its box in the tree.
    bool is_coarse = false;
    /// Whether the box in the tree is another than `near_` knows.
    bool is_stale = false;
    /// Whether it has ever been named as moving; those that never were do not meet each other.
    bool has_moved = false;
    /// Scratch of `find_pairs`.
    bool is_moving = false;
  };

  [[nodiscard]] static bool is_bounded(const Aabb<S>& box) {
    return (box.upper.array() < infinity<S>).all() && (box.lower.array() > -infinity<S>).all();
  }

  [[nodiscard]] static ShapePair ordered(std::uint32_t a, std::uint32_t b) {
    return {std::min(a, b), std::max(a, b)};
  }
  [[nodiscard]] bool is_in_tree(std::uint32_t tag) const {
    return entries_[tag].node != AabbTree<S>::null;
  }

  /// Whether a shape with its centre at a place, grown by a margin, lies within its box in the
  /// tree.
  [[nodiscard]] static bool is_within(const Entry& entry, const Vec3<S>& center, S margin) {
    const Vec3<S> extra = Vec3<S>::Constant(margin + entry.turned);
    return entry.room.contains(Aabb<S>{center - extra, center + extra});
  }

  /// Whether what a shape reaches matters to others, or may.
  [[nodiscard]] bool has_company(const Entry& entry) const {
    return entry.is_stale || entry.is_needed || entry.met_at == refreshes_;
  }

  void mark_stale(std::uint32_t tag) {
    if (entries_[tag].is_stale) return;
    entries_[tag].is_stale = true;
    stale_.push_back(tag);
  }

  /// Changes the box in the tree where it does not hold the swept one, or is far too large for it.
  /// @param shift  [m] By how much the shape has moved since the last time, some steps ago.
  void fit_tree(Entry& entry, std::uint32_t tag, Vec3<S> shift, S reach) {
    const Aabb<S>& swept = entry.swept;
    // A surplus of a tenth of the size, and where the shape is going as much as thirty steps take,
    // but not more than twice its size: a change of the tree costs as much as hundreds of false
    // pairs. A box left over from a faster step shrinks again once it is several times too large.
    const S size = swept.half_extents().maxCoeff();
    const S surplus = S(0.2) * size;
    const Aabb<S>& box = tree_.box(entry.node);
    const Vec3<S> spare = (box.upper - box.lower) - (swept.upper - swept.lower);
    const bool fits = box.contains(swept);
    if (fits && spare.maxCoeff() <= S(8) * surplus) return;
    const S distance = shift.norm();
    if (distance > reach) shift *= reach / distance;
    Vec3<S> ahead = (S(30) * shift)
                        .cwiseMin(Vec3<S>::Constant(S(4) * size))
                        .cwiseMax(Vec3<S>::Constant(S(-4) * size));
    // What is too fast for its square reaches everywhere, which has no centre.
    if (!all_finite(ahead)) ahead.setZero();
    if (fits && (spare - ahead.cwiseAbs()).maxCoeff() <= S(8) * surplus) return;
    Aabb<S> grown = swept.inflated(surplus);
    grown.lower += ahead.cwiseMin(Vec3<S>::Zero());
    grown.upper += ahead.cwiseMax(Vec3<S>::Zero());
    tree_.update(entry.node, grown);
    entry.is_needed = false;
    mark_stale(tag);
  }

  /// Looks up in the tree what the boxes overlap that changed since the last time.
  void refresh_near() {
    if (stale_.empty()) return;
    found_.clear();
    for (const ShapePair& pair : near_) {
      if (!entries_[pair.a].is_stale && !entries_[pair.b].is_stale) found_.push_back(pair);
    }
    const std::size_t kept = found_.size();
    for (const std::uint32_t tag : stale_) {
      if (!is_in_tree(tag)) continue;
      tree_.overlap(tree_.box(entries_[tag].node), [&](std::uint32_t other) {
        const bool is_found_from_other = entries_[other].is_stale && other < tag;
        const bool may_move = entries_[tag].has_moved || entries_[other].has_moved;
        if (other != tag && !is_found_from_other && may_move) {
          found_.push_back(ordered(tag, other));
        }
        return true;
      });
    }
    near_.clear();
    append_sorted(kept, near_);
    ++refreshes_;
    for (const ShapePair& pair : near_) {
      entries_[pair.a].met_at = entries_[pair.b].met_at = refreshes_;
    }
    for (const std::uint32_t tag : stale_) entries_[tag].is_stale = false;
    stale_.clear();
  }

  /// Appends `found_` to `out` in order. Most of it is: the first `sorted` pairs.
  void append_sorted(std::size_t sorted, std::vector<ShapePair>& out) {
    const auto middle = found_.begin() + static_cast<std::ptrdiff_t>(sorted);
    if (!std::is_sorted(middle, found_.end())) std::sort(middle, found_.end());
    const std::size_t before = out.size();
    out.resize(before + found_.size());
    std::merge(found_.begin(), middle, middle, found_.end(),
               out.begin() + static_cast<std::ptrdiff_t>(before));
  }

  AabbTree<S> tree_;
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> unbounded_;
  /// Pairs of bounded shapes whose boxes in the tree overlap and one of which moves, or did,
  /// sorted.
  std::vector<ShapePair> near_;
  std::uint64_t refreshes_ = 0;
  /// Shapes whose boxes in the tree are not those that `near_` was made from.
  std::vector<std::uint32_t> stale_;
  /// Scratch.
  std::vector<ShapePair> found_;
};

}  // namespace bristle::inline BRISTLE_ABI
