/// @file
/// Constants of resistive sensors and variants of their law.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/math/lane_value.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Constants of one resistive sensor. Its ray resists penetration with a spring and damper along
/// itself, and slip with a bristle across itself. `tuned_for` computes constants from a physical
/// spec.
///
/// The defaults give no force. `static_friction * breakaway_distance` is the dimensionless holding
/// coefficient: newtons of friction that one newton of normal force can hold.
template <detail::Value T>
struct SensorParameters {
  /// [N] Normal force at full penetration, K_N in Eq. 3. Finite, >= 0. Newtons, not N/m: the depth
  /// it multiplies is a fraction of the ray (Eq. 4). The stiffness is K_N / L.
  T normal_stiffness = T(0);
  /// [N s] Normal damping, K_D in Eq. 3, on the true rate of the depth fraction. Finite, >= 0. The
  /// paper's values are per 1 kHz step. Divide them by 1000: 50 becomes 0.05.
  T normal_damping = T(0);
  /// [1/m] Static friction, mu_S in Eq. 1: force per newton of normal force and metre of stretch.
  /// [N/m] with FrictionScaling::depth (Eq. 11) and FrictionScaling::none. Finite, >= 0.
  T static_friction = T(0);
  /// [N s/m] Sliding friction, mu_V in Eq. 5. Finite, >= 0.
  T sliding_friction = T(0);
  /// [m] Stretch at which a stuck bristle lets go, sigma_a in Eq. 2. Finite, > 0.
  T breakaway_distance = T(detail::ScalarOf<T>(1e-3));
};

/// Quantity that a sensor's static friction grows with.
enum class FrictionScaling {
  /// Eq. 1: k_t = mu_S F_N, with the sensor's own normal force.
  normal_force,
  /// Eq. 11: k_t = mu_S e_N, for sensors that must not push.
  depth,
  /// k_t = mu_S: a plain spring, as in AMBF without `variable: true`.
  none
};

/// Rule for a bristle stretched beyond sigma_a.
enum class SlipReset {
  /// The bristle lets go and grips anew (Eq. 2). It keeps the remainder of the stretch beyond whole
  /// multiples of sigma_a. That is the paper's saw-tooth in the limit of small steps, without its
  /// aliasing at large ones. Mean sliding friction is half the static one.
  release,
  /// The bristle drags along at sigma_a: Coulomb friction with equal static and sliding
  /// coefficients.
  drag
};

/// Direction of the normal force of a sensor.
enum class NormalDirection {
  /// Along the ray, as in Eq. 3. Oblique rays then push bodies along. That part, sin(angle) of the
  /// force, does not come from any potential: bodies that tumble on stiff rays gain energy without
  /// bound.
  ray,
  /// Along the gradient of the depth. The force comes from a potential while a ray stays on one
  /// surface. Equal to `ray` where the surface faces the ray.
  gradient
};

/// Integration of a patch's forces in the step.
enum class Integration {
  /// Evaluated at the start of the step. Cheapest; stable only below `largest_stable_step`.
  explicit_,
  /// Solved together with contacts and joints as one soft 6x6 constraint; stable at any step.
  implicit,
  /// Explicit where that is safely stable, implicit elsewhere. Chosen anew in each step.
  automatic
};

/// Law of a patch.
enum class Law {
  /// The paper's equations as corrected in docs/sensors.md.
  paper,
  /// The law of the paper's own simulator, defects included; explicit only. For comparison.
  ambf
};

/// Variants of the law that a patch uses.
struct LawOptions {
  /// [-] Law to follow.
  Law law = Law::paper;
  /// [-] Quantity that static friction grows with.
  FrictionScaling scaling = FrictionScaling::normal_force;
  /// [-] Rule for an overstretched bristle.
  SlipReset reset = SlipReset::release;
  /// [-] Direction of the normal force.
  NormalDirection normal = NormalDirection::gradient;
};

/// Checks constants.
/// @throws InvalidArgument naming the field that is not finite or out of range.
template <Scalar S>
void validate(const SensorParameters<S>& p) {
  detail::require_not_negative("SensorParameters::normal_stiffness", p.normal_stiffness);
  detail::require_not_negative("SensorParameters::normal_damping", p.normal_damping);
  detail::require_not_negative("SensorParameters::static_friction", p.static_friction);
  detail::require_not_negative("SensorParameters::sliding_friction", p.sliding_friction);
  detail::require_positive("SensorParameters::breakaway_distance", p.breakaway_distance);
}

/// Returns whether these constants can give a force. Static friction scaled by the normal force
/// needs a normal force.
template <Scalar S>
[[nodiscard]] bool can_apply_force(const SensorParameters<S>& p, const LawOptions& options) {
  return p.normal_stiffness > S(0) || p.normal_damping > S(0) || p.sliding_friction > S(0) ||
         (p.static_friction > S(0) && options.scaling != FrictionScaling::normal_force);
}

}  // namespace bristle::inline BRISTLE_ABI
