/// @file
/// Numbers with derivatives: every function against its closed form, and the rules at kinks.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/core/error.hpp>
#include <bristle/math/dual.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/simd.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

using D1 = Dual<double, 1>;
using D2 = Dual<double, 2>;

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Relative to some operations with one rounding each.
void check(const D1& y, double value, double slope) {
  CHECK(y.value() == value);
  CHECK(y.partial() == test::relative(slope).epsilon(1e-14));
}

}  // namespace

TEST_CASE("Dual: is a scalar of n + 1 numbers that is copied as bytes") {
  static_assert(Scalar<D1> && Scalar<Dual<double, 7>>);
  static_assert(!Scalar<Dual<float, 1>>);
  static_assert(derivatives_of<double> == 0 && derivatives_of<Dual<double, 3>> == 3);
  static_assert(sizeof(Dual<double, 3>) == 4 * sizeof(double));
  static_assert(std::is_trivially_copyable_v<D1> && PlainValue<D1>);
  static_assert(std::is_trivially_default_constructible_v<D1>);
  static_assert(!std::is_convertible_v<D1, double>);  // A derivative is not lost unasked.
  constexpr D2 x = D2::variable(3, 1);
  static_assert(x.value() == 3 && x.partial(0) == 0 && x.partial(1) == 1);
  static_assert(value_of(x) == 3 && static_cast<int>(x) == 3);
  static_assert(value_of(infinity<D1>) == infinite);
}

TEST_CASE("Dual: sums, products and quotients have the derivatives of the rules") {
  const D2 x = D2::variable(3, 0);
  const D2 y = D2::variable(-4, 1);
  const D2 f = (x * y - 2 * x / y + 5) * -x + y;  // -x^2 y + 2 x^2 / y - 5 x + y
  CHECK(f.value() == 36 - 4.5 - 15 - 4);
  CHECK(f.partial(0) == test::relative(24 - 3 - 5.0).epsilon(1e-15));
  CHECK(f.partial(1) == test::relative(-9 - 18.0 / 16 + 1).epsilon(1e-15));
  D2 g = x;
  g += y;
  g *= x;
  g -= 1;
  g /= y;  // (x^2 + x y - 1) / y
  CHECK(g.value() == test::relative(1));
  CHECK(g.partial(0) == test::relative((2 * 3 - 4) / -4.0).epsilon(1e-15));
  CHECK(g.partial(1) == test::relative(-(9 - 1) / 16.0).epsilon(1e-15));
}

TEST_CASE("Dual: functions have the derivatives of their closed forms") {
  for (const double v : {0.3, 0.71, 0.99}) {
    const D1 x = D1::variable(v);
    check(sqrt(x), std::sqrt(v), 0.5 / std::sqrt(v));
    check(sin(x), std::sin(v), std::cos(v));
    check(cos(x), std::cos(v), -std::sin(v));
    check(acos(x), std::acos(v), -1 / std::sqrt(1 - v * v));
    check(exp(x), std::exp(v), std::exp(v));
    check(expm1(x), std::expm1(v), std::exp(v));
    check(log(x), std::log(v), 1 / v);
    check(pow(x, 2.5), std::pow(v, 2.5), 2.5 * std::pow(v, 1.5));
    check(pow(2, x), std::pow(2, v), std::pow(2, v) * std::numbers::ln2);
    check(pow(-x, 2), v * v, 2 * v);
    check(hypot(x, 2 * x), std::hypot(v, 2 * v), std::sqrt(5));
    check(atan2(x, x * x), std::atan2(v, v * v), -1 / (1 + v * v));  // atan(1 / v)
    check(abs(-x), v, 1);
    check(abs(x), v, 1);
    check(copysign(x, -1), -v, -1);
    check(copysign(-x, -1), -v, -1);
    check(copysign(-x, 1), v, 1);
    check(floor(x), 0, 0);
    check(ceil(x), 1, 0);
    check(fmod(10 * x, 0.7), std::fmod(10 * v, 0.7), 10);
    check(fmod(5, x), std::fmod(5, v), -std::floor(5 / v));
    check(fmod(-5, x), std::fmod(-5, v), std::floor(5 / v));
  }
}

TEST_CASE("Dual: where a function has no finite slope its derivatives are 0, not NaN") {
  const D1 zero = D1::variable(0);
  check(sqrt(zero), 0, 0);
  check(abs(zero), 0, 0);
  check(hypot(zero, zero), 0, 0);
  check(atan2(zero, zero), 0, 0);
  check(acos(zero + 1), 0, 0);
  check(pow(zero, 0.5), 0, 0);
  check(1 / zero, infinite, 0);
  CHECK(log(zero).partial() == 0);
  CHECK((zero / zero).partial() == 0);
  CHECK((infinity<D1> * D1::variable(2)).partial() == 0);
  CHECK((D1::variable(2) / infinity<D1>).partial() == 0);
  CHECK(Vec3<D1>(zero, zero, zero).norm() == D1(0));
}

