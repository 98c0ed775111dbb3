/// @file
/// Records that both solvers share. They are bodies of a solve, the constraints of one island, and
/// the report of a solve.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/contacts/contact_constraint.hpp>
#include <bristle/dynamics/solver/constraint.hpp>
#include <bristle/dynamics/solver/soft_block.hpp>
#include <bristle/dynamics/solver/solver_constants.hpp>
#include <bristle/dynamics/solver/solver_def.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// A body in the solver.
template <Scalar S>
struct SolverBody {
  /// Velocities at the end of the step, as solved so far.
  Twist<S> twist{};
  /// v_free: velocities at the end of free motion.
  Twist<S> free{};
  /// v0: velocities at the start of the step.
  Twist<S> start{};
  /// [1] Factors of `start` in `free`: what damping leaves of it.
  S kept_linear = S(1);
  S kept_angular = S(1);
  /// Displacement of free motion over the step, divided by the step.
  Twist<S> mean_free{};
  /// The same with impulses, as solved so far.
  Twist<S> motion{};
  // The fields above, and the flags, describe free motion. A body that touches nothing needs no
  // others.
  /// `moves`: true if forces move it along or about any axis. `turns`: true if torques turn it.
  bool moves = false;
  bool turns = true;
  /// True if it turns about all axes alike. Its inertia is a number times the identity.
  bool is_isotropic = false;
  /// True if sensors push it. It is then stepped by symplectic Euler.
  bool is_sensed = false;
  /// True if its free motion is that of a mechanism. Velocities are then those at its end.
  bool follows_joints = false;
  /// [1/kg, 1/(kg m^2)] World axes; zero along and about locked axes.
  Vec3<S> inverse_mass = zero<Vec3<S>>();
  Mat3<S> inverse_inertia = zero<Mat3<S>>();
  /// [kg, kg m^2] Mass and inertia of the whole body, world axes.
  S mass = S(0);
  Mat3<S> inertia = zero<Mat3<S>>();

  [[nodiscard]] bool is_moving() const { return moves; }
  /// Returns whether damping takes nothing of `start`.
  [[nodiscard]] bool keeps_all() const { return kept_linear == S(1) && kept_angular == S(1); }
  /// [m/s, rad/s] The part of `free` that the start leaves. The rest of it comes from forces.
  [[nodiscard]] Twist<S> kept_start() const {
    if (keeps_all()) return start;
    return {kept_linear * start.linear, kept_angular * start.angular};
  }
  /// Returns whether it is locked along (0 to 2) or about (3 to 5) an axis of the world.
  [[nodiscard]] bool is_locked(Eigen::Index axis) const {
    return (axis < 3 ? inverse_mass[axis] : inverse_inertia(axis - 3, axis - 3)) == S(0);
  }
  /// Adds the effect of an impulse at the end of an arm to a velocity.
  void apply_impulse_at(Twist<S>& velocity, const Vec3<S>& impulse, const Vec3<S>& arm) const {
    velocity.linear += cwise_product(inverse_mass, impulse);
    if (turns) velocity.angular += inverse_inertia * arm.cross(impulse);
  }
  /// Adds the effect of an impulse about the centre of mass to a velocity.
  void apply_impulse(Twist<S>& velocity, const Vec3<S>& impulse,
                     const Vec3<S>& angular_impulse) const {
    velocity.linear += cwise_product(inverse_mass, impulse);
    velocity.angular += inverse_inertia * angular_impulse;
  }
};

/// All constraints between bodies in one step, for all islands.
template <Scalar S>
struct Constraints {
  DynamicArray<ContactConstraint<S>> contacts;
  DynamicArray<ConstraintRow<S>> rows;
  DynamicArray<ConstraintBlock<S>> blocks;
  DynamicArray<SoftBlock<S>> soft;

  void clear() {
    contacts.clear();
    rows.clear();
    blocks.clear();
    soft.clear();
  }
};

