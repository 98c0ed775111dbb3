/// @file
/// Scalar concept and the vector types every other header speaks in.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/math/matrix_arithmetic.hpp>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <type_traits>

namespace bristle::inline BRISTLE_ABI {

/// Opens the library to scalars other than the built-in ones (dual.hpp has one): specialise it to
/// true for a type that has std::numeric_limits, arithmetic, `value_of`, and the functions of
/// <cmath> found by ADL.
template <typename S>
inline constexpr bool is_scalar = std::floating_point<S>;

/// [-] How many derivatives a scalar carries with its value.
template <typename S>
inline constexpr std::size_t derivatives_of = 0;

/// The number that a scalar stands for, for decisions that no derivative may change.
template <std::floating_point S>
[[nodiscard]] constexpr S value_of(S x) {
  return x;
}

/// What a simulation may be computed in: float, double, or a type that `is_scalar` names.
template <typename S>
concept Scalar = is_scalar<S>;

template <Scalar S>
using Vec2 = Eigen::Matrix<S, 2, 1>;
template <Scalar S>
using Vec3 = Eigen::Matrix<S, 3, 1>;
template <Scalar S>
using Vec6 = Eigen::Matrix<S, 6, 1, Eigen::DontAlign>;
template <Scalar S>
using Mat3 = Eigen::Matrix<S, 3, 3>;
/// Unaligned, so that structs holding one have the same layout under every -march.
template <Scalar S>
using Mat6 = Eigen::Matrix<S, 6, 6, Eigen::DontAlign>;
/// Unit quaternion, unaligned for the same reason.
template <Scalar S>
using Quat = Eigen::Quaternion<S, Eigen::DontAlign>;

/// The only source of tolerances in library code. All are relative: multiply by the size of the
/// things compared, so that a scene and its copy at x0.01 or x100 behave alike.
template <Scalar S>
struct Tolerance {
  /// [1] Error of a handful of arithmetic operations.
  static constexpr S round_off() { return S(16) * std::numeric_limits<S>::epsilon(); }
  /// [1] Below it two directions or lengths count as equal: the square root of the precision, where
  /// a first-order error becomes a second-order one.
  static constexpr S equal() { return std::numeric_limits<S>::digits > 30 ? S(1.5e-8) : S(3.5e-4); }
};

/// What iterative geometry is computed in for a world in S: double for float, else S itself
/// (docs/decisions/0010-one-search-for-contact-normals.md).
template <Scalar S>
using Precise = std::conditional_t<std::same_as<S, float>, double, S>;

/// Larger than any distance; what a ray without a hit reports.
template <Scalar S>
inline constexpr S infinity = std::numeric_limits<S>::infinity();

/// Cross-product matrix: skew(a) * b = a x b.
template <typename Derived>
[[nodiscard]] Mat3<typename Derived::Scalar> skew(const Eigen::MatrixBase<Derived>& a) {
  using S = typename Derived::Scalar;
  Mat3<S> m;
  m << S(0), -a.z(), a.y(), a.z(), S(0), -a.x(), -a.y(), a.x(), S(0);
  return m;
}

}  // namespace bristle::inline BRISTLE_ABI
