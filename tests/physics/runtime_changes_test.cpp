/// @file
/// What a host changes in a running world: damping, gravity, impulses, limits and springs of
/// joints, against closed forms.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

using namespace bristle;

namespace {

/// A ball of 2 kg without gravity, and a box on a slide along x at the world.
template <typename S>
struct ChangedScene {
  World<S> world;
  BodyId ball, box;
  JointId slide;

  explicit ChangedScene(Integrator integrator = Integrator::trapezoidal)
      : world(definition(integrator)) {
    ball = world.add_body({.motion = Motion::dynamic,
                           .mass = S(2),
                           .shape = Sphere<S>{S(0.5)},
                           .position = {S(5), S(0), S(0)}});
    box = world.add_body(
        {.motion = Motion::dynamic, .mass = S(1), .shape = Box<S>{{S(0.1), S(0.2), S(0.3)}}});
    JointDef<S> def;
    def.kind = JointKind::prismatic;
    def.body_b = box;
    slide = world.add_joint(def);
  }

  void run(double seconds) {
    const long steps = std::lround(seconds / static_cast<double>(world.time_step()));
    for (long i = 0; i < steps; ++i) world.step();
  }

 private:
  static WorldDef<S> definition(Integrator integrator) {
    WorldDef<S> def;
    def.integrator = integrator;
    def.gravity = bristle::detail::zero<Vec3<S>>();
    def.time_step = S(1) / S(256);
    return def;
  }
};

}  // namespace

TEST_CASE_TEMPLATE(
    "an impulse off the centre turns a ball by its arm, and both momenta are its own", S, float,
    double) {
  ChangedScene<S> scene;
  const Vec3<S> impulse(S(0), S(3), S(1));
  const Vec3<S> arm(S(0.5), S(0), S(0));
  scene.world.apply_impulse(scene.ball, impulse, scene.world.pose(scene.ball).translation + arm);
  const Body<S>& ball = scene.world.body(scene.ball);
  CHECK((ball.mass * ball.twist.linear - impulse).norm() < S(1e-6));
  CHECK((ball.angular_momentum() - arm.cross(impulse)).norm() < S(1e-6));
  // It acts at once, and once.
  scene.run(1);
  CHECK((ball.mass * ball.twist.linear - impulse).norm() < S(1e-5));
}

TEST_CASE("an impulse moves no locked axis") {
  World<double> world;
  BodyDef<double> def{.motion = Motion::dynamic, .shape = Box<double>{{0.1, 0.2, 0.3}}};
  def.locked.linear = {true, false, false};
  def.locked.angular = {false, true, true};
  def.orientation = Quat<double>(0.6, 0.8, 0, 0);
  const BodyId box = world.add_body(def);
  world.apply_impulse(box, {1, 2, 3}, {0.1, -0.2, 0.3});
  const Twist<double>& twist = world.body(box).twist;
  CHECK(twist.linear.x() == 0);
  CHECK(twist.linear.y() == test::relative(2 / world.body(box).mass));
  CHECK(twist.angular.x() != 0);
  CHECK(twist.angular.y() == 0);
  CHECK(twist.angular.z() == 0);
}

TEST_CASE_TEMPLATE("damping and gravity scale that change while a body moves act from then on", S,
                   float, double) {
  ChangedScene<S> scene;
  scene.world.set_velocity(scene.ball, {{S(1), S(0), S(0)}, {S(0), S(0), S(4)}});
  scene.run(1);
  CHECK(scene.world.body(scene.ball).twist.linear.x() == S(1));
  scene.world.set_damping(scene.ball, S(0.5), S(0.25));
  scene.run(2);
  // exp(-rate t)
  const Twist<S>& twist = scene.world.body(scene.ball).twist;
  CHECK(twist.linear.x() == test::relative(S(std::exp(-1.0))).epsilon(1e-5));
  CHECK(twist.angular.z() == test::relative(S(4 * std::exp(-0.5))).epsilon(1e-5));
  scene.world.set_damping(scene.ball, S(0), S(0));
  scene.world.set_gravity({S(0), S(0), S(-10)});
  scene.world.set_gravity_scale(scene.ball, S(0.5));
  scene.run(1);
  CHECK(twist.linear.z() == test::relative(S(-5)).epsilon(1e-5));
}

