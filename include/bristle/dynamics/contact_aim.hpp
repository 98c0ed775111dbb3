/// @file
/// From points of contact to constraints, and what a contact aims at within one step.
///
/// A contact is judged by the gap that motion without it would leave at the end of the step. Where
/// that is not negative the surfaces may approach by what there is and no more (a speculative
/// contact); where it is, they must not approach any more at the end. Bounces are placed at the
/// time of impact within the step. docs/solver.md derives all of it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/contact_cache.hpp>
#include <bristle/dynamics/material.hpp>
#include <bristle/dynamics/solver_types.hpp>
#include <bristle/math/rotation.hpp>

namespace bristle {

/// Adds one constraint for every point of a manifold, warm with the impulses it has.
template <Scalar S>
void add_contacts(const CachedManifold<S>& manifold, const std::vector<CachedPoint<S>>& points,
                  const Material<S>& material, std::uint32_t slot_a, std::uint32_t slot_b,
                  Constraints<S>& out) {
  ContactConstraint<S> c;
  c.body_a = slot_a;
  c.body_b = slot_b;
  c.axes[0] = manifold.normal;
  tangent_basis<S>(manifold.normal, c.axes[1], c.axes[2]);
  c.friction = material.friction;
  c.restitution = material.restitution;
  for (std::uint32_t i = manifold.first; i < manifold.first + manifold.count; ++i) {
    const CachedPoint<S>& point = points[i];
    c.arm_a = point.arm_a;
    c.arm_b = point.arm_b;
    c.gap = point.gap;
    c.impulse = point.impulse;
    c.is_fresh = point.is_fresh;
    out.contacts.push_back(c);
  }
}

/// [m/s] Normal velocities of a contact: at the start of the step, and at its end and in the mean
/// of it if nothing but free motion acted.
template <Scalar S>
struct NormalSpeeds {
  S start, free, free_motion;
};

/// Sets what a contact wants of the velocities at the end of the step.
template <Scalar S>
void aim_contact(ContactConstraint<S>& c, const SolverBody<S>& a, const SolverBody<S>& b,
                 const SolveContext<S>& context);
/// The same where its normal velocities are known.
/// @param follows_joints  Whether one of its bodies moves with a mechanism.
template <Scalar S>
void aim_contact(ContactConstraint<S>& c, const NormalSpeeds<S>& speeds, bool follows_joints,
                 const SolveContext<S>& context);

/// Share of the impulse that a contact will have taken when the step ends, by default and for
/// bounces; to be called when impulses are known.
///
/// @param normal_velocity  [m/s] At the end of the step; not asked for without restitution.
template <Scalar S>
void place_contact(ContactConstraint<S>& c, S normal_velocity, Integrator integrator) {
  c.parts = c.restitution > S(0) && normal_velocity > S(0);
  const S usual = integrator == Integrator::trapezoidal ? S(0.5) : S(1);
  if (c.bounce_share >= S(0)) {
    c.placed = c.least_placed = c.bounce_share * c.impulse[0];
  } else {
    c.placed = usual * c.impulse[0];
    c.least_placed = integrator == Integrator::trapezoidal ? S(0) : c.placed;
  }
}

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// [1] When, as a share of the step, a gap closes that opens at the speed v0 and accelerates by a:
/// the first root of gap + v0 t + a t^2 / 2 in units of the step (v0 and a given in metres a step).
template <Scalar S>
[[nodiscard]] S closing_time(S gap, S v0, S a) {
  using std::max;
  using std::min;
  using std::sqrt;
  if (gap <= S(0)) return S(0);
  // In the form that loses no digits where a is small; v0 < 0.
  const S root = sqrt(max(S(0), v0 * v0 - S(2) * a * gap));
  return min(S(1), S(2) * gap / (root - v0));
}

}  // namespace detail

template <Scalar S>
void aim_contact(ContactConstraint<S>& c, const SolverBody<S>& a, const SolverBody<S>& b,
                 const SolveContext<S>& context) {
  const Vec3<S>& n = c.axes[0];
  const Vec3<S> torque_a = c.arm_a.cross(n);
  const Vec3<S> torque_b = c.arm_b.cross(n);
  const auto normal_part = [&](const Twist<S>& u, const Twist<S>& v) {
    return n.dot(v.linear - u.linear) + (torque_b.dot(v.angular) - torque_a.dot(u.angular));
  };
  const NormalSpeeds<S> speeds{normal_part(a.start, b.start), normal_part(a.free, b.free),
                               normal_part(a.free_motion, b.free_motion)};
  aim_contact(c, speeds, a.follows_joints || b.follows_joints, context);
}

template <Scalar S>
void aim_contact(ContactConstraint<S>& c, const NormalSpeeds<S>& speeds, bool follows_joints,
                 const SolveContext<S>& context) {
  using std::max;
  using std::min;
  const S dt = context.dt;
  const bool is_trapezoidal = context.integrator == Integrator::trapezoidal;
  const S start = speeds.start;
  const S free = speeds.free;
  const S change = free - start;  // What forces do to the normal velocity within the step.
  const bool closes = c.gap + dt * speeds.free_motion < S(0);
  const bool bounces = c.restitution > S(0) && closes && start < -context.restitution_speed;
  c.bounce_share = S(-1);
  // What carried a load and approaches all the same does so because sweeps were cut short.
  const bool is_loaded = context.is_swept && c.impulse[0] > S(0);
  c.is_impact = closes && -start > context.speed_change && !is_loaded;
  // An impact says nothing about the load that follows, nor the load about the impact.
  if (c.is_impact) c.impulse = {};

  if (!is_trapezoidal) {
    c.target = c.gap > S(0) ? -c.gap / dt : S(0);
    if (bounces) c.target = max(c.target, -c.restitution * start);
    return;
  }
  if (bounces && follows_joints) {
    // What changes the speed of a mechanism within the step depends on its speed, and must not be
    // given back to it as if it were a constant force.
    c.target = -c.restitution * free;
    return;
  }
  if (bounces) {
    const S time = detail::closing_time(c.gap, dt * start, dt * change);
    const S after = -c.restitution * (start + time * change);
    const S rest = (S(1) - time) * change;
    // A bounce too low to leave the surface within this step is none.
    if (S(2) * after > -rest) {
      c.target = after + rest;
      c.bounce_share = S(1) - time;
      return;
    }
  }
  if (closes || (c.gap <= context.position_tolerance && value_of(c.restitution) == 0)) {
    c.target = S(0);
    return;
  }
  // Free flight that does not touch must not feel the contact; others may still push the bodies
  // together, by the gap at most. Where they bounce the speed of approach is not lost, so they may
  // come together as fast as closes the gap by the end of the step: stopping bodies that part would
  // give energy to whatever pushes them.
  c.target = min(free, c.restitution > S(0) ? S(-2) * c.gap / dt - start : -c.gap / dt);
}

}  // namespace bristle
