/// @file
/// A haptic loop: what its substeps give the bodies, and how it predicts them.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/stylus.hpp"
#include "support/relative.hpp"

#include <bristle/core/thread_pool.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

/// Jabs a box of 40 mm from above, within one step, and checks that steps leave it where the
/// substeps had it, to `tolerance` [m].
void check_jab(StylusScene<double>& scene, BodyId box, double tolerance) {
  double most = 0;
  for (int step = 0; step < 8; ++step) {
    for (int i = 0; i < 16; ++i) {
      const double depth = step == 2 && i > 3 && i < 9 ? 0.004 : -0.005;
      const double top = scene.loop.bodies().empty()
                             ? scene.world.pose(box).translation.z() + 0.02
                             : scene.loop.bodies()[0].body().center_pose.translation.z() + 0.02;
      most = std::max(most, scene.tick_at({0, 0, top + 0.01 - depth}).force.z());
    }
    const bool is_near = !scene.loop.bodies().empty();
    const Vec3<double> predicted =
        is_near ? scene.loop.bodies()[0].body().center_pose.translation : Vec3<double>::Zero();
    scene.world.step(scene.loop);
    if (is_near) CHECK((scene.world.pose(box).translation - predicted).norm() < tolerance);
  }
  CHECK(most > 1);
  CHECK(scene.world.body(box).twist.linear.z() < -0.05);
}

}  // namespace

// Tool and body exchange one sum: of readings, of wrenches, and of the body's momentum.
TEST_CASE_TEMPLATE("haptic_loop: impulses of the substeps are the momentum of the body", S, float,
                   double) {
  StylusScene<S> scene({.gravity = S(0)});
  const BodyId box = add_box<S>(scene.world, S(0.3));
  scene.world.open(scene.loop);
  Vec3<S> reading = Vec3<S>::Zero();
  Vec3<S> read = Vec3<S>::Zero();
  S turnover = S(0);
  S time = S(0);
  for (int step = 0; step < 12; ++step) {
    for (int i = 0; i < 16; ++i, time += scene.substep_length()) {
      const Vec3<S> at(S(0.003) + S(0.02) * time, 0, S(0.0495) - S(0.02) * time);
      const Vec3<S> force = scene.tick_at(at).force;
      reading += scene.substep_length() * force;
      read += scene.substep_length() * scene.loop.reading(scene.pad).wrench.force;
      turnover += scene.substep_length() * force.norm();
    }
    const Wrench<S> given =
        scene.loop.bodies().empty() ? Wrench<S>{} : scene.loop.bodies()[0].impulse();
    const Twist<S> before = scene.world.body(box).twist;
    const Vec3<S> angular_before = scene.world.body(box).angular_momentum();
    scene.world.step(scene.loop);
    const Vec3<S> gained = S(0.3) * (scene.world.body(box).twist.linear - before.linear);
    const Vec3<S> turned = scene.world.body(box).angular_momentum() - angular_before;
    const S round_off = Tolerance<S>::round_off() * (turnover + S(1e-3));
    CHECK((gained - given.force).norm() <= round_off);
    CHECK((turned - given.torque).norm() <= S(0.1) * round_off);
  }
  REQUIRE(reading.z() > S(0.001));
  const S round_off = S(12 * 16) * Tolerance<S>::round_off() * turnover;
  CHECK((reading + S(0.3) * scene.world.body(box).twist.linear).norm() <= round_off);
  CHECK((reading - read).norm() <= round_off);
}

// A body that nothing else pushes ends the step where the substeps had it, whenever within the step
// they pushed it. It does not turn: the stylus pushes through its centre.
TEST_CASE("haptic_loop: a free body is where the substeps predicted it") {
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    for (const double gravity : {0.0, 9.81}) {
      StylusScene<double> scene({.gravity = gravity, .integrator = integrator});
      const BodyId box = add_box<double>(scene.world, 0.05);
      scene.world.open(scene.loop);
      check_jab(scene, box, 1e-13);
    }
  }
}

