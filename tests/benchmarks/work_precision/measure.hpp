/// @file
/// Runs one engine on one scene: error, time, counters, allocations.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "benchmarks/work_precision/engines.hpp"
#include "benchmarks/work_precision/row.hpp"

namespace bristle::work_precision {

using namespace bristle::detail;

/// One cell of the benchmark.
struct Task {
  const scenes::Recipe* recipe = nullptr;
  const EngineFamily* family = nullptr;
  std::string setting;
  /// [s] Step.
  double dt = 0;
  /// [-] True for one timed run and two variations only.
  bool is_quick = false;
};

/// @throws scenes::Unsupported
[[nodiscard]] Row measure(const Task& task);

/// The row of a task that crashed.
[[nodiscard]] Row crashed(const Task& task);

}  // namespace bristle::work_precision
