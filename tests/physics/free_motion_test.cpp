/// @file
/// Bodies that nothing touches: falling, flying, tumbling.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;
using namespace bristle::detail;

namespace {

template <typename S>
BodyDef<S> brick() {
  BodyDef<S> def;
  def.mass = S(2);
  def.shape = Box<S>{{S(0.05), S(0.1), S(0.2)}};
  return def;
}

template <typename S>
World<S> world_with(const Vec3<S>& gravity, S dt) {
  WorldDef<S> def;
  def.gravity = gravity;
  def.time_step = dt;
  return World<S>(def);
}

/// Angle between the attitudes of a tumbling brick after 0.8 s, in steps of dt and of a 64th.
double tumbling_error(double dt, const Vec3<double>& spin) {
  Quat<double> ends[2];
  for (int k = 0; k < 2; ++k) {
    auto world = world_with<double>(Vec3<double>::Zero(), k == 0 ? dt : dt / 64);
    BodyDef<double> def = brick<double>();
    def.angular_velocity = spin;
    const BodyId id = world.add_body(def);
    const long steps = std::lround(0.8 / world.time_step());
    for (long i = 0; i < steps; ++i) world.step();
    ends[k] = world.pose(id).rotation;
  }
  return log_rotation<double>(ends[0].conjugate() * ends[1]).norm();
}

}  // namespace

TEST_CASE_TEMPLATE("free_motion: a body falls along the exact parabola", S, float, double) {
  auto world = world_with<S>({0, 0, S(-9.81)}, S(1) / S(256));
  BodyDef<S> def = brick<S>();
  def.position = {0, 0, 10};
  def.velocity = {0, 0, 2};
  const BodyId id = world.add_body(def);
  for (int n = 1; n <= 256; ++n) {
    world.step();
    const double t = n / 256.0;
    const double z = 10 + 2 * t - 9.81 * t * t / 2;
    // One rounding of 10 m a step.
    const double tolerance = 10 * n * static_cast<double>(Tolerance<S>::round_off());
    CHECK(std::abs(static_cast<double>(world.pose(id).translation.z()) - z) < tolerance);
  }
}

TEST_CASE_TEMPLATE("free_motion: a body falls by symplectic Euler's recurrence where asked", S,
                   float, double) {
  // v += dt g, then x += dt v: x_n = x_0 + n dt v_0 + g dt^2 n (n + 1) / 2.
  WorldDef<S> world_def;
  world_def.gravity = {0, 0, S(-9.81)};
  world_def.time_step = S(1) / S(256);
  world_def.integrator = Integrator::symplectic_euler;
  World<S> world(world_def);
  BodyDef<S> def = brick<S>();
  def.position = {0, 0, 10};
  const BodyId id = world.add_body(def);
  S v = 0;
  S z = 10;
  for (int n = 1; n <= 256; ++n) {
    world.step();
    v += (S(1) / S(256)) * S(-9.81);
    z += (S(1) / S(256)) * v;
    CHECK(world.body(id).twist.linear.z() == v);
    CHECK(world.pose(id).translation.z() == z);
  }
  const double closed = 10 - 9.81 / 256 / 256 * 256 * 257 / 2;
  CHECK(static_cast<double>(z) ==
        test::relative(closed).epsilon(256 * static_cast<double>(Tolerance<S>::round_off())));
}

TEST_CASE("free_motion: a projectile keeps its horizontal speed and lands where it should") {
  auto world = world_with<double>({0, 0, -10}, 1e-3);
  BodyDef<double> def = brick<double>();
  def.velocity = {3, 0, 10};
  const BodyId id = world.add_body(def);
  for (int i = 0; i < 2000; ++i) world.step();
  // Flight time 2 v_z / g = 2 s.
  CHECK(world.body(id).twist.linear.x() == 3);
  CHECK(world.pose(id).translation.x() == test::relative(6).epsilon(1e-12));
  CHECK(std::abs(world.pose(id).translation.z()) < 1e-11);
}

TEST_CASE("free_motion: gravity scales by body, and an applied wrench acts for one step") {
  auto world = world_with<double>({0, 0, -8}, 0.25);
  BodyDef<double> def = brick<double>();
  def.gravity_scale = 0.5;
  const BodyId half = world.add_body(def);
  def.gravity_scale = 0;
  const BodyId none = world.add_body(def);
  world.apply_wrench(none, {{4, 0, 0}, {0, 0, 0}});
  world.apply_wrench(none, {{4, 0, 0}, {0, 0, 0}});
  world.step();
  CHECK(world.body(half).twist.linear.z() == -1);
  CHECK(world.body(none).twist.linear == Vec3<double>(1, 0, 0));
  world.step();
  CHECK(world.body(none).twist.linear == Vec3<double>(1, 0, 0));
}

