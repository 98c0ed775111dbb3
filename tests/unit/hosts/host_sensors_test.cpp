/// @file
/// Tests of sensors in somebody else's engine.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/block_on_plate.hpp"
#include "scenes/host_pinch.hpp"
#include "scenes/random_host.hpp"

#include <bristle/hosts/host_sensors.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <limits>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE_TEMPLATE("HostSensors: a block comes to rest on a patch at any step", S, float, double) {
  for (const double dt : {1e-3, 1.0 / 60}) {
    CastingBlockOnPlate<S> host;
    HostSensors<S> sensors;
    const PatchId patch = host.attach(sensors, plate_patch<S>());
    const int steps = static_cast<int>(3 / dt);
    for (int i = 0; i < steps; ++i) {
      sensors.step(host, S(dt));
      host.step(S(dt));
    }
    const auto felt = sensors.world().reading(patch);
    const double tolerance = 1e3 * static_cast<double>(Tolerance<S>::round_off());
    CHECK(felt.touching() == 16);
    CHECK(felt.body[0] == host.block_id);
    CHECK(static_cast<double>(felt.total_normal()) == doctest::Approx(4.905).epsilon(tolerance));
    // Pressed in by 0.3 of 10 mm, as tuned.
    CHECK(static_cast<double>(host.block.z()) == doctest::Approx(0.007).epsilon(tolerance));
  }
}

TEST_CASE("HostSensors: shapes that are mirrored are felt as those the engine casts rays at") {
  CastingBlockOnPlate<double> casting;
  BlockOnPlate<double> mirrored;
  HostSensors<double> by_engine, by_mirror;
  const PatchId patch = casting.attach(by_engine, plate_patch<double>());
  REQUIRE(mirrored.attach(by_mirror, plate_patch<double>()) == patch);
  // The block's frame lies in its lower face.
  by_mirror.world().add_shape(mirrored.block_id, {.shape = Box<double>{{0.1, 0.1, 0.1}},
                                                  .X_BS = {Quat<double>::Identity(), {0, 0, 0.1}}});
  for (int i = 0; i < 200; ++i) {
    by_engine.step(casting, 1e-3);
    casting.step(1e-3);
    by_mirror.step(mirrored, 1e-3);
    mirrored.step(1e-3);
    CHECK((casting.block - mirrored.block).norm() < 1e-12);
  }
  CHECK(by_mirror.world().reading(patch).touching() == 16);
}

TEST_CASE("HostSensors: a pushed block sags by F / (mu_S N) and stays") {
  CastingBlockOnPlate<double> host;
  HostSensors<double> sensors;
  const PatchDef<double> def = plate_patch<double>();
  const PatchId patch = host.attach(sensors, def);
  const double dt = 1.0 / 60;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      sensors.step(host, dt);
      host.step(dt);
    }
  };
  run(200);
  const double start = host.block.x();
  host.push = {1.5, 0, 0};
  run(400);
  const double there = host.block.x();
  CHECK(there - start ==
        doctest::Approx(1.5 / (def.parameters.static_friction * 4.905)).epsilon(1e-6));
  run(400);
  CHECK(std::abs(host.block.x() - there) < 1e-12);
  CHECK(sensors.world().reading(patch).total_shear() == doctest::Approx(1.5).epsilon(1e-9));
}

TEST_CASE("HostSensors: what it applies is what it reads, and adds up to nothing") {
  CastingBlockOnPlate<double> host;
  host.velocity = {0.3, -0.1, -0.2};
  HostSensors<double> sensors;
  const PatchId patch = host.attach(sensors, plate_patch<double>());
  sensors.step(host, 1e-3);
  const auto felt = sensors.world().reading(patch);
  REQUIRE(felt.touching() > 0);
  const double size = host.on_plate.force.norm();
  CHECK((host.on_plate.force + host.on_block.force).norm() < 1e-14 * size);
  CHECK((host.on_plate.force - felt.wrench.force).norm() < 1e-14 * size);
  // Moments about the plate's centre: the block's wrench acts at its own.
  const Vec3<double> moment =
      host.on_plate.torque + host.on_block.torque + host.block.cross(host.on_block.force);
  CHECK(moment.norm() < 1e-14 * size);
}

TEST_CASE("HostSensors: nothing in reach, nothing applied") {
  CastingBlockOnPlate<double> host;
  host.block.z() = 1;
  HostSensors<double> sensors;
  const PatchId patch = host.attach(sensors, plate_patch<double>());
  sensors.step(host, 1e-3);
  CHECK(host.wrenches == 0);
  CHECK(sensors.world().reading(patch).touching() == 0);
  CHECK(sensors.report().pairs == 0);
}