TEST_CASE_TEMPLATE("limits that are set stop a slide there, and limits taken away let it go", S,
                   float, double) {
  ChangedScene<S> scene;
  World<S>& world = scene.world;
  world.set_velocity(scene.box, {{S(0.5), S(0), S(0)}, bristle::detail::zero<Vec3<S>>()});
  scene.run(1);
  CHECK(world.reading(scene.slide).position == test::relative(S(0.5)).epsilon(1e-4));
  world.set_limits(scene.slide, S(-0.25), S(0.75));
  scene.run(1);
  CHECK(world.reading(scene.slide).position == test::relative(S(0.75)).epsilon(1e-3));
  CHECK(std::abs(world.reading(scene.slide).velocity) < S(1e-4));
  world.set_limits(scene.slide, -infinity<S>, infinity<S>);
  world.set_velocity(scene.box, {{S(0.5), S(0), S(0)}, bristle::detail::zero<Vec3<S>>()});
  scene.run(1);
  CHECK(world.reading(scene.slide).position == test::relative(S(1.25)).epsilon(1e-3));
}

TEST_CASE("a spring that is set swings at sqrt(k / m), and one taken away lets go") {
  ChangedScene<double> scene;
  World<double>& world = scene.world;
  world.set_spring(scene.slide, {.stiffness = 4, .damping = 0, .rest = 0.1});
  const double seconds = 1;
  scene.run(seconds);
  // From rest at 0.1 m below the rest position, with w = 2 rad/s.
  CHECK(world.reading(scene.slide).position ==
        test::relative(0.1 * (1 - std::cos(2 * seconds))).epsilon(1e-4));
  world.set_spring(scene.slide, {});
  const double speed = world.reading(scene.slide).velocity;
  const double place = world.reading(scene.slide).position;
  scene.run(seconds);
  CHECK(world.reading(scene.slide).velocity == test::relative(speed).epsilon(1e-9));
  CHECK(world.reading(scene.slide).position ==
        test::relative(place + speed * seconds).epsilon(1e-9));
}

TEST_CASE("a spring that is taken away leaves no force behind") {
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    ChangedScene<double> scene(integrator);
    World<double>& world = scene.world;
    world.set_spring(scene.slide, {.stiffness = 1e6, .damping = 0, .rest = 0.1});
    world.step();
    CHECK(world.reading(scene.slide).reaction.force.x() > 1);
    world.set_spring(scene.slide, {});
    const Vec3<double> velocity = world.body(scene.box).twist.linear;
    world.step();
    CHECK(world.reading(scene.slide).reaction.force.x() == 0);
    CHECK(world.body(scene.box).twist.linear == velocity);
  }
}

TEST_CASE_TEMPLATE("a snapshot holds what was changed", S, float, double) {
  ChangedScene<S> changed;
  changed.world.set_damping(changed.ball, S(0.5), S(0.25));
  changed.world.set_gravity_scale(changed.ball, S(-2));
  changed.world.set_limits(changed.slide, S(-1), S(2));
  changed.world.set_spring(changed.slide, {.stiffness = S(3), .damping = S(1), .rest = S(0.5)});
  changed.world.set_gravity({S(1), S(2), S(3)});
  const auto then = changed.world.snapshot();
  ChangedScene<S> other;
  CHECK(other.world.state_hash() != changed.world.state_hash());
  other.world.restore(then);
  CHECK(other.world.body(other.ball).gravity_scale == S(-2));
  CHECK(other.world.joint(other.slide).def.upper_limit == S(2));
  changed.run(1);
  other.run(1);
  CHECK(other.world.state_hash() == changed.world.state_hash());
}

