// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/math/rotation.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;

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

TEST_CASE_TEMPLATE("step_rotation: many small steps make a large one", S, float, double) {
  Quat<S> q = Quat<S>::Identity();
  const Vec3<S> omega(S(0.3), S(-0.2), S(0.5));
  for (int i = 0; i < 100; ++i) q = step_rotation<S>(q, omega, S(0.01));
  CHECK(q.angularDistance(exp_rotation<S>(omega)) <
        (std::is_same_v<S, double> ? S(1e-7) : S(2e-3)));
  CHECK(std::abs(q.norm() - S(1)) < Tolerance<S>::round_off());
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
