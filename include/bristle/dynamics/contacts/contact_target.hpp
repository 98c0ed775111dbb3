/// @file
/// Constraints from contact points, and their velocity targets within one step.
///
/// The target depends on the gap at the end of the step without the contact. If that gap is not
/// negative, the surfaces may close the present gap and no more. Such a contact is speculative. If
/// it is negative, they must not approach at the end. Bounces happen at the time of impact within
/// the step. docs/solver.md derives all of it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/contact_cache.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/bodies/material.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/math/lane_value.hpp>
#include <bristle/math/rotation.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Adds one constraint for every point of a manifold. Its impulses are the warm start.
/// @param drift  [m/s] Velocity of a's surface on its body less that of b's on its own, world axes.
template <Scalar S>
void add_contacts(const CachedManifold<S>& manifold, const DynamicArray<CachedPoint<S>>& points,
                  const Material<S>& material, const Vec3<S>& drift, std::uint32_t slot_a,
                  std::uint32_t slot_b, Constraints<S>& out) {
  ContactConstraint<S> c;
  c.body_a = slot_a;
  c.body_b = slot_b;
  c.first_point = manifold.first;
  c.axes[0] = manifold.normal;
  tangent_basis<S>(manifold.normal, c.axes[1], c.axes[2]);
  c.drift = {c.axes[1].dot(drift), c.axes[2].dot(drift)};
  c.bias = {S(0), c.drift[0], c.drift[1]};
  c.friction = material.friction;
  c.restitution = material.restitution;
  for (std::uint32_t i = manifold.first; i < manifold.first + manifold.count; ++i) {
    const CachedPoint<S>& point = points[i];
    c.arm_a = point.arm_a;
    c.arm_b = point.arm_b;
    c.gap = point.gap;
    c.impulse = point.impulse;
    c.position_excess = point.position_excess;
    c.point = i;
    c.is_fresh = point.is_fresh;
    out.contacts.push_back(c);
  }
}

/// Moves a contact to the instant at which its impulse acts. Finds its bias.
///
/// Surfaces stay together as seen from the arms at the end of the step, r1 = rm + d. Here rm is the
/// arm in the middle of the step. Half of its change is d. In rows with the arm rm the velocities
/// at the end leave -w x d. The mean of the velocities at both ends leaves nothing. So an impulse
/// at rm does no work on pivoting bodies. Trapezoidal steps therefore take the arms rm.
///
/// With symplectic Euler the displacement follows from the velocities at the end. These are those
/// of the middle of the step. Impulses act at its start, as in the leapfrog method of Stoermer and
/// Verlet with constraints (SHAKE; Hairer, Lubich and Wanner, Geometric Numerical Integration,
/// VII.1). So arms stay, and the end leaves the same -w x d. docs/solver.md derives it.
///
/// @param point     The point of the contact.
/// @param hold      [1] `hold_of` the impulses of its manifold. Where surfaces slide, the rotation
///                  of the normal counts as much as that of the arms. It is not known.
template <Scalar S>
void time_contact(ContactConstraint<S>& c, CachedPoint<S>& point, const S& hold,
                  const SolverBody<S>& a, const SolverBody<S>& b, const SolveContext<S>& context);

/// [m/s] Normal velocities of a contact. They are those that the start leaves (`kept_start`), and
/// of free motion at its end and in the mean. Free motion adds to these by forces alone: it goes on
/// after a bounce, while damping follows the velocity.
template <Value T>
struct NormalSpeeds {
  T start, free, mean_free;
};

/// Target normal velocity of a contact, or of several. Tells how it was chosen. It is the result of
/// one formula that serves constraints and lanes.
template <Value T>
struct ContactTarget {
  /// Like the fields of `ContactConstraint` with these names.
  T target, restitution_share;
  Truth<T> is_impact;
};
/// Finds the target from the velocities at the start of a contact.
/// @param impulse         [N s] Warm start along the normal.
/// @param follows_joints  True if one of its bodies moves with a mechanism.
template <Value T>
BRISTLE_FORCE_INLINE ContactTarget<T> target_at(const T& gap, const T& restitution,
                                                const T& impulse, const NormalSpeeds<T>& speeds,
                                                const Truth<T>& follows_joints,
                                                const SolveContext<ScalarOf<T>>& context);
