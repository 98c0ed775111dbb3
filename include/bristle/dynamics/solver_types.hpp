/// @file
/// What both solvers work on: bodies as the solver sees them, one island's constraints, settings
/// and what a solve reports.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/constraint.hpp>
#include <bristle/dynamics/soft_block.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace bristle {

/// Settings of the solver. The defaults are made for holding things still.
template <Scalar S>
struct SolverDef {
  /// [-] Most sweeps over an island's constraints a step.
  int max_sweeps = 100;
  /// [-] Most sweeps of the position correction a step.
  int max_position_sweeps = 30;
  /// [-] Most times an island is solved anew because its sensors changed state (stuck to slipping,
  /// touching to free, normal force).
  int max_passes = 12;
  /// [1] A sweep that changes no velocity by more than this fraction of the speed gained from
  /// gravity in a step is the last one. Tight on purpose: a state that is not at rest to this
  /// precision never becomes the fixed point that makes the next step one sweep.
  S tolerance = std::numeric_limits<S>::digits > 30 ? S(1e-9) : S(1e-5);
  /// [-] Most moving bodies of an island that is solved by factorisation; larger ones are swept.
  std::uint32_t max_direct_bodies = 32;
  /// [-] Most constraint rows of an island that is solved by factorisation.
  std::uint32_t max_direct_rows = 384;
};

/// A body in the solver.
template <Scalar S>
struct SolverBody {
  /// Velocities at the end of the step, as known so far.
  Twist<S> twist{};
  /// Velocities that free motion would give.
  Twist<S> free{};
  /// Velocities at the start of the step.
  Twist<S> start{};
  /// Displacement of the position correction, divided by the step.
  Twist<S> correction{};
  /// [1/kg, 1/(kg m^2)] World axes; zero along and about axes on which forces do not move it.
  Vec3<S> inverse_mass = Vec3<S>::Zero();
  Mat3<S> inverse_inertia = Mat3<S>::Zero();
  /// [kg, kg m^2] Of the whole body, world axes.
  S mass = S(0);
  Mat3<S> inertia = Mat3<S>::Zero();
  /// Whether forces move it along or about any axis.
  bool moves = false;

  [[nodiscard]] bool is_moving() const { return moves; }
  /// Whether nothing moves it along (0 to 2) or about (3 to 5) an axis of the world.
  [[nodiscard]] bool is_locked(Eigen::Index axis) const {
    return (axis < 3 ? inverse_mass[axis] : inverse_inertia(axis - 3, axis - 3)) == S(0);
  }
  /// Adds an impulse about the centre of mass.
  void push(const Vec3<S>& impulse, const Vec3<S>& angular_impulse) {
    twist.linear += inverse_mass.cwiseProduct(impulse);
    twist.angular += inverse_inertia * angular_impulse;
  }
};

/// Everything that acts between bodies in one step, for all islands.
template <Scalar S>
struct Constraints {
  std::vector<ConstraintRow<S>> rows;
  std::vector<ConstraintBlock<S>> blocks;
  std::vector<SoftBlock<S>> soft;

  void clear() {
    rows.clear();
    blocks.clear();
    soft.clear();
  }
};

/// One island: bodies that act on each other, by their slots, and what acts between them, by
/// number.
struct Island {
  std::span<const std::uint32_t> bodies;
  std::span<const std::uint32_t> blocks;
  std::span<const std::uint32_t> soft;
};

/// How a solve went.
template <Scalar S>
struct SolveReport {
  /// [-] Sweeps, and factorisations of an island's matrix.
  int sweeps = 0;
  int factorisations = 0;
  /// [m/s] Largest velocity change of the last sweep.
  S residual = S(0);

  void merge(const SolveReport& other) {
    sweeps += other.sweeps;
    factorisations += other.factorisations;
    residual = std::max(residual, other.residual);
  }
};

/// What one solve needs to know of the step.
template <Scalar S>
struct SolveContext {
  /// [s] Step length.
  S dt = S(0);
  /// [m/s] Velocity changes below this do not count.
  S velocity_tolerance = S(0);
  SolverDef<S> settings{};
};

/// Response of a block's rows to its own impulses when only its two bodies move.
template <Scalar S>
void local_response(const ConstraintBlock<S>& block, const ConstraintRow<S>* rows,
                    const SolverBody<S>& a, const SolverBody<S>& b, BlockResponse<S>& K) {
  const Vec3<S> inverse_mass = a.inverse_mass + b.inverse_mass;
  for (std::size_t j = 0; j < block.count; ++j) {
    const Vec3<S> turn_a = a.inverse_inertia * rows[j].angular_a;
    const Vec3<S> turn_b = b.inverse_inertia * rows[j].angular_b;
    const Vec3<S> move = inverse_mass.cwiseProduct(rows[j].direction);
    for (std::size_t i = 0; i < block.count; ++i) {
      K.matrix[i * block.count + j] = rows[i].direction.dot(move) + rows[i].angular_a.dot(turn_a) +
                                      rows[i].angular_b.dot(turn_b);
    }
  }
  K.prepare(block.kind, block.count);
}

/// Applies the impulse x of a row to both bodies.
template <Scalar S>
void apply_row(const ConstraintRow<S>& row, S x, SolverBody<S>& a, SolverBody<S>& b) {
  a.push(-x * row.direction, -x * row.angular_a);
  b.push(x * row.direction, x * row.angular_b);
}

/// Applies the impulse p of a soft block to both bodies: p on B, -p on A.
template <Scalar S>
void apply_soft(const SoftBlock<S>& block, const Vec6<S>& p, SolverBody<S>& a, SolverBody<S>& b) {
  const Vec3<S> force = p.template head<3>();
  const Vec3<S> torque = p.template tail<3>();
  a.push(-force, -torque - block.arm_a.cross(force));
  b.push(force, torque + block.arm_b.cross(force));
}

}  // namespace bristle
