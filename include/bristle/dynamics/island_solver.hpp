/// @file
/// One island's velocities and displacements, by whichever solver suits it.
///
/// What rests or slides is one sweep of sequential impulses. Where sweeps converge so slowly that
/// factorisations are cheaper, and always where sensors, joints or a wholly new set of contacts
/// want their load spread evenly, the proximal solver takes over, as long as the island is small.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/contact_aim.hpp>
#include <bristle/dynamics/proximal_solver.hpp>
#include <bristle/dynamics/sequential_solver.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace bristle {

/// Scratch memory and the choice. One object serves many islands, one after the other.
template <Scalar S>
class IslandSolver {
 public:
  /// Finds the impulses of all constraints, starting from those of the last step, and the
  /// velocities at the end of the step.
  void solve(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
             const SolveContext<S>& context, SolveReport<S>& report) {
    const bool is_small = island.bodies.size() <= context.settings.max_direct_bodies;
    sequential_.start(island, constraints, bodies);
    if (is_small && wants_even_load(island, constraints)) {
      const S left = S(proximal_.solve(island, constraints, bodies, context, report));
      report.residual = left;
      apply_impulses(island, constraints, bodies);
      // Sweeps would only wear down what factorisations leave of soft blocks and joints.
      const bool is_stiff = !island.soft.empty() || !island.blocks.empty();
      if (left < infinity<S> && (is_stiff || left <= context.velocity_tolerance)) return;
    }
    Convergence progress(context.velocity_tolerance);
    bool may_factor = is_small && island.soft.empty();
    for (int n = 0; n < context.settings.max_sweeps; ++n) {
      const S residual = sequential_.sweep(island, constraints, bodies, n % 2 != 0);
      ++report.sweeps;
      report.residual = residual;
      if (progress.is_done(residual)) break;
      if (may_factor && progress.is_slow()) {
        may_factor = false;
        try_proximal(island, constraints, bodies, context, residual, report);
        if (progress.is_done(report.residual)) break;
      }
    }
  }

  /// Finds the displacements of the step, once velocities are known. In a quiet step they follow
  /// from the velocities and nothing is to be solved.
  void place(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
             const SolveContext<S>& context, SolveReport<S>& report) {
    const S usual = context.integrator == Integrator::trapezoidal ? S(0.5) : S(1);
    for (const std::uint32_t slot : island.bodies) {
      bodies[slot].motion = mean_motion(bodies[slot], context.integrator);
    }
    for (const std::uint32_t i : island.contacts) {
      ContactConstraint<S>& c = constraints.contacts[i];
      place_contact(c, context.integrator);
      if (c.bounce_share < S(0)) continue;
      apply_at_contact<S>(c, (c.bounce_share - usual) * c.impulse_W(), bodies[c.body_a],
                          bodies[c.body_b], motion_of);
    }
    if (!has_position_error(island, constraints, bodies, context)) return;
    const S tolerance = context.position_tolerance / context.dt;
    Convergence progress(tolerance);
    bool may_factor = island.bodies.size() <= context.settings.max_direct_bodies;
    for (int n = 0; n < context.settings.max_position_sweeps; ++n) {
      const S residual =
          sequential_.sweep_positions(island, constraints, bodies, context.dt, n % 2 != 0);
      ++report.position_sweeps;
      if (progress.is_done(residual)) break;
      if (may_factor && progress.is_slow()) {
        proximal_.place(island, constraints, bodies, context, report);
        break;
      }
    }
  }

 private:
  /// Watches a sequence of residuals and tells whether sweeps are worth going on with.
  class Convergence {
   public:
    explicit Convergence(S tolerance) : tolerance_(tolerance) {}

    [[nodiscard]] bool is_done(S residual) {
      before_last_ = between_;
      between_ = last_;
      last_ = residual;
      ++count_;
      return residual <= tolerance_;
    }
    /// Whether the sweeps to come would cost more than factorisations: about 60 sweeps of contacts
    /// are worth one solve by factorisation, in stacks of any height (docs/solver.md). Sweeps go
    /// there and back, so the rate of two is what counts.
    [[nodiscard]] bool is_slow() const {
      using std::log;
      if (count_ < 4) return false;
      if (!(last_ < before_last_)) return true;
      return S(2) * log(last_ / tolerance_) > S(60) * log(before_last_ / last_);
    }

   private:
    S tolerance_;
    S last_ = infinity<S>;
    S between_ = infinity<S>;
    S before_last_ = infinity<S>;
    int count_ = 0;
  };

  /// Sweeps put all load on the first points they come to. Where that would decide what sensors
  /// and contacts report, or whether a grip slips, the load is spread by factorisation.
  [[nodiscard]] static bool wants_even_load(const Island& island,
                                            const Constraints<S>& constraints) {
    if (!island.soft.empty() || !island.blocks.empty()) return true;
    return island.contacts.size() > 1 &&
           std::all_of(island.contacts.begin(), island.contacts.end(),
                       [&](std::uint32_t i) { return constraints.contacts[i].is_fresh; });
  }

  /// Factors, and keeps the result if it is exact, or if a sweep finds less to do there than
  /// before.
  void try_proximal(const Island& island, Constraints<S>& constraints,
                    std::span<SolverBody<S>> bodies, const SolveContext<S>& context, S residual,
                    SolveReport<S>& report) {
    saved_.clear();
    for (const std::uint32_t i : island.contacts) {
      saved_.push_back(constraints.contacts[i].impulse);
    }
    const auto left = S(proximal_.solve(island, constraints, bodies, context, report));
    if (left < infinity<S>) {
      apply_impulses(island, constraints, bodies);
      report.residual = left;
      if (left <= context.velocity_tolerance) return;
      report.residual = sequential_.sweep(island, constraints, bodies, false);
      ++report.sweeps;
      if (report.residual < residual) return;
    }
    for (std::size_t k = 0; k < saved_.size(); ++k) {
      constraints.contacts[island.contacts[k]].impulse = saved_[k];
    }
    apply_impulses(island, constraints, bodies);
    report.residual = residual;
  }

  /// Whether displacements that follow from the velocities leave surfaces overlapping, apart where
  /// they press on each other, or joints open.
  [[nodiscard]] bool has_position_error(const Island& island, const Constraints<S>& constraints,
                                        std::span<const SolverBody<S>> bodies,
                                        const SolveContext<S>& context) const {
    using std::abs;
    const S dt = context.dt;
    const S tolerance = context.position_tolerance;
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = constraints.contacts[i];
      if (c.bounce_share >= S(0)) continue;
      const S left =
          c.gap + dt * c.normal_velocity(bodies[c.body_a].motion, bodies[c.body_b].motion);
      if (left < -tolerance || (left > tolerance && c.placed > c.least_placed)) return true;
    }
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = constraints.blocks[i];
      const Twist<S>& a = bodies[block.body_a].motion;
      const Twist<S>& b = bodies[block.body_b].motion;
      for (std::uint32_t r = block.first; r < block.first + corrected_rows(block); ++r) {
        const ConstraintRow<S>& row = constraints.rows[r];
        const S left = row.error + dt * row.velocity(a, b);
        if (left < -tolerance || (block.kind == BlockKind::equality && left > tolerance)) {
          return true;
        }
      }
    }
    return false;
  }

  SequentialSolver<S> sequential_;
  ProximalSolver<S> proximal_;
  std::vector<std::array<S, 3>> saved_;
};

}  // namespace bristle
