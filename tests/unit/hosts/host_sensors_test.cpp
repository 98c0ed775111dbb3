/// @file
/// Tests of sensors in somebody else's engine.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/block_on_plate.hpp"
#include "scenes/random_host.hpp"
#include "scenes/toy_pinch.hpp"
#include "support/pinch_checks.hpp"
#include "support/relative.hpp"

#include <bristle/hosts/host_sensors.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

using namespace bristle;
using namespace bristle::detail;
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
    const auto reading = sensors.world().reading(patch);
    const double tolerance = 1e3 * static_cast<double>(Tolerance<S>::round_off());
    CHECK(reading.touching() == 16);
    CHECK(reading.body[0] == host.block_id);
    CHECK(static_cast<double>(reading.total_normal()) == test::relative(4.905).epsilon(tolerance));
    // Pressed in by 0.3 of 10 mm, as tuned.
    CHECK(static_cast<double>(host.block.z()) == test::relative(0.007).epsilon(tolerance));
  }
}

namespace {

/// A plate and two blocks at rest, one of which its rays hit, as the engine says.
struct TwoBlocks : BlockOnPlate<double> {
  BodyId other{};
  bool is_other_near = false, throws = false;
  int more_hits = 0;

  PatchId attach(HostSensors<double>& sensors, const PatchDef<double>& patch) {
    other = sensors.world().add_body({.motion = Motion::kinematic});
    return BlockOnPlate<double>::attach(sensors, patch);
  }
  [[nodiscard]] HostBody<double> body(BodyId id) const {
    HostBody<double> found = BlockOnPlate<double>::body(id);
    found.acceleration = {};
    if (id == other) found.pose.translation.x() = found.center.x() = 1;
    return found;
  }
  [[nodiscard]] Mat6<double> mobility(BodyId i, BodyId j) const {
    if (throws) throw std::runtime_error("mobility");
    return BlockOnPlate<double>::mobility(i, j);
  }
  void cast_rays(BodyId, const RayBatch<double>& rays, RayHits<double>& hits) const {
    hits.reset(static_cast<std::size_t>(static_cast<int>(rays.size()) + more_hits));
    for (std::size_t i = 0; i < hits.distance.size(); ++i) {
      hits.offer(i, {0.008, -Vec3<double>::UnitZ()}, (is_other_near ? other : block_id).index);
    }
  }
};

}  // namespace

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
        test::relative(1.5 / (def.parameters.static_friction * 4.905)).epsilon(1e-6));
  run(400);
  CHECK(std::abs(host.block.x() - there) < 1e-12);
  CHECK(sensors.world().reading(patch).total_shear() == test::relative(1.5).epsilon(1e-9));
}

TEST_CASE("HostSensors: what it applies is what it reads, and adds up to nothing") {
  CastingBlockOnPlate<double> host;
  host.velocity = {0.3, -0.1, -0.2};
  HostSensors<double> sensors;
  const PatchId patch = host.attach(sensors, plate_patch<double>());
  sensors.step(host, 1e-3);
  const auto reading = sensors.world().reading(patch);
  REQUIRE(reading.touching() > 0);
  const double size = host.on_plate.force.norm();
  CHECK((host.on_plate.force + host.on_block.force).norm() < 1e-14 * size);
  CHECK((host.on_plate.force - reading.wrench.force).norm() < 1e-14 * size);
  // Moments about the plate's centre: the block's wrench acts at its own.
  const Vec3<double> moment =
      host.on_plate.torque + host.on_block.torque + host.block.cross(host.on_block.force);
  CHECK(moment.norm() < 1e-14 * size);
}

TEST_CASE("HostSensors: an engine that throws between steps leaves bristles in what they touched") {
  for (const Integration integration : {Integration::implicit, Integration::explicit_}) {
    TwoBlocks host;
    HostSensors<double> sensors;
    PatchDef<double> def = plate_patch<double>();
    def.integration = integration;
    const PatchId patch = host.attach(sensors, def);
    const auto shear = [&] { return sensors.world().reading(patch).shear_W.norm(); };
    sensors.step(host, 1e-3);
    // The rays meet the other block, which lies as deep, and come back.
    host.is_other_near = host.throws = true;
    CHECK_THROWS_AS(sensors.step(host, 1e-3), std::runtime_error);
    host.is_other_near = host.throws = false;
    for (int i = 0; i < 2; ++i) {
      sensors.step(host, 1e-3);
      CHECK(sensors.world().reading(patch).touching() > 0);
      CHECK(shear() == 0);
    }
  }
}

TEST_CASE("HostSensors: hits keep their number") {
  for (const int more : {-1, 1, 64}) {
    TwoBlocks host;
    host.more_hits = more;
    HostSensors<double> sensors;
    const PatchId patch = host.attach(sensors, plate_patch<double>());
    CHECK_THROWS_WITH_AS(sensors.step(host, 1e-3), doctest::Contains("hits"), InvalidArgument);
    host.more_hits = 0;
    sensors.step(host, 1e-3);
    CHECK(sensors.world().reading(patch).touching() == 16);
  }
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

TEST_CASE("HostSensors: two pads hold a part at any step, and it sags by m g / (mu_S sum F_N)") {
  // Engines hold it for a minute. The bound is one of a rate, and here nothing but the sensors
  // moves.
  constexpr double seconds = 10;
  check_holds<ToyPinch>({.mass = 0.045, .squeeze = 12}, {}, seconds);
  check_holds<ToyPinch>({.mass = 2, .squeeze = 60}, {}, seconds);
  check_holds<ToyPinch>({.mass = 0.045, .squeeze = 12, .is_geared = true}, {}, seconds);
}

TEST_CASE("HostSensors: a part whose centre of mass lies beside the pads is held against turning") {
  check_holds<ToyPinch>({.squeeze = 30, .offset = 0.04}, {}, 10);
}

TEST_CASE("HostSensors: the squeeze decides whether a part is held or let go") {
  check_lets_go<ToyPinch>();
}

TEST_CASE("HostSensors: a shaken part swings as a spring and damper does, and comes back") {
  check_shaken<ToyPinch>();
}

TEST_CASE("HostSensors: pads that come from out of reach catch a part in a long step") {
  check_caught<ToyPinch>({});
}

TEST_CASE(
    "HostSensors: a body that a caller adds to the mirror himself is missing, and harms nobody") {
  check_stranger<ToyPinch>();
}

TEST_CASE("HostSensors: what has no state is seen by nobody, and what is no number goes nowhere") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  ToyPinch pinch{{}};
  pinch.run(0.5);
  SUBCASE("a gravity that is no number") { pinch.gravity = {nan, 0, 0}; }
  SUBCASE("a rotation that is none") { pinch.center.rotation.coeffs().setZero(); }
  SUBCASE("a rotation that is no number") { pinch.center.rotation.x() = nan; }
  SUBCASE("a place without bounds") { pinch.center.translation.z() = 1e200; }
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
  ToyPinch pinch{{}};
  pinch.run(0.5);
  World<double>& world = pinch.sensors.world();
  SUBCASE("a copy goes on with the same bits") {
    ToyPinch copy = pinch;
    copy.run(0.1);
    pinch.run(0.1);
    CHECK(copy.sensors.world().state_hash() == world.state_hash());
  }
  SUBCASE("so does what is restored") {
    const std::vector<std::byte> bytes = world.snapshot();
    ToyPinch other = pinch;
    other.run(0.05);
    other = pinch;
    other.sensors.world().restore(bytes);
    other.run(0.1);
    pinch.run(0.1);
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
    world.remove_body(pinch.part_id);
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
