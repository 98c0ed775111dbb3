// A two-finger gripper picks a part off an incline, holds it without creep, lets it slip, catches
// it and sets it down, by resistive sensors alone.
//
//   sag of the held part            m g / (mu_S sum F_N)        it then stays where it is
//   load at which it starts to slip sum F_N = m g / mu          mu = mu_S sigma_a
//
// Prints a table, writes a CSV and an SVG plot. `--help` lists the options.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/svg_plot.hpp"
#include "scenario.hpp"

#include <bristle/core/error.hpp>
#include <bristle/io/file.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>

namespace {

using gripper::Outcome;
using gripper::Settings;

constexpr const char* usage =
    R"(Usage: gripper_on_incline [OPTION...]

  --backend fcl|analytic      what computes geometry (fcl)
  --scalar double|float       what the world computes in (double)
  --integration MODE          explicit, implicit or automatic (automatic)
  --dt SECONDS                length of a step; also as a fraction, 1/60 (0.001)
  --law paper|drag|ambf       the sensors' law: the paper's (bristles release), Coulomb drag, or
                              what the paper's own simulator computes, which is explicit only and
                              does not hold the part still: it ends with status 1 (paper)
  --pad FILE                  mesh of a finger's pad, .stl or .obj (the one beside this example)
  --output PREFIX             writes PREFIX.csv and PREFIX.svg (gripper_on_incline)
  --replay FILE               writes the motion and the sensors' forces as binary glTF (.glb), for
                              Blender and other viewers; by examples/run a page, too (.html)
  --help                      this text

Exit status: 0 when the part was held, caught and set down as predicted, 1 when not, 2 for a wrong
option.
)";

[[noreturn]] void fail(const std::string& message) {
  std::fprintf(stderr, "gripper_on_incline: %s\nTry --help.\n", message.c_str());
  std::exit(2);
}

double parse_time_step(const std::string& text) {
  char* end = nullptr;
  double value = std::strtod(text.c_str(), &end);
  if (*end == '/') {
    const char* denominator = end + 1;
    value /= std::strtod(denominator, &end);
    if (end == denominator) end = const_cast<char*>(text.c_str());
  }
  if (end == text.c_str() || *end != '\0' || !(value > 0 && value <= 0.1)) {
    fail("--dt " + text + ": must be a number of seconds in (0, 0.1], such as 0.001 or 1/60");
  }
  return value;
}

std::string one_of(const std::string& option, const std::string& value,
                   std::initializer_list<const char*> allowed) {
  std::string list;
  for (const char* a : allowed) {
    if (value == a) return value;
    list += list.empty() ? a : std::string(", ") + a;
  }
  fail(option + " " + value + ": must be one of " + list);
}

Settings parse(int argc, char** argv) {
  Settings settings;
  settings.pad = std::filesystem::path(BRISTLE_EXAMPLE_DIR) / "pad.stl";
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--help" || option == "-h") {
      std::fputs(usage, stdout);
      std::exit(0);
    }
    const bool is_known = option == "--backend" || option == "--scalar" ||
                          option == "--integration" || option == "--dt" || option == "--law" ||
                          option == "--pad" || option == "--output" || option == "--replay";
    if (!is_known) fail("unknown option '" + option + "'");
    if (i + 1 == argc) fail(option + " needs a value");
    const std::string value = argv[++i];
    if (option == "--backend") settings.backend = one_of(option, value, {"fcl", "analytic"});
    if (option == "--scalar") settings.scalar = one_of(option, value, {"double", "float"});
    if (option == "--law") settings.law = one_of(option, value, {"paper", "drag", "ambf"});
    if (option == "--dt") settings.time_step = parse_time_step(value);
    if (option == "--pad") settings.pad = value;
    if (option == "--output") settings.output = value;
    if (option == "--replay") settings.replay = value;
    if (option == "--replay" && settings.replay.extension() != ".glb") {
      fail("--replay " + value + ": must be a .glb file; examples/run makes pages");
    }
    if (option == "--integration") {
      one_of(option, value, {"explicit", "implicit", "automatic"});
      settings.integration = value == "explicit"   ? bristle::Integration::explicit_
                             : value == "implicit" ? bristle::Integration::implicit
                                                   : bristle::Integration::automatic;
    }
  }
  if (settings.law == "ambf" && settings.integration == bristle::Integration::implicit) {
    fail("--law ambf is explicit only");
  }
  return settings;
}

/// One line of the table; returns whether the value is within its bound.
bool row(const char* what, double value, const char* unit, const char* expected, bool is_good) {
  std::printf("  %-34s %12.6g %-3s  %-34s %s\n", what, value, unit, expected,
              is_good ? "ok" : "NO");
  return is_good;
}

