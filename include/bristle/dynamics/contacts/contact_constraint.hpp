/// @file
/// One point of contact as the solvers see it, and the exact solution of it alone.
///
/// Velocities and positions are two complementarity problems with one matrix (docs/solver.md): the
/// impulse `impulse` keeps the surfaces from approaching at the end of the step, and the share
/// `placed` of it that acts early enough to move the bodies within the step keeps them from
/// overlapping. For a contact at rest the second is half of the first.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/lane_value.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/math/types.hpp>

#include <array>
#include <cmath>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// [1] Share of a row's response below which nothing is left of it but round-off, once other rows
/// hold: a thousand roundings, for what elimination adds up.
template <Scalar S>
inline constexpr S no_mobility = S(1000) * Tolerance<S>::round_off();

/// A point of contact between bodies A and B: impulses on B along the normal (from A to B) and two
/// tangents.
template <Scalar S>
struct ContactConstraint {
  /// [-] Slots of the two bodies.
  std::uint32_t body_a = 0;
  std::uint32_t body_b = 0;
  /// [m] From each centre of mass to the point, world axes: at the instant at which its impulse
  /// acts (`time_contact`).
  Vec3<S> arm_a = Vec3<S>::Zero();
  Vec3<S> arm_b = Vec3<S>::Zero();
  /// [-] Number of its `CachedPoint`.
  std::uint32_t point = 0;
  /// [m/s] Velocity along the axes that surfaces which stay together have at the end of the step,
  /// as these arms see it: not zero, since the arms go on turning.
  std::array<S, 3> bias{};
  /// [1] Normal and two tangents, world axes.
  std::array<Vec3<S>, 3> axes{Vec3<S>::Zero(), Vec3<S>::Zero(), Vec3<S>::Zero()};
  /// [1] Coulomb friction coefficient and coefficient of restitution.
  S friction = S(0);
  S restitution = S(0);
  /// [m] Distance of the surfaces at the start of the step.
  S gap = S(0);
  /// [m/s] Least normal velocity at the end of the step.
  S target = S(0);
  /// [N s] Impulse along the axes.
  std::array<S, 3> impulse{};
  /// [N s] What of it answers the velocities that the step started with, where that is known. They
  /// are gone at its end: the next step needs that much less.
  std::array<S, 3> passing{};
  /// [N s] What of the normal impulse moves the bodies within the step, and the least it may be.
  /// Sweeps over manifolds keep theirs to themselves.
  S placed = S(0);
  S least_placed = S(0);
  /// [1] Share of the step that is left after a bounce, which is the share of its impulse that
  /// moves the bodies; negative where nothing bounces.
  S bounce_share = S(-1);
  /// Whether its bodies bounce or fly apart: an overlap then closes by itself.
  bool parts = false;
  /// Whether the impulse of the last step says nothing about this one: a new contact, or one that
  /// took an impact.
  bool is_fresh = true;
  /// Whether it stops an approach in this step rather than carrying a load.
  bool is_impact = false;
  /// Whether the motion of the step was found to leave its surfaces apart, so that it cannot press;
  /// and whether they come together where it does not.
  bool is_open = false;
  bool is_shut = false;

  /// [m/s] Velocity of B's material relative to A's at the point.
  [[nodiscard]] Vec3<S> velocity(const Twist<S>& a, const Twist<S>& b) const {
    return b.at(arm_b) - a.at(arm_a);
  }
  /// [m/s] Its normal part.
  [[nodiscard]] S normal_velocity(const Twist<S>& a, const Twist<S>& b) const {
    return axes[0].dot(velocity(a, b));
  }
  /// [m/s] Least speed at which the surfaces part at the end of the step.
  [[nodiscard]] S parting_target() const { return target - bias[0]; }
  /// [N s] The impulse as a vector of the world.
  [[nodiscard]] Vec3<S> impulse_W() const {
    return impulse[0] * axes[0] + impulse[1] * axes[1] + impulse[2] * axes[2];
  }
};

