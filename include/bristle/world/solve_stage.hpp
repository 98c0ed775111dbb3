/// @file
/// Third stage of a step: islands are solved and bodies move.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/direct_solver.hpp>
#include <bristle/dynamics/integrator.hpp>
#include <bristle/dynamics/islands.hpp>
#include <bristle/dynamics/sequential_solver.hpp>
#include <bristle/sensors/passes.hpp>
#include <bristle/world/sensor_stage.hpp>
#include <bristle/world/world_state.hpp>

namespace bristle {

/// Solves every island with the solver that suits it, and integrates.
template <Scalar S, typename Backend>
class SolveStage {
 public:
  using State = WorldState<S, Backend>;

  /// Fills the bodies as the solver sees them: masses, velocities at the start and of free motion.
  void prepare_bodies(State& state) const {
    state.solver_bodies.resize(state.bodies.slot_count());
    for (std::uint32_t i = 0; i < state.bodies.slot_count(); ++i) prepare_body(state, i);
  }

  /// The same for one slot. Bodies asleep are to others like those that forces do not move.
  void prepare_body(State& state, std::uint32_t slot) const {
    SolverBody<S>& out = state.solver_bodies[slot];
    out = SolverBody<S>{};
    if (!state.bodies.is_live(slot) || state.bodies.at(slot).is_asleep()) return;
    const Body<S>& body = state.bodies.at(slot);
    out.start = body.twist;
    if (body.is_dynamic()) {
      const Mat3<S> R = body.center_pose.rotation_matrix();
      out.mass = body.mass;
      out.inverse_mass = body.inverse_mass;
      out.inertia = R * body.inertia_B * R.transpose();
      out.inverse_inertia = R * body.inverse_inertia_B * R.transpose();
    }
    out.free = free_twist(body, out.inverse_inertia, state.def.gravity, state.def.time_step);
    out.twist = out.free;
  }

  /// Finds the velocities at the end of the step, and the position corrections.
  void solve(State& state, const SensorStage<S, Backend>& sensors) {
    for (SolverBody<S>& body : state.solver_bodies) {
      // A force that overflowed must not reach others through the island: the body stops instead.
      if (!is_finite(body.free)) {
        body.free = {};
        ++state.report.frozen_bodies;
      }
      body.twist = body.free;
    }
    state.report.rows = state.constraints.rows.size() + 6 * state.constraints.soft.size();
    if (state.report.rows == 0) return;
    for (const Island& island : islands_.build(state.solver_bodies, state.constraints)) {
      if (island.blocks.empty() && island.soft.empty()) continue;
      ++state.report.islands;
      solve_island(state, sensors, island);
    }
  }

  /// Moves all bodies. A body whose new state is not finite stays where it is, at rest.
  void integrate(State& state) const {
    for (std::uint32_t i = 0; i < state.bodies.slot_count(); ++i) {
      if (!state.bodies.is_live(i)) continue;
      Body<S>& body = state.bodies.at(i);
      body.applied = {};
      if (body.motion == Motion::fixed || body.is_asleep()) continue;
      const Transform<S> start = body.center_pose;
      if (body.is_dynamic()) body.twist = state.solver_bodies[i].twist;
      step_pose(body, state.solver_bodies[i].correction, state.def.time_step);
      if (is_finite(body.twist) && body.center_pose.translation.allFinite() &&
          body.center_pose.rotation.coeffs().allFinite()) {
        continue;
      }
      body.center_pose = start;
      body.twist = {};
      ++state.report.frozen_bodies;
    }
  }

 private:
  [[nodiscard]] static bool is_finite(const Twist<S>& twist) {
    return twist.linear.allFinite() && twist.angular.allFinite();
  }

  [[nodiscard]] SolveContext<S> context_of(const State& state, const Island& island) const {
    using std::abs;
    using std::max;
    SolveContext<S> context;
    context.dt = state.def.time_step;
    context.settings = state.def.solver;
    // What a step changes velocities by: gravity, other forces, and the impulses of the last step.
    S change = state.def.gravity.norm() * context.dt;
    S speed = S(0);
    for (const std::uint32_t slot : island.bodies) {
      const SolverBody<S>& body = state.solver_bodies[slot];
      change = max(change, (body.free.linear - body.start.linear).norm());
      speed = max(speed, body.free.linear.norm());
    }
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      const S mobility = max(state.solver_bodies[block.body_a].inverse_mass,
                             state.solver_bodies[block.body_b].inverse_mass);
      change = max(change, mobility * abs(state.constraints.rows[block.first].impulse));
    }
    // Relative to that, but not below what the arithmetic of the present speed resolves.
    context.velocity_tolerance =
        max(context.settings.tolerance * change, Tolerance<S>::round_off() * speed);
    return context;
  }

