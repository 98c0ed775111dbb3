/// @file
/// Products of 3x3 matrices and vectors, written so that they are computed in place: Eigen's own
/// become function calls wherever the caller is large, and the step is made of them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

namespace bristle::inline BRISTLE_ABI {

/// M v.
template <Scalar S>
[[nodiscard]] inline Vec3<S> product(const Mat3<S>& M, const Vec3<S>& v) {
  const S* m = M.data();  // Column by column.
  return {m[0] * v[0] + m[3] * v[1] + m[6] * v[2], m[1] * v[0] + m[4] * v[1] + m[7] * v[2],
          m[2] * v[0] + m[5] * v[1] + m[8] * v[2]};
}

/// R M R^T of a symmetric M, of which six entries are enough.
template <Scalar S>
[[nodiscard]] inline Mat3<S> rotated(const Mat3<S>& R, const Mat3<S>& M) {
  const Vec3<S> x = product<S>(M, R.row(0));
  const Vec3<S> y = product<S>(M, R.row(1));
  const Vec3<S> z = product<S>(M, R.row(2));
  const S xy = R.row(0).dot(y);
  const S xz = R.row(0).dot(z);
  const S yz = R.row(1).dot(z);
  Mat3<S> result;
  result << R.row(0).dot(x), xy, xz, xy, R.row(1).dot(y), yz, xz, yz, R.row(2).dot(z);
  return result;
}

/// Whether no component is infinite or NaN: only of finite ones is 0 times the component 0.
template <Scalar S>
[[nodiscard]] inline bool all_finite(const Vec3<S>& v) {
  return v[0] * S(0) + v[1] * S(0) + v[2] * S(0) == S(0);
}

/// Whether its length squared is finite: then no component is NaN, nor so large that what is
/// computed from it may overflow (`largest_number`).
template <Scalar S>
[[nodiscard]] inline bool has_finite_square(const Vec3<S>& v) {
  return (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) * S(0) == S(0);
}

}  // namespace bristle::inline BRISTLE_ABI
