/// @file
/// Islands beyond `SolverDef::max_direct_work`: swept, in parts of the step.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/momentum.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

using namespace bristle;

namespace {

struct Wall {
  World<double> world;
  std::vector<BodyId> bodies;
};

/// Fifteen by five cubes of 0.2 m and 1 kg on a floor, laid like bricks.
Wall make_wall(double dt) {
  WorldDef<double> def;
  def.time_step = dt;
  Wall wall{World<double>(def), {}};
  wall.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  for (int row = 0; row < 5; ++row) {
    for (int i = 0; i < 15; ++i) {
      wall.bodies.push_back(
          wall.world.add_body({.mass = 1,
                               .shape = Box<double>{{0.1, 0.1, 0.1}},
                               .position = {0.2 * i + 0.1 * (row % 2), 0, 0.1 + 0.2 * row}}));
    }
  }
  return wall;
}

double total_energy(const Wall& wall) {
  return test::energy_of(wall.world, std::span<const BodyId>(wall.bodies));
}

}  // namespace

TEST_CASE("large_islands: towers stand, however many cubes they have") {
  for (const int count : {70, 150}) {
    CAPTURE(count);
    WorldDef<double> def;
    World<double> world(def);
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    std::vector<BodyId> cubes;
    for (int i = 0; i < count; ++i) {
      cubes.push_back(world.add_body(
          {.mass = 1, .shape = Box<double>{{0.1, 0.1, 0.1}}, .position = {0, 0, 0.1 + 0.2 * i}}));
    }
    std::uint64_t most_factorisations = 0;
    for (int i = 0; i < 480; ++i) {
      world.step();
      most_factorisations = std::max(most_factorisations, world.report().factorisations);
    }
    for (int i = 0; i < count; ++i) {
      const Vec3<double> p = world.pose(cubes[static_cast<std::size_t>(i)]).translation;
      // Sweeps may leave an error of 1e-8 of 9.81 m/s^2 dt. It adds up to 1e-9 m in two seconds,
      // and leans the more the higher the tower is.
      CHECK((p - Vec3<double>(0, 0, 0.1 + 0.2 * i)).norm() < 1e-9 * count);
    }
    // It is factored, and seldom.
    CHECK(most_factorisations > 0);
    CHECK(most_factorisations <= 60);
  }
}

TEST_CASE("large_islands: what is poured into a bin does not overlap, and loses energy") {
  WorldDef<double> def;
  World<double> world(def);
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  for (const double side : {-1.0, 1.0}) {
    world.add_body({.motion = Motion::fixed,
                    .shape = Box<double>{{0.2, 1, 3}},
                    .position = {side * 0.6, 0, 3}});
    world.add_body({.motion = Motion::fixed,
                    .shape = Box<double>{{1, 0.2, 3}},
                    .position = {0, side * 0.6, 3}});
  }
  std::vector<BodyId> bodies;
  for (int i = 0; i < 128; ++i) {
    BodyDef<double> body{.mass = 1};
    if (i % 2 == 0) {
      body.shape = Sphere<double>{0.08};
    } else {
      body.shape = Box<double>{{0.07, 0.07, 0.07}};
    }
    const int cell = i % 16;
    body.position = {(cell % 4 - 1.5) * 0.19 + 0.003 * (i % 7), (cell / 4 - 1.5) * 0.19,
                     0.1 + 0.18 * (i / 16)};
    bodies.push_back(world.add_body(body));
  }
  const auto energy = [&] {
    double sum = test::energy_of(world, std::span<const BodyId>(bodies));
    for (const BodyId id : bodies) {
      sum += 9.81 * world.body(id).mass * world.body(id).center_pose.translation.z();
    }
    return sum;
  };
  const double start = energy();
  double settled = start;
  for (int i = 0; i < 720; ++i) {
    world.step();
    if (i == 360) settled = energy();
  }
  double deepest = 0;
  for (const auto& point : world.contacts().points()) deepest = std::max(deepest, -point.gap);
  // Loads that are forgotten where bodies still approach leave 10 mm here and more.
  CHECK(deepest < 1e-3);
  CHECK(energy() < settled + 1e-3 * start);
  CHECK(settled < start);
}

TEST_CASE("large_islands: an impact gives no energy, whatever the step is cut into") {
  for (const double dt : {1.0 / 240, 1.0 / 120, 1.0 / 60, 1.0 / 30}) {
    CAPTURE(dt);
    Wall wall = make_wall(dt);
    for (int i = 0; i < 5; ++i) wall.world.step();
    BodyDef<double> ball{.mass = 20, .shape = Sphere<double>{0.2}, .position = {1.5, -0.6, 0.5}};
    ball.velocity = {0, 5, 0};
    wall.bodies.push_back(wall.world.add_body(ball));
    double before = total_energy(wall);
    const double start = before;
    double fastest = 0;
    for (int i = 0; i * dt < 1; ++i) {
      wall.world.step();
      const double after = total_energy(wall);
      // Contacts at the start of a step hold what has turned since: of the order of one step's
      // fall of the heaviest body, 20 kg * 9.81 * 5 m/s * dt.
      CHECK(after - before < 20 * 9.81 * 5 * dt);
      before = after;
      for (const BodyId id : wall.bodies) {
        fastest = std::max(fastest, wall.world.body(id).twist.linear.norm());
      }
    }
    CHECK(before < start);
    // A cube of 1 kg leaves a ball of 20 kg at less than twice its speed.
    CHECK(fastest < 10);
    CHECK(wall.world.report().islands > 0);
  }
}

