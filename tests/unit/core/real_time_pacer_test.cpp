// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/core/real_time_pacer.hpp>

#include <doctest/doctest.h>

#include <chrono>
#include <cmath>

using namespace bristle;

namespace {

/// A clock that moves only when it is told to, or when somebody sleeps or looks at it for long.
struct FakeClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<FakeClock>;
  [[maybe_unused]] static constexpr bool is_steady = true;

  static inline time_point present{};
  static inline double slept = 0;

  static time_point now() {
    present += duration(10);  // So that waiting by looking ends.
    return present;
  }
  static void sleep_until(time_point until) {
    if (until <= present) return;
    slept += std::chrono::duration<double>(until - present).count();
    present = until;
  }
  static void work(double seconds) {
    present += std::chrono::duration_cast<duration>(std::chrono::duration<double>(seconds));
  }
};

using Pacer = RealTimePacer<FakeClock>;

double seconds_now() {
  return std::chrono::duration<double>(FakeClock::present.time_since_epoch()).count();
}

}  // namespace

// All times are right to a microsecond: a look at the clock takes 10 ns, and a step looks a few
// times.
TEST_CASE("real-time pacer: quick steps take as long as they simulate") {
  Pacer pacer(1e-3, 0.1, 1e-5);
  FakeClock::slept = 0;
  pacer.wait();
  const double start = seconds_now();
  for (int i = 1; i <= 100; ++i) {
    FakeClock::work(0.4e-3);
    pacer.wait();
    CHECK(std::abs(seconds_now() - start - 1e-3 * i) < 1e-6);
  }
  CHECK(pacer.real_time_factor() == test::relative(1).epsilon(1e-4));
  CHECK(pacer.late_steps() == 0);
  CHECK(pacer.worst_lateness() == 0);
  CHECK(pacer.forgiven() == 0);
  // It slept for what was left but the spin.
  CHECK(FakeClock::slept == test::relative(100 * (0.6e-3 - 1e-5)).epsilon(1e-3));
}

TEST_CASE("real-time pacer: one slow step is made up for") {
  Pacer pacer(1e-3, 0.1, 0);
  pacer.wait();
  const double start = seconds_now();
  for (int i = 1; i <= 50; ++i) {
    FakeClock::work(i == 10 ? 5.4e-3 : 0.1e-3);
    pacer.wait();
  }
  CHECK(std::abs(seconds_now() - start - 0.05) < 1e-6);
  // Steps 10 to 14 were due while the slow one ran; each of those after it takes 0.1 ms to catch
  // up.
  CHECK(pacer.late_steps() == 5);
  CHECK(pacer.worst_lateness() == test::relative(4.4e-3).epsilon(1e-3));
  CHECK(pacer.forgiven() == 0);
}

TEST_CASE("real-time pacer: debt beyond the longest is forgiven, and the factor says so") {
  Pacer pacer(1e-3, 0.01, 0);
  pacer.wait();
  const double start = seconds_now();
  for (int i = 1; i <= 100; ++i) {
    FakeClock::work(i == 10 ? 0.101 : 0.1e-3);
    pacer.wait();
  }
  // 9 steps, one of 101 ms, 90 more from then on.
  CHECK(seconds_now() - start == test::relative(0.009 + 0.101 + 0.090).epsilon(1e-4));
  CHECK(pacer.forgiven() == test::relative(0.1).epsilon(1e-3));
  CHECK(pacer.real_time_factor() == test::relative(0.5).epsilon(1e-3));
}

TEST_CASE("real-time pacer: steps that are always too slow run at their own pace") {
  Pacer pacer(1e-3, 0.01, 0);
  pacer.wait();
  for (int i = 0; i < 200; ++i) {
    FakeClock::work(2e-3);
    pacer.wait();
  }
  CHECK(pacer.real_time_factor() == test::relative(0.5).epsilon(1e-3));
  CHECK(pacer.late_steps() == 200);
}

TEST_CASE("real-time pacer: the delay within which a part of the steps began") {
  Pacer pacer(1e-3, 10, 0);
  CHECK(pacer.start_delay(0.5) == 0);
  pacer.wait();
  CHECK(pacer.start_delay(1) == 0);
  // One step in ten is late by 0.2 ms, one in a hundred by 5.4 ms with five behind it that catch
  // up.
  for (int i = 1; i <= 1000; ++i) {
    FakeClock::work(i % 100 == 0 ? 6.4e-3 : i % 10 == 5 ? 1.2e-3 : 0.1e-3);
    pacer.wait();
  }
  CHECK(pacer.start_delay(0.5) < 1e-6);
  const double tenth = pacer.start_delay(0.92);
  CHECK(tenth > 0.2e-3);
  CHECK(tenth < 0.2e-3 * 1.12);
  CHECK(pacer.start_delay(1) == pacer.worst_lateness());
  CHECK(pacer.start_delay(1) == test::relative(5.4e-3).epsilon(1e-3));
  for (int tenths = 1; tenths < 10; ++tenths) {
    CHECK(pacer.start_delay(tenths / 10.0) <= pacer.start_delay((tenths + 1) / 10.0));
  }
  for (const double part : {0.0, -1.0, 1.5, std::nan("")}) {
    CHECK_THROWS_WITH_AS((void)pacer.start_delay(part), doctest::Contains("part"), InvalidArgument);
  }
}

TEST_CASE("real-time pacer: a sleeper that the system wakes late began late, and is not late") {
  struct Sleepy : FakeClock {
    static void sleep_until(time_point until) {
      FakeClock::sleep_until(until);
      work(30e-6);
    }
  };
  RealTimePacer<Sleepy> pacer(1e-3, 10, 0);
  for (int i = 0; i <= 100; ++i) {
    FakeClock::work(0.1e-3);
    pacer.wait();
  }
  CHECK(pacer.late_steps() == 0);
  CHECK(pacer.start_delay(0.01) == test::relative(30e-6).epsilon(1e-2));
  CHECK(pacer.start_delay(1) == test::relative(30e-6).epsilon(1e-2));
}

TEST_CASE("real-time pacer: the clock on the wall") {
  RealTimePacer pacer(1e-3);
  CHECK(pacer.real_time_factor() == 1);
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i <= 20; ++i) pacer.wait();
  // Never early, however busy the machine is.
  CHECK(std::chrono::steady_clock::now() - start >= std::chrono::milliseconds(20));
}

TEST_CASE("real-time pacer: refuses steps that are none") {
  CHECK_THROWS_AS(Pacer(0), InvalidArgument);
  CHECK_THROWS_AS(Pacer(std::nan("")), InvalidArgument);
  CHECK_THROWS_AS(Pacer(1e-3, -1), InvalidArgument);
  CHECK_THROWS_AS(Pacer(1e-3, 1, -1), InvalidArgument);
}

TEST_CASE("RealTimePacer: times that its clock cannot count are refused") {
  CHECK_THROWS_WITH_AS(RealTimePacer<>(1e10), doctest::Contains("RealTimePacer: step"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(RealTimePacer<>(1, 0, 1e10), doctest::Contains("RealTimePacer: spin"),
                       InvalidArgument);
}