/// One island: bodies that act on each other. It holds slots of bodies and numbers of constraints.
struct Island {
  std::span<const std::uint32_t> bodies;
  std::span<const std::uint32_t> contacts;
  std::span<const std::uint32_t> blocks;
  std::span<const std::uint32_t> soft;
};

/// Calls use(row) for each row of an island's blocks.
template <typename AnyConstraints, typename Use>
void for_each_row(const Island& island, AnyConstraints& constraints, Use&& use) {
  for (const std::uint32_t i : island.blocks) {
    const auto& block = constraints.blocks[i];
    for (std::uint32_t r = 0; r < block.count; ++r) use(constraints.rows[block.first + r]);
  }
}

/// Returns whether joints act in an island. Its other blocks are the rolling friction of contacts.
template <Scalar S>
[[nodiscard]] bool has_joints(const Island& island, const Constraints<S>& constraints) {
  for (const std::uint32_t i : island.blocks) {
    if (constraints.blocks[i].is_of_joint()) return true;
  }
  return false;
}

/// Counters and residual of a solve.
template <Scalar S>
struct SolveReport {
  /// [-] Sweeps of the velocity and of the position problem. Factorisations of an island's matrix.
  int sweeps = 0;
  int position_sweeps = 0;
  int factorisations = 0;
  /// [m/s] Residual: the largest velocity change of the last sweep.
  S residual = S(0);
};

/// Parameters of the step that one solve needs.
template <Scalar S>
struct SolveContext {
  /// [s] Step length.
  S dt = S(0);
  /// [-] Rule for positions from velocities.
  Integrator integrator = Integrator::trapezoidal;
  /// [m/s] Largest velocity change of the island's bodies by forces within the step.
  S speed_change = S(0);
  /// [m/s, rad/s] The same, with the effect of motors in the last step.
  S driven_change = S(0);
  /// [m/s] Velocity changes below this are ignored.
  S velocity_tolerance = S(0);
  /// [m] Position errors below this are ignored.
  S position_tolerance = S(0);
  /// [m/s] Impacts slower than this do not bounce.
  S restitution_speed = S(0);
  /// [-] Multiply-adds of one assembly and factorisation of the island's matrix. Only a bound if
  /// that decides (`MethodChoice`).
  std::uint64_t factor_work = 0;
  /// True if sweeps cost less than the factorisations of a heap of mechanisms (`MethodChoice`).
  bool is_costly_heap = false;
  /// True if the island gets a bounded number of sweeps, converged or not.
  bool is_swept = false;
  /// True if sweeps may solve the island and its surfaces slide fast (`MethodChoice`).
  bool slides = false;
  SolverDef<S> settings{};

  /// [m/s] Least speed that is fast: forces do not change velocities as much in the step.
  [[nodiscard]] S fast() const { return std::max(velocity_tolerance, speed_change); }
  /// [-] Factorisations that the budget of one problem pays for. It is as many multiply-adds as
  /// `budget_factorisations` of the largest island take.
  [[nodiscard]] double affordable_steps() const {
    return chosen::budget_factorisations * static_cast<double>(settings.max_direct_work) /
           static_cast<double>(std::max<std::uint64_t>(1, factor_work));
  }
  /// Returns whether a factorisation exceeds its bounds. The island is then swept in any case.
  [[nodiscard]] bool is_large() const {
    return factor_work > settings.max_direct_work || is_costly_heap;
  }
  /// [-] Sweeps of the position problem that cost as much as all steps of Newton's method may.
  [[nodiscard]] int affordable_sweeps(const Island& island) const {
    const double steps = std::min<double>(settings.max_newton_steps, affordable_steps());
    const double work = chosen::contact_sweep_work * static_cast<double>(island.contacts.size());
    return static_cast<int>(std::min(chosen::most_affordable_sweeps,
                                     steps * static_cast<double>(factor_work) / work));
  }
  /// [-] Newton steps that the island may still take to solve one problem, at least one. The cost
  /// of a step so does not grow with the island. The residual of the law grows instead. All passes
  /// of a step share `budgets_of_step` budgets. Once these are spent, each problem gets one step.
  [[nodiscard]] int most_newton_steps(const SolveReport<S>& report) const {
    return static_cast<int>(std::min(steps_of_problem(), steps_left(report)));
  }
  /// [-] Steps that an interior-point method may take from there. It needs some ten to forty
  /// whatever the island is, and gives nothing before its end. So it may take all that is left.
  [[nodiscard]] int most_interior_steps(const SolveReport<S>& report) const {
    return static_cast<int>(steps_left(report));
  }
  /// [1] Share of the budget that `max_newton_steps` on Coulomb's law and as many on the convex
  /// problems would take.
  [[nodiscard]] double cost_share() const {
    return 2.0 * settings.max_newton_steps / affordable_steps();
  }
  /// Returns whether both take a small share of it at most. The island is then solved exactly, or
  /// stacks would never come to rest. A larger one may leave something. Where surfaces slide fast,
  /// any island may: what Newton's method leaves. Sweeps follow, few for a larger one.
  [[nodiscard]] bool is_cheap() const { return cost_share() <= chosen::cheap_cost_share; }

