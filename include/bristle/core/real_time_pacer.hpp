/// @file
/// Keeps a fixed-step loop in step with the clock on the wall, and says how well that goes.
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
/// Step k is due k steps after the first `wait`. A loop that is early sleeps, and spins for the
/// last bit, since systems wake sleepers late; one that is late goes on at once and so catches up,
/// unless it is more than `longest_debt` behind: then the rest is forgiven, the simulation stays
/// behind the wall, and `real_time_factor` says so.
///
/// The steps themselves do not depend on it: a paced run computes the bits of one that is not.
///
/// @tparam Clock  A steady clock of the standard library's shape; `sleep_until` of its own if it
/// has
///                one (tests do).
template <typename Clock = std::chrono::steady_clock>
class RealTimePacer {
 public:
  using Duration = typename Clock::duration;
  using TimePoint = typename Clock::time_point;

  /// @param step          [s] Simulated time of one step. Finite, > 0.
  /// @param longest_debt  [s] Lateness that is made up for. Finite, >= 0.
  /// @param spin          [s] Waited for without sleeping, at the end of each wait. Finite, >= 0.
  /// @throws InvalidArgument naming the argument.
  explicit RealTimePacer(double step, double longest_debt = 0.1, double spin = 200e-6)
      : step_(step), longest_debt_(longest_debt), spin_(spin) {
    detail::require_positive("RealTimePacer: step", step);
    detail::require_not_negative("RealTimePacer: longest_debt", longest_debt);
    detail::require_not_negative("RealTimePacer: spin", spin);
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
      // From here on steps count from now.
      forgiven_ += lateness;
      origin_ = now;
      forgiven_from_ = steps_ - 1;
    }
  }

  /// Simulated time over real time since the first `wait`; 1 for a loop that keeps up, and before
  /// the second one.
  [[nodiscard]] double real_time_factor() const {
    if (steps_ < 2) return 1;
    const double real = seconds(Clock::now() - start_);
    return real > 0 ? static_cast<double>(steps_ - 1) * step_ / real : 1;
  }
  /// [-] Steps that were due before their `wait` was called.
  [[nodiscard]] std::uint64_t late_steps() const { return late_steps_; }
  /// [s] By how much the latest of them was late.
  [[nodiscard]] double worst_lateness() const { return worst_lateness_; }
  /// [s] Lateness that was not made up for.
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
