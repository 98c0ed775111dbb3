// AMBF's own scene files fall, and gain no energy.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/ambf_files.hpp"

#include <bristle/io/adf.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

using namespace bristle;

namespace {

/// [J] Kinetic and potential energy of the bodies of a scene.
double energy_of(const World<double>& world, const AdfScene<double>& scene, double g) {
  double energy = 0.0;
  for (const auto& entry : scene.bodies) {
    const Body<double>& body = world.body(entry.value);
    energy += body.kinetic_energy() + body.mass * g * body.center_pose.translation.z();
  }
  return energy;
}

}  // namespace

TEST_CASE("AMBF's own files: load and run for ten seconds without a blow-up") {
  for (const std::filesystem::path& file : test::ambf_files()) {
    CAPTURE(file.string());
    const double g = 9.81;
    World<double> world({.gravity = {0, 0, -g}, .time_step = 1e-3});
    // The files stand in the air. Something for them to fall on, 0.5 m and more below them.
    const double floor = -2.0;
    world.add_body(
        {.motion = Motion::fixed, .shape = HalfSpace<double>{Vec3<double>::UnitZ(), floor}});
    const AdfScene<double> scene = add_adf(world, file);
    CHECK(scene.bodies.size() > 0);
    for (const AdfNote& note : scene.report.notes()) {
      CAPTURE(note.key);
      CHECK(note.kind != AdfNoteKind::left_out);
    }
    // Only gravity works: energy never exceeds that of the start, to the round-off of what the fall
    // to the floor gives.
    const double start = energy_of(world, scene, g);
    double fall = 0.0;
    for (const auto& entry : scene.bodies) {
      const Body<double>& body = world.body(entry.value);
      fall += body.mass * g * (body.center_pose.translation.z() - floor);
    }
    double gain = 0.0, fastest = 0.0;
    for (int i = 0; i < 10'000; ++i) {
      world.step();
      gain = std::max(gain, energy_of(world, scene, g) - start);
      for (const auto& entry : scene.bodies) {
        fastest = std::max(fastest, world.body(entry.value).twist.linear.norm());
      }
    }
    CHECK(std::isfinite(energy_of(world, scene, g)));
    CHECK(gain <= 1e-9 * fall);
    // The tip of a chain may be faster than its middle, which falls by less than 3 m.
    CHECK(fastest < 3.0 * std::sqrt(2.0 * g * 3.0));
    MESSAGE(file.filename().string(), " of ", file.parent_path().filename().string(), ": ",
            scene.bodies.size(), " bodies, ", scene.joints.size(), " joints, gain / fall ",
            gain / fall, ", fastest ", fastest, " m/s");
  }
}
