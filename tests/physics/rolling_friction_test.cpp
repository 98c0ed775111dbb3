/// @file
/// Rolling friction against closed forms of what rolls, is held, and is carried on wheels.
///
/// A body of mass m, moment of inertia k m R^2 and radius R that rolls on a plane under gravity g
/// is slowed by the torque delta m g: a = g (delta / R) / (1 + k).
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/bristle.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

using namespace bristle;
using namespace bristle::detail;

namespace {

constexpr double rolling_gravity = 9.81;
constexpr double rolling_radius = 0.1;
constexpr double rolling_lever = 0.002;

template <Scalar S>
WorldDef<S> rolling_world(S dt, Integrator integrator = Integrator::trapezoidal) {
  return {.gravity = {S(0), S(0), S(-rolling_gravity)}, .time_step = dt, .integrator = integrator};
}

/// A plane whose uphill direction is `angle` [rad] above -x, and that resists rolling.
template <Scalar S>
BodyDef<S> rolling_ground(S angle = S(0)) {
  return {.motion = Motion::fixed,
          .shape = HalfSpace<S>{{std::sin(angle), S(0), std::cos(angle)}, S(0)},
          .material = {.friction = S(0.6), .rolling_friction = S(rolling_lever)}};
}

/// A ball on that plane that rolls along `velocity`.
template <Scalar S>
BodyDef<S> rolling_ball(const Vec3<S>& velocity, S angle = S(0)) {
  const Vec3<S> n(std::sin(angle), S(0), std::cos(angle));
  return {.mass = S(1),
          .shape = Sphere<S>{S(rolling_radius)},
          .material = {.friction = S(0.6)},
          .position = S(rolling_radius) * n,
          .velocity = velocity,
          .angular_velocity = (S(1) / S(rolling_radius)) * n.cross(velocity)};
}

}  // namespace

// a = 5/7 g delta / R. The first step has no load of a last one, and rolls freely.
TEST_CASE_TEMPLATE("rolling friction: slows a ball by 5/7 g delta / R, straight on", S, double,
                   float) {
  const double a = 5.0 / 7.0 * rolling_gravity * rolling_lever / rolling_radius;
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    for (const double dt : {1.0 / 60, 1.0 / 240, 1e-3}) {
      CAPTURE(dt);
      World<S> world(rolling_world(S(dt), integrator));
      world.add_body(rolling_ground<S>());
      // Along no axis of the contact: its friction is a disk, not a square.
      const Vec3<S> direction(S(0.6), S(0.8), S(0));
      const BodyId ball = world.add_body(rolling_ball<S>(direction));
      const int steps = static_cast<int>(std::lround(2.0 / dt));
      for (int i = 0; i < steps; ++i) world.step();
      const auto v = world.body(ball).twist.linear;
      const double expected = 1.0 - a * dt * (steps - 1);
      // Digits of the solver's tolerance, or of the sum of so many steps in float.
      const double digits = sizeof(S) == sizeof(double) ? 1e-7 : 2e-4;
      CHECK(static_cast<double>(v.dot(direction)) == test::relative(expected).epsilon(digits));
      CHECK(std::abs(v.dot(Vec3<S>(S(-0.8), S(0.6), S(0)))) < S(digits));
    }
  }
}

// Its way is v^2 / (2 a). A step in which it stops adds at most half of what it goes in one.
TEST_CASE("rolling friction: stops a ball for good, after v^2 / (2 a)") {
  const double a = 5.0 / 7.0 * rolling_gravity * rolling_lever / rolling_radius;
  const double v = 0.5;
  const double dt = 1.0 / 240;
  World<double> world(rolling_world(dt));
  world.add_body(rolling_ground<double>());
  const BodyId ball = world.add_body(rolling_ball<double>({v, 0, 0}));
  const int stopped = static_cast<int>(std::ceil(v / (a * dt))) + 2;
  for (int i = 0; i < stopped; ++i) world.step();
  const Vec3<double> at = world.pose(ball).translation;
  CHECK(at.x() == test::relative(v * v / (2 * a) + v * dt).epsilon(1e-4));
  for (int i = 0; i < 240; ++i) world.step();
  CHECK((world.pose(ball).translation - at).norm() < 1e-12);
  CHECK(world.body(ball).twist.angular.norm() < 1e-10);
  CHECK(world.report().factorisations == 0);
}

