/// @file
/// Tests of vectors and matrices for numbers that cannot be computed with.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <cmath>

namespace bristle::inline BRISTLE_ABI::detail {

/// Returns whether no entry is infinite or NaN. Only a finite entry times 0 is 0.
template <Scalar S, int rows, int columns, int options>
[[nodiscard]] inline bool all_finite(const Eigen::Matrix<S, rows, columns, options>& m) {
  S sum = S(0);
  for (int i = 0; i < rows * columns; ++i) sum += m.data()[i] * S(0);
  return sum == S(0);
}

/// Returns whether the squared length is finite. Then no component is NaN. None is so large that a
/// result may overflow (`largest_number`).
template <Scalar S>
[[nodiscard]] inline bool has_finite_square(const Vec3<S>& v) {
  return (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) * S(0) == S(0);
}

/// Returns whether a vector has length 1. False if it is not finite.
template <typename Vector>
[[nodiscard]] bool is_unit(const Vector& v) {
  using S = typename Vector::Scalar;
  using std::abs;
  return abs(v.squaredNorm() - S(1)) <= Tolerance<S>::equal();
}

}  // namespace bristle::inline BRISTLE_ABI::detail
