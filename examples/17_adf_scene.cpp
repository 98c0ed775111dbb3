// A scene in AMBF's description format: load it, see what was not taken as it stands, and use it.
//
// The file has a parallel gripper on a lift above a part, with four sensors in an array on one
// finger, eight on a mesh on the other, and a scanner in the palm. The drives close the fingers
// with 5 N and raise the lift, which had sunk to its stop at -10 mm, to 100 mm. The part, 0.1 kg,
// rises by 110 mm but for the sag of the skin, m g / (mu_S sum F_N) = 0.98 / (1000 x 10) = 0.098
// mm.
//
// Another file can be named on the command line; it is loaded, reported, and run for a second.
//
// Expected output: 17_adf_scene.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>
#include <bristle/io/adf.hpp>

#include <cstdio>

using namespace bristle;

namespace {

void run(World<double>& world, double seconds) {
  for (double t = 0; t < seconds; t += world.time_step()) world.step();
}

void print(const AdfScene<double>& scene) {
  std::printf("%zu bodies, %zu joints, %zu patches, %zu proximity sensors\n", scene.bodies.size(),
              scene.joints.size(), scene.patches.size(), scene.proximity.size());
  std::printf("not taken as it stands:\n%s", scene.report.text().c_str());
}

void grip_and_lift(World<double>& world, AdfScene<double>& scene) {
  const BodyId part = scene.bodies.at("Part");
  for (const char* finger : {"Left", "Right"}) {
    world.set_motor(
        scene.joints.at(finger),
        {.mode = MotorMode::position, .target = 0.03, .max_force = 5, .max_speed = 0.2});
  }
  run(world, 0.5);
  const double start = world.pose(part).translation.z();
  world.set_motor(scene.joints.at("Lift"),
                  {.mode = MotorMode::position, .target = 0.1, .max_force = 50, .max_speed = 0.2});
  run(world, 1.5);

  for (const auto& patch : scene.patches) {
    const auto reading = world.reading(patch.value);
    std::printf("%-9s normal %.3f N, shear %.2f N, touching %zu of %zu\n", patch.name.c_str(),
                reading.total_normal(), reading.total_shear(), reading.touching(), reading.size());
  }
  std::printf("the part rose by %.3f mm\n", 1e3 * (world.pose(part).translation.z() - start));
  AdfProximity<double>& scanner = scene.proximity.at("Scanner");
  world.sense(scanner.carrier, scanner.rays);
  std::printf("the scanner's middle ray meets the part at %.1f mm\n",
              1e3 * scanner.rays.distance()[4]);
}

}  // namespace

int main(int argc, char** argv) {
  World<double> world({.gravity = {0, 0, -9.81}, .time_step = 1e-3});
  try {
    if (argc > 1) {
      print(add_adf(world, argv[1]));
      run(world, 1.0);
      return 0;
    }
    AdfScene<double> scene = add_adf(world, BRISTLE_EXAMPLE_DIR "/scenes/parallel_gripper.yaml");
    print(scene);
    grip_and_lift(world, scene);
  } catch (const IoError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