/// Sets the velocity target of a contact.
template <Scalar S>
void target_contact(ContactConstraint<S>& c, const SolverBody<S>& a, const SolverBody<S>& b,
                    const SolveContext<S>& context);

/// Position impulse of a contact, or of several. It is apart from `ContactTarget` since it follows
/// from solved impulses.
template <Value T>
struct PositionImpulse {
  /// Like the fields of `ContactConstraint` with these names.
  T position_impulse, least_position_impulse;
  Truth<T> is_separating;
};
/// Share of the impulse that acts within the step. It depends on whether the contact bounces. Call
/// it when impulses are known.
///
/// @param impulse          [N s] Along the normal.
/// @param normal_velocity  [m/s] At the end of the step. Unused without restitution.
template <Value T>
BRISTLE_FORCE_INLINE PositionImpulse<T> position_impulse_of(
    const T& impulse, const T& restitution, const ContactTarget<T>& target,
    const T& normal_velocity, const SolveContext<ScalarOf<T>>& context);
/// Sets the position impulse of a contact (`position_impulse_of`).
template <Scalar S>
void set_position_impulse(ContactConstraint<S>& c, S normal_velocity,
                          const SolveContext<S>& context) {
  const ContactTarget<S> target{c.parting_target(), c.restitution_share, c.is_impact};
  const PositionImpulse<S> found =
      position_impulse_of<S>(c.impulse[0], c.restitution, target, normal_velocity, context);
  c.position_impulse = found.position_impulse;
  c.least_position_impulse = found.least_position_impulse;
  c.is_separating = found.is_separating;
}

/// [1] Share of an impulse that moves the bodies within the step, without a bounce.
template <Scalar S>
[[nodiscard]] S usual_share(Integrator integrator) {
  return integrator == Integrator::trapezoidal ? S(0.5) : S(1);
}

/// Finds contacts with an impulse whose surfaces the displacements of the step leave apart. Their
/// position impulse is zero. Free motion alone would close them. Other contacts do not let it. They
/// are open, unless the step without their impulses closes them after all. Displacements follow
/// from impulses, so no other order can tell.
///
/// Only gaps larger than the motion of the surfaces by the velocities of the start count. Smaller
/// ones are not known well enough where surfaces slide. Where surfaces approach, they close without
/// any force.
///
/// @return True if any contact was found to be open or shut. The velocities are then to be solved
///         anew.
template <Scalar S>
[[nodiscard]] bool open_contacts(const Island& island, Constraints<S>& constraints,
                                 std::span<const SolverBody<S>> bodies,
                                 const SolveContext<S>& context);

// Implementation ----------------------------------------------------------------------------------

/// [1] Share of the step after which a gap closes. The gap opens at the speed v0 and accelerates by
/// a. It is the first root of gap + v0 t + a t^2 / 2, in units of the step. Units of v0 and a are
/// metres per step.
template <Value T>
[[nodiscard]] BRISTLE_FORCE_INLINE T closing_time(const T& gap, const T& v0, const T& a) {
  using S = ScalarOf<T>;
  using std::max;
  using std::min;
  using std::sqrt;
  const T zero = S(0);
  // This form loses no digits where a is small. Here v0 < 0.
  const T root = sqrt(max(zero, v0 * v0 - S(2) * a * gap));
  return select(gap <= zero, zero, min(T(S(1)), S(2) * gap / (root - v0)));
}

