// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/sensors/taxel_flaws.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

std::vector<double> read(TaxelFlaws<double>& flaws, const std::vector<double>& in) {
  std::vector<double> out(in.size());
  flaws.apply(in, out);
  return out;
}

}  // namespace

TEST_CASE("taxel flaws: none by default") {
  TaxelFlaws<double> flaws(3, {});
  const std::vector<double> in{0.0, -1.5, 2.25};
  CHECK(read(flaws, in) == in);
}

// Prandtl's play of half width r, by hand: up from 0 to 3 it reads 3 - r; down to 2 it stays; down
// to 1 it reads 1 + r; back to 0 it reads r.
TEST_CASE("taxel flaws: hysteresis is a play") {
  TaxelFlaws<double> flaws(1, {.hysteresis = 0.75});
  const double in[] = {0.5, 1, 3, 2, 1, 0, 3};
  const double expected[] = {0, 0.25, 2.25, 2.25, 1.75, 0.75, 2.25};
  for (std::size_t k = 0; k < 7; ++k) {
    CAPTURE(k);
    CHECK(read(flaws, {in[k]})[0] == expected[k]);
  }
  flaws.reset();
  CHECK(read(flaws, {0.5})[0] == 0);
}

// Moments of n samples are off by about sigma / sqrt(n) (mean) and sigma / sqrt(2 n) (deviation);
// five of these for n = 40000.
TEST_CASE("taxel flaws: noise and gains have the deviation that was asked for") {
  constexpr std::size_t n = 40000;
  const auto check = [](const std::vector<double>& x, double mean, double deviation) {
    double sum = 0, squares = 0;
    for (const double v : x) sum += v;
    for (const double v : x) squares += (v - sum / n) * (v - sum / n);
    CHECK(std::abs(sum / n - mean) < 5 * deviation / std::sqrt(n));
    CHECK(std::abs(std::sqrt(squares / n) - deviation) < 5 * deviation / std::sqrt(2.0 * n));
  };
  TaxelFlaws<double> noisy(n, {.noise = 0.3});
  check(read(noisy, std::vector<double>(n, 5.0)), 5, 0.3);
  TaxelFlaws<double> spread(n, {.gain_spread = 0.1});
  check(read(spread, std::vector<double>(n, 2.0)), 2, 0.2);
  // Over time, too, and independent of the sample before.
  TaxelFlaws<double> single(1, {.noise = 0.3});
  std::vector<double> series, products;
  for (std::size_t k = 0; k < n; ++k) series.push_back(read(single, {0.0})[0]);
  check(series, 0, 0.3);
  double correlation = 0;
  for (std::size_t k = 1; k < n; ++k) correlation += series[k] * series[k - 1];
  CHECK(std::abs(correlation / n) < 5 * 0.3 * 0.3 / std::sqrt(n));
}

// The number of dead ones is binomial: within five deviations.
TEST_CASE("taxel flaws: dead taxels read nothing, not even noise") {
  constexpr std::size_t n = 10000;
  TaxelFlaws<double> flaws(n, {.dead_share = 0.05, .noise = 0.1});
  const std::vector<double> out = read(flaws, std::vector<double>(n, 1.0));
  std::size_t dead = 0;
  for (std::size_t i = 0; i < n; ++i) {
    CHECK((out[i] == 0) == (flaws.gain(i) == 0));
    if (out[i] == 0) ++dead;
  }
  CHECK(std::abs(static_cast<double>(dead) - 500) < 5 * std::sqrt(500 * 0.95));
  TaxelFlaws<double> all(10, {.dead_share = 1});
  CHECK(read(all, std::vector<double>(10, 1.0)) == std::vector<double>(10, 0.0));
}

TEST_CASE("taxel flaws: the seed says it all") {
  const TaxelFlawsDef<double> def{.gain_spread = 0.1, .dead_share = 0.1, .noise = 0.1, .seed = 7};
  TaxelFlaws<double> a(50, def), b(50, def);
  TaxelFlawsDef<double> other = def;
  other.seed = 8;
  TaxelFlaws<double> c(50, other);
  const std::vector<double> in(50, 1.0);
  const auto first = read(a, in);
  CHECK(first == read(b, in));
  CHECK(first != read(c, in));
  CHECK(first != read(a, in));  // The next sample is another one.
  a.reset();
  CHECK(first == read(a, in));
}

// The mean product of independent noise of deviation s is about s^2 / sqrt(n): within five of
// these.
TEST_CASE("taxel flaws: channels share the dead, and neither gains nor noise") {
  constexpr std::size_t n = 40000;
  const auto make = [](std::uint64_t channel, double gain_spread) {
    return TaxelFlaws<double>(n, {.gain_spread = gain_spread,
                                  .dead_share = 0.1,
                                  .noise = 0.3,
                                  .seed = 7,
                                  .channel = channel});
  };
  TaxelFlaws<double> depth = make(0, 0), force = make(1, 0);
  const auto noise_of_depth = read(depth, std::vector<double>(n, 0.0));
  const auto noise_of_force = read(force, std::vector<double>(n, 0.0));
  double correlation = 0;
  std::size_t dead = 0;
  for (std::size_t i = 0; i < n; ++i) {
    CHECK((depth.gain(i) == 0) == (force.gain(i) == 0));
    dead += depth.gain(i) == 0 ? 1u : 0u;
    correlation += noise_of_depth[i] * noise_of_force[i];
  }
  CHECK(dead > n / 20);
  CHECK(std::abs(correlation / n) < 5 * 0.3 * 0.3 / std::sqrt(n));
  const TaxelFlaws<double> spread = make(0, 0.1), other = make(1, 0.1);
  double together = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (spread.gain(i) != 0) together += (spread.gain(i) - 1) * (other.gain(i) - 1);
  }
  CHECK(std::abs(together / n) < 5 * 0.1 * 0.1 / std::sqrt(n));
}

TEST_CASE("taxel flaws: refuses nonsense") {
  using Def = TaxelFlawsDef<double>;
  CHECK_THROWS_AS(TaxelFlaws<double>(0, Def{}), InvalidArgument);
  CHECK_THROWS_AS(TaxelFlaws<double>(1, Def{.gain_spread = -1}), InvalidArgument);
  CHECK_THROWS_AS(TaxelFlaws<double>(1, Def{.dead_share = 1.5}), InvalidArgument);
  CHECK_THROWS_AS(TaxelFlaws<double>(1, Def{.hysteresis = -1}), InvalidArgument);
  CHECK_THROWS_AS(TaxelFlaws<double>(1, Def{.noise = std::nan("")}), InvalidArgument);
  TaxelFlaws<double> flaws(2, Def{});
  std::vector<double> two(2), three(3);
  CHECK_THROWS_AS(flaws.apply(three, two), InvalidArgument);
  CHECK_THROWS_AS(flaws.apply(two, three), InvalidArgument);
}
