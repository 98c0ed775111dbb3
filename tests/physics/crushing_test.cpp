/// @file
/// Bodies between a floor and a plate that comes down on them, which no solver can keep apart.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace bristle;

namespace {

/// Towers of bodies of 1 kg and 0.2 m on a floor, 10 mm apart, with a plate 50 mm above them.
struct CrushedTowers {
  static constexpr double mass = 1;
  static constexpr double half = 0.1;
  World<double> world;
  std::vector<BodyId> bodies{};
  BodyId plate{};
  double height;
  double largest_impulse = 0;  // [N s] Of all points and steps so far.
  double largest_gain = 0;     // [J] Of energy in a step.
  double fastest = 0;          // [m/s]

  /// @param aside  [m] Every other tower is this far out of its place.
  CrushedTowers(int side, int layers, const Shape<double>& shape, double dt, double aside = 0)
      : world({.time_step = dt}), height(2 * half * layers) {
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    for (int i = 0; i < side * side * layers; ++i) {
      const int x = i % side;
      const int y = i / side % side;
      const int layer = i / (side * side);
      bodies.push_back(world.add_body(
          {.mass = mass,
           .shape = shape,
           .position = {0.21 * x + aside * ((x + y) % 2), 0.21 * y, half * (1 + 2 * layer)}}));
    }
    const double middle = 0.105 * (side - 1);
    plate = world.add_body({.motion = Motion::kinematic,
                            .shape = Box<double>{{1, 1, 0.1}},
                            .position = {middle, middle, height + 0.15}});
  }
  /// The plate moves by a distance, down or up.
  void move_plate(double velocity, double distance) {
    const double dt = world.def().time_step;
    for (int i = 0; i * dt * std::abs(velocity) < distance; ++i) {
      const double before = energy();
      world.set_velocity(plate, {{0, 0, velocity}, {0, 0, 0}});
      world.step();
      largest_gain = std::max(largest_gain, energy() - before);
      for (const BodyId id : bodies) {
        fastest = std::max(fastest, world.body(id).twist.linear.norm());
      }
      for (const auto& point : world.contacts().points()) {
        largest_impulse = std::max(largest_impulse, point.impulse[0]);
      }
    }
  }
  [[nodiscard]] double energy() const {
    double sum = 0;
    for (const BodyId id : bodies) {
      sum += world.body(id).kinetic_energy() +
             mass * 9.81 * world.body(id).center_pose.translation.z();
    }
    return sum;
  }
};

}  // namespace

TEST_CASE("crushing: a body between two that nothing stops is pressed by a bounded impulse") {
  for (const double dt : {1.0 / 60, 1.0 / 1000}) {
    for (const Shape<double>& shape :
         {Shape<double>(Box<double>{{0.1, 0.1, 0.1}}), Shape<double>(Sphere<double>{0.1})}) {
      CAPTURE(dt);
      CrushedTowers one(1, 1, shape, dt);
      one.move_plate(-0.1, 0.15);
      // Ten times what stops the body, at most as fast as the plate, and brings it to the plate's
      // speed, with the fall of one step.
      const double most = 10 * CrushedTowers::mass * (0.1 + 0.1 + 9.81 * dt);
      CHECK(one.largest_impulse > 0.1 * most);
      CHECK(one.largest_impulse <= most * (1 + 1e-6));
      // It is between both, and goes no faster than the plate.
      CHECK(one.fastest <= 0.1 * (1 + 1e-6));
      CHECK(one.largest_gain < 0.5 * CrushedTowers::mass * 0.1 * 0.1);
      // What was pressed together comes to rest once it is let go.
      one.move_plate(0.1, 0.2);
      CHECK(one.world.body(one.bodies[0]).twist.linear.norm() < 1e-6);
      CHECK(one.world.pose(one.bodies[0]).translation.z() == test::relative(0.1).epsilon(1e-3));
    }
  }
}

TEST_CASE(
    "crushing: towers that are crushed are not thrown out, whatever shape and step they have") {
  struct Towers {
    int side, layers;
    Shape<double> shape;
    double dt, speed;
  };
  const Box<double> box{{0.1, 0.1, 0.1}};
  const Sphere<double> ball{0.1};
  // Small ones are factorised, wide ones swept.
  for (const Towers& t : {Towers{1, 3, ball, 1.0 / 240, 0.1}, Towers{2, 2, box, 1.0 / 60, 0.1},
                          Towers{3, 3, box, 1.0 / 240, 0.3}, Towers{4, 3, box, 1.0 / 60, 0.1}}) {
    CAPTURE(t.side);
    for (const double aside : {0.0, 1e-5, 1e-4}) {
      CAPTURE(aside);
      CrushedTowers towers(t.side, t.layers, t.shape, t.dt, aside);
      towers.move_plate(-t.speed, 0.8 * towers.height);
      // What is squeezed out falls from no higher than it stood, and slides as fast as the plate
      // and a lever let it.
      CHECK(towers.fastest < std::sqrt(2 * 9.81 * towers.height) + 3 * t.speed);
    }
  }
}

TEST_CASE("crushing: loads below the bound do not know of it") {
  // Two movers, opposed, and a load that friction balances: boxes that a plate pushes along.
  World<double> world({.time_step = 1.0 / 240});
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  std::vector<BodyId> boxes;
  for (int i = 0; i < 6; ++i) {
    boxes.push_back(world.add_body({.mass = i % 2 == 0 ? 1.0 : 50.0,
                                    .shape = Box<double>{{0.1, 0.1, 0.1}},
                                    .material = {.friction = 0.9},
                                    .position = {0.2 * i, 0, 0.1}}));
  }
  const BodyId plate = world.add_body({.motion = Motion::kinematic,
                                       .shape = Box<double>{{0.1, 1, 0.5}},
                                       .position = {-0.2, 0, 0.6}});
  // So slowly that the weight alone decides on the bound. It is eleven times the load.
  world.set_velocity(plate, {{1e-3, 0, 0}, {0, 0, 0}});
  for (int i = 0; i < 240; ++i) world.step();
  for (const BodyId id : boxes) {
    CHECK(world.body(id).twist.linear.x() == test::relative(1e-3).epsilon(1e-6));
  }
  for (const auto& point : world.contacts().points()) CHECK(point.gap > -1e-5);
}