/// [1] How far an impulse is from the edge of its friction cone, where surfaces slide: 0 at the edge
/// and 1 up to nine tenths of the way to it, without a jump that would make small differences large.
/// @param impulse  [N s] Along the normal and two tangents.
template <Scalar S>
[[nodiscard]] S hold_of(const std::array<S, 3>& impulse, const S& friction) {
  using std::min;
  using std::sqrt;
  const S most = friction * impulse[0];
  const S friction2 = impulse[1] * impulse[1] + impulse[2] * impulse[2];
  if (!(friction2 < most * most)) return S(0);
  return friction2 > S(0) ? min(S(1), S(10) * (S(1) - sqrt(friction2) / most)) : S(1);
}

/// Whether two contacts are between the same bodies along the same axes.
template <Scalar S>
[[nodiscard]] bool are_of_one_manifold(const ContactConstraint<S>& c,
                                       const ContactConstraint<S>& d) {
  return c.body_a == d.body_a && c.body_b == d.body_b && c.axes[0] == d.axes[0] &&
         c.friction == d.friction;
}

/// Response of a contact's velocities along its axes to its impulses, when only its own bodies
/// move: a symmetric 3x3 matrix.
template <Scalar S>
struct ContactResponse {
  S nn = S(0), n1 = S(0), n2 = S(0), a = S(0), b = S(0), c = S(0);
  /// Largest eigenvalue of the tangential part [[a, b], [b, c]].
  S largest = S(0);
  /// Inverse of that part's determinant, 0 where it is singular, and of `largest` and `nn`, 0 where
  /// they are.
  S inverse_determinant = S(0), inverse_largest = S(0), inverse_nn = S(0);

  /// Takes the entries of a symmetric matrix.
  void set(const Mat3<S>& M) {
    nn = M(0, 0);
    n1 = M(0, 1);
    n2 = M(0, 2);
    a = M(1, 1);
    b = M(1, 2);
    c = M(2, 2);
  }
  /// Prepares the solution once the entries are filled.
  void prepare() {
    using std::sqrt;
    largest = S(0.5) * (a + c) + sqrt(S(0.25) * (a - c) * (a - c) + b * b);
    const S determinant = a * c - b * b;
    inverse_determinant = determinant > no_mobility<S> * a * c ? S(1) / determinant : S(0);
    inverse_largest = largest > S(0) ? S(1) / largest : S(0);
    inverse_nn = nn > S(0) ? S(1) / nn : S(0);
  }
};

namespace detail {

/// Impulse change that brings one velocity to its target, 0 where nothing can move.
template <Scalar S>
[[nodiscard]] S scalar_change(S residual, S response) {
  return response > S(0) ? -residual / response : S(0);
}

/// Friction of a contact: the exact 2x2 solution if it lies in the disk of `radius`; else one
/// projected-gradient step of length 1 / lambda_max, whose fixed point is the point of the disk's
/// edge that opposes the slip (Coulomb's direction, also where the 2x2 matrix is not isotropic).
/// @tparam Response  Has what `ContactResponse` says of the tangential part.
template <Value T, typename Response>
BRISTLE_INLINE void solve_friction(const Response& K, const T& v1, const T& v2, const T& radius,
                                   T& t1, T& t2) {
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

}  // namespace detail

/// Solves one contact with everything else held still.
/// @param v  [m/s] Velocity at the point as it is now.
/// @return [N s] Change of the impulse, along the axes.
template <Scalar S>
std::array<S, 3> solve_contact(ContactConstraint<S>& c, const ContactResponse<S>& K,
                               const Vec3<S>& v) {
  const std::array<S, 3> before = c.impulse;
  const S wanted = before[0] + (c.target - c.axes[0].dot(v)) * K.inverse_nn;
  c.impulse[0] = wanted > S(0) ? wanted : S(0);
  const S change = c.impulse[0] - before[0];
  detail::solve_friction(K, c.axes[1].dot(v) - c.bias[1] + K.n1 * change,
                         c.axes[2].dot(v) - c.bias[2] + K.n2 * change,
                         c.friction * c.impulse[0], c.impulse[1], c.impulse[2]);
  return {change, c.impulse[1] - before[1], c.impulse[2] - before[2]};
}

}  // namespace bristle::inline BRISTLE_ABI
