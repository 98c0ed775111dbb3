/// @file
/// Rigid transform: the pose of one frame in another.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/types.hpp>

#include <cmath>
#include <string>
#include <string_view>

namespace bristle::inline BRISTLE_ABI {

/// Pose X_AB of a frame B in a frame A. It maps coordinates in B to coordinates in A.
///
/// `X_AC = X_AB * X_BC`, `p_AP = X_AB * p_BP`: names show when frames do not match. An omitted
/// member is the identity, as in `{.rotation = r}`. `{r, {}}` is not: Eigen leaves a vector made
/// from `{}` uninitialised.
template <Scalar S>
struct Transform {
  /// [1] R_AB as a unit quaternion.
  Quat<S> rotation = Quat<S>::Identity();
  /// [m] Origin of B in A.
  Vec3<S> translation = detail::zero<Vec3<S>>();

  /// X_BA, the pose of A in B.
  [[nodiscard]] Transform inverse() const {
    const Quat<S> r = rotation.conjugate();
    return {r, -(r * translation)};
  }

  /// A free vector (direction, velocity, force) of B, in the axes of A.
  [[nodiscard]] Vec3<S> rotate(const Vec3<S>& v_B) const { return rotation * v_B; }

  /// R_AB as a matrix: cheaper than the quaternion from the second vector on.
  [[nodiscard]] Mat3<S> rotation_matrix() const { return bristle::rotation_matrix<S>(rotation); }

  /// The same pose in another scalar.
  template <Scalar T>
  [[nodiscard]] Transform<T> cast() const {
    return {Quat<T>(rotation.template cast<T>()), translation.template cast<T>()};
  }

  friend Transform operator*(const Transform& X_AB, const Transform& X_BC) {
    return {X_AB.rotation * X_BC.rotation, X_AB.rotation * X_BC.translation + X_AB.translation};
  }
  friend Vec3<S> operator*(const Transform& X_AB, const Vec3<S>& p_B) {
    return X_AB.rotation * p_B + X_AB.translation;
  }
};

/// X_AB from X_WA and X_WB. The two origins are subtracted first. So no digits are lost far from
/// the world's origin. The error is relative to the distance of the two frames.
template <Scalar S>
[[nodiscard]] Transform<S> relative_pose(const Transform<S>& X_WA, const Transform<S>& X_WB) {
  const Quat<S> R_AW = X_WA.rotation.conjugate();
  return {R_AW * X_WB.rotation, R_AW * Vec3<S>(X_WB.translation - X_WA.translation)};
}

namespace detail {

/// Raises InvalidArgument unless the pose is finite and its rotation has length 1.
template <Scalar S>
void require_pose(std::string_view field, const Transform<S>& X) {
  using std::abs;
  const bool is_unit = abs(X.rotation.squaredNorm() - S(1)) <= Tolerance<S>::equal();
  if (is_unit && all_finite(X.translation)) return;
  // Text is made only on error: steps never allocate.
  const std::string name(field);
  require_all_finite(name + ".translation", X.translation);
  require_all_finite(name + ".rotation", X.rotation.coeffs());
  require(is_unit, name + ".rotation: length", X.rotation.norm(), "must be 1");
}

}  // namespace detail

}  // namespace bristle::inline BRISTLE_ABI
