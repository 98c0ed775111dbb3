/// @file
/// Sequential impulses: sweeps over an island's constraints. Each is solved exactly in turn.
///
/// This is the general solver. Its cost is proportional to the number of constraints. It needs no
/// memory. Resting and sliding islands converge in one sweep from a warm start.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/contacts/manifold_sweeps.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <algorithm>
#include <array>

namespace bristle::inline BRISTLE_ABI::detail {

/// The algorithm with its scratch memory. One object serves many islands in turn.
template <Scalar S>
class SequentialSolver {
 public:
  /// Sets up the sweeps over an island. Applies the impulses in its constraints (warm start).
  void start(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies) {
    by_manifold_ = false;
    start_points(island, constraints, bodies);
    start_blocks(island, constraints, bodies);
    apply_impulses(island, constraints, bodies);
  }

  /// The same for sweeps in which the points of a manifold share their friction. `start_part` sets
  /// velocities and contact targets.
  void start_manifolds(const Island& island, Constraints<S>& constraints,
                       std::span<const SolverBody<S>> bodies, S parts) {
    by_manifold_ = true;
    manifolds_.start(island, constraints, bodies, parts);
    start_blocks(island, constraints, bodies);
  }
  /// Returns whether most contacts of the manifolds are new.
  [[nodiscard]] bool is_cold() const { return manifolds_.is_cold(); }
  /// Finds the velocities of a swept island. They are those by the impulses of points. A
  /// crushed island (`limit_crushing`) keeps those of the last sweep. A single point has no
  /// torsion, and the torque that is lost so would spin its bodies at 900 rad/s.
  void find_velocities(const Island& island, const Constraints<S>& constraints,
                       std::span<SolverBody<S>> bodies) const {
    if (!manifolds_.may_be_crushed()) apply_impulses(island, constraints, bodies);
  }
  /// Starts a substep. Arms, axes and masses stay those of the start of the step.
  void start_part(const Island& island, Constraints<S>& constraints,
                  std::span<SolverBody<S>> bodies, const SolveContext<S>& context) {
    manifolds_.target(bodies, context);
    if (shares_bodies(island)) {
      manifolds_.write_impulses(island, constraints);
      apply_impulses(island, constraints, bodies);
    } else {
      for (const std::uint32_t slot : island.bodies) bodies[slot].twist = bodies[slot].free;
      manifolds_.apply();
    }
  }
  /// Ends a substep that another one follows.
  void move_on(std::span<const SolverBody<S>> bodies, S dt) { manifolds_.move_on(bodies, dt); }
  /// Ends the last substep: writes the contacts' results to the constraints.
  void finish_parts(const Island& island, Constraints<S>& constraints) const {
    manifolds_.write_back(island, constraints);
  }

  /// One sweep over all constraints, there or back. Information crosses a stack in one pair of
  /// sweeps instead of one per layer.
  ///
  /// The motion of a soft block is stored right after its own last update. There its impulse is
  /// exactly offset + matrix * motion. The progress of the sweeps does not matter. Elsewhere the
  /// stiffness would multiply the residual.
  ///
  /// @return [m/s] Largest velocity change.
  S sweep(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
          bool backwards) {
    S largest = S(0);
    for (std::size_t k = 0; k < island.soft.size(); ++k) {
      largest = std::max(largest, sweep_soft(constraints.soft[island.soft[k]], k, bodies));
    }
    for_each(island.blocks.size(), backwards, [&](std::size_t k) {
      largest = std::max(largest, sweep_block(constraints, island.blocks[k], k, bodies));
    });
    if (by_manifold_) {
      return std::max(largest, sweep_manifolds(island, bodies, velocity_of,
                                               [&] { return manifolds_.sweep(backwards); }));
    }
    for_each(island.contacts.size(), backwards, [&](std::size_t k) {
      largest =
          std::max(largest, sweep_contact(constraints.contacts[island.contacts[k]], k, bodies));
    });
    return largest;
  }

  /// Starts to watch the sweeps that follow, there and back in turn, for `extrapolate`.
  void start_extrapolation(SweptProblem problem) { manifolds_.start_extrapolation(problem); }
  /// Moves on as the last sweep there and back did (`ManifoldSweeps::extrapolate`). At least one
  /// sweep has to follow.
  /// @return True if there was something to gain.
  bool extrapolate(SweptProblem problem) { return manifolds_.extrapolate(problem); }

