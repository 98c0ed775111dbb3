/// @file
/// Free velocities, and poses from velocities.
///
/// The rotation of a body in one step keeps angular momentum exactly. It keeps kinetic energy to
/// round-off. It uses the discrete Moser-Veselov equation of the free top with preprocessed inertia
/// (Hairer and Vilmart 2006, "Preprocessed discrete Moser-Veselov algorithm for the full dynamics
/// of a rigid body"). It is of fourth order in the step. Fast spins are split into parts of at most
/// a radian.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/dynamics/dynamics_constants.hpp>
#include <bristle/math/rotation.hpp>

#include <cmath>

namespace bristle::inline BRISTLE_ABI::detail {

/// Exact solution of v' = a - rate v over a step: v(dt) = kept v + lasting a.
template <Scalar S>
struct Decay {
  /// [1] exp(-rate dt).
  S kept;
  /// [s] (1 - exp(-rate dt)) / rate. Without damping that is the step.
  S lasting;
};
template <Scalar S>
[[nodiscard]] Decay<S> decay(const S& rate, const S& dt) {
  using std::expm1;
  const S x = rate * dt;
  // The next terms of the two series are x^2 / 2 and x^2 / 6. Below 1e-8 they are less than half a
  // rounding of double, and lost. So they are in float.
  if (x < S(1e-8)) return {S(1) - x, dt * (S(1) - S(0.5) * x)};
  const S lost = -expm1(-x);
  return {S(1) - lost, lost / rate};
}

/// Effect of damping on a body in a step. It exists beside `Body` since a step needs it twice, and
/// it costs two exponentials.
template <Scalar S>
struct BodyDecay {
  Decay<S> linear, angular;
};
template <Scalar S>
[[nodiscard]] BodyDecay<S> decay_of(const Body<S>& body, const S& dt) {
  if (!is_damped(body)) return {{S(1), dt}, {S(1), dt}};
  return {decay(body.linear_damping, dt), decay(body.angular_damping, dt)};
}

/// Velocities of a body after the forces known at the start of the step. These are gravity, the
/// caller's wrench and damping. The gyroscopic torque is left out: `step_pose` accounts for it
/// exactly.
/// @param decay  `decay_of` the body and the step.
template <Scalar S>
[[nodiscard]] Twist<S> free_twist(const Body<S>& body, const Vec3<S>& gravity,
                                  const BodyDecay<S>& decay) {
  Twist<S> result = body.twist;
  if (!body.is_dynamic()) return result;
  if (is_damped(body)) {
    result.linear *= decay.linear.kept;
    result.angular *= decay.angular.kept;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (body.locked.linear[k]) continue;
    result.linear[i] += decay.linear.lasting * (body.gravity_scale * gravity[i] +
                                                body.inverse_mass * body.applied.force[i]);
  }
  if (body.applied.torque != zero<Vec3<S>>()) {
    result.angular += decay.angular.lasting * (body.inverse_inertia_W() * body.applied.torque);
  }
  return result;
}

/// Moves a body by one step.
///
/// A dynamic body keeps its angular momentum. Its angular velocity is given at the old attitude. It
/// changes as the body turns.
/// @param motion  [m/s, rad/s] Displacement divided by the step, at the old attitude.
template <Scalar S>
void step_pose(Body<S>& body, const Twist<S>& motion, S dt);

// Implementation ----------------------------------------------------------------------------------

/// Solves one step of the free top, in body axes. The vector part q of its quaternion is found by
/// Newton's method. It is the root of q0 J q + q x J q = h y / 2 with q0 = sqrt(1 - |q|^2). Returns
/// false if the step turns too far for a root.
/// @param inertia  [kg m^2] In a unit near its size. `inverse_inertia` and y use the same unit.
/// @param y        [kg m^2/s] Body-frame angular momentum.
template <Scalar S>
bool solve_top_step(const Mat3<S>& inertia, const Mat3<S>& inverse_inertia, const Vec3<S>& y, S h,
                    Vec3<S>& q) {
  using std::sqrt;
  // Preprocessing: these modified moments make the second-order map one of fourth order.
  const S trace_inverse = inverse_inertia.trace();
  const S product = inertia.determinant();
  const S sum = inertia.trace();
  const S C = y.squaredNorm() / S(2);
  const S H = y.dot(inverse_inertia * y) / S(2);
  const S scale = sum / (S(6) * product);
  const S s = -trace_inverse * H / S(3) + scale * C;
  const S d = scale * H - C / (S(3) * product);
  const Mat3<S> inverse_J = (S(1) + h * h * s) * inverse_inertia + h * h * d * identity<Mat3<S>>();
  const Mat3<S> J = inverse_of(inverse_J);

  const Vec3<S> target = (h / S(2)) * y;
  q = inverse_J * target;
  const S round_off = Tolerance<S>::round_off();
  for (int iteration = 0; iteration < chosen::most_top_iterations; ++iteration) {
    const S rest = S(1) - q.squaredNorm();
    // A substep turns by a radian at most. Beyond a quarter turn, with 2 q0^2 < 1, q has
    // left the root.
    if (!(rest > S(0.5))) return false;
    const S q0 = sqrt(rest);
    const Vec3<S> Jq = J * q;
    const Vec3<S> residual = q0 * Jq + q.cross(Jq) - target;
    const Mat3<S> slope = q0 * J - Jq * (q.transpose() / q0) + skew(q) * J - skew(Jq);
    const Vec3<S> change = inverse_of(slope) * residual;
    q -= change;
    if (change.squaredNorm() <= round_off * round_off * q.squaredNorm()) return true;
  }
  return true;
}

/// Returns whether an inertia is a number times the identity, to round-off.
template <Scalar S>
[[nodiscard]] bool is_isotropic(const Mat3<S>& inertia) {
  using std::abs;
  using std::max;
  const S unequal = max(abs(inertia(1, 1) - inertia(0, 0)), abs(inertia(2, 2) - inertia(0, 0)));
  const S mixed = max({abs(inertia(1, 0)), abs(inertia(2, 0)), abs(inertia(2, 1))});
  return max(unequal, mixed) <= Tolerance<S>::round_off() * inertia(0, 0);
}

/// Turns a body as a free top that now has the angular velocity w [rad/s, world axes]. The body's
/// own angular momentum stays, as far as the step resolves it; its angular velocity follows its
/// attitude. The step is halved until each part turns by less than a radian. The map then has its
/// root.
template <Scalar S>
void turn_free_top(Body<S>& body, const Vec3<S>& w, S dt) {
  using std::sqrt;
  Quat<S>& rotation = body.center_pose.rotation;
  // Divided by a power of two near the inertia, which cancels in the equation. Its third power then
  // stays in range.
  const S scale = power_of_two_below(S(body.inertia_B.trace()));
  const S unit = S(1) / scale;
  const Mat3<S> inertia = unit * body.inertia_B;
  const Mat3<S> inverse_inertia = scale * body.inverse_inertia_B;
  const Mat3<S> R = body.center_pose.rotation_matrix();
  const Vec3<S> own_L_W = R * (inertia * (R.transpose() * body.twist.angular));
  const Vec3<S> L_W = rotation * (inertia * (rotation.conjugate() * w));
  if (!(L_W.squaredNorm() > S(0)) && !(own_L_W.squaredNorm() > S(0))) return;
  // The fastest rotation by this momentum, at any attitude.
  const S fastest = dt * L_W.norm() * inverse_inertia.norm();
  int substeps = 1;
  while (S(substeps) < fastest && substeps < chosen::most_top_substeps) substeps *= 2;
  const S h = dt / S(substeps);
  for (int i = 0; i < substeps; ++i) {
    const Vec3<S> y = rotation.conjugate() * L_W;
    Vec3<S> q;
    if (solve_top_step(inertia, inverse_inertia, y, h, q)) {
      const Quat<S> turn(sqrt(S(1) - q.squaredNorm()), q.x(), q.y(), q.z());
      rotation = unit_product(rotation, turn);
    } else {
      // Faster than substeps resolve. Momentum is still kept. Energy stays in its bounds.
      rotation = step_rotation<S>(rotation, rotation * (inverse_inertia * y), h);
    }
  }
  const auto turning_by = [&](const Vec3<S>& momentum_W) -> Vec3<S> {
    return rotation * (inverse_inertia * (rotation.conjugate() * momentum_W));
  };
  // Trapezoidal steps move the body by the mean of two velocities. The momentum beyond that of the
  // motion is half of the step's impulses. It stays in the world, too, while the axes turn. On a
  // thin body it may then have a component about the thin axis that turns it by radians a step. A
  // step does not resolve that, and energy would come from nothing. The body then takes these
  // impulses along as it turns.
  const Vec3<S> stayed = turning_by(own_L_W);
  const Vec3<S> taken = turning_by(L_W) + rotation * (R.transpose() * (body.twist.angular - w));
  body.twist.angular = turns_far<S>(stayed - taken, dt) ? taken : stayed;
}

template <Scalar S>
void step_pose(Body<S>& body, const Twist<S>& motion, S dt) {
  Transform<S>& X = body.center_pose;
  X.translation += dt * motion.linear;
  if (body.is_dynamic() && !body.locked.any_angular() && !is_isotropic(body.inertia_B)) {
    turn_free_top(body, motion.angular, dt);
  } else {
    X.rotation = step_rotation(X.rotation, motion.angular, dt);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
