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
#include <bristle/dynamics/bodies/material.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/math/lane_value.hpp>
#include <bristle/math/rotation.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

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
    c.point = i;
    c.is_fresh = point.is_fresh;
    out.contacts.push_back(c);
  }
}

/// Takes a contact to the instant at which its impulse acts, and finds its bias.
///
/// Its surfaces stay together as seen from the arms at the end of the step, r1 = rm + d, where rm is
/// the arm in the middle of the step and d half of what it changes by: in rows with the arm rm the
/// velocities at the end leave -w x d. The mean of the velocities at both ends leaves nothing, so
/// that an impulse at rm does no work on what pivots: trapezoidal steps take the arms rm. With
/// symplectic Euler the displacement follows from the velocities at the end, which are those of the
/// middle of the step, and impulses act at its start, as in the leapfrog method of Stoermer and
/// Verlet with constraints (SHAKE; Hairer, Lubich and Wanner, Geometric Numerical Integration,
/// VII.1): arms stay, and the end leaves the same -w x d.
/// docs/solver.md derives it.
///
/// @param point     The point of the contact.
/// @param hold      [1] `hold_of` the impulses of its manifold. Where surfaces slide the turning of
///                  the normal counts as much as that of the arms, and is not known.
/// @param is_swept  Large islands have the arms alone: sweeps that are cut short keep no energy.
template <Scalar S>
void time_contact(ContactConstraint<S>& c, CachedPoint<S>& point, const S& hold,
                  const SolverBody<S>& a, const SolverBody<S>& b, const SolveContext<S>& context,
                  bool is_swept);

/// [m/s] Normal velocities of a contact: at the start of the step, and at its end and in the mean
/// of it if nothing but free motion acted.
template <Value T>
struct NormalSpeeds {
  T start, free, free_motion;
};

/// What a contact wants of the step, or several of them do.
template <Value T>
struct ContactAim {
  /// As the fields of `ContactConstraint` with these names.
  T target, bounce_share;
  Truth<T> is_impact;
};
/// What the velocities that a contact starts from ask of it.
/// @param impulse         [N s] That it starts from, along the normal.
/// @param follows_joints  Whether one of its bodies moves with a mechanism.
template <Value T>
BRISTLE_INLINE ContactAim<T> aim_at(const T& gap, const T& restitution, const T& impulse,
                                    const NormalSpeeds<T>& speeds, const Truth<T>& follows_joints,
                                    const SolveContext<ScalarOf<T>>& context);
/// Sets what a contact wants of the velocities at the end of the step.
template <Scalar S>
void aim_contact(ContactConstraint<S>& c, const SolverBody<S>& a, const SolverBody<S>& b,
                 const SolveContext<S>& context);

/// What moves the bodies of a contact within the step, or those of several contacts.
template <Value T>
struct ContactPlace {
  /// As the fields of `ContactConstraint` with these names.
  T placed, least_placed;
  Truth<T> parts;
};
/// Share of the impulse that a contact will have taken when the step ends, by default and for
/// bounces; to be called when impulses are known.
///
/// @param impulse          [N s] Along the normal.
/// @param normal_velocity  [m/s] At the end of the step; of no account without restitution.
template <Value T>
BRISTLE_INLINE ContactPlace<T> place_of(const T& impulse, const T& restitution,
                                        const ContactAim<T>& aim, const T& normal_velocity,
                                        const SolveContext<ScalarOf<T>>& context);
template <Scalar S>
void place_contact(ContactConstraint<S>& c, S normal_velocity, const SolveContext<S>& context) {
  const ContactAim<S> aim{c.parting_target(), c.bounce_share, c.is_impact};
  const ContactPlace<S> place =
      place_of<S>(c.impulse[0], c.restitution, aim, normal_velocity, context);
  c.placed = place.placed;
  c.least_placed = place.least_placed;
  c.parts = place.parts;
}

