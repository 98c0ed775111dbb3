// Figure 2 of the paper: how deep a sphere sinks into a plane that it falls on, as a primitive and
// as meshes, at update rates from 60 Hz to 10 kHz.
//
// The paper shows that collision response is soft, and softer or harder with the rate and with the
// mesh, which nobody can grip by. The bound is the way of one step at the speed of the impact,
// v / f with v = sqrt(2 g h). Contacts that are only near count here before they touch, so the
// answer is 0 whatever the rate and the mesh.
//
// Prints a table, writes fig2_drop.csv and fig2_drop.svg; `--replay FILE.glb` the drop of the
// finest mesh.
// SPDX-License-Identifier: BSD-3-Clause
#include "drop.hpp"
#include "support/replay.hpp"
#include "support/svg_plot.hpp"
#include "support/table.hpp"


#include <iterator>
#include <vector>

namespace {

struct Peer {
  const char* name;
  // Worst depth [mm] of the ball at the rates below, and of its mesh of 1280 triangles; < 0: none.
  double ball[3];
  double mesh[3];
};
constexpr double peer_rates[3] = {120, 500, 1000};

// The same scene, heights and measure, each engine with its defaults. `tests/benchmarks/run
// --scenes
// '^drop/'` measures those of Bullet, ODE, MuJoCo and DART again; those of Box3D and Jolt were
// measured by drivers that are not part of this project.
constexpr Peer peers[] = {
    {"Bullet 3.24 (hull)", {34.5, 0, 0}, {27.9, 0, 0}},
    {"Bullet 3.24 (GImpact mesh)", {-1, -1, -1}, {45.8, 11.5, 2.02}},
    {"ODE 0.16.2", {45.8, 11.5, 6.07}, {45.8, 11.5, 6.07}},
    {"MuJoCo 2.2.2", {45.8, 44.9, 45.1}, {45.8, 44.9, 45.1}},
    {"DART 6.12.1", {45.8, 11.5, 6.07}, {-1, -1, -1}},
    {"Box3D 30c67b5", {26.1, 0.0688, 4.34}, {-1, -1, -1}},
    {"Jolt 5.5.1", {27.9, 8.9e-5, 8.9e-5}, {34.7, 6.44, 6.39}},
};

figure::Cell depth_text(double millimetres) {
  return millimetres < 0 ? figure::Cell() : figure::number("%.3g", millimetres);
}

/// A curve, or nothing in its place, so that an engine looks the same in both panels.
void add_peer(figure::PlotPanel& panel, const char* name, const double (&depths)[3]) {
  panel.series.push_back({"", {}, {}, true});
  if (depths[0] < 0) return;
  panel.series.back().name = name;
  panel.series.back().x.assign(std::begin(peer_rates), std::end(peer_rates));
  panel.series.back().y.assign(std::begin(depths), std::end(depths));
}

}  // namespace

int main(int argc, char** argv) {
  figure::Replay replay = figure::Replay::of_arguments(argc, argv);
  const double impact_speed = std::sqrt(2 * 9.81 * fig2::height);
  figure::Table table({"rate [Hz]", "way of a step [mm]", "ball [mm]", "80 triangles [mm]",
                       "1280 triangles [mm]", "gap at rest [mm]"});
  figure::PlotSeries bound{"way of one step", {}, {}};
  figure::PlotSeries here{"bristle: ball, 80 and 1280 triangles", {}, {}, true};
  for (const double rate : fig2::rates) {
    std::vector<figure::Cell> row{figure::number("%.0f", rate),
                                  figure::number("%.2f", 1e3 * impact_speed / rate)};
    fig2::Depth worst;
    for (const std::uint32_t frequency : {0u, 2u, 8u}) {
      const fig2::Depth depth = fig2::worst_drop(frequency, rate);
      worst.worse(depth);
      row.push_back(figure::number("%.3g", 1e3 * std::max(depth.deepest, depth.below_rest), 1e-6));
    }
    row.push_back(figure::number("%.3g", 1e3 * worst.rest_gap, 1e-3));
    // A nanometre, and it lies on the plane.
    table.add(row, std::max(worst.deepest, worst.below_rest) < 1e-9 && worst.rest_gap < 1e-6);
    bound.x.push_back(rate);
    bound.y.push_back(1e3 * impact_speed / rate);
    here.x.push_back(rate);
    here.y.push_back(1e3 * worst.deepest);
  }
  std::puts(
      "Deepest in the plane, worst of eight phases of the step, and D_p (lowest place against"
      "\nthe one at rest), whichever is larger:");
  table.print();
  table.write_csv("fig2_drop.csv");

  figure::Table others({"others, worst depth [mm]", "ball, 120 Hz", "500 Hz", "1 kHz",
                        "1280 triangles, 120 Hz", "500 Hz", "1 kHz"});
  figure::PlotPanel ball{.y_label = "depth of the ball [mm]", .series = {here, bound}};
  figure::PlotPanel mesh{.y_label = "depth of the mesh [mm]", .series = {here, bound}};
  for (const Peer& peer : peers) {
    std::vector<figure::Cell> row{peer.name};
    for (const double d : peer.ball) row.push_back(depth_text(d));
    for (const double d : peer.mesh) row.push_back(depth_text(d));
    others.add(row);
    add_peer(ball, peer.name, peer.ball);
    add_peer(mesh, peer.name, peer.mesh);
  }
  std::puts("");
  others.print();

  figure::SvgPlot plot{
      .title = "50 kg fall 2 m onto a plane: worst depth of eight phases (Fig. 2)",
      .x_label = "update rate [Hz]"};
  plot.is_logarithmic = true;
  plot.width = 860;
  for (figure::PlotPanel* panel : {&ball, &mesh}) {
    panel->y_low = -3;
    panel->y_high = 60;
    plot.panels.push_back(*panel);
  }
  plot.write_svg("fig2_drop.svg");
  if (replay.is_wanted()) fig2::drop(8, 1000, 0, replay.watch());
  replay.write();
  return table.is_good() ? 0 : 1;
}
