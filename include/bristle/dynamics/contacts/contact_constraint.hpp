/// @file
/// One contact point for the solvers. Its exact solution with other contacts held still.
///
/// Velocities and positions are two complementarity problems with one matrix (docs/solver.md). The
/// impulse `impulse` stops the approach of the surfaces at the end of the step. Its share
/// `position_impulse` acts early enough to move the bodies within the step. It keeps them from
/// overlapping. For a contact at rest the second is half of the first.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/no_index.hpp>
#include <bristle/dynamics/dynamics_constants.hpp>
#include <bristle/math/lane_value.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// [1] Share of a row's response that counts as round-off once other rows hold.
template <Scalar S>
[[nodiscard]] S no_mobility() {
  return S(chosen::no_mobility_roundings) * Tolerance<S>::round_off();
}

/// A contact point between bodies A and B. Its impulses act on B. They are along the normal (A to
/// B) and two tangents. It has the axes and targets of one step, which a `CachedPoint` does not
/// keep.
template <Scalar S>
struct ContactConstraint {
  /// [-] Slots of the two bodies.
  std::uint32_t body_a = 0;
  std::uint32_t body_b = 0;
  /// [m] From each centre of mass to the point, world axes. It is taken at the instant at which the
  /// impulse acts (`time_contact`).
  Vec3<S> arm_a = zero<Vec3<S>>();
  Vec3<S> arm_b = zero<Vec3<S>>();
  /// [-] Number of its `CachedPoint`.
  std::uint32_t point = 0;
  /// [-] The same of the first point of its manifold; `no_index` where it is not of a manifold.
  std::uint32_t first_point = no_index;
  /// [m/s] Final velocity along the axes, by these arms, of surfaces that stay together. It is not
  /// zero, since the arms go on turning, and since surfaces may run on their bodies.
  std::array<S, 3> bias{};
  /// [m/s] Part of `bias` along the tangents from surfaces that run on their bodies.
  std::array<S, 2> drift{};
  /// [1] Normal and two tangents, world axes.
  std::array<Vec3<S>, 3> axes{zero<Vec3<S>>(), zero<Vec3<S>>(), zero<Vec3<S>>()};
  /// [1] Coulomb friction coefficient and coefficient of restitution.
  S friction = S(0);
  S restitution = S(0);
  /// [m] Distance of the surfaces at the start of the step.
  S gap = S(0);
  /// [m/s] Lower bound of the final normal velocity.
  S target = S(0);
  /// [N s] Impulses along the axes, and the most that the one along the normal may be.
  std::array<S, 3> impulse{};
  S most_impulse = infinity<S>;
  /// [N s] Part of `impulse` that only stopped the initial velocity, where known. Subtracted from
  /// the warm start of the next step.
  std::array<S, 3> transient_impulse{};
  /// [N s] Position impulse, and its lower bound. It is the part of the normal impulse that moves
  /// the bodies within the step. Sweeps over manifolds store their own.
  S position_impulse = S(0);
  S least_position_impulse = S(0);
  /// [N s] Part of the position impulse that velocities did not give: that of the last substep
  /// times their number. Where surfaces slide fast, sweeps leave velocities far from their laws.
  /// The next step needs it as well, and its sweeps over manifolds start from it.
  S position_excess = S(0);
  /// [1] Share of the step that is left after a bounce. The same share of its impulse moves the
  /// bodies. Negative without a bounce.
  S restitution_share = S(-1);
  /// True if its bodies bounce or fly apart. An overlap then closes by itself.
  bool is_separating = false;
  /// True if the last step's impulse does not predict this one. The contact is then new, or took an
  /// impact.
  bool is_fresh = true;
  /// True if it stops an approach. False if it carries a load.
  bool is_impact = false;
  /// `is_open`: true if the motion of the step separates its surfaces. It then carries no load.
  /// `is_shut`: true if it was open, but closed without its impulse.
  bool is_open = false;
  bool is_shut = false;

  /// [m/s] Velocity of B's material relative to A's at the point.
  [[nodiscard]] Vec3<S> velocity(const Twist<S>& a, const Twist<S>& b) const {
    return b.at(arm_b) - a.at(arm_a);
  }
  /// [m/s] Normal part of `velocity`.
  [[nodiscard]] S normal_velocity(const Twist<S>& a, const Twist<S>& b) const {
    return axes[0].dot(velocity(a, b));
  }
  /// [m/s] Lower bound of the speed at which the surfaces separate at the end of the step.
  [[nodiscard]] S parting_target() const { return target - bias[0]; }
  /// [N s] The impulse on B in world axes.
  [[nodiscard]] Vec3<S> impulse_W() const {
    return impulse[0] * axes[0] + impulse[1] * axes[1] + impulse[2] * axes[2];
  }
};

/// [1] Distance of an impulse from the edge of its friction cone, where surfaces slide. It is 0 at
/// the edge. It is 1 up to most of the way to it (`chosen::hold_fade`). It is continuous, so that
/// small differences stay small.
/// @param impulse  [N s] Along the normal and two tangents.
template <Scalar S>
[[nodiscard]] S hold_of(const std::array<S, 3>& impulse, const S& friction) {
  using std::min;
  using std::sqrt;
  const S most = friction * impulse[0];
  const S friction2 = impulse[1] * impulse[1] + impulse[2] * impulse[2];
  if (!(friction2 < most * most)) return S(0);
  // The first test saves the root.
  const double whole = 1 - chosen::hold_fade;
  if (friction2 <= S(whole * whole) * (most * most)) return S(1);
  return min(S(1), S(1 / chosen::hold_fade) * (S(1) - sqrt(friction2) / most));
}

