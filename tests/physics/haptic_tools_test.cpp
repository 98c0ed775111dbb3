/// @file
/// Tools of a haptic loop: how they move, what opening forgets, bodies that go, and what is
/// refused.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/stylus.hpp"
#include "support/relative.hpp"

#include <bristle/sensors/virtual_coupling.hpp>

#include <doctest/doctest.h>

#include <limits>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;

TEST_CASE(
    "haptic_tools: a body removed between substeps is felt to the end of the step, and no more") {
  StylusScene<double> scene({});
  add_table(scene.world);
  const BodyId box = add_box<double>(scene.world, 0.5);
  for (int i = 0; i < 60; ++i) scene.world.step();
  scene.world.open(scene.loop);
  const auto run = [&](int first, int last) {
    for (int i = first; i < last; ++i) scene.tick_at({0, 0, 0.047});
  };
  run(0, 16);
  scene.world.step(scene.loop);
  run(0, 8);
  CHECK(scene.loop.wrench(scene.tool).force.z() > 1);
  scene.world.remove_body(box);
  const BodyId successor = add_box<double>(scene.world, 0.5, 5);
  CHECK(successor.index == box.index);
  run(8, 16);
  CHECK(scene.loop.wrench(scene.tool).force.z() > 1);
  scene.world.step(scene.loop);
  // The body that now has its index got nothing.
  CHECK(scene.world.body(successor).twist.linear.z() == test::relative(-9.81 / 60));
  run(0, 16);
  CHECK(scene.loop.wrench(scene.tool).force.z() == 0);
  // A tool whose body is gone feels nothing either.
  scene.world.step(scene.loop);
  scene.world.remove_body(scene.body);
  run(0, 16);
  scene.world.step(scene.loop);
  run(0, 16);
  CHECK(scene.loop.wrench(scene.tool).force.isZero(0));
}

// Sensors of K_N and K_D over a wall at depth d feel K d + (K h + B) v: any velocity shows.
TEST_CASE(
    "haptic_tools: the velocity of a tool is that since the last substep, and none at first") {
  StylusScene<double> scene({});
  add_table(scene.world);
  const auto move = [&](double z) {
    scene.loop.move(scene.tool, {Quat<double>::Identity(), {0, 0, z}});
  };
  const double h = scene.substep_length();
  const double K = scene.stiffness();
  const double B = 16 * scene.def.normal_damping / scene.ray;
  const auto check_force = [&](double z, double v) {
    scene.loop.substep();
    CHECK(scene.loop.wrench(scene.tool).force.z() ==
          test::relative(K * (scene.ray - z) + (K * h + B) * v).epsilon(1e-9));
  };
  // Placed before and elsewhere at the first substep: it jumped.
  move(0.012);
  scene.world.open(scene.loop);
  move(0.006);
  check_force(0.006, 0);
  // However often it is asked for between two substeps.
  const double v = 0.1;
  move(0.006 - 0.7 * v * h);
  move(0.006 - v * h);
  move(0.006 - v * h);
  check_force(0.006 - v * h, v);
  // Not moved, it stands still.
  check_force(0.006 - v * h, 0);
  for (int i = 3; i < 16; ++i) scene.loop.substep();
  // Moved on between the last substep and the step: the step ends there.
  move(0.005);
  scene.world.step(scene.loop);
  CHECK(scene.world.pose(scene.body).translation.z() == test::relative(0.005));
  check_force(0.005, (0.006 - v * h - 0.005) / h);
  // A jump while the loop was closed is no velocity either.
  scene.world.open(scene.loop);
  move(0.008);
  check_force(0.008, 0);
}

