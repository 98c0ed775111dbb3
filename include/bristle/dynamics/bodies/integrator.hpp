/// @file
/// Free velocities, and poses from velocities.
///
/// The turn of a body in one step keeps angular momentum exactly and kinetic energy to round-off:
/// the discrete Moser-Veselov equation of the free top with preprocessed inertia (Hairer and
/// Vilmart 2006, "Preprocessed discrete Moser-Veselov algorithm for the full dynamics of a rigid
/// body"), fourth order in the step, in parts of at most a radian where the body spins faster.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/math/rotation.hpp>

namespace bristle::inline BRISTLE_ABI {

/// Velocities of a body after the forces known at the start of the step: gravity and what the
/// caller applies. The gyroscopic torque is not among them; `step_pose` accounts for it exactly.
template <Scalar S>
[[nodiscard]] Twist<S> free_twist(const Body<S>& body, const Vec3<S>& gravity, S dt) {
  Twist<S> result = body.twist;
  if (!body.is_dynamic()) return result;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (body.locked.linear[k]) continue;
    result.linear[i] +=
        dt * (body.gravity_scale * gravity[i] + body.inverse_mass * body.applied.force[i]);
  }
  if (body.applied.torque != Vec3<S>::Zero()) {
    result.angular += dt * (body.inverse_inertia_W() * body.applied.torque);
  }
  return result;
}

/// Moves a body by one step.
///
/// A dynamic body keeps its angular momentum, so its angular velocity, which comes in as at the old
/// attitude, changes as it turns.
/// @param motion  [m/s, rad/s] Displacement divided by the step, at the old attitude.
template <Scalar S>
void step_pose(Body<S>& body, const Twist<S>& motion, S dt);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// Vector part q of the quaternion of one step of the free top, in body axes: the root of
/// q0 J q + q x J q = h y / 2 with q0 = sqrt(1 - |q|^2), by Newton. Returns false when the step
/// turns too far for a root.
/// @param inertia  [kg m^2] Over any unit, near which it is, as are its inverse and y.
/// @param y        [kg m^2/s] Body-frame angular momentum.
template <Scalar S>
bool solve_top_step(const Mat3<S>& inertia, const Mat3<S>& inverse_inertia, const Vec3<S>& y, S h,
                    Vec3<S>& q) {
  using std::sqrt;
  // Preprocessing: with these modified moments the second-order map is fourth-order.
  const S trace_inverse = inverse_inertia.trace();
  const S product = inertia.determinant();
  const S sum = inertia.trace();
  const S C = y.squaredNorm() / S(2);
  const S H = y.dot(inverse_inertia * y) / S(2);
  const S scale = sum / (S(6) * product);
  const S s = -trace_inverse * H / S(3) + scale * C;
  const S d = scale * H - C / (S(3) * product);
  const Mat3<S> inverse_J = (S(1) + h * h * s) * inverse_inertia + h * h * d * Mat3<S>::Identity();
  const Mat3<S> J = inverse_J.inverse();

  const Vec3<S> target = (h / S(2)) * y;
  q = inverse_J * target;
  const S round_off = Tolerance<S>::round_off();
  for (int iteration = 0; iteration < 8; ++iteration) {
    const S rest = S(1) - q.squaredNorm();
    if (!(rest > S(0.5))) return false;
    const S q0 = sqrt(rest);
    const Vec3<S> Jq = J * q;
    const Vec3<S> residual = q0 * Jq + q.cross(Jq) - target;
    const Mat3<S> slope = q0 * J - Jq * (q.transpose() / q0) + skew(q) * J - skew(Jq);
    const Vec3<S> change = slope.inverse() * residual;
    q -= change;
    if (change.squaredNorm() <= round_off * round_off * q.squaredNorm()) return true;
  }
  return true;
}

template <Scalar S>
[[nodiscard]] bool is_isotropic(const Mat3<S>& inertia) {
  using std::abs;
  using std::max;
  const S unequal = max(abs(inertia(1, 1) - inertia(0, 0)), abs(inertia(2, 2) - inertia(0, 0)));
  const S mixed = max({abs(inertia(1, 0)), abs(inertia(2, 0)), abs(inertia(2, 1))});
  return max(unequal, mixed) <= Tolerance<S>::round_off() * inertia(0, 0);
}

/// Turns a body as a free top that has the angular velocity w [rad/s, world axes] now; the body's
/// own angular momentum stays, its angular velocity follows its attitude. The step is halved until
/// each part turns by less than a radian, where the map has its root.
template <Scalar S>
void turn_free_top(Body<S>& body, const Vec3<S>& w, S dt) {
  using std::sqrt;
  Quat<S>& rotation = body.center_pose.rotation;
  // Over a power of two near the inertia, which scales out of the equation: its third power stays
  // in range then.
  const S scale = power_of_two_below(S(body.inertia_B.trace()));
  const S unit = S(1) / scale;
  const Mat3<S> inertia = unit * body.inertia_B;
  const Mat3<S> inverse_inertia = scale * body.inverse_inertia_B;
  const Mat3<S> R = body.center_pose.rotation_matrix();
  const Vec3<S> own_L_W = R * (inertia * (R.transpose() * body.twist.angular));
  const Vec3<S> L_W = rotation * (inertia * (rotation.conjugate() * w));
  if (!(L_W.squaredNorm() > S(0)) && !(own_L_W.squaredNorm() > S(0))) return;
  // The fastest that this momentum can ever turn the body, whatever its attitude becomes.
  const S fastest = dt * L_W.norm() * inverse_inertia.norm();
  constexpr int most_parts = 4096;
  int parts = 1;
  while (S(parts) < fastest && parts < most_parts) parts *= 2;
  const S h = dt / S(parts);
  for (int i = 0; i < parts; ++i) {
    const Vec3<S> y = rotation.conjugate() * L_W;
    Vec3<S> q;
    if (solve_top_step(inertia, inverse_inertia, y, h, q)) {
      const Quat<S> turn(sqrt(S(1) - q.squaredNorm()), q.x(), q.y(), q.z());
      rotation = unit_product(rotation, turn);
    } else {
      // Faster than the parts resolve: momentum is still kept, and energy stays between its bounds.
      rotation = step_rotation<S>(rotation, rotation * (inverse_inertia * y), h);
    }
  }
  body.twist.angular = rotation * (inverse_inertia * (rotation.conjugate() * own_L_W));
}

}  // namespace detail

template <Scalar S>
void step_pose(Body<S>& body, const Twist<S>& motion, S dt) {
  Transform<S>& X = body.center_pose;
  X.translation += dt * motion.linear;
  if (body.is_dynamic() && !body.locked.any_angular() && !detail::is_isotropic(body.inertia_B)) {
    detail::turn_free_top(body, motion.angular, dt);
  } else {
    X.rotation = step_rotation(X.rotation, motion.angular, dt);
  }
}

}  // namespace bristle::inline BRISTLE_ABI
