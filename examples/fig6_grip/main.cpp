// Figure 6 (b) of the paper: a prismatic gripper with resistive sensors holds parts at asymmetric
// postures: rolled, turned, off centre, tapered, round.
//
// Each part sinks by m g / (mu_S sum F_N) when its weight comes on, one that is off centre turns
// under it, and then all stay where they are. Against torsion about the line between the pads, of
// radius R and pressed with F each, a pad whose bristles drag along resists with (2/3) mu F R, as a
// disk under Coulomb friction does; with the paper's bristles, which release, the outermost let go
// first, at (1/2) mu F R, and that is the limit.
//
// Prints two tables, writes fig6_grip.csv, fig6_grip_torsion.csv and fig6_grip.svg; `--replay
// FILE.glb` the grip of the rolled cube.
// SPDX-License-Identifier: BSD-3-Clause
#include "grip.hpp"
#include "support/replay.hpp"
#include "support/svg_plot.hpp"
#include "support/table.hpp"


namespace {

using bristle::Integration;
using bristle::SlipReset;
using fig6::GripDef;

const char* name_of(SlipReset reset) { return reset == SlipReset::drag ? "drag" : "release"; }

bool print_postures() {
  figure::Table table({"part", "dt [ms]", "integration", "squeeze [N]", "carried [N]", "sag [um]",
                       "by statics", "turn [mrad]", "by statics", "drift in 5 s [m]", "[rad]"});
  for (const fig6::Posture posture : fig6::postures) {
    for (const double dt : {1e-3, 1.0 / 240}) {
      for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
        const fig6::Held held =
            fig6::hold({.posture = posture, .time_step = dt, .integration = integration});
        std::vector<figure::Cell> row{fig6::name_of(posture), figure::number("%.3g", 1e3 * dt),
                                      figure::name_of(integration)};
        // Explicit steps of 1/240 s are too long for these pads. How they fail is chance.
        if (!held.is_right() && integration == Integration::explicit_ && dt > 2e-3) {
          row.push_back(held.is_lost() ? "lost" : "shakes");
          table.add(row);
          continue;
        }
        row.push_back(figure::number("%.3f", held.squeeze));
        row.push_back(figure::number("%.6f", held.carried));
        row.push_back(figure::number("%.2f", 1e6 * held.sag));
        row.push_back(figure::number("%.2f", 1e6 * held.expected_sag));
        row.push_back(figure::number("%.3f", 1e3 * held.turn, 1e-3));
        row.push_back(figure::number("%.3f", 1e3 * held.expected_turn, 1e-3));
        row.push_back(figure::number("%.2g", held.drift, 1e-12));
        row.push_back(figure::number("%.2g", held.drift_turn, 1e-12));
        table.add(row, held.is_right());
      }
    }
  }
  std::puts(
      "Parts of 0.5 kg and 50 mm between two pads of 12 mm radius, 113 sensors and 10 N each, "
      "mu = 1:");
  table.print();
  table.write_csv("fig6_grip.csv");
  return table.is_good();
}

bool print_torsion() {
  figure::Table table({"bristles", "F [N]", "dt [ms]", "N m/rad", "sum mu_S F_N r^2", "limit [N m]",
                       "closed form", "2 (2/3) mu F R"});
  figure::SvgPlot plot{.title = "Torsion of a cube between two pads (Fig. 6 (b))",
                        .x_label = "turn [mrad]"};
  for (const double force : {5.0, 10.0, 20.0}) {
    figure::PlotPanel panel{.y_label = figure::text("torque at %g N [N m]", force), .series = {}};
    for (const SlipReset reset : {SlipReset::drag, SlipReset::release}) {
      for (const double dt : {1e-3, 1.0 / 240}) {
        figure::PlotSeries curve{name_of(reset), {}, {}};
        const fig6::Torsion torsion = fig6::twist({.force = force, .time_step = dt, .reset = reset},
                                                  [&curve](double torque, double turn) {
                                                    curve.x.push_back(1e3 * turn);
                                                    curve.y.push_back(torque);
                                                  });
        const double disk = 4.0 / 3 * force * fig6::pad_radius;
        table.add({name_of(reset), figure::number("%g", force), figure::number("%.3g", 1e3 * dt),
                   figure::number("%.4f", torsion.stiffness),
                   figure::number("%.4f", torsion.expected_stiffness),
                   figure::number("%.4f", torsion.limit),
                   figure::number("%.4f", torsion.expected_limit), figure::number("%.4f", disk)},
                  torsion.is_right());
        if (dt < 2e-3) continue;
        panel.series.push_back(curve);
        panel.references = {{disk, "2 (2/3) mu F R"}, {0.75 * disk, "2 (1/2) mu F R"}};
      }
    }
    plot.panels.push_back(panel);
  }
  std::puts(
      "\nTorsion of the cube without weight, implicit; closed form: sum mu F_N r if bristles "
      "drag,\nuntil the outermost lets go if they release:");
  table.print();
  table.write_csv("fig6_grip_torsion.csv");
  plot.width = 860;
  plot.panel_height = 130;
  plot.write_svg("fig6_grip.svg");
  return table.is_good();
}

}  // namespace

int main(int argc, char** argv) {
  figure::Replay replay = figure::Replay::of_arguments(argc, argv);
  const bool holds = print_postures();
  const bool resists = print_torsion();
  if (replay.is_wanted()) {
    fig6::hold({.posture = fig6::Posture::rolled, .watch = replay.watch()}, 1, 1);
  }
  replay.write();
  return holds && resists ? 0 : 1;
}