TEST_CASE("haptic_tools: opened again it is like a new one, and forgets the substeps so far") {
  StylusScene<double> scene({.cast_every = 7});
  add_table(scene.world);
  const BodyId box = add_box<double>(scene.world, 0.2);
  const std::vector<std::byte> start = scene.world.snapshot();
  const auto run = [&] {
    BitHash bits;
    scene.loop.move(scene.tool, {Quat<double>::Identity(), wiggle(0.0)});
    scene.world.open(scene.loop);
    for (int i = 0; i < 320; ++i) {
      const Wrench<double>& reading = scene.tick_at(wiggle(i / 960.0));
      for (const double f : reading.force) bits.add(f);
      for (const double t : reading.torque) bits.add(t);
      if (scene.loop.substeps_done() == 16) scene.world.step(scene.loop);
    }
    return bits.value();
  };
  const std::uint64_t bits = run();
  CHECK(scene.loop.wrench(scene.tool).force.z() > 1);
  const std::uint64_t end = scene.world.state_hash();
  for (int i = 0; i < 5; ++i) scene.tick_at({0, 0, 0.045});
  CHECK(scene.loop.bodies()[0].impulse().force.z() < -0.01);
  scene.world.restore(start);
  scene.world.open(scene.loop);
  CHECK(scene.loop.substeps_done() == 0);
  CHECK(scene.loop.wrench(scene.tool).force.isZero(0));
  CHECK(scene.loop.reading(scene.pad).touching() == 0);
  CHECK(scene.loop.bodies()[0].id() == box);
  CHECK(scene.loop.bodies()[0].impulse().force.isZero(0));
  CHECK(run() == bits);
  CHECK(scene.world.state_hash() == end);
}

TEST_CASE("haptic_tools: tools that are new, wrong or gone") {
  StylusScene<double> scene({});
  add_table(scene.world);
  scene.world.open(scene.loop);
  const auto run = [&] {
    for (int i = 0; i < 16; ++i) scene.tick_at({0, 0, 0.006});
  };
  run();
  // One that nobody has moved yet stays where its body is.
  const BodyId late = scene.world.add_body({.motion = Motion::kinematic, .position = {1, 2, 3}});
  const ToolId tool = scene.loop.add_tool(late);
  scene.world.step(scene.loop);
  CHECK(scene.world.pose(late).translation == Vec3<double>(1, 2, 3));
  run();
  scene.loop.move(tool, {Quat<double>::Identity(), {1, 2, 2}});
  scene.world.step(scene.loop);
  CHECK((scene.world.pose(late).translation - Vec3<double>(1, 2, 2)).norm() < 1e-12);

  // A body that cannot be a tool is refused before anything is moved.
  auto wrong = scene.loop;
  for (int i = 0; i < 16; ++i) wrong.substep();
  wrong.move(scene.tool, {Quat<double>::Identity(), {0, 0, 0.1}});
  const ToolId box = wrong.add_tool(add_box<double>(scene.world, 0.5, 1));
  wrong.move(box, {Quat<double>::Identity(), {0, 0, 1}});
  const std::uint64_t hash = scene.world.state_hash();
  CHECK_THROWS_AS(scene.world.step(wrong), InvalidArgument);
  CHECK(scene.world.state_hash() == hash);
  CHECK(wrong.substeps_done() == 16);
  HapticLoop<double> nobody({});
  nobody.add_tool(BodyId{});
  CHECK_THROWS_AS(scene.world.open(nobody), InvalidArgument);

  // A tool whose body is gone is in nobody's way.
  scene.world.remove_body(late);
  scene.world.open(scene.loop);
  run();
  CHECK(scene.loop.wrench(scene.tool).force.z() ==
        test::relative(scene.stiffness() * (scene.ray - 0.006)));
  CHECK(scene.loop.wrench(tool).force.isZero(0));
  scene.world.step(scene.loop);
}

