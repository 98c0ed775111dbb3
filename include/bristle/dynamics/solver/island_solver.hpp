/// @file
/// One island's velocities and displacements, by whichever solver suits it.
///
/// What rests or slides is one sweep of sequential impulses. Where sweeps converge so slowly that
/// factorisations are cheaper, and always where sensors, joints or a wholly new set of contacts
/// want their load spread evenly, the proximal solver takes over, as long as the island is small.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/contacts/contact_aim.hpp>
#include <bristle/dynamics/contacts/saved_impulses.hpp>
#include <bristle/dynamics/solver/derivative_watch.hpp>
#include <bristle/dynamics/solver/island_energy.hpp>
#include <bristle/dynamics/solver/proximal_solver.hpp>
#include <bristle/dynamics/solver/sequential_solver.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Scratch memory and the choice. One object serves many islands, one after the other.
template <Scalar S>
class IslandSolver {
 public:
  /// Finds the impulses of all constraints, starting from those of the last step, and the
  /// velocities at the end of the step.
  void solve(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
             const SolveContext<S>& context, SolveReport<S>& report) {
    if (is_large(context)) {
      solve_large(island, constraints, bodies, context, report);
    } else {
      aim(island, constraints, bodies, context);
      solve_small(island, constraints, bodies, context, report);
    }
  }

  /// Finds the displacements of the step, once velocities are known. In a quiet step they follow
  /// from the velocities and nothing is to be solved.
  ///
  /// @return Whether they say that the velocities are to be solved anew (`open_contacts`).
  bool place(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
             const SolveContext<S>& context, SolveReport<S>& report) {
    if (!is_large(context)) {
      return place_small(island, constraints, bodies, context, report) &&
             context.integrator == Integrator::trapezoidal &&
             open_contacts<S>(island, constraints, bodies, context);
    }
    if (!island.soft.empty()) {
      // Others are placed part by part as they are solved.
      place_part(island, constraints, bodies, context, context.settings.max_position_sweeps,
                 report);
    }
    return false;
  }

  /// [-] Multiply-adds of one assembly and factorisation of an island's matrix, for
  /// `SolveContext::factor_work`; a bound where that says on which side of
  /// `enough` it is.
  [[nodiscard]] std::uint64_t factor_work(const Island& island, const Constraints<S>& constraints,
                                          std::size_t slots, std::uint64_t enough) {
    // A row of a contact is squared over both of its bodies, in three blocks.
    const std::uint64_t rows = 3 * (island.contacts.size() + island.blocks.size());
    const std::uint64_t assembly = 78 * rows + 500 * island.soft.size();
    const std::uint64_t unknowns = 6 * island.bodies.size();
    const std::uint64_t dense = assembly + unknowns * unknowns * unknowns / 6;
    if (dense <= enough) return dense;
    if (assembly > enough) return assembly;
    order_.build(island, constraints, slots);
    order_.clear(island);
    return assembly + order_.factor_work();
  }

  /// Whether an island is swept.
  [[nodiscard]] static bool is_large(const SolveContext<S>& context) {
    return context.factor_work > context.settings.max_direct_work;
  }

 private:
  static void aim(const Island& island, Constraints<S>& constraints,
                  std::span<const SolverBody<S>> bodies, const SolveContext<S>& context) {
    for (const std::uint32_t i : island.contacts) {
      ContactConstraint<S>& c = constraints.contacts[i];
      aim_contact(c, bodies[c.body_a], bodies[c.body_b], context);
    }
  }

  void solve_small(const Island& island, Constraints<S>& constraints,
                   std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                   SolveReport<S>& report) {
    sequential_.start(island, constraints, bodies);
    if (wants_even_load(island, constraints)) {
      report.residual = S(proximal_.solve(island, constraints, bodies, context, report));
      apply_impulses(island, constraints, bodies);
      if (report.residual <= S(proximal_.enough())) return;
      // Sweeps repair the rest: the impulses of an iteration that was cut short do not add up to
      // velocities that hold joints and contacts.
    }
    // What one sweep does not settle is brought well below what counts: left just there it would
    // come up again in the next step.
    Convergence progress(context.velocity_tolerance, S(0.3) * context.velocity_tolerance);
    bool may_factor = island.soft.empty();
    watch_.start();
    for (int n = 0; n < context.settings.max_sweeps; ++n) {
      const S residual = sequential_.sweep(island, constraints, bodies, n % 2 != 0);
      ++report.sweeps;
      report.residual = residual;
      if (progress.is_done(residual) &&
          have_settled(island, constraints, bodies, context, velocity_of)) {
        break;
      }
      if (may_factor && progress.is_slow()) {
        may_factor = false;
        if (try_proximal(island, constraints, bodies, context, residual, report)) return;
        progress.accept(S(proximal_.enough()));
      }
    }
    if (report.residual > context.velocity_tolerance && has_gained_energy(island, bodies)) {
      sweep_from_nothing(island, constraints, bodies, context, report);
    }
  }

