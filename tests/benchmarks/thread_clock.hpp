/// @file
/// Processor time of this thread: what others do to the machine counts only through its caches.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <ctime>

namespace bristle::benchmarks {

/// [s] Processor time this thread has used.
[[nodiscard]] inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// [s] What asking costs, which the time of a single step contains once.
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

}  // namespace bristle::benchmarks
