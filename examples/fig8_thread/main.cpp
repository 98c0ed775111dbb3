// Figure 8 (b) of the paper: two grippers manipulate a deformable thread around an obstacle.
//
// The thread is that of the authors' scene KnotEnv: 65 rigid links and 64 revolute joints. Two
// hands, force-limited motors throughout, take it by its ends with pads of sensors, wrap it around
// the upper half of a post, and pull it over the post, where the tensions on both sides differ by
// the capstan's factor. Then one lets go, goes around to where the other holds the thread, takes it
// over, and pulls on alone. Nothing is glued.
//
// Prints a table, writes fig8_thread.csv, fig8_thread.svg (tensions and slip over time) and
// fig8_thread_shape.svg (the thread at the end of each phase, seen along the post); `--replay
// FILE.glb` the run that these show. The cost of a step goes to the error stream, since it differs
// from run to run.
// SPDX-License-Identifier: BSD-3-Clause
#include "fig8_thread/task.hpp"
#include "support/replay.hpp"
#include "support/svg_plot.hpp"
#include "support/table.hpp"


#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

namespace {

using bristle::Integration;
using fig8b::Measured;
using fig8b::Phase;
using fig8b::Task;
using fig8b::TaskDef;

/// Curves over the time of one run.
struct Curves {
  figure::PlotSeries left{"side of -y", {}, {}};
  figure::PlotSeries right{"side of +y", {}, {}};
  figure::PlotSeries limit{"capstan over the lower", {}, {}};
  figure::PlotSeries first{"hand 0", {}, {}};
  figure::PlotSeries second{"hand 1", {}, {}};
  std::vector<figure::PlotPhase> phases;

  /// Notes every hundredth of a second.
  void add(const Task& task, Phase phase) {
    const double t = task.time();
    if (t < next_) return;
    next_ += 0.01;
    const auto add_to = [t](figure::PlotSeries& series, double y) {
      series.x.push_back(t);
      series.y.push_back(y);
    };
    add_to(first, task.hand(0).pull(task.world()).norm());
    add_to(second, task.hand(1).pull(task.world()).norm());
    // Before the thread hangs from the post there is no such tension.
    if (phase == Phase::grip || phase == Phase::wrap) return;
    const double a = task.tension(-1);
    const double b = task.tension(1);
    add_to(left, a);
    add_to(right, b);
    add_to(limit, fig8b::capstan(std::min(a, b)));
  }
  void write() const {
    figure::SvgPlot plot{.title = "A thread pulled over a post and handed over (Fig. 8 (b))",
                          .x_label = "time [s]"};
    plot.panels.push_back({.y_label = "pull of a hand [N]", .series = {first, second}});
    plot.panels.push_back({.y_label = "tension at the post [N]",
                           .series = {left, right, limit},
                           .y_low = 0,
                           .y_high = 16});
    plot.phases = phases;
    plot.width = 860;
    plot.write_svg("fig8_thread.svg");
  }

 private:
  double next_ = 0;
};

/// The thread at the end of each phase, and the post.
struct Shapes {
  figure::PlotPanel panel{
      .y_label = "z [m]", .series = {}, .references = {}, .y_low = -0.8, .y_high = 0.6};

