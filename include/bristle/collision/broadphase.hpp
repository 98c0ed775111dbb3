/// @file
/// Broad phase: a tree of fat AABBs, and a list of unbounded shapes beside it.
///
/// AABBs are fat so that they seldom change. Overlaps between them are remembered. A step queries
/// the tree only for shapes that left their fat AABB.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/collision_constants.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/geometry/trees/aabb_tree.hpp>
#include <bristle/math/finite.hpp>

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Two shapes that may touch, by their tags, a < b.
struct ShapePair {
  std::uint32_t a = 0;
  std::uint32_t b = 0;

  friend constexpr auto operator<=>(const ShapePair&, const ShapePair&) = default;
  friend constexpr bool operator==(const ShapePair&, const ShapePair&) = default;
};

/// Boxes of all shapes of a world. Tags are small numbers that the caller assigns and reuses.
template <Scalar S>
class BroadPhase {
 public:
  /// Adds a shape with its box in the world. Infinite boxes are kept in a list of their own.
  void insert(std::uint32_t tag, const Aabb<S>& box) {
    if (entries_.size() <= tag) entries_.resize(tag + 1);
    mark_dirty(tag);
    Entry& entry = entries_[tag];
    entry.swept = box;
    if (is_bounded(box)) {
      entry.node = tree_.insert(box, tag);
    } else {
      unbounded_.insert(std::lower_bound(unbounded_.begin(), unbounded_.end(), tag), tag);
    }
  }

  /// Removes a shape; its tag may be reused.
  void remove(std::uint32_t tag) {
    mark_dirty(tag);
    Entry& entry = entries_[tag];
    if (entry.node != detail::no_index) {
      tree_.remove(entry.node);
    } else {
      unbounded_.erase(std::lower_bound(unbounded_.begin(), unbounded_.end(), tag));
    }
    entry = Entry{};
    entry.is_dirty = true;
  }

  /// Sets the swept box of a shape for the step. The tree keeps a fat AABB. So slow shapes do not
  /// change it every step.
  /// @param reach   [m] Swept margin by which the box grew around the shape.
  /// @param center  [m] Point that is tracked, and about which the shape turns.
  void move(std::uint32_t tag, const Aabb<S>& swept, S reach, const Vec3<S>& center) {
    Entry& entry = entries_[tag];
    entry.swept = swept;
    entry.is_loose = false;
    if (entry.node == detail::no_index) return;
    fit_tree(entry, tag, center - entry.center, reach);
    entry.center = center;
    entry.is_tracked = true;
    const Aabb<S>& box = tree_.box(entry.node);
    const Vec3<S> margin = filled<Vec3<S>>(reach);
    entry.margin_box = {center - ((swept.lower - box.lower) + margin),
                        center + ((box.upper - swept.upper) + margin)};
    entry.turned = S(0);
  }
  /// The same for a shape that is not tracked.
  void move(std::uint32_t tag, const Aabb<S>& swept) {
    move(tag, swept, S(0), swept.center());
    entries_[tag].is_tracked = false;
  }

  /// Returns whether a shape overlaps no other shape and stays in its fat AABB while its points
  /// move by `reach` [m]. Then it needs no exact swept box: the whole fat AABB counts as swept.
  [[nodiscard]] bool stays(std::uint32_t tag, S reach, const Vec3<S>& center) {
    Entry& entry = entries_[tag];
    if (!entry.is_tracked || has_overlaps(entry) || !is_within(entry, center, reach)) return false;
    if (!entry.is_loose) entry.swept = tree_.box(entry.node);
    entry.is_loose = true;
    return true;
  }
  /// Returns whether `swept` is the fat AABB in this step.
  [[nodiscard]] bool is_loose(std::uint32_t tag) const { return entries_[tag].is_loose; }
  /// Sets an exact swept box after all. It stays exact in the next steps.
  void refine(std::uint32_t tag, const Aabb<S>& swept) {
    Entry& entry = entries_[tag];
    entry.swept = swept;
    entry.is_loose = false;
    entry.is_needed = true;
  }

