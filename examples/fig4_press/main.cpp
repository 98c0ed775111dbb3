// Figures 4 and 6 (a) of the paper: an array of sensors pressed into a box, and a skin wrapped
// around a fingertip pressed into a plane, as maps of depth and force.
//
// Both rest by their weight on sensors alone. Under the flat array depth is a plane, whose forces
// add up to the weight and meet below the centre of mass; under the round skin it falls off from
// the middle as the plane recedes. The table sets every sensor's depth beside that of statics.
//
// Prints a table, writes fig4_press.csv, fig4_press_sensors.csv and fig4_press.svg; `--replay
// FILE.glb` how the skin is pressed.
// SPDX-License-Identifier: BSD-3-Clause
#include "press.hpp"
#include "support/replay.hpp"
#include "support/svg_heat_map.hpp"
#include "support/table.hpp"

#include <bristle/io/trace.hpp>

#include <string>

namespace {

using bristle::Integration;
using fig4::Press;
using fig4::Steps;

struct Scene {
  const char* name;
  Press (*make)(const Steps&);
};
constexpr Scene scenes[] = {{"array on a box", fig4::press_on_box},
                            {"skin on a plane", fig4::press_skin}};

void add_row(figure::Table& table, const Scene& scene, const Steps& steps) {
  Press press = scene.make(steps);
  press.run(4);
  const auto reading = press.world.reading(press.patch);
  const bool is_lost = reading.touching() == 0;
  std::vector<figure::Cell> row{scene.name, figure::number("%.3g", 1e3 * steps.time_step),
                                figure::name_of(steps.integration)};
  if (is_lost) {
    row.push_back("lost");
  } else {
    row.push_back(figure::number("%.0f", static_cast<double>(reading.touching())));
    row.push_back(figure::number("%.6f", reading.wrench.force.z()));
    row.push_back(figure::number("%.6f", press.weight));
    row.push_back(figure::number("%.2g", press.imbalance(), 1e-6));
    row.push_back(
        figure::number("%.4f", *std::max_element(reading.depth.begin(), reading.depth.end())));
    row.push_back(figure::number("%.4f", press.depth_error()));
  }
  if (is_lost && steps.integration == Integration::explicit_) {
    table.add(row);
  } else {
    table.add(row, press.imbalance() < 1e-6 && press.depth_error() < 1e-3);
  }
}

figure::HeatMap map_of(std::string title, std::string label, std::span<const double> values) {
  return {.title = std::move(title),
          .label = std::move(label),
          .columns = fig4::side,
          .values = {values.begin(), values.end()},
          .low = 0};
}

}  // namespace

int main(int argc, char** argv) {
  figure::Replay replay = figure::Replay::of_arguments(argc, argv);
  figure::Table table({"scene", "dt [ms]", "integration", "sensors touching", "force [N]",
                       "weight [N]", "imbalance [1]", "largest depth [1]",
                       "largest error of depth [1]"});
  for (const Scene& scene : scenes) {
    for (const double dt : {1e-3, 1.0 / 240, 1.0 / 60}) {
      for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
        add_row(table, scene, {dt, integration});
      }
    }
  }
  std::puts(
      "256 sensors, at rest; imbalance: missing force, and torque about a centimetre, as "
      "parts of the weight.");
  table.print();
  table.write_csv("fig4_press.csv");

  figure::SvgHeatMaps figure{.title = "Pressed sensors, seen from below (Figs. 4 and 6 (a))"};
  bristle::Trace sensors{{"box: depth", "1"},
                         {"box: normal force", "N"},
                         {"skin: depth", "1"},
                         {"skin: normal force", "N"}};
  for (const Scene& scene : scenes) {
    Press press = scene.make({});
    press.run(4, scene.make == fig4::press_skin ? replay.watch() : nullptr);
    const auto reading = press.world.reading(press.patch);
    figure.maps.push_back(map_of(scene.name, "depth [1]", reading.depth));
    figure.maps.push_back(map_of(scene.name, "normal force [N]", reading.normal_force));
  }
  for (std::size_t i = 0; i < fig4::side * fig4::side; ++i) {
    sensors.add_row({figure.maps[0].values[i], figure.maps[1].values[i], figure.maps[2].values[i],
                     figure.maps[3].values[i]});
  }
  sensors.write_csv("fig4_press_sensors.csv");
  figure.write_svg("fig4_press.svg");
  replay.write();
  return table.is_good() ? 0 : 1;
}