  /// Whether the bodies of an island have more kinetic energy than they had, and more than free
  /// motion would give them.
  [[nodiscard]] static bool has_gained_energy(const Island& island,
                                              std::span<const SolverBody<S>> bodies) {
    const IslandEnergy<S> energy = energy_of<S>(island, bodies);
    return energy.found > energy.start && energy.found > energy.free;
  }

  /// Sweeps an island that would not converge once more, from no impulses at all, and keeps what
  /// leaves less to solve. From there the turn of each constraint takes energy out of the island,
  /// so that it is calmed wherever sweeps end; impulses of an iteration that went astray, or of a
  /// step before an impact, may have brought in any amount.
  void sweep_from_nothing(const Island& island, Constraints<S>& constraints,
                          std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                          SolveReport<S>& report) {
    saved_.save(island, constraints);
    clear_impulses(island, constraints);
    sequential_.start(island, constraints, bodies);
    S residual = infinity<S>;
    watch_.start();
    for (int n = 0; n < context.settings.max_sweeps; ++n) {
      residual = sequential_.sweep(island, constraints, bodies, n % 2 != 0);
      ++report.sweeps;
      if (residual <= context.velocity_tolerance &&
          have_settled(island, constraints, bodies, context, velocity_of)) {
        break;
      }
    }
    if (residual < report.residual) {
      report.residual = residual;
      return;
    }
    saved_.restore(island, constraints);
    apply_impulses(island, constraints, bodies);
  }

  /// A large island: few sweeps, in parts of the step that are short enough for them. Gaps follow
  /// the motion from part to part; arms and normals stay.
  void solve_large(const Island& island, Constraints<S>& constraints,
                   std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                   SolveReport<S>& report) {
    // Soft blocks are linearised over the whole step.
    const int count = island.soft.empty() ? part_count(context) : 1;
    const S parts = S(count);
    SolveContext<S> part = context.part(parts);
    part.is_swept = true;
    begin_parts(island, constraints, bodies, parts);
    sequential_.start_manifolds(island, constraints, bodies, parts);
    const int most =
        sequential_.is_cold() ? context.settings.max_sweeps : context.settings.large_sweeps;
    for (int k = 0; k < count; ++k) {
      for (std::size_t n = 0; n < island.bodies.size(); ++n) {
        SolverBody<S>& body = bodies[island.bodies[n]];
        body.start = k > 0 ? body.twist : body.start;
        body.free = body.start + parts_[n].change;
        body.free_motion = mean_free_motion(body, context.integrator);
      }
      sweep_part(island, constraints, bodies, part, most, report);
      if (has_blown_up(island, bodies)) {
        sequential_.forget_impulses();
        clear_impulses(island, constraints);
        sweep_part(island, constraints, bodies, part, most, report);
      }
      sequential_.keep_impulses();
      if (!island.soft.empty()) break;  // Placed when their sensors have settled.
      place_part(island, constraints, bodies, part, part.settings.large_position_sweeps, report);
      if (k + 1 < count) sequential_.move_on(bodies, part.dt);
      end_part(island, constraints, bodies, part.dt, parts);
    }
    sequential_.finish_parts(island, constraints);
    end_parts(island, constraints, bodies);
    scale_bounds(island, constraints, parts);
  }

  /// The velocities at the end of a part.
  void sweep_part(const Island& island, Constraints<S>& constraints,
                  std::span<SolverBody<S>> bodies, const SolveContext<S>& part, int most,
                  SolveReport<S>& report) {
    sequential_.start_part(island, constraints, bodies, part);
    for (int n = 0; n < most; ++n) {
      report.residual = sequential_.sweep(island, constraints, bodies, n % 2 != 0);
      ++report.sweeps;
      if (report.residual <= part.velocity_tolerance) break;
    }
    sequential_.finish(island, bodies);
  }

  /// Whether cut-short sweeps have released impulses that they cannot take back: those that earlier
  /// ones piled up between bodies that should bounce and cannot part, or those of an impact in the
  /// step before. Swept from nothing they get what they ask for in this part and no more. Sensors,
  /// drives and moving bodies hardly double the energy of a heap within one, but from rest, where
  /// sweeps from nothing do as well.
  [[nodiscard]] static bool has_blown_up(const Island& island,
                                         std::span<const SolverBody<S>> bodies) {
    const IslandEnergy<S> energy = energy_of<S>(island, bodies);
    return energy.found > S(2) * std::max(energy.start, energy.free);
  }

