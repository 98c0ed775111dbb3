/// @file
/// Velocities and displacements of one island, with a choice of solvers.
///
/// Resting islands, and those that slide on as before, take one sweep of sequential impulses. The
/// proximal solver takes over where sweeps converge so slowly that factorisations are cheaper. It
/// also solves every small island with sensors, joints or only new contacts. These need their load
/// spread evenly. Large islands are swept, and so are smaller heaps that slide, if sweeps serve.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/contacts/contact_target.hpp>
#include <bristle/dynamics/contacts/saved_impulses.hpp>
#include <bristle/dynamics/solver/derivative_watch.hpp>
#include <bristle/dynamics/solver/island_energy.hpp>
#include <bristle/dynamics/solver/method_choice.hpp>
#include <bristle/dynamics/solver/proximal_solver.hpp>
#include <bristle/dynamics/solver/sequential_solver.hpp>
#include <bristle/dynamics/solver/solver_constants.hpp>
#include <bristle/dynamics/solver/sweep_convergence.hpp>

#include <algorithm>
#include <cmath>

namespace bristle::inline BRISTLE_ABI::detail {

/// The choice with its scratch memory. One object serves many islands in turn.
template <Scalar S>
class IslandSolver {
 public:
  /// Finds the impulses of all constraints and the velocities at the end of the step. Starts from a
  /// warm start.
  /// @param context  `is_swept` is false afterwards if a heap that slides was solved otherwise.
  void solve(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
             SolveContext<S>& context, SolveReport<S>& report) {
    if (context.is_large()) {
      solve_large(island, constraints, bodies, context, report);
      return;
    }
    if (context.is_swept) {
      saved_.save(island, constraints);
      context.is_swept = !goes_on(island, constraints, bodies, context, report);
      if (!context.is_swept) return;
      saved_.restore(island, constraints);
      if (sweep_sliding(island, constraints, bodies, context, report)) return;
      saved_.restore(island, constraints);
      context.is_swept = false;
    }
    target(island, constraints, bodies, context);
    solve_small(island, constraints, bodies, context, report);
  }

  /// Finds the displacements of the step from solved velocities. In a quiet step they follow from
  /// the velocities. Nothing is solved then.
  ///
  /// @return True if the velocities are to be solved anew (`open_contacts`).
  bool place(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
             const SolveContext<S>& context, SolveReport<S>& report) {
    if (!context.is_swept) {
      return place_small(island, constraints, bodies, context, report) &&
             context.integrator == Integrator::trapezoidal &&
             open_contacts<S>(island, constraints, bodies, context);
    }
    if (!island.soft.empty()) {
      // Other islands are placed substep by substep as they are solved.
      const int most = context.settings.max_position_sweeps;
      place_part(island, constraints, bodies, context, {most, most},
                 S(chosen::swept_position_share) * report.residual, report);
    }
    return false;
  }

 private:
  /// [-] Sweeps that run unless the problem is solved, and how many there may be if more pay.
  struct SweepCount {
    int least, most;

    [[nodiscard]] static SweepCount half_of(int most) { return {(most + 1) / 2, most}; }
  };

  /// Returns whether one sweep solves an island from the warm start: it moves on as before.
  [[nodiscard]] bool goes_on(const Island& island, Constraints<S>& constraints,
                             std::span<SolverBody<S>> bodies, SolveContext<S> context,
                             SolveReport<S>& report) {
    context.is_swept = false;
    target(island, constraints, bodies, context);
    sequential_.start(island, constraints, bodies);
    report.residual = sequential_.sweep(island, constraints, bodies, false);
    ++report.sweeps;
    return report.residual <= context.velocity_tolerance;
  }

  static void target(const Island& island, Constraints<S>& constraints,
                     std::span<const SolverBody<S>> bodies, const SolveContext<S>& context) {
    for (const std::uint32_t i : island.contacts) {
      ContactConstraint<S>& c = constraints.contacts[i];
      target_contact(c, bodies[c.body_a], bodies[c.body_b], context);
    }
  }

