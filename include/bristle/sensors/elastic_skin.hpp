/// @file
/// Constants of sensors from the material of a skin: Young's modulus, Poisson's ratio, thickness.
///
/// A thin elastic layer on a hard body is a bed of independent springs: an elastic foundation
/// (Johnson, *Contact Mechanics*, 4.3). Each sensor is one of them. The layer is confined sideways:
/// its compression modulus is (1 - nu) E / ((1 + nu)(1 - 2 nu)). Its shear modulus is G = E / (2 (1
/// + nu)). Stiffness per area is modulus over thickness h.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/sensors/sensor_parameters.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Layer of soft material on a hard body. Silicone rubber is the default.
template <Scalar S>
struct ElasticSkin {
  /// [Pa] Young's modulus E. Finite, > 0.
  S young_modulus = S(1e6);
  /// [1] Poisson's ratio nu, in [0, 0.5). An incompressible layer could not be pressed at all.
  /// Rubbers have 0.45 to 0.49, foams about 0.1.
  S poisson_ratio = S(0.45);
  /// [m] Thickness h. Finite, > 0.
  S thickness = S(0.003);
  /// [m^2] Skin area over the number of sensors. Finite, > 0.
  S area_per_sensor = S(1e-6);
  /// [m] Ray length: the depth where sensors saturate. At most the thickness.
  S length = S(0.003);
  /// [1] Static friction coefficient. Finite, > 0.
  S friction = S(0.8);
  /// [s] Relaxation time of the material, viscosity over modulus (Kelvin and Voigt's solid).
  /// Finite, >= 0.
  S relaxation_time = S(1e-3);
  /// [Pa] Working pressure. Finite, > 0. The shear stiffness of the bristles grows with the normal
  /// force (Eq. 1). At this pressure it is that of the material.
  S working_pressure = S(1e4);

  /// [Pa/m] Pressure per depth of indentation.
  [[nodiscard]] S normal_stiffness_per_area() const {
    const S nu = poisson_ratio;
    return (S(1) - nu) * young_modulus / ((S(1) + nu) * (S(1) - S(2) * nu) * thickness);
  }
  /// [Pa/m] Shear stress per displacement along the surface.
  [[nodiscard]] S shear_stiffness_per_area() const {
    return young_modulus / (S(2) * (S(1) + poisson_ratio) * thickness);
  }

  /// Constants of each sensor, for FrictionScaling::normal_force.
  /// @throws InvalidArgument naming the field.
  [[nodiscard]] SensorParameters<S> parameters() const;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
SensorParameters<S> ElasticSkin<S>::parameters() const {
  detail::require_positive("ElasticSkin::young_modulus", young_modulus);
  detail::require_not_negative("ElasticSkin::poisson_ratio", poisson_ratio);
  detail::require(poisson_ratio < S(0.5), "ElasticSkin::poisson_ratio", poisson_ratio,
                  "must be < 0.5");
  detail::require_positive("ElasticSkin::thickness", thickness);
  detail::require_positive("ElasticSkin::area_per_sensor", area_per_sensor);
  detail::require_positive("ElasticSkin::length", length);
  detail::require(length <= thickness, "ElasticSkin::length", length,
                  "must be at most the thickness, " + detail::to_text(thickness));
  detail::require_positive("ElasticSkin::friction", friction);
  detail::require_not_negative("ElasticSkin::relaxation_time", relaxation_time);
  detail::require_positive("ElasticSkin::working_pressure", working_pressure);

  SensorParameters<S> p;
  // At the depth e L: F_N = p A with p = k e L.
  p.normal_stiffness = normal_stiffness_per_area() * area_per_sensor * length;
  // F_N = K_N (e + tau de/dt).
  p.normal_damping = relaxation_time * p.normal_stiffness;
  // k_t = mu_S F_N equals G A / h at F_N = working pressure times A.
  p.static_friction = shear_stiffness_per_area() / working_pressure;
  p.breakaway_distance = friction / p.static_friction;
  p.sliding_friction = relaxation_time * shear_stiffness_per_area() * area_per_sensor;
  return p;
}

}  // namespace bristle::inline BRISTLE_ABI
