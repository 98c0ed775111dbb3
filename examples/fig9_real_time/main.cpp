// Figure 9 of the paper: real-time factor over time of the two-handed screwdriver.
//
// The task of fig8_screwdriver with one turn, at a fixed 1 kHz on one core, with 100, 1000 and
// 10 000 sensors. The factor is simulated time over the time that the processor took, over
// stretches of a tenth of a second; above 1 the task runs in real time. One run has the solver's
// defaults instead of the task's bounds, and one casts its rays in every eighth step.
//
// Prints a table, writes fig9_real_time.csv, fig9_real_time_curves.csv and fig9_real_time.svg.
// SPDX-License-Identifier: BSD-3-Clause
#include "fig8_screwdriver/task.hpp"
#include "support/table.hpp"

#include <bristle/io/svg_plot.hpp>

#include <algorithm>
#include <cmath>

namespace {

using fig8::Sample;
using fig8::Task;
using fig8::TaskDef;

struct Case {
  std::string name;
  TaskDef def;
};

std::vector<Case> cases() {
  const auto with = [](int across, int along) {
    return TaskDef{.turns = 1, .grid = {across, along}};
  };
  std::vector<Case> all{{"100 sensors", with(5, 5)},
                        {"1000 sensors", with(10, 25)},
                        {"10 000 sensors", with(25, 100)},
                        {"1000, default solver", with(10, 25)},
                        {"10 000, rays each 8th step", with(25, 100)}};
  all[3].def.solver = {};
  all[4].def.cast_every = 8;
  return all;
}

/// [s] Length of a stretch over which the factor is taken.
constexpr double stretch = 0.1;

/// Real-time factor over time.
bristle::PlotSeries factors(const Task& task, double time_step) {
  bristle::PlotSeries curve;
  const auto count = static_cast<std::size_t>(std::lround(stretch / time_step));
  const std::vector<Sample>& steps = task.samples();
  for (std::size_t i = 0; i + count <= steps.size(); i += count) {
    double cpu_time = 0;
    for (std::size_t k = i; k < i + count; ++k) cpu_time += steps[k].cpu_time;
    curve.x.push_back(steps[i + count - 1].time);
    curve.y.push_back(stretch / cpu_time);
  }
  return curve;
}

}  // namespace

int main() {
  figure::Table table({"", "sensors", "factor", "least in 0.1 s", "longest step [ms]",
                       "steps below 1 ms [%]", "slip [mm]"});
  bristle::SvgPlot plot{.title = "Real-time factor of the screwdriver task, 1 kHz (Fig. 9)",
                        .x_label = "time [s]"};
  bristle::PlotPanel panel{.y_label = "real-time factor",
                           .series = {},
                           .references = {{1, "real time"}},
                           .is_logarithmic = true};
  for (const Case& each : cases()) {
    Task task(each.def);
    task.run();
    bristle::PlotSeries curve = factors(task, each.def.time_step);
    double longest = 0;
    double in_time = 0;
    for (const Sample& step : task.samples()) {
      longest = std::max(longest, step.cpu_time);
      if (step.cpu_time < each.def.time_step) in_time += 1;
    }
    const auto steps = static_cast<double>(task.samples().size());
    table.add({each.name, figure::number("%g", 4.0 * each.def.grid.count()),
               figure::number("%.2f", task.real_time_factor()),
               figure::number("%.2f", *std::min_element(curve.y.begin(), curve.y.end())),
               figure::number("%.2f", 1e3 * longest), figure::number("%.1f", 100 * in_time / steps),
               figure::number("%.3f", 1e3 * task.slip())},
              task.is_right());
    if (plot.phases.empty()) {
      for (const fig8::Phase& phase : task.phases()) {
        const bool is_shown = phase.is_turn() || phase.name == "lift" || phase.name == "insert";
        if (is_shown) plot.phases.push_back({phase.begin, phase.end, phase.name});
      }
    }
    curve.name = each.name;
    panel.series.push_back(curve);
  }
  std::puts("The screwdriver of fig8_screwdriver at 1 kHz on one core, implicit:");
  table.print();
  table.write_csv("fig9_real_time.csv");

  std::vector<figure::Cell> heads{"time [s]"};
  for (const bristle::PlotSeries& curve : panel.series) heads.push_back(curve.name);
  figure::Table points(heads);
  for (std::size_t i = 0; i < panel.series[0].x.size(); ++i) {
    std::vector<figure::Cell> row{figure::number("%.1f", panel.series[0].x[i])};
    for (const bristle::PlotSeries& curve : panel.series) {
      row.push_back(figure::number("%.3f", curve.y[i]));
    }
    points.add(row);
  }
  points.write_csv("fig9_real_time_curves.csv");
  plot.panels.push_back(panel);
  plot.width = 860;
  plot.panel_height = 260;
  plot.write_svg("fig9_real_time.svg");
  return table.is_good() ? 0 : 1;
}
