// Records a sudden push in a trace, writes it as CSV, and draws it.
//
// A block of 0.5 kg on 25 sensors is pushed from 0.2 s to 0.7 s with 2 N. Its bristles stretch by
// s = F / (mu_S N) = 2 N * creep / (friction * m g), which for 1 mm and 0.8 is 0.51 mm; then it
// comes back to where it was: nothing slipped. Writes push.csv and push.svg to the current folder.
//
// Expected output: 08_trace_to_csv.expected
// SPDX-License-Identifier: BSD-3-Clause
#define BRISTLE_WITH_FILES 1  // for Trace
#include "support/svg_plot.hpp"

#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdio>

using namespace bristle;
using namespace figure;

int main() {
  const double dt = 1e-3;
  const double weight = 0.5 * 9.81;
  World<double> world({.time_step = dt});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  // The centre of mass lies low, so that the block hardly leans when it is pushed.
  const BodyId block = world.add_body({.mass = 0.5,
                                       .center_of_mass = Vec3<double>(0, 0, -0.032),
                                       .shape = Box<double>{.half_extents = {0.05, 0.05, 0.03}},
                                       .position = {0, 0, 0.032}});
  const PatchId pad = world.add_patch(
      block,
      sensor_grid<double>({.center = {0, 0, -0.03},
                           .side_u = {0, 0.1, 0},
                           .side_v = {0.1, 0, 0},
                           .count_u = 5,
                           .count_v = 5}),
      tuned_for<double>({.friction = 0.8, .creep = 1e-3, .load = weight, .mass = 0.5}));

  Trace trace{{"time", "s"}, {"displacement", "m"}, {"normal force", "N"}, {"shear", "N"}};
  for (int i = 1; i <= 1000; ++i) {
    if (i > 200 && i <= 700) world.apply_wrench(block, {{2, 0, 0}, {0, 0, 0}});
    world.step();
    const auto reading = world.reading(pad);
    trace.add_row({dt * i, world.body(block).center_pose.translation.x(), reading.total_normal(),
                   reading.total_shear()});
  }
  trace.write_csv("push.csv");

  const double stretch = 2 * 1e-3 / (0.8 * weight);
  const std::vector<double>& time = trace.column("time");
  SvgPlot plot{.title = "A push of 2 N for half a second", .x_label = "time [s]"};
  plot.phases = {{0, 0.2, "at rest"}, {0.2, 0.7, "pushed"}, {0.7, 1, "at rest"}};
  plot.panels.push_back({.y_label = "force [N]",
                         .series = {{"normal force", time, trace.column("normal force")},
                                    {"shear", time, trace.column("shear")}},
                         .references = {{weight, "m g"}}});
  plot.panels.push_back({.y_label = "displacement [m]",
                         .series = {{"", time, trace.column("displacement")}},
                         .references = {{stretch, "predicted"}}});
  plot.write_svg("push.svg");

  std::printf("push.csv: %zu rows; push.svg: %zu panels\n", trace.size(), plot.panels.size());
  std::puts("time [s]  displacement [mm]  shear [N]");
  for (std::size_t row = 99; row < trace.size(); row += 200) {
    std::printf("%8.1f  %17.2f  %9.2f\n", time[row],
                1e3 * std::abs(trace.column("displacement")[row]), trace.column("shear")[row]);
  }
  std::printf("predicted while pushed: %.2f mm\n", 1e3 * stretch);
}
