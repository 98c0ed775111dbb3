// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/math/simd.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// Numbers for all lanes, among them what is easily forgotten.
template <Scalar S>
class LaneValues {
 public:
  static constexpr std::size_t n = lanes<S>;
  using Array = std::array<S, n>;

  LaneValues() {
    for (S& value : a) value = next();
    for (S& value : b) value = next();
    for (S& value : c) value = next();
  }

  Array a, b, c;

 private:
  S next() {
    const S special[] = {
        S(0), S(-0.0), infinity<S>, -infinity<S>, std::numeric_limits<S>::quiet_NaN(), S(1)};
    const std::size_t kind = random().index(12);
    return kind < 6 ? special[kind] : random().template uniform<S>(S(-3), S(3));
  }
  static test::Random& random() {
    static test::Random generator(7);
    return generator;
  }
};

/// The same number, or both none; zeros of either sign are told apart.
template <Scalar S>
bool same(S x, S y) {
  if (std::isnan(x) || std::isnan(y)) return std::isnan(x) && std::isnan(y);
  return x == y && std::signbit(x) == std::signbit(y);
}

/// How many lanes of `pack` differ from expected(i).
template <Scalar S, typename Expected>
int wrong_lanes(const Pack<S>& pack, Expected&& expected) {
  int wrong = 0;
  for (std::size_t i = 0; i < lanes<S>; ++i) wrong += same<S>(pack[i], expected(i)) ? 0 : 1;
  return wrong;
}

template <Scalar S, typename Expected>
int wrong_bits(const Mask<S>& mask, Expected&& expected) {
  int wrong = 0;
  for (std::size_t i = 0; i < lanes<S>; ++i) {
    wrong += (((bits(mask) >> i) & 1u) != 0) == expected(i) ? 0 : 1;
  }
  return wrong + (bits(mask) >> lanes<S> == 0 ? 0 : 1);
}

}  // namespace

TEST_CASE_TEMPLATE("Pack: fills one native register", S, float, double) {
  CHECK(lanes<S> <= 16);
  CHECK((lanes<S> & (lanes<S> - 1)) == 0);
  if (detail::has_register<S>) CHECK(sizeof(Pack<S>) == simd_bytes);
}

TEST_CASE_TEMPLATE("Pack: computes in every lane what scalars do", S, float, double) {
  for (int round = 0; round < 200; ++round) {
    const LaneValues<S> v;
    const auto& x = v.a;
    const auto& y = v.b;
    const auto a = Pack<S>::load(x.data());
    const auto b = Pack<S>::load(y.data());
    CHECK(wrong_lanes<S>(a, [&](std::size_t i) { return x[i]; }) == 0);
    CHECK(wrong_lanes<S>(a + b, [&](std::size_t i) { return x[i] + y[i]; }) == 0);
    CHECK(wrong_lanes<S>(a - b, [&](std::size_t i) { return x[i] - y[i]; }) == 0);
    CHECK(wrong_lanes<S>(a * b, [&](std::size_t i) { return x[i] * y[i]; }) == 0);
    CHECK(wrong_lanes<S>(a / b, [&](std::size_t i) { return x[i] / y[i]; }) == 0);
    CHECK(wrong_lanes<S>(-a, [&](std::size_t i) { return -x[i]; }) == 0);
    CHECK(wrong_lanes<S>(a * S(2), [&](std::size_t i) { return x[i] * S(2); }) == 0);
    CHECK(wrong_lanes<S>(min(a, b), [&](std::size_t i) { return x[i] < y[i] ? x[i] : y[i]; }) == 0);
    CHECK(wrong_lanes<S>(max(a, b), [&](std::size_t i) { return x[i] > y[i] ? x[i] : y[i]; }) == 0);
    CHECK(wrong_lanes<S>(abs(a), [&](std::size_t i) { return std::abs(x[i]); }) == 0);
    CHECK(wrong_lanes<S>(sqrt(a), [&](std::size_t i) { return std::sqrt(x[i]); }) == 0);
  }
  // Exact, so that it does not matter what the compiler fuses.
  Pack<S> a = Pack<S>::numbers();
  a += S(2);
  a *= S(6);
  a -= S(4);
  a /= S(2);
  CHECK(wrong_lanes<S>(a, [](std::size_t i) { return S(3 * i + 4); }) == 0);
}

TEST_CASE_TEMPLATE("Mask: compares in every lane as scalars do, NaN among them", S, float, double) {
  for (int round = 0; round < 200; ++round) {
    const LaneValues<S> v;
    const auto& x = v.a;
    const auto& y = v.b;
    const auto& z = v.c;
    const auto a = Pack<S>::load(x.data());
    const auto b = Pack<S>::load(y.data());
    const auto c = Pack<S>::load(z.data());
    CHECK(wrong_bits<S>(a < b, [&](std::size_t i) { return x[i] < y[i]; }) == 0);
    CHECK(wrong_bits<S>(a <= b, [&](std::size_t i) { return x[i] <= y[i]; }) == 0);
    CHECK(wrong_bits<S>(a > b, [&](std::size_t i) { return x[i] > y[i]; }) == 0);
    CHECK(wrong_bits<S>(a >= b, [&](std::size_t i) { return x[i] >= y[i]; }) == 0);
    CHECK(wrong_bits<S>(a == b, [&](std::size_t i) { return x[i] == y[i]; }) == 0);
    CHECK(wrong_bits<S>(a != b, [&](std::size_t i) { return x[i] != y[i]; }) == 0);
    CHECK(wrong_bits<S>((a < b) & (b < c),
                        [&](std::size_t i) { return x[i] < y[i] && y[i] < z[i]; }) == 0);
    CHECK(wrong_bits<S>((a < b) | (b < c),
                        [&](std::size_t i) { return x[i] < y[i] || y[i] < z[i]; }) == 0);
    CHECK(wrong_bits<S>(!(a < b), [&](std::size_t i) { return !(x[i] < y[i]); }) == 0);
    CHECK(wrong_lanes<S>(select(a < b, b, c),
                         [&](std::size_t i) { return x[i] < y[i] ? y[i] : z[i]; }) == 0);
    const std::uint32_t less = bits(a < b);
    CHECK(any(a < b) == (less != 0));
    CHECK(none(a < b) == (less == 0));
    CHECK(all(a < b) == (less == (1u << lanes<S>)-1u));
  }
  CHECK(all(Pack<S>(S(1)) == Pack<S>(S(1))));
}