  void solve_island(State& state, const SensorStage<S, Backend>& sensors, const Island& island) {
    const SolveContext<S> context = context_of(state, island);
    SolveReport<S> report;
    bool is_direct = DirectSolver<S>::applies_to(island, state.constraints, context.settings);
    const auto solve_once = [&] {
      for (const std::uint32_t soft : island.soft) sensors.fill(state, soft);
      is_direct = is_direct &&
                  direct_.solve(island, state.constraints, state.solver_bodies, context, report);
      if (!is_direct) {
        report.merge(sequential_.solve(island, state.constraints, state.solver_bodies, context));
      }
      for (const std::uint32_t soft : island.soft) sensors.evaluate(state, soft);
    };
    const auto relinearise = [&](int pass, bool is_last_pass) {
      bool has_changed = false;
      for (const std::uint32_t soft : island.soft) {
        has_changed = sensors.relinearise(state, soft, pass, is_last_pass) || has_changed;
      }
      return has_changed;
    };
    solve_in_passes(context.settings.max_passes, solve_once, relinearise);
    rebuild_velocities(state, island);
    for (const std::uint32_t slot : island.bodies) {
      if (is_finite(state.solver_bodies[slot].twist)) continue;
      discard(state, sensors, island);
      return;
    }
    if (needs_correction(state, island, context)) {
      const int sweeps = is_direct ? direct_.correct_positions(island, state.constraints,
                                                               state.solver_bodies, context)
                                   : sequential_.correct_positions(island, state.constraints,
                                                                   state.solver_bodies, context);
      state.report.position_sweeps += static_cast<std::uint64_t>(sweeps);
    }
    state.report.direct_islands += is_direct ? 1 : 0;
    state.report.sweeps += static_cast<std::uint64_t>(report.sweeps);
    state.report.factorisations += static_cast<std::uint64_t>(report.factorisations);
    state.report.residual = std::max(state.report.residual, report.residual);
  }

  /// Velocities as free motion plus all impulses: what sensors, contacts and joints report is then
  /// exactly what moved the bodies, to the round-off of this sum and not of a matrix.
  void rebuild_velocities(State& state, const Island& island) const {
    for (const std::uint32_t slot : island.bodies) {
      state.solver_bodies[slot].twist = state.solver_bodies[slot].free;
    }
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      for (std::uint32_t r = block.first; r < block.first + block.count; ++r) {
        const ConstraintRow<S>& row = state.constraints.rows[r];
        apply_row(row, row.impulse, state.solver_bodies[block.body_a],
                  state.solver_bodies[block.body_b]);
      }
    }
    for (const std::uint32_t s : island.soft) {
      const SoftBlock<S>& soft = state.constraints.soft[s];
      apply_soft(soft, soft.impulse, state.solver_bodies[soft.body_a],
                 state.solver_bodies[soft.body_b]);
    }
  }

  /// Leaves an island to free motion when its solution is not finite, and remembers nothing of it.
  void discard(State& state, const SensorStage<S, Backend>& sensors, const Island& island) const {
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      for (std::uint32_t r = block.first; r < block.first + block.count; ++r) {
        state.constraints.rows[r].impulse = S(0);
      }
    }
    for (const std::uint32_t soft : island.soft) sensors.discard(state, soft);
    rebuild_velocities(state, island);
    ++state.report.discarded_islands;
  }

  [[nodiscard]] bool needs_correction(const State& state, const Island& island,
                                      const SolveContext<S>& context) const {
    using std::abs;
    const S tolerance = context.dt * context.velocity_tolerance;
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      const Twist<S>& a = state.solver_bodies[block.body_a].twist;
      const Twist<S>& b = state.solver_bodies[block.body_b].twist;
      for (std::uint32_t r = block.first; r < block.first + corrected_rows(block); ++r) {
        const ConstraintRow<S>& row = state.constraints.rows[r];
        const S left = row.error + context.dt * row.velocity(a, b);
        if (left < -tolerance || (block.kind == BlockKind::equality && left > tolerance)) {
          return true;
        }
      }
    }
    return false;
  }

  IslandBuilder<S> islands_;
  DirectSolver<S> direct_;
  SequentialSolver<S> sequential_;
};

}  // namespace bristle
