/// @file
/// One line of the benchmark's CSV: an engine in one setting on one scene at one step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/rigid/trial.hpp"

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace bristle::work_precision {

using namespace bristle::detail;

/// Measurements of one run. The defaults stand for a run that ended in a crash.
struct Row {
  std::string scene;
  std::string engine;
  std::string setting;
  /// [s] Step.
  double dt = 0;
  /// [-] Steps of a run.
  long steps = 0;
  /// [*] In the unit of the scene; infinite when there is no finite result.
  double error = std::numeric_limits<double>::infinity();
  bool passes = false;
  /// [us] Processor time of a step: mean of a run, best and median of the runs; and the slowest
  /// step of a run.
  double best_us = std::numeric_limits<double>::quiet_NaN();
  double median_us = std::numeric_limits<double>::quiet_NaN();
  double worst_us = std::numeric_limits<double>::quiet_NaN();
  /// [us] 99th percentile of the steps of a run.
  double p99_us = std::numeric_limits<double>::quiet_NaN();
  /// [-] A step, as far as the engine tells.
  double sweeps = 0;
  double factorisations = 0;
  /// [-] A step, in the second half of the run.
  double allocations = std::numeric_limits<double>::quiet_NaN();
  std::vector<scenes::Metric> further{};

  /// Engine and setting, "ode/step".
  [[nodiscard]] std::string who() const { return engine + '/' + setting; }
};

/// First line of the file.
[[nodiscard]] std::string csv_header();
/// A row as a line of the file.
[[nodiscard]] std::string csv_line(const Row& row);
/// A line of the file as a row.
/// @throws InvalidArgument when it is none.
[[nodiscard]] Row parse_row(std::string_view line);

/// [s] "1/240" or "0.01" as a number; 0 if it is none.
[[nodiscard]] double parse_time_step(const std::string& text);
/// "1/240" where that is what a step is, else the number.
[[nodiscard]] std::string time_step_text(double dt);

}  // namespace bristle::work_precision
