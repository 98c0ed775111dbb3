/// @file
/// Relative motion of two bodies at a contact patch. A force and a torque between them cause it. It
/// is found once for a manifold. The response of each of its points follows from it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/solver/solver_types.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// Relative velocity of b and a at a point between them. Relative rotation of the bodies. Both are
/// along the axes of a contact, per unit of force along these axes and of torque about them.
template <Scalar S>
struct ManifoldMobility {
  ManifoldMobility(const ContactConstraint<S>& c, const SolverBody<S>& a, const SolverBody<S>& b,
                   const Vec3<S>& arm_a, const Vec3<S>& arm_b) {
    const ContactFrame<S> frame(c, a, b);
    linear.set(frame.inverse_mass);
    if (frame.turns_a) add(frame.inverse_inertia_a, frame.to_contact * arm_a);
    if (frame.turns_b) add(frame.inverse_inertia_b, frame.to_contact * arm_b);
  }
  /// Adds one body. It has torques r x e_k from unit forces at the arm r.
  void add(const Mat3<S>& J, const Vec3<S>& r) {
    angular += J;
    const Mat3<S> by = times_skew<S>(J, r);
    turn += by;
    linear.nn += r[2] * by(1, 0) - r[1] * by(2, 0);
    linear.n1 += r[0] * by(2, 0) - r[2] * by(0, 0);
    linear.n2 += r[1] * by(0, 0) - r[0] * by(1, 0);
    linear.a += r[0] * by(2, 1) - r[2] * by(0, 1);
    linear.b += r[1] * by(0, 1) - r[0] * by(1, 1);
    linear.c += r[1] * by(0, 2) - r[0] * by(1, 2);
  }
  /// Velocities along the axes for forces along them.
  ContactResponse<S> linear;
  /// Rotations about the axes (rows) for forces along them (columns). Its transpose gives
  /// velocities for torques.
  Mat3<S> turn = zero<Mat3<S>>();
  /// Rotations for torques.
  Mat3<S> angular = zero<Mat3<S>>();
};

}  // namespace bristle::inline BRISTLE_ABI::detail
