/// @file
/// How long an explicit step may be, and what happens beyond.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"
#include "support/relative.hpp"

#include <bristle/sensors/placement.hpp>

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

PlateDef<double> explicit_plate(double static_friction, int per_side = 4) {
  PlateDef<double> def;
  def.integration = Integration::explicit_;
  def.per_side = per_side;
  def.parameters.static_friction = static_friction;
  def.parameters.normal_damping = 0;
  // No reset: what is unstable shall grow.
  def.parameters.breakaway_distance = 1;
  return def;
}

/// Stability limit of the plate at rest by the library.
double predicted_limit(PlateDef<double> def) {
  def.time_step = 1e-6;
  auto scene = make_plate<double>(def);
  scene.world.step();
  return scene.world.largest_stable_step(scene.patch);
}

/// Returns whether a nudge of 1e-9 m/s in all directions stays small for 3000 steps.
bool is_stable(PlateDef<double> def, double dt) {
  def.time_step = dt;
  auto scene = make_plate<double>(def);
  scene.world.step();
  scene.world.set_velocity(scene.plate, {{1e-9, 0.7e-9, 0.4e-9}, {5e-9, -8e-9, 3e-9}});
  for (int i = 0; i < 3000; ++i) {
    scene.world.step();
    const Twist<double>& twist = scene.world.body(scene.plate).twist;
    if (twist.linear.norm() + 0.1 * twist.angular.norm() > 1e-6) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("stability: the longest explicit step of Fig. 7 (R13)") {
  struct Row {
    double static_friction;
    double step;
  };
  for (const Row row : {Row{5e3, 8.897e-3}, Row{1e5, 2.002e-3}, Row{1e6, 0.6337e-3}}) {
    // Tangential mode with the lever gamma = 1 + m h^2 / I: k dt^2 + 2 c dt = 4 m.
    const double h = 6.934375e-3;
    const double inertia = 0.5 / 3 * (0.01 + 0.000025);
    const double gamma = 1 + 0.5 * h * h / inertia;
    const Mode<double> mode{0.5, row.static_friction * 0.5 * 9.81 * gamma, 1.6 * gamma};
    CHECK(mode.largest_stable_step() == test::relative(row.step).epsilon(0.01));
    CHECK(predicted_limit(explicit_plate(row.static_friction)) ==
          test::relative(row.step).epsilon(0.01));
  }
}

TEST_CASE("stability: the 6x6 criterion meets the simulation within 1 % (R20)") {
  for (const int per_side : {2, 4, 8}) {
    for (const double static_friction : {1e3, 5e4, 1e6}) {
      for (const double half_height : {0.005, 0.1}) {
        for (const double normal_damping : {0.0, 0.05}) {
          PlateDef<double> def = explicit_plate(static_friction, per_side);
          def.half_height = half_height;
          def.parameters.normal_damping = normal_damping;
          // Four sensors of 1 N cannot carry 4.9 N.
          def.parameters.normal_stiffness = per_side == 2 ? 4 : 1;
          const double limit = predicted_limit(def);
          INFO("n = ", per_side * per_side, ", mu_S = ", static_friction,
               ", K_D = ", normal_damping, ", half height = ", half_height, ", limit = ", limit);
          CHECK(is_stable(def, 0.99 * limit));
          CHECK_FALSE(is_stable(def, 1.01 * limit));
        }
      }
    }
  }
}

TEST_CASE("stability: locked axes leave the limit of what can still move") {
  const auto limit = [](bool can_sink, double damping) {
    World<double> world({.time_step = 1e-6});
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}, .filter = {1, 0, 0}});
    const BodyId plate = world.add_body(
        {.mass = 0.5,
         .shape = Box<double>{{0.1, 0.1, 0.005}},
         .position = {0, 0, 0.006},
         .locked = {.linear = {true, true, !can_sink}, .angular = {true, true, true}}});
    PatchDef<double> def;
    def.sensors = sensor_grid<double>({.center = {0, 0, -0.005},
                                       .side_u = {0, 0.2, 0},
                                       .side_v = {0.2, 0, 0},
                                       .count_u = 4,
                                       .count_v = 4});
    def.parameters = {1, damping, 5000, 0.1, 1e-3};
    const PatchId patch = world.add_patch(plate, def);
    world.step();
    return world.largest_stable_step(patch);
  };
  for (const double damping : {0.0, 0.05}) {
    // The normal mode alone: n K_N / L against m, with n K_D / L.
    const Mode<double> mode{0.5, 16 / 0.01, 16 * damping / 0.01};
    CHECK(limit(true, damping) == test::relative(mode.largest_stable_step()).epsilon(1e-9));
    CHECK(limit(false, damping) == infinity<double>);
  }
}

