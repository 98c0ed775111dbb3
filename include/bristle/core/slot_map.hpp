/// @file
/// Storage with handles that detect when their element is gone.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/core/no_index.hpp>

#include <compare>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// Handle of an element of a `SlotMap`. A default-constructed handle names nothing.
///
/// Ordered by slot, so sorting by handle is the same in every run.
template <typename Tag>
struct Id {
  /// [-] Slot number.
  std::uint32_t index = no_index;
  /// [-] Number of reuses of the slot when this handle was made.
  std::uint32_t generation = 0;

  friend constexpr auto operator<=>(const Id&, const Id&) = default;
  friend constexpr bool operator==(const Id&, const Id&) = default;

  /// Text for messages ("{3, 0}", or "unset").
  [[nodiscard]] friend std::string to_text(const Id& id) {
    if (id == Id{}) return "unset";
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "{%u, %u}", unsigned{id.index}, unsigned{id.generation});
    return buffer;
  }
};

/// Elements in slots that keep their place while they live. Freed slots are reused, last freed
/// first. A handle to a former element is recognised as stale.
///
/// Iterate with `for (const std::uint32_t i : map.live_slots()) use(map.at(i));` The order is that
/// of the slots, so it depends only on the sequence of insertions and erasures.
template <typename T, typename Tag>
class SlotMap {
 public:
  using Handle = Id<Tag>;

  /// Range of the numbers of a map's live slots.
  class LiveSlots {
   public:
    /// Iterator whose value is a slot number.
    class Iterator {
     public:
      Iterator(const SlotMap& map, std::uint32_t slot) : map_(&map), slot_(slot) { skip_free(); }
      std::uint32_t operator*() const noexcept { return slot_; }
      Iterator& operator++() noexcept {
        ++slot_;
        skip_free();
        return *this;
      }
      /// True behind the last slot, wherever that is by then.
      friend bool operator==(const Iterator& it, std::default_sentinel_t) noexcept {
        return it.slot_ >= it.map_->slot_count();
      }

     private:
      void skip_free() noexcept {
        while (slot_ < map_->slot_count() && !map_->slots_[slot_].is_live) ++slot_;
      }

      const SlotMap* map_;
      std::uint32_t slot_;
    };

    explicit LiveSlots(const SlotMap& map) : map_(&map) {}
    [[nodiscard]] Iterator begin() const noexcept { return Iterator(*map_, 0); }
    [[nodiscard]] std::default_sentinel_t end() const noexcept { return {}; }

   private:
    const SlotMap* map_;
  };

  /// Stores an element in the slot freed last, or in a new one.
  Handle insert(T value) {
    std::uint32_t index = 0;
    if (free_.empty()) {
      index = static_cast<std::uint32_t>(slots_.size());
      slots_.push_back(Slot{std::move(value), 0, true});
    } else {
      index = free_.back();
      free_.pop_back();
      slots_[index].value = std::move(value);
      slots_[index].is_live = true;
    }
    ++size_;
    return Handle{index, slots_[index].generation};
  }

  /// Ends the element's life and frees its slot. The handle must be live.
  void erase(Handle id) {
    BRISTLE_ASSERT(contains(id));
    Slot& slot = slots_[id.index];
    slot.value = T{};
    slot.is_live = false;
    ++slot.generation;
    free_.push_back(id.index);
    --size_;
  }

  /// Returns whether the handle names an element that still exists.
  [[nodiscard]] bool contains(Handle id) const noexcept {
    return id.index < slots_.size() && slots_[id.index].is_live &&
           slots_[id.index].generation == id.generation;
  }

  /// The element of a handle.
  /// @throws InvalidArgument{field} if the handle is stale or was never made.
  [[nodiscard]] T& get(Handle id, std::string_view field) {
    check(id, field);
    return slots_[id.index].value;
  }
  [[nodiscard]] const T& get(Handle id, std::string_view field) const {
    check(id, field);
    return slots_[id.index].value;
  }

  /// The element in a live slot.
  [[nodiscard]] T& at(std::uint32_t index) noexcept {
    BRISTLE_ASSERT(is_live(index));
    return slots_[index].value;
  }
  [[nodiscard]] const T& at(std::uint32_t index) const noexcept {
    BRISTLE_ASSERT(is_live(index));
    return slots_[index].value;
  }

  /// Returns whether a slot holds an element.
  [[nodiscard]] bool is_live(std::uint32_t index) const noexcept {
    return index < slots_.size() && slots_[index].is_live;
  }
  /// Handle of the element in a live slot.
  [[nodiscard]] Handle handle(std::uint32_t index) const noexcept {
    return Handle{index, slots_[index].generation};
  }
  /// Number of live elements.
  [[nodiscard]] std::uint32_t size() const noexcept { return size_; }
  /// Number of slots, live or free: the length of a list with an entry for each slot.
  [[nodiscard]] std::uint32_t slot_count() const noexcept {
    return static_cast<std::uint32_t>(slots_.size());
  }
  /// Numbers of the live slots, ascending. The loop over them may erase the element it is at.
  [[nodiscard]] LiveSlots live_slots() const noexcept { return LiveSlots(*this); }

 private:
  struct Slot {
    T value{};
    std::uint32_t generation = 0;
    bool is_live = false;
  };

  void check(Handle id, std::string_view field) const {
    detail::require(contains(id), field, id,
                    "must name something that exists (unknown or removed handle)");
  }

  DynamicArray<Slot> slots_;
  DynamicArray<std::uint32_t> free_;
  std::uint32_t size_ = 0;
};

}  // namespace detail

}  // namespace bristle::inline BRISTLE_ABI

/// Handles are keys of unordered containers.
template <typename Tag>
struct std::hash<bristle::detail::Id<Tag>> {
  [[nodiscard]] std::size_t operator()(const bristle::detail::Id<Tag>& id) const noexcept {
    // Maps ids one to one to 64 bits. Every bit reaches the lowest ones, by which tables of a power
    // of two choose. Slots are consecutive. Generations are mostly 0.
    const std::uint64_t bits =
        (std::uint64_t{id.generation} << 32 | id.index) * 0x9e3779b97f4a7c15u;
    return static_cast<std::size_t>(bits ^ bits >> 32);
  }
};