  /// Ends the sweeps of a substep.
  void finish(const Island& island, std::span<SolverBody<S>> bodies) const {
    if (!shares_bodies(island)) manifolds_.unload(bodies, velocity_of);
  }
  /// Stores the results of the last sweeps (`ManifoldSweeps::spread_friction`).
  void keep_impulses() { manifolds_.spread_friction(); }
  /// Clears the warm start of contacts.
  void forget_impulses() { manifolds_.forget(); }

  /// Starts sweeps of the position problem of a substep.
  void start_positions(const Island& island, std::span<SolverBody<S>> bodies,
                       const SolveContext<S>& context) {
    manifolds_.start_positions(bodies, context);
    if (shares_bodies(island)) manifolds_.unload(bodies, motion_of);
  }
  /// Ends sweeps of the position problem.
  void finish_positions(const Island& island, Constraints<S>& constraints,
                        std::span<SolverBody<S>> bodies) {
    manifolds_.finish_positions(island, constraints);
    if (!shares_bodies(island)) manifolds_.unload(bodies, motion_of);
  }
  /// One sweep of the position problem over the displacements in `SolverBody::motion`. A larger
  /// position impulse moves bodies apart, a smaller one together. At the end touching surfaces do
  /// not overlap. Velocities, and so kinetic energy, do not change.
  ///
  /// @return [m/s] Largest change of a displacement, divided by the step.
  S sweep_positions(const Island& island, Constraints<S>& constraints,
                    std::span<SolverBody<S>> bodies, S dt, bool backwards) {
    S largest = S(0);
    for_each(island.blocks.size(), backwards, [&](std::size_t k) {
      largest = std::max(largest, place_block(constraints, island.blocks[k], k, bodies, dt));
    });
    if (by_manifold_) {
      return std::max(largest, sweep_manifolds(island, bodies, motion_of,
                                               [&] { return manifolds_.place(backwards); }));
    }
    for_each(island.contacts.size(), backwards, [&](std::size_t k) {
      largest =
          std::max(largest, place_contact(constraints.contacts[island.contacts[k]], k, bodies, dt));
    });
    return largest;
  }

 private:
  /// Returns whether other constraints change velocities between two sweeps over manifolds.
  [[nodiscard]] static bool shares_bodies(const Island& island) {
    return !island.blocks.empty() || !island.soft.empty();
  }
  template <typename Of, typename Sweep>
  S sweep_manifolds(const Island& island, std::span<SolverBody<S>> bodies, Of&& of, Sweep&& sweep) {
    if (!shares_bodies(island)) return sweep();
    manifolds_.load(bodies, of);
    const S largest = sweep();
    manifolds_.unload(bodies, of);
    return largest;
  }

