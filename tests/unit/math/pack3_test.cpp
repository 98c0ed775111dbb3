// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/math/pack3.hpp>

#include <doctest/doctest.h>

#include <array>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE_TEMPLATE("Pack3: computes in every lane what vectors do", S, float, double) {
  test::Random random(1);
  constexpr std::size_t n = lanes<S>;
  std::array<std::array<S, n>, 3> a, b;
  for (auto* v : {&a, &b}) {
    for (auto& axis : *v) {
      for (S& value : axis) value = random.uniform(S(-1), S(1));
    }
  }
  const auto p = Pack3<S>::load(a[0].data(), a[1].data(), a[2].data());
  const auto q = Pack3<S>::load(b[0].data(), b[1].data(), b[2].data());
  Mat3<S> M;
  for (int i = 0; i < 9; ++i) M.data()[i] = random.uniform(S(-1), S(1));
  const Vec3<S> constant(1, 2, 3);
  std::array<std::array<S, n>, 3> stored;
  (p - q).store(stored[0].data(), stored[1].data(), stored[2].data());
  // Coordinates are at most 1: products of three terms are at most 3 with errors of some ulp.
  const S tolerance = S(3) * Tolerance<S>::round_off();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3<S> v(a[0][i], a[1][i], a[2][i]);
    const Vec3<S> w(b[0][i], b[1][i], b[2][i]);
    CHECK(p[i] == v);
    CHECK((p + q)[i] == v + w);
    CHECK(Vec3<S>(stored[0][i], stored[1][i], stored[2][i]) == v - w);
    CHECK((-p)[i] == -v);
    CHECK((p.x * q)[i] == v.x() * w);
    CHECK(Pack3<S>::all(constant)[i] == constant);
    CHECK(select(p.x < q.x, p, q)[i] == (v.x() < w.x() ? v : w));
    CHECK(std::abs(dot(p, q)[i] - v.dot(w)) < tolerance);
    CHECK((cross(p, q)[i] - v.cross(w)).norm() < tolerance);
    CHECK(((M * p)[i] - M * v).norm() < tolerance);
  }
}
