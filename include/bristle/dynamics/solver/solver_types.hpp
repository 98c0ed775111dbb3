/// @file
/// What both solvers work on: bodies as the solver sees them, one island's constraints, settings
/// and what a solve reports.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/contacts/contact_constraint.hpp>
#include <bristle/dynamics/solver/constraint.hpp>
#include <bristle/dynamics/solver/soft_block.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// How positions follow from velocities; docs/solver.md compares them.
enum class Integrator {
  /// With the mean of the velocities at both ends of the step: second order, exact under constant
  /// forces. Bodies that sensors push are stepped by symplectic Euler all the same, with which the
  /// law of the bristles is integrated.
  trapezoidal,
  /// With the velocity at the end of the step: first order, as the paper has it.
  symplectic_euler
};

/// Settings of the solver. The defaults are made for holding things still.
template <Scalar S>
struct SolverDef {
  /// [-] Most sweeps over an island in a solve, and as many again from no impulses where those went
  /// astray.
  int max_sweeps = 100;
  /// [-] Most sweeps of the position problem a step.
  int max_position_sweeps = 30;
  /// [-] Most times an island is solved because its sensors changed state (stuck to slipping,
  /// touching to free, normal force), and because contacts turned out to be open.
  int max_passes = 12;
  /// [1] A sweep that changes no velocity by more than this fraction of the speed gained from
  /// gravity in a step is the last one. Tight on purpose: a state that is not at rest to this
  /// precision never becomes the fixed point that makes the next step one sweep.
  S tolerance = std::numeric_limits<S>::digits > 30 ? S(1e-8) : S(1e-5);
  /// [1] Position errors below this fraction of what gravity moves a body by in a step are left
  /// alone. Positions do not act back on velocities, so this may be looser.
  S position_tolerance = std::numeric_limits<S>::digits > 30 ? S(1e-6) : S(1e-3);
  /// [-] Most multiply-adds of one factorisation of the matrix of an island that is solved by
  /// factorisation where sweeps converge too slowly: a tower of some five hundred bodies, a heap
  /// of some forty. Larger islands are swept. 0 for plain sequential impulses.
  std::uint64_t max_direct_work = 700000;
  /// [-] Most Newton steps of one such solve: the bound on the cost of the worst step.
  int max_newton_steps = 60;
  /// [-] Most sweeps over a larger island in each part of a step; `max_sweeps` where most of its
  /// contacts are new.
  int large_sweeps = 10;
  /// [-] Most sweeps of its position problem.
  int large_position_sweeps = 4;
  /// [s] Longest part of a step over which such an island is solved at once, > 0; infinite for one
  /// part a step.
  S longest_part = S(1) / S(240);
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
  /// Displacement of the step, divided by the step: of free motion, and as known so far.
  Twist<S> free_motion{};
  Twist<S> motion{};
  // Up to here, and the flags, is all that a step needs of a body that touches nothing.
  /// Whether forces move it along or about any axis, and whether torques turn it about any.
  bool moves = false;
  bool turns = true;
  /// Whether it turns about all axes alike: its inertia is then a number times the identity.
  bool is_isotropic = false;
  /// Whether sensors push it: it is then stepped by symplectic Euler.
  bool is_sensed = false;
  /// Whether its free motion is that of a mechanism, and velocities are those at its end.
  bool follows_joints = false;
  /// [1/kg, 1/(kg m^2)] World axes; zero along and about axes on which forces do not move it.
  Vec3<S> inverse_mass = Vec3<S>::Zero();
  Mat3<S> inverse_inertia = Mat3<S>::Zero();
  /// [kg, kg m^2] Of the whole body, world axes.
  S mass = S(0);
  Mat3<S> inertia = Mat3<S>::Zero();