// Sensors of the world and drives make the step move a body by its velocity at the end, also where
// they are too weak for their forces to be seen: 10 nN on 50 g for a tenth of a second is 1 nm.
TEST_CASE("haptic_loop: a body that weak sensors or a weak drive act on is where predicted") {
  constexpr double weak = 1e-8;
  SUBCASE("sensors") {
    StylusScene<double> scene({.gravity = 0.0});
    const BodyId box = add_box<double>(scene.world, 0.05);
    const BodyId below = scene.world.add_body({.motion = Motion::fixed, .position = {0, 0, -0.1}});
    PatchDef<double> pad;
    pad.sensors.add({0, 0, 0}, {0, 0, 1}, 0.11);
    pad.parameters = {weak, 0, 0, 0, 1e-3};
    scene.world.add_patch(below, pad);
    scene.world.step();
    scene.world.open(scene.loop);
    check_jab(scene, box, 2e-9);
  }
  SUBCASE("a motor") {
    StylusScene<double> scene({.gravity = 0.0});
    const BodyId box = add_box<double>(scene.world, 0.05);
    JointDef<double> slide;
    slide.kind = JointKind::prismatic;
    slide.body_a = scene.world.add_body({.motion = Motion::fixed});
    slide.body_b = box;
    // Along z.
    slide.X_AJ.rotation = slide.X_BJ.rotation =
        exp_rotation<double>(-0.5 * std::numbers::pi * Vec3<double>::UnitY());
    slide.X_AJ.translation = {0, 0, 0.02};
    slide.motor = {MotorMode::velocity, 1, weak, 1};
    scene.world.add_joint(slide);
    scene.world.step();
    scene.world.open(scene.loop);
    check_jab(scene, box, 2e-9);
  }
}

// At rest on a table a box does not give way. The loop's force is then the sensors' own closed
// form: F = n K_N e, also within the step in which the force changes.
TEST_CASE_TEMPLATE("haptic_loop: a box on a table stands firm within the step", S, float, double) {
  for (const S mass : {S(0.005), S(0.5)}) {
    StylusScene<S> scene({.static_friction = S(0), .sliding_friction = S(0)});
    add_table(scene.world);
    const BodyId box = add_box<S>(scene.world, mass);
    for (int i = 0; i < 60; ++i) scene.world.step();
    scene.loop.move(scene.tool, {Quat<S>::Identity(), {0, 0, S(0.05)}});
    scene.world.open(scene.loop);
    const S top = scene.world.pose(box).translation.z() + S(0.02);
    for (int step = 0; step < 30; ++step) {
      for (int i = 0; i < 16; ++i) {
        // 5 mm down in half a second. The force is that at the end of the substep: of the depth
        // there and of the damper.
        const S time = (S(step) + S(i) / S(16)) * scene.def.time_step;
        const S speed = S(0.01);
        const S z = S(0.05) - speed * time;
        const S force = scene.tick_at({0, 0, z}).force.z();
        if (step == 0) continue;
        const S depth = (top + scene.ray - z) + speed * scene.substep_length();
        const S expected =
            scene.stiffness() * depth + S(16) * scene.def.normal_damping * speed / scene.ray;
        CHECK(static_cast<double>(force) ==
              test::relative(static_cast<double>(expected)).epsilon(2e-3));
      }
      scene.world.step(scene.loop);
    }
  }
}

// Two stiff fingers of 80 kN/m on a gram: explicit forces would need substeps of 0.1 ms.
TEST_CASE_TEMPLATE("haptic_loop: two stiff fingers hold a light body at any rate", S, float,
                   double) {
  StylusDef<S> def;
  def.gravity = S(0);
  def.normal_stiffness = S(50);
  def.normal_damping = S(0.01);
  for (const std::uint32_t substeps : {1u, 4u, 64u}) {
    def.substeps = substeps;
    StylusScene<S> scene(def);
    const BodyId other = scene.world.add_body({.motion = Motion::kinematic});
    const ToolId below = scene.loop.add_tool(other);
    scene.loop.add_patch(below, StylusScene<S>::pad_def(def));
    const BodyId box = add_box<S>(scene.world, S(0.001), S(0.0002));
    const Quat<S> upside_down(0, 1, 0, 0);
    const S depth = S(0.001);
    for (int step = 0; step < 120; ++step) {
      if (step == 0) {
        scene.loop.move(scene.tool, {Quat<S>::Identity(), {0, 0, S(0.05) - depth}});
        scene.loop.move(below, {upside_down, {0, 0, S(-0.01) + depth}});
        scene.world.open(scene.loop);
      }
      for (std::uint32_t i = 0; i < substeps; ++i) {
        scene.loop.move(below, {upside_down, {0, 0, S(-0.01) + depth}});
        scene.tick_at({0, 0, S(0.05) - depth});
      }
      scene.world.step(scene.loop);
    }
    // n K_N depth / L on either side, the box between them and at rest.
    const double expected = static_cast<double>(scene.stiffness() * depth);
    const double epsilon = sizeof(S) == 4 ? 1e-3 : 1e-6;
    CHECK(static_cast<double>(scene.loop.wrench(scene.tool).force.z()) ==
          test::relative(expected).epsilon(epsilon));
    CHECK(static_cast<double>(scene.loop.wrench(below).force.z()) ==
          test::relative(-expected).epsilon(epsilon));
    CHECK(static_cast<double>(scene.world.body(box).twist.linear.norm()) < epsilon);
  }
}