namespace {

/// A pinch that has held its part since gravity came, [m/s] how fast that creeps, and [m] how far
/// it sagged.
struct Hold {
  double creep = 0;
  double sag = 0;
  double expected_sag = 0;
};
Hold hold(const HostPinchDef<double>& def, double dt) {
  HostPinch<double> pinch(def);
  pinch.run(1.0, dt);
  const double start = pinch.center.translation.z();
  pinch.gravity = {0, 0, -9.81};
  pinch.run(1.5, dt);
  const double there = pinch.center.translation.z();
  pinch.run(2.0, dt);
  Hold result;
  result.creep = std::abs(pinch.center.translation.z() - there) / 2.0;
  result.sag = start - there;
  double normal = 0;
  for (const PatchId patch : pinch.patches) {
    normal += pinch.sensors.world().reading(patch).total_normal();
  }
  const double mu_S = pinch.sensors.world().patch(pinch.patches[0]).def.parameters.static_friction;
  result.expected_sag = def.mass * 9.81 / (mu_S * normal);
  CHECK(normal == doctest::Approx(2 * def.squeeze).epsilon(1e-9));
  return result;
}

}  // namespace

TEST_CASE("HostSensors: two pads hold a part at any step, and it sags by m g / (mu_S sum F_N)") {
  for (const HostPinchDef<double>& def :
       {HostPinchDef<double>{.mass = 0.045, .squeeze = 12},
        HostPinchDef<double>{.mass = 2, .squeeze = 60},
        HostPinchDef<double>{.mass = 0.045, .squeeze = 12, .is_geared = true}}) {
    for (const double dt : {5e-4, 1e-3, 2e-3, 1.0 / 240, 1.0 / 120, 1.0 / 60, 1.0 / 30}) {
      CAPTURE(def.mass);
      CAPTURE(def.is_geared);
      CAPTURE(dt);
      const Hold held = hold(def, dt);
      CHECK(held.creep < 1e-9);
      CHECK(held.sag == doctest::Approx(held.expected_sag).epsilon(1e-3));
    }
  }
}

TEST_CASE("HostSensors: a part whose centre of mass lies beside the pads is held against turning") {
  HostPinchDef<double> def;
  def.squeeze = 30;
  def.offset = 0.04;
  for (const double dt : {1e-3, 1.0 / 60}) {
    HostPinch<double> pinch(def);
    pinch.run(1.0, dt);
    pinch.gravity = {0, 0, -9.81};
    pinch.run(2.0, dt);
    const Quat<double> there = pinch.center.rotation;
    pinch.run(2.0, dt);
    CHECK(there.angularDistance(pinch.center.rotation) < 1e-9);
    CHECK(there.angularDistance(Quat<double>::Identity()) < 0.1);
    double weight = 0;
    for (const PatchId patch : pinch.patches) {
      weight -= pinch.sensors.world().reading(patch).wrench.force.z();
    }
    CHECK(weight == doctest::Approx(def.mass * 9.81).epsilon(1e-9));
  }
}

TEST_CASE("HostSensors: the squeeze decides whether a part is held or let go") {
  const double limit = 0.045 * 9.81 / (2 * 0.7);
  for (const double factor : {1.01, 0.99}) {
    CAPTURE(factor);
    HostPinch<double> pinch({.mass = 0.045, .squeeze = 12});
    pinch.run(0.5, 1e-3);
    pinch.gravity = {0, 0, -9.81};
    pinch.run(0.5, 1e-3);
    for (double squeeze = 12; squeeze > factor * limit; squeeze *= 0.99) {
      pinch.def.squeeze = squeeze;
      pinch.run(0.01, 1e-3);
    }
    pinch.def.squeeze = factor * limit;
    pinch.run(2.0, 1e-3);
    CHECK((pinch.twist.linear.norm() < 1e-9) == (factor > 1));
  }
}

TEST_CASE("HostSensors: pads that come from out of reach catch a part in a long step") {
  HostPinch<double> pinch({.mass = 0.045, .squeeze = 12});
  pinch.x = {-0.03, 0.03};
  pinch.v = {0.2, -0.2};
  double fastest = 0;
  for (int i = 0; i < 300; ++i) {
    pinch.step(1.0 / 60);
    fastest = std::max(fastest, pinch.twist.linear.norm());
  }
  for (const PatchId patch : pinch.patches) {
    CHECK(pinch.sensors.world().reading(patch).total_normal() == doctest::Approx(12).epsilon(1e-9));
  }
  CHECK(pinch.twist.linear.norm() < 1e-9);
  CHECK(fastest < 0.05);
}

