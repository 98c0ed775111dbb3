/// @file
/// Velocity constraints of joints, and of rolling friction, as rows in blocks. Exact solution of
/// one block.
///
/// The sequential and the proximal solver share this file. They differ only in how an impulse of
/// one block changes the velocities of the others.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/no_index.hpp>
#include <bristle/dynamics/contacts/contact_constraint.hpp>
#include <bristle/math/cholesky.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/math/types.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// One scalar velocity constraint between bodies A and B. Its velocity is d . (v_B - v_A) +
/// angular_b . w_B - angular_a . w_A. An impulse x adds d x to B's momentum.
template <Scalar S>
struct ConstraintRow {
  /// [1] Direction d, world axes. It is zero for a row on angular velocity.
  Vec3<S> direction = zero<Vec3<S>>();
  /// [m or 1] r x d for a row at a point, the axis for an angular row. One for each body.
  Vec3<S> angular_a = zero<Vec3<S>>();
  Vec3<S> angular_b = zero<Vec3<S>>();
  /// [m/s or rad/s] Velocity target.
  S target = S(0);
  /// [1/kg or 1/(kg m^2)] Compliance of a bounded row. Its velocity target is target - compliance *
  /// impulse.
  S compliance = S(0);
  /// [m or rad] Position error at the start of the step. It is the distance to a limit, or the
  /// offset of a joint.
  S error = S(0);
  /// [N s or N m s] Accumulated impulse.
  S impulse = S(0);
  /// [N s or N m s] Accumulated impulse of the position correction.
  S correction = S(0);

  /// [m/s or rad/s] Velocity of the row.
  [[nodiscard]] S velocity(const Twist<S>& a, const Twist<S>& b) const {
    return direction.dot(b.linear - a.linear) + angular_b.dot(b.angular) - angular_a.dot(a.angular);
  }
};

/// The same row with the opposite sign. Its error, target and impulses are zero.
template <Scalar S>
[[nodiscard]] ConstraintRow<S> reversed(const ConstraintRow<S>& row) {
  ConstraintRow<S> result;
  result.direction = -row.direction;
  result.angular_a = -row.angular_a;
  result.angular_b = -row.angular_b;
  return result;
}

/// Allowed impulses of a block.
enum class BlockKind : std::uint8_t {
  /// Any value: velocities equal their targets.
  equality,
  /// One row within [lower, upper]: a motor, or rolling friction.
  bounded,
  /// A limit: one row that only pushes. It keeps an error from falling below zero.
  limit
};

/// Rows that are solved together.
template <Scalar S>
struct ConstraintBlock {
  static constexpr std::size_t max_rows = 6;

  /// [-] Slots of the two bodies.
  std::uint32_t body_a = 0;
  std::uint32_t body_b = 0;
  /// [-] First row and number of rows.
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  BlockKind kind = BlockKind::equality;
  /// [-] First of its impulses among those that the joint stores.
  std::uint8_t first_impulse = 0;
  /// [-] Slot of its joint; `no_index` for rolling friction.
  std::uint32_t joint = 0;
  /// [N s or N m s] Bounds of a bounded row or a limit.
  S lower = S(0);
  S upper = S(0);

  [[nodiscard]] bool is_of_joint() const { return joint != no_index; }
};

/// Number of rows of a block that the position correction closes. It closes all of a joint, one of
/// a limit, none of a motor or of rolling friction.
template <Scalar S>
[[nodiscard]] std::uint32_t corrected_rows(const ConstraintBlock<S>& block) {
  switch (block.kind) {
    case BlockKind::equality:
      return block.count;
    case BlockKind::limit:
      return 1;
    case BlockKind::bounded:
      break;
  }
  return 0;
}

/// Response of a block's row velocities to its own impulses. The factor of that matrix. Row-major,
/// `count` x `count`.
template <Scalar S>
struct BlockResponse {
  std::array<S, 36> matrix{};
  /// Cholesky factor of `matrix`, for equality blocks.
  std::array<S, 36> factor{};

  [[nodiscard]] S operator()(std::size_t i, std::size_t j, std::size_t count) const {
    return matrix[i * count + j];
  }

  /// Factors `matrix` for the solution.
  void prepare(BlockKind kind, std::size_t count) {
    if (kind != BlockKind::equality) return;
    factor = matrix;
    // Redundant rows give a singular matrix. The floor softens them just enough to share the load.
    // A block without any response (between two immovable bodies) gets no impulse.
    if (!factor_cholesky(factor.data(), count, no_mobility<S>())) {
      factor.fill(S(0));
      for (std::size_t i = 0; i < count; ++i) factor[i * count + i] = infinity<S>;
    }
  }
};

/// Solves one block with everything else held still.
///
/// @param K         Response of the block's velocities to its impulses.
/// @param velocity  Present row velocities.
/// @param rows      The block's rows; their impulses are updated.
/// @param[out] change  Impulse change of each row.
template <Scalar S>
void solve_block(const ConstraintBlock<S>& block, const BlockResponse<S>& K, const S* velocity,
                 ConstraintRow<S>* rows, S* change) {
  using std::max;
  using std::min;
  switch (block.kind) {
    case BlockKind::equality:
      for (std::size_t i = 0; i < block.count; ++i) change[i] = rows[i].target - velocity[i];
      solve_lower(K.factor.data(), block.count, change);
      solve_upper(K.factor.data(), block.count, change);
      for (std::size_t i = 0; i < block.count; ++i) rows[i].impulse += change[i];
      return;
    case BlockKind::bounded:
    case BlockKind::limit: {
      const S missing = velocity[0] - rows[0].target + rows[0].compliance * rows[0].impulse;
      const S wanted = rows[0].impulse + scalar_change(missing, K(0, 0, 1) + rows[0].compliance);
      const S impulse = min(max(wanted, block.lower), block.upper);
      change[0] = impulse - rows[0].impulse;
      rows[0].impulse = impulse;
      return;
    }
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
