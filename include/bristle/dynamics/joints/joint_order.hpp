/// @file
/// Couplings between the joints of a mechanism. Their order keeps the matrix narrow.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/dynamics/dynamics_constants.hpp>
#include <bristle/dynamics/joints/joint_kinematics.hpp>

#include <algorithm>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Two joints that share a body which forces move. An impulse in one changes the velocity in the
/// other. Each joint is also coupled to itself, once per body that moves.
struct JointCoupling {
  /// [-] The shared body.
  std::uint32_t body = 0;
  /// [-] Joints; `row` is not before `column` in the order. The flags: true if the body is their B.
  std::uint32_t row = 0;
  std::uint32_t column = 0;
  bool is_b_of_row = false;
  bool is_b_of_column = false;
};

/// Joints numbered breadth first from the end of a chain. The method is that of Cuthill and McKee
/// (1969). Neighbours get near numbers. So the envelope of a chain is as narrow as one joint.
class JointOrder {
 public:
  /// @param moves  For each body, true if forces move it.
  template <Scalar S>
  void build(std::span<const MechanismJoint<S>> joints, const DynamicArray<bool>& moves);

  /// First block row of each joint: its linear row. Its angular row follows, if any.
  [[nodiscard]] std::uint32_t first_row(std::size_t joint) const { return first_row_[joint]; }
  /// For each block row, the first column where the matrix may not be zero.
  [[nodiscard]] const DynamicArray<std::uint32_t>& envelope() const { return envelope_; }
  /// Couplings of all joints, in the order of rows.
  [[nodiscard]] const DynamicArray<JointCoupling>& couplings() const { return couplings_; }
  /// [-] Multiply-adds of a factorisation of the matrix within its envelope. If they exceed
  /// `chosen::most_factor_work` the order is not finished. A hub with hundreds of neighbours
  /// does, say.
  [[nodiscard]] std::uint64_t factor_work() const { return factor_work_; }
  [[nodiscard]] bool is_too_wide() const { return factor_work_ > chosen::most_factor_work; }
  /// Returns whether some joint closes a loop. Bodies that forces do not move count as one. The
  /// joints may then lock more than is free.
  [[nodiscard]] bool has_loop() const { return has_loop_; }

 private:
  struct End {
    std::uint32_t body, joint;
    bool is_b;
  };

  template <typename Visit>
  void for_neighbours(std::uint32_t joint, Visit visit) const;
  void number_joints(std::size_t count);
  [[nodiscard]] std::uint32_t root(std::uint32_t body) const;

  DynamicArray<End> ends_;                       // At bodies that move, sorted by body.
  DynamicArray<std::uint32_t> first_end_;        // Of each body in `ends_`, and one past the last.
  DynamicArray<std::uint32_t> body_a_, body_b_;  // Of each joint; `no_index` if it does not move.
  DynamicArray<std::uint32_t> order_;            // Joints by number.
  DynamicArray<std::uint32_t> number_;           // Of each joint.
  DynamicArray<std::uint32_t> parent_;           // Of each body, towards the root of its tree.
  DynamicArray<std::uint32_t> first_row_, envelope_;
  DynamicArray<JointCoupling> couplings_;
  std::uint64_t factor_work_ = 0;
  bool has_loop_ = false;
};

// Implementation ----------------------------------------------------------------------------------

template <typename Visit>
void JointOrder::for_neighbours(std::uint32_t joint, Visit visit) const {
  for (const std::uint32_t body : {body_a_[joint], body_b_[joint]}) {
    if (body == no_index) continue;
    for (std::uint32_t e = first_end_[body]; e < first_end_[body + 1]; ++e) visit(ends_[e].joint);
  }
}

inline std::uint32_t JointOrder::root(std::uint32_t body) const {
  while (parent_[body] != body) body = parent_[body];
  return body;
}