template <Scalar S>
void time_contact(ContactConstraint<S>& c, CachedPoint<S>& point, const S& hold,
                  const SolverBody<S>& a, const SolverBody<S>& b, const SolveContext<S>& context) {
  const Vec3<S>& to_mid_a = point.mid_offset_a *= hold;
  const Vec3<S>& to_mid_b = point.mid_offset_b *= hold;
  // Large islands get no bias: sweeps that are cut short keep no energy. Sweeps over manifolds do
  // not read it at all.
  if (!context.is_large()) {
    const Vec3<S> bias = a.start.angular.cross(to_mid_a) - b.start.angular.cross(to_mid_b);
    for (std::size_t k = 0; k < 3; ++k) c.bias[k] += c.axes[k].dot(bias);
  }
  if (context.integrator == Integrator::trapezoidal) {
    point.acts_at_mid = true;
    c.arm_a += to_mid_a;
    c.arm_b += to_mid_b;
  } else {
    // The displacement is the velocity at the end. Its bias closes no gap.
    c.gap -= context.dt * c.bias[0];
  }
}

template <Value T>
BRISTLE_FORCE_INLINE ContactTarget<T> target_at(const T& gap, const T& restitution,
                                                const T& impulse, const NormalSpeeds<T>& speeds,
                                                const Truth<T>& follows_joints,
                                                const SolveContext<ScalarOf<T>>& context) {
  using S = ScalarOf<T>;
  using std::max;
  using std::min;
  const T zero = S(0);
  const T dt = context.dt;
  const T start = speeds.start;
  const T free = speeds.free;
  const T change = free - start;  // Velocity change by forces.
  const T closing_speed = gap / dt;
  const Truth<T> may_bounce = restitution > zero;
  const T end_gap = gap + dt * speeds.mean_free;
  // Bodies that came as near as they may in the last step close their gap exactly at the end of
  // this one. Round-off must not decide that point by point. Surfaces that bounce fly on.
  const Truth<T> touches =
      (end_gap < zero) | ((min(gap, end_gap) <= T(context.position_tolerance)) & !may_bounce);
  const Truth<T> bounces = may_bounce & touches & (start < T(-context.restitution_speed));
  ContactTarget<T> target;
  target.restitution_share = S(-1);
  // A contact that carried a load should not approach. If it does, the last step was not solved
  // better than what drives the island, or sweeps were cut short.
  const Truth<T> is_loaded = impulse > zero;
  const T usual = select(is_loaded, T(context.driven_change), T(context.speed_change));
  target.is_impact = touches & (-start > usual);
  if (context.is_swept) target.is_impact = target.is_impact & !is_loaded;
  if (context.integrator != Integrator::trapezoidal) {
    target.target = select(gap > zero, -closing_speed, zero);
    target.target = select(bounces, max(target.target, -restitution * start), target.target);
    return target;
  }
  // A contact must not act on free flight that does not touch. Other constraints may still push the
  // bodies together. They may close the gap at most. If they bounce, the speed of approach is not
  // lost. They may then come together as fast as closes the gap by the end of the step. Stopping
  // bodies that separate would give energy to whatever pushes them.
  const T nearest = select(may_bounce, S(-2) * closing_speed - start, -closing_speed);
  target.target = select(touches, zero, min(free, nearest));
  if (!any(bounces)) return target;
  const T time = closing_time<T>(gap, dt * start, dt * change);
  const T after = -restitution * (start + time * change);
  const T rest = (S(1) - time) * change;
  // A bounce must leave the surface within this step. Lower ones are ignored.
  const Truth<T> leaves = bounces & !follows_joints & (S(2) * after > -rest);
  target.target = select(leaves, after + rest, target.target);
  target.restitution_share = select(leaves, S(1) - time, target.restitution_share);
  // The speed change of a mechanism within the step depends on its speed. A constant force must not
  // restore it.
  target.target = select(bounces & follows_joints, -restitution * free, target.target);
  return target;
}

