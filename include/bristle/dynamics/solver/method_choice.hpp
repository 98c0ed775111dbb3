/// @file
/// The choice between factorisations and sweeps for one island, and where factorisations start.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/disjoint_sets.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/solver/island_order.hpp>
#include <bristle/dynamics/solver/solver_constants.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <algorithm>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Returns whether the load must be spread by factorisation. Sweeps put all load on the first
/// points. That would decide the readings of sensors and contacts, or whether a grip slips.
template <Scalar S>
[[nodiscard]] bool needs_even_load(const Island& island, const Constraints<S>& constraints) {
  if (!island.soft.empty() || has_joints(island, constraints)) return true;
  return island.contacts.size() > 1 &&
         std::all_of(island.contacts.begin(), island.contacts.end(),
                     [&](std::uint32_t i) { return constraints.contacts[i].is_fresh; });
}

/// [m^2/s^2] Square of the speed at which the surfaces of a contact slide.
/// @param v  [m/s] Velocity of the contact (`ContactConstraint::velocity`).
template <Scalar S>
[[nodiscard]] S slip2_of(const ContactConstraint<S>& c, const Vec3<S>& v) {
  const S slip1 = c.axes[1].dot(v) - c.drift[0];
  const S slip2 = c.axes[2].dot(v) - c.drift[1];
  return slip1 * slip1 + slip2 * slip2;
}

/// Returns whether no rough surfaces of an island that carry load slide. Those that do have an
/// impulse at the edge of its friction cone, and they move. Surfaces that rest may be at the edge
/// where the load is spread over more points than it needs. Surfaces whose impulse is within its
/// cone move where a driven body has a new velocity.
template <Scalar S>
[[nodiscard]] bool is_held(const Island& island, const Constraints<S>& constraints,
                           std::span<const SolverBody<S>> bodies, const SolveContext<S>& context) {
  const S still2 = context.velocity_tolerance * context.velocity_tolerance;
  return std::none_of(island.contacts.begin(), island.contacts.end(), [&](std::uint32_t i) {
    const ContactConstraint<S>& c = constraints.contacts[i];
    const bool is_at_edge =
        c.friction * c.impulse[0] > S(0) && hold_of(c.impulse, c.friction) < S(chosen::edge_hold);
    if (!is_at_edge) return false;
    return slip2_of(c, c.velocity(bodies[c.body_a].start, bodies[c.body_b].start)) > still2;
  });
}

/// The choice with its scratch memory. One object serves many islands in turn.
template <Scalar S>
class MethodChoice {
 public:
  /// Chooses between factorisations and sweeps. Sets `factor_work`, `is_costly_heap`,
  /// `is_swept` and `slides` of the context.
  void make(const Island& island, const Constraints<S>& constraints,
            std::span<const SolverBody<S>> bodies, SolveContext<S>& context) {
    const std::uint64_t most = context.settings.max_direct_work;
    // A row of a contact is squared over both of its bodies, in three blocks. A contact has three
    // rows, and a block of rows counts as many.
    const std::uint64_t rows = 3 * (island.contacts.size() + island.blocks.size());
    const std::uint64_t assembly =
        chosen::contact_row_work * rows + chosen::soft_block_work * island.soft.size();
    const std::uint64_t unknowns = 6 * island.bodies.size();
    // The Cholesky factor of a full matrix of n unknowns takes n^3 / 6 multiply-adds.
    const std::uint64_t dense = assembly + unknowns * unknowns * unknowns / 6;
    const bool may_be_large = dense > most;
    context.slides = dense > most / chosen::sliding_work_divisor &&
                     has_sliding_heap(island, constraints, bodies, context);
    context.factor_work = dense;
    if (!may_be_large && !context.slides) return;
    if (assembly <= most) {
      const std::uint64_t elimination =
          order_.factor_work(island, constraints, bodies.size(), most - assembly);
      const std::uint64_t work = std::min(dense, assembly + elimination);
      // The full matrix bounds the work of small islands. It decides what their budget allows.
      if (may_be_large) {
        context.factor_work = work;
        context.is_costly_heap = elimination > most / chosen::mechanism_work_divisor &&
                                 has_short_mechanisms(island, constraints, bodies, context);
      }
      context.is_swept =
          context.is_large() || (context.slides && work > most / chosen::sliding_work_divisor);
    } else {
      context.is_swept = true;
    }
  }

 private:
  /// Returns whether an island has contacts alone, none of which may bounce, and surfaces that
  /// slide or close faster than forces change velocities in a step. Islands at rest or held have to
  /// be exact. Where one contact slides, all of its island is swept.
  [[nodiscard]] static bool has_sliding_heap(const Island& island,
                                             const Constraints<S>& constraints,
                                             std::span<const SolverBody<S>> bodies,
                                             const SolveContext<S>& context) {
    // Derivatives need a solution. Symplectic Euler is for those who ask for it.
    if (derivatives_of<S> != 0 || context.integrator != Integrator::trapezoidal) return false;
    if (!island.blocks.empty() || !island.soft.empty()) return false;
    S fastest2 = S(0);
    for (const std::uint32_t i : island.contacts) {
      const ContactConstraint<S>& c = constraints.contacts[i];
      if (c.restitution > S(0)) return false;
      const Vec3<S> v = c.velocity(bodies[c.body_a].start, bodies[c.body_b].start);
      const S closing = std::min(S(0), c.axes[0].dot(v));
      const bool touches = c.impulse[0] > S(0) || c.gap + context.dt * closing < S(0);
      if (!touches) continue;
      fastest2 = std::max(fastest2, closing * closing + slip2_of(c, v));
    }
    return fastest2 > context.fast() * context.fast();
  }

  /// Returns whether an island has contacts between mechanisms, none of which has more bodies than
  /// sweeps carry a load along. Each sweep carries it by about one body. A long chain that is swept
  /// tears, and a rope without contacts takes one factorisation however it moves.
  [[nodiscard]] bool has_short_mechanisms(const Island& island, const Constraints<S>& constraints,
                                          std::span<const SolverBody<S>> bodies,
                                          const SolveContext<S>& context) {
    // Derivatives need a solution.
    if (derivatives_of<S> != 0 || island.contacts.empty()) return false;
    if (!has_joints(island, constraints)) return false;
    mechanisms_.reset(bodies.size());
    for (const std::uint32_t i : island.blocks) {
      const ConstraintBlock<S>& block = constraints.blocks[i];
      const bool connects =
          block.is_of_joint() && bodies[block.body_a].moves && bodies[block.body_b].moves;
      if (connects) mechanisms_.join(block.body_a, block.body_b);
    }
    sizes_.assign(bodies.size(), 0);
    return std::none_of(island.bodies.begin(), island.bodies.end(), [&](std::uint32_t slot) {
      return ++sizes_[mechanisms_.find(slot)] > context.settings.large_sweeps;
    });
  }

  IslandOrder order_;
  DisjointSets mechanisms_;
  DynamicArray<int> sizes_;  // Bodies of each mechanism.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
