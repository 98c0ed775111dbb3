/// @file
/// Sequential impulses: sweeps over an island's blocks, each solved exactly in its turn.
///
/// The general solver: cost proportional to the number of constraints, memory none. Stacks of like
/// masses converge in a few sweeps from the impulses of the last step; islands with joints or
/// sensors are better off with the direct solver while they are small.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver_types.hpp>

#include <algorithm>
#include <vector>

namespace bristle {

/// Scratch memory and the algorithm. One object serves many islands, one after the other.
template <Scalar S>
class SequentialSolver {
 public:
  /// Finds the velocities at the end of the step, starting from the impulses in the rows and soft
  /// blocks (warm start).
  ///
  /// The motion it leaves in a soft block is the one right after the block's own last turn, where
  /// its impulse is offset + matrix * motion exactly, however far the sweeps have got: evaluating
  /// it elsewhere would multiply what is left of the residual by the stiffness.
  SolveReport<S> solve(const Island& island, Constraints<S>& constraints,
                       std::span<SolverBody<S>> bodies, const SolveContext<S>& context) {
    prepare(island, constraints, bodies);
    for (const std::uint32_t slot : island.bodies) bodies[slot].twist = bodies[slot].free;
    apply_accumulated(island, constraints, bodies);

    SolveReport<S> report;
    for (int sweep = 0; sweep < context.settings.max_sweeps; ++sweep) {
      report.residual = S(0);
      for (std::size_t k = 0; k < island.soft.size(); ++k) {
        report.residual =
            std::max(report.residual, sweep_soft(constraints.soft[island.soft[k]], k, bodies));
      }
      // There and back: information crosses a stack in one pair of sweeps instead of one per layer.
      const std::size_t count = island.blocks.size();
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = sweep % 2 == 0 ? k : count - 1 - k;
        report.residual =
            std::max(report.residual, sweep_block(constraints, island.blocks[i], i, bodies));
      }
      ++report.sweeps;
      if (report.residual <= context.velocity_tolerance) break;
    }
    return report;
  }

  /// Finds displacements that close what is left of the position errors after the step, by the same
  /// sweeps on velocities of their own, so that no kinetic energy comes of it. Uses the responses
  /// of the `solve` before it.
  /// @return Sweeps done.
  int correct_positions(const Island& island, Constraints<S>& constraints,
                        std::span<SolverBody<S>> bodies, const SolveContext<S>& context) {
    int sweep = 0;
    for (; sweep < context.settings.max_position_sweeps; ++sweep) {
      S residual = S(0);
      for (std::size_t k = 0; k < island.blocks.size(); ++k) {
        residual = std::max(residual,
                            sweep_position(constraints, island.blocks[k], k, bodies, context.dt));
      }
      if (residual <= context.velocity_tolerance) break;
    }
    return sweep;
  }

 private:
  void prepare(const Island& island, const Constraints<S>& constraints,
               std::span<const SolverBody<S>> bodies) {
    responses_.resize(std::max(responses_.size(), island.blocks.size()));
    for (std::size_t k = 0; k < island.blocks.size(); ++k) {
      const ConstraintBlock<S>& block = constraints.blocks[island.blocks[k]];
      local_response(block, &constraints.rows[block.first], bodies[block.body_a],
                     bodies[block.body_b], responses_[k]);
    }
    gains_.resize(std::max(gains_.size(), island.soft.size()));
    for (std::size_t k = 0; k < island.soft.size(); ++k) {
      gains_[k] = soft_gain(constraints.soft[island.soft[k]], bodies);
    }
  }

  /// (I + A W)^-1: turns the residual p(u) - p of a soft block into the change of its impulse. Via
  /// W^-1 (W^-1 + A)^-1, which needs Cholesky factors only.
  static Mat6<S> soft_gain(const SoftBlock<S>& soft, std::span<const SolverBody<S>> bodies) {
    const SolverBody<S>& a = bodies[soft.body_a];
    const SolverBody<S>& b = bodies[soft.body_b];
    using RowMajor6 = Eigen::Matrix<S, 6, 6, Eigen::RowMajor | Eigen::DontAlign>;
    RowMajor6 W = mobility(a.inverse_mass, a.inverse_inertia, soft.arm_a) +
                  mobility(b.inverse_mass, b.inverse_inertia, soft.arm_b);
    if (!factor_cholesky(W.data(), 6)) return Mat6<S>::Zero();
    RowMajor6 inverse;  // Row i holds W^-1 e_i; symmetric.
    for (int i = 0; i < 6; ++i) {
      inverse.row(i).setZero();
      inverse(i, i) = S(1);
      solve_lower(W.data(), 6, inverse.row(i).data(), static_cast<std::size_t>(i));
      solve_upper(W.data(), 6, inverse.row(i).data());
    }
    RowMajor6 sum = inverse + soft.matrix;
    if (!factor_cholesky(sum.data(), 6)) return Mat6<S>::Zero();
    RowMajor6 gain = inverse;  // Row i becomes sum^-1 (W^-1 e_i), which is row i of W^-1 sum^-1.
    for (int i = 0; i < 6; ++i) {
      solve_lower(sum.data(), 6, gain.row(i).data());
      solve_upper(sum.data(), 6, gain.row(i).data());
    }
    return gain;
  }