  /// [-] Number of substeps of a swept island. It has an upper bound, whatever the length of the
  /// step.
  [[nodiscard]] int part_count() const {
    using std::ceil;
    using std::max;
    using std::min;
    const S most = S(chosen::most_swept_substeps);
    const S wanted = ceil(dt / settings.longest_substep);
    return static_cast<int>(min(most, max(S(1), wanted)));  // Infinite length: one.
  }
  /// The same for one of several equal substeps.
  [[nodiscard]] SolveContext part(S parts) const {
    SolveContext result = *this;
    result.dt /= parts;
    result.speed_change /= parts;
    result.driven_change /= parts;
    result.velocity_tolerance /= parts;
    return result;
  }

 private:
  [[nodiscard]] double steps_of_problem() const {
    return std::clamp(affordable_steps(), 1.0, static_cast<double>(settings.max_newton_steps));
  }
  [[nodiscard]] double steps_left(const SolveReport<S>& report) const {
    return std::max(1.0, chosen::budgets_of_step * steps_of_problem() - report.factorisations);
  }
};

/// Velocity along a row per impulse of its own if only its two bodies move.
template <Scalar S>
[[nodiscard]] S row_response(const ConstraintRow<S>& row, const SolverBody<S>& a,
                             const SolverBody<S>& b) {
  return row.direction.dot(cwise_product(a.inverse_mass + b.inverse_mass, row.direction)) +
         row.angular_a.dot(a.inverse_inertia * row.angular_a) +
         row.angular_b.dot(b.inverse_inertia * row.angular_b);
}

/// Response of a block's rows to its own impulses if only its two bodies move.
template <Scalar S>
void local_response(const ConstraintBlock<S>& block, const ConstraintRow<S>* rows,
                    const SolverBody<S>& a, const SolverBody<S>& b, BlockResponse<S>& K) {
  const Vec3<S> inverse_mass = a.inverse_mass + b.inverse_mass;
  for (std::size_t j = 0; j < block.count; ++j) {
    const Vec3<S> turn_a = a.inverse_inertia * rows[j].angular_a;
    const Vec3<S> turn_b = b.inverse_inertia * rows[j].angular_b;
    const Vec3<S> move = cwise_product(inverse_mass, rows[j].direction);
    for (std::size_t i = 0; i < block.count; ++i) {
      K.matrix[i * block.count + j] = rows[i].direction.dot(move) + rows[i].angular_a.dot(turn_a) +
                                      rows[i].angular_b.dot(turn_b);
    }
  }
  K.prepare(block.kind, block.count);
}