TEST_CASE("haptic_tools: patches are switched, changed and removed while they touch") {
  StylusScene<double> scene({});
  add_table(scene.world);
  // A second pad, twice as stiff, in the same place.
  PatchDef<double> stiff = StylusScene<double>::pad_def({});
  stiff.parameters.normal_stiffness *= 2;
  const ToolPatchId other = scene.loop.add_patch(scene.tool, stiff);
  scene.world.open(scene.loop);
  const auto run = [&](int first, int last) {
    for (int i = first; i < last; ++i) scene.tick_at({0, 0, 0.006});
    if (last == 16) scene.world.step(scene.loop);
  };
  // [-] What the tool feels, in pads of the first kind.
  const double one = scene.stiffness() * (scene.ray - 0.006);
  const auto pads = [&] { return scene.loop.wrench(scene.tool).force.z() / one; };
  // The loop is opened where the tool was, far away.
  run(0, 16);
  run(0, 16);
  CHECK(pads() == test::relative(3));
  CHECK(scene.loop.rays_cast() == 32);

  // Off at once, and without rays.
  run(0, 8);
  scene.loop.set_active(scene.pad, false);
  CHECK(scene.loop.reading(scene.pad).touching() == 0);
  CHECK(scene.loop.reading(scene.pad).total_normal() == 0);
  run(8, 16);
  CHECK(pads() == test::relative(2));
  CHECK(scene.loop.rays_cast() == 16);
  run(0, 16);
  CHECK(pads() == test::relative(2));
  // Off and on within one step.
  run(0, 8);
  scene.loop.set_active(other, false);
  scene.loop.set_active(other, true);
  run(8, 16);
  CHECK(pads() == 0);
  run(0, 16);
  CHECK(pads() == test::relative(2));
  // On again with the next step.
  run(0, 8);
  scene.loop.set_active(scene.pad, true);
  run(8, 16);
  CHECK(pads() == test::relative(2));
  run(0, 16);
  CHECK(pads() == test::relative(3));

  SensorParameters<double> parameters = stiff.parameters;
  parameters.normal_stiffness /= 4;
  scene.loop.set_parameters(other, parameters);
  run(0, 16);
  CHECK(pads() == test::relative(1.5));
  parameters.normal_stiffness = -1;
  CHECK_THROWS_AS(scene.loop.set_parameters(other, parameters), InvalidArgument);

  // What is left keeps its handle.
  run(0, 8);
  scene.loop.remove_patch(scene.pad);
  CHECK(!scene.loop.contains(scene.pad));
  CHECK(scene.loop.contains(other));
  run(8, 16);
  CHECK(pads() == test::relative(0.5));
  CHECK(scene.loop.reading(other).total_normal() == test::relative(0.5 * one));
  CHECK_THROWS_AS((void)scene.loop.reading(scene.pad), InvalidArgument);
  CHECK_THROWS_AS(scene.loop.remove_patch(scene.pad), InvalidArgument);
  CHECK_THROWS_AS(scene.loop.set_active(scene.pad, true), InvalidArgument);
  CHECK_THROWS_AS(scene.loop.set_parameters(scene.pad, stiff.parameters), InvalidArgument);
  const ToolPatchId next = scene.loop.add_patch(scene.tool, StylusScene<double>::pad_def({}));
  CHECK(next.index != scene.pad.index);
  CHECK(next.index != other.index);
  run(0, 16);
  run(0, 16);
  CHECK(pads() == test::relative(1.5));
  // A loop that is opened anew forgets substeps, not what it has.
  scene.world.open(scene.loop);
  run(0, 16);
  CHECK(pads() == test::relative(1.5));
}

