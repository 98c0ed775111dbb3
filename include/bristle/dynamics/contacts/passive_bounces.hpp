/// @file
/// Bounces of mechanisms that give no energy.
///
/// Newton's law of restitution speaks of normal velocities alone. Where a chain is struck aside of
/// its centre, friction and joints then may do work: the impulses that reverse the normal velocity
/// leave more kinetic energy than there was (Kane and Levinson, *Dynamics*, 1985, section 5.8).
/// Without restitution they never do: velocities then are a projection, in the metric of the
/// masses. Impulses between the two solutions are allowed ones, since what contacts may give is
/// convex; the last of them that gives no energy is taken.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/contacts/saved_impulses.hpp>
#include <bristle/dynamics/solver/island_energy.hpp>
#include <bristle/dynamics/solver/island_solver.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Scratch memory and the algorithm. One object serves many islands, one after the other.
template <Scalar S>
class PassiveBounces {
 public:
  /// Takes back what bounces have given the mechanisms of a solved island beyond the energy of
  /// their free motion. Islands with sensors or drives, or beside what moves by itself, are left
  /// alone: their energy is not theirs. So are large ones, whose impulses are sums over parts of
  /// the step.
  void calm(const Island& island, Constraints<S>& constraints, std::span<SolverBody<S>> bodies,
            const SolveContext<S>& context, IslandSolver<S>& solver, SolveReport<S>& report) {
    if (island.blocks.empty() || island.contacts.empty() || !island.soft.empty()) return;
    if (IslandSolver<S>::is_large(context)) return;
    const S gained = gained_energy(island, bodies);
    if (!(gained > S(0)) || !is_closed(island, constraints, bodies)) return;
    saved_.save(island, constraints);
    bouncing_.clear();
    for (const std::uint32_t slot : island.bodies) bouncing_.push_back(bodies[slot].twist);
    SolveContext<S> without = context;
    without.restitution_speed = infinity<S>;
    solver.solve(island, constraints, bodies, without, report);
    const S share = passive_share(island, bodies, gained);
    saved_.blend(share, island, constraints);
    for (std::size_t k = 0; k < bouncing_.size(); ++k) {
      Twist<S>& twist = bodies[island.bodies[k]].twist;
      twist = twist + share * (bouncing_[k] - twist);
    }
  }

 private:
  /// [J] Twice the kinetic energy beyond that at the start of the step and that of free motion, and
  /// beyond their rounding.
  [[nodiscard]] static S gained_energy(const Island& island,
                                       std::span<const SolverBody<S>> bodies) {
    const IslandEnergy<S> energy = energy_of<S>(island, bodies);
    return energy.found - (S(1) + Tolerance<S>::equal()) * std::max(energy.start, energy.free);
  }

  /// Whether something bounces, and nothing but the island's own bodies brings energy in.
  [[nodiscard]] static bool is_closed(const Island& island, const Constraints<S>& constraints,
                                      std::span<const SolverBody<S>> bodies) {
    const auto rests = [&](std::uint32_t slot) {
      const SolverBody<S>& body = bodies[slot];
      return body.moves || (body.twist.linear.isZero(S(0)) && body.twist.angular.isZero(S(0)));
    };
    return std::any_of(island.contacts.begin(), island.contacts.end(),
                       [&](std::uint32_t i) { return constraints.contacts[i].parting_target() > S(0); }) &&
           std::all_of(island.contacts.begin(), island.contacts.end(),
                       [&](std::uint32_t i) {
                         const ContactConstraint<S>& c = constraints.contacts[i];
                         return rests(c.body_a) && rests(c.body_b);
                       }) &&
           std::all_of(island.blocks.begin(), island.blocks.end(), [&](std::uint32_t i) {
             const ConstraintBlock<S>& block = constraints.blocks[i];
             return block.kind != BlockKind::bounded && rests(block.body_a) && rests(block.body_b);
           });
  }

  /// [1] How far to go from the velocities v without bounces to those with them, v + d: the root of
  /// |v + s d|^2 = |v + d|^2 - gained.
  [[nodiscard]] S passive_share(const Island& island, std::span<const SolverBody<S>> bodies,
                                S gained) const {
    using std::max;
    using std::min;
    using std::sqrt;
    S along = S(0);
    S across = S(0);
    for (std::size_t k = 0; k < bouncing_.size(); ++k) {
      const SolverBody<S>& body = bodies[island.bodies[k]];
      const Twist<S> way = bouncing_[k] - body.twist;
      along += mass_product(body, body.twist, way);
      across += mass_product(body, way, way);
    }
    const S below = S(2) * along + across - gained;
    if (!(below > S(0)) || !(across > S(0))) return S(0);
    return min(S(1), max(S(0), (sqrt(along * along + across * below) - along) / across));
  }

  SavedImpulses<S> saved_;
  std::vector<Twist<S>> bouncing_;
};

}  // namespace bristle::inline BRISTLE_ABI