TEST_CASE_TEMPLATE("Mask: names the first lanes", S, float, double) {
  for (std::size_t count = 0; count <= lanes<S>; ++count) {
    CHECK(wrong_bits<S>(Mask<S>::first(count), [&](std::size_t i) { return i < count; }) == 0);
  }
}

TEST_CASE_TEMPLATE("Pack: reads and writes at any address", S, float, double) {
  constexpr std::size_t n = lanes<S>;
  // Unaligned: one past an aligned address.
  alignas(64) std::array<S, n + 1> shifted;
  for (std::size_t i = 0; i <= n; ++i) shifted[i] = S(i);
  const auto a = Pack<S>::load(shifted.data() + 1);
  CHECK(wrong_lanes<S>(a, [&](std::size_t i) { return S(i + 1); }) == 0);
  (a * S(3)).store(shifted.data() + 1);
  for (std::size_t i = 0; i <= n; ++i) CHECK(shifted[i] == S(3 * i));
}

TEST_CASE_TEMPLATE("Pack: gathers by indices", S, float, double) {
  std::vector<S> table(100);
  for (std::size_t i = 0; i < table.size(); ++i) table[i] = S(i) * S(0.5);
  std::array<std::uint32_t, lanes<S>> at;
  for (std::size_t i = 0; i < at.size(); ++i)
    at[i] = static_cast<std::uint32_t>((37 * i + 99) % 100);
  CHECK(wrong_lanes<S>(Pack<S>::gather(table.data(), at.data()),
                       [&](std::size_t i) { return S(0.5) * S(at[i]); }) == 0);
  CHECK(wrong_lanes<S>(Pack<S>::numbers(), [](std::size_t i) { return S(i); }) == 0);
}

TEST_CASE_TEMPLATE("Pack: loads integers below 2^31, rounded as scalars are", S, float, double) {
  // One past an aligned address.
  alignas(64) std::array<std::uint32_t, lanes<S> + 1> x;
  for (std::uint32_t step : {1u, 12345u, 0x7000001u}) {
    for (std::uint32_t i = 0; i < x.size(); ++i) x[i] = 0x7fffffffu - i * step;
    CHECK(wrong_lanes<S>(Pack<S>::load_integers(x.data() + 1),
                         [&](std::size_t i) { return static_cast<S>(x[i + 1]); }) == 0);
  }
}

TEST_CASE_TEMPLATE("store_packed: chosen lanes side by side, in rows of their own", S, float,
                   double) {
  constexpr std::size_t n = lanes<S>;
  constexpr std::size_t stride = 2 * n + 1;
  test::Random random(9);
  const auto chance = [&] {
    std::array<S, n> values;
    for (S& value : values) value = random.uniform(S(0), S(1));
    return values;
  };
  const std::array<std::array<S, n>, 3> from = {chance(), chance(), chance()};
  for (int round = 0; round < 300; ++round) {
    const std::uint32_t chosen = round == 0 ? 0u
                                 : round == 1
                                     ? first_bits(n)
                                     : bits(Pack<S>::load(chance().data()) < Pack<S>(S(0.5)));
    // A whole pack may be written at the second of the rows' entries, and nothing else.
    std::array<S, 3 * stride> to;
    to.fill(S(-1));
    const std::size_t count =
        store_packed({Pack<S>::load(from[0].data()), Pack<S>::load(from[1].data()),
                      Pack<S>::load(from[2].data())},
                     chosen, to.data() + 1, stride);
    std::size_t wrong = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      const S* const out = to.data() + row * stride;
      std::size_t next = 1;
      for (std::size_t i = 0; i < n; ++i) {
        if ((chosen >> i & 1u) != 0) wrong += out[next++] == from[row][i] ? 0u : 1u;
      }
      CHECK(count == next - 1);
      wrong += out[0] == S(-1) ? 0u : 1u;
      for (std::size_t i = n + 1; i < stride; ++i) wrong += out[i] == S(-1) ? 0u : 1u;
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE_TEMPLATE("sum_of_lanes, min_of_lanes, max_of_lanes: join by halves", S, float, double) {
  test::Random random(3);
  for (int round = 0; round < 50; ++round) {
    std::array<S, lanes<S>> x;
    for (S& value : x) value = random.uniform(S(-1), S(1));
    const auto a = Pack<S>::load(x.data());
    CHECK(min_of_lanes(a) == *std::min_element(x.begin(), x.end()));
    CHECK(max_of_lanes(a) == *std::max_element(x.begin(), x.end()));
    // The very same additions.
    std::array<S, lanes<S>> halves = x;
    for (std::size_t half = x.size() / 2; half > 0; half /= 2) {
      for (std::size_t i = 0; i < half; ++i) halves[i] += halves[i + half];
    }
    CHECK(sum_of_lanes(a) == halves[0]);
  }
}
