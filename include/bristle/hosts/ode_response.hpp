/// @file
/// Mobility of a body of ODE's, and its motion in a step without sensors.
///
/// ODE has no mass matrix. The motion that a body's joints leave free is found joint by joint,
/// where the other side of a joint is the world or a kinematic body.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/hosts/host_sensors.hpp>
#include <bristle/hosts/hosts_constants.hpp>
#include <bristle/hosts/ode_conversions.hpp>
#include <bristle/math/matrix_arithmetic.hpp>
#include <bristle/math/spatial.hpp>

#include <ode/ode.h>

namespace bristle::inline BRISTLE_ABI::detail {

/// Mobility of a body, and its twist at the end of the step without sensors.
struct OdeResponse {
  Mat6<double> mobility = zero<Mat6<double>>();
  Vec6<double> twist = zero<Vec6<double>>();
  /// Diagonal of the mobility without joints.
  Vec6<double> free = zero<Vec6<double>>();

  /// Sets the twist along a row to that of `base`, by an impulse along that row.
  void hold(const Vec3<double>& linear, const Vec3<double>& angular, const Vec6<double>& base) {
    const Vec6<double> row = stacked<double>(linear, angular);
    const Vec6<double> moved = mobility * row;
    const double row_mobility = row.dot(moved);
    // Joints may hold the same motion twice. Then only rounding is left.
    if (row_mobility <= chosen::held_mobility_share * cwise_square(row).dot(free)) return;
    twist -= moved * (row.dot(twist - base) / row_mobility);
    mobility -= moved * moved.transpose() / row_mobility;
  }
};
/// Motion that a joint holds, along an axis and across it: of its point, and turns.
struct OdeHold {
  bool along = false, across = false, turn_along = false, turn_across = false;
  Vec3<double> point = zero<Vec3<double>>();
  Vec3<double> axis = unit_z<Vec3<double>>();
};

/// The motion that a joint holds of a body with its centre of mass at `center` [m].
[[nodiscard]] inline OdeHold ode_hold_of(dJointID joint, const Vec3<double>& center) {
  const auto at = [joint](auto get) { return ode_vector(get, joint); };
  switch (dJointGetType(joint)) {
    case dJointTypeBall:
      return {true, true, false, false, at(dJointGetBallAnchor)};
    case dJointTypeHinge:
      return {true, true, false, true, at(dJointGetHingeAnchor), at(dJointGetHingeAxis)};
    case dJointTypeUniversal: {
      const Vec3<double> axis = at(dJointGetUniversalAxis1).cross(at(dJointGetUniversalAxis2));
      return {true, true, true, false, at(dJointGetUniversalAnchor), axis.normalized()};
    }
    case dJointTypeSlider:
      return {false, true, true, true, center, at(dJointGetSliderAxis)};
    case dJointTypePiston:
      return {false, true, false, true, at(dJointGetPistonAnchor), at(dJointGetPistonAxis)};
    case dJointTypePlane2D:
      return {true, false, false, true, center};
    case dJointTypeFixed:
      return {true, true, true, true, center};
    default:
      return {};
  }
}

/// Holds the motion that a joint to the world or a kinematic body holds.
inline void hold_by(dJointID joint, dBodyID body, OdeResponse& response) {
  const dBodyID first = dJointGetBody(joint, 0);
  const dBodyID other = first == body ? dJointGetBody(joint, 1) : first;
  if (!dJointIsEnabled(joint) || (other != nullptr && !dBodyIsKinematic(other))) return;
  const Vec3<double> center = ode_vector(dBodyGetPosition(body));
  Vec6<double> base = zero<Vec6<double>>();
  if (other != nullptr) {
    base = ode_twist(other);
    base.head<3>() += base.tail<3>().cross(center - ode_vector(dBodyGetPosition(other)));
  }
  const OdeHold held = ode_hold_of(joint, center);
  dVector3 axis = {held.axis.x(), held.axis.y(), held.axis.z()}, p, q;
  dPlaneSpace(axis, p, q);
  for (const dReal* direction : {axis, p, q}) {
    const Vec3<double> d = ode_vector(direction);
    if (direction == axis ? held.along : held.across) {
      response.hold(d, (held.point - center).cross(d), base);
    }
    if (direction == axis ? held.turn_along : held.turn_across) {
      response.hold(zero<Vec3<double>>(), d, base);
    }
  }
}

/// The response of a body in a step of dt [s], with gravity, its present forces and joints.
[[nodiscard]] inline OdeResponse ode_response(dBodyID body, double dt) {
  OdeResponse result;
  result.twist = ode_twist(body);
  if (dBodyIsKinematic(body)) return result;
  dMass mass;
  dBodyGetMass(body, &mass);
  Mat3<double> inertia;
  for (int i = 0; i < 3; ++i) inertia.row(i) = ode_vector(mass.I + 4 * i);
  const Mat3<double> R = ode_pose(body).rotation_matrix();
  inertia = (R * inertia * R.transpose()).eval();
  result.mobility = free_mobility<double>(1 / mass.mass, inertia.inverse());
  result.free = result.mobility.diagonal();
  if (dBodyGetGyroscopicMode(body)) {
    // Gyroscopic turning by the momentum at the end of the step, as in ODE.
    const Vec3<double> momentum = inertia * result.twist.tail<3>();
    result.twist.tail<3>() = (inertia - dt * skew(momentum)).inverse() * momentum;
  }
  Vec3<double> force = ode_vector(dBodyGetForce(body));
  if (dBodyGetGravityMode(body))
    force += mass.mass * ode_vector(dWorldGetGravity, dBodyGetWorld(body));
  result.twist += dt * result.mobility * stacked<double>(force, ode_vector(dBodyGetTorque(body)));
  for (int i = 0; i < dBodyGetNumJoints(body); ++i) hold_by(dBodyGetJoint(body, i), body, result);
  return result;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