  void add(const Measured& measured) {
    figure::PlotSeries line{fig8b::name_of(measured.phase), {}, {}};
    for (const auto& bead : measured.beads) {
      line.x.push_back(bead.y());
      line.y.push_back(bead.z());
    }
    panel.series.push_back(line);
  }
  void write() {
    figure::PlotSeries post{"post", {}, {}};
    for (int i = 0; i <= 90; ++i) {
      const double angle = i * std::numbers::pi / 45;
      post.x.push_back(fig8b::post_radius * std::sin(angle));
      post.y.push_back(fig8b::post_radius * std::cos(angle));
    }
    panel.series.push_back(post);
    figure::SvgPlot plot{.title = "The thread at the end of each phase", .x_label = "y [m]"};
    plot.panels.push_back(panel);
    plot.width = 860;
    plot.panel_height = 420;
    plot.write_svg("fig8_thread_shape.svg");
  }
};

/// Explicit steps are too long for these pads on links of a few grams.
bool is_lost_explicitly(const TaskDef& def, const Measured& m) {
  return def.integration == Integration::explicit_ && !m.is_held();
}

void add_row(figure::Table& table, const TaskDef& def, const Measured& m) {
  using figure::number;
  std::vector<figure::Cell> row{fig8b::name_of(m.phase), number("%.3g", 1e3 * def.time_step),
                                figure::name_of(def.integration)};
  if (is_lost_explicitly(def, m)) {
    row.push_back("lost");
    table.add(row);
    return;
  }
  row.push_back(number("%.0e", m.length_error));
  row.push_back(number("%.2f", 1e6 * m.gap));
  for (const double slip : m.slip) row.push_back(number("%.2f", 1e3 * slip));
  for (const double pull : m.pull) row.push_back(number("%.2f", pull));
  const bool is_on_post = m.phase != Phase::grip && m.phase != Phase::wrap;
  for (const double tension : m.tension) {
    row.push_back(is_on_post ? number("%.2f", tension) : figure::Cell());
  }
  row.push_back(is_on_post ? number("%.2f", fig8b::capstan(std::min(m.tension[0], m.tension[1])))
                           : figure::Cell());
  if (m.phase == Phase::grip) {
    row.resize(row.size() + 5);
  } else {
    for (const double part :
         {m.energy.work, m.energy.held, m.energy.post, m.energy.joints, m.energy.rest()}) {
      row.push_back(number("%.3f", part, 1e-3));
    }
  }
  row.push_back(number("%.0f", m.rows));
  row.push_back(number("%.0f", m.factorisations));
  row.push_back(number("%.0f", 100 * m.capped));
  table.add(row, m.is_right());
}

}  // namespace

int main(int argc, char** argv) {
  figure::Replay replay = figure::Replay::of_arguments(argc, argv);
  figure::Table table({"phase",       "dt [ms]",     "integration", "length error", "gap [um]",
                       "slip 0 [mm]", "slip 1 [mm]", "pull 0 [N]",  "pull 1 [N]",   "T -y [N]",
                       "T +y [N]",    "capstan [N]", "work [J]",    "held [J]",     "post [J]",
                       "joints [J]",  "rest [J]",    "rows",        "factored",     "capped [%]"});
  Curves curves;
  Shapes shapes;
  for (const Integration integration : {Integration::implicit, Integration::explicit_}) {
    for (const double dt : {1e-3, 1.0 / 240}) {
      const TaskDef def{.time_step = dt, .integration = integration};
      const bool is_drawn = integration == Integration::implicit && dt < 2e-3;
      Task task(def);
      const auto start = std::chrono::steady_clock::now();
      for (const Phase phase : fig8b::phases) {
        const double begin = task.time();
        const Measured measured = task.run(phase, [&](const Task& now) {
          if (!is_drawn) return;
          curves.add(now, phase);
          replay.observe(now.world());
        });
        add_row(table, def, measured);
        if (is_drawn) {
          curves.phases.push_back({begin, task.time(), fig8b::name_of(phase)});
          shapes.add(measured);
        }
        if (measured.is_lost || is_lost_explicitly(def, measured)) break;
      }
      const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
      std::fprintf(stderr, "%s, %.3g ms: %.1f ms a step\n", figure::name_of(integration), 1e3 * dt,
                   1e3 * passed.count() * dt / task.time());
    }
  }
  std::printf(
      "A thread of %zu links and %zu revolutes, %.2f m and %.3f kg, two hands with %g N a finger,\n"
      "a post of %g m radius and friction %g. Energies are of the phase: the drives' work, what is "
      "held\nmore than before, what was lost on the post, in joints, and elsewhere:\n",
      fig8b::link_count, fig8b::link_count - 1, fig8b::pitch * fig8b::cylinder_count,
      fig8b::cylinder_count * (fig8b::cylinder_mass + fig8b::bead_mass) + fig8b::bead_mass,
      fig8b::squeeze, fig8b::post_radius, fig8b::post_friction);
  table.print();
  table.write_csv("fig8_thread.csv");
  curves.write();
  shapes.write();
  replay.write();
  return table.is_good() ? 0 : 1;
}