  [[nodiscard]] bool is_moving() const { return moves; }
  /// Whether nothing moves it along (0 to 2) or about (3 to 5) an axis of the world.
  [[nodiscard]] bool is_locked(Eigen::Index axis) const {
    return (axis < 3 ? inverse_mass[axis] : inverse_inertia(axis - 3, axis - 3)) == S(0);
  }
  /// Adds what an impulse at the end of an arm does to a velocity.
  void push_at(Twist<S>& velocity, const Vec3<S>& impulse, const Vec3<S>& arm) const {
    velocity.linear += inverse_mass.cwiseProduct(impulse);
    if (turns) velocity.angular += inverse_inertia * arm.cross(impulse);
  }
  /// Adds what an impulse about the centre of mass does to a velocity.
  void push(Twist<S>& velocity, const Vec3<S>& impulse, const Vec3<S>& angular_impulse) const {
    velocity.linear += inverse_mass.cwiseProduct(impulse);
    velocity.angular += inverse_inertia * angular_impulse;
  }
};

/// Everything that acts between bodies in one step, for all islands.
template <Scalar S>
struct Constraints {
  std::vector<ContactConstraint<S>> contacts;
  std::vector<ConstraintRow<S>> rows;
  std::vector<ConstraintBlock<S>> blocks;
  std::vector<SoftBlock<S>> soft;

  void clear() {
    contacts.clear();
    rows.clear();
    blocks.clear();
    soft.clear();
  }
};

/// One island: bodies that act on each other, by their slots, and what acts between them, by
/// number.
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

/// How a solve went.
template <Scalar S>
struct SolveReport {
  /// [-] Sweeps of the velocity and of the position problem, and factorisations of an island's
  /// matrix.
  int sweeps = 0;
  int position_sweeps = 0;
  int factorisations = 0;
  /// [m/s] What is left to solve: the largest velocity change of the last sweep.
  S residual = S(0);
};

/// What one solve needs to know of the step.
template <Scalar S>
struct SolveContext {
  /// [s] Step length.
  S dt = S(0);
  /// [-] How the island's positions follow from its velocities.
  Integrator integrator = Integrator::trapezoidal;
  /// [m/s] By how much forces change the velocity of any of the island's bodies within the step.
  S speed_change = S(0);
  /// [m/s, rad/s] The same with what drives did in the last step.
  S driven_change = S(0);
  /// [m/s] Velocity changes below this do not count.
  S velocity_tolerance = S(0);
  /// [m] Position errors below this do not count.
  S position_tolerance = S(0);
  /// [m/s] Impacts slower than this do not bounce.
  S restitution_speed = S(0);
  /// [-] Multiply-adds of one factorisation of the island's matrix; see `factor_work`.
  std::uint64_t factor_work = 0;
  /// Whether the island gets a bounded number of sweeps, converged or not.
  bool is_swept = false;
  SolverDef<S> settings{};

  /// The same for one of several equal parts of the step.
  [[nodiscard]] SolveContext part(S parts) const {
    SolveContext result = *this;
    result.dt /= parts;
    result.speed_change /= parts;
    result.driven_change /= parts;
    result.velocity_tolerance /= parts;
    return result;
  }
};

/// Velocity along a row per impulse of its own when only its two bodies move.
template <Scalar S>
[[nodiscard]] S row_response(const ConstraintRow<S>& row, const SolverBody<S>& a,
                             const SolverBody<S>& b) {
  return row.direction.dot((a.inverse_mass + b.inverse_mass).cwiseProduct(row.direction)) +
         row.angular_a.dot(a.inverse_inertia * row.angular_a) +
         row.angular_b.dot(b.inverse_inertia * row.angular_b);
}

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

