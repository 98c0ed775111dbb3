/// @file
/// Revolute joints in a world: what they hold, how they turn, their limits and motors. Chains of
/// them without a world are tested with `MechanismIntegrator`.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/mechanism.hpp"
#include "support/momentum.hpp"
#include "support/numbers.hpp"
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::g;
using std::numbers::pi;
using V = Vec3<double>;

namespace {

/// A rod of 2 kg, 0.2 m along x.
template <typename S>
BodyDef<S> rod(const Vec3<S>& position, const Quat<S>& orientation = Quat<S>::Identity()) {
  BodyDef<S> def;
  def.mass = S(2);
  def.shape = Box<S>{{S(0.1), S(0.02), S(0.02)}};
  def.position = position;
  def.orientation = orientation;
  return def;
}
/// [kg m^2] Of such a rod about an end, across itself.
constexpr double about_end = 2 * ((0.01 + 0.0004) / 3 + 0.01);
/// [kg m^2] The same about its centre.
constexpr double about_centre = 2 * (0.01 + 0.0004) / 3;

/// Joint frames whose x axis is the world's y, for bodies along the world's axes: positive angles
/// lower what points along x.
const Quat<double> about_y = exp_rotation<double>({0, 0, pi / 2});

/// A rod hinged about y at its end, or at its centre, to something fixed at the origin; at angle
/// zero it points along x.
struct Hinge {
  World<double> world;
  BodyId frame{}, body{};
  JointId joint{};

  void run(double seconds) {
    const long steps = std::lround(seconds / world.time_step());
    for (long i = 0; i < steps; ++i) world.step();
  }
  [[nodiscard]] JointReading<double> reading() const { return world.reading(joint); }
  void set_rate(double rate, double arm) {
    world.set_velocity(body, {world.pose(body).rotate(V(0, 0, -rate * arm)), {0, rate, 0}});
  }
};

struct HingeDef {
  double arm = 0.1;
  double angle = 0;
  double dt = 1.0 / 240;
  double gravity = 0;
  JointDef<double> joint{};
};

Hinge make_hinge(HingeDef def) {
  WorldDef<double> world_def;
  world_def.time_step = def.dt;
  world_def.gravity = {0, 0, -def.gravity};
  Hinge hinge{World<double>(world_def), {}, {}, {}};
  hinge.frame = hinge.world.add_body({.motion = Motion::fixed});
  const Quat<double> turn = exp_rotation<double>({0, def.angle, 0});
  hinge.body = hinge.world.add_body(rod<double>(turn * V(def.arm, 0, 0), turn));
  def.joint.kind = JointKind::revolute;
  def.joint.body_a = hinge.frame;
  def.joint.body_b = hinge.body;
  def.joint.X_AJ = {about_y, {0, 0, 0}};
  def.joint.X_BJ = {about_y, {-def.arm, 0, 0}};
  hinge.joint = hinge.world.add_joint(def.joint);
  return hinge;
}

}  // namespace

TEST_CASE_TEMPLATE("revolute: a level rod on a stop hangs by its hinge", S, float, double) {
  WorldDef<S> world_def;
  world_def.time_step = S(1) / S(240);
  world_def.gravity = {0, 0, S(-10)};
  World<S> world(world_def);
  const BodyId wall = world.add_body({.motion = Motion::fixed, .position = {1, 1, 1}});
  const BodyId arm = world.add_body(rod<S>({S(1.1), 1, 1}));
  JointDef<S> def;
  def.kind = JointKind::revolute;
  def.body_a = wall;
  def.body_b = arm;
  def.X_AJ.rotation = about_y.cast<S>();
  def.X_BJ = {about_y.cast<S>(), {S(-0.1), 0, 0}};
  def.upper_limit = 0;
  const JointId joint = world.add_joint(def);
  for (int i = 0; i < 240; ++i) world.step();
  const double eps = static_cast<double>(Tolerance<S>::round_off());
  CHECK(static_cast<double>((world.pose(arm).translation - Vec3<S>(S(1.1), 1, 1)).norm()) <
        4 * eps);
  // The wall lifts 20 N, and turns against 20 N at 0.1 m, about -y.
  const JointReading<S> reading = world.reading(joint);
  CHECK(static_cast<double>(reading.reaction.force.z()) == test::relative(20).epsilon(100 * eps));
  CHECK(static_cast<double>(reading.reaction.torque.y()) == test::relative(-2).epsilon(100 * eps));
  // Each step may leave a part of what gravity gives in it, for all of the second.
  const double left = static_cast<double>(world.def().solver.tolerance) * 10 / 240;
  CHECK(std::abs(static_cast<double>(reading.position)) < 4 * eps + left);
  CHECK(reading.motor_force == S(0));
}

