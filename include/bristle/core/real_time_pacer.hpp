/// @file
/// Paces a fixed-step loop by the wall clock. Reports how well it keeps up.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <thread>

namespace bristle::inline BRISTLE_ABI {

/// Paces a loop of equal steps:
///
///     RealTimePacer pacer(1e-3);
///     while (running) {
///       world.step();
///       pacer.wait();
///     }
///
/// Step k is due k steps after the first `wait`. An early loop sleeps. It spins for the last bit,
/// since systems wake sleepers late. A late loop goes on at once and so catches up. A loop more
/// than `longest_debt` behind is forgiven its delay. The simulation then stays behind the clock.
/// The `real_time_factor` shows it.
///
/// Pacing does not affect the steps. They compute the same bits with and without it.
///
/// @tparam Clock  A steady clock like those of the standard library. Its own `sleep_until` is used
///                if it has one (tests do).
template <typename Clock = std::chrono::steady_clock>
class RealTimePacer {
 public:
  /// Time between two instants of the clock.
  using Duration = typename Clock::duration;
  /// Instant of the clock.
  using TimePoint = typename Clock::time_point;

  /// @param step          [s] Simulated time of one step. > 0, at most a million.
  /// @param longest_debt  [s] Longest delay that is caught up. >= 0, at most a million.
  /// @param spin          [s] Time at the end of each wait without sleep. >= 0, at most a million.
  /// @throws InvalidArgument naming the argument.
  explicit RealTimePacer(double step, double longest_debt = 0.1, double spin = 200e-6)
      : step_(step), longest_debt_(longest_debt), spin_(spin) {
    detail::require_positive("RealTimePacer: step", step);
    detail::require_not_negative("RealTimePacer: longest_debt", longest_debt);
    detail::require_not_negative("RealTimePacer: spin", spin);
    // A clock of nanoseconds in 64 bits counts 9e9 s.
    constexpr double most = 1e6;
    constexpr const char* rule = "must be at most a million seconds";
    detail::require(step <= most, "RealTimePacer: step", step, rule);
    detail::require(longest_debt <= most, "RealTimePacer: longest_debt", longest_debt, rule);
    detail::require(spin <= most, "RealTimePacer: spin", spin, rule);
  }

  /// Returns when the next step is due; call it once a step. The first call starts the clock.
  void wait() {
    const TimePoint now = Clock::now();
    if (steps_ == 0) {
      origin_ = start_ = now;
      steps_ = 1;
      return;
    }
    const double due = static_cast<double>(steps_ - forgiven_from_) * step_;
    const double lateness = seconds(now - origin_) - due;
    ++steps_;
    if (lateness <= 0) {
      sleep_until(origin_ + duration(due));
      return;
    }
    ++late_steps_;
    worst_lateness_ = std::max(worst_lateness_, lateness);
    if (lateness > longest_debt_) {
      // Steps count from now.
      forgiven_ += lateness;
      origin_ = now;
      forgiven_from_ = steps_ - 1;
    }
  }

  /// Simulated time over real time since the first `wait`. It is 1 for a loop that keeps up, and
  /// before the second `wait`.
  [[nodiscard]] double real_time_factor() const {
    if (steps_ < 2) return 1;
    const double real = seconds(Clock::now() - start_);
    return real > 0 ? static_cast<double>(steps_ - 1) * step_ / real : 1;
  }
  /// [-] Steps that were due before their `wait` was called.
  [[nodiscard]] std::uint64_t late_steps() const { return late_steps_; }
  /// [s] Largest delay of a step.
  [[nodiscard]] double worst_lateness() const { return worst_lateness_; }
  /// [s] Total delay that was not caught up.
  [[nodiscard]] double forgiven() const { return forgiven_; }

 private:
  static double seconds(Duration d) { return std::chrono::duration<double>(d).count(); }
  static Duration duration(double s) {
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s));
  }

  void sleep_until(TimePoint due) const {
    const TimePoint wake = due - duration(spin_);
    if constexpr (requires { Clock::sleep_until(wake); }) {
      Clock::sleep_until(wake);
    } else {
      std::this_thread::sleep_until(wake);
    }
    while (Clock::now() < due) {
    }
  }

  double step_, longest_debt_, spin_;
  TimePoint start_{}, origin_{};
  std::uint64_t steps_ = 0;
  std::uint64_t forgiven_from_ = 0;
  std::uint64_t late_steps_ = 0;
  double worst_lateness_ = 0;
  double forgiven_ = 0;
};

}  // namespace bristle::inline BRISTLE_ABI
