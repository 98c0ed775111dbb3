/// @file
/// Processor time of this thread: what others do to the machine counts only through its caches.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <ctime>

namespace bristle::work_precision {

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

}  // namespace bristle::work_precision
