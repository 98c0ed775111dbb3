/// @file
/// The hook through which a host lends its worker threads.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>

namespace bristle {

/// Runs task(i) once for every i in [0, count), in any order and on any threads, and returns when
/// all are done. Tasks never write to the same place, so results do not depend on the schedule.
using ParallelFor =
    std::function<void(std::size_t count, const std::function<void(std::size_t)>& task)>;

/// The default: one after the other on the calling thread.
inline void serial_for(std::size_t count, const std::function<void(std::size_t)>& task) {
  for (std::size_t i = 0; i < count; ++i) task(i);
}

}  // namespace bristle