TEST_CASE("revolute: five rows are locked") {
  CHECK(locked_rows(JointKind::revolute) == 5);
  Hinge hinge = make_hinge({.joint = {.lower_limit = -1, .upper_limit = 1}});
  hinge.world.step();
  CHECK(hinge.world.report().rows == 7);
}

TEST_CASE("revolute: a pendulum keeps its period and energy at large swings") {
  // 120 degrees from hanging, which is 90 degrees below level.
  const double swing = 2 * pi / 3;
  const double w0 = std::sqrt(2 * g * 0.1 / about_end);
  const double period = test::pendulum_period(w0, swing);
  Hinge hinge = make_hinge({.angle = pi / 2 - swing, .dt = period / 400, .gravity = g});
  const double start = hinge.world.pose(hinge.body).translation.z();
  hinge.run(period / 2);
  CHECK(hinge.reading().position == test::relative(pi / 2 + swing).epsilon(1e-7));
  CHECK(std::abs(hinge.reading().velocity) < 1e-5);
  hinge.run(19.5 * period);
  // The error of one period is that of a fifth-order method, and twenty add up.
  CHECK(hinge.world.pose(hinge.body).translation.z() == test::relative(start).epsilon(1e-5));
  CHECK(std::abs(hinge.reading().position - (pi / 2 - swing)) < 1e-5);
}

TEST_CASE("revolute: stops that are not reached cost a pendulum nothing") {
  const double swing = 1, period = test::pendulum_period(std::sqrt(2 * g * 0.1 / about_end), swing);
  Hinge hinge = make_hinge({.angle = pi / 2 - swing,
                            .dt = period / 400,
                            .gravity = g,
                            .joint = {.lower_limit = 0, .upper_limit = pi}});
  hinge.run(20 * period);
  CHECK(std::abs(hinge.reading().position - (pi / 2 - swing)) < 1e-5);
}

TEST_CASE("revolute: a swinging rod is held by what it weighs and by its turn") {
  // Through the bottom: m g + m r w^2, with I w^2 / 2 = m g r from level.
  const double quarter = 0.25 * test::pendulum_period(std::sqrt(2 * g * 0.1 / about_end), pi / 2);
  Hinge hinge = make_hinge({.dt = quarter / 1000, .gravity = g});
  hinge.run(quarter);
  const double rate2 = 2 * 2 * g * 0.1 / about_end;
  CHECK(hinge.reading().velocity == test::relative(std::sqrt(rate2)).epsilon(1e-5));
  CHECK(hinge.reading().reaction.force.z() == test::relative(2 * (g + 0.1 * rate2)).epsilon(1e-4));
}

TEST_CASE("revolute: whole turns are counted, and a snapshot goes on with them") {
  for (const double rate : {7.0, -7.0, 500.0, -500.0}) {
    CAPTURE(rate);
    // At 500 rad/s a step of 1/100 s turns the rod by five radians: more than half a turn.
    Hinge hinge =
        make_hinge({.arm = 0, .dt = 0.01, .joint = {.motor = {MotorMode::velocity, rate, 1}}});
    hinge.set_rate(rate, 0);
    hinge.run(1);
    CHECK(hinge.reading().position == test::relative(rate).epsilon(1e-6));
    const auto saved = hinge.world.snapshot();
    hinge.run(1);
    const auto hash = hinge.world.state_hash();
    CHECK(hinge.reading().position == test::relative(2 * rate).epsilon(1e-6));
    hinge.world.restore(saved);
    CHECK(hinge.reading().position == test::relative(rate).epsilon(1e-6));
    hinge.run(1);
    CHECK(hinge.world.state_hash() == hash);
  }
}

TEST_CASE("revolute: the first angle lies within the limits where a turn does") {
  const auto start = [](double angle, double lower, double upper) {
    return make_hinge({.angle = angle, .joint = {.lower_limit = lower, .upper_limit = upper}})
        .reading()
        .position;
  };
  CHECK(start(1, -infinity<double>, infinity<double>) == test::relative(1));
  CHECK(start(-3, -infinity<double>, infinity<double>) == test::relative(-3));
  CHECK(start(-1, 4, 6) == test::relative(2 * pi - 1));
  CHECK(start(1, -infinity<double>, -5) == test::relative(1 - 2 * pi));
  // A little beyond a limit it stays there.
  CHECK(start(-0.1, 0, 10) == test::relative(-0.1));
}

