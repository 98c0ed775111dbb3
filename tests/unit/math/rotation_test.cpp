// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/math/rotation.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

using namespace bristle;
using namespace bristle::detail;

TEST_CASE_TEMPLATE("exp_rotation: turns by the length of the vector, about it", S, float, double) {
  const S quarter = std::numbers::pi_v<S> / S(2);
  const Quat<S> q = exp_rotation<S>({0, 0, quarter});
  CHECK((q * Vec3<S>(1, 0, 0) - Vec3<S>(0, 1, 0)).norm() < Tolerance<S>::round_off());
  CHECK(exp_rotation<S>(Vec3<S>::Zero()).coeffs() == Quat<S>::Identity().coeffs());
}

TEST_CASE_TEMPLATE("log_rotation: inverts exp_rotation at all angles", S, float, double) {
  test::Random random(1);
  for (const S angle : {S(1e-12), S(1e-6), S(1e-3), S(0.1), S(1), S(3)}) {
    for (int i = 0; i < 20; ++i) {
      const Vec3<S> phi = angle * random.direction<S>();
      const Quat<S> q = exp_rotation<S>(phi);
      CHECK(std::abs(q.norm() - S(1)) < Tolerance<S>::round_off());
      const Vec3<S> back = log_rotation<S>(q);
      CHECK((back - phi).norm() < S(4) * Tolerance<S>::round_off() * angle);
      // -q is the same rotation.
      const Quat<S> minus(-q.w(), -q.x(), -q.y(), -q.z());
      CHECK((log_rotation<S>(minus) - phi).norm() < S(4) * Tolerance<S>::round_off() * angle);
    }
  }
}

TEST_CASE_TEMPLATE("rotation_matrix: is that of Eigen, and fused multiply-adds change no bit", S,
                   float, double) {
  test::Random random(5);
  for (int i = 0; i < 200; ++i) {
    const Quat<S> q = exp_rotation<S>(S(3) * random.direction<S>());
    const Mat3<S> R = rotation_matrix<S>(q);
    CHECK((R - q.toRotationMatrix()).norm() < Tolerance<S>::round_off());
    // What a compiler makes of `2 a + b` where it may.
    const S xy = q.x() * q.y();
    const S wz = q.w() * q.z();
    CHECK(std::fma(S(2), xy, S(2) * wz) == R(1, 0));
    CHECK(std::fma(S(2), xy, -(S(2) * wz)) == R(0, 1));
  }
}

TEST_CASE_TEMPLATE("step_rotation: many small steps make a large one", S, float, double) {
  Quat<S> q = Quat<S>::Identity();
  const Vec3<S> omega(S(0.3), S(-0.2), S(0.5));
  for (int i = 0; i < 100; ++i) q = step_rotation<S>(q, omega, S(0.01));
  CHECK(q.angularDistance(exp_rotation<S>(omega)) <
        (std::is_same_v<S, double> ? S(1e-7) : S(2e-3)));
  CHECK(std::abs(q.norm() - S(1)) < Tolerance<S>::round_off());
}

TEST_CASE_TEMPLATE(
    "exp_rotation: the series of small angles and the functions agree to the last bits", S, float,
    double) {
  test::Random random(7);
  const S few_bits = S(2) * std::numeric_limits<S>::epsilon();
  for (int i = 0; i < 1000; ++i) {
    // Below and above the angle from which the functions are called.
    const S angle = S(0.3) * S(i + 1) / S(1000);
    const Vec3<S> axis = random.direction<S>();
    const Quat<S> q = exp_rotation<S>(angle * axis);
    const Vec3<double> phi = (angle * axis).template cast<double>();
    const double exact = phi.norm();
    CHECK(std::abs(q.w() - S(std::cos(exact / 2))) <= std::numeric_limits<S>::epsilon());
    const Vec3<double> sine = (std::sin(exact / 2) / exact) * phi;
    CHECK((q.vec() - sine.template cast<S>()).norm() <= few_bits * S(angle));
  }
}

TEST_CASE_TEMPLATE("unit_product: the product of Eigen, of length 1", S, float, double) {
  test::Random random(9);
  const S few_bits = S(4) * std::numeric_limits<S>::epsilon();
  for (int i = 0; i < 1000; ++i) {
    const Quat<S> p = exp_rotation<S>(random.in_cube(S(3)));
    Quat<S> q = exp_rotation<S>(random.in_cube(S(3)));
    if (i % 2 == 0) q.coeffs() *= random.uniform(S(0.1), S(10));
    CHECK((unit_product(p, q).coeffs() - (p * q).normalized().coeffs()).norm() <= few_bits);
  }
}

TEST_CASE_TEMPLATE("step_rotation: stays of unit length, and comes back to it from any other", S,
                   float, double) {
  test::Random random(8);
  const Quat<S> start = exp_rotation<S>(random.direction<S>());
  const Vec3<S> omega(S(3), S(-2), S(5));
  const S few_bits = S(4) * std::numeric_limits<S>::epsilon();
  Quat<S> q = start;
  for (int i = 0; i < 100000; ++i) q = step_rotation<S>(q, omega, S(0.01));
  CHECK(std::abs(q.norm() - S(1)) <= few_bits);
  const Quat<S> turned = step_rotation<S>(start, omega, S(0.01));
  for (const S length :
       {S(1) + S(0.4) * Tolerance<S>::equal(), S(1) - S(1e-6), S(1) + S(3e-4), S(0.5), S(20)}) {
    Quat<S> other = start;
    other.coeffs() *= length;
    const Quat<S> back = step_rotation<S>(other, omega, S(0.01));
    CHECK((back.coeffs() - turned.coeffs()).norm() <= few_bits);
  }
}

TEST_CASE_TEMPLATE("tangent_basis: right-handed, orthonormal, for every direction", S, float,
                   double) {
  test::Random random(2);
  for (int i = 0; i < 200; ++i) {
    Vec3<S> n = random.direction<S>();
    if (i < 6) n = S(i % 2 == 0 ? 1 : -1) * Vec3<S>::Unit(i / 2);
    Vec3<S> t1, t2;
    tangent_basis<S>(n, t1, t2);
    Mat3<S> R;
    R << t1, t2, n;
    CHECK((R.transpose() * R - Mat3<S>::Identity()).norm() < S(2) * Tolerance<S>::round_off());
    CHECK(std::abs(R.determinant() - S(1)) < S(2) * Tolerance<S>::round_off());
  }
}
