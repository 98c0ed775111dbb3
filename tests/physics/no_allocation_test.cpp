/// @file
/// A warmed-up step allocates nothing.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/drops.hpp"
#include "scenes/grasp.hpp"
#include "scenes/medley.hpp"
#include "scenes/pile.hpp"
#include "scenes/plate.hpp"
#include "scenes/skin.hpp"
#include "scenes/stack.hpp"
#include "scenes/stylus.hpp"
#include "support/counted_new.hpp"

#include <bristle/core/thread_pool.hpp>

#include <doctest/doctest.h>

#include <array>

using namespace bristle;
using namespace bristle::scenes;

namespace {

/// Allocations in `steps` steps after `warm_up` of them.
template <typename World>
std::size_t allocations_of(World& world, int warm_up, int steps) {
  for (int i = 0; i < warm_up; ++i) world.step();
  const std::size_t before = test::allocations;
  for (int i = 0; i < steps; ++i) world.step();
  return test::allocations - before;
}

}  // namespace

TEST_CASE("no_allocation: the counter counts") {
  const std::size_t before = test::allocations;
  // Called by name, so that the compiler may not leave the pair out.
  ::operator delete(::operator new(8));
  CHECK(test::allocations == before + 1);
}

TEST_CASE_TEMPLATE("no_allocation: plates that hold, slip and slide", S, float, double) {
  for (const Integration integration :
       {Integration::explicit_, Integration::implicit, Integration::automatic}) {
    for (const S angle : {S(0.3), S(1.4)}) {
      PlateDef<S> def;
      def.integration = integration;
      def.incline = angle;
      def.has_contact = true;
      auto scene = make_plate<S>(def);
      CHECK(allocations_of(scene.world, 20, 300) == 0);
    }
  }
}

TEST_CASE_TEMPLATE("no_allocation: a gripper with drives, joints and pads", S, float, double) {
  for (const S finger_mass : {S(0), S(0.5)}) {
    GraspDef<S> def;
    def.finger_mass = finger_mass;
    auto scene = make_grasp<S>(def);
    CHECK(allocations_of(scene.world, 20, 300) == 0);
  }
}

TEST_CASE_TEMPLATE("no_allocation: a chain of joints of all kinds", S, float, double) {
  // Integrated as a mechanism, and with a motor, by the solver.
  for (const MotorMode mode : {MotorMode::none, MotorMode::spring}) {
    World<S> world(WorldDef<S>{.time_step = S(1.0 / 240)});
    BodyId above = world.add_body({.motion = Motion::fixed});
    for (const JointKind kind : {JointKind::revolute, JointKind::ball, JointKind::cone_twist,
                                 JointKind::prismatic, JointKind::six_dof, JointKind::fixed}) {
      BodyDef<S> link;
      link.mass = S(1);
      link.shape = Box<S>{{S(0.02), S(0.02), S(0.05)}};
      link.position = world.pose(above).translation - Vec3<S>(S(0.03), 0, S(0.1));
      const BodyId body = world.add_body(link);
      JointDef<S> joint;
      joint.kind = kind;
      joint.body_a = above;
      joint.body_b = body;
      joint.X_BJ.translation = Vec3<S>(S(0.03), 0, S(0.1));
      if (kind == JointKind::cone_twist) joint.swing_limit = S(0.5);
      if (kind == JointKind::six_dof) joint.bushing.stiffness.setConstant(S(2e3));
      if (kind == JointKind::revolute || kind == JointKind::prismatic) {
        joint.spring = {S(50), S(0.5), S(0)};
        joint.motor = {mode, S(0.1), S(20)};
        joint.motor.stiffness = S(30);
      }
      world.add_joint(joint);
      above = body;
    }
    CHECK(allocations_of(world, 120, 300) == 0);
  }
}

TEST_CASE("no_allocation: a stack on hard contact, and one that is swept on sensors") {
  StackDef<double> def;
  auto hard = make_stack<double>(def);
  CHECK(allocations_of(hard.world, 60, 300) == 0);
  def.by = StackBy::sensors;
  def.solver.max_direct_work = 0;
  auto swept = make_stack<double>(def);
  CHECK(allocations_of(swept.world, 60, 300) == 0);
}

TEST_CASE_TEMPLATE("no_allocation: a bit of everything", S, float, double) {
  // Warm once the plates have come to rest: until then new shapes of islands turn up.
  auto scene = make_medley<S>();
  CHECK(allocations_of(scene.world, 500, 300) == 0);
}

TEST_CASE_TEMPLATE("no_allocation: shapes of all kinds on a table and on its mesh", S, float,
                   double) {
  // Warm after they have met the table with most points.
  for (const DropDef<S>& def : drops<S>()) {
    CAPTURE(def.name);
    for (const bool is_mesh : {false, true}) {
      auto drop = make_drop<AnalyticBackend>(def, is_mesh);
      CHECK(allocations_of(drop.world, 240, 240) == 0);
    }
  }
}

TEST_CASE("no_allocation: a pile on a pool of threads") {
  ThreadPool pool(3);
  WorldDef<double> def;
  def.parallel_for = pool.hook();
  auto pile = make_pile<double>(def);
  // Warm once the pile has settled; until then it finds larger islands and more contacts.
  CHECK(allocations_of(pile.world, 700, 300) == 0);
}

