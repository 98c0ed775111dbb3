/// @file
/// Worlds with derivatives: what a motion, a slip, a sag or a reading depends on, against closed
/// forms and against differences of the world without.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/grasp.hpp"
#include "scenes/medley.hpp"
#include "scenes/squeezed_cubes.hpp"
#include "scenes/stack.hpp"
#include "support/dual_world.hpp"
#include "support/relative.hpp"

#include <bristle/math/dual.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

using namespace bristle;
using namespace bristle::scenes;

namespace {

using D = Dual<double, 2>;

template <typename S>
void advance(World<S>& world, double seconds) {
  const long steps = std::lround(seconds / static_cast<double>(world.time_step()));
  for (long i = 0; i < steps; ++i) world.step();
}

/// A quantity as a function of two numbers: in duals, its derivatives by both.
template <typename Scene>
D differentiated(const Scene& scene, double a, double b) {
  return scene(D::variable(a, 0), D::variable(b, 1));
}

/// Checks the value of a quantity against that of the world without derivatives, and its
/// derivatives against central differences of that one.
/// @param tolerance  [1] Relative: of what is cut off by the difference, and what a solver that
///                   stops at 1e-8 leaves, over the width of the difference.
template <typename Scene>
void check_differences(const Scene& scene, double a, double b, double width, double tolerance) {
  const D y = differentiated(scene, a, b);
  CHECK(y.value() == test::relative(scene(a, b)).epsilon(1e-7));
  const double by_a = (scene(a * (1 + width), b) - scene(a * (1 - width), b)) / (2 * width * a);
  const double by_b = (scene(a, b * (1 + width)) - scene(a, b * (1 - width))) / (2 * width * b);
  CHECK(y.partial(0) == test::relative(by_a).epsilon(tolerance));
  CHECK(y.partial(1) == test::relative(by_b).epsilon(tolerance));
}

/// [m] Height of a body without forces but gravity.
constexpr auto thrown = [](auto gravity, auto speed) {
  using S = decltype(gravity);
  World<S> world({.gravity = {S(0), S(0), -gravity}, .time_step = S(1e-3)});
  const BodyId ball =
      world.add_body({.mass = S(2), .shape = Sphere<S>{S(0.1)}, .velocity = {S(0), S(0), speed}});
  advance(world, 0.5);
  return world.pose(ball).translation.z();
};

/// [m] Height of a ball 0.5 s after it was let go at a height above a floor, after one bounce.
constexpr auto bounced = [](auto restitution, auto height) {
  using S = decltype(height);
  World<S> world({.gravity = {S(0), S(0), S(-9.81)}, .time_step = S(1e-3)});
  const S radius = S(0.05);
  world.add_body({.motion = Motion::fixed,
                  .shape = HalfSpace<S>{},
                  .material = {.friction = S(0), .restitution = restitution}});
  const BodyId ball = world.add_body({.shape = Sphere<S>{radius},
                                      .material = {.friction = S(0), .restitution = restitution},
                                      .position = {S(0), S(0), radius + height}});
  advance(world, 0.5);
  return world.pose(ball).translation.z() - radius;
};

/// [m] How far a box slides that starts with a speed.
constexpr auto slid = [](auto friction, auto speed) {
  using S = decltype(friction);
  World<S> world({.gravity = {S(0), S(0), S(-9.81)}, .time_step = S(1e-3)});
  world.add_body(
      {.motion = Motion::fixed, .shape = HalfSpace<S>{}, .material = {.friction = friction}});
  const BodyId box = world.add_body({.mass = S(0.7),
                                     .shape = Box<S>{{S(0.1), S(0.1), S(0.02)}},
                                     .material = {.friction = friction},
                                     .position = {S(0), S(0), S(0.02)},
                                     .velocity = {speed, S(0), S(0)}});
  advance(world, 0.6);
  return world.pose(box).translation.x();
};

/// [m] How far a box slides down a slope of an angle in 0.3 s, from rest.
constexpr auto slid_down = [](auto friction, auto angle) {
  using std::cos;
  using std::sin;
  using S = decltype(friction);
  World<S> world(
      {.gravity = {S(9.81) * sin(angle), S(0), S(-9.81) * cos(angle)}, .time_step = S(1e-3)});
  world.add_body(
      {.motion = Motion::fixed, .shape = HalfSpace<S>{}, .material = {.friction = friction}});
  const BodyId box = world.add_body({.mass = S(0.7),
                                     .shape = Box<S>{{S(0.1), S(0.1), S(0.02)}},
                                     .material = {.friction = friction},
                                     .position = {S(0), S(0), S(0.02)}});
  advance(world, 0.3);
  return world.pose(box).translation.x();
};

/// [m] Where the tip of a rod on a ball joint is after 0.4 s of swinging from the horizontal.
constexpr auto swung = [](auto length, auto gravity) {
  using S = decltype(length);
  World<S> world({.gravity = {S(0), S(0), -gravity}, .time_step = S(2e-3)});
  const BodyId wall = world.add_body({.motion = Motion::fixed});
  const BodyId rod = world.add_body({.mass = S(1.5),
                                     .shape = Box<S>{{length / S(2), S(0.02), S(0.03)}},
                                     .position = {length / S(2), S(0), S(0)}});
  world.add_joint({.kind = JointKind::ball,
                   .body_a = wall,
                   .body_b = rod,
                   .X_BJ = {Quat<S>::Identity(), {-length / S(2), S(0), S(0)}}});
  advance(world, 0.4);
  return (world.pose(rod) * Vec3<S>(length / S(2), S(0), S(0))).z();
};

/// [m/s] Speed of a body with damping after 0.4 s: alone, or on a ball joint to the world.
template <typename S>
S slowed(S rate, bool is_joined) {
  World<S> world({.time_step = S(2e-3)});
  const BodyId rod = world.add_body({.mass = S(1.5),
                                     .shape = Box<S>{{S(0.2), S(0.02), S(0.03)}},
                                     .position = {S(0.2), S(0), S(0)},
                                     .velocity = {S(0), S(1), S(0)},
                                     .linear_damping = rate,
                                     .angular_damping = rate});
  if (is_joined) {
    world.add_joint({.kind = JointKind::ball,
                     .body_b = rod,
                     .X_BJ = {Quat<S>::Identity(), {S(-0.2), S(0), S(0)}}});
  }
  advance(world, 0.4);
  return world.body(rod).twist.linear.y();
}

/// A grasp that has come to rest.
template <typename S>
GraspScene<S> held(S mass, S static_friction, Integration integration, S finger_mass, S grip) {
  GraspDef<S> def;
  def.part_mass = mass;
  def.static_friction = static_friction;
  def.integration = integration;
  def.finger_mass = finger_mass;
  def.grip = grip;
  def.sliding_friction = S(4);
  auto scene = make_grasp<S>(def);
  scene.run(S(2));
  return scene;
}

}  // namespace

