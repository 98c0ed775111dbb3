// Figure 7 (b) of the paper: a box is set down on an incline and stays there, for as long as one
// likes.
//
// A bristle pulls with F_T = mu_S F_N s at any speed, zero included. So the box comes to rest where
// its bristles carry it, tan(angle) / mu_S down the slope and a little more for its tilt, and its
// creep is zero, not small. The law as the paper's own simulator, AMBF, computes it has no normal
// damping and no force at small stretches; its box never comes to rest.
//
// Prints a table, writes fig7_incline.csv and fig7_incline.svg; `--replay FILE.glb` the first
// second on the steepest.
// SPDX-License-Identifier: BSD-3-Clause
#include "hold.hpp"
#include "support/replay.hpp"
#include "support/svg_plot.hpp"
#include "support/table.hpp"


#include <string>

namespace {

using bristle::Integration;
using bristle::Law;
using fig7::Hold;
using fig7::Incline;

constexpr std::array<double, 5> angles{5, 10, 20, 30, 45};

void add_row(figure::Table& table, const Incline& incline) {
  const Hold hold = fig7::hold(incline, incline.law == Law::ambf ? 0 : 20);
  const bool is_lost = hold.drift > 1;
  const std::string sensors = figure::text("%.0f", incline.per_side * incline.per_side);
  std::vector<figure::Cell> row{
      figure::text("%.0f", incline.degrees) + (incline.law == Law::ambf ? " AMBF's law" : ""),
      sensors + (fig7::plate_of(incline).has_contact ? " and contact" : ""),
      figure::number("%.3g", 1e3 * incline.time_step), figure::name_of(incline.integration)};
  if (incline.law == Law::ambf) {
    row.resize(6);
  } else {
    row.push_back(is_lost ? "lost" : figure::number("%.2f", 1e6 * hold.shift));
    row.push_back(figure::number("%.2f", 1e6 * hold.expected));
  }
  row.push_back(is_lost ? "lost" : figure::number("%.2g", hold.drift, 1e-15));
  row.push_back(is_lost ? "lost" : figure::number("%.2g", hold.jitter, 1e-12));
  // Explicit steps must hold where they are stable with room to spare, AMBF's law need not.
  if (incline.law == Law::paper &&
      (incline.integration == Integration::implicit || incline.time_step < 2e-3)) {
    table.add(row, fig7::holds(hold));
  } else {
    table.add(row);
  }
}

/// The way down the slope in the first second, for each incline; the steepest is recorded.
figure::PlotPanel panel(Law law, int per_side, const char* label, figure::Replay& replay) {
  figure::PlotPanel panel{.y_label = label, .series = {}};
  for (const double angle : angles) {
    const auto def = fig7::plate_of(
        {.degrees = angle,
         .law = law,
         .integration = law == Law::ambf ? Integration::explicit_ : Integration::implicit,
         .per_side = per_side});
    auto scene = bristle::scenes::make_plate<double>(def);
    figure::PlotSeries curve{figure::text("%.0f degrees", angle), {}, {}};
    for (int i = 0; i < 1000; ++i) {
      scene.world.step();
      if (law == Law::paper && angle == angles.back()) replay.observe(scene.world);
      curve.x.push_back(1e-3 * (i + 1));
      curve.y.push_back(1e6 * scene.position().x());
    }
    panel.series.push_back(curve);
  }
  return panel;
}

}  // namespace

int main(int argc, char** argv) {
  figure::Replay replay = figure::Replay::of_arguments(argc, argv);
  figure::Table table({"incline [deg]", "sensors", "dt [ms]", "integration", "shift [um]",
                       "by statics", "drift in 10 s [m]", "rms speed [m/s]"});
  for (const double angle : angles) {
    for (const double dt : {1e-3, 1.0 / 240, 1.0 / 60}) {
      for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
        add_row(table, {.degrees = angle, .time_step = dt, .integration = integration});
      }
    }
    for (const int per_side : {2, 5}) {
      add_row(table, {.degrees = angle,
                      .law = Law::ambf,
                      .integration = Integration::explicit_,
                      .per_side = per_side});
    }
  }
  std::puts(
      "A plate of 0.5 kg on an incline, mu_S = 5000 /m, sigma_a = 1 mm, K_N = 1 N, K_D = 0.05 "
      "N s,\nmu_V = 0.1 N s/m; the paper's law is watched from 20 s on.");
  table.print();
  table.write_csv("fig7_incline.csv");

  figure::SvgPlot plot{.title = "Set down on inclines of 5 to 45 degrees (Fig. 7 (b))",
                        .x_label = "time [s]"};
  plot.width = 860;
  plot.panels.push_back(panel(Law::paper, 4, "way down [um]", replay));
  plot.panels.push_back(panel(Law::ambf, 2, "AMBF's law, 4 sensors [um]", replay));
  plot.panels.back().y_low = -200;
  plot.panels.back().y_high = 1200;
  plot.write_svg("fig7_incline.svg");
  replay.write();
  return table.is_good() ? 0 : 1;
}
