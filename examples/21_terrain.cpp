// A ball and a crate on terrain: a height field as ground, and what a ray finds of it.
//
// The ground is a slope of tan q = 0.2 that ends at x = 1 m. A ball of radius r rolls down with
// 5/7 g sin q = 1.374 m/s^2, and touches the flat ground r tan(q / 2) = 10 mm before the end, after
// 2.030 m at 2.362 m/s. There it keeps (2/5 + cos q) / (7/5) = 0.986 of that, 2.329 m/s, as the
// spin about the point that it meets is kept. The crate's friction of 0.5 is more than 0.2: it
// stays.
//
// Expected output: 21_terrain.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

int main() {
  using namespace bristle;
  // Rows of equal y, over 6 m by 2 m in cells of 50 mm.
  const std::array<std::uint32_t, 2> cells{120, 40};
  std::vector<double> heights;
  for (std::uint32_t j = 0; j <= cells[1]; ++j) {
    for (std::uint32_t i = 0; i <= cells[0]; ++i) {
      heights.push_back(0.2 * std::max(0.0, 1 - (6.0 * i / cells[0] - 3)));
    }
  }
  const auto surface = height_field_mesh<double>({6, 2}, cells, heights);

  World<double> world({.time_step = 1.0 / 240});
  // Half a metre thick: a shape is a solid.
  world.add_body({.motion = Motion::fixed, .shape = extruded_mesh<double>(surface, {0, 0, -0.5})});
  const auto height_at = [&](double x, double y) {
    return world.cast_ray({.origin = {x, y, 10}, .direction = {0, 0, -1}}).point.z();
  };
  std::printf("ground at x = -1 m: %.3f m, at x = 2 m: %.3f m\n", height_at(-1, 0),
              height_at(2, 0));

  const double slant = std::sqrt(1 + 0.2 * 0.2);
  const Vec3<double> up = Vec3<double>(0.2, 0, 1) / slant;
  const Quat<double> along(Eigen::AngleAxisd(std::atan(0.2), Vec3<double>::UnitY()));
  const auto on_slope = [&](double x, double y, double h) {
    return Vec3<double>(Vec3<double>(x, y, height_at(x, y)) + h * up);
  };
  const BodyId ball = world.add_body(
      {.mass = 1, .shape = Sphere<double>{.radius = 0.1}, .position = on_slope(-1, -0.5, 0.1)});
  const BodyId crate = world.add_body({.mass = 5,
                                       .shape = Box<double>{.half_extents = {0.2, 0.15, 0.1}},
                                       .position = on_slope(-1, 0.5, 0.1),
                                       .orientation = along});
  const Vec3<double> put = world.pose(crate).translation;
  std::puts("time [s]  ball x [m]  speed [m/s]  crate moved [mm]");
  for (int i = 1; i <= 480; ++i) {
    world.step();
    if (i % 60 != 0) continue;
    std::printf("%8.2f  %10.3f  %11.3f  %16.4f\n", i / 240.0, world.pose(ball).translation.x(),
                world.body(ball).twist.linear.norm(),
                1e3 * (world.pose(crate).translation - put).norm());
  }
}
