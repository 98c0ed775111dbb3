/// @file
/// Hard contact at the ends of the scales: sizes, steps, masses, friction, spins.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/stack.hpp"
#include "support/momentum.hpp"
#include "support/numbers.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

using namespace bristle;
using bristle::test::g;
using namespace bristle::scenes;

namespace {

/// Cubes on top of each other, a little apart, and a cube that slides beside them. Lengths in
/// `size`; times in sqrt(size / g).
struct Scaled {
  World<double> world;
  std::vector<BodyId> cubes{};
  BodyId slider{};
};

Scaled make_scaled(double size, double step, double friction, const std::vector<double>& masses) {
  WorldDef<double> def;
  const double time = std::sqrt(size / g);
  def.time_step = step * time;
  def.gravity = {0, 0, -g};
  // A speed, so it goes with the size.
  def.restitution_speed = 0.01 * size / time;
  Scaled scene{World<double>(def), {}, {}};
  BodyDef<double> ground;
  ground.motion = Motion::fixed;
  ground.shape = HalfSpace<double>{};
  ground.material = {friction, 0};
  scene.world.add_body(ground);
  BodyDef<double> cube;
  cube.shape = Box<double>{Vec3<double>::Constant(size / 2)};
  cube.material = {friction, 0};
  for (std::size_t k = 0; k < masses.size(); ++k) {
    cube.mass = masses[k] * 1000 * size * size * size;
    cube.position = {0.02 * size * static_cast<double>(k), 0,
                     size * (0.5 + 1.01 * static_cast<double>(k) + 0.01)};
    scene.cubes.push_back(scene.world.add_body(cube));
  }
  cube.position = {0, 5 * size, size / 2};
  cube.velocity = {size / time, 0, 0};
  scene.slider = scene.world.add_body(cube);
  return scene;
}

/// [1] Places of all its bodies after a time, in units of the size.
std::vector<Vec3<double>> places_after(Scaled& scene, double size, int steps) {
  for (int i = 0; i < steps; ++i) scene.world.step();
  std::vector<Vec3<double>> places;
  for (const BodyId id : scene.cubes) places.push_back(scene.world.pose(id).translation / size);
  places.push_back(scene.world.pose(scene.slider).translation / size);
  return places;
}

/// [m] Largest error of the heights of a stack of cubes of 0.2 m.
double height_error(const StackScene<double>& scene) {
  double worst = 0;
  for (std::size_t k = 0; k < scene.cubes.size(); ++k) {
    const double z = scene.world.pose(scene.cubes[k]).translation.z();
    worst = std::max(worst, std::abs(z - scene.rest_heights[k]));
  }
  return worst;
}

}  // namespace

TEST_CASE("extremes: a stack and a slide of 1 mm to 100 m are the same but for their scale") {
  const std::vector<double> masses{1, 0.5, 2};
  Scaled one = make_scaled(1, 0.02, 0.5, masses);
  const std::vector<Vec3<double>> reference = places_after(one, 1, 1000);
  for (const double size : {1e-3, 1e-2, 0.1, 10.0, 100.0}) {
    CAPTURE(size);
    Scaled scene = make_scaled(size, 0.02, 0.5, masses);
    const std::vector<Vec3<double>> places = places_after(scene, size, 1000);
    for (std::size_t k = 0; k < places.size(); ++k) {
      // Nothing in it is chaotic: round-offs of 1000 steps.
      CHECK((places[k] - reference[k]).norm() < 1e-9);
    }
    CHECK(scene.world.report().frozen_bodies == 0);
  }
  // v^2 / (2 mu g) in units of the size, and the stack at rest.
  CHECK(reference.back().x() == test::relative(1.0).epsilon(1e-3));
  for (std::size_t k = 0; k < masses.size(); ++k) {
    CHECK(std::abs(reference[k].z() - 0.5 - static_cast<double>(k)) < 1e-7);
  }
}

TEST_CASE("extremes: a stack comes to rest at steps from 10 us to 1/30 s") {
  for (const double dt : {1e-5, 1e-4, 1e-3, 1.0 / 240, 1.0 / 60, 1.0 / 30}) {
    CAPTURE(dt);
    StackDef<double> def;
    def.masses = {1, 2, 1};
    def.time_step = dt;
    auto scene = make_stack<double>(def);
    scene.run(0.5);
    CHECK(height_error(scene) < 1e-7);
    for (const BodyId id : scene.cubes) {
      // The bound is the solver's tolerance.
      CHECK(scene.world.body(id).twist.linear.norm() < 1e-6);
    }
  }
}