TEST_CASE("haptic_tools: behind a coupling the hand feels sensors and spring in series") {
  StylusScene<double> scene({});
  add_table(scene.world);
  scene.world.open(scene.loop);
  const double h = scene.substep_length();
  CouplingDef<double> def{.stiffness = 400, .damping = 1};
  // The sensors' damping is that of 16 of them.
  def.mass = 1.5 * least_coupled_mass(def, scene.stiffness(), 16 * 0.005 / scene.ray, h);
  Transform<double> device{Quat<double>::Identity(), {0, 0, 0.02}};
  VirtualCoupling<double> coupling(def, device);
  scene.loop.move(scene.tool, coupling.pose());
  for (int step = 0; step < 120; ++step) {
    for (int i = 0; i < 16; ++i) {
      // Down at 14 mm/s for a second, then at rest 4 mm into the table.
      const bool is_down = device.translation.z() <= 0.006;
      const Twist<double> moved{Vec3<double>(0, 0, is_down ? 0 : -0.014), Vec3<double>::Zero()};
      scene.loop.substep();
      coupling.step(device, moved, scene.loop.wrench(scene.tool), h);
      device.translation += h * moved.linear;
      scene.loop.move(scene.tool, coupling.pose(), coupling.twist());
    }
    scene.world.step(scene.loop);
    // The world has the tool where the coupling has it.
    CHECK((scene.world.pose(scene.body).translation - coupling.pose().translation).norm() < 1e-12);
  }
  const double depth = scene.ray - device.translation.z();
  CHECK(depth == test::relative(0.004).epsilon(0.01));
  CHECK(coupling.wrench().force.z() ==
        test::relative(depth / (1 / def.stiffness + 1 / scene.stiffness())).epsilon(1e-6));
  CHECK(scene.loop.wrench(scene.tool).force.z() ==
        test::relative(coupling.wrench().force.z()).epsilon(1e-6));
}

TEST_CASE("haptic_tools: a patch that is refused is not added") {
  StylusScene<double> scene({});
  PatchDef<double> empty;
  CHECK_THROWS_AS(scene.loop.add_patch(scene.tool, empty), InvalidArgument);
  CHECK_THROWS_AS((void)scene.loop.reading(ToolPatchId{scene.pad.index + 1}), InvalidArgument);
  const auto next = scene.loop.add_patch(scene.tool, StylusScene<double>::pad_def({}));
  CHECK(next.index == scene.pad.index + 1);
}

// The box of the tool lies beside the origin of its body, and so does its centre of mass.
TEST_CASE("haptic_tools: rays that end in the tool's own shapes are refused by the world") {
  StylusScene<double> scene({});
  const BodyId body = scene.world.add_body({.motion = Motion::kinematic,
                                            .shapes = {{.shape = Box<double>{{0.01, 0.01, 0.01}},
                                                        .X_BS = {.translation = {0.1, 0, 0}}}}});
  REQUIRE(scene.world.body(body).center_B.x() == test::relative(0.1));
  const auto ray = [&](double x, double end) {
    PatchDef<double> def = StylusScene<double>::pad_def({});
    def.sensors = {};
    def.sensors.add(Vec3<double>(x, 0, 0.01), Vec3<double>(x, 0, end));
    return def;
  };
  const auto open = [&](const PatchDef<double>& def) {
    HapticLoop<double> loop({});
    loop.add_patch(loop.add_tool(body), def);
    scene.world.open(loop);
  };
  CHECK_NOTHROW(open(ray(0.1, 0.02)));
  CHECK_NOTHROW(open(ray(0, 0)));
  CHECK_THROWS_WITH_AS(open(ray(0.1, 0)), doctest::Contains("(0.1, 0, 0)"), InvalidArgument);
  PatchDef<double> inwards = ray(0.1, 0);
  inwards.may_point_inwards = true;
  CHECK_NOTHROW(open(inwards));

  // One that joins an open loop is refused by the step, which changes nothing.
  HapticLoop<double> loop({.substeps = 1});
  const ToolId tool = loop.add_tool(body);
  scene.world.open(loop);
  const ToolPatchId refused = loop.add_patch(tool, ray(0.1, 0));
  loop.substep();
  const std::uint64_t hash = scene.world.state_hash();
  CHECK_THROWS_AS(scene.world.step(loop), InvalidArgument);
  CHECK(scene.world.state_hash() == hash);
  CHECK(loop.substeps_done() == 1);
  // Without it the loop goes on.
  loop.remove_patch(refused);
  CHECK_NOTHROW(scene.world.step(loop));
}

