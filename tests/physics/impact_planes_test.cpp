/// @file
/// Contacts of shapes that are apart when the step begins: what flies past is not stopped, and what
/// hits does so in the plane in which it meets the other.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace bristle;

namespace {

/// Steps for some seconds, and calls `after` after each step.
template <typename After>
void advance_by(World<double>& world, double seconds, After&& after) {
  const long steps = std::lround(seconds / world.time_step());
  for (long i = 0; i < steps; ++i) {
    world.step();
    after();
  }
}
void advance_by(World<double>& world, double seconds) {
  advance_by(world, seconds, [] {});
}

/// Two balls of 0.1 m and 1 kg at 5 m/s, the one of which hits the other at rest 0.12 m beside its
/// centre.
struct ObliqueHit {
  World<double> world;
  BodyId struck, striker;

  ObliqueHit(double dt, double restitution, double friction, double ahead) {
    WorldDef<double> def;
    def.gravity = {0, 0, 0};
    def.time_step = dt;
    world = World<double>(def);
    BodyDef<double> ball;
    ball.mass = 1;
    ball.shape = Sphere<double>{0.1};
    ball.material = {.friction = friction, .restitution = restitution};
    struck = world.add_body(ball);
    ball.position = {1 + ahead, 0.12, 0};
    ball.velocity = {-5, 0, 0};
    striker = world.add_body(ball);
    advance_by(world, 0.5);
  }
};

}  // namespace

TEST_CASE("impact_planes: smooth balls part along the line of their centres where they meet") {
  // The normal has sin = 0.12 / 0.2: speed along it is 5 * 0.8.
  for (const double dt : {1.0 / 60, 1.0 / 240, 1e-3}) {
    for (const double restitution : {0.0, 0.5, 1.0}) {
      for (const double ahead : {0.0, 0.013, 0.029, 0.047}) {
        CAPTURE(dt);
        CAPTURE(restitution);
        CAPTURE(ahead);
        ObliqueHit hit(dt, restitution, 0, ahead);
        const Twist<double> a = hit.world.body(hit.struck).twist;
        const Twist<double> b = hit.world.body(hit.striker).twist;
        // The steps of the advance leave less than a thousandth of the normal.
        const Vec3<double> n(-0.8, -0.6, 0);
        const Vec3<double> expected = 0.5 * (1 + restitution) * 4 * n;
        CHECK((a.linear - expected).norm() < 5e-3);
        CHECK((b.linear - (Vec3<double>(-5, 0, 0) - expected)).norm() < 5e-3);
        CHECK(a.angular.norm() < 1e-6);
        CHECK(b.angular.norm() < 1e-6);
        const double energy = 0.5 * (a.linear.squaredNorm() + b.linear.squaredNorm());
        CHECK(energy < 12.5 * (1 + 1e-6));
        CHECK(energy ==
              test::relative(12.5 - 0.25 * (1 - restitution * restitution) * 16).epsilon(2e-3));
      }
    }
  }
}

TEST_CASE(
    "impact_planes: balls that slide as they meet are turned by mu times the normal impulse") {
  for (const double dt : {1.0 / 60, 1.0 / 240, 1e-3}) {
    CAPTURE(dt);
    ObliqueHit hit(dt, 0, 0.1, 0.013);
    // Sliding: the tangential impulse is mu times the normal one, 0.1 * 2 N s, on an arm of 0.1 m.
    const double inertia = 0.4 * 1 * 0.01;
    CHECK(std::abs(hit.world.body(hit.struck).twist.angular.z()) ==
          test::relative(0.1 * 2 * 0.1 / inertia).epsilon(5e-3));
  }
}

