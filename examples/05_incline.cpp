// Leaves a box on 16 sensors on a 20 degree incline for ten seconds, under the paper's law and under
// the law as its own simulator, AMBF, computes it.
//
// A bristle carries F_T = mu_S F_N s at any speed, zero included. So the box comes to rest where
// mu_S s = tan 20, that is s = 0.364 / 5000 = 72.8 um, and stays: what creeps is zero, not small.
// AMBF cubes stretches below 0.1 mm, which leaves next to no force there: the box slides until the
// bristles let go, over and over. (The same happens in engines that approximate friction by a
// multiple of velocity: they can slow a slide down, never end it.)
// Expected output: 05_incline.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdio>
#include <numbers>

using namespace bristle;

namespace {

/// A world with a box that stands on nothing but its sensors; gravity leans instead of the plane.
struct Incline {
  World<double> world;
  BodyId box;
  PatchId patch;
};

Incline make_incline(Law law, double slope) {
  Incline scene{World<double>({.gravity = {9.81 * std::sin(slope), 0, -9.81 * std::cos(slope)},
                               .time_step = 1e-3}),
                {},
                {}};
  scene.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  scene.box = scene.world.add_body({.mass = 0.5,
                                    .center_of_mass = Vec3<double>(0, 0, -0.007),
.shape = Box<double>{.half_extents = {0.1, 0.1, 0.005}},
                                    .position = {0, 0, 0.007}});
  scene.patch = scene.world.add_patch(
      scene.box, {.sensors = sensor_grid<double>({.center = {0, 0, -0.005},
                                                  .side_u = {0, 0.2, 0},
                                                  .side_v = {0.2, 0, 0},
                                                  .count_u = 4,
                                                  .count_v = 4}),
                  .parameters = {.normal_stiffness = 1,
                                 .normal_damping = 0.05,
                                 .static_friction = 5000,
                                 .sliding_friction = 0.5,
                                 .breakaway_distance = 1e-3},
                  .options = {.law = law}});
  return scene;
}

}  // namespace

int main() {
  const double slope = 20 * std::numbers::pi / 180;
  Incline paper = make_incline(Law::paper, slope);
  Incline ambf = make_incline(Law::ambf, slope);
  const auto along = [](const Incline& scene) {
    return 1e6 * scene.world.pose(scene.box).translation.x();
  };

  std::puts("             way down the slope [um]");
  std::puts("time [s]     paper's law      AMBF's law");
  double rest = 0;
  for (int i = 1; i <= 12000; ++i) {
    paper.world.step();
    ambf.world.step();
    if (i == 2000) rest = along(paper);
    if (i % 2000 == 0) std::printf("%8d  %14.1f  %14.0f\n", i / 1000, along(paper), along(ambf));
  }
  std::printf("predicted %14.1f\n", 1e6 * std::tan(slope) / 5000);
  const double drift = std::abs(along(paper) - rest);
  std::printf("drift in the last ten seconds: %s\n",
              drift < 1e-6 ? "less than a picometre" : "too much");
}
