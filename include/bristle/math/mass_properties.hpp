/// @file
/// Mass, centre of mass and inertia of a rigid body, and their sums.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/transform.hpp>

#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// Mass, centre of mass and inertia of a rigid body, in one frame.
template <Scalar S>
struct MassProperties {
  /// [kg] Mass.
  S mass = S(0);
  /// [m] Centre of mass.
  Vec3<S> center = detail::zero<Vec3<S>>();
  /// [kg m^2] Inertia about the centre of mass, along the frame's axes.
  Mat3<S> inertia = detail::zero<Mat3<S>>();

  /// The same body with its mass multiplied by `factor` (a density, for unit-density properties).
  [[nodiscard]] MassProperties scaled(S factor) const {
    return {factor * mass, center, factor * inertia};
  }

  /// The same body in frame A, where its own frame has the pose `X_AB`.
  [[nodiscard]] MassProperties transformed(const Transform<S>& X_AB) const {
    const Mat3<S> R = X_AB.rotation_matrix();
    return {mass, X_AB * center, R * inertia * R.transpose()};
  }
};

/// Inertia of a point mass `m` [kg] at `r` [m]: the term of the parallel-axis theorem.
template <Scalar S>
[[nodiscard]] Mat3<S> point_inertia(S m, const Vec3<S>& r) {
  return m * (r.squaredNorm() * detail::identity<Mat3<S>>() - r * r.transpose());
}

namespace detail {

/// The power of two at or below a normal number > 0.
template <Scalar S>
[[nodiscard]] S power_of_two_below(const S& x) {
  if constexpr (std::same_as<S, double>) {
    return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) & 0x7ff0'0000'0000'0000u);
  } else if constexpr (std::same_as<S, float>) {
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(x) & 0x7f80'0000u);
  } else if constexpr (std::floating_point<S>) {
    return std::ldexp(S(1), std::ilogb(x));
  } else {
    return S(power_of_two_below(value_of(x)));
  }
}

}  // namespace detail

/// [1/(kg m^2)] Inverse of an inertia, or the other way round.
///
/// Uses cofactors of the matrix over a power of two near its trace. The determinant, a third power,
/// then neither overflows nor vanishes. That holds for any size of the body. No bit depends on the
/// power.
template <Scalar S>
[[nodiscard]] Mat3<S> inverse_inertia(const Mat3<S>& inertia) {
  const S unit = S(1) / detail::power_of_two_below(S(inertia.trace()));
  return unit * detail::inverse_of<S>(unit * inertia);
}

/// [1/(kg m^2)] Inverse inertia of a body that torques turn only about its free axes. Rows and
/// columns of locked axes are zero.
template <Scalar S>
[[nodiscard]] Mat3<S> inverse_inertia(Mat3<S> inertia, const std::array<bool, 3>& is_locked) {
  const S scale = detail::power_of_two_below(S(inertia.trace()));
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (!is_locked[static_cast<std::size_t>(i)]) continue;
    detail::set_row(inertia, i, detail::zero<Vec3<S>>());
    detail::set_column(inertia, i, detail::zero<Vec3<S>>());
    inertia(i, i) = scale;
  }
  Mat3<S> inverse = inverse_inertia<S>(inertia);
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (is_locked[static_cast<std::size_t>(i)]) inverse(i, i) = S(0);
  }
  return inverse;
}

/// Two bodies welded together; either may have zero mass.
template <Scalar S>
[[nodiscard]] MassProperties<S> operator+(const MassProperties<S>& a, const MassProperties<S>& b) {
  const S mass = a.mass + b.mass;
  if (!(mass > S(0))) return {};
  const Vec3<S> center = (a.mass * a.center + b.mass * b.center) / mass;
  return {mass, center,
          a.inertia + b.inertia + point_inertia<S>(a.mass, a.center - center) +
              point_inertia<S>(b.mass, b.center - center)};
}

}  // namespace bristle::inline BRISTLE_ABI