TEST_CASE("impact_planes: what flies past is not touched") {
  for (const double dt : {1.0 / 60, 1.0 / 240}) {
    for (const double speed : {2.0, 5.0, 10.0, 20.0, 50.0}) {
      for (const double clearance : {0.001, 0.01, 0.05, 0.1}) {
        CAPTURE(dt);
        CAPTURE(speed);
        CAPTURE(clearance);
        WorldDef<double> def;
        def.gravity = {0, 0, 0};
        def.time_step = dt;
        World<double> world(def);
        for (int i = 0; i < 4; ++i) {
          for (const double side : {-1.0, 1.0}) {
            BodyDef<double> pillar{.motion = Motion::fixed, .shape = Box<double>{{0.1, 0.1, 1}}};
            pillar.position = {1.0 + 0.7 * i, side * (0.2 + clearance), 0};
            world.add_body(pillar);
          }
        }
        const BodyId ball =
            world.add_body({.shape = Sphere<double>{0.1}, .velocity = {speed, 0, 0}});
        advance_by(world, 5 / speed);
        CHECK(world.body(ball).twist.linear.x() == speed);
        CHECK(world.body(ball).twist.linear.y() == 0);
      }
    }
  }
}

TEST_CASE("impact_planes: a row of boxes that lie flush is a plane to what goes over it fast") {
  for (const double dt : {1.0 / 60, 1.0 / 240}) {
    for (const double speed : {1.0, 2.0, 4.0}) {
      for (const bool is_ball : {true, false}) {
        CAPTURE(dt);
        CAPTURE(speed);
        CAPTURE(is_ball);
        WorldDef<double> def;
        def.time_step = dt;
        World<double> world(def);
        for (int i = -1; i < 6; ++i) {
          BodyDef<double> tile{.motion = Motion::fixed, .shape = Box<double>{{0.5, 0.5, 0.1}}};
          tile.position = {1.0 * i, 0, -0.1};
          tile.material.friction = is_ball ? 0.5 : 0;
          world.add_body(tile);
        }
        BodyDef<double> body;
        if (is_ball) {
          body.shape = Sphere<double>{0.1};
          body.angular_velocity = {0, speed / 0.1, 0};
        } else {
          body.shape = Box<double>{{0.1, 0.1, 0.1}};
        }
        body.position = {0, 0, 0.1};
        body.velocity = {speed, 0, 0};
        const BodyId id = world.add_body(body);
        double highest = 0;
        advance_by(world, 4 / speed,
                   [&] { highest = std::max(highest, world.pose(id).translation.z()); });
        CHECK(world.body(id).twist.linear.x() == test::relative(speed).epsilon(1e-6));
        CHECK(highest < 0.1 + 1e-6);
      }
    }
  }
}

TEST_CASE("impact_planes: smooth elastic balls in a box keep their energy, or lose some") {
  for (const double dt : {1.0 / 60, 1.0 / 240}) {
    CAPTURE(dt);
    WorldDef<double> def;
    def.gravity = {0, 0, 0};
    def.time_step = dt;
    World<double> world(def);
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {-1.0, 1.0}) {
        Vec3<double> normal = Vec3<double>::Zero();
        normal[axis] = -side;
        BodyDef<double> wall{.motion = Motion::fixed, .shape = HalfSpace<double>{}};
        wall.orientation = Quat<double>::FromTwoVectors(Vec3<double>::UnitZ(), normal);
        wall.position = -1.0 * normal;
        wall.material = {.friction = 0, .restitution = 1};
        world.add_body(wall);
      }
    }
    std::vector<BodyId> balls;
    for (int i = 0; i < 27; ++i) {
      BodyDef<double> ball;
      ball.mass = 1;
      ball.shape = Sphere<double>{0.1};
      ball.material = {.friction = 0, .restitution = 1};
      ball.position = {0.5 * (i % 3) - 0.5, 0.5 * (i / 3 % 3) - 0.5, 0.5 * (i / 9) - 0.5};
      ball.velocity = {std::sin(7.0 * i), std::cos(11.0 * i), std::sin(13.0 * i + 1)};
      balls.push_back(world.add_body(ball));
    }
    const auto energy = [&] {
      double sum = 0;
      for (const BodyId id : balls) sum += world.body(id).kinetic_energy();
      return sum;
    };
    const double start = energy();
    double highest = start;
    advance_by(world, 10, [&] { highest = std::max(highest, energy()); });
    CHECK(highest < 1.01 * start);
  }
}