  void start_blocks(const Island& island, const Constraints<S>& constraints,
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

  void start_points(const Island& island, const Constraints<S>& constraints,
                    std::span<const SolverBody<S>> bodies) {
    contact_responses_.resize(std::max(contact_responses_.size(), island.contacts.size()));
    for (std::size_t k = 0; k < island.contacts.size();) {
      const ContactConstraint<S>& first = constraints.contacts[island.contacts[k]];
      const ContactFrame<S> frame(first, bodies[first.body_a], bodies[first.body_b]);
      for (; k < island.contacts.size(); ++k) {
        const ContactConstraint<S>& c = constraints.contacts[island.contacts[k]];
        if (!are_of_one_manifold(first, c)) break;
        contact_responses_[k] = contact_response(c, frame);
      }
    }
  }

  template <typename Visit>
  static void for_each(std::size_t count, bool backwards, Visit&& visit) {
    for (std::size_t k = 0; k < count; ++k) visit(backwards ? count - 1 - k : k);
  }

  /// (I + A W)^-1 of a soft block. It maps the residual p(u) - p to the change of its impulse. It
  /// is found as W^-1 (W^-1 + A)^-1. That needs Cholesky factors only.
  static Mat6<S> soft_gain(const SoftBlock<S>& soft, std::span<const SolverBody<S>> bodies) {
    const SolverBody<S>& a = bodies[soft.body_a];
    const SolverBody<S>& b = bodies[soft.body_b];
    using RowMajor6 = Eigen::Matrix<S, 6, 6, Eigen::RowMajor | Eigen::DontAlign>;
    RowMajor6 W = mobility(a.inverse_mass, a.inverse_inertia, soft.arm_a) +
                  mobility(b.inverse_mass, b.inverse_inertia, soft.arm_b);
    if (!factor_cholesky(W.data(), 6)) return zero<Mat6<S>>();
    RowMajor6 inverse = identity<RowMajor6>();  // Row i will hold W^-1 e_i; symmetric.
    for (int i = 0; i < 6; ++i) {
      solve_lower(W.data(), 6, &inverse(i, 0), static_cast<std::size_t>(i));
      solve_upper(W.data(), 6, &inverse(i, 0));
    }
    RowMajor6 sum = inverse + soft.matrix;
    if (!factor_cholesky(sum.data(), 6)) return zero<Mat6<S>>();
    RowMajor6 gain = inverse;  // Row i becomes sum^-1 (W^-1 e_i), which is row i of W^-1 sum^-1.
    for (int i = 0; i < 6; ++i) {
      solve_lower(sum.data(), 6, &gain(i, 0));
      solve_upper(sum.data(), 6, &gain(i, 0));
    }
    return gain;
  }

  S sweep_soft(SoftBlock<S>& soft, std::size_t k, std::span<SolverBody<S>> bodies) {
    SolverBody<S>& a = bodies[soft.body_a];
    SolverBody<S>& b = bodies[soft.body_b];
    const Vec6<S> u = relative_motion(soft, a.twist, b.twist);
    const Vec6<S> change = gains_[k] * (soft.offset + soft.matrix * u - soft.impulse);
    soft.impulse += change;
    apply_soft(soft, change, a, b);
    soft.motion = relative_motion(soft, a.twist, b.twist);
    return first_half<S>(soft.motion - u).norm();
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
      apply_row(rows[i], change[i], a, b, velocity_of);
      largest = std::max(largest, abs(change[i]) * responses_[k](i, i, block.count));
    }
    return largest;
  }

  S sweep_contact(ContactConstraint<S>& c, std::size_t k, std::span<SolverBody<S>> bodies) {
    using std::abs;
    using std::max;
    SolverBody<S>& a = bodies[c.body_a];
    SolverBody<S>& b = bodies[c.body_b];
    const ContactResponse<S>& K = contact_responses_[k];
    const std::array<S, 3> x = solve_contact(c, K, c.velocity(a.twist, b.twist));
    if (x[0] == S(0) && x[1] == S(0) && x[2] == S(0)) return S(0);
    apply_at_contact<S>(c, x[0] * c.axes[0] + x[1] * c.axes[1] + x[2] * c.axes[2], a, b,
                        velocity_of);
    return max(abs(x[0]) * K.nn, max(abs(x[1]), abs(x[2])) * K.largest);
  }

  S place_block(Constraints<S>& constraints, std::uint32_t index, std::size_t k,
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
      const S left = rows[i].error / dt + rows[i].velocity(a.motion, b.motion);
      S wanted = rows[i].correction + scalar_change(left, response);
      if (block.kind != BlockKind::equality) wanted = std::max(S(0), wanted);
      const S change = wanted - rows[i].correction;
      rows[i].correction = wanted;
      apply_row(rows[i], change, a, b, motion_of);
      largest = std::max(largest, abs(change) * response);
    }
    return largest;
  }

  S place_contact(ContactConstraint<S>& c, std::size_t k, std::span<SolverBody<S>> bodies, S dt) {
    using std::abs;
    using std::max;
    SolverBody<S>& a = bodies[c.body_a];
    SolverBody<S>& b = bodies[c.body_b];
    if (c.is_separating) return S(0);
    const ContactResponse<S>& response = contact_responses_[k];
    const S left = c.gap / dt + c.normal_velocity(a.motion, b.motion);
    const S wanted = max(c.least_position_impulse, c.position_impulse - left * response.inverse_nn);
    const S change = wanted - c.position_impulse;
    if (change == S(0)) return S(0);
    c.position_impulse = wanted;
    apply_at_contact<S>(c, change * c.axes[0], a, b, motion_of);
    return abs(change) * response.nn;
  }

  bool by_manifold_ = false;
  ManifoldSweeps<S> manifolds_;
  DynamicArray<ContactResponse<S>> contact_responses_;
  DynamicArray<BlockResponse<S>> responses_;
  DynamicArray<Mat6<S>> gains_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