TEST_CASE("stability: a damping of 50 N s, read as a rate, throws an explicit plate (R14)") {
  // How far it flies depends on where in its growth it leaves the sensors, and the hard contact.
  // a + 2 b = n (K_N dt^2 + 2 K_D dt) / (L m) = 80, 320, 2000 for n = 4, 16, 100; the limit is 4.
  struct Row {
    int per_side;
    double height;
  };
  for (const Row row : {Row{2, 5}, Row{4, 100}, Row{10, 500}}) {
    double highest = 0;
    // Each step overshoots the last by a + 2 b; the last kick before the plate leaves the sensors
    // depends on where the growth began, so the table has the worst of several starts.
    for (const double drop : {1e-9, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3}) {
      PlateDef<double> def;
      def.per_side = row.per_side;
      def.parameters.normal_damping = 50;
      def.integration = Integration::explicit_;
      // Four sensors of 1 N cannot carry the plate; it rests on hard contact besides.
      def.has_contact = row.per_side == 2;
      def.drop = drop;
      auto scene = make_plate<double>(def);
      for (int i = 0; i < 1000; ++i) {
        scene.world.step();
        highest = std::max(highest, scene.position().z());
      }
      CHECK(scene.world.report().frozen_bodies == 0);
    }
    INFO("n = ", row.per_side * row.per_side);
    CHECK(highest > row.height);
  }
}

TEST_CASE("stability: the same plate rests under implicit and automatic integration (R14)") {
  for (const double dt : {1e-3, 1.0 / 60}) {
    for (const Integration integration : {Integration::implicit, Integration::automatic}) {
      PlateDef<double> def;
      def.parameters.normal_damping = 50;
      def.integration = integration;
      def.time_step = dt;
      def.drop = 1e-6;
      auto scene = make_plate<double>(def);
      scene.run(1);
      // A damper this strong creeps back from 1 um at K_N / K_D = 1 / 50 s.
      CHECK(std::abs(scene.position().z() - 6.934375e-3) < 1.1e-6);
      CHECK(std::abs(scene.velocity().z()) < 1e-5);
    }
  }
}

TEST_CASE("stability: automatic integration is explicit where that is safe, implicit elsewhere") {
  // Lambda = dt^2 k / m with k = mu_S m g: 0.5 is crossed at dt = sqrt(0.5 / (5000 * 9.81)) = 3.2
  // ms.
  PlateDef<double> def;
  def.integration = Integration::automatic;
  def.parameters.normal_damping = 0;
  def.time_step = 1e-3;
  auto calm = make_plate<double>(def);
  calm.run(0.1);
  CHECK(calm.world.report().explicit_pairs == 1);
  CHECK(calm.world.report().implicit_pairs == 0);
  def.time_step = 5e-3;
  auto stiff = make_plate<double>(def);
  stiff.run(0.1);
  CHECK(stiff.world.report().explicit_pairs == 0);
  CHECK(stiff.world.report().implicit_pairs == 1);
}

TEST_CASE("stability: automatic integration sees how easily a body turns about its patch") {
  // The same pad under bodies of 1 kg and ever smaller inertia: what explicit steps would make turn
  // faster and faster is integrated implicitly, and comes to rest.
  for (const double inertia : {1e-2, 1e-3, 1e-4, 1e-5}) {
    CAPTURE(inertia);
    WorldDef<double> world_def;
    world_def.time_step = 1e-3;
    World<double> world(world_def);
    BodyDef<double> floor;
    floor.motion = Motion::fixed;
    floor.shape = HalfSpace<double>{};
    world.add_body(floor);
    BodyDef<double> def;
    def.mass = 1;
    def.inertia = Mat3<double>(inertia * Mat3<double>::Identity());
    def.position = {0, 0, 0.00485};
    def.angular_velocity = {1e-3, 0, 0};
    const BodyId body = world.add_body(def);
    PatchDef<double> pad;
    SensorGridDef<double> grid;
    grid.side_u = {0, 0.2, 0};
    grid.side_v = {0.2, 0, 0};
    grid.count_u = grid.count_v = 4;
    pad.sensors = sensor_grid(grid);
    pad.parameters = {40, 0, 2000, 0.1, 1e-3};
    world.add_patch(body, pad);
    double fastest = 0;
    for (int i = 0; i < 2000; ++i) {
      world.step();
      fastest = std::max(fastest, world.body(body).twist.angular.norm());
    }
    CHECK(fastest < 1.1e-3);
  }
}

TEST_CASE("stability: bodies that only share a floor do not change each other's integration") {
  const auto first_after = [](int count) {
    World<double> world({.time_step = 1e-3});
    BodyDef<double> floor;
    floor.motion = Motion::fixed;
    floor.shape = HalfSpace<double>{};
    world.add_body(floor);
    BodyId first;
    for (int i = 0; i < count; ++i) {
      BodyDef<double> def;
      def.mass = 0.5;
      def.shape = Box<double>{{0.1, 0.1, 0.005}};
      def.filter.mask = 0;
      def.position = {10.0 * i, 0, 0.0071};
      const BodyId body = world.add_body(def);
      if (i == 0) first = body;
      SensorGridDef<double> grid;
      grid.center = {0, 0, -0.005};
      grid.side_u = {0, 0.2, 0};
      grid.side_v = {0.2, 0, 0};
      grid.count_u = grid.count_v = 4;
      PatchDef<double> pad;
      pad.sensors = sensor_grid(grid);
      pad.parameters = {1, 0.01, 5000, 0.1, 1e-3};
      world.add_patch(body, pad);
    }
    for (int i = 0; i < 50; ++i) world.step();
    CHECK(world.report().implicit_pairs == 0);
    return world.pose(first).translation;
  };
  CHECK(first_after(1) == first_after(30));
}