/// [1] Share of an impulse that moves the bodies of contacts that do not bounce.
template <Scalar S>
[[nodiscard]] S usual_share(Integrator integrator) {
  return integrator == Integrator::trapezoidal ? S(0.5) : S(1);
}

/// Finds contacts that press though the displacements of the step leave their surfaces apart and
/// need nothing of their impulse: free motion alone would close them, and other contacts do not let
/// it. They are open, unless the step without their impulses closes them after all. There is no
/// other order to tell it in, since displacements follow from impulses. Only gaps count that are
/// larger than the way which the velocities of the start move the surfaces by: smaller ones are not
/// known well enough where surfaces slide, and closed without any force where they approach.
///
/// @return Whether any contact was found to be open or shut, so that the velocities are to be solved
///         anew.
template <Scalar S>
[[nodiscard]] bool open_contacts(const Island& island, Constraints<S>& constraints,
                                 std::span<const SolverBody<S>> bodies,
                                 const SolveContext<S>& context);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// [1] When, as a share of the step, a gap closes that opens at the speed v0 and accelerates by a:
/// the first root of gap + v0 t + a t^2 / 2 in units of the step (v0 and a given in metres a step).
template <Value T>
[[nodiscard]] BRISTLE_INLINE T closing_time(const T& gap, const T& v0, const T& a) {
  using S = ScalarOf<T>;
  using std::max;
  using std::min;
  using std::sqrt;
  const T zero = S(0);
  // In the form that loses no digits where a is small; v0 < 0.
  const T root = sqrt(max(zero, v0 * v0 - S(2) * a * gap));
  return select(gap <= zero, zero, min(T(S(1)), S(2) * gap / (root - v0)));
}

}  // namespace detail

template <Scalar S>
void time_contact(ContactConstraint<S>& c, CachedPoint<S>& point, const S& hold,
                  const SolverBody<S>& a, const SolverBody<S>& b, const SolveContext<S>& context,
                  bool is_swept) {
  const Vec3<S>& to_mid_a = point.mid_offset_a *= hold;
  const Vec3<S>& to_mid_b = point.mid_offset_b *= hold;
  if (!is_swept) {
    const Vec3<S> bias = a.start.angular.cross(to_mid_a) - b.start.angular.cross(to_mid_b);
    for (std::size_t k = 0; k < 3; ++k) c.bias[k] = c.axes[k].dot(bias);
  }
  if (context.integrator == Integrator::trapezoidal) {
    point.acts_at_mid = true;
    c.arm_a += to_mid_a;
    c.arm_b += to_mid_b;
  } else {
    // The displacement is the velocity at the end, whose bias closes no gap.
    c.gap -= context.dt * c.bias[0];
  }
}

