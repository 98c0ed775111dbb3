/// @file
/// Two fingers hold a part by their sensors alone.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/grasp.hpp"

#include "scenes/plate.hpp"
#include "support/integrations.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

using namespace bristle;
using bristle::test::both_integrations;
using namespace bristle::scenes;

namespace {}  // namespace

TEST_CASE("grasp: a part between still fingers sags by m g / (mu_S sum F_N) (R12)") {
  const double sag = 0.5 * 9.81 / (1000 * 2 * 10);
  CHECK(sag == test::relative(245.250e-6).epsilon(1e-9));
  for (const double dt : {1e-3, 1.0 / 60}) {
    for (const double static_friction : {1e3, 1e5}) {
      for (const Integration integration : both_integrations) {
        // k / m = mu_S sum F_N / m: 4e4 (dt < 10 ms) and 4e6 (dt < 1 ms).
        if (integration == Integration::explicit_ && (dt > 5e-3 || static_friction > 1e4)) continue;
        GraspDef<double> def;
        def.time_step = dt;
        def.static_friction = static_friction;
        def.integration = integration;
        auto scene = make_grasp<double>(def);
        scene.run(4);
        const double settled = scene.sag();
        CHECK(scene.total_normal() == test::relative(20).epsilon(1e-6));
        CHECK(settled == test::relative(sag * 1e3 / static_friction).epsilon(1e-5));
        scene.run(5);
        CHECK(std::abs(scene.sag() - settled) < 1e-12);
      }
    }
  }
}

TEST_CASE("grasp: driven fingers of any mass grip with the force of their drive (R12)") {
  for (const double dt : {1e-3, 1.0 / 60}) {
    for (const double finger_mass : {0.5, 5000.0}) {
      GraspDef<double> def;
      def.time_step = dt;
      def.finger_mass = finger_mass;
      def.static_friction = 1e5;
      auto scene = make_grasp<double>(def);
      scene.run(4);
      CHECK(scene.total_normal() == test::relative(20).epsilon(1e-5));
      CHECK(scene.sag() == test::relative(0.5 * 9.81 / (1e5 * 20)).epsilon(1e-5));
      for (const JointId motor : scene.drives) {
        CHECK(scene.world.reading(motor).motor_force == test::relative(10).epsilon(1e-9));
      }
      const double settled = scene.sag();
      scene.run(5);
      CHECK(std::abs(scene.sag() - settled) < 1e-9);
    }
  }
}

TEST_CASE("grasp: float holds a part as double does (R12)") {
  // Stretches of 245 um out of positions of 40 mm (4e-9 m): 2e-5 relative, and the sum of 50.
  for (const Integration integration : both_integrations) {
    GraspDef<float> def;
    def.integration = integration;
    auto scene = make_grasp<float>(def);
    scene.run(4);
    const float settled = scene.sag();
    CHECK(static_cast<double>(settled) == test::relative(245.25e-6).epsilon(1e-3));
    scene.run(5);
    CHECK(std::abs(scene.sag() - settled) < 1e-6F);
  }
}

TEST_CASE("grasp: a loosened grip slips when mu times the grip no longer carries the part") {
  // mu = mu_S sigma_a = 1: two pads at N each hold 2 N; 4.905 N needs 2.4525 N each.
  GraspDef<double> def;
  def.finger_mass = 0.1;
  def.sliding_friction = 0.8;
  auto scene = make_grasp<double>(def);
  scene.run(1);
  double grip = 10;
  const double start = scene.sag();
  while (grip > 0.5 && scene.sag() - start < 2e-3) {
    grip *= 0.9995;
    for (const JointId motor : scene.drives) {
      scene.world.set_motor(motor, {MotorMode::velocity, 10, grip, 1});
    }
    scene.world.step();
  }
  CHECK(grip == test::relative(2.4525).epsilon(0.05));
  // Caught again: it stops within a few millimetres.
  for (const JointId motor : scene.drives) {
    scene.world.set_motor(motor, {MotorMode::velocity, 10, 10, 1});
  }
  scene.run(1);
  const double caught = scene.sag();
  CHECK(caught - start < 0.02);
  scene.run(1);
  CHECK(std::abs(scene.sag() - caught) < 1e-9);
}

TEST_CASE("grasp: bristles resist torsion about the normal (R11)") {
  // yaw = tau / (mu_S (N / n) sum r^2) with r from the plate's centre on the 4 x 4 grid.
  double sum_r2 = 0;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      const double x = 0.1 * ((2 * i + 1) / 4.0 - 1);
      const double y = 0.1 * ((2 * j + 1) / 4.0 - 1);
      sum_r2 += x * x + y * y;
    }
  }
  const double yaw = 0.2 / (5000 * 0.5 * 9.81 / 16 * sum_r2);
  CHECK(yaw == test::relative(1.304791e-3).epsilon(1e-5));
  for (const Integration integration : both_integrations) {
    PlateDef<double> def;
    def.integration = integration;
    def.parameters.sliding_friction = 5;
    auto scene = make_plate<double>(def);
    scene.world.step();
    for (int i = 0; i < 3000; ++i) {
      scene.world.apply_wrench(scene.plate, {{0, 0, 0}, {0, 0, 0.2}});
      scene.world.step();
    }
    const Vec3<double> turn = log_rotation<double>(scene.world.pose(scene.plate).rotation);
    CHECK(turn.z() == test::relative(yaw).epsilon(1e-4));
    CHECK(scene.world.reading(scene.patch).wrench.torque.z() == test::relative(-0.2).epsilon(1e-6));
  }
}