TEST_CASE("Dual: order is that of values, equality that of everything") {
  const D1 x = D1::variable(1);
  const D1 one = 1;
  CHECK((x <= one && x >= one && !(x < one) && !(x > one)));
  CHECK(x != one);
  CHECK(value_of(x) == value_of(one));
  CHECK(D1(-0.0) == D1(0.0));
  const D1 nan = std::numeric_limits<D1>::quiet_NaN();
  CHECK((nan != nan && !(nan < one) && !(nan >= one) && isnan(nan) && !isfinite(nan)));
  // Of what is equal by order, max and min give the first, with its derivatives.
  CHECK(std::max(one, x) == one);
  CHECK(std::max(x, one) == x);
  CHECK(std::clamp(3 * x, D1(0), D1(2)) == D1(2));
}

TEST_CASE("Dual: is a scalar to Eigen") {
  const D2 a = D2::variable(0.3, 0);
  const D2 b = D2::variable(-0.7, 1);
  const Vec3<D2> v(a, b, a * b);
  const D2 length = v.norm();
  const double n = std::sqrt(0.09 + 0.49 + 0.0441);
  CHECK(length.value() == test::relative(n).epsilon(1e-15));
  CHECK(length.partial(0) == test::relative((0.3 + 0.21 * 0.7) / n).epsilon(1e-14));
  CHECK(length.partial(1) == test::relative((-0.7 - 0.21 * 0.3) / n).epsilon(1e-14));
  CHECK(v.allFinite());
  // d(A^-1) = -A^-1 dA A^-1.
  Mat3<D2> A;
  A << 2, a, 0, a, 3, b, 0, b, 4;
  const Mat3<D2> inverse = A.inverse();
  const Mat3<double> value = inverse.cast<double>();
  Mat3<double> dA = Mat3<double>::Zero();
  dA(0, 1) = dA(1, 0) = 1;
  const Mat3<double> expected = -value * dA * value;
  for (Eigen::Index i = 0; i < 9; ++i) {
    CHECK(inverse(i).partial(0) == test::relative(expected(i)).epsilon(1e-13));
  }
  CHECK((2.0 * v).x() == D2(2) * a);
}

TEST_CASE("Dual: a rotation by an angle that is a variable turns about its axis") {
  // d(R p) / d phi = axis x (R p), by the series of small angles and by sines.
  const Vec3<double> axis = Vec3<double>(1, -2, 2) / 3;
  const Vec3<double> p(0.3, 0.5, -0.2);
  for (const double angle : {0.0, 0.1, 2.0}) {
    const D1 phi = D1::variable(angle);
    const Quat<D1> q = exp_rotation<D1>(phi * axis.cast<D1>());
    const Vec3<D1> turned = q * p.cast<D1>();
    const Vec3<double> expected = axis.cross(turned.cast<double>());
    for (Eigen::Index i = 0; i < 3; ++i) {
      CHECK(turned[i].partial() == test::relative(expected[i]).epsilon(1e-14));
    }
    // And back.
    const Vec3<D1> vector = log_rotation<D1>(q);
    for (Eigen::Index i = 0; i < 3; ++i) {
      CHECK(vector[i].partial() == test::relative(axis[i]).epsilon(1e-14));
    }
  }
}

TEST_CASE("Dual: in lanes it is what it is alone, and choices go by value") {
  std::vector<D1> x;
  for (std::size_t i = 0; i < lanes<D1>; ++i) x.push_back(D1(double(i), {1 + double(i)}));
  const Pack<D1> pack = Pack<D1>::load(x.data());
  const Pack<D1> y = select(pack == Pack<D1>(D1(2)), Pack<D1>(D1(7)), sqrt(pack * pack));
  for (std::size_t i = 0; i < lanes<D1>; ++i) {
    CHECK(y[i].value() == (i == 2 ? 7.0 : double(i)));
    CHECK(y[i].partial() == (i == 2 || i == 0 ? 0.0 : 1 + double(i)));
  }
  CHECK(sum_of_lanes(pack) == D1(6, {10}));
}

TEST_CASE("Dual: hashes tell derivatives apart, errors name the value") {
  const auto hash = [](const D1& x) {
    BitHash h;
    h.add(x);
    return h.value();
  };
  CHECK(hash(D1(1)) == hash(D1(1)));
  CHECK(hash(D1(1)) != hash(D1::variable(1)));
  CHECK_THROWS_WITH_AS(detail::require_positive("mass", D1::variable(-2.5)),
                       "mass = -2.5: must be finite and > 0", InvalidArgument);
}
