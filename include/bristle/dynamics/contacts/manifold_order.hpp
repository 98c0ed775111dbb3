/// @file
/// Order of manifolds. Some of them may be solved side by side.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/core/dynamic_array.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// The contacts of one manifold, and its two bodies.
struct ManifoldSpan {
  /// [-] First contact, by its number in the island. Number of contacts.
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  /// [-] Slots of the bodies; true if impulses move them.
  std::uint32_t body_a = 0;
  std::uint32_t body_b = 0;
  bool moves_a = false;
  bool moves_b = false;
};

/// Sorts manifolds into rounds. Manifolds of a round have no moving body in common. One that shares
/// a moving body with an earlier manifold is in a later round. So sweeps over the rounds, there or
/// back, equal sweeps over the list to the last bit. The number of manifolds solved at once does
/// not matter.
class ManifoldOrder {
 public:
  struct Place {
    std::uint32_t round = 0;
    /// [-] Number of contacts. Within a round, manifolds with as many are adjacent. Those with most
    /// come first.
    std::uint32_t count = 0;
    std::uint32_t manifold = 0;
  };

  /// @param slots  [-] Number of bodies.
  void build(const DynamicArray<ManifoldSpan>& manifolds, std::size_t slots) {
    found_.clear();
    next_round_.resize(std::max(next_round_.size(), slots), 0);
    std::uint32_t rounds = 0;
    std::uint32_t most = 0;
    for (std::uint32_t k = 0; k < manifolds.size(); ++k) {
      const ManifoldSpan& m = manifolds[k];
      std::uint32_t round = 0;
      if (m.moves_a) round = std::max(round, next_round_[m.body_a]);
      if (m.moves_b) round = std::max(round, next_round_[m.body_b]);
      if (m.moves_a) next_round_[m.body_a] = round + 1;
      if (m.moves_b) next_round_[m.body_b] = round + 1;
      found_.push_back({round, m.count, k});
      rounds = std::max(rounds, round + 1);
      most = std::max(most, m.count);
    }
    for (const ManifoldSpan& m : manifolds) next_round_[m.body_a] = next_round_[m.body_b] = 0;
    sort_by_counting(rounds, most);
  }

  [[nodiscard]] const DynamicArray<Place>& places() const { return places_; }

 private:
  /// Fills `places_`. Many manifolds share a round and a number of contacts. So counting sort is
  /// cheap.
  void sort_by_counting(std::uint32_t rounds, std::uint32_t most) {
    const auto kind = [most](const Place& p) {
      return std::size_t(p.round) * (most + 1) + (most - p.count);
    };
    next_of_kind_.assign(std::size_t(rounds) * (most + 1) + 1, 0);
    for (const Place& p : found_) ++next_of_kind_[kind(p) + 1];
    for (std::size_t k = 1; k < next_of_kind_.size(); ++k) next_of_kind_[k] += next_of_kind_[k - 1];
    places_.resize(found_.size());
    for (const Place& p : found_) places_[next_of_kind_[kind(p)]++] = p;
  }

  DynamicArray<Place> found_, places_;  // As found, and in order.
  DynamicArray<std::uint32_t> next_of_kind_;
  DynamicArray<std::uint32_t> next_round_;  // By slot; 0 between two calls.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