TEST_CASE("extremes: friction from 0 to 10 slides and holds as Coulomb says") {
  for (const double mu : {0.0, 1e-3, 0.1, 1.0, 3.0, 10.0}) {
    for (const double dt : {1e-3, 1.0 / 60}) {
      CAPTURE(mu);
      CAPTURE(dt);
      Scaled scene = make_scaled(0.2, dt / std::sqrt(0.2 / g), mu, {1});
      const BodyId id = scene.slider;
      // Flat, so that it does not tip over at any friction.
      BodyDef<double> def;
      def.mass = 1;
      def.shape = Box<double>{{0.3, 0.3, 0.005}};
      def.material = {mu, 0};
      def.position = {0, -3, 0.005};
      def.velocity = {1, 0, 0};
      const BodyId plate = scene.world.add_body(def);
      const int steps = static_cast<int>(std::lround(0.5 / dt));
      for (int i = 0; i < steps; ++i) scene.world.step();
      const double stop = mu > 0 ? 1 / (mu * g) : 1e9;
      const double expected = stop > 0.5 ? 0.5 - mu * g * 0.125 : stop / 2;
      const double x = scene.world.pose(plate).translation.x();
      // The last step of a slide: mu g dt^2 / 8, or all of it within one step.
      CHECK(std::abs(x - expected) < std::min(mu * g * dt * dt / 8, dt) + 1e-9);
      CHECK(std::abs(scene.world.pose(plate).translation.z() - 0.005) < 1e-7);
      CHECK(scene.world.pose(id).translation.z() > 0.09);
    }
  }
}

TEST_CASE("extremes: rods and plates at 1000 rad/s keep momentum and energy") {
  const Vec3<double> shapes[] = {
      {0.5, 0.005, 0.005}, {0.2, 0.2, 0.002}, {0.1, 0.1, 0.1}, {0.3, 0.1, 0.01}};
  for (const Vec3<double>& half : shapes) {
    for (const double dt : {1e-4, 1.0 / 240, 1.0 / 60, 1.0 / 30}) {
      CAPTURE(half.x());
      CAPTURE(dt);
      WorldDef<double> world_def;
      world_def.time_step = dt;
      world_def.gravity.setZero();
      World<double> world(world_def);
      BodyDef<double> def;
      def.mass = 1;
      def.shape = Box<double>{half};
      def.angular_velocity = {600, -500, 624};
      def.velocity = {1, 2, 3};
      const BodyId id = world.add_body(def);
      const Vec3<double> momentum = world.body(id).angular_momentum();
      const double energy = world.body(id).kinetic_energy();
      for (int i = 0; i < 2000; ++i) world.step();
      CHECK((world.body(id).angular_momentum() - momentum).norm() < 1e-9 * momentum.norm());
      CHECK(world.body(id).kinetic_energy() == test::relative(energy).epsilon(1e-8));
      CHECK(world.body(id).twist.linear == Vec3<double>(1, 2, 3));
    }
  }
}

TEST_CASE("extremes: a rod that spins at 1000 rad/s hits the floor and does not blow up") {
  for (const double dt : {1e-4, 1e-3, 1.0 / 240, 1.0 / 60}) {
    CAPTURE(dt);
    WorldDef<double> world_def;
    world_def.time_step = dt;
    World<double> world(world_def);
    BodyDef<double> ground;
    ground.motion = Motion::fixed;
    ground.shape = HalfSpace<double>{};
    world.add_body(ground);
    BodyDef<double> def;
    def.mass = 1;
    def.shape = Box<double>{{0.2, 0.01, 0.01}};
    def.position = {0, 0, 0.3};
    def.angular_velocity = {10, 1000, 10};
    const std::array<BodyId, 1> body{world.add_body(def)};
    const double start = test::energy_of(world, std::span<const BodyId>(body));
    double highest = start;
    const long steps = std::lround(1 / dt);
    for (long i = 0; i < steps; ++i) {
      world.step();
      highest = std::max(highest, test::energy_of(world, std::span<const BodyId>(body)));
    }
    CHECK(highest < 1.001 * start);
    CHECK(world.report().frozen_bodies == 0);
  }
}
