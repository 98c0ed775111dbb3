// Figure 7 (a) of the paper: a box on resistive sensors, pushed by a constant force, sticks and
// slips up stairs of sigma_a.
//
// Between F_max / 2 and F_max = mu_S sigma_a m g a plate that slides goes on sliding: its bristles
// let go at sigma_a and grip anew, which takes k sigma_a^2 / 2 a stair, so that mean friction is
// half the static one. The table sets height, period and mean speed beside those of the plate's
// equation, m e'' + c e' + k e = F with e back at 0 at every release.
//
// Prints a table, writes fig7_stick_slip.csv and fig7_stick_slip.svg; `--replay FILE.glb` a push by
// 0.51 F_max.
// SPDX-License-Identifier: BSD-3-Clause
#include "stairs.hpp"
#include "support/replay.hpp"
#include "support/svg_plot.hpp"
#include "support/table.hpp"

#include <bristle/io/trace.hpp>

#include <string>

namespace {

using bristle::Integration;
using fig7::Push;
using fig7::Stairs;

/// The first 80 ms of a push.
bristle::Trace record(const Push& push) {
  bristle::Trace trace{{"time", "ms"}, {"place", "mm"}, {"speed", "m/s"}, {"friction", "F_max"}};
  fig7::climb(push, 0.08, [&](const auto& scene, double time) {
    // Every 0.1 ms, or every step.
    if (time < 1e-4 * (static_cast<double>(trace.size()) + 1) - 1e-9) return;
    const double shear = scene.world.reading(scene.patch).total_shear();
    trace.add_row({1e3 * time, 1e3 * scene.position().x(), scene.velocity().x(),
                   shear / fig7::StairEquation::full_load});
  });
  return trace;
}

void plot() {
  figure::SvgPlot plot{.title = "A constant push: stairs of 1 mm (Fig. 7 (a))",
                        .x_label = "time [ms]"};
  const auto panels_of = [&plot](double force, double damping_ratio, const std::string& what) {
    figure::PlotPanel place{.y_label = "place [mm]", .series = {}};
    figure::PlotPanel friction{.y_label = "shear / F_max", .series = {}};
    for (const double dt : {1e-5, 1e-3}) {
      const bristle::Trace trace = record({force, damping_ratio, dt, Integration::implicit});
      const auto curve = [&](const char* channel, const std::string& name) {
        return figure::PlotSeries{name, trace.column("time"), trace.column(channel)};
      };
      place.series.push_back(curve("place", what + ", dt = " + figure::text("%g ms", 1e3 * dt)));
      friction.series.push_back(curve("friction", ""));
    }
    friction.references = {{0.5, "F_max / 2"}};
    plot.panels.push_back(place);
    plot.panels.push_back(friction);
  };
  panels_of(0.51, fig7::papers_damping_ratio(), "F = 0.51 F_max, the paper's mu_V");
  panels_of(0.9, 0.5, "F = 0.9 F_max, damping ratio 0.5");
  plot.width = 860;
  plot.panel_height = 130;
  plot.write_svg("fig7_stick_slip.svg");
}

}  // namespace

int main(int argc, char** argv) {
  figure::Replay replay = figure::Replay::of_arguments(argc, argv);
  figure::Table table({"F / F_max", "damping ratio", "dt [ms]", "integration", "height [mm]",
                       "period [ms]", "its equation", "speed [m/s]", "its equation",
                       "friction / F_max", "steps a stair"});
  const double papers = fig7::papers_damping_ratio();
  struct Force {
    double part;
    double damping_ratio;
  };
  for (const Force force : {Force{0.51, papers}, Force{0.55, papers}, Force{0.6, papers},
                            Force{0.9, 0.5}, Force{1, 0.7}}) {
    for (const double dt : {1e-5, 1e-3, 1.0 / 240}) {
      for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
        const Push push{force.part, force.damping_ratio, dt, integration};
        const Stairs expected = fig7::StairEquation(push).steady();
        const Stairs measured = fig7::climb(push, dt < 1e-4 ? 1 : 4);
        table.add(
            {figure::number("%.2f", force.part), figure::number("%.4f", force.damping_ratio),
             figure::number("%.3g", 1e3 * dt), figure::name_of(integration),
             figure::number("%.3f", 1e3 * measured.height),
             figure::number("%.3f", 1e3 * measured.period),
             figure::number("%.3f", 1e3 * expected.period),
             figure::number("%.3f", measured.speed, 1e-6), figure::number("%.3f", expected.speed),
             figure::number("%.3f", fig7::mean_friction(push, measured.speed)),
             figure::number("%.1f", expected.period / dt)},
            fig7::is_right(push, measured, expected));
      }
    }
  }
  std::puts(
      "Stairs of a plate of 0.5 kg on 16 sensors, mu_S = 5000 /m, sigma_a = 1 mm, F_max = "
      "24.525 N.");
  table.print();
  table.write_csv("fig7_stick_slip.csv");
  plot();
  if (replay.is_wanted()) {
    fig7::climb({0.51, papers}, 0.4, [&replay](const auto& scene, double) {
      replay.recorder().scalar("place", "mm", 1e3 * scene.position().x());
      replay.observe(scene.world);
    });
  }
  replay.write();
  return table.is_good() ? 0 : 1;
}