TEST_CASE("gradients: a thrown body, by gravity and by its speed") {
  // z = v t - g t^2 / 2 exactly; 500 steps of round-off.
  const D z = differentiated(thrown, 9.81, 2);
  CHECK(z.value() == thrown(9.81, 2.0));
  CHECK(z.partial(0) == test::relative(-0.125).epsilon(1e-12));
  CHECK(z.partial(1) == test::relative(0.5).epsilon(1e-12));
}

TEST_CASE("gradients: a bounce, by restitution and by height") {
  // After t1 = sqrt(2 h / g): z = e g t1 (t - t1) - g (t - t1)^2 / 2, with
  // dt1/dh = 1 / (g t1) and dz/dt1 = g (e (t - 2 t1) + t - t1).
  const double e = 0.6;
  const double h = 0.3;
  const double t1 = std::sqrt(2 * h / 9.81);
  const double rest = 0.5 - t1;
  const D z = differentiated(bounced, e, h);
  CHECK(z.value() == test::relative(bounced(e, h)).epsilon(1e-12));
  CHECK(z.value() == test::relative(e * 9.81 * t1 * rest - 9.81 * rest * rest / 2).epsilon(1e-9));
  CHECK(z.partial(0) == test::relative(9.81 * t1 * rest).epsilon(1e-9));
  CHECK(z.partial(1) == test::relative((e * (rest - t1) + rest) / t1).epsilon(1e-9));
}