TEST_CASE("revolute: stops hold at any angle, whole turns and all") {
  for (const double limit : {0.5, 3.0, pi, 4.0, 2 * pi, 20.0}) {
    for (const double side : {-1.0, 1.0}) {
      CAPTURE(limit);
      CAPTURE(side);
      JointDef<double> def;
      def.lower_limit = -limit;
      def.upper_limit = limit;
      Hinge hinge = make_hinge({.joint = def});
      hinge.set_rate(5 * side, 0.1);
      double farthest = 0;
      double stopped = 0;
      for (long i = std::lround((limit / 5 + 0.1) * 240); i > 0; --i) {
        hinge.world.step();
        farthest = std::max(farthest, side * hinge.reading().position);
        stopped += hinge.reading().reaction.torque.y() * hinge.world.time_step();
      }
      // It comes to rest there, by an impulse that takes its angular momentum.
      CHECK(farthest < limit + 1e-6);
      CHECK(side * hinge.reading().position == test::relative(limit).epsilon(1e-6));
      CHECK(std::abs(hinge.reading().velocity) < 1e-8);
      CHECK(side * stopped == test::relative(-5 * about_end).epsilon(1e-3));
    }
  }
}

TEST_CASE("revolute: a motor spins up at its torque limit, then holds its rate") {
  Hinge hinge = make_hinge({.arm = 0, .joint = {.motor = {MotorMode::velocity, 6, 0.02}}});
  // 0.02 N m on 2 (0.1^2 + 0.02^2) / 3 kg m^2.
  const double up = 0.02 / about_centre;
  hinge.run(1);
  CHECK(hinge.reading().velocity == test::relative(up).epsilon(1e-9));
  CHECK(hinge.reading().motor_force == test::relative(0.02).epsilon(1e-12));
  CHECK(hinge.reading().reaction.torque.y() == test::relative(0.02).epsilon(1e-9));
  hinge.run(1.5);
  CHECK(hinge.reading().velocity == test::relative(6).epsilon(1e-12));
  CHECK(std::abs(hinge.reading().motor_force) < 1e-9);
}

TEST_CASE("revolute: a motor holds a rod against its weight, as far as its torque goes") {
  // Level, at rest: 2 kg at 0.1 m.
  Hinge strong = make_hinge({.gravity = 10, .joint = {.motor = {MotorMode::velocity, 0, 3}}});
  strong.run(1);
  CHECK(std::abs(strong.reading().position) < 1e-9);
  CHECK(strong.reading().motor_force == test::relative(-2).epsilon(1e-9));
  Hinge weak = make_hinge({.gravity = 10, .joint = {.motor = {MotorMode::velocity, 0, 1}}});
  weak.run(10.0 / 240);
  // 2 N m of weight less 1 N m: for such small angles its lever is that of level.
  CHECK(weak.reading().velocity == test::relative(1 / about_end * 10 / 240).epsilon(0.02));
  CHECK(weak.reading().motor_force == test::relative(-1).epsilon(1e-12));
}

TEST_CASE("revolute: a position motor arrives without passing, also beyond a turn") {
  for (const double target : {1.0, -2.5, 9.0}) {
    CAPTURE(target);
    Hinge hinge = make_hinge({.joint = {.motor = {MotorMode::position, target, 0.5}}});
    // Up at a = tau / I, down at a / 2: the highest rate is sqrt(2 a |target| / 3), the time three
    // times that by a.
    const double time = std::sqrt(6 * std::abs(target) * about_end / 0.5);
    double farthest = 0;
    for (long i = std::lround(1.1 * time * 240 + 24); i > 0; --i) {
      hinge.world.step();
      farthest = std::max(farthest, hinge.reading().position / target);
    }
    CHECK(farthest < 1 + 1e-9);
    CHECK(hinge.reading().position == test::relative(target).epsilon(1e-6));
    CHECK(std::abs(hinge.reading().motor_force) < 1e-5);
  }
}

