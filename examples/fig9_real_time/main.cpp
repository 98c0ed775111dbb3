// Figure 9 of the paper: real-time factor over time of the two-handed screwdriver.
//
// The task of fig8_screwdriver with one turn, at a fixed 1 kHz on one core, with 100, 1000 and
// 10 000 sensors, implicit and explicit. The factor is simulated time over the time that the
// processor took, over stretches of a tenth of a second; above 1 the task runs in real time. One
// run has the solver's defaults instead of the task's bounds.
//
// Prints a table, writes fig9_real_time.csv, fig9_real_time_curves.csv and fig9_real_time.svg;
// `--replay FILE.glb` the task with 10 000 sensors.
// SPDX-License-Identifier: BSD-3-Clause
#include "fig8_screwdriver/task.hpp"
#include "support/replay.hpp"
#include "support/svg_plot.hpp"
#include "support/table.hpp"


#include <algorithm>
#include <cmath>

namespace {

using bristle::Integration;
using fig8::PadGrid;
using fig8::Sample;
using fig8::Task;
using fig8::TaskDef;

struct Case {
  std::string name;
  TaskDef def;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Integration integration : {Integration::implicit, Integration::explicit_}) {
    for (const PadGrid grid : {PadGrid{5, 5}, PadGrid{10, 25}, PadGrid{25, 100}}) {
      all.push_back({std::to_string(4 * grid.count()) + " sensors",
                     {.turns = 1, .integration = integration, .grid = grid}});
    }
  }
  all.push_back({"1000, default solver", {.turns = 1, .grid = {10, 25}, .solver = {}}});
  return all;
}

/// [s] Length of a stretch over which the factor is taken.
constexpr double stretch = 0.1;

/// Real-time factor over time.
figure::PlotSeries factors(const Case& each, const Task& task) {
  figure::PlotSeries curve{each.name, {}, {}};
  const auto count = static_cast<std::size_t>(std::lround(stretch / each.def.time_step));
  const std::vector<Sample>& steps = task.samples();
  for (std::size_t i = 0; i + count <= steps.size(); i += count) {
    double cpu_time = 0;
    for (std::size_t k = i; k < i + count; ++k) cpu_time += steps[k].cpu_time;
    curve.x.push_back(steps[i + count - 1].time);
    curve.y.push_back(stretch / cpu_time);
  }
  return curve;
}

std::vector<figure::Cell> row_of(const Case& each, const Task& task,
                                 const figure::PlotSeries& curve) {
  double longest = 0;
  double in_time = 0;
  for (const Sample& step : task.samples()) {
    longest = std::max(longest, step.cpu_time);
    if (step.cpu_time < each.def.time_step) in_time += 1;
  }
  return {each.name,
          figure::name_of(each.def.integration),
          figure::number("%.2f", task.real_time_factor()),
          figure::number("%.2f", *std::min_element(curve.y.begin(), curve.y.end())),
          figure::number("%.2f", 1e3 * longest),
          figure::number("%.1f", 100 * in_time / static_cast<double>(task.samples().size())),
          figure::number("%.3f", 1e3 * task.slip())};
}

void write_curves(const std::vector<figure::PlotPanel>& panels) {
  std::vector<figure::Cell> heads{"time [s]"};
  for (const figure::PlotPanel& panel : panels) {
    for (const figure::PlotSeries& curve : panel.series) {
      heads.push_back(panel.y_label + ": " + curve.name);
    }
  }
  figure::Table table(heads);
  const std::vector<double>& times = panels.front().series.front().x;
  for (std::size_t i = 0; i < times.size(); ++i) {
    std::vector<figure::Cell> row{figure::number("%.1f", times[i])};
    for (const figure::PlotPanel& panel : panels) {
      for (const figure::PlotSeries& curve : panel.series) {
        row.push_back(i < curve.y.size() ? figure::number("%.3f", curve.y[i]) : "");
      }
    }
    table.add(row);
  }
  table.write_csv("fig9_real_time_curves.csv");
}

}  // namespace

int main(int argc, char** argv) {
  figure::Replay replay = figure::Replay::of_arguments(argc, argv);
  figure::Table table({"", "integration", "factor", "least in 0.1 s", "longest step [ms]",
                       "steps below 1 ms [%]", "slip [mm]"});
  figure::SvgPlot plot{.title = "Real-time factor of the screwdriver task at 1 kHz (Fig. 9)",
                        .x_label = "time [s]"};
  for (const Integration integration : {Integration::implicit, Integration::explicit_}) {
    plot.panels.push_back({.y_label = std::string("factor, ") + figure::name_of(integration),
                           .series = {},
                           .references = {{1, "real time"}},
                           .is_logarithmic = true});
  }
  std::vector<Case> all = cases();
  // The one with the most sensors, implicit. Recording is no part of what is measured.
  all[2].def.watch = replay.watch();
  for (const Case& each : all) {
    Task task(each.def);
    task.run();
    const figure::PlotSeries curve = factors(each, task);
    table.add(row_of(each, task, curve), task.is_right());
    plot.panels[each.def.integration == Integration::implicit ? 0 : 1].series.push_back(curve);
    if (!plot.phases.empty()) continue;
    for (const fig8::Phase& phase : task.phases()) {
      if (phase.is_shown()) plot.phases.push_back({phase.begin, phase.end, phase.name});
    }
  }
  std::puts("The screwdriver of fig8_screwdriver at 1 kHz on one core:");
  table.print();
  table.write_csv("fig9_real_time.csv");
  write_curves(plot.panels);
  plot.width = 860;
  plot.panel_height = 200;
  plot.write_svg("fig9_real_time.svg");
  replay.write();
  return table.is_good() ? 0 : 1;
}