template <Value T>
BRISTLE_INLINE ContactAim<T> aim_at(const T& gap, const T& restitution, const T& impulse,
                                    const NormalSpeeds<T>& speeds, const Truth<T>& follows_joints,
                                    const SolveContext<ScalarOf<T>>& context) {
  using S = ScalarOf<T>;
  using std::max;
  using std::min;
  const T zero = S(0);
  const T dt = context.dt;
  const T start = speeds.start;
  const T free = speeds.free;
  const T change = free - start;  // What forces do to the normal velocity within the step.
  const T closing_speed = gap / dt;
  const Truth<T> may_bounce = restitution > zero;
  const Truth<T> closes = gap + dt * speeds.free_motion < zero;
  const Truth<T> bounces = may_bounce & closes & (start < T(-context.restitution_speed));
  ContactAim<T> aim;
  aim.bounce_share = S(-1);
  aim.is_impact = closes & (-start > T(context.speed_change));
  // What carried a load and approaches all the same does so because sweeps were cut short.
  if (context.is_swept) aim.is_impact = aim.is_impact & !(impulse > zero);
  if (context.integrator != Integrator::trapezoidal) {
    aim.target = select(gap > zero, -closing_speed, zero);
    aim.target = select(bounces, max(aim.target, -restitution * start), aim.target);
    return aim;
  }
  // Free flight that does not touch must not feel the contact; others may still push the bodies
  // together, by the gap at most. Where they bounce the speed of approach is not lost, so they may
  // come together as fast as closes the gap by the end of the step: stopping bodies that part would
  // give energy to whatever pushes them.
  const Truth<T> touches = closes | ((gap <= T(context.position_tolerance)) & !may_bounce);
  const T nearest = select(may_bounce, S(-2) * closing_speed - start, -closing_speed);
  aim.target = select(touches, zero, min(free, nearest));
  if (!any(bounces)) return aim;
  const T time = detail::closing_time<T>(gap, dt * start, dt * change);
  const T after = -restitution * (start + time * change);
  const T rest = (S(1) - time) * change;
  // A bounce too low to leave the surface within this step is none.
  const Truth<T> leaves = bounces & !follows_joints & (S(2) * after > -rest);
  aim.target = select(leaves, after + rest, aim.target);
  aim.bounce_share = select(leaves, S(1) - time, aim.bounce_share);
  // What changes the speed of a mechanism within the step depends on its speed, and must not be
  // given back to it as if it were a constant force.
  aim.target = select(bounces & follows_joints, -restitution * free, aim.target);
  return aim;
}

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
  const bool is_trapezoidal = context.integrator == Integrator::trapezoidal;
  c.passing = {};
  if (c.is_open) {
    c.target = -c.gap / context.dt;
    c.bounce_share = S(-1);
    c.is_impact = false;
    c.impulse = {};
    return;
  }
  const S gap = is_trapezoidal ? c.gap : c.gap + context.dt * c.bias[0];
  const ContactAim<S> aim = aim_at<S>(gap, c.restitution, c.impulse[0], speeds,
                                      a.follows_joints || b.follows_joints, context);
  c.target = aim.target;
  // Surfaces that touch in a trapezoidal step stay together; those that fly on or bounce do not.
  if (!is_trapezoidal || aim.target == S(0)) c.target += c.bias[0];
  c.bounce_share = aim.bounce_share;
  c.is_impact = aim.is_impact;
  // An impact says nothing about the load that follows, nor the load about the impact.
  if (c.is_impact) c.impulse = {};
}

template <Value T>
BRISTLE_INLINE ContactPlace<T> place_of(const T& impulse, const T& restitution,
                                        const ContactAim<T>& aim, const T& normal_velocity,
                                        const SolveContext<ScalarOf<T>>& context) {
  using S = ScalarOf<T>;
  const T zero = S(0);
  const Truth<T> is_timed = aim.bounce_share >= zero;
  const bool is_trapezoidal = context.integrator == Integrator::trapezoidal;
  ContactPlace<T> place;
  place.placed =
      select(is_timed, aim.bounce_share, T(usual_share<S>(context.integrator))) * impulse;
  place.least_placed = is_trapezoidal ? select(is_timed, place.placed, zero) : place.placed;
  // Not whatever may bounce and has any speed apart: at rest round-off decides that, and heaps of
  // such bodies would sink into themselves.
  const Truth<T> has_bounced = aim.target > zero;
  const Truth<T> flies_apart = normal_velocity > T(context.restitution_speed);
  const Truth<T> may_bounce = restitution > zero;
  place.parts = may_bounce & (flies_apart | (has_bounced & (normal_velocity > zero)));
  return place;
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
    const bool may_open = !c.is_shut && !c.parts && c.parting_target() == S(0);
    if (!may_open || c.placed > S(0)) continue;
    const SolverBody<S>& a = bodies[c.body_a];
    const SolverBody<S>& b = bodies[c.body_b];
    const S left = min(c.gap, c.gap + context.dt * c.normal_velocity(a.motion, b.motion));
    const S moved = context.dt * c.velocity(a.start, b.start).norm();
    if (left > max(context.position_tolerance, moved)) c.is_open = has_changed = true;
  }
  return has_changed;
}

}  // namespace bristle::inline BRISTLE_ABI
