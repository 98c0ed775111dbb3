// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/measure.hpp"

#include "benchmarks/thread_clock.hpp"
#include "benchmarks/work_precision/allocations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace bristle::work_precision {

using namespace bristle::detail;

using scenes::Engine;
using scenes::Instant;
using scenes::Trial;

namespace {

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// [s] 99th percentile of the values.
double percentile99(std::vector<double> values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 99 / 100);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Runs of one trial.
class Runner {
 public:
  Runner(const Task& task, Trial& trial)
      : task_(task),
        trial_(trial),
        steps_(std::lround(trial.scene().duration / task.dt)),
        clock_cost_(benchmarks::clock_cost()) {}

  [[nodiscard]] long steps() const { return steps_; }

  /// The run that the metrics are taken of; fills in counters and allocations.
  /// @return [s] Time of each step.
  std::vector<double> observed_run(Row& row) {
    const std::unique_ptr<Engine> engine = make();
    std::vector<double> times(static_cast<std::size_t>(steps_));
    scenes::StepCounters total;
    long allocated = 0;
    trial_.observe(*engine, at(0));
    for (long i = 0; i < steps_; ++i) {
      trial_.prepare(*engine, at(i));
      const long before = allocations().value_or(0);
      times[static_cast<std::size_t>(i)] = timed_step(*engine);
      if (i >= steps_ / 2) allocated += allocations().value_or(0) - before;
      const scenes::StepCounters counters = engine->counters();
      total.sweeps += counters.sweeps;
      total.factorisations += counters.factorisations;
      trial_.observe(*engine, at(i + 1));
    }
    const double count = static_cast<double>(steps_);
    row.sweeps += static_cast<double>(total.sweeps) / count;
    row.factorisations += static_cast<double>(total.factorisations) / count;
    if (allocations()) {
      row.allocations += static_cast<double>(allocated) / static_cast<double>(steps_ - steps_ / 2);
    } else {
      row.allocations = std::numeric_limits<double>::quiet_NaN();
    }
    return times;
  }

  /// Lowers the time of each step to what it takes in one more run: what is left of a slow step in
  /// both is its own, not an interrupt's.
  void refine(std::vector<double>& times) {
    const std::unique_ptr<Engine> engine = make();
    for (long i = 0; i < steps_; ++i) {
      trial_.prepare(*engine, at(i));
      double& time = times[static_cast<std::size_t>(i)];
      time = std::min(time, timed_step(*engine));
    }
  }

  /// [s] Mean time of a step in a run in which nothing else happens.
  double plain_run() {
    const std::unique_ptr<Engine> engine = make();
    const double start = benchmarks::thread_seconds();
    for (long i = 0; i < steps_; ++i) {
      trial_.prepare(*engine, at(i));
      engine->step();
    }
    return (benchmarks::thread_seconds() - start) / static_cast<double>(steps_);
  }

 private:
  [[nodiscard]] std::unique_ptr<Engine> make() const {
    return task_.family->make(trial_.scene(), task_.dt, task_.setting);
  }
  [[nodiscard]] Instant at(long step) const {
    return {static_cast<double>(step) * task_.dt, task_.dt, step};
  }
  double timed_step(Engine& engine) const {
    const double start = benchmarks::thread_seconds();
    engine.step();
    return std::max(benchmarks::thread_seconds() - start - clock_cost_, 0.0);
  }

  const Task& task_;
  Trial& trial_;
  long steps_;
  double clock_cost_;
};

Row titled(const Task& task) {
  Row row;
  row.scene = task.recipe->name;
  row.engine = task.family->name;
  row.setting = task.setting;
  row.dt = task.dt;
  return row;
}

void set_outcome(Row& row, const scenes::Outcome& outcome) {
  row.error =
      std::isfinite(outcome.error) ? outcome.error : std::numeric_limits<double>::infinity();
  row.passes = outcome.passes && std::isfinite(outcome.error);
  row.further = outcome.further;
}

/// Has a trial compare itself with a run of the same engine in fine steps.
void compare_with_reference(const Task& task, Trial& trial) {
  Task fine = task;
  fine.dt = task.recipe->reference_step;
  const std::unique_ptr<Trial> reference = task.recipe->make(0);
  Row unused;
  Runner(fine, *reference).observed_run(unused);
  trial.compare(*reference);
}

/// A scene of one trial: the metrics of one run, the times of further ones.
Row measure_one(const Task& task) {
  Row row = titled(task);
  row.allocations = 0;
  const std::unique_ptr<Trial> trial = task.recipe->make(0);
  Runner runner(task, *trial);
  std::vector<double> times = runner.observed_run(row);
  if (task.recipe->reference_step > 0) compare_with_reference(task, *trial);
  set_outcome(row, trial->outcome());
  row.steps = runner.steps();

  std::vector<double> runs;
  if (trial->scene().is_large) {
    runs.push_back(mean(times));
  } else {
    if (!task.is_quick) runner.refine(times);
    // Three to five runs, fewer where they are long.
    const double seconds_a_run = mean(times) * static_cast<double>(runner.steps());
    const std::size_t most = task.is_quick         ? 1
                             : seconds_a_run > 1   ? 2
                             : seconds_a_run > 0.1 ? 3
                                                   : 5;
    while (runs.size() < most) runs.push_back(runner.plain_run());
  }
  row.best_us = 1e6 * *std::min_element(runs.begin(), runs.end());
  row.median_us = 1e6 * median(runs);
  row.p99_us = 1e6 * percentile99(times);
  row.worst_us = 1e6 * *std::max_element(times.begin(), times.end());
  return row;
}

/// A scene of several trials: the largest error and the slowest step of all, the mean of the rest.
Row measure_variations(const Task& task) {
  Row row = titled(task);
  row.allocations = 0;
  const int count = task.is_quick ? std::min(2, task.recipe->variations) : task.recipe->variations;
  std::vector<double> errors;
  std::vector<double> runs;
  int failures = 0;
  scenes::Outcome worst;
  double slowest = 0;
  double slow = 0;
  for (int i = 0; i < count; ++i) {
    const std::unique_ptr<Trial> trial = task.recipe->make(i);
    Runner runner(task, *trial);
    const std::vector<double> times = runner.observed_run(row);
    runs.push_back(mean(times));
    slowest = std::max(slowest, *std::max_element(times.begin(), times.end()));
    slow = std::max(slow, percentile99(times));
    row.steps = runner.steps();

    scenes::Outcome outcome = trial->outcome();
    if (!std::isfinite(outcome.error)) outcome.error = std::numeric_limits<double>::infinity();
    errors.push_back(outcome.error);
    if (!outcome.passes) ++failures;
    if (i == 0 || outcome.error > worst.error) worst = outcome;
  }
  set_outcome(row, worst);
  row.passes = failures == 0;
  row.further.insert(row.further.begin(), {{"median_error", median(errors)},
                                           {"mean_error", mean(errors)},
                                           {"failures", static_cast<double>(failures)},
                                           {"runs", static_cast<double>(count)}});
  row.sweeps /= count;
  row.factorisations /= count;
  row.allocations /= count;
  row.best_us = row.median_us = 1e6 * mean(runs);
  row.p99_us = 1e6 * slow;
  row.worst_us = 1e6 * slowest;
  return row;
}

}  // namespace

Row measure(const Task& task) {
  return task.recipe->variations > 1 ? measure_variations(task) : measure_one(task);
}

Row crashed(const Task& task) {
  Row row = titled(task);
  row.further.push_back({"crashed", 1});
  return row;
}

}  // namespace bristle::work_precision
