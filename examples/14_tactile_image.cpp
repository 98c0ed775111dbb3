// A ball pressed on a skin of silicone, as an image: constants from the material, readings as rows
// and columns, and what a sensor with flaws would make of them.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <algorithm>
#include <cstdio>
#include <vector>

using namespace bristle;

void print(const char* title, const TactileImage<double>& image, double full_scale) {
  std::printf("%s\n", title);
  for (std::size_t row = 0; row < image.rows; ++row) {
    for (std::size_t column = 0; column < image.columns; ++column) {
      const double shade = std::clamp(image(row, column) / full_scale, 0.0, 1.0);
      std::putchar(" .:-=+*#%@"[static_cast<int>(shade * 9.999)]);
      std::putchar(' ');
    }
    std::printf("\n");
  }
}

int main() {
  World<double> world({.time_step = 1e-3});
  // 16 x 16 sensors on 32 x 32 mm of skin, 4 mm thick.
  const BodyId plate =
      world.add_body({.motion = Motion::fixed, .shape = Box<double>{{0.016, 0.016, 0.005}}});
  SensorGridDef<double> grid;
  grid.center = {0, 0, 0.009};
  grid.side_u = {0.032, 0, 0};
  grid.side_v = {0, 0.032, 0};
  grid.count_u = grid.count_v = 16;
  grid.depth = 0.004;
  grid.range = 0.004 + 1e-9;
  const ElasticSkin<double> skin{.young_modulus = 3e4,
                                 .thickness = 0.004,
                                 .area_per_sensor = 4e-6,
                                 .length = 0.004,
                                 .relaxation_time = 5e-3};
  const PatchId patch =
      world.add_patch(plate, {.sensors = sensor_grid(grid), .parameters = skin.parameters()});
  // A steel ball of 12 mm radius.
  world.add_body(
      {.mass = 0.5, .shape = Sphere<double>{.radius = 0.012}, .position = {0.003, 0, 0.021}});
  for (int i = 0; i < 1000; ++i) world.step();

  const PatchReading<double> reading = world.reading(patch);
  const auto image = tactile_image(reading, TactileChannel::normal_force, grid.count_u);
  const double peak = *std::max_element(image.pixels.begin(), image.pixels.end());
  std::printf("weight 4.905 N, read %.3f N\n", reading.total_normal());
  print("normal force:", image, peak);

  TaxelFlaws<double> flaws(reading.size(), {.gain_spread = 0.1, .dead_share = 0.03, .noise = 0.01});
  std::vector<double> read(reading.size());
  flaws.apply(reading.normal_force, read);
  print("as a worn sensor reads it:", {image.rows, image.columns, read}, peak);
}