template <Scalar S>
void target_contact(ContactConstraint<S>& c, const SolverBody<S>& a, const SolverBody<S>& b,
                    const SolveContext<S>& context) {
  const Vec3<S>& n = c.axes[0];
  const Vec3<S> torque_a = c.arm_a.cross(n);
  const Vec3<S> torque_b = c.arm_b.cross(n);
  const auto normal_part = [&](const Twist<S>& u, const Twist<S>& v) {
    return n.dot(v.linear - u.linear) + (torque_b.dot(v.angular) - torque_a.dot(u.angular));
  };
  // Most bodies are not damped. Their velocities need no copy.
  const bool keeps_all = a.keeps_all() && b.keeps_all();
  const NormalSpeeds<S> speeds{
      keeps_all ? normal_part(a.start, b.start) : normal_part(a.kept_start(), b.kept_start()),
      normal_part(a.free, b.free), normal_part(a.mean_free, b.mean_free)};
  const bool is_trapezoidal = context.integrator == Integrator::trapezoidal;
  c.transient_impulse = {};
  if (c.is_open) {
    c.target = -c.gap / context.dt;
    c.restitution_share = S(-1);
    c.is_impact = false;
    c.impulse = {};
    return;
  }
  const S gap = is_trapezoidal ? c.gap : c.gap + context.dt * c.bias[0];
  const ContactTarget<S> target = target_at<S>(gap, c.restitution, c.impulse[0], speeds,
                                               a.follows_joints || b.follows_joints, context);
  c.target = target.target;
  // Surfaces that touch in a trapezoidal step stay together. Those that fly on or bounce do not.
  if (!is_trapezoidal || target.target == S(0)) c.target += c.bias[0];
  c.restitution_share = target.restitution_share;
  c.is_impact = target.is_impact;
  // An impact does not predict the load that follows. Neither does the load predict the impact.
  if (c.is_impact) c.impulse = {};
}

template <Value T>
BRISTLE_FORCE_INLINE PositionImpulse<T> position_impulse_of(
    const T& impulse, const T& restitution, const ContactTarget<T>& target,
    const T& normal_velocity, const SolveContext<ScalarOf<T>>& context) {
  using S = ScalarOf<T>;
  const T zero = S(0);
  const Truth<T> is_timed = target.restitution_share >= zero;
  const bool is_trapezoidal = context.integrator == Integrator::trapezoidal;
  PositionImpulse<T> found;
  found.position_impulse =
      select(is_timed, target.restitution_share, T(usual_share<S>(context.integrator))) * impulse;
  found.least_position_impulse =
      is_trapezoidal ? select(is_timed, found.position_impulse, zero) : found.position_impulse;
  // A contact that may bounce needs more than any speed apart. At rest round-off decides that.
  // Heaps of such bodies would sink into themselves.
  const Truth<T> has_bounced = target.target > zero;
  const Truth<T> flies_apart = normal_velocity > T(context.restitution_speed);
  const Truth<T> may_bounce = restitution > zero;
  found.is_separating = may_bounce & (flies_apart | (has_bounced & (normal_velocity > zero)));
  return found;
}

template <Scalar S>
bool open_contacts(const Island& island, Constraints<S>& constraints,
                   std::span<const SolverBody<S>> bodies, const SolveContext<S>& context) {
  using std::max;
  using std::min;
  bool has_changed = false;
  for (const std::uint32_t i : island.contacts) {
    ContactConstraint<S>& c = constraints.contacts[i];
    if (!(c.impulse[0] > S(0))) continue;
    if (c.is_open) {
      c.is_open = false;
      c.is_shut = has_changed = true;
      continue;
    }
    const bool may_open = !c.is_shut && !c.is_separating && c.parting_target() == S(0);
    if (!may_open || c.position_impulse > S(0)) continue;
    const SolverBody<S>& a = bodies[c.body_a];
    const SolverBody<S>& b = bodies[c.body_b];
    const S left = min(c.gap, c.gap + context.dt * c.normal_velocity(a.motion, b.motion));
    const S moved = context.dt * c.velocity(a.start, b.start).norm();
    if (left > max(context.position_tolerance, moved)) c.is_open = has_changed = true;
  }
  return has_changed;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