TEST_CASE("gradients: how far a box slides until it rests, by friction and by its speed") {
  // v^2 / (2 mu g). The step in which it stops is shared linearly: up to half a step of v more.
  const double mu = 0.4;
  const double v = 1.3;
  const double rate = mu * 9.81;
  const D x = differentiated(slid, mu, v);
  const double step = 1e-3 / 2;
  CHECK(x.value() == test::relative(v * v / 2 / rate).epsilon(1e-5));
  CHECK(std::abs(x.partial(1) - v / rate) < step);
  CHECK(std::abs(x.partial(0) + v * v / 2 / rate / mu) < step * v / mu);
  check_differences(slid, mu, v, 1e-5, 1e-4);
}

TEST_CASE("gradients: a box on a slope slides by mu and angle, or rests without derivatives") {
  // x = (sin a - mu cos a) g t^2 / 2.
  const double a = 0.5;
  const double fall = 9.81 * 0.3 * 0.3 / 2;
  const D x = differentiated(slid_down, 0.3, a);
  CHECK(x.value() == test::relative(fall * (std::sin(a) - 0.3 * std::cos(a))).epsilon(1e-7));
  CHECK(x.partial(0) == test::relative(-fall * std::cos(a)).epsilon(1e-7));
  CHECK(x.partial(1) == test::relative(fall * (std::cos(a) + 0.3 * std::sin(a))).epsilon(1e-7));
  const D resting = differentiated(slid_down, 0.7, a);
  CHECK(std::abs(resting.value()) < 1e-9);
  CHECK(std::abs(resting.partial(0)) < 1e-9);
  CHECK(std::abs(resting.partial(1)) < 1e-9);
}

TEST_CASE("gradients: a rod that swings on a ball joint, by its length and by gravity") {
  // Substeps end where values say, so differences jump by what an integration leaves: 1e-7 here.
  check_differences(swung, 0.8, 9.81, 1e-3, 1e-4);
}

TEST_CASE("gradients: the sag of a grasped part, by its mass and by mu_S") {
  // F / (mu_S N), with both pads pressed to 10 N or driven with it.
  const double m = 0.5;
  const double mu_S = 1000;
  for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
    for (const double finger_mass : {0.0, 0.3}) {
      if (integration == Integration::explicit_ && finger_mass > 0) continue;
      INFO("explicit: ", integration == Integration::explicit_, ", fingers of ", finger_mass);
      const auto scene =
          held<D>(D::variable(m, 0), D::variable(mu_S, 1), integration, D(finger_mass), D(10));
      const double sag = m * 9.81 / (mu_S * 20);
      CHECK(scene.sag().value() == test::relative(sag).epsilon(1e-5));
      CHECK(scene.sag().partial(0) == test::relative(sag / m).epsilon(1e-5));
      CHECK(scene.sag().partial(1) == test::relative(-sag / mu_S).epsilon(1e-5));
      // The fingers read the weight, whatever mu_S is.
      D shear = 0;
      for (const PatchId pad : scene.pads) shear += scene.world.reading(pad).shear_W.z();
      CHECK(std::abs(shear.value()) == test::relative(m * 9.81).epsilon(1e-5));
      CHECK(std::abs(shear.partial(0)) == test::relative(9.81).epsilon(1e-4));
      CHECK(std::abs(shear.partial(1)) < 1e-4 * m * 9.81 / mu_S);
    }
  }
}

TEST_CASE("gradients: the sag of a part between driven fingers, by the force of their drives") {
  const D grip = D::variable(10, 0);
  const auto scene = held<D>(D(0.5), D(1000), Integration::implicit, D(0.3), grip);
  const double sag = 0.5 * 9.81 / (1000 * 20);
  CHECK(scene.sag().partial(0) == test::relative(-sag / 10).epsilon(1e-4));
  CHECK(scene.total_normal().partial(0) == test::relative(2).epsilon(1e-5));
}

