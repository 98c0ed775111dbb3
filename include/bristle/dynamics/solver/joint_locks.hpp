/// @file
/// Which rows may need a motion that joints lock, as far as the joints' graph tells.
///
/// A finger on a slide that is pushed across it gives way nowhere
/// (docs/decisions/0009-locked-contact-directions.md). Most rows are safe from that, wherever their
/// bodies are:
///  - Bodies in different sets of jointed bodies. One of the sets at least is not held by anything
///    immovable. It moves as a whole, and the row with it.
///  - Motors and limits in a set without loops. Their joint can move while all others rest.
/// The rest are tested by numbers.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/core/disjoint_sets.hpp>
#include <bristle/core/dynamic_array.hpp>

#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// The graph of an island's joints. Bodies are numbers below `ground()`, which stands for all that
/// cannot move.
class JointLocks {
 public:
  /// Starts an island of so many movable bodies, without joints.
  void reset(std::size_t bodies) {
    ground_ = static_cast<std::uint32_t>(bodies);
    sets_.reset(bodies + 1);
    closing_.clear();
    has_loop_.assign(bodies + 1, false);
  }
  /// Number of all immovable bodies together.
  [[nodiscard]] std::uint32_t ground() const { return ground_; }

  /// Adds a joint between two bodies.
  void join(std::uint32_t a, std::uint32_t b) {
    if (sets_.find(a) == sets_.find(b)) closing_.push_back(a);
    sets_.join(a, b);
  }
  /// Adds the locked axes of a body. They hold it against the world in part, beside its joints.
  void hold(std::uint32_t body) {
    sets_.join(body, ground_);
    closing_.push_back(body);
  }
  /// Ends the list of joints.
  void finish() {
    for (const std::uint32_t body : closing_) has_loop_[sets_.find(body)] = true;
  }

  /// Returns whether joints may lock a contact between two bodies.
  [[nodiscard]] bool may_lock_contact(std::uint32_t a, std::uint32_t b) {
    return sets_.find(a) == sets_.find(b);
  }
  /// Returns whether other joints may lock the motor or a limit of a joint between two bodies.
  [[nodiscard]] bool may_lock_joint(std::uint32_t a, std::uint32_t b) {
    return sets_.find(a) == sets_.find(b) && has_loop_[sets_.find(a)];
  }

 private:
  std::uint32_t ground_ = 0;
  DisjointSets sets_;
  DynamicArray<std::uint32_t> closing_;  // A body of each loop.
  DynamicArray<bool> has_loop_;          // By set.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