TEST_CASE("HostSensors: what has no state is seen by nobody, and what is no number goes nowhere") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  HostPinch<double> pinch({});
  pinch.run(0.5, 1e-3);
  SUBCASE("a gravity that is no number") { pinch.gravity = {nan, 0, 0}; }
  SUBCASE("a velocity without bounds") { pinch.twist.linear.y() = 1e300; }
  pinch.sensors.step(pinch, 1e-3);
  CHECK(pinch.sensors.report().missing_bodies == 1);
  CHECK(pinch.sensors.report().pairs == 0);
  for (const Wrench<double>& given : pinch.given) CHECK(given.force.isZero(0));
  for (const PatchId patch : pinch.patches) {
    CHECK(pinch.sensors.world().reading(patch).touching() == 0);
  }
  CHECK_THROWS_AS(pinch.sensors.step(pinch, 0.0), InvalidArgument);
  CHECK_THROWS_AS(pinch.sensors.step(pinch, nan), InvalidArgument);
}

TEST_CASE("HostSensors: a hit on what is not mirrored is refused, and nothing was applied") {
  CastingBlockOnPlate<double> host;
  HostSensors<double> sensors;
  (void)host.attach(sensors, plate_patch<double>());
  host.block_id.index = 5;
  CHECK_THROWS_WITH_AS(sensors.step(host, 1e-3), doctest::Contains("hits.tag"), InvalidArgument);
  CHECK(host.wrenches == 0);
}

TEST_CASE("HostSensors: patches are switched, removed and put back as those of a world") {
  HostPinch<double> pinch({});
  pinch.run(0.5, 1e-3);
  World<double>& world = pinch.sensors.world();
  SUBCASE("a copy goes on with the same bits") {
    HostPinch<double> copy = pinch;
    copy.run(0.1, 1e-3);
    pinch.run(0.1, 1e-3);
    CHECK(copy.sensors.world().state_hash() == world.state_hash());
  }
  SUBCASE("so does what is restored") {
    const std::vector<std::byte> bytes = world.snapshot();
    HostPinch<double> other = pinch;
    other.run(0.05, 1e-3);
    other = pinch;
    other.sensors.world().restore(bytes);
    other.run(0.1, 1e-3);
    pinch.run(0.1, 1e-3);
    CHECK(other.sensors.world().state_hash() == world.state_hash());
  }
  SUBCASE("switched off it gives nothing") {
    world.set_active(pinch.patches[0], false);
    world.set_active(pinch.patches[1], false);
    pinch.sensors.step(pinch, 1e-3);
    CHECK(pinch.sensors.report().pairs == 0);
    CHECK(pinch.given[2].force.isZero(0));
  }
  SUBCASE("a body that is removed is let go") {
    world.remove_body(pinch.part);
    pinch.sensors.step(pinch, 1e-3);
    CHECK(pinch.sensors.report().pairs == 0);
    CHECK(world.reading(pinch.patches[0]).touching() == 0);
  }
}

TEST_CASE_TEMPLATE("HostSensors: whatever states an engine has, no wrench is without bounds", S,
                   float, double) {
  RandomHost<S> host(5);
  int wrong = 0;
  for (int i = 0; i < 3000; ++i) wrong += host.step() ? 0 : 1;
  CHECK(wrong == 0);
  CHECK(host.bad == 0);
  CHECK(host.given > 500);
}

TEST_CASE("HostSensors: a shaken part swings as a spring and damper does, and comes back") {
  // 1 g at 5 Hz across the pads is 60 % of what they can hold.
  HostPinchDef<double> def;
  def.squeeze = def.mass * 9.81 / (2 * def.friction * 0.6);
  const double w = 2 * 3.14159265358979 * 5;
  for (const double dt : {5e-4, 1e-3, 2e-3, 1.0 / 240}) {
    CAPTURE(dt);
    HostPinch<double> pinch(def);
    pinch.run(1.0, dt);
    double largest = 0;
    const int steps = static_cast<int>(std::lround(3 / dt));
    for (int i = 0; i < steps; ++i) {
      // What acts in the step is the mean over it.
      const double t = i * dt;
      pinch.shake.y() = 9.81 * (std::cos(w * t) - std::cos(w * (t + dt))) / (w * dt);
      pinch.step(dt);
      if (t > 2) largest = std::max(largest, std::abs(pinch.center.translation.y()));
    }
    const SensorParameters<double> p = pinch.sensors.world().patch(pinch.patches[0]).def.parameters;
    const double normal = 2 * def.squeeze;
    const double k = p.static_friction * normal;
    const double c = p.sliding_friction * normal;
    const double r2 = def.mass * w * w / k;
    const double amplitude = def.mass * 9.81 / k / std::hypot(1 - r2, c * w / k);
    CHECK(largest == doctest::Approx(amplitude).epsilon(0.01));
    pinch.shake.setZero();
    pinch.run(3.0, dt);
    CHECK(std::abs(pinch.center.translation.y()) < 1e-9);
  }
}