  /// Parts of a step; no more than a bound on its cost, however long it is.
  [[nodiscard]] static int part_count(const SolveContext<S>& context) {
    using std::ceil;
    using std::max;
    using std::min;
    const S most = S(64);
    const S wanted = ceil(context.dt / context.settings.longest_part);
    return static_cast<int>(min(most, max(S(1), wanted)));  // Infinite parts: one.
  }

  /// Remembers the whole step of each body and makes warm impulses of joints those of a part.
  void begin_parts(const Island& island, Constraints<S>& constraints,
                   std::span<SolverBody<S>> bodies, S parts) {
    parts_.resize(std::max(parts_.size(), island.bodies.size()));
    for (std::size_t n = 0; n < island.bodies.size(); ++n) {
      const SolverBody<S>& body = bodies[island.bodies[n]];
      parts_[n].start = body.start;
      parts_[n].free = body.free;
      parts_[n].free_motion = body.free_motion;
      parts_[n].change = (S(1) / parts) * (body.free - body.start);
      parts_[n].motion = {};
    }
    row_totals_.clear();
    for_each_row(island, constraints, [&](ConstraintRow<S>& row) {
      row.impulse /= parts;
      row.compliance *= parts;
      row_totals_.push_back(S(0));
    });
    scale_bounds(island, constraints, S(1) / parts);
  }

  /// What a drive may give in a part is its share of what it may in the step.
  static void scale_bounds(const Island& island, Constraints<S>& constraints, S scale) {
    for (const std::uint32_t i : island.blocks) {
      ConstraintBlock<S>& block = constraints.blocks[i];
      if (block.kind != BlockKind::bounded) continue;
      block.lower *= scale;
      block.upper *= scale;
    }
  }

  /// The position problem of a part, swept.
  void place_part(const Island& island, Constraints<S>& constraints,
                  std::span<SolverBody<S>> bodies, const SolveContext<S>& part, int most_sweeps,
                  SolveReport<S>& report) {
    for (const std::uint32_t slot : island.bodies) {
      bodies[slot].motion = mean_motion(bodies[slot], part.integrator);
    }
    sequential_.start_positions(island, bodies, part);
    for (int n = 0; n < most_sweeps; ++n) {
      const S residual =
          sequential_.sweep_positions(island, constraints, bodies, part.dt, n % 2 != 0);
      ++report.position_sweeps;
      if (residual * part.dt <= part.position_tolerance) break;
    }
    sequential_.finish_positions(island, bodies);
  }