  void solve_small(const Island& island, Constraints<S>& constraints,
                   std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                   SolveReport<S>& report) {
    bool may_factor = island.soft.empty();
    const bool needs_even = needs_even_load(island, constraints);
    if (!needs_even) warm_start_.save(island, constraints);
    sequential_.start(island, constraints, bodies);
    if (needs_even) {
      // A second solve from where sweeps have led finds some of what the first did not.
      may_factor = may_factor && context.is_cheap();
      report.residual = S(proximal_.solve(island, constraints, bodies, context, report));
      apply_impulses(island, constraints, bodies);
      if (report.residual <= S(proximal_.enough())) return;
      // Sweeps repair the rest. The impulses of an iteration that was cut short are not consistent.
      // Their velocities do not satisfy joints and contacts.
    }
    // A residual that needs more than one sweep is brought well below the tolerance. Just below it,
    // it would come up again in the next step.
    SweepConvergence<S> progress(context.velocity_tolerance,
                                 S(chosen::later_sweep_share) * context.velocity_tolerance);
    watch_.start();
    int most_sweeps = may_factor ? context.settings.max_sweeps : most_repairs(context);
    for (int n = 0; n < most_sweeps; ++n) {
      const S residual = sequential_.sweep(island, constraints, bodies, n % 2 != 0);
      ++report.sweeps;
      report.residual = residual;
      if (progress.is_done(residual) &&
          have_settled(island, constraints, bodies, context, velocity_of)) {
        break;
      }
      if (may_factor && progress.is_slow()) {
        may_factor = false;
        saved_.save(island, constraints);
        if (!needs_even) start_where_held(island, constraints, bodies, context);
        if (try_proximal(island, constraints, bodies, context, residual, report)) return;
        progress.accept(S(proximal_.enough()));
        most_sweeps = std::min(most_sweeps, n + 1 + most_repairs(context));
      }
    }
    if (report.residual > context.velocity_tolerance && has_gained_energy(island, bodies)) {
      sweep_from_nothing(island, constraints, bodies, context, report);
    }
  }

  /// Goes back from swept impulses, which are saved, to the warm start of an island that is held.
  /// It is nearer to the solution. Sweeps put the load on single points, which then slide.
  void start_where_held(const Island& island, Constraints<S>& constraints,
                        std::span<SolverBody<S>> bodies, const SolveContext<S>& context) {
    warm_start_.restore(island, constraints);
    if (is_held<S>(island, constraints, bodies, context)) {
      apply_impulses(island, constraints, bodies);
    } else {
      saved_.restore(island, constraints);
    }
  }

  /// [-] Sweeps that may repair a result of factorisations.
  [[nodiscard]] static int most_repairs(const SolveContext<S>& context) {
    const SolverDef<S>& settings = context.settings;
    return context.is_cheap()
               ? settings.max_sweeps
               : std::min(settings.max_sweeps, SweepCount::half_of(settings.large_sweeps).least);
  }

  /// Returns whether the kinetic energy exceeds that at the start and that of free motion.
  [[nodiscard]] static bool has_gained_energy(const Island& island,
                                              std::span<const SolverBody<S>> bodies) {
    const IslandEnergy<S> energy = energy_of<S>(island, bodies);
    return energy.found > energy.start && energy.found > energy.free;
  }

