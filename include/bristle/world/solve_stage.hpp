/// @file
/// Third stage: islands are solved and bodies move.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/integrator.hpp>
#include <bristle/dynamics/bodies/islands.hpp>
#include <bristle/dynamics/contacts/contact_target.hpp>
#include <bristle/dynamics/contacts/passive_restitution.hpp>
#include <bristle/dynamics/solver/crushing_limit.hpp>
#include <bristle/dynamics/solver/guarded_sweeps.hpp>
#include <bristle/dynamics/solver/island_solver.hpp>
#include <bristle/dynamics/solver/method_choice.hpp>
#include <bristle/sensors/solve_passes.hpp>
#include <bristle/world/joint_stage.hpp>
#include <bristle/world/sensor_stage.hpp>
#include <bristle/world/world_constants.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <array>

namespace bristle::inline BRISTLE_ABI::detail {

/// Solves every island with its best solver, and integrates.
template <Scalar S>
class SolveStage {
 public:
  using State = WorldState<S>;

  /// Fills the solver bodies: masses, initial and free velocities.
  void prepare_bodies(State& state) {
    has_movers_ = false;
    state.solver_bodies.resize(state.bodies.slot_count());
    for (std::uint32_t i = 0; i < state.bodies.slot_count(); ++i) prepare_body(state, i);
  }

  /// Fills the mass properties of a solver body. Only bodies under forces or impulses need them.
  static void prepare_mass(State& state, std::uint32_t slot) {
    SolverBody<S>& out = state.solver_bodies[slot];
    if (!out.moves) return;
    const Body<S>& body = state.bodies.at(slot);
    out.mass = body.mass;
    out.inverse_mass = body.inverse_mass_W();
    const std::array<bool, 3>& locked = body.locked.angular;
    out.turns = !(locked[0] && locked[1] && locked[2]);
    out.is_isotropic = !body.locked.any_angular() && is_isotropic(body.inertia_B);
    if (out.is_isotropic) {
      out.inertia = body.inertia_B;
      out.inverse_inertia = body.inverse_inertia_B;
      return;
    }
    const Mat3<S> R = body.center_pose.rotation_matrix();
    out.inertia = rotated<S>(R, body.inertia_B);
    out.inverse_inertia = out.turns ? body.inverse_inertia_W(R) : zero<Mat3<S>>();
  }

  /// The same for one body. To others, a sleeping body is like one that forces do not move.
  void prepare_body(State& state, std::uint32_t slot) {
    SolverBody<S>& out = state.solver_bodies[slot];
    const bool is_awake = state.bodies.is_live(slot) && !state.bodies.at(slot).is_asleep();
    const bool moves = is_awake && state.bodies.at(slot).moves();
    // Moving bodies get their masses where they are needed; all others must have none.
    if (!moves) out = SolverBody<S>{};
    if (!is_awake) return;
    const Body<S>& body = state.bodies.at(slot);
    out.moves = moves;
    out.is_sensed = out.follows_joints = false;
    out.start = body.twist;
    const BodyDecay<S> decay = decay_of(body, state.def.time_step);
    out.kept_linear = decay.linear.kept;
    out.kept_angular = decay.angular.kept;
    // Sensors need the masses of their bodies early.
    if (state.patches.size() > 0) prepare_mass(state, slot);
    out.free = free_twist(body, state.def.gravity, decay);
    start_from_free(state, out);
    has_movers_ = has_movers_ || (!moves && has_motion(out.free));
  }

  /// Finds the velocities at the end of the step, and the position corrections.
  /// @param joints  Null in a world that never had a joint.
  void solve(State& state, SensorStage<S>& sensors, JointStage<S>* joints) {
    // Explicit sensors have acted on bodies since.
    if (state.report.explicit_pairs > 0) {
      for (SolverBody<S>& body : state.solver_bodies) {
        if (body.is_sensed) start_from_free(state, body);
      }
    }
    state.report.rows = 3 * state.constraints.contacts.size() + state.constraints.rows.size() +
                        6 * state.constraints.soft.size();
    if (state.report.rows == 0) return;
    for (const Island& island : islands_.build(state.solver_bodies, state.constraints)) {
      if (island.contacts.empty() && island.blocks.empty() && island.soft.empty()) continue;
      if (state.patches.size() == 0) {
        for (const std::uint32_t slot : island.bodies) prepare_mass(state, slot);
      }
      ++state.report.islands;
      solve_island(state, sensors, joints, island);
    }
  }