TEST_CASE("revolute: a motor between two free bodies keeps their momentum") {
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  world_def.time_step = 1e-3;
  World<double> world(world_def);
  const std::array<BodyId, 2> bodies{world.add_body(rod<double>({0.1, 0, 0})),
                                     world.add_body(rod<double>({0.3, 0, 0}))};
  JointDef<double> def;
  def.kind = JointKind::revolute;
  def.body_a = bodies[0];
  def.body_b = bodies[1];
  def.X_AJ = {about_y, {0.1, 0, 0}};
  def.X_BJ = {about_y, {-0.1, 0, 0}};
  def.motor = {MotorMode::velocity, 5, 0.1};
  const JointId joint = world.add_joint(def);
  for (int i = 0; i < 500; ++i) world.step();
  const auto after = test::momentum_of(world, std::span<const BodyId>(bodies));
  CHECK(world.reading(joint).velocity == test::relative(5).epsilon(1e-6));
  CHECK(after.force.norm() < 1e-12);
  // Each rod turns with 2.5 rad/s about the hinge's middle: of first order in the step.
  CHECK(after.torque.norm() < 1e-3 * 2.5 * about_end);
}

TEST_CASE("revolute: a four-bar linkage stays closed") {
  // A crank of 0.1 m, a coupler of 0.3 m and a rocker of 0.25 m on a base of 0.3 m: 0.1 + 0.3 is
  // less than 0.3 + 0.25, so the crank turns fully. All four axes are y.
  for (const bool is_driven : {false, true}) {
    CAPTURE(is_driven);
    WorldDef<double> world_def;
    World<double> world(world_def);
    const BodyId base = world.add_body({.motion = Motion::fixed});
    const V ground(0.3, 0, 0), tip(0, 0, 0.1);
    const double d = (ground - tip).norm(), along = (d * d + 0.3 * 0.3 - 0.25 * 0.25) / (2 * d);
    const V u = (ground - tip) / d, across(-u.z(), 0, u.x());
    const V pin = tip + along * u + std::sqrt(0.09 - along * along) * across;
    std::vector<JointDef<double>> joints;
    const std::vector<std::array<V, 2>> ends{{V(0, 0, 0), tip}, {tip, pin}, {pin, ground}};
    std::vector<BodyId> bars;
    for (const auto& [from, to] : ends) {
      const V direction = (to - from).normalized();
      BodyDef<double> def;
      def.mass = 0.5;
      def.shape = Box<double>{{(to - from).norm() / 2, 0.01, 0.01}};
      def.position = (from + to) / 2;
      def.orientation = exp_rotation<double>({0, -std::atan2(direction.z(), direction.x()), 0});
      bars.push_back(world.add_body(def));
    }
    const auto join = [&](BodyId a, BodyId b, const V& point, const JointMotor<double>& motor) {
      const Transform<double> X_WJ{about_y, point};
      JointDef<double> def;
      def.kind = JointKind::revolute;
      def.body_a = a;
      def.body_b = b;
      def.X_AJ = world.pose(a).inverse() * X_WJ;
      def.X_BJ = world.pose(b).inverse() * X_WJ;
      def.motor = motor;
      joints.push_back(def);
      return world.add_joint(def);
    };
    const JointId crank =
        join(base, bars[0], V(0, 0, 0), {is_driven ? MotorMode::velocity : MotorMode::none, 6, 50});
    join(bars[0], bars[1], tip, {});
    join(bars[1], bars[2], pin, {});
    join(bars[2], base, ground, {});
    double gap = 0, tilt = 0;
    const auto energy = [&] { return test::energy_of(world, std::span<const BodyId>(bars)); };
    const double start = energy();
    for (int i = 0; i < 5 * 240; ++i) {
      world.step();
      for (const JointDef<double>& joint : joints) {
        const Transform<double> A = world.pose(joint.body_a) * joint.X_AJ;
        const Transform<double> B = world.pose(joint.body_b) * joint.X_BJ;
        gap = std::max(gap, (A.translation - B.translation).norm());
        tilt = std::max(tilt, A.rotate(V::UnitX()).cross(B.rotate(V::UnitX())).norm());
      }
    }
    CHECK(tilt < 1e-9);
    if (is_driven) {
      // The gap is between the arc of the crank in a step, 6 rad/s of it, and its tangent.
      CHECK(gap < 0.1 * (6.0 / 240) * (6.0 / 240) / 2);
      CHECK(world.reading(crank).position == test::relative(30).epsilon(1e-3));
    } else {
      CHECK(gap < 1e-10);
      CHECK(energy() == test::relative(start).epsilon(1e-4));
    }
  }
}
