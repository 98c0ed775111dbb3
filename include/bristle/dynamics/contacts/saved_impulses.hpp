/// @file
/// Copy of an island's impulses, kept while another solution is tried.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <array>
#include <cstddef>

namespace bristle::inline BRISTLE_ABI::detail {

/// Sets all impulses of an island to zero.
template <Scalar S>
void clear_impulses(const Island& island, Constraints<S>& constraints) {
  for (const std::uint32_t i : island.contacts) constraints.contacts[i].impulse = {};
  for_each_row(island, constraints, [](ConstraintRow<S>& row) { row.impulse = S(0); });
  for (const std::uint32_t i : island.soft) set_zero(constraints.soft[i].impulse);
}

/// A copy of the impulses that a solver found. One object serves many islands in turn.
template <Scalar S>
class SavedImpulses {
 public:
  void save(const Island& island, const Constraints<S>& constraints) {
    contacts_.resize(island.contacts.size());
    rows_.clear();
    soft_.clear();
    for (std::size_t k = 0; k < contacts_.size(); ++k) {
      contacts_[k] = constraints.contacts[island.contacts[k]].impulse;
    }
    for_each_row(island, constraints,
                 [&](const ConstraintRow<S>& row) { rows_.push_back(row.impulse); });
    for (const std::uint32_t i : island.soft) {
      soft_.push_back({constraints.soft[i].impulse, constraints.soft[i].motion});
    }
  }

  /// Restores the impulses of the island that was saved.
  void restore(const Island& island, Constraints<S>& constraints) const {
    for (std::size_t k = 0; k < contacts_.size(); ++k) {
      constraints.contacts[island.contacts[k]].impulse = contacts_[k];
    }
    std::size_t r = 0;
    for_each_row(island, constraints, [&](ConstraintRow<S>& row) { row.impulse = rows_[r++]; });
    for (std::size_t k = 0; k < soft_.size(); ++k) {
      constraints.soft[island.soft[k]].impulse = soft_[k].impulse;
      constraints.soft[island.soft[k]].motion = soft_[k].motion;
    }
  }

  /// Moves the impulses towards the saved ones, by a share.
  void blend(S share, const Island& island, Constraints<S>& constraints) const {
    for (std::size_t k = 0; k < contacts_.size(); ++k) {
      auto& impulse = constraints.contacts[island.contacts[k]].impulse;
      for (std::size_t i = 0; i < 3; ++i) impulse[i] += share * (contacts_[k][i] - impulse[i]);
    }
    std::size_t r = 0;
    for_each_row(island, constraints,
                 [&](ConstraintRow<S>& row) { row.impulse += share * (rows_[r++] - row.impulse); });
  }

 private:
  struct Soft {
    Vec6<S> impulse, motion;
  };
  DynamicArray<std::array<S, 3>> contacts_;
  DynamicArray<S> rows_;
  DynamicArray<Soft> soft_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
