/// @file
/// Processor time of this thread: what others do to the machine counts only through its caches.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <ctime>
#include <type_traits>
#include <vector>

namespace bristle::benchmarks {

/// [s] Processor time this thread has used.
[[nodiscard]] inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// [s] Cost of a clock query, which the time of a single step contains once.
[[nodiscard]] inline double clock_cost() {
  double least = 1;
  for (int i = 0; i < 1000; ++i) {
    const double start = thread_seconds();
    least = std::min(least, thread_seconds() - start);
  }
  return least;
}

/// [ns] Median time of a call in eleven runs of about 10 ms each.
template <typename Call>
[[nodiscard]] double median_nanoseconds(Call&& call) {
  const auto run = [&](int repeats) {
    const double start = thread_seconds();
    for (int i = 0; i < repeats; ++i) call();
    return 1e9 * (thread_seconds() - start);
  };
  run(1);
  const int repeats = std::max(1, static_cast<int>(1e7 / std::max(run(3) / 3, 1.0)));
  std::array<double, 11> times{};
  for (double& time : times) time = run(repeats) / repeats;
  std::nth_element(times.begin(), times.begin() + 5, times.end());
  return times[5];
}

/// [ns] Time of a step of a motion that is run seven times: the mean over the motion of each step's
/// median. Steps that are short beside the clock are timed in groups of neighbours.
/// @param prepare  Callable prepare(k), done before step k and not counted: then no steps are
///                 grouped. Or `nullptr`.
template <typename Prepare, typename Step>
[[nodiscard]] double median_step_nanoseconds(int steps, const Prepare& prepare, const Step& step) {
  constexpr bool is_prepared = !std::is_same_v<Prepare, std::nullptr_t>;
  const auto seconds_of = [&](int first, int end) {
    if constexpr (is_prepared) prepare(first);
    const double start = thread_seconds();
    for (int k = first; k < end; ++k) step(k);
    return thread_seconds() - start;
  };
  int group = 1;
  if constexpr (!is_prepared) {
    const double all = seconds_of(0, steps);
    group = std::clamp(static_cast<int>(50e-6 * steps / all), 1, steps);
  }
  std::vector<std::array<double, 7>> times(static_cast<std::size_t>((steps + group - 1) / group));
  for (std::size_t run = 0; run < 7; ++run) {
    for (int first = 0; first < steps; first += group) {
      times[static_cast<std::size_t>(first / group)][run] =
          seconds_of(first, std::min(steps, first + group));
    }
  }
  double sum = -clock_cost() * static_cast<double>(times.size());
  for (std::array<double, 7>& of_group : times) {
    std::nth_element(of_group.begin(), of_group.begin() + 3, of_group.end());
    sum += of_group[3];
  }
  return 1e9 * sum / steps;
}

}  // namespace bristle::benchmarks
