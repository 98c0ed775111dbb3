/// @file
/// Sweeps that stop the spread of overflows. They are for islands whose solution is not finite.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/contacts/contact_target.hpp>
#include <bristle/dynamics/contacts/saved_impulses.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/math/finite.hpp>

#include <array>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Sweeps over the contacts and joints of an island, without a warm start. An update is undone if
/// the squared velocity of a body would not be finite. A body whose masses overflow then touches
/// nothing. Its neighbours keep their supports. Soft blocks get no impulse.
///
/// Bodies move by the velocity at the end of the step. It closes no gap and opens no overlap.
template <Scalar S>
class GuardedSweeps {
 public:
  static void solve(const Island& island, Constraints<S>& constraints,
                    std::span<SolverBody<S>> bodies, const SolveContext<S>& context) {
    clear_impulses(island, constraints);
    for (const std::uint32_t slot : island.bodies) {
      SolverBody<S>& body = bodies[slot];
      if (!has_finite_square<S>(body.free.linear) || !has_finite_square<S>(body.free.angular)) {
        body.free = {};
      }
      body.twist = body.free;
      body.follows_joints = false;
    }
    for (const std::uint32_t i : island.contacts) {
      ContactConstraint<S>& c = constraints.contacts[i];
      target_contact(c, bodies[c.body_a], bodies[c.body_b], context);
    }
    for (int n = 0; n < context.settings.max_sweeps; ++n) {
      for (const std::uint32_t i : island.blocks) update_block(constraints, i, bodies);
      for (const std::uint32_t i : island.contacts) update_contact(constraints.contacts[i], bodies);
    }
    for (const std::uint32_t slot : island.bodies) bodies[slot].motion = bodies[slot].twist;
  }

 private:
  [[nodiscard]] static bool is_finite(const SolverBody<S>& body) {
    return has_finite_square<S>(body.twist.linear) && has_finite_square<S>(body.twist.angular);
  }

  static void update_contact(ContactConstraint<S>& c, std::span<SolverBody<S>> bodies) {
    SolverBody<S>& a = bodies[c.body_a];
    SolverBody<S>& b = bodies[c.body_b];
    const std::array<S, 3> impulse = c.impulse;
    const Twist<S> twist_a = a.twist;
    const Twist<S> twist_b = b.twist;
    const ContactResponse<S> K = contact_response(c, ContactFrame<S>(c, a, b));
    const std::array<S, 3> x = solve_contact(c, K, c.velocity(a.twist, b.twist));
    apply_at_contact<S>(c, x[0] * c.axes[0] + x[1] * c.axes[1] + x[2] * c.axes[2], a, b,
                        velocity_of);
    if (is_finite(a) && is_finite(b) && has_finite_square<S>(c.impulse_W())) return;
    c.impulse = impulse;
    a.twist = twist_a;
    b.twist = twist_b;
  }

  static void update_block(Constraints<S>& constraints, std::uint32_t index,
                           std::span<SolverBody<S>> bodies) {
    const ConstraintBlock<S>& block = constraints.blocks[index];
    ConstraintRow<S>* rows = &constraints.rows[block.first];
    SolverBody<S>& a = bodies[block.body_a];
    SolverBody<S>& b = bodies[block.body_b];
    const Twist<S> twist_a = a.twist;
    const Twist<S> twist_b = b.twist;
    BlockResponse<S> response;
    local_response(block, rows, a, b, response);
    S impulse[ConstraintBlock<S>::max_rows];
    S velocity[ConstraintBlock<S>::max_rows];
    S change[ConstraintBlock<S>::max_rows];
    for (std::size_t i = 0; i < block.count; ++i) {
      impulse[i] = rows[i].impulse;
      velocity[i] = rows[i].velocity(a.twist, b.twist);
    }
    solve_block(block, response, velocity, rows, change);
    bool has_finite_impulses = true;
    for (std::size_t i = 0; i < block.count; ++i) {
      apply_row(rows[i], change[i], a, b, velocity_of);
      has_finite_impulses = has_finite_impulses && has_finite_square(rows[i].impulse);
    }
    if (is_finite(a) && is_finite(b) && has_finite_impulses) return;
    for (std::size_t i = 0; i < block.count; ++i) rows[i].impulse = impulse[i];
    a.twist = twist_a;
    b.twist = twist_b;
  }
};

}  // namespace bristle::inline BRISTLE_ABI::detail