TEST_CASE("haptic_tools: a step that one of the tools cannot make is refused for all of them") {
  StylusScene<double> scene({});
  const BodyId second = scene.world.add_body({.motion = Motion::kinematic});
  const ToolId far = scene.loop.add_tool(second);
  scene.world.open(scene.loop);
  const Quat<double> upright = Quat<double>::Identity();
  const auto substep = [&](double x) {
    // Its velocity is said to be zero, and is more than any within the step.
    scene.loop.move(far, {upright, {x, 0, 0}}, {});
    scene.tick_at({0, 0, 0.9});
  };
  for (int i = 0; i < 16; ++i) substep(largest_number<double>);
  const std::uint64_t hash = scene.world.state_hash();
  for (int i = 0; i < 2; ++i) {
    CHECK_THROWS_AS(scene.world.step(scene.loop), InvalidArgument);
    CHECK(scene.world.state_hash() == hash);
  }
  // Opened anew, the loop goes on.
  scene.world.open(scene.loop);
  for (int i = 0; i < 16; ++i) substep(0.1);
  scene.world.step(scene.loop);
  CHECK(scene.world.pose(second).translation.x() == test::relative(0.1));
  CHECK(scene.world.pose(scene.body).translation.z() == test::relative(0.9));
}

TEST_CASE("haptic_tools: bad input is refused by name, and changes nothing") {
  StylusScene<double> scene({});
  add_box<double>(scene.world, 0.5);
  CHECK_THROWS_AS(scene.loop.substep(), InvalidArgument);
  CHECK_THROWS_AS(scene.world.step(scene.loop), InvalidArgument);
  scene.world.open(scene.loop);
  scene.tick_at({0, 0, 0.049});
  const Wrench<double> before = scene.loop.wrench(scene.tool);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const Quat<double> upright = Quat<double>::Identity();
  CHECK_THROWS_AS(scene.loop.move(scene.tool, {upright, {0, nan, 0}}), InvalidArgument);
  CHECK_THROWS_AS(scene.loop.move(scene.tool, {Quat<double>(nan, 0, 0, 0), {0, 0, 0}}),
                  InvalidArgument);
  CHECK_THROWS_AS(scene.loop.move(scene.tool, {Quat<double>(2, 0, 0, 0), {0, 0, 0}}),
                  InvalidArgument);
  CHECK_THROWS_AS(scene.loop.move(scene.tool, {upright, {0, 0, 0}}, {{inf, 0, 0}, {0, 0, 0}}),
                  InvalidArgument);
  CHECK_THROWS_AS(scene.loop.move(ToolId{7}, {upright, {0, 0, 0}}), InvalidArgument);
  CHECK_THROWS_AS((void)scene.loop.wrench(ToolId{}), InvalidArgument);
  CHECK_THROWS_AS((void)scene.loop.reading(ToolPatchId{}), InvalidArgument);
  CHECK(scene.loop.wrench(scene.tool).force == before.force);
  // Too few substeps for a step, then too many.
  const std::uint64_t hash = scene.world.state_hash();
  CHECK_THROWS_AS(scene.world.step(scene.loop), InvalidArgument);
  CHECK(scene.world.state_hash() == hash);
  for (int i = 1; i < 16; ++i) scene.tick_at({0, 0, 0.049});
  CHECK_THROWS_AS(scene.loop.substep(), InvalidArgument);
  scene.world.step(scene.loop);

  CHECK_THROWS_AS((HapticLoop<double>({.substeps = 0})), InvalidArgument);
  CHECK_THROWS_AS((HapticLoop<double>({.max_speed = nan})), InvalidArgument);
  PatchDef<double> ambf = StylusScene<double>::pad_def({});
  ambf.options.law = Law::ambf;
  ambf.integration = Integration::explicit_;
  CHECK_THROWS_AS(scene.loop.add_patch(scene.tool, ambf), InvalidArgument);
  HapticLoop<double> other({});
  other.add_tool(add_box<double>(scene.world, 0.5, 1));
  CHECK_THROWS_AS(scene.world.open(other), InvalidArgument);
}