  void apply_accumulated(const Island& island, Constraints<S>& constraints,
                         std::span<SolverBody<S>> bodies) {
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = constraints.blocks[i];
      for (std::uint32_t r = block.first; r < block.first + block.count; ++r) {
        apply_row(constraints.rows[r], constraints.rows[r].impulse, bodies[block.body_a],
                  bodies[block.body_b]);
      }
    }
    for (const std::uint32_t s : island.soft) {
      const SoftBlock<S>& soft = constraints.soft[s];
      apply_soft(soft, soft.impulse, bodies[soft.body_a], bodies[soft.body_b]);
    }
  }

  S sweep_soft(SoftBlock<S>& soft, std::size_t k, std::span<SolverBody<S>> bodies) {
    SolverBody<S>& a = bodies[soft.body_a];
    SolverBody<S>& b = bodies[soft.body_b];
    const Vec6<S> u = relative_motion(soft, a.twist, b.twist);
    const Vec6<S> change = gains_[k] * (soft.offset + soft.matrix * u - soft.impulse);
    soft.impulse += change;
    apply_soft(soft, change, a, b);
    soft.motion = relative_motion(soft, a.twist, b.twist);
    return (soft.motion - u).template head<3>().norm();
  }

  S sweep_block(Constraints<S>& constraints, std::uint32_t index, std::size_t k,
                std::span<SolverBody<S>> bodies) {
    using std::abs;
    const ConstraintBlock<S>& block = constraints.blocks[index];
    ConstraintRow<S>* rows = &constraints.rows[block.first];
    SolverBody<S>& a = bodies[block.body_a];
    SolverBody<S>& b = bodies[block.body_b];
    S velocity[ConstraintBlock<S>::max_rows];
    S change[ConstraintBlock<S>::max_rows];
    for (std::size_t i = 0; i < block.count; ++i) velocity[i] = rows[i].velocity(a.twist, b.twist);
    solve_block(block, responses_[k], velocity, rows, change);
    S largest = S(0);
    for (std::size_t i = 0; i < block.count; ++i) {
      apply_row(rows[i], change[i], a, b);
      largest = std::max(largest, abs(change[i]) * responses_[k](i, i, block.count));
    }
    return largest;
  }

  S sweep_position(Constraints<S>& constraints, std::uint32_t index, std::size_t k,
                   std::span<SolverBody<S>> bodies, S dt) {
    using std::abs;
    const ConstraintBlock<S>& block = constraints.blocks[index];
    ConstraintRow<S>* rows = &constraints.rows[block.first];
    SolverBody<S>& a = bodies[block.body_a];
    SolverBody<S>& b = bodies[block.body_b];
    const std::size_t count = corrected_rows(block);
    S largest = S(0);
    for (std::size_t i = 0; i < count; ++i) {
      const S response = responses_[k](i, i, block.count);
      const S left = rows[i].error / dt + rows[i].velocity(a.twist, b.twist) +
                     rows[i].velocity(a.correction, b.correction);
      S wanted = rows[i].correction + detail::scalar_change(left, response);
      if (block.kind != BlockKind::equality) wanted = std::max(S(0), wanted);
      const S change = wanted - rows[i].correction;
      rows[i].correction = wanted;
      push_correction(rows[i], change, a, b);
      largest = std::max(largest, abs(change) * response);
    }
    return largest;
  }

  static void push_correction(const ConstraintRow<S>& row, S x, SolverBody<S>& a,
                              SolverBody<S>& b) {
    a.correction.linear -= x * a.inverse_mass.cwiseProduct(row.direction);
    a.correction.angular -= a.inverse_inertia * (x * row.angular_a);
    b.correction.linear += x * b.inverse_mass.cwiseProduct(row.direction);
    b.correction.angular += b.inverse_inertia * (x * row.angular_b);
  }

  std::vector<BlockResponse<S>> responses_;
  std::vector<Mat6<S>> gains_;
};

}  // namespace bristle