TEST_CASE("gradients: variables may be marked once a scene has settled") {
  // Nothing of what is converged then moves, but what depends on the mark does.
  auto scene = held<D>(D(0.5), D(1000), Integration::implicit, D(0.0), D(10));
  REQUIRE(scene.sag().partial(0) == 0);
  scene.world.set_gravity({D(0), D(0), -D::variable(9.81, 0)});
  scene.run(D(2));
  CHECK(scene.sag().partial(0) == test::relative(0.5 / (1000 * 20)).epsilon(1e-5));

  // Five cubes on each other: what each is carried with follows at once, and all stay. To the 1e-8
  // that solvers leave of a step, 17 ms.
  auto stack = make_stack<D>({});
  stack.run(D(2));
  stack.world.set_gravity({D(0), D(0), -D::variable(9.81, 0)});
  const double dt = stack.world.time_step().value();
  for (int i = 0; i < 5; ++i) {
    stack.world.step();
    for (const BodyId cube : stack.cubes) {
      INFO("step ", i, ", cube ", cube.index);
      CHECK(std::abs(stack.world.contact_impulse(cube).force.z().partial(0) - dt) < 1e-7 * dt);
      CHECK(std::abs(stack.world.body(cube).twist.linear.z().partial(0)) < 1e-7 * dt);
      CHECK(std::abs(stack.world.pose(cube).translation.z().partial(0)) < 1e-7 * dt * dt);
    }
  }
}

TEST_CASE("gradients: a bit of everything has the values of the world without, and no NaN") {
  auto with = make_medley<D>({.gravity = {D(0), D::variable(0, 1), -D::variable(9.81, 0)}});
  auto without = make_medley<double>();
  for (int i = 0; i < 100; ++i) {
    with.world.step();
    without.world.step();
  }
  for (std::size_t k = 0; k < with.bodies.size(); ++k) {
    INFO("body ", k);
    const Vec3<D> p = with.world.pose(with.bodies[k]).translation;
    const Vec3<double> q = without.world.pose(without.bodies[k]).translation;
    // Solvers end at 1e-8 of the speed that gravity gives in a step.
    CHECK((p.cast<double>() - q).norm() < 1e-7);
    for (const D& x : p) CHECK((std::isfinite(x.partial(0)) && std::isfinite(x.partial(1))));
  }
  CHECK(with.world.report().frozen_bodies == 0);
}

TEST_CASE("gradients: snapshots keep derivatives, and hashes tell them") {
  const auto make = [](const D& gravity) {
    return make_medley<D>({.gravity = {D(0), D(0), -gravity}});
  };
  auto first = make(D::variable(9.81, 0));
  auto second = make(D::variable(9.81, 0));
  auto constant = make(D(9.81));
  for (auto* m : {&first, &second, &constant}) {
    for (int i = 0; i < 20; ++i) m->world.step();
  }
  CHECK(first.world.state_hash() == second.world.state_hash());
  CHECK(first.world.state_hash() != constant.world.state_hash());
  const std::vector<std::byte> bytes = first.world.snapshot();
  for (int i = 0; i < 10; ++i) first.world.step();
  const std::uint64_t later = first.world.state_hash();
  first.world.restore(bytes);
  CHECK(first.world.state_hash() == second.world.state_hash());
  for (int i = 0; i < 10; ++i) first.world.step();
  CHECK(first.world.state_hash() == later);
  CHECK_THROWS_AS(make_medley<double>().world.restore(bytes), InvalidArgument);
}

TEST_CASE("gradients: by a rate of damping that is zero, alone and on a joint") {
  for (const bool is_joined : {false, true}) {
    const D v = slowed(D::variable(0, 0), is_joined);
    CHECK(v.value() == test::relative(slowed(0.0, is_joined)).epsilon(1e-12));
    const double by_rate = (slowed(1e-5, is_joined) - slowed(0.0, is_joined)) / 1e-5;
    CHECK(std::abs(by_rate) > 0.01);
    CHECK(v.partial(0) == test::relative(by_rate).epsilon(1e-4));
  }
}

// Worlds with derivatives take the convex problems, whose opening speeds must not follow the creep
// of what sticks (docs/decisions/0050-opening-speeds-follow-slip.md): the floor sank by a tenth of
// the free fall of a step in half a second, and faster and faster.
TEST_CASE("worlds with derivatives: nine cubes that four plates press together stay up") {
  for (const double press : {1.5, 2.0}) {
    CAPTURE(press);
    auto floor = make_squeezed_floor<D>(240, press, false);
    floor.run(0.5, 0);
    CHECK(floor.sag() < 1e-6 * step_fall(240));
  }
}
