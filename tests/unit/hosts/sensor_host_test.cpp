/// @file
/// Tests of patches in somebody else's engine.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/block_on_plate.hpp"

#include <bristle/hosts/sensor_host.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE_TEMPLATE("sensor_host: a block comes to rest on a patch at any step", S, float, double) {
  for (const double dt : {1e-3, 1.0 / 60}) {
    BlockOnPlate<S> host;
    HostPatch<S> patch(0, plate_patch<S>());
    const int steps = static_cast<int>(3 / dt);
    for (int i = 0; i < steps; ++i) {
      patch.step(host, S(dt));
      host.step(S(dt));
    }
    const auto felt = patch.reading();
    const double tolerance = 1e3 * static_cast<double>(Tolerance<S>::round_off());
    CHECK(felt.touching() == 16);
    CHECK(felt.body[0].index == 1);
    CHECK(static_cast<double>(felt.total_normal()) == doctest::Approx(4.905).epsilon(tolerance));
    // Pressed in by 0.3 of 10 mm, as tuned.
    CHECK(static_cast<double>(host.block.z()) == doctest::Approx(0.007).epsilon(tolerance));
  }
}

TEST_CASE("sensor_host: a pushed block sags by F / (mu_S N) and stays") {
  BlockOnPlate<double> host;
  PatchDef<double> def = plate_patch<double>();
  const double mu_S = def.parameters.static_friction;
  HostPatch<double> patch(0, def);
  const double dt = 1.0 / 60;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      patch.step(host, dt);
      host.step(dt);
    }
  };
  run(200);
  const double start = host.block.x();
  host.push = {1.5, 0, 0};
  run(400);
  const double there = host.block.x();
  CHECK(there - start == doctest::Approx(1.5 / (mu_S * 4.905)).epsilon(1e-6));
  run(400);
  CHECK(std::abs(host.block.x() - there) < 1e-12);
  CHECK(patch.reading().total_shear() == doctest::Approx(1.5).epsilon(1e-9));
}

TEST_CASE("sensor_host: what it applies is what it reads, and adds up to nothing") {
  struct Recorder : BlockOnPlate<double> {
    Wrench<double> on[2];
    void apply_wrench(std::uint32_t i, const Wrench<double>& w) { on[i] += w; }
  } host;
  host.velocity = {0.3, -0.1, -0.2};
  HostPatch<double> patch(0, plate_patch<double>());
  patch.step(host, 1e-3);
  const auto felt = patch.reading();
  REQUIRE(felt.touching() > 0);
  CHECK((host.on[0].force + host.on[1].force).norm() < 1e-14 * host.on[0].force.norm());
  CHECK((host.on[0].force - felt.wrench.force).norm() < 1e-14 * host.on[0].force.norm());
  // Moments about plate's centre: the block's wrench acts at its own centre.
  const Vec3<double> moment =
      host.on[0].torque + host.on[1].torque + host.block.cross(host.on[1].force);
  CHECK(moment.norm() < 1e-14 * host.on[0].force.norm());
}

TEST_CASE("sensor_host: nothing in reach, nothing applied") {
  BlockOnPlate<double> host;
  host.block.z() = 1;
  HostPatch<double> patch(0, plate_patch<double>());
  patch.step(host, 1e-3);
  CHECK(host.wrenches == 0);
  CHECK(patch.reading().touching() == 0);
}

TEST_CASE("sensor_host: what a host hands out does not come back when it is no number") {
  BlockOnPlate<double> host;
  host.push = {std::numeric_limits<double>::quiet_NaN(), 0, 0};
  HostPatch<double> patch(0, plate_patch<double>());
  patch.step(host, 1e-3);
  CHECK(host.added.allFinite());
  CHECK(patch.reading().wrench.force.allFinite());
  CHECK_THROWS_AS(patch.step(host, 0.0), InvalidArgument);
  CHECK_THROWS_AS(patch.step(host, std::numeric_limits<double>::quiet_NaN()), InvalidArgument);
}