/// Mobilities of two bodies along and about the axes of a contact. All points of a manifold share
/// them.
template <Scalar S>
struct ContactFrame {
  ContactFrame(const ContactConstraint<S>& c, const SolverBody<S>& a, const SolverBody<S>& b) {
    for (std::size_t k = 0; k < 3; ++k) {
      set_row(to_contact, static_cast<Eigen::Index>(k), c.axes[k]);
    }
    const Vec3<S> m = a.inverse_mass + b.inverse_mass;
    inverse_mass = diagonal_matrix<S>(m);
    if (m[0] != m[1] || m[0] != m[2]) inverse_mass = rotated<S>(to_contact, inverse_mass);
    const auto inverse_inertia = [&](const SolverBody<S>& body) -> Mat3<S> {
      return body.is_isotropic ? body.inverse_inertia
                               : rotated<S>(to_contact, body.inverse_inertia);
    };
    turns_a = a.moves && a.turns;
    turns_b = b.moves && b.turns;
    if (turns_a) inverse_inertia_a = inverse_inertia(a);
    if (turns_b) inverse_inertia_b = inverse_inertia(b);
  }

  Mat3<S> to_contact;
  Mat3<S> inverse_mass;
  bool turns_a, turns_b;
  /// Of bodies that turn.
  Mat3<S> inverse_inertia_a, inverse_inertia_b;
};

/// Response of a contact's velocities to its impulses if only its two bodies move.
template <Scalar S>
[[nodiscard]] ContactResponse<S> contact_response(const ContactConstraint<S>& c,
                                                  const ContactFrame<S>& frame) {
  ContactResponse<S> K;
  K.set(frame.inverse_mass);
  // Along the contact's axes the torques r x e_k of unit impulses at the arm r are
  // (0, z, -y), (-z, 0, x) and (y, -x, 0).
  const auto turn = [&](const Mat3<S>& J, const Vec3<S>& arm) {
    const Vec3<S> r = frame.to_contact * arm;
    const S x = r[0];
    const S y = r[1];
    const S z = r[2];
    const S x0 = z * J(0, 1) - y * J(0, 2);
    const S y0 = z * J(1, 1) - y * J(1, 2);
    const S z0 = z * J(1, 2) - y * J(2, 2);
    const S x1 = x * J(0, 2) - z * J(0, 0);
    const S y1 = x * J(1, 2) - z * J(0, 1);
    const S z1 = x * J(2, 2) - z * J(0, 2);
    const S x2 = y * J(0, 0) - x * J(0, 1);
    const S y2 = y * J(0, 1) - x * J(1, 1);
    K.nn += z * y0 - y * z0;
    K.n1 += x * z0 - z * x0;
    K.n2 += y * x0 - x * y0;
    K.a += x * z1 - z * x1;
    K.b += y * x1 - x * y1;
    K.c += y * x2 - x * y2;
  };
  if (frame.turns_a) turn(frame.inverse_inertia_a, c.arm_a);
  if (frame.turns_b) turn(frame.inverse_inertia_b, c.arm_b);
  K.prepare();
  return K;
}

/// Applies an impulse on B at a contact, and its reaction on A. Changes the velocities that `of`
/// picks.
template <Scalar S, typename Of>
void apply_at_contact(const ContactConstraint<S>& c, const Vec3<S>& impulse, SolverBody<S>& a,
                      SolverBody<S>& b, Of&& of) {
  if (a.moves) a.apply_impulse_at(of(a), -impulse, c.arm_a);
  if (b.moves) b.apply_impulse_at(of(b), impulse, c.arm_b);
}

/// Applies the impulse x of a row to both bodies.
template <Scalar S, typename Of>
void apply_row(const ConstraintRow<S>& row, S x, SolverBody<S>& a, SolverBody<S>& b, Of&& of) {
  a.apply_impulse(of(a), -x * row.direction, -x * row.angular_a);
  b.apply_impulse(of(b), x * row.direction, x * row.angular_b);
}

