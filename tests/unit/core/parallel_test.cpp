// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/parallel.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

TEST_CASE("serial_for: runs every task once, in order") {
  std::vector<std::size_t> seen;
  bristle::serial_for(4, [&](std::size_t i) { seen.push_back(i); });
  CHECK(seen == std::vector<std::size_t>{0, 1, 2, 3});
  bristle::serial_for(0, [&](std::size_t) { FAIL("no task"); });
}

namespace {

/// A sum of floats, whose rounding tells in which order it was made.
struct FloatSum {
  float value = 0;
  FloatSum& operator+=(const FloatSum& more) {
    value += more.value;
    return *this;
  }
};

/// 1 + 1/2 + ... + 1/n in ranges of ten.
float harmonic(std::size_t n, std::size_t fewest_shared, const bristle::ParallelFor& hook) {
  return bristle::sum_in_ranges<FloatSum>(n, 10, fewest_shared, hook,
                                          [](std::size_t first, std::size_t end, FloatSum& sum) {
                                            for (std::size_t i = first; i < end; ++i) {
                                              sum.value += 1 / float(i + 1);
                                            }
                                          })
      .value;
}

}  // namespace

TEST_CASE("is_serial: knows the default and nothing else") {
  CHECK(bristle::is_serial(bristle::serial_for));
  CHECK_FALSE(
      bristle::is_serial([](std::size_t n, const auto& task) { bristle::serial_for(n, task); }));
}

TEST_CASE("sum_in_ranges: each range once, added in order, whoever does them") {
  std::size_t tasks = 0;
  // From the last to the first.
  const bristle::ParallelFor backwards = [&](std::size_t count, const auto& task) {
    tasks += count;
    for (std::size_t i = count; i-- > 0;) task(i);
  };
  for (const std::size_t n : {0u, 1u, 9u, 10u, 11u, 95u, 320u, 321u, 1000u}) {
    CAPTURE(n);
    float expected = 0;
    for (std::size_t first = 0; first < n; first += 10) {
      float range = 0;
      for (std::size_t i = first; i < std::min(n, first + 10); ++i) range += 1 / float(i + 1);
      expected += range;
    }
    CHECK(harmonic(n, 2, bristle::serial_for) == expected);
    tasks = 0;
    CHECK(harmonic(n, 2, backwards) == expected);
    CHECK(tasks == (n > 10 ? (n + 9) / 10 : 0));
  }
  tasks = 0;
  CHECK(harmonic(95, 11, backwards) == harmonic(95, 2, backwards));
  CHECK(tasks == 10);  // Only those of the second sum.
}