bool print_table(const Settings& settings, const Outcome& o) {
  char text[64];
  bool good = true;
  std::printf("gripper_on_incline: %zu sensors, dt = %g s, %s, %s, law %s\n", o.sensors,
              settings.time_step, settings.backend.c_str(), settings.scalar.c_str(),
              settings.law.c_str());
  std::printf("  %-34s %12s %-3s  %s\n", "", "measured", "", "expected");

  // Float rounds positions of a tenth of a metre to 7 nm, a few of which add up.
  const double length_floor = settings.scalar == "float" ? 1e-6 : 0;
  std::snprintf(text, sizeof text, "m g/(mu_S sum F_N) = %.3f +- 1 %%", 1e6 * o.predicted_sag);
  good &= row("sag in the hand", 1e6 * o.sag, "um", text,
              std::abs(o.sag - o.predicted_sag) < 0.01 * o.predicted_sag + length_floor);
  std::snprintf(text, sizeof text, "< 1 in %g s", o.hold_time);
  good &= row("creep while held", 1e6 * o.creep, "um", text, o.creep < 1e-6 && o.was_held);
  std::snprintf(text, sizeof text, "m g = %.4f", o.weight);
  good &= row("vertical force of the sensors", o.weight + o.hold_force_error, "N", text,
              o.hold_force_error < 1e-3 * o.weight);
  std::snprintf(text, sizeof text, "m g/mu = %.3f +- 5 %%", o.weight / o.friction);
  good &= row("normal force when slip starts", o.slip_load, "N", text,
              std::abs(o.slip_load * o.friction / o.weight - 1) < 0.05);
  good &= row("slid before it was caught", 1e3 * o.slid, "mm", "2 to 3",
              o.slid > 2e-3 && o.slid < 3e-3);
  good &= row("creep after the catch", 1e6 * o.caught_creep, "um", "< 1 in 0.5 s",
              o.caught_creep < 1e-6 && o.was_caught);
  good &= row("speed after it was set down", o.final_speed, "m/s", "0 on the incline",
              o.final_speed < 1e-4 && o.final_height_error < 1e-4);

  if (!o.was_held) {
    std::printf("  The part was lost before the end of the hold%s.\n",
                settings.integration == bristle::Integration::explicit_
                    ? "; explicit integration needs a shorter step"
                    : "");
  }
  std::printf("  %-34s %12.1f      simulated %.2f s in %.3f s of processor time\n",
              "real-time factor", o.simulated_time / o.cpu_time, o.simulated_time, o.cpu_time);
  std::printf("  %-34s %12llu      %llu skipped with nothing in reach\n", "rays cast",
              static_cast<unsigned long long>(o.rays_cast),
              static_cast<unsigned long long>(o.rays_skipped));
  std::printf("  %-34s %12llu      %llu implicit\n", "patch-body pairs explicit",
              static_cast<unsigned long long>(o.explicit_pairs),
              static_cast<unsigned long long>(o.implicit_pairs));
  if (o.backend_failures > 0) {
    std::printf("  %-34s %12llu\n", "contact queries that failed",
                static_cast<unsigned long long>(o.backend_failures));
  }
  return good;
}

std::filesystem::path with_extension(const Settings& settings, const char* extension) {
  std::filesystem::path path = settings.output;
  path += extension;
  return path;
}

void write_files(const Settings& settings, const Outcome& outcome) {
  const std::filesystem::path csv = with_extension(settings, ".csv");
  const std::filesystem::path svg = with_extension(settings, ".svg");
  outcome.trace.write_csv(csv);

  const std::vector<double>& time = outcome.trace.column("time");
  const auto curve = [&](const char* label, const char* channel) {
    return figure::PlotSeries{label, time, outcome.trace.column(channel)};
  };
  figure::SvgPlot plot{.title = "A part picked off an incline, held, let slip and caught",
                        .x_label = "time [s]"};
  plot.width = 860;
  plot.panel_height = 130;
  plot.panels.push_back(
      {.y_label = "height [mm]",
       .series = {curve("part", "part height"), curve("gripper", "gripper height")}});
  plot.panels.push_back(
      {.y_label = "sag in hand [um]", .series = {curve("", "sag")}, .y_low = -200, .y_high = 3500});
  if (std::isfinite(outcome.predicted_sag)) {
    plot.panels.back().references = {{1e6 * outcome.predicted_sag, "m g / (mu_S sum F_N)"}};
  }
  plot.panels.push_back({.y_label = "force [N]",
                         .series = {curve("normal, both pads", "normal force"),
                                    curve("shear on part", "shear force")},
                         .references = {{outcome.weight, "m g"}}});
  plot.panels.push_back({.y_label = "slipping sensors", .series = {curve("", "slipping sensors")}});
  for (const gripper::Phase& phase : outcome.phases) {
    plot.phases.push_back({phase.start, phase.end, phase.name});
  }
  plot.write_svg(svg);
  std::printf("wrote %s and %s\n", csv.string().c_str(), svg.string().c_str());
  if (settings.replay.empty()) return;
  bristle::write_file(settings.replay, outcome.replay);
  std::printf("wrote %s\n", settings.replay.string().c_str());
}

}  // namespace

int main(int argc, char** argv) {
  const Settings settings = parse(argc, argv);
  try {
    const Outcome outcome = settings.backend == "fcl" ? gripper::run_with_fcl(settings)
                                                      : gripper::run_with_analytic(settings);
    const bool good = print_table(settings, outcome);
    write_files(settings, outcome);
    return good ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gripper_on_incline: %s\n", error.what());
    return 1;
  }
}
