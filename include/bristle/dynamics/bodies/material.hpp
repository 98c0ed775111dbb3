/// @file
/// Surface constants of hard contact, and their combination for a pair.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/math/types.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Surface of a shape in hard contact. Sensors have their own friction.
template <Scalar S>
struct Material {
  /// [1] Coulomb friction coefficient, >= 0. Of a pair: the geometric mean.
  S friction = S(0.5);
  /// [1] Coefficient of restitution, in [0, 1]. Of a pair: the larger one.
  S restitution = S(0);
  /// [m/s] Velocity of the surface relative to its shape, in the shape's axes, as of a conveyor
  /// belt. Friction of hard contact drags along the part of it in the contact plane. `combined`
  /// leaves it out.
  Vec3<S> surface_velocity = detail::zero<Vec3<S>>();
  /// [m] Lever of rolling friction, >= 0: how far ahead of the middle the normal force of a hard
  /// contact may act against rolling. Of a pair: the larger one. docs/world.md has the law.
  S rolling_friction = S(0);
};

/// Material of a pair: geometric mean of the friction, larger restitution and rolling friction.
template <Scalar S>
[[nodiscard]] Material<S> combined(const Material<S>& a, const Material<S>& b) {
  using std::max;
  using std::sqrt;
  Material<S> pair;
  pair.friction = sqrt(a.friction * b.friction);
  pair.restitution = max(a.restitution, b.restitution);
  pair.rolling_friction = max(a.rolling_friction, b.rolling_friction);
  return pair;
}

namespace detail {

/// Returns whether a step can use a material.
template <Scalar S>
[[nodiscard]] bool is_valid_state(const Material<S>& m) {
  return m.friction >= S(0) && m.friction <= largest_number<S> && m.restitution >= S(0) &&
         m.restitution <= S(1) && has_finite_square<S>(m.surface_velocity) &&
         m.rolling_friction >= S(0) && m.rolling_friction <= largest_number<S>;
}

}  // namespace detail

/// Checks a material.
/// @throws InvalidArgument naming the field that is out of range.
template <Scalar S>
void validate(const Material<S>& m) {
  detail::require_not_negative("Material::friction", m.friction);
  detail::require_not_negative("Material::restitution", m.restitution);
  detail::require(m.restitution <= S(1), "Material::restitution", m.restitution, "must be <= 1");
  detail::require_all_finite("Material::surface_velocity", m.surface_velocity);
  detail::require_not_negative("Material::rolling_friction", m.rolling_friction);
}

}  // namespace bristle::inline BRISTLE_ABI