inline void JointOrder::number_joints(std::size_t count) {
  number_.assign(count, no_index);
  order_.clear();
  const auto take = [&](std::uint32_t joint) {
    if (number_[joint] != no_index) return;
    number_[joint] = static_cast<std::uint32_t>(order_.size());
    order_.push_back(joint);
  };
  const auto degree = [&](std::uint32_t joint) {
    std::uint32_t result = 0;
    for_neighbours(joint, [&](std::uint32_t other) { result += other != joint ? 1 : 0; });
    return result;
  };
  for (std::size_t done = 0; order_.size() < count;) {
    // From the remaining joint with the fewest neighbours. In a chain it is an end.
    std::uint32_t start = no_index;
    std::uint32_t fewest = no_index;
    for (std::uint32_t joint = 0; joint < count; ++joint) {
      if (number_[joint] != no_index || degree(joint) >= fewest) continue;
      start = joint;
      fewest = degree(joint);
    }
    take(start);
    for (; done < order_.size(); ++done) for_neighbours(order_[done], take);
  }
}

template <Scalar S>
void JointOrder::build(std::span<const MechanismJoint<S>> joints, const DynamicArray<bool>& moves) {
  const std::uint32_t anchor = static_cast<std::uint32_t>(moves.size());
  parent_.resize(moves.size() + 1);
  for (std::uint32_t i = 0; i <= anchor; ++i) parent_[i] = i;
  has_loop_ = false;
  ends_.clear();
  body_a_.clear();
  body_b_.clear();
  const auto add_end = [&](std::uint32_t body, std::uint32_t joint, bool is_b) {
    if (moves[body]) ends_.push_back({body, joint, is_b});
    return moves[body] ? body : no_index;
  };
  for (std::uint32_t i = 0; i < joints.size(); ++i) {
    body_a_.push_back(add_end(joints[i].body_a, i, false));
    body_b_.push_back(add_end(joints[i].body_b, i, true));
    const std::uint32_t a = root(std::min(body_a_.back(), anchor));
    const std::uint32_t b = root(std::min(body_b_.back(), anchor));
    has_loop_ = has_loop_ || a == b;
    parent_[std::max(a, b)] = std::min(a, b);
  }
  std::sort(ends_.begin(), ends_.end(), [](const End& l, const End& r) {
    return l.body != r.body ? l.body < r.body : l.joint < r.joint;
  });
  first_end_.assign(moves.size() + 1, 0);
  for (const End& end : ends_) ++first_end_[end.body + 1];
  for (std::size_t i = 0; i < moves.size(); ++i) first_end_[i + 1] += first_end_[i];

  first_row_.resize(joints.size());
  envelope_.clear();
  couplings_.clear();
  // All joints of a body couple. That part is dense. It takes a sixth of the cube of their number.
  factor_work_ = 0;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const std::uint64_t degree = first_end_[i + 1] - first_end_[i];
    factor_work_ = std::max(factor_work_, 27 * degree * degree / 6 * degree);
  }
  if (is_too_wide()) return;
  number_joints(joints.size());
  for (const std::uint32_t joint : order_) {
    const std::uint32_t row = static_cast<std::uint32_t>(envelope_.size());
    first_row_[joint] = row;
    std::uint32_t first = row;
    for_neighbours(joint, [&](std::uint32_t other) {
      if (number_[other] < number_[joint]) first = std::min(first, first_row_[other]);
    });
    envelope_.push_back(first);
    if (!lets_turn(joints[joint].kind)) envelope_.push_back(first);
  }
  // Half the square of the width of each row. Blocks are three by three.
  factor_work_ = 0;
  for (std::uint32_t row = 0; row < envelope_.size(); ++row) {
    const std::uint64_t width = row - envelope_[row];
    factor_work_ += 27 * width * width / 2;
  }

  for (const End& row : ends_) {
    for (std::uint32_t e = first_end_[row.body]; e < first_end_[row.body + 1]; ++e) {
      const End& column = ends_[e];
      if (number_[column.joint] > number_[row.joint]) continue;
      couplings_.push_back({row.body, row.joint, column.joint, row.is_b, column.is_b});
    }
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