/// Mobilities of two bodies along and about the axes of a contact: what the points of a manifold
/// have in common.
template <Scalar S>
struct ContactFrame {
  ContactFrame(const ContactConstraint<S>& c, const SolverBody<S>& a, const SolverBody<S>& b) {
    for (Eigen::Index k = 0; k < 3; ++k) to_contact.row(k) = c.axes[static_cast<std::size_t>(k)];
    const Vec3<S> m = a.inverse_mass + b.inverse_mass;
    inverse_mass = m.asDiagonal();
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

/// Response of a contact's velocities to its impulses when only its two bodies move.
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

/// Applies an impulse on B at a contact, and its reaction on A, to whichever velocities `of` picks.
template <Scalar S, typename Of>
void apply_at_contact(const ContactConstraint<S>& c, const Vec3<S>& impulse, SolverBody<S>& a,
                      SolverBody<S>& b, Of&& of) {
  if (a.moves) a.push_at(of(a), -impulse, c.arm_a);
  if (b.moves) b.push_at(of(b), impulse, c.arm_b);
}

/// Applies the impulse x of a row to both bodies.
template <Scalar S, typename Of>
void apply_row(const ConstraintRow<S>& row, S x, SolverBody<S>& a, SolverBody<S>& b, Of&& of) {
  a.push(of(a), -x * row.direction, -x * row.angular_a);
  b.push(of(b), x * row.direction, x * row.angular_b);
}

/// Applies the impulse p of a soft block to both bodies: p on B, -p on A.
template <Scalar S>
void apply_soft(const SoftBlock<S>& block, const Vec6<S>& p, SolverBody<S>& a, SolverBody<S>& b) {
  const Vec3<S> force = p.template head<3>();
  const Vec3<S> torque = p.template tail<3>();
  a.push(a.twist, -force, -torque - block.arm_a.cross(force));
  b.push(b.twist, force, torque + block.arm_b.cross(force));
}

/// Sets the velocities of an island to free motion plus everything its constraints hold: what
/// sensors, contacts and joints report is then exactly what moves the bodies, to the round-off of
/// this sum and not of a matrix.
template <Scalar S>
void apply_impulses(const Island& island, const Constraints<S>& constraints,
                    std::span<SolverBody<S>> bodies);

/// Whether a body turns by more than half a radian in a step. The chord of its way then misses the
/// arc by an eighth of the radius, and directions of the start say little about the end.
template <Scalar S>
[[nodiscard]] bool turns_far(const Twist<S>& motion, S dt) {
  const S most = S(0.5) / dt;
  return motion.angular.squaredNorm() > most * most;
}

/// Displacement of a body in a step, divided by it, from its velocities.
template <Scalar S>
[[nodiscard]] Twist<S> mean_motion(const SolverBody<S>& body, Integrator integrator) {
  if (integrator == Integrator::symplectic_euler) return body.twist;
  return body.free_motion + S(0.5) * (body.twist - body.free);
}

/// The same for free motion that starts and ends with known velocities, of a body or of a point.
template <Scalar S, typename Velocity>
[[nodiscard]] Velocity mean_free_motion(const Velocity& start, const Velocity& free,
                                        Integrator integrator) {
  if (integrator == Integrator::symplectic_euler) return free;
  return S(0.5) * (start + free);
}
template <Scalar S>
[[nodiscard]] Twist<S> mean_free_motion(const SolverBody<S>& body, Integrator integrator) {
  return mean_free_motion<S>(body.start, body.free, integrator);
}

/// Picks the velocity at the end of the step, or the displacement of it, for the functions above.
inline constexpr auto velocity_of = [](auto& body) -> auto& { return body.twist; };
inline constexpr auto motion_of = [](auto& body) -> auto& { return body.motion; };

template <Scalar S>
void apply_impulses(const Island& island, const Constraints<S>& constraints,
                    std::span<SolverBody<S>> bodies) {
  for (const std::uint32_t slot : island.bodies) bodies[slot].twist = bodies[slot].free;
  // Points between the same two bodies follow each other: their impulses are summed first.
  for (std::size_t k = 0; k < island.contacts.size();) {
    const std::uint32_t slot_a = constraints.contacts[island.contacts[k]].body_a;
    const std::uint32_t slot_b = constraints.contacts[island.contacts[k]].body_b;
    Vec3<S> force = Vec3<S>::Zero();
    Vec3<S> torque_a = Vec3<S>::Zero();
    Vec3<S> torque_b = Vec3<S>::Zero();
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
    if (a.moves) a.push(a.twist, -force, -torque_a);
    if (b.moves) b.push(b.twist, force, torque_b);
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

}  // namespace bristle::inline BRISTLE_ABI