TEST_CASE("rolling friction: a slope up to delta / R holds a ball, a steeper one does not") {
  const double dt = 1.0 / 240;
  for (const double share : {0.5, 0.99, 1.01, 2.0}) {
    CAPTURE(share);
    const double angle = std::atan(share * rolling_lever / rolling_radius);
    World<double> world(rolling_world(dt));
    world.add_body(rolling_ground<double>(angle));
    const BodyId ball = world.add_body(rolling_ball<double>({0, 0, 0}, angle));
    // The first step of a contact rolls freely: it has to be stopped, and is.
    for (int i = 0; i < 240; ++i) world.step();
    const Vec3<double> at = world.pose(ball).translation;
    const double start = world.body(ball).twist.linear.norm();
    for (int i = 0; i < 480; ++i) world.step();
    if (share < 1) {
      CHECK((world.pose(ball).translation - at).norm() < 1e-12);
      continue;
    }
    const double a = 5.0 / 7.0 * rolling_gravity *
                     (std::sin(angle) - rolling_lever / rolling_radius * std::cos(angle));
    const double gained = world.body(ball).twist.linear.norm() - start;
    CHECK(gained == test::relative(a * 2.0).epsilon(1e-6));
  }
}

// A cylinder on its side touches along a line: k = 1/2, and the load is on two points.
TEST_CASE("rolling friction: counts once however many points carry the load") {
  World<double> world(rolling_world(1.0 / 240));
  world.add_body(rolling_ground<double>());
  BodyDef<double> roller{.mass = 2.0,
                         .shape = Cylinder<double>{rolling_radius, 0.15},
                         .material = {.friction = 0.6},
                         .position = {0, 0, rolling_radius},
                         .orientation = {std::sqrt(0.5), std::sqrt(0.5), 0, 0},
                         .velocity = {1, 0, 0}};
  roller.angular_velocity = {0, 1 / rolling_radius, 0};
  const BodyId id = world.add_body(roller);
  for (int i = 0; i < 240; ++i) world.step();
  const double a = rolling_gravity * rolling_lever / rolling_radius / 1.5;
  const double expected = 1.0 - a * 239.0 / 240.0;
  CHECK(world.body(id).twist.linear.x() == test::relative(expected).epsilon(1e-6));
}

// A cart of mass M on four wheels m, k = 2/5: a = g (delta / R) (M + 4 m) / (M + 4 m (1 + k)). Its
// wheels hang on hinges, whose mechanism moves as it does without contacts.
TEST_CASE("rolling friction: of its wheels slows a cart") {
  const double M = 4.0, m = 0.5, k = 0.4;
  World<double> world(rolling_world(1.0 / 240));
  world.add_body(rolling_ground<double>());
  BodyDef<double> def{.mass = M,
                      .shape = Box<double>{{0.4, 0.15, 0.02}},
                      .position = {0, 0, rolling_radius},
                      .velocity = {1, 0, 0}};
  const BodyId cart = world.add_body(def);
  const Quat<double> hinge(std::sqrt(0.5), 0, 0,
                           std::sqrt(0.5));  // x of a hinge is its axis: y here
  for (const double x : {-0.3, 0.3}) {
    for (const double y : {-0.3, 0.3}) {
      BodyDef<double> wheel = rolling_ball<double>({1, 0, 0});
      wheel.mass = m;
      wheel.position += Vec3<double>(x, y, 0);
      const BodyId id = world.add_body(wheel);
      world.add_joint({.kind = JointKind::revolute,
                       .body_a = cart,
                       .body_b = id,
                       .X_AJ = {hinge, {x, y, 0}},
                       .X_BJ = {hinge, {0, 0, 0}}});
    }
  }
  for (int i = 0; i < 24; ++i) world.step();
  const double start = world.body(cart).twist.linear.x();
  for (int i = 0; i < 240; ++i) world.step();
  const double a =
      rolling_gravity * rolling_lever / rolling_radius * (M + 4 * m) / (M + 4 * m * (1 + k));
  CHECK(start - world.body(cart).twist.linear.x() == test::relative(a).epsilon(1e-5));
}

