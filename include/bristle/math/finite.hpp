/// @file
/// Whether vectors and matrices hold numbers that can be computed with.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <cmath>

namespace bristle::inline BRISTLE_ABI {

/// Whether no entry is infinite or NaN: only of finite ones is 0 times the entry 0.
template <Scalar S, int rows, int columns, int options>
[[nodiscard]] inline bool all_finite(const Eigen::Matrix<S, rows, columns, options>& m) {
  S sum = S(0);
  for (int i = 0; i < rows * columns; ++i) sum += m.data()[i] * S(0);
  return sum == S(0);
}

/// Whether its length squared is finite: then no component is NaN, nor so large that what is
/// computed from it may overflow (`largest_number`).
template <Scalar S>
[[nodiscard]] inline bool has_finite_square(const Vec3<S>& v) {
  return (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) * S(0) == S(0);
}

/// Whether a vector has the length 1. One that is not finite has not.
template <typename Vector>
[[nodiscard]] bool is_unit(const Vector& v) {
  using S = typename Vector::Scalar;
  using std::abs;
  return abs(v.squaredNorm() - S(1)) <= Tolerance<S>::equal();
}

}  // namespace bristle::inline BRISTLE_ABI
