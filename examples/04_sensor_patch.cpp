// Covers the underside of a box with the sensors of a mesh file, and stands it on an incline.
//
// 36 sensors sit on the vertices of a 100 mm pad. The box of 2 kg leans: its centre of mass is off
// its middle, and the plane has 10 degrees. The patch's reading must balance the weight:
//
//   force across the plane  = m g cos 10
//   force up the slope      = m g sin 10
//   centre of pressure      = centre of mass, shifted down the slope by its height times tan 10
//
// Expected output: 04_sensor_patch.expected
// SPDX-License-Identifier: BSD-3-Clause
#define BRISTLE_WITH_FILES 1  // for load_mesh
#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>

using namespace bristle;

int main() {
  // Any .obj or .stl will do; this one is made here, so that the example needs no file.
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / "bristle_example_pad.obj";
  save_obj(file, grid_mesh<double>({0.1, 0.1}, {5, 5}));
  const TriangleMesh<double> pad = load_mesh<double>(file);

  const double mass = 2;
  const double weight = mass * 9.81;
  const double slope = 10 * std::numbers::pi / 180;
  const Quat<double> tilt = exp_rotation<double>({0, slope, 0});  // +x points down the slope

  World<double> world({.time_step = 1e-3});
  const BodyId plane =
      world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}, .orientation = tilt});
  const Vec3<double> center_of_mass(0.004, 0.008, -0.01);
  const BodyId box = world.add_body({.mass = mass,
                                     .center_of_mass = center_of_mass,
                                     .shape = Box<double>{.half_extents = {0.05, 0.05, 0.03}},
                                     .position = tilt * Vec3<double>(0, 0, 0.033),
                                     .orientation = tilt});

  // The pad's mesh faces +z; turned by half a turn about x it covers the underside.
  PlacementReport placed;
  const SensorLayout<double> sensors =
      sensors_from_mesh<double>(pad,
                                {.depth = 0.005,
                                 .range = 0.010,
                                 .faces = false,
                                 .vertices = true,
                                 .X_AM = {Quat<double>(0, 1, 0, 0), {0, 0, -0.03}}},
                                &placed);
  const PatchId patch = world.add_patch(
      box, sensors,
      tuned_for<double>({.friction = 0.8, .load = weight, .mass = mass, .press = 0.2}));
  for (int i = 0; i < 3000; ++i) world.step();

  const PatchReading<double> reading = world.reading(patch);
  std::printf("%zu sensors on vertices; depth of each, the way down the slope to the right:\n",
              placed.vertex_sensors);
  for (std::size_t i = 0; i < reading.size(); ++i) {
    std::printf("%6.2f%s", reading.depth[i], i % 6 == 5 ? "\n" : "");
  }

  // Centre of pressure and centre of mass in the plane's frame, from the middle of the box.
  const Transform<double> X_PW = world.pose(plane).inverse();
  const Vec3<double> middle = X_PW * world.pose(box).translation;
  const Vec3<double> center = X_PW * (world.pose(box) * center_of_mass) - middle;
  Vec3<double> pressure = Vec3<double>::Zero();
  for (std::size_t i = 0; i < reading.size(); ++i) {
    const Vec3<double> touch(reading.point_x[i], reading.point_y[i], reading.point_z[i]);
    pressure += reading.normal_force[i] / reading.total_normal() * (X_PW * touch - middle);
  }
  const double height = center.z() + middle.z();
  std::puts("\n                            read  expected");
  // The box leans on its soft skin, so its sensors do not stand quite upright on the plane: the
  // vector sum is what balances the weight.
  const Vec3<double> force = X_PW.rotate(reading.wrench.force);
  std::printf("across the plane [N]     %7.3f  %8.3f\n", force.z(), weight * std::cos(slope));
  std::printf("up the slope [N]         %7.3f  %8.3f\n", -force.x(), weight * std::sin(slope));
  std::printf("centre of pressure [mm]  %7.2f  %8.2f   along x\n", 1e3 * pressure.x(),
              1e3 * (center.x() + height * std::tan(slope)));
  std::printf("                         %7.2f  %8.2f   along y\n", 1e3 * pressure.y(),
              1e3 * center.y());
  std::filesystem::remove(file);
}