// One ball rolls on another in free space, pressed on by a force at each centre.
TEST_CASE("rolling friction: acts equally on both bodies, and its reading is what it did") {
  World<double> world({.gravity = {0, 0, 0}, .time_step = 1e-3});
  std::vector<BodyId> balls;
  for (const double side : {-1.0, 1.0}) {
    BodyDef<double> def = rolling_ball<double>({0, 0, 0});
    def.material.rolling_friction = rolling_lever;
    def.position = {0, 0, side * rolling_radius};
    def.angular_velocity = {0, side * 3.0, side};
    balls.push_back(world.add_body(def));
  }
  const double inertia = 0.4 * rolling_radius * rolling_radius;
  double slowest = 3.0;
  for (int i = 0; i < 200; ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      const double side = k == 0 ? -1.0 : 1.0;
      world.apply_wrench(balls[k], {{0, 0, -5.0 * side}, {0, 0, 0}});
    }
    const Vec3<double> before = world.body(balls[1]).twist.angular;
    world.step();
    const Vec3<double> w0 = world.body(balls[0]).twist.angular;
    const Vec3<double> w1 = world.body(balls[1]).twist.angular;
    CHECK((w0 + w1).norm() < 1e-9);
    const Wrench<double> read = world.contact_impulse(balls[1], balls[0]);
    CHECK((inertia * (w1 - before) - read.torque).norm() < 1e-12);
    CHECK(w1.y() <= slowest);
    slowest = w1.y();
  }
  // I w' = -delta N about y. What turns about the normal is not slowed.
  CHECK(world.body(balls[1]).twist.angular.y() ==
        test::relative(3.0 - 0.199 * rolling_lever * 5.0 / inertia).epsilon(1e-6));
  CHECK(world.body(balls[1]).twist.angular.z() == test::relative(1.0).epsilon(1e-9));
}

// 48 balls of which some resist rolling fall on each other: energy falls, and they come to rest.
TEST_CASE("rolling friction: takes energy out of a heap, and brings it to rest") {
  World<double> world(rolling_world(1.0 / 240));
  world.add_body(rolling_ground<double>());
  std::vector<BodyId> balls;
  for (int i = 0; i < 48; ++i) {
    BodyDef<double> def = rolling_ball<double>({0, 0, 0});
    const double row = i % 4, column = i / 4 % 4, layer = i / 16;
    def.position = {0.21 * row + 0.03 * layer, 0.21 * column + 0.02 * layer, 0.1 + 0.205 * layer};
    balls.push_back(world.add_body(def));
  }
  const auto energy = [&] {
    double sum = 0;
    for (const BodyId id : balls) {
      const Twist<double>& v = world.body(id).twist;
      sum += 0.5 * v.linear.squaredNorm() +
             0.2 * rolling_radius * rolling_radius * v.angular.squaredNorm() +
             rolling_gravity * world.pose(id).translation.z();
    }
    return sum;
  };
  const double start = energy();
  double last = start;
  for (int i = 0; i < 240 * 20; ++i) {
    world.step();
    const double now = energy();
    CHECK(now < last + 1e-6 * start);
    last = now;
  }
  // A turn about the vertical is no rolling.
  for (const BodyId id : balls) {
    CHECK(world.body(id).twist.linear.norm() < 1e-6);
    CHECK(world.body(id).twist.angular.head<2>().norm() < 1e-5);
  }
}

TEST_CASE("rolling friction: holds on when the length of steps changes") {
  const double angle = std::atan(0.9 * rolling_lever / rolling_radius);
  World<double> world(rolling_world(1.0 / 240));
  world.add_body(rolling_ground<double>(angle));
  const BodyId ball = world.add_body(rolling_ball<double>({0, 0, 0}, angle));
  for (int i = 0; i < 240; ++i) world.step();
  const Vec3<double> at = world.pose(ball).translation;
  for (const double dt : {1.0 / 60, 1e-3, 1.0 / 120}) {
    world.set_time_step(dt);
    for (int i = 0; i < 60; ++i) world.step();
    CHECK((world.pose(ball).translation - at).norm() < 1e-12);
  }
}