TEST_CASE("free_motion: a force at a point turns a body as r x F says") {
  auto world = world_with<double>(Vec3<double>::Zero(), 1e-3);
  const BodyId id = world.add_body(brick<double>());
  world.apply_force(id, {0, 5, 0}, {0.1, 0, 0});
  world.step();
  CHECK(world.body(id).twist.linear.y() == test::relative(5 * 1e-3 / 2));
  CHECK(world.body(id).angular_momentum().z() == test::relative(0.1 * 5 * 1e-3));
}

TEST_CASE_TEMPLATE("free_motion: a tumbling brick keeps momentum and energy at 1/60 s", S, float,
                   double) {
  // A handful of roundings a step, all in the same direction at worst.
  constexpr int steps = 3600;
  const S tolerance = S(steps) * Tolerance<S>::round_off();
  // Spinning about its middle axis it flips over and over: the hardest case for an integrator.
  for (const Vec3<S>& spin : {Vec3<S>(S(0.01), 6, S(0.02)), Vec3<S>(4, 3, -5), Vec3<S>(0, 0, 20)}) {
    auto world = world_with<S>(Vec3<S>::Zero(), S(1) / S(60));
    BodyDef<S> def = brick<S>();
    def.angular_velocity = spin;
    const BodyId id = world.add_body(def);
    const Vec3<S> momentum = world.body(id).angular_momentum();
    const S energy = world.body(id).kinetic_energy();
    for (int i = 0; i < steps; ++i) world.step();
    CHECK((world.body(id).angular_momentum() - momentum).norm() < tolerance * momentum.norm());
    CHECK(std::abs(world.body(id).kinetic_energy() - energy) < S(2) * tolerance * energy);
    CHECK(std::abs(world.pose(id).rotation.norm() - S(1)) < Tolerance<S>::round_off());
  }
}

TEST_CASE("free_motion: the attitude of a tumbling brick is of fourth order in the step") {
  const Vec3<double> spin(4, 3, -5);
  const double coarse = tumbling_error(1.0 / 100, spin);
  const double fine = tumbling_error(1.0 / 200, spin);
  CHECK(fine < 1e-5);
  CHECK(coarse / fine == test::relative(16).epsilon(0.2));
}

TEST_CASE("free_motion: momentum and energy stay at spins of more than half a turn a step") {
  // A rod that tumbles end over end: a map that loses its root has a factor of 290 between the
  // energies that its momentum allows to go wrong by.
  for (const double spin : {100.0, 150.0, 200.0, 1000.0}) {
    CAPTURE(spin);
    auto world = world_with<double>(Vec3<double>::Zero(), 1.0 / 60);
    BodyDef<double> def;
    def.mass = 1;
    def.shape = Box<double>{{0.1, 0.005, 0.006}};
    def.angular_velocity = {0.3 * spin, 0.3 * spin, spin};
    const BodyId id = world.add_body(def);
    const Vec3<double> momentum = world.body(id).angular_momentum();
    const double energy = world.body(id).kinetic_energy();
    for (int i = 0; i < 600; ++i) world.step();
    CHECK((world.body(id).angular_momentum() - momentum).norm() < 1e-10 * momentum.norm());
    CHECK(world.body(id).kinetic_energy() == test::relative(energy).epsilon(1e-9));
  }
}

TEST_CASE("free_motion: kinematic bodies move as told, fixed ones not at all") {
  auto world = world_with<double>({0, 0, -9.81}, 0.1);
  BodyDef<double> def = brick<double>();
  def.motion = Motion::kinematic;
  def.velocity = {1, 0, 0};
  const BodyId kinematic = world.add_body(def);
  def.motion = Motion::fixed;
  const BodyId fixed = world.add_body(def);
  world.apply_wrench(kinematic, {{100, 100, 100}, {1, 2, 3}});
  for (int i = 0; i < 10; ++i) world.step();
  CHECK(world.pose(kinematic).translation.isApprox(Vec3<double>(1, 0, 0), 1e-14));
  CHECK(world.pose(fixed).translation == Vec3<double>::Zero());
  const Transform<double> goal{exp_rotation<double>({0.3, 0.2, 0.1}), {1, 2, 3}};
  world.move_to(kinematic, goal);
  world.step();
  CHECK(world.pose(kinematic).translation.isApprox(goal.translation, 1e-14));
  CHECK(world.pose(kinematic).rotation.angularDistance(goal.rotation) < 1e-7);
}