/// Applies the impulse p of a soft block to both bodies. It is p on B, -p on A.
template <Scalar S>
void apply_soft(const SoftBlock<S>& block, const Vec6<S>& p, SolverBody<S>& a, SolverBody<S>& b) {
  const Vec3<S> force = first_half<S>(p);
  const Vec3<S> torque = second_half<S>(p);
  a.apply_impulse(a.twist, -force, -torque - block.arm_a.cross(force));
  b.apply_impulse(b.twist, force, torque + block.arm_b.cross(force));
}

/// Sets the velocities of an island to free motion plus all impulses of its constraints. The
/// readings of sensors, contacts and joints are then exactly what moves the bodies. They differ by
/// the round-off of this sum and not of a matrix.
template <Scalar S>
void apply_impulses(const Island& island, const Constraints<S>& constraints,
                    std::span<SolverBody<S>> bodies);

/// Displacement of a body in a step, divided by the step, if its impulses act for a share of it.
template <Scalar S>
[[nodiscard]] Twist<S> motion_by(const SolverBody<S>& body, const S& share) {
  return body.mean_free + share * (body.twist - body.free);
}
/// The same by the share of the integrator.
template <Scalar S>
[[nodiscard]] Twist<S> mean_motion(const SolverBody<S>& body, Integrator integrator) {
  if (integrator == Integrator::symplectic_euler) return body.twist;
  return motion_by(body, S(0.5));
}

/// The same for free motion with known velocities at both ends, of a body or of a point.
template <Scalar S, typename Velocity>
[[nodiscard]] Velocity mean_free_velocity(const Velocity& start, const Velocity& free,
                                          Integrator integrator) {
  if (integrator == Integrator::symplectic_euler) return free;
  return S(0.5) * (start + free);
}
template <Scalar S>
[[nodiscard]] Twist<S> mean_free_velocity(const SolverBody<S>& body, Integrator integrator) {
  return mean_free_velocity<S>(body.start, body.free, integrator);
}

/// Picks the velocity at the end of the step, or the displacement, for the functions above.
inline constexpr auto velocity_of = [](auto& body) -> auto& { return body.twist; };
inline constexpr auto motion_of = [](auto& body) -> auto& { return body.motion; };

template <Scalar S>
void apply_impulses(const Island& island, const Constraints<S>& constraints,
                    std::span<SolverBody<S>> bodies) {
  for (const std::uint32_t slot : island.bodies) bodies[slot].twist = bodies[slot].free;
  // Points between the same two bodies follow each other. Their impulses are summed first.
  for (std::size_t k = 0; k < island.contacts.size();) {
    const std::uint32_t slot_a = constraints.contacts[island.contacts[k]].body_a;
    const std::uint32_t slot_b = constraints.contacts[island.contacts[k]].body_b;
    Vec3<S> force = zero<Vec3<S>>();
    Vec3<S> torque_a = zero<Vec3<S>>();
    Vec3<S> torque_b = zero<Vec3<S>>();
    for (; k < island.contacts.size(); ++k) {
      const ContactConstraint<S>& c = constraints.contacts[island.contacts[k]];
      if (c.body_a != slot_a || c.body_b != slot_b) break;
      const Vec3<S> impulse = c.impulse_W();
      force += impulse;
      torque_a += c.arm_a.cross(impulse);
      torque_b += c.arm_b.cross(impulse);
    }
    SolverBody<S>& a = bodies[slot_a];
    SolverBody<S>& b = bodies[slot_b];
    if (a.moves) a.apply_impulse(a.twist, -force, -torque_a);
    if (b.moves) b.apply_impulse(b.twist, force, torque_b);
  }
  for (const std::uint32_t i : island.blocks) {
    const ConstraintBlock<S>& block = constraints.blocks[i];
    for (std::uint32_t r = block.first; r < block.first + block.count; ++r) {
      apply_row(constraints.rows[r], constraints.rows[r].impulse, bodies[block.body_a],
                bodies[block.body_b], velocity_of);
    }
  }
  for (const std::uint32_t s : island.soft) {
    const SoftBlock<S>& soft = constraints.soft[s];
    apply_soft(soft, soft.impulse, bodies[soft.body_a], bodies[soft.body_b]);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