  /// Records the position of a shape after the step.
  /// @param shift, turn  [m] Motion of its centre. Largest motion of other points about it.
  /// @return True if its swept box is known to hold it still.
  [[nodiscard]] bool settle(std::uint32_t tag, const Vec3<S>& center, S shift, S turn, S reach) {
    Entry& entry = entries_[tag];
    entry.turned += turn;
    return entry.is_loose ? is_within(entry, center, S(0)) : shift + turn <= reach;
  }

  /// The swept box of a shape.
  [[nodiscard]] const Aabb<S>& swept(std::uint32_t tag) const { return entries_[tag].swept; }

  /// Calls visit(tag) -> bool for every shape whose swept box overlaps `box`. Ends when it returns
  /// false. Unbounded shapes come last, in order of their tags.
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

  /// Calls visit(tag) -> bool for every shape whose box in the tree accept(box) -> bool takes. It
  /// is asked again, box by box, so that it may take less as visits go on. Ends when a visit
  /// returns false. Unbounded shapes come last, in order of their tags.
  template <typename Accept, typename Visit>
  void find(Accept&& accept, Visit&& visit) const {
    bool goes_on = true;
    tree_.find(accept, [&](std::uint32_t tag) { return goes_on = visit(tag); });
    for (std::size_t i = 0; goes_on && i < unbounded_.size(); ++i) goes_on = visit(unbounded_[i]);
  }