// On a flat face the plane that a ray met is the face: casting once a step changes nothing but
// rounding. On a ball of radius R it is off by d^2 / 2R after a slide by d.
TEST_CASE("haptic_loop: rays once a step instead of once a substep") {
  for (const bool is_ball : {false, true}) {
    std::vector<double> forces[2];
    std::uint64_t rays[2] = {0, 0};
    for (const int k : {0, 1}) {
      StylusScene<double> scene({.cast_every = k == 0 ? 1u : 16u});
      const double radius = 0.1;
      scene.world.add_body({.motion = Motion::fixed,
                            .shape = is_ball ? OptionalShape<double>(Sphere<double>{radius})
                                             : OptionalShape<double>(Box<double>{{0.1, 0.1, 0.1}}),
                            .position = {0, 0, -0.06}});
      scene.loop.move(scene.tool, {Quat<double>::Identity(), wiggle(0.0)});
      scene.world.open(scene.loop);
      double time = 0;
      for (int step = 0; step < 60; ++step) {
        for (int i = 0; i < 16; ++i, time += scene.substep_length()) {
          forces[k].push_back(scene.tick_at(wiggle(time)).force.z());
          rays[k] += scene.loop.rays_cast();
        }
        scene.world.step(scene.loop);
      }
    }
    CHECK(rays[0] > 900 * 16);
    CHECK(rays[1] < rays[0] / 8);
    double worst = 0;
    for (std::size_t i = 0; i < forces[0].size(); ++i) {
      worst = std::max(worst, std::abs(forces[0][i] - forces[1][i]));
    }
    // It slides by d in a step: the springs are off by K d^2 / 2R, the dampers by B v d / R, as the
    // normal is off by d / R. The slope of the ball under the pad makes it a little more.
    const double speed = 3e-4 * 40 + 2e-4 * 31;
    const double d = speed / 60;
    const double B = 16 * 0.005 / 0.01;
    CHECK(worst <= (is_ball ? 1.2 * (800 * d * d / (2 * 0.1) + B * speed * d / 0.1) : 1e-9));
  }
}

// The same hand, sensors and box in a world that steps at the rate of the substeps, with the stylus
// a body like any other, is what the loop stands in for.
TEST_CASE("haptic_loop: close to a world that steps as often as the loop substeps") {
  const auto make_box = [](World<double>& world) {
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    return world.add_body({.mass = 0.2,
                           .shape = Box<double>{{0.03, 0.03, 0.02}},
                           .material = {.friction = 0.3},
                           .position = {0, 0, 0.02}});
  };
  // Presses, wiggles and drags the box along.
  const auto at = [](double time) -> Vec3<double> {
    return wiggle(time) + Vec3<double>(0.02 * std::max(time - 0.3, 0.0), 0, 0);
  };
  constexpr int substeps = 960;
  std::vector<Vec3<double>> expected;
  World<double> world({.time_step = 1.0 / 960});
  const BodyId box = make_box(world);
  const BodyId stylus = world.add_body({.motion = Motion::kinematic});
  PatchDef<double> pad = StylusScene<double>::pad_def({});
  pad.integration = Integration::implicit;
  const PatchId patch = world.add_patch(stylus, pad);
  for (int i = 0; i < substeps; ++i) {
    const double t = i / 960.0;
    world.set_pose(stylus, {Quat<double>::Identity(), at(t)});
    world.set_velocity(stylus, {960 * (at(t) - at(std::max(t - 1.0 / 960, 0.0))), {0, 0, 0}});
    world.step();
    expected.push_back(world.reading(patch).wrench.force);
  }
  REQUIRE(world.pose(box).translation.x() > 0.005);
  // The box slips under bristles that slip, whose saw-teeth come at other times: a few per cent at
  // any rate. At 60 Hz the box learns a step late that it slides, in 1/60 s by a few tenths of 3 N.
  struct Case {
    std::uint32_t substeps;
    double force_error;
    double place_error;
  };
  for (const Case& c : {Case{16, 0.15, 0.1}, Case{4, 0.04, 0.01}, Case{1, 0.04, 0.01}}) {
    CAPTURE(c.substeps);
    StylusScene<double> scene({.time_step = c.substeps / 960.0, .substeps = c.substeps});
    const BodyId part = make_box(scene.world);
    scene.loop.move(scene.tool, {Quat<double>::Identity(), at(0)});
    scene.world.open(scene.loop);
    double squares = 0;
    double sum = 0;
    for (int i = 0; i < substeps; ++i) {
      const Vec3<double>& wanted = expected[static_cast<std::size_t>(i)];
      squares += (scene.tick_at(at(i / 960.0)).force - wanted).squaredNorm();
      sum += wanted.squaredNorm();
      if (scene.loop.substeps_done() == c.substeps) scene.world.step(scene.loop);
    }
    CHECK(std::sqrt(squares / sum) < c.force_error);
    CHECK(scene.world.pose(part).translation.x() ==
          test::relative(world.pose(box).translation.x()).epsilon(c.place_error));
  }
}

