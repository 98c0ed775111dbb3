/// @file
/// A part that two pads squeeze, lift and hold, in whatever engine: by the engine's own contacts,
/// and by sensors.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/svg_plot.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>

namespace figure {

/// The same in every engine: pads of 100 g that slide along x on a lift, and a part between them,
/// all of them boxes of 10 x 20 x 20 mm that stand 0.1 mm apart.
struct LiftedPinch {
  /// [1] Coulomb's coefficient.
  double friction = 0.7;
  /// [kg], [N] Mass of the part, and force of each pad on it.
  double mass = 0.045;
  double squeeze = 12;
  /// [m/s^2]
  double gravity = 9.81;
  /// [s] Step, and [s] end.
  double dt = 1e-3;
  double end = 9;

  /// The sensors' share of it.
  [[nodiscard]] bristle::GripSpec<double> spec() const {
    return {.friction = friction, .load = squeeze, .mass = mass};
  }
  /// [m] Height that the lift shall have: it rises by 0.1 m within the second second.
  [[nodiscard]] static double height(double t) { return 0.1 * std::clamp(t - 1, 0.0, 1.0); }
  /// [m/s] Mean speed of the lift in the step that begins at t [s].
  [[nodiscard]] double speed(double t) const { return (height(t + dt) - height(t)) / dt; }
};

/// Outcome of a pinch: the part's height in the pads over time, and its creep [m/s] in the end.
struct PinchRun {
  PlotSeries height;
  double creep = 0;
  bool is_lost = false;
};

/// Runs a pinch in an engine.
/// @param engine  has step(t) [s], a step of the engine with squeeze and lift, and place(), the
///                part's height between the pads [m].
template <typename Engine>
PinchRun run_pinch(Engine& engine, const LiftedPinch& pinch) {
  PinchRun result;
  const double settled = 4;  // [s]
  double start = 0;
  for (int i = 0; i * pinch.dt < pinch.end; ++i) {
    const double t = i * pinch.dt;
    engine.step(t);
    const double place = engine.place();
    if (t < settled) start = place;
    if (i % std::lround(0.02 / std::min(pinch.dt, 0.02)) == 0) {
      result.height.x.push_back(t);
      result.height.y.push_back(1e3 * place);
    }
    // It has left the pads, or is nowhere.
    if (!(std::abs(place) < 0.02)) {
      result.is_lost = true;
      return result;
    }
    result.creep = (start - place) / (pinch.end - settled);
  }
  return result;
}

/// Prints how fast two parts creep, by contacts and by sensors, at steps from 1 to 17 ms, and plots
/// where they are at 2 ms: 45 g at 12 N, 38 times what would do, and 2 kg at 60 N, 4.3 times that.
/// @param name   [-] of the engine.
/// @param file   [-] Name of the plot's file.
/// @param bound  [m/s] Creep that the engine's numbers do not tell from none.
/// @return 0 if sensors hold both parts at every step, else 1.
template <typename Engine>
int compare_pinches(const std::string& name, const std::string& file, double bound) {
  struct Part {
    const char* name;
    double mass, squeeze;  // [kg], [N]
  };
  const Part parts[] = {{"45 g at 12 N", 0.045, 12}, {"2 kg at 60 N", 2, 60}};
  std::printf("creep [um/s]   %22s   %22s\nstep [ms]   ", parts[0].name, parts[1].name);
  for (int k = 0; k < 2; ++k) std::printf("   %10s  %10s", "contacts", "sensors");
  std::printf("\n");
  SvgPlot plot{.title = "Lifted and held by two pads in " + name + ", steps of 2 ms",
               .x_label = "time [s]"};
  for (const Part& part : parts) {
    plot.panels.push_back({.y_label = std::string(part.name) + " [mm]", .series = {}});
  }
  bool all_held = true;
  for (const double dt : {0.001, 0.002, 1.0 / 240, 1.0 / 120, 1.0 / 60}) {
    std::printf("%9.1f   ", 1e3 * dt);
    for (std::size_t k = 0; k < 2; ++k) {
      std::printf(" ");
      for (const bool has_sensors : {false, true}) {
        const LiftedPinch pinch{.mass = parts[k].mass, .squeeze = parts[k].squeeze, .dt = dt};
        Engine engine(pinch, has_sensors);
        PinchRun run = run_pinch(engine, pinch);
        if (run.is_lost) {
          std::printf("  %10s", "dropped");
        } else {
          std::printf("  %10.4f", 1e6 * run.creep);
        }
        if (has_sensors) all_held = all_held && !run.is_lost && std::abs(run.creep) < bound;
        if (dt == 0.002) {
          run.height.name = has_sensors ? "sensors" : "contacts";
          plot.panels[k].series.push_back(run.height);
        }
      }
    }
    std::printf("\n");
  }
  plot.write_svg(file);
  std::printf("wrote %s\n", file.c_str());
  return all_held ? 0 : 1;
}

}  // namespace figure