TEST_CASE("a change that breaks a rule names it, and nothing changes") {
  ChangedScene<double> scene;
  World<double>& world = scene.world;
  const BodyId floor = world.add_body(
      {.motion = Motion::fixed, .shape = HalfSpace<double>{}, .position = {0, 0, -9}});
  const std::uint64_t before = world.state_hash();
  const double nan = std::nan("");
  CHECK_THROWS_AS(world.set_damping(scene.ball, -1, 0), InvalidArgument);
  CHECK_THROWS_AS(world.set_damping(scene.ball, 0, nan), InvalidArgument);
  CHECK_THROWS_AS(world.set_damping(floor, 1, 1), InvalidArgument);
  CHECK_THROWS_AS(world.set_gravity_scale(scene.ball, nan), InvalidArgument);
  CHECK_THROWS_AS(world.set_gravity_scale(floor, 0), InvalidArgument);
  CHECK_THROWS_AS(world.apply_impulse(floor, {1, 0, 0}, {0, 0, 0}), InvalidArgument);
  CHECK_THROWS_AS(world.apply_impulse(scene.ball, {nan, 0, 0}, {0, 0, 0}), InvalidArgument);
  CHECK_THROWS_AS(world.apply_impulse(scene.ball, {1e150, 0, 0}, {0, 1e150, 0}), InvalidArgument);
  CHECK_THROWS_WITH_AS(world.set_limits(scene.slide, 1, -1),
                       doctest::Contains("JointDef::lower_limit"), InvalidArgument);
  CHECK_THROWS_WITH_AS(world.set_limits(scene.slide, -1, nan),
                       doctest::Contains("JointDef::lower_limit"), InvalidArgument);
  CHECK_THROWS_WITH_AS(world.set_spring(scene.slide, {.stiffness = -1}),
                       doctest::Contains("JointSpring::stiffness"), InvalidArgument);
  CHECK_THROWS_WITH_AS(world.apply_force(scene.ball, {nan, 0, 0}, {0, 0, 0}),
                       doctest::Contains("force[0]"), InvalidArgument);
  CHECK(world.state_hash() == before);
}

TEST_CASE("values that are no enumerators are refused by field") {
  World<double> world;
  const std::uint64_t before = world.state_hash();
  CHECK_THROWS_WITH_AS(world.add_body({.motion = static_cast<Motion>(7)}),
                       doctest::Contains("BodyDef::motion = 7"), InvalidArgument);
  ChangedScene<double> scene;
  JointDef<double> joint;
  joint.body_b = scene.box;
  joint.kind = static_cast<JointKind>(12);
  CHECK_THROWS_WITH_AS(scene.world.add_joint(joint), doctest::Contains("JointDef::kind = 12"),
                       InvalidArgument);
  CHECK_THROWS_WITH_AS(scene.world.set_motor(scene.slide, {.mode = static_cast<MotorMode>(-1)}),
                       doctest::Contains("JointMotor::mode = -1"), InvalidArgument);
  CHECK(world.state_hash() == before);
}

TEST_CASE("a body has its shapes in ascending order, whatever came and went") {
  World<double> world;
  std::vector<BodyId> bodies;
  for (int i = 0; i < 3; ++i) bodies.push_back(world.add_body({.motion = Motion::fixed}));
  std::vector<std::vector<ShapeId>> shapes(bodies.size());
  const auto check = [&] {
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      std::vector<ShapeId> found;
      world.for_each_shape(bodies[k],
                           [&](ShapeId id, const ShapeDef<double>&) { found.push_back(id); });
      std::vector<ShapeId> expected = shapes[k];
      std::sort(expected.begin(), expected.end());
      CHECK(found == expected);
    }
  };
  std::uint32_t random = 1;
  for (int i = 0; i < 300; ++i) {
    random = random * 1664525u + 1013904223u;
    const std::size_t k = (random >> 8) % bodies.size();
    std::vector<ShapeId>& own = shapes[k];
    if (own.size() < 8 && (random >> 20) % 3 != 0) {
      own.push_back(world.add_shape(bodies[k], {.shape = Sphere<double>{0.1}}));
    } else if (!own.empty()) {
      const std::size_t which = (random >> 12) % own.size();
      world.remove_shape(own[which]);
      own.erase(own.begin() + static_cast<std::ptrdiff_t>(which));
    }
    check();
  }
  world.remove_body(bodies[1]);
  for (const ShapeId id : shapes[1]) CHECK(!world.contains(id));
  bodies[1] = world.add_body({.motion = Motion::fixed});
  shapes[1].clear();
  check();
}
