/// @file
/// Joints between the same two bodies as one group. Their rows span six dimensions at most.
///
/// Let u be B's velocity relative to A at a common point, and w its angular velocity. All rows of n
/// such joints are R (u, l w), 6 n by 6. Reduced to R = Q T, Q has orthonormal columns. The joints
/// then require T (u, l w) = Q^T b. Requirements beyond that contradict each other and cannot be
/// met. The group is six rows in the matrix of the mechanism. The number of its joints does not
/// matter. The impulses y of these rows are spread over the joints as x = Q y. These are the
/// smallest that add up to them. Bodies that forces do not move count as one. So joints from a body
/// to several of them are a group too.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/joints/joint_kinematics.hpp>
#include <bristle/math/tall_qr.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Joints of a mechanism, grouped by their two bodies. Keeps its memory.
template <Scalar S>
class JointGroups {
 public:
  /// @param moves  For each body, true if forces move it.
  void build(std::span<const MechanismJoint<S>> joints, const DynamicArray<bool>& moves);

  /// Copies joints. Exchanges the bodies of those that are defined from the other side than their
  /// group. Equal axes of a group then turn with the same body. They stay equal to round-off where
  /// bodies are slightly off their joints. Else they would seem to hold one more direction.
  void orient(std::span<const MechanismJoint<S>> joints,
              DynamicArray<MechanismJoint<S>>& out) const;
  /// Returns whether the bodies of a joint were exchanged.
  [[nodiscard]] bool is_exchanged(std::size_t joint) const { return is_exchanged_[joint]; }

  [[nodiscard]] std::size_t size() const { return groups_.size(); }
  /// One joint for each group, for the order of the matrix. It is the only joint, or one of kind
  /// `fixed`.
  [[nodiscard]] std::span<const MechanismJoint<S>> joints() const { return merged_; }
  /// Returns whether a group has more than one joint.
  [[nodiscard]] bool is_merged(std::size_t group) const { return groups_[group].count > 1; }
  /// Returns whether any group has more than one joint.
  [[nodiscard]] bool has_merged() const { return groups_.size() < members_.size(); }
  /// Geometry of a group: that of its joint, or of its common point.
  [[nodiscard]] const JointState<S>& at(std::size_t group) const { return groups_[group].at; }
  /// T, by rows, for the motion (u, w) at the common point.
  [[nodiscard]] const Mat6<S>& triangle(std::size_t group) const { return groups_[group].triangle; }

  /// Finds the geometry of all joints. The arms of a joint in a larger group meet in one point, B's
  /// origin.
  template <typename Nodes>
  void place(std::span<const MechanismJoint<S>> joints, const Nodes& nodes,
             DynamicArray<JointState<S>>& at);

  /// Reduces groups at the positions that `place` set.
  void reduce(std::span<const MechanismJoint<S>> joints, std::span<const JointState<S>> at);

  /// Right-hand side of the six rows of a group, from those of its joints, b.
  void gather(std::size_t group, std::span<const MechanismJoint<S>> joints,
              std::span<const Twist<S>> b, Vec3<S>& linear, Vec3<S>& angular);
  /// Broadcasts the impulses of the six rows of a group over its joints. Calls use(joint, force,
  /// torque) with the impulses on each joint's B.
  template <typename Use>
  void broadcast(std::size_t group, std::span<const MechanismJoint<S>> joints,
                 const Vec3<S>& linear, const Vec3<S>& angular, const Use& use);
  /// The joint of a group that has only one.
  [[nodiscard]] std::uint32_t joint(std::size_t group) const {
    return members_[groups_[group].first].joint;
  }

 private:
  struct Member {
    std::uint32_t body_a = 0, body_b = 0;  // One past the last body where forces do not move it.
    std::uint32_t joint = 0;
    bool is_reversed = false;  // Its A is the B of the group; also after `orient`.
  };
  struct Group {
    std::uint32_t first = 0, count = 0;  // Range in `members_`.
    std::uint32_t first_row = 0, rows = 0;
    S length = S(1);  // [m] Length that weights rotation.
    JointState<S> at{};
    Mat6<S> triangle;
    TallQr<S> qr{};
  };

  [[nodiscard]] static std::size_t rows_of(JointKind kind) { return lets_turn(kind) ? 3 : 6; }
  [[nodiscard]] std::span<const Row6<S>> rows_of(const Group& group) const {
    return std::span<const Row6<S>>(rows_).subspan(group.first_row, group.rows);
  }
  void fill_rows(const Group& group, std::span<const MechanismJoint<S>> joints,
                 std::span<const JointState<S>> at);

