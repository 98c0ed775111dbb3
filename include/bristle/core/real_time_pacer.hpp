/// @file
/// Paces a fixed-step loop by the wall clock. Reports how well it keeps up.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
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
      const TimePoint at = origin_ + duration(due);
      count_delay(seconds(sleep_until(at) - at));
      return;
    }
    count_delay(lateness);
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
  /// [s] Largest delay of a step that was late.
  [[nodiscard]] double worst_lateness() const { return worst_lateness_; }
  /// [s] Delay within which a part of all steps began, say 0.99 of them: late steps, and those that
  /// the system woke late. Rounded up by at most a ninth. 0 before the second `wait`.
  /// @param part  [1] In (0, 1]. 1 is the largest delay.
  /// @throws InvalidArgument when it is not.
  [[nodiscard]] double start_delay(double part) const {
    detail::require(part > 0 && part <= 1, "RealTimePacer: part", part, "must be in (0, 1]");
    const double wanted = part * static_cast<double>(steps_ == 0 ? 0 : steps_ - 1);
    double counted = 0;
    for (std::size_t i = 0; i < delays_.size(); ++i) {
      counted += static_cast<double>(delays_[i]);
      if (counted >= wanted && counted > 0) {
        return std::min(worst_delay_, shortest_delay * std::exp2(static_cast<double>(i) / octave));
      }
    }
    return 0;
  }
  /// [s] Total delay that was not caught up.
  [[nodiscard]] double forgiven() const { return forgiven_; }

 private:
  static double seconds(Duration d) { return std::chrono::duration<double>(d).count(); }
  static Duration duration(double s) {
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(s));
  }

  /// [s] Upper end of the first bin of delays, and [-] bins in which a delay doubles.
  static constexpr double shortest_delay = 1e-9;
  static constexpr double octave = 8;

  void count_delay(double delay) {
    worst_delay_ = std::max(worst_delay_, delay);
    const double bin = delay > shortest_delay ? octave * std::log2(delay / shortest_delay) : 0;
    const double last = static_cast<double>(delays_.size() - 1);
    ++delays_[static_cast<std::size_t>(std::min(std::ceil(bin), last))];
  }

  /// @return When the waiting ended.
  TimePoint sleep_until(TimePoint due) const {
    const TimePoint wake = due - duration(spin_);
    if constexpr (requires { Clock::sleep_until(wake); }) {
      Clock::sleep_until(wake);
    } else {
      std::this_thread::sleep_until(wake);
    }
    TimePoint now = Clock::now();
    while (now < due) now = Clock::now();
    return now;
  }

  double step_, longest_debt_, spin_;
  TimePoint start_{}, origin_{};
  std::uint64_t steps_ = 0;
  std::uint64_t forgiven_from_ = 0;
  std::uint64_t late_steps_ = 0;
  double worst_lateness_ = 0;
  double forgiven_ = 0;
  double worst_delay_ = 0;
  /// [-] Steps by the delay of their start. The last bin ends at a million seconds.
  std::array<std::uint64_t, 400> delays_{};
};

}  // namespace bristle::inline BRISTLE_ABI
