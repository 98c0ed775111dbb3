/// @file
/// ODE's vectors, poses and twists as bristle's.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/spatial.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/math/types.hpp>

#include <ode/ode.h>

namespace bristle::inline BRISTLE_ABI::detail {

/// The vector of three of ODE's numbers.
[[nodiscard]] inline Vec3<double> ode_vector(const dReal* x) { return {x[0], x[1], x[2]}; }
/// The vector that one of ODE's functions writes.
template <typename Getter, typename Of>
[[nodiscard]] Vec3<double> ode_vector(Getter get, Of of) {
  dVector3 x;
  get(of, x);
  return ode_vector(x);
}
/// The pose of ODE's quaternion and place.
[[nodiscard]] inline Transform<double> ode_transform(const dReal* q, const dReal* x) {
  return {Quat<double>(q[0], q[1], q[2], q[3]).normalized(), ode_vector(x)};
}
/// Pose of a body in the world.
[[nodiscard]] inline Transform<double> ode_pose(dBodyID body) {
  return ode_transform(dBodyGetQuaternion(body), dBodyGetPosition(body));
}
/// [m/s, rad/s] Twist of a body's centre of mass, world axes.
[[nodiscard]] inline Vec6<double> ode_twist(dBodyID body) {
  return stacked<double>(ode_vector(dBodyGetLinearVel(body)), ode_vector(dBodyGetAngularVel(body)));
}

}  // namespace bristle::inline BRISTLE_ABI::detail