// What is held has no velocity that would tell its torque.
TEST_CASE("rolling friction: another world goes on from a snapshot with the same bits") {
  for (const double speed : {0.0, 0.2}) {
    const auto make = [&] {
      World<double> world(rolling_world(1.0 / 240));
      world.add_body(rolling_ground<double>(0.015));
      world.add_body(rolling_ball<double>({0.5 * speed, speed, 0}, 0.015));
      return world;
    };
    World<double> world = make();
    for (int i = 0; i < 100; ++i) world.step();
    World<double> other = make();
    other.restore(world.snapshot());
    CHECK(other.state_hash() == world.state_hash());
    for (int i = 0; i < 50; ++i) world.step();
    for (int i = 0; i < 50; ++i) other.step();
    CHECK(other.state_hash() == world.state_hash());
  }
}

// Without factorisations every island counts as large: four substeps, each with its part of the
// bounds.
TEST_CASE("rolling friction: has its part of the bounds in each substep of what is swept") {
  WorldDef<double> def = rolling_world(1.0 / 60);
  def.solver.max_direct_work = 0;
  World<double> world(def);
  world.add_body(rolling_ground<double>());
  const BodyId ball = world.add_body(rolling_ball<double>({1, 0, 0}));
  for (int i = 0; i < 60; ++i) world.step();
  const double a = 5.0 / 7.0 * rolling_gravity * rolling_lever / rolling_radius;
  CHECK(world.body(ball).twist.linear.x() == test::relative(1 - a * 59.0 / 60.0).epsilon(1e-6));
}

TEST_CASE("rolling friction: holds a ball that sleeps, and that is woken again") {
  const double angle = std::atan(0.9 * rolling_lever / rolling_radius);
  WorldDef<double> def = rolling_world(1.0 / 240);
  def.sleep.time = 0.5;
  World<double> world(def);
  world.add_body(rolling_ground<double>(angle));
  const BodyId ball = world.add_body(rolling_ball<double>({0, 0, 0}, angle));
  for (int i = 0; i < 480; ++i) world.step();
  CHECK(world.is_asleep(ball));
  const Vec3<double> at = world.pose(ball).translation;
  world.wake(ball);
  for (int i = 0; i < 30; ++i) world.step();
  CHECK((world.pose(ball).translation - at).norm() < 1e-12);
}

// Joints of a world may come and go while contacts have rows of their own.
TEST_CASE("rolling friction: rolls on after the last joint of its world is gone") {
  World<double> world(rolling_world(1.0 / 60));
  world.add_body(rolling_ground<double>());
  BodyDef<double> far = rolling_ball<double>({0, 0, 0});
  far.position = {-5, 0, 5};
  const BodyId a = world.add_body(far);
  const JointId joint =
      world.add_joint({.body_a = a, .X_BJ = {Quat<double>::Identity(), far.position}});
  world.step();
  world.remove_joint(joint);
  for (int i = 0; i < 40; ++i) {
    far.position.y() += 1;
    (void)world.add_body(far);
  }
  // 50 rad/s: more than half a radian a step.
  const BodyId ball = world.add_body(rolling_ball<double>({5, 0, 0}));
  for (int i = 0; i < 60; ++i) world.step();
  const double slowing = 5.0 / 7.0 * rolling_gravity * rolling_lever / rolling_radius;
  CHECK(world.body(ball).twist.linear.x() ==
        test::relative(5.0 - slowing * 59.0 / 60.0).epsilon(1e-6));
}