TEST_CASE("large_islands: a long chain that falls on the floor stays a chain") {
  for (const double dt : {1.0 / 240, 1.0 / 60}) {
    CAPTURE(dt);
    WorldDef<double> def;
    def.time_step = dt;
    World<double> world(def);
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    const int links = 70;
    std::vector<BodyId> chain;
    std::vector<JointId> joints;
    for (int i = 0; i < links; ++i) {
      chain.push_back(world.add_body(
          {.mass = 0.1, .shape = Sphere<double>{0.03}, .position = {0.1 * i, 0, 0.5}}));
      if (i == 0) continue;
      JointDef<double> joint;
      joint.kind = JointKind::ball;
      joint.body_a = chain[chain.size() - 2];
      joint.body_b = chain.back();
      joint.X_AJ.translation = {0.05, 0, 0};
      joint.X_BJ.translation = {-0.05, 0, 0};
      joints.push_back(world.add_joint(joint));
    }
    double gap = 0;
    for (int i = 0; i * dt < 1.5; ++i) {
      world.step();
      for (std::size_t k = 1; k < chain.size(); ++k) {
        const Vec3<double> a = world.pose(chain[k - 1]) * Vec3<double>(0.05, 0, 0);
        const Vec3<double> b = world.pose(chain[k]) * Vec3<double>(-0.05, 0, 0);
        gap = std::max(gap, (a - b).norm());
      }
      CHECK(world.report().frozen_bodies == 0);
    }
    // Links of 0.1 m turn by up to v dt / 0.1 in a step; the second order of that is left.
    const double turn = 3 * dt / 0.1;
    CHECK(gap < 0.1 * turn * turn);
  }
}

TEST_CASE("large_islands: two feet of one body keep their own friction when swept") {
  for (const bool slippery_first : {false, true}) {
    WorldDef<double> def;
    def.gravity = {9.81 * std::sin(0.35), 0, -9.81 * std::cos(0.35)};
    def.solver.max_direct_work = 0;
    World<double> world(def);
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}, .material = {1, 0}});
    BodyDef<double> body;
    body.mass = 1;
    body.inertia = 0.02 * Mat3<double>::Identity();
    // Free to roll, so that statics share the load evenly between the feet.
    body.locked.angular = {false, true, true};
    for (int k = 0; k < 2; ++k) {
      ShapeDef<double> foot;
      foot.shape = Box<double>{{0.05, 0.05, 0.05}};
      foot.X_BS.translation = {0, k == 0 ? -0.2 : 0.2, 0};
      foot.material.friction = (k == 0) == slippery_first ? 0.0 : 1.0;
      body.shapes.push_back(foot);
    }
    body.center_of_mass = Vec3<double>::Zero();
    body.position = {0, 0, 0.05};
    const BodyId id = world.add_body(body);
    for (int i = 0; i < 240; ++i) world.step();
    // The rough foot carries half of the weight, and holds up to tan = 0.5.
    CHECK(std::abs(world.pose(id).translation.x()) < 0.02);
  }
}

TEST_CASE("large_islands: what slides and spins is not braked twice") {
  // A disk of eight feet slides and spins: friction cannot be more than mu m g in all. The sweeps
  // of trapezoidal steps are not extrapolated where surfaces slide, those of symplectic Euler are.
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    CAPTURE(static_cast<int>(integrator));
    WorldDef<double> def;
    def.time_step = 1e-3;
    def.integrator = integrator;
    def.solver.max_direct_work = 0;
    World<double> world(def);
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}, .material = {0.5, 0}});
    BodyDef<double> body{.mass = 1,
                         .shape = Box<double>{{0.1, 0.1, 0.02}},
                         .material = {0.5, 0},
                         .position = {0, 0, 0.02}};
    body.velocity = {2, 0, 0};
    body.angular_velocity = {0, 0, 200};
    const BodyId id = world.add_body(body);
    double before = 2;
    for (int i = 0; i < 50; ++i) {
      world.step();
      const double v = world.body(id).twist.linear.head<2>().norm();
      CHECK(before - v < 1.01 * 0.5 * 9.81 * def.time_step);
      before = v;
    }
    // Spinning fast, most of the friction goes round: the slide is hardly braked.
    CHECK(before > 2 - 0.5 * 0.5 * 9.81 * 0.05);
  }
}

TEST_CASE("large_islands: a heap that is put in overlapping comes apart, and no farther") {
  for (const double dt : {1.0 / 60, 1.0 / 240}) {
    for (const double pitch : {0.18, 0.195}) {
      CAPTURE(dt);
      CAPTURE(pitch);
      World<double> world({.time_step = dt});
      world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
      std::vector<BodyId> boxes;
      for (int i = 0; i < 216; ++i) {
        const Vec3<double> place = {1.0 * (i % 6), 1.0 * (i / 6 % 6), i / 36 + 0.5};
        boxes.push_back(world.add_body(
            {.mass = 1, .shape = Box<double>{{0.1, 0.1, 0.1}}, .position = pitch * place}));
      }
      double top = 0;
      for (int n = 0; n < 12; ++n) {
        world.step();
        for (const BodyId id : boxes) {
          top = std::max(top, world.body(id).center_pose.translation.z());
        }
      }
      double deepest = 0;
      world.for_each_contact([&](const ContactReading<double>& contact) {
        contact.for_each_point([&](const ContactReading<double>::Point& point) {
          deepest = std::max(deepest, -point.gap);
        });
      });
      // Six boxes on each other. If the next step starts from what closed their overlaps they are
      // up to 9 mm higher.
      CHECK(top < 1.1 + 3e-3);
      CHECK(deepest < 2e-3);
    }
  }
}
