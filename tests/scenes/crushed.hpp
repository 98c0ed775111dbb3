/// @file
/// Bodies that fixed and kinematic ones crush between them, which no solver can keep apart.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace bristle::scenes {

/// A world with a floor, and what happens to the bodies in it.
struct Crushed {
  World<double> world;
  std::vector<BodyId> bodies{};
  /// Bodies that nothing stops, with their velocities by time [s].
  std::vector<std::pair<BodyId, std::function<Twist<double>(double)>>> movers{};
  double friction = 0.5;       // [1] Of all bodies.
  double time = 0;             // [s]
  double fastest = 0;          // [m/s] Of all bodies so far.
  double fastest_spin = 0;     // [rad/s]
  double largest_gain = 0;     // [J] Of energy in a step.
  double largest_impulse = 0;  // [N s] At a point.

  explicit Crushed(double dt, double of_all = 0.5) : world({.time_step = dt}), friction(of_all) {
    world.add_body({.motion = Motion::fixed,
                    .shape = HalfSpace<double>{},
                    .material = {.friction = friction}});
  }
  void add(double mass, const Shape<double>& shape, const Vec3<double>& position) {
    bodies.push_back(world.add_body(
        {.mass = mass, .shape = shape, .material = {.friction = friction}, .position = position}));
  }
  void add_mover(const Vec3<double>& half, const Vec3<double>& position,
                 std::function<Twist<double>(double)> velocity) {
    movers.emplace_back(world.add_body({.motion = Motion::kinematic,
                                        .shape = Box<double>{half},
                                        .material = {.friction = friction},
                                        .position = position}),
                        std::move(velocity));
  }
  /// [J] Of motion and height.
  [[nodiscard]] double energy() const {
    double sum = 0;
    for (const BodyId id : bodies) {
      const Body<double>& body = world.body(id);
      sum += body.kinetic_energy() + body.mass * 9.81 * body.center_pose.translation.z();
    }
    return sum;
  }
  void run(double seconds) {
    for (const double end = time + seconds; time < end; time += world.time_step()) {
      const double before = energy();
      for (const auto& [id, velocity] : movers) world.set_velocity(id, velocity(time));
      world.step();
      largest_gain = std::max(largest_gain, energy() - before);
      for (const BodyId id : bodies) {
        fastest = std::max(fastest, world.body(id).twist.linear.norm());
        fastest_spin = std::max(fastest_spin, world.body(id).twist.angular.norm());
      }
      for (const auto& point : world.contacts().points()) {
        largest_impulse = std::max(largest_impulse, point.impulse[0]);
      }
    }
  }
};

/// Towers of bodies of 1 kg and 0.2 m, 10 mm apart, under a plate that comes down from 50 mm above.
struct CrushedTowers {
  int side = 1;
  int layers = 1;
  Shape<double> shape = Box<double>{{0.1, 0.1, 0.1}};
  double speed = 0.1;  // [m/s] Of the plate.
  double friction = 0.5;

  /// @param aside  [m] Bodies are out of their places by multiples of it.
  /// @param until  [s] When the plate goes up again.
  [[nodiscard]] Crushed make(double dt, double aside = 0, double until = 1e9) const {
    Crushed scene(dt, friction);
    for (int i = 0; i < side * side * layers; ++i) {
      const int layer = i / (side * side);
      scene.add(1, shape,
                {0.21 * (i % side) + aside * (i % 7), 0.21 * (i / side % side), 0.1 + 0.2 * layer});
    }
    const double middle = 0.105 * (side - 1);
    scene.add_mover({1, 1, 0.1}, {middle, middle, height() + 0.15},
                    [v = speed, until](double t) -> Twist<double> {
                      return {{0, 0, t < until ? -v : v}, {0, 0, 0}};
                    });
    return scene;
  }
  [[nodiscard]] double height() const { return 0.2 * layers; }
  /// [s] After how long the plate has gone through a share of the height.
  [[nodiscard]] double time_of(double share) const { return (0.05 + share * height()) / speed; }
};

/// Doors that close on 40 bodies of five shapes at 0.5 m/s, pass through each other, and open after
/// a second.
[[nodiscard]] inline Crushed make_closing_doors(double dt, double aside) {
  const Shape<double> shapes[] = {Box<double>{{0.08, 0.08, 0.08}}, Sphere<double>{0.09},
                                  Capsule<double>{0.05, 0.05}, Cylinder<double>{0.08, 0.08},
                                  box_mesh<double>({0.08, 0.07, 0.08})};
  Crushed scene(dt);
  for (int i = 0; i < 40; ++i) {
    scene.add(1 + i % 3, shapes[i % 5],
              {0.24 * (i % 4) - 0.36 + aside * (i % 7), 0.25 * (i / 4 % 3) - 0.25,
               0.1 + 0.22 * (i / 12)});
  }
  for (const int sign : {-1, 1}) {
    scene.add_mover({0.1, 2, 2}, {0.7 * sign, 0, 2}, [sign](double t) -> Twist<double> {
      return {{t < 1 ? -0.5 * sign : 0.5 * sign, 0, 0}, {0, 0, 0}};
    });
  }
  return scene;
}

/// A lift with 12 boxes of 1 and 20 kg that goes up at 0.2 m/s under a roof.
[[nodiscard]] inline Crushed make_rising_lift(double dt, double aside) {
  Crushed scene(dt);
  scene.world.add_body(
      {.motion = Motion::fixed, .shape = Box<double>{{1, 1, 0.1}}, .position = {0, 0, 1.2}});
  for (int i = 0; i < 12; ++i) {
    scene.add(i % 2 == 0 ? 20 : 1, Box<double>{{0.1, 0.1, 0.1}},
              {0.22 * (i % 2) - 0.11 + aside * i, 0.22 * (i / 2 % 2) - 0.11, 0.4 + 0.2 * (i / 4)});
  }
  scene.add_mover({0.5, 0.5, 0.1}, {0, 0, 0.2}, [](double) -> Twist<double> {
    return {{0, 0, 0.2}, {0, 0, 0}};
  });
  return scene;
}

/// A paddle that turns into nine balls on the floor at 1 rad/s.
[[nodiscard]] inline Crushed make_turning_paddle(double dt, double aside) {
  Crushed scene(dt);
  for (int i = 0; i < 9; ++i) {
    scene.add(1, Sphere<double>{0.1}, {0.2 * (i % 3) - 0.2 + aside * i, 0.2 * (i / 3) - 0.2, 0.1});
  }
  scene.add_mover({0.6, 0.3, 0.05}, {0, 0, 0.4}, [](double) -> Twist<double> {
    return {{0, 0, 0}, {0, 1, 0}};
  });
  return scene;
}

}  // namespace bristle::scenes
