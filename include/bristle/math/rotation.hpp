/// @file
/// Rotations: the exponential map, the step of a quaternion, and bases from one direction.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/math_constants.hpp>
#include <bristle/math/types.hpp>

#include <cmath>
#include <numbers>

namespace bristle::inline BRISTLE_ABI {

/// Quaternion of the rotation vector phi [rad]: rotation by |phi| about phi. Exact for every |phi|,
/// including 0.
template <Scalar S>
[[nodiscard]] Quat<S> exp_rotation(const Vec3<S>& phi) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const S angle2 = phi.squaredNorm();
  // Most bodies turn by little in a step. Up to a quarter of a radian, two series in y = (a/2)^2
  // are exact to the last bit. They are those of the cosine and of sin(a/2)/a. The omitted terms,
  // y^6 / 12! and y^5 / 11!, are below 3e-17.
  if (angle2 < S(0.0625)) {
    const S y = S(0.25) * angle2;
    const S cosine =
        S(1) +
        y * (S(-1.0 / 2) +
             y * (S(1.0 / 24) + y * (S(-1.0 / 720) + y * (S(1.0 / 40320) - y * S(1.0 / 3628800)))));
    const S k = S(0.5) +
                y * (S(-0.5 / 6) + y * (S(0.5 / 120) + y * (S(-0.5 / 5040) + y * S(0.5 / 362880))));
    return Quat<S>(cosine, k * phi.x(), k * phi.y(), k * phi.z());
  }
  const S angle = sqrt(angle2);
  const S k = sin(angle / S(2)) / angle;
  return Quat<S>(cos(angle / S(2)), k * phi.x(), k * phi.y(), k * phi.z());
}

/// Rotation vector [rad] of a unit quaternion, of length <= pi. It is the inverse of
/// `exp_rotation`.
template <Scalar S>
[[nodiscard]] Vec3<S> log_rotation(const Quat<S>& q) {
  using std::atan2;
  const S sign = q.w() < S(0) ? S(-1) : S(1);
  const Vec3<S> v = sign * q.vec();
  const S sine = v.norm();
  if (sine * sine < detail::Tolerance<S>::round_off()) return S(2) * v;
  return (S(2) * atan2(sine, sign * q.w()) / sine) * v;
}

/// Rotation vector [rad] of the shortest rotation from the unit vector a to the unit vector b. Zero
/// for opposite vectors, where it has no direction.
template <Scalar S>
[[nodiscard]] Vec3<S> shortest_turn(const Vec3<S>& a, const Vec3<S>& b) {
  using std::atan2;
  const Vec3<S> c = a.cross(b);
  const S sine = c.norm();
  if (sine * sine < detail::Tolerance<S>::round_off()) return c;
  return (atan2(sine, a.dot(b)) / sine) * c;
}

/// [rad] The angle that differs from `angle` by whole turns and is nearest to `guess`.
template <Scalar S>
[[nodiscard]] S nearest_turn(S angle, S guess) {
  using std::abs;
  using std::floor;
  const S turn = S(2 * std::numbers::pi);
  const S turns = (guess - angle) / turn;
  // The angle stays as it is if round-off reaches a whole turn.
  if (!(abs(turns) * detail::Tolerance<S>::round_off() < S(1))) return angle;
  return angle + turn * floor(turns + S(0.5));
}

/// The rotation p q, of length 1 to round-off. Each product corrects the length that it loses.
template <Scalar S>
[[nodiscard]] Quat<S> unit_product(const Quat<S>& p, const Quat<S>& q) {
  using std::abs;
  // In scalars. A quaternion that is stored as two halves and loaded as a whole is slow. That costs
  // as much as all the rest.
  const S x = (p.w() * q.x() + p.x() * q.w()) + (p.y() * q.z() - p.z() * q.y());
  const S y = (p.w() * q.y() + p.y() * q.w()) + (p.z() * q.x() - p.x() * q.z());
  const S z = (p.w() * q.z() + p.z() * q.w()) + (p.x() * q.y() - p.y() * q.x());
  const S w = (p.w() * q.w() - p.x() * q.x()) - (p.y() * q.y() + p.z() * q.z());
  const S norm2 = (x * x + y * y) + (z * z + w * w);
  // Where the length is 1 but for round-off, one Newton step for 1 / |p q| is exact.
  if (!(abs(norm2 - S(1)) < detail::Tolerance<S>::equal())) return Quat<S>(w, x, y, z).normalized();
  const S scale = S(0.5) * (S(3) - norm2);
  return Quat<S>(scale * w, scale * x, scale * y, scale * z);
}

/// Attitude after rotation for `dt` with the constant world-frame angular velocity `w_W` [rad/s].
template <Scalar S>
[[nodiscard]] Quat<S> step_rotation(const Quat<S>& q, const Vec3<S>& w_W, S dt) {
  return unit_product(exp_rotation<S>(dt * w_W), q);
}

namespace detail {

/// [rad/s] Angular velocity that turns by `far_turn_of_step` in a step.
template <Scalar S>
[[nodiscard]] S far_turn(S dt) {
  return S(chosen::far_turn_of_step) / dt;
}
/// Returns whether an angular velocity [rad/s] turns a body farther than that.
template <Scalar S>
[[nodiscard]] bool turns_far(const Vec3<S>& angular, S dt) {
  return angular.squaredNorm() > far_turn(dt) * far_turn(dt);
}

}  // namespace detail

/// The matrix R_AB of a unit quaternion.
///
/// Each product is doubled last. So its bits are the same if a compiler fuses the doubling with the
/// sum behind it, as the straight-line vectorizer of g++ 12 does in spite of `-ffp-contract=off`.
template <Scalar S>
[[nodiscard]] Mat3<S> rotation_matrix(const Quat<S>& q) {
  const S xx = q.x() * q.x(), yy = q.y() * q.y(), zz = q.z() * q.z();
  const S xy = q.x() * q.y(), xz = q.x() * q.z(), yz = q.y() * q.z();
  const S wx = q.w() * q.x(), wy = q.w() * q.y(), wz = q.w() * q.z();
  const S two = S(2);
  Mat3<S> R;
  R(0, 0) = S(1) - (two * yy + two * zz);
  R(1, 0) = two * xy + two * wz;
  R(2, 0) = two * xz - two * wy;
  R(0, 1) = two * xy - two * wz;
  R(1, 1) = S(1) - (two * xx + two * zz);
  R(2, 1) = two * yz + two * wx;
  R(0, 2) = two * xz + two * wy;
  R(1, 2) = two * yz - two * wx;
  R(2, 2) = S(1) - (two * xx + two * yy);
  return R;
}

/// Two unit vectors that complete the unit vector n to a right-handed orthonormal basis (t1, t2,
/// n).
///
/// Continuous except where n.z changes its sign (Duff et al. 2017, "Building an Orthonormal Basis,
/// Revisited"). So components along t1 and t2 must not outlive a change of n.
template <Scalar S>
void tangent_basis(const Vec3<S>& n, Vec3<S>& t1, Vec3<S>& t2) {
  const S sign = n.z() < S(0) ? S(-1) : S(1);
  const S a = S(-1) / (sign + n.z());
  const S b = n.x() * n.y() * a;
  t1 = Vec3<S>(S(1) + sign * n.x() * n.x() * a, sign * b, -sign * n.x());
  t2 = Vec3<S>(b, sign + n.y() * n.y() * a, -n.y());
}

}  // namespace bristle::inline BRISTLE_ABI
