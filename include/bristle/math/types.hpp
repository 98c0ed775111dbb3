/// @file
/// Scalar concept and the vector types of all other headers.
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

/// Opens the library to scalars that are not built in (dual.hpp has one). Specialise it to true for
/// a type that has std::numeric_limits, arithmetic and `value_of`. ADL must find the functions of
/// `<cmath>`.
template <typename S>
inline constexpr bool is_scalar = std::floating_point<S>;

/// [-] Number of derivatives that a scalar carries.
template <typename S>
inline constexpr std::size_t derivatives_of = 0;

/// The number without derivatives, for decisions that no derivative may change.
template <std::floating_point S>
[[nodiscard]] constexpr S value_of(S x) {
  return x;
}

/// Number type of a simulation: float, double, or a type with `is_scalar`.
template <typename S>
concept Scalar = is_scalar<S>;

namespace detail {
template <Scalar S>
using Vec2 = Eigen::Matrix<S, 2, 1>;
}  // namespace detail

/// Column vector of three numbers.
template <Scalar S>
using Vec3 = Eigen::Matrix<S, 3, 1>;
/// Column vector of six numbers, unaligned as `Mat6`.
template <Scalar S>
using Vec6 = Eigen::Matrix<S, 6, 1, Eigen::DontAlign>;
/// Matrix of three rows and three columns.
template <Scalar S>
using Mat3 = Eigen::Matrix<S, 3, 3>;
/// Unaligned, so that structs holding one have the same layout under every -march.
template <Scalar S>
using Mat6 = Eigen::Matrix<S, 6, 6, Eigen::DontAlign>;
/// Unit quaternion, unaligned for the same reason.
template <Scalar S>
using Quat = Eigen::Quaternion<S, Eigen::DontAlign>;

namespace detail {

/// The only source of tolerances in library code. All are relative. Multiply by the size of the
/// compared things. Then a scene and its copy at x0.01 or x100 behave alike.
template <Scalar S>
struct Tolerance {
  /// [1] Error of a few arithmetic operations.
  static constexpr S round_off() { return S(16) * std::numeric_limits<S>::epsilon(); }
  /// [1] Two directions or lengths closer than this count as equal. It is the square root of the
  /// precision. A first-order error becomes a second-order one.
  static constexpr S equal() { return std::numeric_limits<S>::digits > 30 ? S(1.5e-8) : S(3.5e-4); }
};

/// Number type of iterative geometry in a world in S. It is double for float, else S itself
/// (docs/decisions/0010-one-search-for-contact-normals.md).
template <Scalar S>
using Precise = std::conditional_t<std::same_as<S, float>, double, S>;

}  // namespace detail

/// Larger than any distance; the distance of a ray without a hit.
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

namespace detail {

/// J skew(r), without the products by zero.
template <typename S>
[[nodiscard]] BRISTLE_FORCE_INLINE Mat3<S> times_skew(const Mat3<S>& J, const Vec3<S>& r) {
  Mat3<S> product;
  set_column(product, 0, r[2] * column_of(J, 1) - r[1] * column_of(J, 2));
  set_column(product, 1, r[0] * column_of(J, 2) - r[2] * column_of(J, 0));
  set_column(product, 2, r[1] * column_of(J, 0) - r[0] * column_of(J, 1));
  return product;
}

}  // namespace detail

}  // namespace bristle::inline BRISTLE_ABI
