// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/math/lane_value.hpp>

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// A formula as the law has them: a branch, a choice, and a call that is not vectorised.
template <Value T>
Vector3<T> folded(const Vector3<T>& a, const Vector3<T>& n, T size) {
  using std::fmod;
  using std::sqrt;
  const Vector3<T> across = a - dot(n, a) * n;
  const T length = sqrt(dot(across, across));
  const Truth<T> is_over = length > size;
  if (!any(is_over)) return cross(across, n);
  return select(is_over, T(fmod(length, size) / length) * across, zero_vector<T>());
}

template <Scalar S>
Pack3<S> pack_of(const Vec3<S>* items) {
  S x[lanes<S>], y[lanes<S>], z[lanes<S>];
  for (std::size_t i = 0; i < lanes<S>; ++i) {
    x[i] = items[i].x();
    y[i] = items[i].y();
    z[i] = items[i].z();
  }
  return Pack3<S>::load(x, y, z);
}

}  // namespace

TEST_CASE_TEMPLATE("Value: one formula, the same in a scalar and in each lane", S, float, double) {
  test::Random random(1);
  for (int round = 0; round < 100; ++round) {
    Vec3<S> a[lanes<S>], n[lanes<S>];
    for (std::size_t i = 0; i < lanes<S>; ++i) {
      a[i] = random.in_cube(S(1));
      n[i] = random.direction<S>();
    }
    // With all lanes over, or none, or some: the branch is taken for all or for nobody.
    const S size = round % 3 == 0 ? S(0.01) : round % 3 == 1 ? S(10) : S(0.5);
    const Pack3<S> found = folded<Pack<S>>(pack_of(a), pack_of(n), Pack<S>(size));
    bool some_over = false;
    for (std::size_t i = 0; i < lanes<S>; ++i) {
      some_over = some_over || (a[i] - n[i].dot(a[i]) * n[i]).norm() > size;
    }
    for (std::size_t i = 0; i < lanes<S>; ++i) {
      Vec3<S> expected = folded<S>(a[i], n[i], size);
      const bool is_over = (a[i] - n[i].dot(a[i]) * n[i]).norm() > size;
      if (some_over && !is_over) expected.setZero();
      // fmod of lengths that differ by a rounding may differ by a hundred of them here.
      CHECK((found[i] - expected).norm() < S(100) * Tolerance<S>::round_off());
    }
  }
}

TEST_CASE_TEMPLATE("Mask: from_bits is the inverse of bits, and masks combine", S, float, double) {
  test::Random random(2);
  const std::uint32_t all_bits = (1u << lanes<S>)-1u;
  for (int round = 0; round < 100; ++round) {
    const auto a = static_cast<std::uint32_t>(random.index(all_bits + 1u));
    const auto b = static_cast<std::uint32_t>(random.index(all_bits + 1u));
    const Mask<S> ma = Mask<S>::from_bits(a), mb = Mask<S>::from_bits(b);
    CHECK(bits(ma) == a);
    CHECK(bits(ma & mb) == (a & b));
    CHECK(bits(ma | mb) == (a | b));
    CHECK(bits(ma ^ mb) == (a ^ b));
    CHECK(bits(!ma) == (~a & all_bits));
    // Bits above the lanes do not count.
    CHECK(bits(Mask<S>::from_bits(a | ~all_bits)) == a);
  }
}

TEST_CASE_TEMPLATE("Value: sums over lanes, remainders, and single scalars", S, float, double) {
  S values[lanes<S>];
  S sum = S(0);
  for (std::size_t i = 0; i < lanes<S>; ++i) sum += values[i] = S(i) + S(0.5);
  const Pack<S> pack = Pack<S>::load(values);
  CHECK(sum_of_lanes(pack) == sum);  // Small halves: exact in any order.
  CHECK(sum_of_lanes(Pack3<S>{pack, -pack, pack * pack}).x() == sum);
  CHECK(sum_of_lanes(Pack3<S>{pack, -pack, pack * pack}).y() == -sum);
  CHECK(sum_of_lanes(sum) == sum);
  const Pack<S> rest = fmod(pack, Pack<S>(S(1.25)));
  for (std::size_t i = 0; i < lanes<S>; ++i) CHECK(rest[i] == std::fmod(values[i], S(1.25)));
  // Where a difference is the remainder, up to just below twice the divisor, and beyond it.
  for (const S largest : {S(2.4), S(2.5), S(7)}) {
    for (std::size_t i = 0; i < lanes<S>; ++i) {
      values[i] = i % 3 == 0 ? S(1.25) : S(0.1) + S(0.07) * S(i);
    }
    values[lanes<S> - 1] = largest;
    const Pack<S> wrapped = fmod(Pack<S>::load(values), Pack<S>(S(1.25)));
    for (std::size_t i = 0; i < lanes<S>; ++i) {
      CHECK(wrapped[i] == std::fmod(values[i], S(1.25)));
    }
  }
  CHECK(select(true, S(1), S(2)) == S(1));
  CHECK(select(false, Vec3<S>(1, 2, 3), zero_vector<S>()) == Vec3<S>::Zero());
  CHECK(broadcast<Pack<S>>(Vec3<S>(1, 2, 3))[0] == Vec3<S>(1, 2, 3));
  CHECK(any(true));
  CHECK_FALSE(all(false));
}