  DynamicArray<Member> members_;  // Sorted by their bodies.
  DynamicArray<Group> groups_;
  DynamicArray<MechanismJoint<S>> merged_;
  DynamicArray<bool> is_exchanged_;  // By joint.
  DynamicArray<Row6<S>> rows_;       // Rows of all merged groups.
  DynamicArray<S> values_;           // One value per row of a group.
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void JointGroups<S>::build(std::span<const MechanismJoint<S>> joints,
                           const DynamicArray<bool>& moves) {
  const auto anchor = static_cast<std::uint32_t>(moves.size());
  members_.clear();
  for (std::uint32_t i = 0; i < joints.size(); ++i) {
    const std::uint32_t a = moves[joints[i].body_a] ? joints[i].body_a : anchor;
    const std::uint32_t b = moves[joints[i].body_b] ? joints[i].body_b : anchor;
    members_.push_back({std::min(a, b), std::max(a, b), i, a > b});
  }
  // Joints of a group keep their order. Groups are ordered by their first joints. Mechanisms
  // without merged groups are as if there were none.
  std::sort(members_.begin(), members_.end(), [](const Member& l, const Member& r) {
    if (l.body_a != r.body_a) return l.body_a < r.body_a;
    return l.body_b != r.body_b ? l.body_b < r.body_b : l.joint < r.joint;
  });
  groups_.clear();
  for (std::uint32_t k = 0; k < members_.size(); ++k) {
    const bool is_next = k > 0 && members_[k].body_a == members_[k - 1].body_a &&
                         members_[k].body_b == members_[k - 1].body_b;
    if (!is_next) {
      groups_.emplace_back();
      groups_.back().first = k;
    }
    ++groups_.back().count;
  }
  std::sort(groups_.begin(), groups_.end(), [this](const Group& l, const Group& r) {
    return members_[l.first].joint < members_[r.first].joint;
  });
  merged_.clear();
  is_exchanged_.assign(joints.size(), false);
  std::uint32_t rows = 0;
  for (Group& group : groups_) {
    const Member& first = members_[group.first];
    merged_.push_back(joints[first.joint]);
    if (group.count == 1) continue;
    merged_.back().kind = JointKind::fixed;
    if (first.is_reversed) std::swap(merged_.back().body_a, merged_.back().body_b);
    group.first_row = rows;
    for (std::uint32_t k = 0; k < group.count; ++k) {
      Member& member = members_[group.first + k];
      group.rows += static_cast<std::uint32_t>(rows_of(joints[member.joint].kind));
      // A joint with a spring is not exchanged. Its position keeps its sign.
      if (!member.is_reversed || joints[member.joint].has_spring()) continue;
      member.is_reversed = false;
      is_exchanged_[member.joint] = true;
    }
    rows += group.rows;
  }
  rows_.resize(rows);
}

template <Scalar S>
void JointGroups<S>::orient(std::span<const MechanismJoint<S>> joints,
                            DynamicArray<MechanismJoint<S>>& out) const {
  out.assign(joints.begin(), joints.end());
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!is_exchanged_[i]) continue;
    std::swap(out[i].body_a, out[i].body_b);
    std::swap(out[i].X_CmA_J, out[i].X_CmB_J);
  }
}

template <Scalar S>
template <typename Nodes>
void JointGroups<S>::place(std::span<const MechanismJoint<S>> joints, const Nodes& nodes,
                           DynamicArray<JointState<S>>& at) {
  using std::max;
  using std::sqrt;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    at[i] = joint_state(joints[i], nodes[joints[i].body_a].now, nodes[joints[i].body_b].now);
  }
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    Group& group = groups_[g];
    if (group.count == 1) {
      group.at = at[members_[group.first].joint];
      continue;
    }
    // Seen from A, which forces move. B may be one of several bodies that they do not move.
    const auto& a = nodes[merged_[g].body_a];
    const auto& b = nodes[merged_[g].body_b];
    Vec3<S> sum = zero<Vec3<S>>();
    S arm2 = S(0);
    for (std::uint32_t k = 0; k < group.count; ++k) {
      const Member& member = members_[group.first + k];
      const MechanismJoint<S>& joint = joints[member.joint];
      JointState<S>& one = at[member.joint];
      one.arm_a = (nodes[joint.body_b].now.x - nodes[joint.body_a].now.x) + one.arm_b;
      sum += member.is_reversed ? one.arm_b : one.arm_a;
      arm2 = max(arm2, max(one.arm_a.squaredNorm(), one.arm_b.squaredNorm()));
    }
    group.at = {};
    group.at.arm_a = sum / S(group.count);
    group.at.arm_b = group.at.arm_a - (b.now.x - a.now.x);
    // This length balances both kinds of impulse. Impulses move the joints as much as angular
    // impulses turn them.
    const S gains = a.inverse_mass.sum() + b.inverse_mass.sum();
    const S turns = a.inverse_inertia.trace() + b.inverse_inertia.trace();
    const S length2 = arm2 + gains / turns;
    group.length = length2 > S(0) && length2 < infinity<S> ? S(sqrt(length2)) : S(1);
  }
}