  /// Moves all bodies. If a step cannot start from a body's new state, the body keeps its pose, at
  /// rest.
  /// @param joints  As in `solve`.
  void integrate(State& state, const JointStage<S>* joints) const {
    for (const std::uint32_t i : state.bodies.live_slots()) {
      Body<S>& body = state.bodies.at(i);
      body.applied = {};
      if (body.motion == Motion::fixed || body.is_asleep()) continue;
      const Transform<S> start = body.center_pose;
      const SolverBody<S>& solved = state.solver_bodies[i];
      if (body.is_dynamic()) {
        body.twist = solved.twist;
        ++state.report.awake_bodies;  // Unless it falls asleep in this step.
      }
      if (solved.follows_joints) {
        joints->move(body, solved, i, state.def.time_step);
      } else {
        step_pose(body, solved.motion, state.def.time_step);
      }
      if (has_finite_square<S>(body.twist) && is_pose(body.center_pose)) continue;
      body.center_pose = start;
      body.twist = {};
      ++state.report.frozen_bodies;
    }
  }

 private:
  /// Sets the unconstrained motion of a body, once its free velocity is known.
  static void start_from_free(State& state, SolverBody<S>& body) {
    // An overflowed force must not spread: the body stops.
    if (!has_finite_square<S>(body.free)) {
      body.free = {};
      ++state.report.frozen_bodies;
    }
    body.twist = body.free;
    body.motion = body.mean_free = mean_free_velocity(body, integrator_of(state, body));
  }

  [[nodiscard]] static Integrator integrator_of(const State& state, const SolverBody<S>& body) {
    return body.is_sensed || !body.is_moving() ? Integrator::symplectic_euler
                                               : state.def.integrator;
  }