  void end_part(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
                S dt, S parts) {
    std::size_t r = 0;
    for_each_row(island, constraints,
                 [&](ConstraintRow<S>& row) { row_totals_[r++] += row.impulse; });
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = constraints.blocks[i];
      for (std::uint32_t k = block.first; k < block.first + block.count; ++k) {
        ConstraintRow<S>& row = constraints.rows[k];
        row.error += dt * row.velocity(bodies[block.body_a].motion, bodies[block.body_b].motion);
        row.correction = S(0);
      }
    }
    for (std::size_t n = 0; n < island.bodies.size(); ++n) {
      parts_[n].motion = parts_[n].motion + (S(1) / parts) * bodies[island.bodies[n]].motion;
    }
  }

  /// Puts the whole step back: all impulses, the velocities at both ends, the displacement.
  void end_parts(const Island& island, Constraints<S>& constraints,
                 std::span<SolverBody<S>> bodies) {
    for (std::size_t n = 0; n < island.bodies.size(); ++n) {
      SolverBody<S>& body = bodies[island.bodies[n]];
      body.start = parts_[n].start;
      body.free = parts_[n].free;
      body.free_motion = parts_[n].free_motion;
      body.motion = parts_[n].motion;
    }
    if (!island.soft.empty()) return;
    std::size_t r = 0;
    for_each_row(island, constraints,
                 [&](ConstraintRow<S>& row) { row.impulse = row_totals_[r++]; });
    apply_impulses(island, constraints, bodies);
  }

  /// @return Whether there was anything to solve.
  bool place_small(const Island& island, Constraints<S>& constraints,
                   std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                   SolveReport<S>& report) {
    for (const std::uint32_t slot : island.bodies) {
      bodies[slot].motion = mean_motion(bodies[slot], context.integrator);
    }
    for_each_row(island, constraints, [](ConstraintRow<S>& row) { row.correction = S(0); });
    for (const std::uint32_t i : island.contacts) {
      ContactConstraint<S>& c = constraints.contacts[i];
      const S parting = c.restitution > S(0)
                            ? c.normal_velocity(bodies[c.body_a].twist, bodies[c.body_b].twist)
                            : S(0);
      place_contact(c, parting, context);
    }
    move_by_bounces(island, constraints, bodies, context);
    if (!has_position_error(island, constraints, bodies, context)) return false;
    if (!island.blocks.empty()) {
      // Joints must not give way to what they forbid, which sweeps do not see.
      proximal_.place(island, constraints, bodies, context, report);
      return true;
    }
    const S tolerance = context.position_tolerance / context.dt;
    Convergence progress(tolerance, tolerance);
    watch_.start();
    for (int n = 0; n < context.settings.max_position_sweeps; ++n) {
      const S residual =
          sequential_.sweep_positions(island, constraints, bodies, context.dt, n % 2 != 0);
      ++report.position_sweeps;
      if (progress.is_done(residual) &&
          have_settled(island, constraints, bodies, context, motion_of)) {
        break;
      }
      if (progress.is_slow()) {
        proximal_.place(island, constraints, bodies, context, report);
        break;
      }
    }
    return true;
  }

  /// Gives bodies the displacement of bounces, whose share is not the usual one.
  static void move_by_bounces(const Island& island, const Constraints<S>& constraints,
                              std::span<SolverBody<S>> bodies, const SolveContext<S>& context) {
    const S usual = usual_share<S>(context.integrator);
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = constraints.contacts[i];
      if (c.bounce_share < S(0)) continue;
      apply_at_contact<S>(c, (c.bounce_share - usual) * c.impulse_W(), bodies[c.body_a],
                          bodies[c.body_b], motion_of);
    }
  }

  /// Watches a sequence of residuals and tells whether sweeps are worth going on with.
  class Convergence {
   public:
    /// @param first  Residual at which the first sweep is the last; `later` is for the others.
    Convergence(S first, S later) : first_(first), tolerance_(later) {}

    /// Residuals up to `enough` are good enough from now on.
    void accept(S enough) { tolerance_ = std::max(tolerance_, enough); }
    [[nodiscard]] bool is_done(S residual) {
      before_last_ = between_;
      between_ = last_;
      last_ = residual;
      ++count_;
      return residual <= (count_ == 1 ? first_ : tolerance_);
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
    S first_;
    S tolerance_;
    S last_ = infinity<S>;
    S between_ = infinity<S>;
    S before_last_ = infinity<S>;
    int count_ = 0;
  };

  /// Whether the derivatives of the bodies' velocities have settled, or of their displacements.
  template <typename Select>
  [[nodiscard]] bool have_settled(const Island& island, const Constraints<S>& constraints,
                                  std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                                  const Select& select) {
    return watch_.have_settled(context.settings.tolerance, [&](auto& watch) {
      for (const std::uint32_t slot : island.bodies) {
        const Twist<S>& twist = select(bodies[slot]);
        for (const S& x : twist.linear) watch.velocity(x);
        for (const S& x : twist.angular) watch.velocity(x);
      }
      for (const std::uint32_t i : island.contacts) {
        const ContactConstraint<S>& c = constraints.contacts[i];
        const S response =
            bodies[c.body_a].inverse_mass.maxCoeff() + bodies[c.body_b].inverse_mass.maxCoeff();
        for (const S& x : c.impulse) watch.impulse(x, response);
      }
    });
  }

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
  /// @return Whether nothing is left to do.
  bool try_proximal(const Island& island, Constraints<S>& constraints,
                    std::span<SolverBody<S>> bodies, const SolveContext<S>& context, S residual,
                    SolveReport<S>& report) {
    saved_.save(island, constraints);
    const auto left = S(proximal_.solve(island, constraints, bodies, context, report));
    if (left < infinity<S>) {
      apply_impulses(island, constraints, bodies);
      report.residual = left;
      if (left <= S(proximal_.enough())) return true;
      report.residual = sequential_.sweep(island, constraints, bodies, false);
      ++report.sweeps;
      if (report.residual < residual) return report.residual <= context.velocity_tolerance;
    }
    saved_.restore(island, constraints);
    apply_impulses(island, constraints, bodies);
    report.residual = residual;
    return false;
  }

  /// Whether displacements that follow from the velocities leave surfaces overlapping, apart where
  /// they press on each other, or joints open.
  [[nodiscard]] bool has_position_error(const Island& island, const Constraints<S>& constraints,
                                        std::span<const SolverBody<S>> bodies,
                                        const SolveContext<S>& context) const {
    using std::abs;
    // What is closed well enough may have derivatives that are not.
    if constexpr (derivatives_of<S> != 0) return true;
    const S dt = context.dt;
    const S tolerance = context.position_tolerance;
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = constraints.contacts[i];
      if (c.parts) continue;
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
  IslandOrder order_;
  SavedImpulses<S> saved_;
  DerivativeWatch<S> watch_;

  /// The whole step of a body that is solved in parts, and what one part adds to its velocity.
  struct Parts {
    Twist<S> start, free, free_motion, change, motion;
  };
  std::vector<Parts> parts_;
  std::vector<S> row_totals_;  // Impulses of all parts.
};

}  // namespace bristle::inline BRISTLE_ABI