// The tip of a rod that spins about its middle gets 83 mm further in a step; its middle stays.
TEST_CASE("haptic_loop: what swings in within a step is felt") {
  StylusScene<double> scene({.gravity = 0.0});
  const BodyId rod =
      scene.world.add_body({.motion = Motion::kinematic, .shape = Box<double>{{0.5, 0.01, 0.01}}});
  scene.world.set_velocity(rod, {{0, 0, 0}, {0, 0, 10}});
  const Vec3<double> at(0.48, 0.06, 0.016);
  scene.loop.move(scene.tool, {Quat<double>::Identity(), at});
  scene.world.open(scene.loop);
  double first = 0;
  double most = 0;
  for (int i = 0; i < 16; ++i) {
    const double force = scene.tick_at(at).force.z();
    if (i == 0) first = force;
    most = std::max(most, force);
  }
  CHECK(first == 0);
  // 4 mm deep; all sensors are over the rod at once.
  CHECK(most > 0.9 * scene.stiffness() * 0.004);
}

TEST_CASE(
    "haptic_loop: a copy and a snapshot go on with the same bits, for any number of workers") {
  const auto run = [](StylusScene<double>& scene, int first, int last) {
    std::vector<std::uint64_t> bits;
    BitHash forces;
    for (int step = first; step < last; ++step) {
      for (int i = 0; i < 16; ++i) {
        const double time = (step + i / 16.0) / 60;
        const Wrench<double>& reading = scene.tick_at(wiggle(time));
        for (const double f : reading.force) forces.add(f);
        for (const double t : reading.torque) forces.add(t);
      }
      scene.world.step(scene.loop);
      bits.push_back(scene.world.state_hash());
      bits.push_back(forces.value());
    }
    return bits;
  };
  const auto make = [](const ParallelFor& parallel_for) {
    StylusScene<double> scene({.cast_every = 7, .parallel_for = parallel_for});
    add_table(scene.world);
    add_box<double>(scene.world, 0.2);
    // Enough others that the world shares its work.
    for (int i = 0; i < 100; ++i) {
      scene.world.add_body(
          {.mass = 0.1,
           .shape = Sphere<double>{.radius = 0.05},
           .position = {1 + 0.09 * (i % 5), 0.09 * (i / 5 % 5), 0.06 + 0.1 * (i / 25)}});
    }
    scene.world.open(scene.loop);
    return scene;
  };
  auto scene = make(serial_for);
  run(scene, 0, 20);
  const std::vector<std::byte> snapshot = scene.world.snapshot();
  const auto loop = scene.loop;
  const auto expected = run(scene, 20, 40);
  scene.world.restore(snapshot);
  scene.loop = loop;
  CHECK(run(scene, 20, 40) == expected);
  ThreadPool pool(3);
  auto shared = make(pool.hook());
  run(shared, 0, 20);
  CHECK(run(shared, 20, 40) == expected);
}
