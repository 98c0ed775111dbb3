// Rows of boxes of 0.1 to 10 kg that a plate pushes, as in the scene `moving/push24` of the
// work-precision benchmark but longer: how overlaps and cost grow with the heap. Where light boxes
// are pinched is chance, so each row has several starts with other masses and places.
//
//     benchmark_pushed_rows [starts] [--markdown]
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/benchmark_table.hpp"
#include "benchmarks/thread_clock.hpp"
#include "benchmarks/work_precision/drivers/bristle_driver.hpp"
#include "scenes/rigid/driven.hpp"
#include "scenes/rigid/watched.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

using namespace bristle;

int main(int argc, char** argv) {
  int starts = 6;
  bool is_markdown = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--markdown") {
      is_markdown = true;
    } else {
      starts = std::max(1, std::atoi(argv[i]));
    }
  }
  const work_precision::EngineFamily family = work_precision::bristle_family<double>("bristle64");
  benchmarks::Table table(is_markdown, {"     boxes", "step [s]", "ms a step", "least overlap [mm]",
                                        "median", "largest"});
  for (const int rows : {4, 8, 12, 20, 40}) {
    for (const double rate : {60.0, 240.0}) {
      const double dt = 1 / rate;
      double seconds = 0;
      long steps = 0;
      std::vector<double> depths;
      for (int start = 0; start < starts; ++start) {
        scenes::Watched trial(scenes::pushed_boxes(rows, static_cast<std::uint64_t>(start) + 2),
                              {.depth = std::numeric_limits<double>::infinity()});
        const auto engine = family.make(trial.scene(), dt, family.settings.front());
        const long count = std::lround(trial.scene().duration * rate);
        for (long i = 0; i <= count; ++i) {
          trial.observe(*engine, {static_cast<double>(i) * dt, dt, i});
          if (i == count) break;
          trial.prepare(*engine, {static_cast<double>(i) * dt, dt, i});
          const double before = benchmarks::thread_seconds();
          engine->step();
          seconds += benchmarks::thread_seconds() - before;
        }
        steps += count;
        depths.push_back(1e3 * trial.outcome().error);
      }
      std::sort(depths.begin(), depths.end());
      const std::size_t middle = depths.size() / 2;
      const double median =
          depths.size() % 2 != 0 ? depths[middle] : 0.5 * (depths[middle - 1] + depths[middle]);
      table.add({std::to_string(6 * rows), "1/" + benchmarks::in_full(rate),
                 benchmarks::in_short(1e3 * seconds / static_cast<double>(steps)),
                 benchmarks::in_short(depths.front()), benchmarks::in_short(median),
                 benchmarks::in_short(depths.back())});
    }
  }
}
