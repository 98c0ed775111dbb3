/// @file
/// Bullet's vectors and poses as bristle's, and back.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/transform.hpp>
#include <bristle/math/types.hpp>

#include <LinearMath/btTransform.h>

namespace bristle::inline BRISTLE_ABI::detail {

/// The same numbers in double, for any build of Bullet.
[[nodiscard]] inline Vec3<double> from_bullet(const btVector3& v) {
  return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
}
[[nodiscard]] inline Transform<double> from_bullet(const btTransform& X) {
  const btQuaternion q = X.getRotation();
  const Quat<double> rotation(static_cast<double>(q.w()), static_cast<double>(q.x()),
                              static_cast<double>(q.y()), static_cast<double>(q.z()));
  return {rotation.normalized(), from_bullet(X.getOrigin())};
}
/// The same numbers as Bullet counts.
[[nodiscard]] inline btVector3 to_bullet(const Vec3<double>& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

}  // namespace bristle::inline BRISTLE_ABI::detail