  /// Appends to `out` every overlapping pair with a shape in `moving`. The other shape is any that
  /// `accept(a, b)` accepts. Pairs have a < b, are sorted, and come once each.
  /// @param[in,out] tested  Number of overlapping pairs, accepted or not.
  template <typename Accept>
  void find_pairs(const DynamicArray<std::uint32_t>& moving, Accept&& accept,
                  DynamicArray<ShapePair>& out, std::uint64_t& tested) {
    for (const std::uint32_t tag : moving) {
      entries_[tag].is_moving = true;
      if (!entries_[tag].has_moved) mark_dirty(tag);
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
        // Other moving, bounded shapes meet this one through `unbounded_`. Two unbounded shapes
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

  /// Calls visit(tag, max_distance) -> new max_distance for shapes that the ray may meet. Unbounded
  /// shapes come first, then nearer boxes before farther ones.
  template <typename Visit>
  void walk_ray(Ray<S> ray, Visit&& visit) const {
    for (const std::uint32_t tag : unbounded_) ray.length = visit(tag, ray.length);
    tree_.walk_ray(ray, visit);
  }

 private:
  struct Entry {
    typename AabbTree<S>::NodeId node = detail::no_index;
    Aabb<S> swept{};
    /// [m] Centre at the last `move`. Box of all centres at which the shape stays in its fat AABB.
    Vec3<S> center = zero<Vec3<S>>();
    Aabb<S> margin_box{};
    /// [m] Largest motion of its points about the centre since then.
    S turned = S(0);
    /// True if `center` is tracked.
    bool is_tracked = false;
    /// Last refresh in which `near_` named it.
    std::uint64_t met_at = 0;
    /// True if its exact swept box was needed since its fat AABB changed.
    bool is_needed = false;
    /// True if `swept` is its fat AABB.
    bool is_loose = false;
    /// True if its fat AABB changed since `near_` was made.
    bool is_dirty = false;
    /// True once it was in `moving`. Shapes that never were do not meet each other.
    bool has_moved = false;
    /// Scratch of `find_pairs`.
    bool is_moving = false;
  };

  [[nodiscard]] static bool is_bounded(const Aabb<S>& box) {
    const Vec3<S> largest = filled<Vec3<S>>(largest_number<S>);
    return all_at_most(box.upper, largest) && all_at_most(-largest, box.lower);
  }

  [[nodiscard]] static ShapePair ordered(std::uint32_t a, std::uint32_t b) {
    return {std::min(a, b), std::max(a, b)};
  }
  [[nodiscard]] bool is_in_tree(std::uint32_t tag) const {
    return entries_[tag].node != detail::no_index;
  }

  /// Returns whether a shape with its centre at `center`, grown by `margin` [m], lies in its fat
  /// AABB.
  [[nodiscard]] static bool is_within(const Entry& entry, const Vec3<S>& center, S margin) {
    const Vec3<S> extra = filled<Vec3<S>>(margin + entry.turned);
    return entry.margin_box.contains(Aabb<S>{center - extra, center + extra});
  }

  /// Returns whether a shape overlaps others or needs an exact swept box. It may be true where that
  /// is not known.
  [[nodiscard]] bool has_overlaps(const Entry& entry) const {
    return entry.is_dirty || entry.is_needed || entry.met_at == refreshes_;
  }

  void mark_dirty(std::uint32_t tag) {
    if (entries_[tag].is_dirty) return;
    entries_[tag].is_dirty = true;
    dirty_.push_back(tag);
  }

  /// Replaces the fat AABB where it does not hold the swept box. Also replaces it if it is far too
  /// large.
  /// @param shift  [m] Motion of the shape since the last `move`, some steps ago.
  void fit_tree(Entry& entry, std::uint32_t tag, Vec3<S> shift, S reach) {
    const Aabb<S>& swept = entry.swept;
    // The fat AABB covers some steps in the direction of motion. A box left over from a faster step
    // shrinks again.
    const S size = swept.half_extents().maxCoeff();
    const S surplus = S(chosen::fat_box_margin) * size;
    const Aabb<S>& box = tree_.box(entry.node);
    const Vec3<S> spare = (box.upper - box.lower) - (swept.upper - swept.lower);
    const bool fits = box.contains(swept);
    if (fits && spare.maxCoeff() <= S(chosen::fat_box_surplus) * surplus) return;
    const S distance = shift.norm();
    if (distance > reach) shift *= reach / distance;
    Vec3<S> ahead =
        cwise_clamp(S(chosen::fat_box_steps) * shift, S(chosen::fat_box_stretch) * size);
    // The motion of a body too fast for its square is not finite.
    if (!all_finite(ahead)) set_zero(ahead);
    if (fits && (spare - cwise_abs(ahead)).maxCoeff() <= S(chosen::fat_box_surplus) * surplus)
      return;
    Aabb<S> grown = swept.inflated(surplus);
    grown.lower += cwise_min(ahead, zero<Vec3<S>>());
    grown.upper += cwise_max(ahead, zero<Vec3<S>>());
    tree_.update(entry.node, grown);
    entry.is_needed = false;
    mark_dirty(tag);
  }

  /// Finds the overlaps of fat AABBs that changed since the last call.
  void refresh_near() {
    if (dirty_.empty()) return;
    found_.clear();
    for (const ShapePair& pair : near_) {
      if (!entries_[pair.a].is_dirty && !entries_[pair.b].is_dirty) found_.push_back(pair);
    }
    const std::size_t kept = found_.size();
    for (const std::uint32_t tag : dirty_) {
      if (!is_in_tree(tag)) continue;
      tree_.overlap(tree_.box(entries_[tag].node), [&](std::uint32_t other) {
        const bool is_found_from_other = entries_[other].is_dirty && other < tag;
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
    for (const std::uint32_t tag : dirty_) entries_[tag].is_dirty = false;
    dirty_.clear();
  }

  /// Appends `found_` to `out` in order. Its first `sorted` pairs are sorted already.
  void append_sorted(std::size_t sorted, DynamicArray<ShapePair>& out) {
    const auto middle = found_.begin() + static_cast<std::ptrdiff_t>(sorted);
    if (!std::is_sorted(middle, found_.end())) std::sort(middle, found_.end());
    const std::size_t before = out.size();
    out.resize(before + found_.size());
    std::merge(found_.begin(), middle, middle, found_.end(),
               out.begin() + static_cast<std::ptrdiff_t>(before));
  }

  AabbTree<S> tree_;
  DynamicArray<Entry> entries_;
  DynamicArray<std::uint32_t> unbounded_;
  /// Pairs of bounded shapes whose fat AABBs overlap, sorted. One of the two moves, or did.
  DynamicArray<ShapePair> near_;
  std::uint64_t refreshes_ = 0;
  /// Shapes whose fat AABBs changed since `near_` was made.
  DynamicArray<std::uint32_t> dirty_;
  /// Scratch.
  DynamicArray<ShapePair> found_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
