/// @file
/// The rotation that brings one axis onto another, as AMBF has it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/transform.hpp>

#include <numbers>

namespace bristle::inline BRISTLE_ABI::detail {

/// Shortest rotation from one unit vector to another. Between opposite vectors the format takes the
/// half turn about from x X, or about from x Y if X is parallel.
[[nodiscard]] inline Quat<double> axis_turn(const Vec3<double>& from, const Vec3<double>& to) {
  const double cosine = from.dot(to);
  // 1 + cosine is more than 1/2 here, so it loses at most one bit.
  if (cosine > -0.5) {
    const Vec3<double> axis = from.cross(to);
    return Quat<double>(1.0 + cosine, axis.x(), axis.y(), axis.z()).normalized();
  }
  // AMBF takes angles above 3.13 rad for opposite, which is within 0.012 rad. X is parallel for it
  // within 0.1 rad.
  const bool is_opposite = cosine < -0.99993;
  Vec3<double> axis = from.cross(to);
  if (is_opposite) {
    axis = from.cross(unit_x<Vec3<double>>());
    if (axis.norm() < 0.1) axis = from.cross(unit_y<Vec3<double>>());
  }
  // Half a turn, or most of the rotation. From 2.1 to 3.13 rad, 2 rad leave 1.14 rad at most, whose
  // cosine is above -1/2: the recursion ends.
  const double angle = is_opposite ? std::numbers::pi : 2.0;
  const Quat<double> first(Eigen::AngleAxis<double>(angle, axis.normalized()));
  return (axis_turn(first * from, to) * first).normalized();
}

}  // namespace bristle::inline BRISTLE_ABI::detail