  /// Sweeps an island that did not converge once more, without a warm start. Keeps the result with
  /// the smaller residual. From zero each update takes energy out of the island. It does not matter
  /// where the sweeps end. A warm start may bring in any amount of energy. Its impulses may be from
  /// a diverged iteration, or from a step before an impact.
  void sweep_from_nothing(const Island& island, Constraints<S>& constraints,
                          std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                          SolveReport<S>& report) {
    saved_.save(island, constraints);
    clear_impulses(island, constraints);
    sequential_.start(island, constraints, bodies);
    S residual = infinity<S>;
    watch_.start();
    const int most_sweeps = most_repairs(context);
    for (int n = 0; n < most_sweeps; ++n) {
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

  /// Sweeps a heap that slides (`MethodChoice`) over one substep.
  ///
  /// @return True if the result serves. Newton's method takes over where sweeps have nearly found
  ///         the solution. It needs a step or two, and a steady slide then takes one sweep. Where
  ///         the heap is hit, Newton's method takes many and does not find the solution.
  bool sweep_sliding(const Island& island, Constraints<S>& constraints,
                     std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                     SolveReport<S>& report) {
    const S near = std::max(context.velocity_tolerance,
                            S(chosen::newton_takes_over_share) * context.speed_change);
    const SolverDef<S>& settings = context.settings;
    sequential_.start_manifolds(island, constraints, bodies, S(1));
    sequential_.start_part(island, constraints, bodies, context);
    const int affordable = context.affordable_sweeps(island);
    const int most = std::max(settings.large_sweeps, sliding_sweeps(affordable, settings));
    sweep_until(context.fast(), {settings.large_sweeps, most}, island, constraints, bodies, context,
                report);
    if (report.residual <= near) return false;
    sequential_.finish(island, bodies);
    if (has_made_energy(island, bodies, context, report)) {
      sequential_.forget_impulses();
      clear_impulses(island, constraints);
      sequential_.start_part(island, constraints, bodies, context);
      sweep_until(near, {0, most}, island, constraints, bodies, context, report);
      sequential_.finish(island, bodies);
    }
    sequential_.keep_impulses();
    // Velocities are left far from their laws. Overlaps are small beside the motion by forces.
    const S enough = std::min(S(chosen::swept_position_share) * report.residual,
                              S(chosen::sliding_overlap_share) * context.speed_change);
    place_part(island, constraints, bodies, context, {affordable, affordable}, enough, report);
    sequential_.finish_parts(island, constraints);
    sequential_.find_velocities(island, constraints, bodies);
    return true;
  }

  /// [-] Sweeps of the velocities of a heap that slides. Positions, which sweeps find, have more of
  /// the budget.
  [[nodiscard]] static int sliding_sweeps(int affordable, const SolverDef<S>& settings) {
    return std::min(settings.max_sweeps, affordable / chosen::sliding_velocity_divisor);
  }

  /// Solves a large island by few sweeps. Its substeps are short enough for them. Gaps follow the
  /// motion from substep to substep. Arms and normals stay.
  void solve_large(const Island& island, Constraints<S>& constraints,
                   std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                   SolveReport<S>& report) {
    // Soft blocks are linearised over the whole step.
    const int count = island.soft.empty() ? context.part_count() : 1;
    const S parts = S(count);
    SolveContext<S> part = context.part(parts);
    begin_parts(island, constraints, bodies, parts);
    sequential_.start_manifolds(island, constraints, bodies, parts);
    const SolverDef<S>& settings = context.settings;
    SweepCount sweeps = SweepCount::half_of(settings.large_sweeps);
    SweepCount placings = SweepCount::half_of(settings.large_position_sweeps);
    if (context.slides) {
      const int affordable = context.affordable_sweeps(island) / count;
      sweeps.most = sliding_sweeps(affordable, settings);
      placings.least = placings.most = std::max(placings.most, affordable);
    }
    if (sequential_.is_cold()) sweeps = {settings.max_sweeps, settings.max_sweeps};
    for (int k = 0; k < count; ++k) {
      for (std::size_t n = 0; n < island.bodies.size(); ++n) {
        SolverBody<S>& body = bodies[island.bodies[n]];
        body.start = k > 0 ? body.twist : body.start;
        body.free = body.kept_start() + parts_[n].change;
        body.mean_free = mean_free_velocity(body, context.integrator);
      }
      sweep_part(island, constraints, bodies, part, sweeps, report);
      if (has_made_energy(island, bodies, part, report)) {
        sequential_.forget_impulses();
        clear_impulses(island, constraints);
        sweep_part(island, constraints, bodies, part, sweeps, report);
      }
      sequential_.keep_impulses();
      if (!island.soft.empty()) break;  // Placed when their sensors have settled.
      // Positions need no more digits than velocities have.
      place_part(island, constraints, bodies, part, placings,
                 S(chosen::swept_position_share) * report.residual, report);
      if (k + 1 < count) sequential_.move_on(bodies, part.dt);
      end_part(island, constraints, bodies, part.dt, parts);
    }
    sequential_.finish_parts(island, constraints);
    end_parts(island, constraints, bodies);
    scale_bounds(island, constraints, parts);
  }

  /// Finds the velocities at the end of a substep.
  void sweep_part(const Island& island, Constraints<S>& constraints,
                  std::span<SolverBody<S>> bodies, const SolveContext<S>& part, SweepCount count,
                  SolveReport<S>& report) {
    sequential_.start_part(island, constraints, bodies, part);
    if (part.slides) {
      sweep_until(part.fast(), count, island, constraints, bodies, part, report);
    } else {
      sweep_while_it_pays(SweptProblem::velocities, count, [&](bool backwards) {
        return sweep_velocities(backwards, island, constraints, bodies, part, report);
      });
    }
    sequential_.finish(island, bodies);
  }

  /// @return True if the velocities are found.
  bool sweep_velocities(bool backwards, const Island& island, Constraints<S>& constraints,
                        std::span<SolverBody<S>> bodies, const SolveContext<S>& part,
                        SolveReport<S>& report) {
    report.residual = sequential_.sweep(island, constraints, bodies, backwards);
    ++report.sweeps;
    return report.residual <= part.velocity_tolerance;
  }

  /// Sweeps the velocities of a heap that slides until a sweep changes them by `enough` at most.
  /// They are not extrapolated: where surfaces slide, no energy becomes the least.
  void sweep_until(S enough, SweepCount count, const Island& island, Constraints<S>& constraints,
                   std::span<SolverBody<S>> bodies, const SolveContext<S>& part,
                   SolveReport<S>& report) {
    for (int n = 0; n < count.least || (n < count.most && report.residual > enough); ++n) {
      if (sweep_velocities(n % 2 != 0, island, constraints, bodies, part, report)) return;
    }
  }

  /// Sweeps there and back in turn until the problem is solved, or as often as `count` says. Where
  /// extrapolating gains nothing, contacts open or slide. Many more sweeps would gain little there.
  /// @param sweep  sweep(backwards) returns whether the problem is solved.
  template <typename Sweep>
  void sweep_while_it_pays(SweptProblem problem, SweepCount count, const Sweep& sweep) {
    sequential_.start_extrapolation(problem);
    bool gains = false;
    for (int n = 0; n < count.least || gains; ++n) {
      const bool backwards = n % 2 != 0;
      if (sweep(backwards)) return;
      // Two more sweeps follow, as an extrapolation may violate the laws of contacts.
      if (backwards) gains = n + 2 < count.most && sequential_.extrapolate(problem);
    }
  }

  /// Returns whether sweeps that were cut short brought in energy of their warm start: of impulses
  /// that piled up between bodies that cannot separate, or of an impact in the last step. Sweeps
  /// from no impulses bring none into what slides (`sweep_from_nothing`), and find what movers
  /// give. Bounces, motors and sensors of other islands give energy, too, but hardly double it.
  [[nodiscard]] static bool has_made_energy(const Island& island,
                                            std::span<const SolverBody<S>> bodies,
                                            const SolveContext<S>& context,
                                            const SolveReport<S>& report) {
    const IslandEnergy<S> energy = energy_of<S>(island, bodies);
    const S available = std::max(energy.start, energy.free);
    if (!context.slides) return energy.found > S(chosen::suspicious_energy_growth) * available;
    return report.residual > context.fast() && energy.found > available;
  }

  /// Stores the whole step of each body. Scales the warm start of rows to a substep.
  void begin_parts(const Island& island, Constraints<S>& constraints,
                   std::span<SolverBody<S>> bodies, S parts) {
    parts_.resize(std::max(parts_.size(), island.bodies.size()));
    for (std::size_t n = 0; n < island.bodies.size(); ++n) {
      SolverBody<S>& body = bodies[island.bodies[n]];
      parts_[n].start = body.start;
      parts_[n].free = body.free;
      parts_[n].mean_free = body.mean_free;
      parts_[n].kept_linear = body.kept_linear;
      parts_[n].kept_angular = body.kept_angular;
      const Twist<S> by_forces = body.free - body.kept_start();
      parts_[n].change = {take_part(body.kept_linear, parts) * by_forces.linear,
                          take_part(body.kept_angular, parts) * by_forces.angular};
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

  /// Reduces what damping keeps in a step to what it keeps in a substep.
  /// @return  [1] Share of the change by forces that each substep adds. Together, decayed from each
  ///          one on, they make up that of the step.
  [[nodiscard]] static S take_part(S& kept, S parts) {
    using std::pow;
    const S whole = kept;
    if (!(whole < S(1))) {
      kept = S(1) + (whole - S(1)) / parts;
      return S(1) / parts;
    }
    kept = pow(whole, S(1) / parts);
    return (S(1) - kept) / (S(1) - whole);
  }

  /// Scales the bounds of motors and of rolling friction to a substep, or back.
  static void scale_bounds(const Island& island, Constraints<S>& constraints, S scale) {
    for (const std::uint32_t i : island.blocks) {
      ConstraintBlock<S>& block = constraints.blocks[i];
      if (block.kind != BlockKind::bounded) continue;
      block.lower *= scale;
      block.upper *= scale;
    }
  }

  /// Solves the position problem of a substep by sweeps. It is convex, so sweeps and extrapolation
  /// find its solution.
  /// @param enough  [m/s] Residual at which it is solved.
  void place_part(const Island& island, Constraints<S>& constraints,
                  std::span<SolverBody<S>> bodies, const SolveContext<S>& part, SweepCount count,
                  S enough, SolveReport<S>& report) {
    enough = std::max(enough, part.position_tolerance / part.dt);
    for (const std::uint32_t slot : island.bodies) {
      bodies[slot].motion = mean_motion(bodies[slot], part.integrator);
    }
    sequential_.start_positions(island, bodies, part);
    sweep_while_it_pays(SweptProblem::positions, count, [&](bool backwards) {
      ++report.position_sweeps;
      return sequential_.sweep_positions(island, constraints, bodies, part.dt, backwards) <= enough;
    });
    sequential_.finish_positions(island, constraints, bodies);
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

  /// Restores the whole step: all impulses, the velocities at both ends, the displacement.
  void end_parts(const Island& island, Constraints<S>& constraints,
                 std::span<SolverBody<S>> bodies) {
    for (std::size_t n = 0; n < island.bodies.size(); ++n) {
      SolverBody<S>& body = bodies[island.bodies[n]];
      body.start = parts_[n].start;
      body.free = parts_[n].free;
      body.mean_free = parts_[n].mean_free;
      body.motion = parts_[n].motion;
      body.kept_linear = parts_[n].kept_linear;
      body.kept_angular = parts_[n].kept_angular;
    }
    if (!island.soft.empty()) return;
    std::size_t r = 0;
    for_each_row(island, constraints,
                 [&](ConstraintRow<S>& row) { row.impulse = row_totals_[r++]; });
    sequential_.find_velocities(island, constraints, bodies);
  }

  /// @return True if there was anything to solve.
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
      set_position_impulse(c, parting, context);
      c.position_excess = S(0);
    }
    move_by_restitution(island, constraints, bodies, context);
    if (!has_position_error(island, constraints, bodies, context)) return false;
    if (has_joints(island, constraints)) {
      // Joints must not yield along their locked axes. Sweeps do not ensure that.
      proximal_.place(island, constraints, bodies, context, report);
      return true;
    }
    const S tolerance = context.position_tolerance / context.dt;
    SweepConvergence<S> progress(tolerance, tolerance);
    bool may_factor = true;
    watch_.start();
    for (int n = 0; n < context.settings.max_position_sweeps; ++n) {
      const S residual =
          sequential_.sweep_positions(island, constraints, bodies, context.dt, n % 2 != 0);
      ++report.position_sweeps;
      if (progress.is_done(residual) &&
          have_settled(island, constraints, bodies, context, motion_of)) {
        break;
      }
      if (may_factor && progress.is_slow()) {
        may_factor = false;
        if (S(proximal_.place(island, constraints, bodies, context, report)) < infinity<S>) break;
      }
    }
    return true;
  }

  /// Adds the displacements of bounces. Their share is not the usual one.
  static void move_by_restitution(const Island& island, const Constraints<S>& constraints,
                                  std::span<SolverBody<S>> bodies, const SolveContext<S>& context) {
    const S usual = usual_share<S>(context.integrator);
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = constraints.contacts[i];
      if (c.restitution_share < S(0)) continue;
      apply_at_contact<S>(c, (c.restitution_share - usual) * c.impulse_W(), bodies[c.body_a],
                          bodies[c.body_b], motion_of);
    }
  }

  /// Returns whether the derivatives of the bodies' velocities, or displacements, have settled.
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

  /// Solves by factorisation. Keeps the result if it is exact. Also keeps it if a sweep then finds
  /// a smaller residual than that of the saved impulses.
  /// @param residual  [m/s] Residual of the impulses that are in `saved_`.
  /// @return True if nothing is left to do.
  bool try_proximal(const Island& island, Constraints<S>& constraints,
                    std::span<SolverBody<S>> bodies, const SolveContext<S>& context, S residual,
                    SolveReport<S>& report) {
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

  /// Returns whether displacements by the velocities leave a position error. Surfaces overlap,
  /// loaded surfaces are apart, or joints are open.
  [[nodiscard]] bool has_position_error(const Island& island, const Constraints<S>& constraints,
                                        std::span<const SolverBody<S>> bodies,
                                        const SolveContext<S>& context) const {
    using std::abs;
    // Values that have converged may have derivatives that have not.
    if constexpr (derivatives_of<S> != 0) return true;
    const S dt = context.dt;
    const S tolerance = context.position_tolerance;
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = constraints.contacts[i];
      if (c.is_separating) continue;
      const S left =
          c.gap + dt * c.normal_velocity(bodies[c.body_a].motion, bodies[c.body_b].motion);
      if (left < -tolerance || (left > tolerance && c.position_impulse > c.least_position_impulse))
        return true;
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
  SavedImpulses<S> saved_, warm_start_;
  DerivativeWatch<S> watch_;

  /// Whole step of a body that is solved in substeps. Velocity change of one substep.
  struct Parts {
    Twist<S> start, free, mean_free, change, motion;
    S kept_linear, kept_angular;
  };
  DynamicArray<Parts> parts_;
  DynamicArray<S> row_totals_;  // Impulses of all substeps.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
