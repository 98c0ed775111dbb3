// Figure 8 (a) of the paper: a two-handed screwdriver.
//
// The major hand picks the driver up beside the cast, the minor one guides its shaft into the slot
// and softens its grip, the major one turns the shaft and the cast below it; the minor one holds
// while the major one goes back for another turn; three times. Both hands are grippers with pads of
// sensors, moved by motors of limited force; nothing is glued to anything, tip and slot meet as
// shapes. A hand holds while its surface moves along what it grips by less than sigma_a.
//
// Prints the phases, and the task at several steps; writes fig8_screwdriver.csv,
// fig8_screwdriver_steps.csv and fig8_screwdriver.svg; `--replay FILE.glb` the task.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/replay.hpp"
#include "support/svg_plot.hpp"
#include "support/table.hpp"
#include "task.hpp"


#include <cmath>

namespace {

using bristle::Integration;
using fig8::Phase;
using fig8::Sample;
using fig8::Task;

/// [deg] Without the minus of a rounded zero.
double in_degrees(double angle) { return std::round(100 * angle / fig8::degree) / 100 + 0.0; }

bool print_phases(const Task& task) {
  figure::Table table({"phase", "until [s]", "holds", "tip at [mm]", "shaft [deg]", "cast [deg]",
                       "slip [mm]", "let go", "major [N]", "minor [N]", "wrist [N m]",
                       "x real time"});
  for (const Phase& phase : task.phases()) {
    const bool has_turned = !phase.is_turn() || (phase.driver_turn > Task::wanted_turn &&
                                                 phase.cast_turn > Task::wanted_turn);
    const bool has_held = phase.slip < Task::slip_bound && phase.released == 0;
    table.add(
        {phase.name, figure::number("%.1f", phase.end), phase.holder,
         figure::number("%.2f", 1e3 * phase.height),
         figure::number("%.2f", in_degrees(phase.driver_turn)),
         figure::number("%.2f", in_degrees(phase.cast_turn)),
         figure::number("%.3f", 1e3 * phase.slip),
         figure::number("%g", static_cast<double>(phase.released)),
         figure::number("%.2f", phase.squeeze_major), figure::number("%.2f", phase.squeeze_minor),
         figure::number("%.2f", phase.torque), figure::number("%.1f", phase.real_time_factor())},
        has_turned && has_held);
  }
  std::printf(
      "A driver of %.1f kg in two hands, implicit steps of 1 ms, %d sensors. The hand that holds\n"
      "must slip by less than %.3f mm, shaft and cast must turn by %.0f degrees a turn:\n",
      fig8::driver_mass, 4 * fig8::PadGrid{}.count(), 1e3 * Task::slip_bound,
      Task::wanted_turn / fig8::degree);
  table.print();
  table.write_csv("fig8_screwdriver.csv");

  const fig8::Account& sum = task.account();
  std::printf(
      "\nEnergy: drives gave %.4f J, the cast's joint took %.4f, sensors %.4f, contacts %.4f; the\n"
      "bodies have %.4f more, and %.4f are not accounted for. Momentum of the driver beyond what\n"
      "acted on it in a step: %.0e N s, %.0e N m s.\n",
      sum.drives, -sum.cast, -sum.sensors, -sum.contacts, sum.gained, sum.error(),
      sum.lost_momentum, sum.lost_angular);
  return table.is_good() && task.is_right();
}

void draw(const Task& task) {
  figure::SvgPlot plot{.title = "A screwdriver in two hands (Fig. 8 (a))", .x_label = "time [s]"};
  figure::PlotSeries shaft{"shaft", {}, {}}, cast{"cast", {}, {}}, height{"", {}, {}};
  figure::PlotSeries major{"major hand", {}, {}}, minor{"minor hand", {}, {}}, slip{"", {}, {}};
  const auto point = [](figure::PlotSeries& curve, double x, double y) {
    curve.x.push_back(x);
    curve.y.push_back(y);
  };
  constexpr std::size_t every = 20;
  for (std::size_t i = 0; i < task.samples().size(); i += every) {
    const Sample& at = task.samples()[i];
    point(shaft, at.time, at.driver_turn / fig8::degree);
    point(cast, at.time, at.cast_turn / fig8::degree);
    point(height, at.time, 1e3 * at.height);
    point(major, at.time, at.squeeze_major);
    point(minor, at.time, at.squeeze_minor);
    point(slip, at.time, 1e3 * at.slip);
  }
  for (const Phase& phase : task.phases()) {
    if (phase.is_shown()) plot.phases.push_back({phase.begin, phase.end, phase.name});
  }
  plot.panels = {{.y_label = "turn [deg]", .series = {shaft, cast}},
                 {.y_label = "tip at [mm]", .series = {height}},
                 {.y_label = "squeeze [N]", .series = {major, minor}},
                 {.y_label = "slip [mm]",
                  .series = {slip},
                  .references = {{1e3 * Task::slip_bound, "sigma_a"}}}};
  plot.width = 860;
  plot.panel_height = 110;
  plot.write_svg("fig8_screwdriver.svg");
}

bool print_steps() {
  figure::Table table({"integration", "dt [ms]", "least turn [deg]", "slip [mm]", "work [J]",
                       "not accounted for", "momentum [N s]", "x real time"});
  for (const Integration integration : {Integration::implicit, Integration::explicit_}) {
    for (const double dt : {1e-3, 1.0 / 240}) {
      Task task({.time_step = dt, .integration = integration});
      task.run();
      std::vector<figure::Cell> row{figure::name_of(integration), figure::number("%.3g", 1e3 * dt)};
      // Explicit steps of 1/240 s are too long for these pads.
      if (!task.lost_in().empty() && integration == Integration::explicit_ && dt > 2e-3) {
        row.push_back("lost: " + task.lost_in());
        table.add(row);
        continue;
      }
      const fig8::Account& sum = task.account();
      row.push_back(figure::number("%.2f", task.least_turn() / fig8::degree));
      row.push_back(figure::number("%.3f", 1e3 * task.slip()));
      row.push_back(figure::number("%.3f", sum.drives));
      row.push_back(figure::number("%.4f", sum.error()));
      row.push_back(figure::number("%.1g", sum.lost_momentum, 1e-14));
      row.push_back(figure::number("%.1f", task.real_time_factor()));
      table.add(row, task.is_right());
    }
  }
  std::puts("\nThe same at other steps:");
  table.print();
  table.write_csv("fig8_screwdriver_steps.csv");
  return table.is_good();
}

}  // namespace

int main(int argc, char** argv) {
  figure::Replay replay = figure::Replay::of_arguments(argc, argv);
  Task task({.watch = replay.watch()});
  task.run();
  const bool is_done = print_phases(task);
  draw(task);
  replay.write();
  const bool is_done_at_all_steps = print_steps();
  return is_done && is_done_at_all_steps ? 0 : 1;
}
