/// @file
/// Bounces of mechanisms that add no energy.
///
/// Newton's law of restitution is about normal velocities alone. A chain may be struck off its
/// centre. Friction and joints may then do work. The impulses that reverse the normal velocity then
/// leave more kinetic energy than before (Kane and Levinson, *Dynamics*, 1985, section 5.8).
/// Without restitution they never do. Velocities are then a projection, in the metric of the
/// masses. Impulses between the two solutions are allowed. The impulses of contacts are a convex
/// set. The last of them that adds no energy is taken.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/contacts/saved_impulses.hpp>
#include <bristle/dynamics/solver/island_energy.hpp>
#include <bristle/dynamics/solver/island_solver.hpp>

#include <algorithm>
#include <cmath>

namespace bristle::inline BRISTLE_ABI::detail {

/// The algorithm with its scratch memory. One object serves many islands in turn.
template <Scalar S>
class PassiveRestitution {
 public:
  /// Limits the restitution energy of a solved island. Removes the energy that bounces added to its
  /// mechanisms beyond that of free motion. Islands with sensors, motors, moving kinematic bodies
  /// or surfaces that run are skipped. Energy comes in from outside there. Large islands are
  /// skipped, too: their impulses are sums over substeps.
  void limit_energy(const Island& island, Constraints<S>& constraints,
                    std::span<SolverBody<S>> bodies, const SolveContext<S>& context,
                    IslandSolver<S>& solver, SolveReport<S>& report) {
    if (!has_joints(island, constraints) || island.contacts.empty() || !island.soft.empty()) return;
    if (context.is_large()) return;
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
  /// [J] Twice the kinetic energy beyond that at the start of the step and that of free motion.
  /// Round-off does not count.
  [[nodiscard]] static S gained_energy(const Island& island,
                                       std::span<const SolverBody<S>> bodies) {
    const IslandEnergy<S> energy = energy_of<S>(island, bodies);
    return energy.found - (S(1) + Tolerance<S>::equal()) * std::max(energy.start, energy.free);
  }

  /// Returns whether some contact bounces. Also requires that no energy comes in from outside.
  [[nodiscard]] static bool is_closed(const Island& island, const Constraints<S>& constraints,
                                      std::span<const SolverBody<S>> bodies) {
    const auto rests = [&](std::uint32_t slot) {
      const SolverBody<S>& body = bodies[slot];
      return body.moves || (body.twist.linear.isZero(S(0)) && body.twist.angular.isZero(S(0)));
    };
    return std::any_of(
               island.contacts.begin(), island.contacts.end(),
               [&](std::uint32_t i) { return constraints.contacts[i].parting_target() > S(0); }) &&
           std::all_of(island.contacts.begin(), island.contacts.end(),
                       [&](std::uint32_t i) {
                         const ContactConstraint<S>& c = constraints.contacts[i];
                         const bool is_still = c.drift[0] == S(0) && c.drift[1] == S(0);
                         return is_still && rests(c.body_a) && rests(c.body_b);
                       }) &&
           std::all_of(island.blocks.begin(), island.blocks.end(), [&](std::uint32_t i) {
             const ConstraintBlock<S>& block = constraints.blocks[i];
             const bool is_motor = block.kind == BlockKind::bounded && block.is_of_joint();
             return !is_motor && rests(block.body_a) && rests(block.body_b);
           });
  }

  /// [1] Share of the way from the velocities v without bounces to those with them, v + d. It is
  /// the root of |v + s d|^2 = |v + d|^2 - gained.
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
  DynamicArray<Twist<S>> bouncing_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