/// Returns whether two contacts have the same bodies and axes, and surfaces that run alike, as the
/// points of a manifold have.
template <Scalar S>
[[nodiscard]] bool are_of_one_manifold(const ContactConstraint<S>& c,
                                       const ContactConstraint<S>& d) {
  if (c.first_point == d.first_point && c.first_point != no_index) return true;
  return c.body_a == d.body_a && c.body_b == d.body_b && c.axes[0] == d.axes[0] &&
         c.friction == d.friction && c.drift[0] == d.drift[0] && c.drift[1] == d.drift[1];
}

/// Response of a contact's velocities along its axes to its impulses. It is a symmetric 3x3 matrix.
/// Only the contact's own bodies move.
template <Scalar S>
struct ContactResponse {
  S nn = S(0), n1 = S(0), n2 = S(0), a = S(0), b = S(0), c = S(0);
  /// Largest eigenvalue of the tangential part [[a, b], [b, c]].
  S largest = S(0);
  /// Inverses of that part's determinant, of `largest` and of `nn`. Each is 0 where the value is
  /// singular or 0.
  S inverse_determinant = S(0), inverse_largest = S(0), inverse_nn = S(0);

  /// Sets the entries from a symmetric matrix.
  void set(const Mat3<S>& M) {
    nn = M(0, 0);
    n1 = M(0, 1);
    n2 = M(0, 2);
    a = M(1, 1);
    b = M(1, 2);
    c = M(2, 2);
  }
  /// Computes the other fields from the entries.
  void prepare() {
    using std::sqrt;
    largest = S(0.5) * (a + c) + sqrt(S(0.25) * (a - c) * (a - c) + b * b);
    const S determinant = a * c - b * b;
    inverse_determinant = determinant > no_mobility<S>() * a * c ? S(1) / determinant : S(0);
    inverse_largest = largest > S(0) ? S(1) / largest : S(0);
    inverse_nn = nn > S(0) ? S(1) / nn : S(0);
  }
};

/// Impulse change that brings one velocity to its target. It is 0 where nothing can move.
template <Scalar S>
[[nodiscard]] S scalar_change(S residual, S response) {
  return response > S(0) ? -residual / response : S(0);
}

/// Friction of a contact. It is the exact 2x2 solution if that is in the disk of `radius`. Else it
/// is one projected-gradient step of length 1 / lambda_max. The fixed point of that step is on the
/// disk's edge, opposite to the slip. That is Coulomb's direction, also for a 2x2 matrix that is
/// not isotropic.
/// @tparam Response  Has the tangential fields of `ContactResponse`.
template <Value T, typename Response>
BRISTLE_FORCE_INLINE void solve_friction(const Response& K, const T& v1, const T& v2,
                                         const T& radius, T& t1, T& t2) {
  using std::sqrt;
  const T zero = ScalarOf<T>(0);
  const T x = t1 - (K.c * v1 - K.b * v2) * K.inverse_determinant;
  const T y = t2 - (K.a * v2 - K.b * v1) * K.inverse_determinant;
  const Truth<T> is_regular = K.inverse_determinant > zero;
  const Truth<T> sticks = is_regular & (x * x + y * y <= radius * radius);
  if (all(sticks)) {
    t1 = x;
    t2 = y;
    return;
  }
  const T u1 = t1 - v1 * K.inverse_largest;
  const T u2 = t2 - v2 * K.inverse_largest;
  const T size2 = u1 * u1 + u2 * u2;
  const T one = ScalarOf<T>(1);
  const T shrink = select(size2 > radius * radius, radius / sqrt(size2), one);
  t1 = select(sticks, x, shrink * u1);
  t2 = select(sticks, y, shrink * u2);
}

/// Solves one contact with everything else held still.
/// @param v  [m/s] Current velocity at the point.
/// @return [N s] Change of the impulse, along the axes.
template <Scalar S>
std::array<S, 3> solve_contact(ContactConstraint<S>& c, const ContactResponse<S>& K,
                               const Vec3<S>& v) {
  const std::array<S, 3> before = c.impulse;
  const S wanted = before[0] + (c.target - c.axes[0].dot(v)) * K.inverse_nn;
  // In this order a velocity that is NaN gives no impulse.
  c.impulse[0] = std::min(wanted > S(0) ? wanted : S(0), c.most_impulse);
  const S change = c.impulse[0] - before[0];
  solve_friction(K, c.axes[1].dot(v) - c.bias[1] + K.n1 * change,
                 c.axes[2].dot(v) - c.bias[2] + K.n2 * change, c.friction * c.impulse[0],
                 c.impulse[1], c.impulse[2]);
  return {change, c.impulse[1] - before[1], c.impulse[2] - before[2]};
}

}  // namespace bristle::inline BRISTLE_ABI::detail
