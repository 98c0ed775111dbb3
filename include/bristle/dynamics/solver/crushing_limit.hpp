/// @file
/// The most that bodies which nothing stops press with.
///
/// Fixed and kinematic bodies that move towards each other crush what is between them. No
/// velocities keep all surfaces apart then. Impulses would grow with every sweep and Newton step,
/// and the movers would do work without end. So their contacts give at most an impulse that is far
/// above all that the bodies between them can ask for. Coulomb's law always has a solution then.
/// Surfaces approach only where that bound is reached.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/solver_types.hpp>

#include <algorithm>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// [1] Load of a contact as a multiple of all that acts on its island in a step. Levers and wedges
/// that are moved against something ask for more than one. Crushed heaps throw no body out with 3
/// to 10; of 96 runs 2 do with 30, and doors that close on a heap throw bodies at 18 m/s with 100.
inline constexpr double most_leverage = 10;

/// Returns whether immovable bodies that an island touches move against each other. Those that turn
/// are taken to do so.
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
  return std::any_of(island.contacts.begin(), island.contacts.end(), [&](std::uint32_t i) {
    const ContactConstraint<S>& c = constraints.contacts[i];
    return is_other(bodies[c.body_a]) || is_other(bodies[c.body_b]);
  });
}

/// [N s] Bound of what acts on an island in a step: what stops or drives all of its bodies, its
/// motors and its soft blocks. Torques count by an arm of 1 m.
template <Scalar S>
[[nodiscard]] S impulse_scale(const Island& island, const Constraints<S>& constraints,
                              std::span<const SolverBody<S>> bodies,
                              const SolveContext<S>& context) {
  using std::abs;
  using std::max;
  using std::sqrt;
  S speed2 = context.driven_change * context.driven_change;
  for (const std::uint32_t i : island.contacts) {
    const ContactConstraint<S>& c = constraints.contacts[i];
    const Vec3<S> v = c.velocity(bodies[c.body_a].start, bodies[c.body_b].start);
    speed2 = max(speed2, S(v.squaredNorm()));
  }
  S mass = S(0);
  for (const std::uint32_t slot : island.bodies) mass += bodies[slot].mass;
  S sum = mass * sqrt(speed2);
  for (const std::uint32_t i : island.blocks) {
    const ConstraintBlock<S>& block = constraints.blocks[i];
    if (block.kind == BlockKind::equality) continue;
    const S most = max(abs(block.lower), abs(block.upper));
    if (most < infinity<S>) sum += most;
  }
  for (const std::uint32_t i : island.soft) {
    sum += first_half<S>(constraints.soft[i].offset).norm();
  }
  return sum;
}

/// Bounds the normal impulses of contacts with immovable bodies, where these move against each
/// other. Elsewhere there is a solution without a bound.
template <Scalar S>
void limit_crushing(const Island& island, Constraints<S>& constraints,
                    std::span<const SolverBody<S>> bodies, const SolveContext<S>& context) {
  if (!are_movers_opposed(island, constraints, bodies)) return;
  const S most = S(most_leverage) * impulse_scale(island, constraints, bodies, context);
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