template <Scalar S>
void JointGroups<S>::fill_rows(const Group& group, std::span<const MechanismJoint<S>> joints,
                               std::span<const JointState<S>> at) {
  std::size_t row = group.first_row;
  for (std::uint32_t k = 0; k < group.count; ++k) {
    const Member& member = members_[group.first + k];
    const JointState<S>& one = at[member.joint];
    const S sign = member.is_reversed ? S(-1) : S(1);
    const Vec3<S> r = (member.is_reversed ? one.arm_b : one.arm_a) - group.at.arm_a;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const Vec3<S> e = sign * unit_vector<Vec3<S>>(axis);
      const Vec3<S> d = across(one.slide, e);
      const Vec3<S> turn = r.cross(d) / group.length;
      rows_[row++] = {d.x(), d.y(), d.z(), turn.x(), turn.y(), turn.z()};
    }
    if (lets_turn(joints[member.joint].kind)) continue;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const Vec3<S> e = sign * unit_vector<Vec3<S>>(axis);
      const Vec3<S> d = across(one.hinge, e);
      rows_[row++] = {S(0), S(0), S(0), d.x(), d.y(), d.z()};
    }
  }
}

template <Scalar S>
void JointGroups<S>::reduce(std::span<const MechanismJoint<S>> joints,
                            std::span<const JointState<S>> at) {
  for (Group& group : groups_) {
    if (group.count == 1) continue;
    fill_rows(group, joints, at);
    group.qr = reduce_rows(std::span<Row6<S>>(rows_).subspan(group.first_row, group.rows));
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < 6; ++j) {
        group.triangle(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            (j < 3 ? S(1) : group.length) * group.qr.triangle[i][j];
      }
    }
  }
}

template <Scalar S>
void JointGroups<S>::gather(std::size_t g, std::span<const MechanismJoint<S>> joints,
                            std::span<const Twist<S>> b, Vec3<S>& linear, Vec3<S>& angular) {
  const Group& group = groups_[g];
  values_.clear();
  for (std::uint32_t k = 0; k < group.count; ++k) {
    const std::uint32_t joint = members_[group.first + k].joint;
    for (const S& x : b[joint].linear) values_.push_back(x);
    if (lets_turn(joints[joint].kind)) continue;
    for (const S& x : b[joint].angular) values_.push_back(group.length * x);
  }
  to_triangle(group.qr, rows_of(group), std::span<S>(values_));
  linear = {values_[0], values_[1], values_[2]};
  angular = {values_[3], values_[4], values_[5]};
}

template <Scalar S>
template <typename Use>
void JointGroups<S>::broadcast(std::size_t g, std::span<const MechanismJoint<S>> joints,
                               const Vec3<S>& linear, const Vec3<S>& angular, const Use& use) {
  const Group& group = groups_[g];
  values_.assign(group.rows, S(0));
  for (std::size_t i = 0; i < 3; ++i) {
    values_[i] = linear[static_cast<Eigen::Index>(i)];
    values_[i + 3] = angular[static_cast<Eigen::Index>(i)];
  }
  from_triangle(group.qr, rows_of(group), std::span<S>(values_));
  const S* x = values_.data();
  for (std::uint32_t k = 0; k < group.count; ++k) {
    const std::uint32_t joint = members_[group.first + k].joint;
    const bool has_torque = !lets_turn(joints[joint].kind);
    const Vec3<S> force(x[0], x[1], x[2]);
    const Vec3<S> torque =
        has_torque ? Vec3<S>(group.length * Vec3<S>(x[3], x[4], x[5])) : zero<Vec3<S>>();
    use(joint, force, torque);
    x += has_torque ? 6 : 3;
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