// A cart that stands on a slope of which its wheels hold a part: they are light, so what is missing
// in the motion of the mechanism would spin them.
TEST_CASE("rolling friction: of light wheels holds a cart on a slope") {
  const double angle = std::atan(0.5 * rolling_lever / rolling_radius);
  World<double> world(rolling_world(1.0 / 240));
  world.add_body(rolling_ground<double>(angle));
  const Quat<double> tilt(std::cos(angle / 2), 0, std::sin(angle / 2), 0);
  const auto along = [&](double x, double y) -> Vec3<double> {
    return tilt * Vec3<double>(x, y, rolling_radius);
  };
  const BodyId cart = world.add_body({.mass = 10.0,
                                      .shape = Box<double>{{0.4, 0.15, 0.02}},
                                      .position = along(0, 0),
                                      .orientation = tilt});
  const Quat<double> hinge(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
  for (const double x : {-0.3, 0.3}) {
    for (const double y : {-0.3, 0.3}) {
      BodyDef<double> wheel = rolling_ball<double>({0, 0, 0});
      wheel.mass = 1e-5;
      wheel.position = along(x, y);
      wheel.orientation = tilt;
      world.add_joint({.kind = JointKind::revolute,
                       .body_a = cart,
                       .body_b = world.add_body(wheel),
                       .X_AJ = {hinge, {x, y, 0}},
                       .X_BJ = {hinge, {0, 0, 0}}});
    }
  }
  for (int i = 0; i < 240; ++i) world.step();
  const Vec3<double> at = world.pose(cart).translation;
  CHECK((at - along(0, 0)).norm() < 1e-5);
  for (int i = 0; i < 240; ++i) world.step();
  CHECK((world.pose(cart).translation - at).norm() < 1e-9);
}

TEST_CASE("rolling friction: has a row where a ball rolls, two where it is held, and else none") {
  const auto rows = [](double lever, double speed) {
    World<double> world(rolling_world(1.0 / 240));
    BodyDef<double> ground = rolling_ground<double>(0.5 * rolling_lever / rolling_radius);
    ground.material.rolling_friction = lever;
    world.add_body(ground);
    world.add_body(rolling_ball<double>({0, speed, 0}, 0.5 * rolling_lever / rolling_radius));
    for (int i = 0; i < 10; ++i) world.step();
    return world.report().rows;
  };
  CHECK(rows(0, 1) == 3);
  CHECK(rows(rolling_lever, 1) == 3 + 1);
  CHECK(rows(rolling_lever, 0) == 3 + 2);
}

TEST_CASE("rolling friction: negative or not finite is refused by name") {
  World<double> world;
  for (const double wrong : {-1e-3, std::nan(""), infinity<double>}) {
    BodyDef<double> ball = rolling_ball<double>({0, 0, 0});
    ball.material.rolling_friction = wrong;
    CHECK_THROWS_WITH_AS((void)world.add_body(ball),
                         doctest::Contains("Material::rolling_friction"), InvalidArgument);
  }
}

// The bound of what crushes is a multiple of what acts, and rolling friction only resists.
TEST_CASE("rolling friction: adds nothing to the impulse of a ball that is crushed") {
  const auto largest = [](double lever) {
    World<double> world(rolling_world(1.0 / 240));
    BodyDef<double> ground = rolling_ground<double>();
    ground.material.rolling_friction = lever;
    world.add_body(ground);
    const BodyId ball = world.add_body(rolling_ball<double>({0, 0, 0}));
    world.add_body({.motion = Motion::kinematic,
                    .shape = Box<double>{{1, 1, 0.1}},
                    .material = ground.material,
                    .position = {0, 0, 2 * rolling_radius + 0.11},
                    .velocity = {0, 0, -0.1}});
    double most = 0;
    for (int i = 0; i < 72; ++i) {
      world.step();
      world.for_each_contact([&](const ContactReading<double>& contact) {
        contact.for_each_point(
            [&](const auto& point) { most = std::max(most, point.normal_impulse); });
      });
    }
    CHECK(world.body(ball).twist.linear.norm() < 1);
    return most;
  };
  const double without = largest(0);
  CHECK(without > 0.1);
  for (const double lever : {rolling_lever, 10 * rolling_lever}) {
    CHECK(largest(lever) <= without * (1 + 1e-6));
  }
}
