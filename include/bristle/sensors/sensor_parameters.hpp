/// @file
/// Constants of resistive sensors and the readings of the law one can choose between.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/math/lane_value.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Constants of one resistive sensor, a ray that meets penetration with a spring and damper along
/// itself and slip with a bristle across itself. `tuned_for` proposes them from physical wants.
///
/// The defaults give no force. `static_friction * breakaway_distance` is the dimensionless holding
/// coefficient: how many newtons of friction one newton of normal force can hold.
template <Value T>
struct SensorParameters {
  /// [N] Normal force at full penetration, K_N in Eq. 3. Finite, >= 0. Newtons and not N/m because
  /// the depth it multiplies is a fraction of the ray (Eq. 4): the stiffness is K_N / L.
  T normal_stiffness = T(0);
  /// [N s] Normal damping, K_D in Eq. 3, on the true rate of the depth fraction. Finite, >= 0. The
  /// paper's values are per step of its 1 kHz loop: divide by 1000 (50 becomes 0.05).
  T normal_damping = T(0);
  /// [1/m] Static friction, mu_S in Eq. 1: force per newton of normal force and metre of stretch.
  /// [N/m] with FrictionScaling::depth (Eq. 11) and FrictionScaling::none. Finite, >= 0.
  T static_friction = T(0);
  /// [N s/m] Sliding friction, mu_V in Eq. 5. Finite, >= 0.
  T sliding_friction = T(0);
  /// [m] Stretch at which a stuck bristle lets go, sigma_a in Eq. 2. Finite, > 0.
  T breakaway_distance = T(ScalarOf<T>(1e-3));
};

/// What the static friction of a sensor grows with.
enum class FrictionScaling {
  /// Eq. 1: k_t = mu_S F_N, with the sensor's own normal force.
  normal_force,
  /// Eq. 11: k_t = mu_S e_N, for sensors that shall not push.
  depth,
  /// k_t = mu_S: a plain spring, what AMBF does without `variable: true`.
  none
};

/// What happens to a bristle stretched beyond sigma_a.
enum class SlipReset {
  /// It lets go and grips anew (Eq. 2), keeping what the stretch exceeds whole multiples of sigma_a
  /// by: the paper's saw-tooth in the limit of small steps, without its aliasing at large ones.
  /// Mean
  /// sliding friction is half the static one.
  release,
  /// It drags along at sigma_a: Coulomb friction with equal static and sliding coefficients.
  drag
};

/// Along what the normal force of a sensor points.
enum class NormalDirection {
  /// Along the ray, as in Eq. 3. Oblique rays then push bodies along: sin(angle) of the force does
  /// not come from any potential, and bodies that tumble on stiff rays gain energy without bound.
  ray,
  /// Along the gradient of the depth: the force comes from a potential while a ray stays on one
  /// surface. The same as `ray` where it meets the surface head-on.
  gradient
};

/// How the forces of a patch enter the step.
enum class Integration {
  /// Evaluated at the start of the step. Cheapest; stable only below `largest_stable_step`.
  explicit_,
  /// Solved together with contacts and joints as one soft 6x6 constraint; stable at any step.
  implicit,
  /// Explicit where that is safely stable, implicit elsewhere, decided anew each step.
  automatic
};

/// Which law a patch follows.
enum class Law {
  /// The paper's equations as corrected in docs/sensors.md.
  paper,
  /// What the paper's own simulator computes, defects included; explicit only. For comparison.
  ambf
};

/// Readings of the law a patch uses.
struct LawOptions {
  /// [-] Law to follow.
  Law law = Law::paper;
  /// [-] What static friction grows with.
  FrictionScaling scaling = FrictionScaling::normal_force;
  /// [-] What becomes of an overstretched bristle.
  SlipReset reset = SlipReset::release;
  /// [-] Along what the normal force points.
  NormalDirection normal = NormalDirection::gradient;
};

/// @throws InvalidArgument naming the field that is not finite or out of range.
template <Scalar S>
void validate(const SensorParameters<S>& p) {
  detail::require_not_negative("SensorParameters::normal_stiffness", p.normal_stiffness);
  detail::require_not_negative("SensorParameters::normal_damping", p.normal_damping);
  detail::require_not_negative("SensorParameters::static_friction", p.static_friction);
  detail::require_not_negative("SensorParameters::sliding_friction", p.sliding_friction);
  detail::require_positive("SensorParameters::breakaway_distance", p.breakaway_distance);
}

/// Whether a sensor with these constants can give a force. Static friction that is scaled by the
/// normal force needs one.
template <Scalar S>
[[nodiscard]] bool can_push(const SensorParameters<S>& p, const LawOptions& options) {
  return p.normal_stiffness > S(0) || p.normal_damping > S(0) || p.sliding_friction > S(0) ||
         (p.static_friction > S(0) && options.scaling != FrictionScaling::normal_force);
}

}  // namespace bristle::inline BRISTLE_ABI
