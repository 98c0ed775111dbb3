// Presses one sensor on a floor and drags it along, and compares what it reads with the law.
//
//   depth          e   = 1 - distance / L                      Eq. 4
//   normal force   F_N = K_N e + K_D de/dt                     Eq. 3
//   shear          F_T = mu_S F_N s + mu_V v                   Eqs. 1, 5
//   slip           the bristle lets go when s > sigma_a        Eq. 2
//
// The probe goes down 4 mm in 0.1 s, rests, then goes sideways at 9 mm/s. Its bristle stretches by
// 1 mm, holds mu_S sigma_a = 0.8 N of friction for each N of normal force, lets go and starts anew.
//
// Expected output: 03_one_sensor.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <cmath>
#include <cstdio>

using namespace bristle;

int main() {
  const double dt = 1e-3;
  World<double> world({.time_step = dt});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});

  // A probe without a shape, moved by hand. Its ray points down and is 10 mm long, so that it just
  // touches the floor when the probe is 10 mm above it.
  const BodyId probe = world.add_body({.motion = Motion::kinematic, .position = {0, 0, 0.010}});
  SensorLayout<double> sensor;
  sensor.add({0, 0, 0}, {0, 0, -0.010});
  const SensorParameters<double> law{.normal_stiffness = 20,
                                     .normal_damping = 0.1,
                                     .static_friction = 800,
                                     .sliding_friction = 5,
                                     .breakaway_distance = 1e-3};
  const PatchId patch = world.add_patch(probe, sensor, law);

  std::puts("           depth [1]     normal force [N]     shear [N]");
  std::puts("time [s]  read   law      read      law     read     law   state");
  for (int i = 1; i <= 420; ++i) {
    const double t = dt * i;
    const double down = t < 0.1005 ? -0.040 : 0.0;
    const double along = t > 0.2005 ? 0.009 : 0.0;
    world.set_velocity(probe, {{along, 0, down}, {0, 0, 0}});
    world.step();
    const PatchReading<double> reading = world.reading(patch);
    const bool lets_go = reading.state[0] == SensorState::slipping;
    if (i % 30 != 0 && !lets_go) continue;

    // The sensor reads its depth at the start of the step, and the force that acted during it.
    const Vec3<double> p = world.pose(probe).translation;
    const double depth = 1 - (p.z() - down * dt) / 0.010;
    const double normal = law.normal_stiffness * depth - law.normal_damping * down / 0.010;
    const double stretch =
        std::fmod(p.x() - along * dt, law.breakaway_distance);  // since the bristle last let go
    const double shear = law.static_friction * normal * stretch + law.sliding_friction * along;
    std::printf("%8.3f  %.3f  %.3f  %7.3f  %7.3f  %7.3f %7.3f   %s\n", t, reading.depth[0], depth,
                reading.total_normal(), normal, reading.total_shear(), shear,
                lets_go ? "lets go" : "holds");
  }
}
