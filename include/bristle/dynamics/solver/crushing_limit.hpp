/// @file
/// Bound of the impulses by bodies that nothing stops.
///
/// Fixed and kinematic bodies that move towards each other crush what is between them. No
/// velocities keep all surfaces apart then. Impulses would grow with every sweep and Newton step,
/// and the movers would do work without end. So their contacts give at most an impulse that is far
/// above all that the bodies between them can ask for. Coulomb's law has a solution then.
/// Surfaces approach only where that bound is reached.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/solver_constants.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <algorithm>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Returns whether a contact carries more than all that acts on its island in a step. It crushes
/// bodies, or a lever presses it.
/// @param most  [N s] `ContactConstraint::most_impulse`. Infinite where nothing can be crushed.
template <typename Real>
[[nodiscard]] bool is_crushing(const Real& impulse, const Real& most) {
  return impulse > most / Real(chosen::most_leverage);
}

/// Returns whether immovable bodies that an island touches, or has joints with, move against each
/// other. Those that turn are taken to do so.
template <Scalar S>
[[nodiscard]] bool are_movers_opposed(const Island& island, const Constraints<S>& constraints,
                                      std::span<const SolverBody<S>> bodies) {
  const SolverBody<S>* first = nullptr;
  const auto is_other = [&](const SolverBody<S>& body) {
    if (body.moves || &body == first) return false;
    if (first == nullptr) {
      first = &body;
      return false;
    }
    const S zero = S(0);
    return (body.free.linear - first->free.linear).squaredNorm() > zero ||
           body.free.angular.squaredNorm() > zero || first->free.angular.squaredNorm() > zero;
  };
  const auto any = [&](std::span<const std::uint32_t> numbers, const auto& all) {
    return std::any_of(numbers.begin(), numbers.end(), [&](std::uint32_t i) {
      return is_other(bodies[all[i].body_a]) || is_other(bodies[all[i].body_b]);
    });
  };
  return any(island.contacts, constraints.contacts) || any(island.blocks, constraints.blocks);
}

/// [N s] Sum of the impulses on an island in a step: those that stop its bodies, those by forces,
/// motors and soft blocks, and those that bring all of them to the speed of movers. Torques count
/// as forces at the radius of gyration.
template <Scalar S>
[[nodiscard]] S impulse_scale(const Island& island, const Constraints<S>& constraints,
                              std::span<const SolverBody<S>> bodies) {
  using std::abs;
  using std::max;
  using std::sqrt;
  S sum = S(0);
  S mass = S(0);
  const auto momentum = [](const SolverBody<S>& body, const Twist<S>& v) {
    return body.mass * v.linear.norm() +
           sqrt(body.mass * max(S(0), S(v.angular.dot(body.inertia * v.angular))));
  };
  for (const std::uint32_t slot : island.bodies) {
    const SolverBody<S>& body = bodies[slot];
    mass += body.mass;
    sum += momentum(body, body.start) + momentum(body, body.free - body.start);
  }
  S speed2 = S(0);
  for (const std::uint32_t i : island.contacts) {
    const ContactConstraint<S>& c = constraints.contacts[i];
    const SolverBody<S>& a = bodies[c.body_a];
    const SolverBody<S>& b = bodies[c.body_b];
    if (!a.moves) speed2 = max(speed2, S(a.free.at(c.arm_a).squaredNorm()));
    if (!b.moves) speed2 = max(speed2, S(b.free.at(c.arm_b).squaredNorm()));
  }
  for (const std::uint32_t i : island.blocks) {
    const ConstraintBlock<S>& block = constraints.blocks[i];
    // Rolling friction drives nothing, and its bound follows from the impulses that are limited.
    if (!block.is_of_joint()) continue;
    const SolverBody<S>& a = bodies[block.body_a];
    const SolverBody<S>& b = bodies[block.body_b];
    const S jointed = max(a.moves ? a.mass : S(0), b.moves ? b.mass : S(0));
    if (!a.moves || !b.moves) {
      S of_block2 = S(0);
      for (std::uint32_t r = block.first; r < block.first + block.count; ++r) {
        const ConstraintRow<S>& row = constraints.rows[r];
        const S response = row_response(row, a, b);
        const S speed = row.velocity(a.moves ? Twist<S>{} : a.free, b.moves ? Twist<S>{} : b.free);
        if (response > S(0)) of_block2 += speed * speed / (response * jointed);
      }
      speed2 = max(speed2, of_block2);
    }
    const S most = max(abs(block.lower), abs(block.upper));
    if (block.kind == BlockKind::equality || !(most < infinity<S>)) continue;
    sum += most * sqrt(row_response(constraints.rows[block.first], a, b) * jointed);
  }
  sum += mass * sqrt(speed2);
  for (const std::uint32_t i : island.soft) {
    const SoftBlock<S>& soft = constraints.soft[i];
    const S radius2 = max(bodies[soft.body_a].mass * bodies[soft.body_a].inverse_inertia.trace(),
                          bodies[soft.body_b].mass * bodies[soft.body_b].inverse_inertia.trace());
    sum += first_half<S>(soft.offset).norm() + second_half<S>(soft.offset).norm() * sqrt(radius2);
  }
  return sum;
}

/// Bounds the normal impulses of contacts with immovable bodies, where these move against each
/// other. Elsewhere there is a solution without a bound. The bound has no derivatives: at rest
/// those of its speeds are infinite.
template <Scalar S>
void limit_crushing(const Island& island, Constraints<S>& constraints,
                    std::span<const SolverBody<S>> bodies) {
  if (!are_movers_opposed(island, constraints, bodies)) return;
  const S most =
      S(value_of(S(chosen::most_leverage) * impulse_scale(island, constraints, bodies)));
  if (!(most < infinity<S>)) return;  // Numbers that are none bound nothing.
  for (const std::uint32_t i : island.contacts) {
    ContactConstraint<S>& c = constraints.contacts[i];
    if (bodies[c.body_a].moves && bodies[c.body_b].moves) continue;
    c.most_impulse = most;
    if (!(c.impulse[0] > most)) continue;
    const S share = most / c.impulse[0];
    for (S& x : c.impulse) x *= share;
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