TEST_CASE("no_allocation: ranges of a large patch on a pool of threads") {
  ThreadPool pool(3);
  WorldDef<double> def;
  def.parallel_for = pool.hook();
  for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
    for (const bool in_rows : {true, false}) {
      auto skin = make_skin<double>(def, integration, 1, in_rows);
      CHECK(allocations_of(skin.world, 100, 100) == 0);
    }
  }
}

TEST_CASE("no_allocation: falling asleep, sleeping and waking") {
  WorldDef<double> def;
  def.sleep.time = 0.1;
  auto scene = make_medley<double>(def);
  const auto wake_and_rest = [&] {
    for (const BodyId id : scene.bodies) scene.world.wake(id);
    int awake = 0;
    for (int i = 0; i < 300; ++i) {
      scene.world.step();
      if (scene.world.report().awake_bodies > 0) ++awake;
    }
    CHECK(awake > 10);
    CHECK(scene.world.report().awake_bodies == 0);
  };
  for (int i = 0; i < 2000; ++i) scene.world.step();
  wake_and_rest();
  const std::size_t before = test::allocations;
  for (int k = 0; k < 3; ++k) wake_and_rest();
  CHECK(test::allocations == before);
}

TEST_CASE_TEMPLATE("no_allocation: substeps of a haptic loop, and the steps between them", S, float,
                   double) {
  for (const std::uint32_t cast_every : {1u, 5u}) {
    StylusScene<S> scene({.cast_every = cast_every});
    scene.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
    scene.world.add_body({.mass = S(0.2),
                          .shape = Box<S>{{S(0.02), S(0.02), S(0.02)}},
                          .position = {0, 0, S(0.02)}});
    scene.world.open(scene.loop);
    // Comes, presses, drags and leaves.
    const auto run = [&](int steps) {
      for (int i = 0; i < 16 * steps; ++i) {
        const S turn = S(0.01) * S(i);
        scene.tick_at({S(0.003) * std::sin(turn), 0, S(0.05) + S(0.004) * std::sin(S(2) * turn)});
        if (scene.loop.substeps_done() == scene.def.substeps) scene.world.step(scene.loop);
      }
    };
    run(60);
    const std::size_t before = test::allocations;
    run(60);
    CHECK(test::allocations == before);
    CHECK(scene.world.body(scene.body).twist.linear.norm() > S(0));
  }
}

TEST_CASE("no_allocation: what held begins to slide, and holds again") {
  World<double> world;
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  std::array<BodyId, 2> boxes{};
  for (const std::size_t k : {0u, 1u}) {
    boxes[k] = world.add_body({.mass = 1.0,
                               .shape = Box<double>{{0.05, 0.05, 0.05}},
                               .position = {0.11 * static_cast<double>(k), 0, 0.05}});
  }
  // With a joint in it the island is always solved by factorisation.
  world.add_joint({.kind = JointKind::ball,
                   .body_a = boxes[0],
                   .body_b = boxes[1],
                   .X_AJ = {.translation = {0.055, 0, 0}},
                   .X_BJ = {.translation = {-0.055, 0, 0}}});
  const auto pull = [&](double force) {
    for (int i = 0; i < 50; ++i) {
      world.apply_force(boxes[0], {force, 0, 0}, world.pose(boxes[0]).translation);
      world.step();
    }
  };
  for (const double held : {0.0, 1.0, 3.0}) pull(held);
  REQUIRE(world.body(boxes[0]).twist.linear.norm() < 1e-6);
  const std::size_t before = test::allocations;
  pull(20);
  CHECK(test::allocations == before);
  CHECK(world.body(boxes[0]).twist.linear.x() > 0.5);
  pull(0);
  CHECK(test::allocations == before);
}

TEST_CASE("no_allocation: queries and readings") {
  auto scene = make_grasp<double>({});
  scene.run(0.05);
  std::vector<double> points(6 * scene.world.patch(scene.pads[0]).size());
  double sum = 0;
  const std::size_t before = test::allocations;
  sum += scene.world.reading(scene.pads[0]).total_normal();
  scene.world.taxel_points(scene.pads[0], points);
  CHECK(test::allocations == before);
  CHECK(sum > 0);
}

TEST_CASE_TEMPLATE("no_allocation: a sensor takes 16 numbers of a copy and of a snapshot", S, float,
                   double) {
  // Under load, so that all contacts of a step are there. The difference leaves out what a world
  // has besides, and the last packet.
  struct Size {
    double sensors = 0, copy = 0, snapshot = 0;
  };
  const auto size_of = [](int per_side) {
    PlateDef<S> def;
    def.per_side = per_side;
    auto scene = make_plate<S>(def);
    for (int i = 0; i < 3; ++i) scene.world.step();
    const auto sensors = static_cast<double>(scene.world.patch(scene.patch).size());
    REQUIRE(scene.world.reading(scene.patch).touching() == scene.world.patch(scene.patch).size());
    const std::size_t before = test::allocated_bytes;
    const World<S> copy(scene.world);
    const auto bytes = static_cast<double>(test::allocated_bytes - before);
    return Size{sensors, bytes, static_cast<double>(copy.snapshot().size())};
  };
  const Size large = size_of(100), small = size_of(20);
  const double sensors = large.sensors - small.sensors;
  // Measured: 113 and 61 bytes.
  CHECK((large.copy - small.copy) / sensors < 16 * sizeof(S));
  CHECK((large.snapshot - small.snapshot) / sensors < 16 * sizeof(S));
}