  [[nodiscard]] SolveContext<S> context_of(const State& state, const Island& island) const {
    using std::abs;
    using std::max;
    using std::sqrt;
    SolveContext<S> context;
    context.dt = state.def.time_step;
    context.settings = state.def.solver;
    context.restitution_speed = state.def.restitution_speed;
    context.integrator = island.soft.empty() ? state.def.integrator : Integrator::symplectic_euler;
    // Velocity change of a step: by gravity, other forces, and the impulses of the last step.
    S change = state.def.gravity.norm() * context.dt;
    S change2 = S(0);
    S speed2 = S(0);
    S extent = S(0);
    for (const std::uint32_t slot : island.bodies) {
      const SolverBody<S>& body = state.solver_bodies[slot];
      change2 = max(change2, (body.free.linear - body.start.linear).squaredNorm());
      speed2 = max(speed2, body.free.linear.squaredNorm());
      extent = max(extent, cwise_abs(state.bodies.at(slot).center_pose.translation).maxCoeff());
      if (body.is_sensed) context.integrator = Integrator::symplectic_euler;
    }
    change = max(change, sqrt(change2));
    context.speed_change = context.driven_change = change;
    std::uint32_t last_a = 0;
    std::uint32_t last_b = 0;
    S mobility = S(0);
    const auto add_impulse = [&](std::uint32_t slot_a, std::uint32_t slot_b, S impulse) {
      // The points of a manifold are consecutive.
      if (slot_a != last_a || slot_b != last_b) {
        mobility = max(state.solver_bodies[slot_a].inverse_mass.maxCoeff(),
                       state.solver_bodies[slot_b].inverse_mass.maxCoeff());
        last_a = slot_a;
        last_b = slot_b;
      }
      change = max(change, mobility * abs(impulse));
    };
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = state.constraints.contacts[i];
      add_impulse(c.body_a, c.body_b, c.impulse[0]);
    }
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      // Rolling friction drives nothing: it only resists.
      if (!block.is_of_joint()) continue;
      add_impulse(block.body_a, block.body_b, state.constraints.rows[block.first].impulse);
      // Motors and limits decide on the velocity at the end of a step as if it had lasted all step.
      // With the mean of two velocities they would overshoot.
      if (block.kind == BlockKind::equality) continue;
      context.integrator = Integrator::symplectic_euler;
      // A motor may act where nothing else does: a hand that closes before it is loaded. Limits
      // only react.
      if (!(block.upper < infinity<S>) || !(block.lower > -infinity<S>)) continue;
      const ConstraintRow<S>& row = state.constraints.rows[block.first];
      const S response =
          row_response(row, state.solver_bodies[block.body_a], state.solver_bodies[block.body_b]);
      context.driven_change = max(context.driven_change, response * abs(row.impulse));
    }
    // Relative to that change, but not below the resolution of the present state.
    context.velocity_tolerance = max(context.settings.tolerance * context.driven_change,
                                     Tolerance<S>::round_off() * max(sqrt(speed2), change));
    // Where nothing moved or pressed before, as in a hand that begins to close, nothing gives a
    // scale. A speed is none there that moves no body by more than round-off within the step.
    if (!(context.velocity_tolerance > S(0))) {
      context.velocity_tolerance = Tolerance<S>::round_off() * extent / context.dt;
    }
    context.position_tolerance =
        max(context.settings.position_tolerance * context.dt * context.speed_change,
            Tolerance<S>::round_off() * extent);
    return context;
  }

  void solve_island(State& state, SensorStage<S>& sensors, JointStage<S>* joints, Island island) {
    SolveContext<S> context = context_of(state, island);
    Constraints<S>& constraints = state.constraints;
    std::span<SolverBody<S>> bodies = state.solver_bodies;
    choice_.make(island, constraints, bodies, context);
    if (joints != nullptr && joints->follow(state, island, context)) {
      // A mechanism without contacts is solved. Its springs are done, too.
      if (island.contacts.empty()) return;
      island.soft = {};
      context.integrator = Integrator::trapezoidal;
    } else if (context.integrator == Integrator::symplectic_euler) {
      for (const std::uint32_t slot : island.bodies) bodies[slot].mean_free = bodies[slot].free;
    }
    time_contacts(state, island, context);
    if (joints != nullptr) joints->time_rows(state, island, context);
    SolveReport<S> report;
    const std::span<const std::uint32_t> sensed = sensors.of_patches(island.soft);
    const auto solve_once = [&] {
      for (const std::uint32_t soft : sensed) sensors.fill(state, soft);
      if (has_movers_) limit_crushing<S>(island, constraints, bodies);
      solver_.solve(island, constraints, bodies, context, report);
    };
    const auto answer = [&](const SolvePass& pass) {
      bool has_changed = false;
      // Backwards: the patch sensed last is still in cache, and the first one is read first.
      for (std::size_t k = sensed.size(); k-- > 0;) {
        has_changed = sensors.answer(state, sensed[k], pass) || has_changed;
      }
      return has_changed;
    };
    const S position_tolerance = context.position_tolerance;
    // The displacements tell which contacts cannot press.
    for (int pass = 1;; ++pass) {
      solve_in_passes(context.settings.max_passes, solve_once, answer);
      // The impulse of the sensors is the sum of their evaluated impulses.
      if (!island.soft.empty()) apply_impulses(island, constraints, bodies);
      restitution_.limit_energy(island, constraints, bodies, context, solver_, report);
      if (!(report.residual < infinity<S>) || !is_finite(state, island)) {
        guard(state, sensors, island, context);
        return;
      }
      // Positions need no more digits than velocities have.
      const S most = S(chosen::position_residual_share * std::min(1.0, context.cost_share())) *
                     context.speed_change;
      context.position_tolerance =
          std::max(position_tolerance, context.dt * std::min(report.residual, most));
      if (!solver_.place(island, constraints, bodies, context, report)) break;
      if (pass >= context.settings.max_passes) break;
    }
    if (!context.is_large()) limit_turns(state, island, context);
    if (context.integrator == Integrator::trapezoidal) keep_angular_momentum(state, island);
    if (joints != nullptr) joints->close_wide_gaps(state, island);
    state.report.position_sweeps += static_cast<std::uint64_t>(report.position_sweeps);
    state.report.direct_islands += report.factorisations > 0 ? 1 : 0;
    state.report.sweeps += static_cast<std::uint64_t>(report.sweeps);
    state.report.factorisations += static_cast<std::uint64_t>(report.factorisations);
    state.report.residual = std::max(state.report.residual, report.residual);
    state.report.capped_islands += report.residual > context.velocity_tolerance ? 1u : 0u;
  }

  /// Moves contacts to the instants at which their impulses act.
  static void time_contacts(State& state, const Island& island, const SolveContext<S>& context) {
    using std::max;
    // An arm r of a turning body leaves an error of h w^2 r / 2 at most. Below the velocity
    // tolerance it is not corrected.
    const S least = S(2) * context.velocity_tolerance / context.dt;
    const S most = far_turn(context.dt);
    for (std::size_t k = 0; k < island.contacts.size();) {
      const ContactConstraint<S>& first = state.constraints.contacts[island.contacts[k]];
      const SolverBody<S>& a = state.solver_bodies[first.body_a];
      const SolverBody<S>& b = state.solver_bodies[first.body_b];
      const S w2 = max(a.start.angular.squaredNorm(), b.start.angular.squaredNorm());
      const S reach2 = max(first.arm_a.squaredNorm(), first.arm_b.squaredNorm());
      const bool moves_arms = w2 * w2 * reach2 > least * least && w2 <= most * most;
      const std::size_t begin = k;
      // The split of a manifold's impulse among its points is not unique. Its sum is.
      std::array<S, 3> impulse{};
      for (; k < island.contacts.size(); ++k) {
        const ContactConstraint<S>& c = state.constraints.contacts[island.contacts[k]];
        if (!are_of_one_manifold(first, c)) break;
        if (!moves_arms) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) impulse[axis] += c.impulse[axis];
      }
      if (!moves_arms) continue;
      const S hold = hold_of(impulse, first.friction);
      if (!(hold > S(0))) continue;
      for (std::size_t n = begin; n < k; ++n) {
        ContactConstraint<S>& c = state.constraints.contacts[island.contacts[n]];
        CachedPoint<S>& point = state.contacts.points()[c.point];
        state.contacts.find_mid_offsets(point);
        time_contact(c, point, hold, a, b, context);
      }
    }
  }

  /// Bounds how far the position corrections of an island turn a body: by half a radian. They are
  /// solved along the directions of the start of the step, which mean nothing beyond that. They
  /// have no bound where a body is hit far from its centre, where a light link stands across its
  /// chain, or where bodies that interlock are pushed apart both ways; and such a body pushes
  /// others just as far.
  ///
  /// Corrections then start from the motion in which all impulses move the bodies by one share
  /// (`share_apart`). It keeps surfaces apart, and so does what lies between it and the solved
  /// motion. By the usual share a fast body would pass through a wall by half of its way.
  static void limit_turns(State& state, const Island& island, const SolveContext<S>& context) {
    using std::sqrt;
    const S most = far_turn(context.dt);
    S share = usual_share<S>(context.integrator);
    if (!(fastest_turn2(state, island, share) > most * most)) return;
    share = share_apart(state, island, context, share);
    const S turn2 = fastest_turn2(state, island, share);
    if (!(turn2 > most * most)) return;
    const S part = most / sqrt(turn2);
    for (const std::uint32_t slot : island.bodies) {
      SolverBody<S>& body = state.solver_bodies[slot];
      const Twist<S> start = motion_by(body, share);
      body.motion = start + part * (body.motion - start);
    }
  }
  /// [rad^2/s^2] Square of the fastest turn in an island that corrections add to the motion in
  /// which impulses act for a share of the step.
  [[nodiscard]] static S fastest_turn2(const State& state, const Island& island, const S& share) {
    S fastest2 = S(0);
    for (const std::uint32_t slot : island.bodies) {
      const SolverBody<S>& body = state.solver_bodies[slot];
      fastest2 = std::max(fastest2, (body.motion - motion_by(body, share)).angular.squaredNorm());
    }
    return fastest2;
  }
  /// [1] Least share of its impulses, from the usual one up to all, by which no gap of an island
  /// closes by more than itself, and no overlap grows. It is one for all, or momentum would be
  /// lost. Contacts towards which impulses drive the bodies bound it from above. Contacts that
  /// position sweeps ignore have no say: round-off would decide where surfaces rest on each other.
  [[nodiscard]] static S share_apart(const State& state, const Island& island,
                                     const SolveContext<S>& context, const S& usual) {
    // Where a body turns far its arms end up anywhere. Its centre does not.
    const auto arm_of = [&](const SolverBody<S>& body, const Vec3<S>& arm) -> Vec3<S> {
      return turns_far<S>(body.twist.angular, context.dt) ? zero<Vec3<S>>() : arm;
    };
    S least = usual;
    S largest = S(1);
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = state.constraints.contacts[i];
      const SolverBody<S>& a = state.solver_bodies[c.body_a];
      const SolverBody<S>& b = state.solver_bodies[c.body_b];
      const Vec3<S> arm_a = arm_of(a, c.arm_a);
      const Vec3<S> arm_b = arm_of(b, c.arm_b);
      const auto parting = [&](const Twist<S>& u, const Twist<S>& v) {
        return c.axes[0].dot(v.at(arm_b) - u.at(arm_a));
      };
      const S free_way = std::max(S(0), c.gap) + context.position_tolerance;
      const S missing = -parting(a.mean_free, b.mean_free) - free_way / context.dt;
      const S given = parting(a.twist, b.twist) - parting(a.free, b.free);
      if (given > S(0)) least = std::max(least, S(missing / given));
      if (given < S(0)) largest = std::min(largest, S(missing / given));
    }
    return std::max(usual, std::min(least, largest));
  }

  /// Restores the angular momentum of an isolated island.
  ///
  /// Its constraints act at the arms of the start. Since then, bodies with the velocity v at the
  /// end have moved by dt u. The angular momentum of their centres changes by dt m u x v. Outer
  /// forces account for that change only in free motion (u0, v0). Where surfaces slide or hit, the
  /// difference is of the order of the step. It is returned as one turn of the whole island about
  /// its centre of mass, as of one rigid body. That moves nothing in it relative to anything else.
  void keep_angular_momentum(State& state, const Island& island) const {
    const auto is_free = [&](std::uint32_t slot) {
      const SolverBody<S>& body = state.solver_bodies[slot];
      if (!body.moves || body.follows_joints) return false;
      for (Eigen::Index axis = 0; axis < 6; ++axis) {
        if (body.is_locked(axis)) return false;
      }
      return true;
    };
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = state.constraints.contacts[i];
      if (!is_free(c.body_a) || !is_free(c.body_b)) return;
    }
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = state.constraints.blocks[i];
      if (!is_free(block.body_a) || !is_free(block.body_b)) return;
    }
    // Positions at the end of the step: a velocity change adds to the angular momentum there.
    const S dt = state.def.time_step;
    const auto end_of = [&](std::uint32_t slot) -> Vec3<S> {
      return state.bodies.at(slot).center_pose.translation +
             dt * state.solver_bodies[slot].motion.linear;
    };
    S mass = S(0);
    Vec3<S> center = zero<Vec3<S>>();
    for (const std::uint32_t slot : island.bodies) {
      mass += state.solver_bodies[slot].mass;
      center += state.solver_bodies[slot].mass * end_of(slot);
    }
    center /= mass;
    Vec3<S> excess = zero<Vec3<S>>();
    Mat3<S> inertia = zero<Mat3<S>>();
    for (const std::uint32_t slot : island.bodies) {
      const SolverBody<S>& body = state.solver_bodies[slot];
      excess += body.mass * (body.motion.linear.cross(body.twist.linear) -
                             body.mean_free.linear.cross(body.free.linear));
      inertia += body.inertia + point_inertia<S>(body.mass, end_of(slot) - center);
    }
    // Impulses later in the step count from the positions at its start. There they act at two
    // points.
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = state.constraints.contacts[i];
      const CachedPoint<S>& point = state.contacts.points()[c.point];
      Vec3<S> apart = (state.bodies.at(c.body_b).center_pose.translation -
                       state.bodies.at(c.body_a).center_pose.translation) +
                      (point.arm_b - point.arm_a);
      if (point.acts_at_mid) apart += point.mid_offset_b - point.mid_offset_a;
      excess += (S(1) / dt) * apart.cross(c.impulse_W());
    }
    const Vec3<S> turn = inverse_inertia<S>(inertia) * (-dt * excess);
    for (const std::uint32_t slot : island.bodies) {
      Twist<S>& twist = state.solver_bodies[slot].twist;
      twist.linear += turn.cross(end_of(slot) - center);
      twist.angular += turn;
    }
  }

  /// Returns whether all velocities and impulses of an island are finite, and the sum of their
  /// squares. Heavy bodies may take an impulse that overflows at a velocity that does not.
  [[nodiscard]] static bool is_finite(const State& state, const Island& island) {
    const Constraints<S>& constraints = state.constraints;
    S sum = S(0);
    const auto add = [&sum](const auto& values) {
      for (const S& x : values) sum += x * x;
    };
    for (const std::uint32_t slot : island.bodies) {
      add(state.solver_bodies[slot].twist.linear);
      add(state.solver_bodies[slot].twist.angular);
    }
    for (const std::uint32_t i : island.contacts) add(constraints.contacts[i].impulse);
    for_each_row(island, constraints,
                 [&](const ConstraintRow<S>& row) { sum += row.impulse * row.impulse; });
    for (const std::uint32_t i : island.soft) add(constraints.soft[i].impulse);
    return sum * S(0) == S(0);  // Only a finite number times 0 is 0.
  }

  /// Solves an island whose solution is not finite, by sweeps that skip overflowing rows.
  static void guard(State& state, SensorStage<S>& sensors, const Island& island,
                    const SolveContext<S>& context) {
    for (const std::uint32_t soft : sensors.of_patches(island.soft)) sensors.discard(state, soft);
    GuardedSweeps<S>::solve(island, state.constraints, state.solver_bodies, context);
    ++state.report.discarded_islands;
  }

  [[nodiscard]] static bool has_motion(const Twist<S>& twist) {
    return twist.linear.squaredNorm() > S(0) || twist.angular.squaredNorm() > S(0);
  }

  bool has_movers_ = false;  // True if an immovable body moves. Only then may others be crushed.
  IslandBuilder<S> islands_;
  MethodChoice<S> choice_;
  IslandSolver<S> solver_;
  PassiveRestitution<S> restitution_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
