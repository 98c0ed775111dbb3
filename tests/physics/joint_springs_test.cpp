/// @file
/// Springs of joints in a world: on a free axis, and six at once.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/momentum.hpp"
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>

using namespace bristle;
using std::numbers::pi;
using V = Vec3<double>;

namespace {

/// Principal moments of 0.01, 0.02, 0.03 kg m^2, and 2 kg.
template <typename S>
BodyDef<S> sprung_block(const Vec3<S>& position = Vec3<S>::Zero()) {
  BodyDef<S> def;
  def.mass = S(2);
  def.inertia = Vec3<S>(S(0.01), S(0.02), S(0.03)).asDiagonal();
  def.position = position;
  return def;
}

template <typename S>
struct Sprung {
  World<S> world;
  BodyId frame{}, body{};
  JointId joint{};

  void run(double seconds) {
    const long steps = std::lround(seconds / static_cast<double>(world.time_step()));
    for (long i = 0; i < steps; ++i) world.step();
  }
  [[nodiscard]] JointReading<S> reading() const { return world.reading(joint); }
};

/// A block at the origin, joined there to something fixed.
template <typename S>
Sprung<S> make_sprung(JointDef<S> def, S dt, const Vec3<S>& gravity = Vec3<S>::Zero()) {
  WorldDef<S> world_def;
  world_def.time_step = dt;
  world_def.gravity = gravity;
  Sprung<S> sprung{World<S>(world_def), {}, {}, {}};
  sprung.frame = sprung.world.add_body({.motion = Motion::fixed});
  sprung.body = sprung.world.add_body(sprung_block<S>());
  def.body_a = sprung.frame;
  def.body_b = sprung.body;
  sprung.joint = sprung.world.add_joint(def);
  return sprung;
}

}  // namespace

TEST_CASE("joint spring: a torsion spring swings at its frequency and loses nothing") {
  // k / I = 100 / s^2.
  JointDef<double> def{.kind = JointKind::revolute, .spring = {.stiffness = 1}};
  auto sprung = make_sprung<double>(def, 1.0 / 240);
  sprung.world.set_velocity(sprung.body, {{0, 0, 0}, {2, 0, 0}});
  double worst = 0;
  for (int i = 1; i <= 2400; ++i) {
    sprung.world.step();
    const double t = i / 240.0;
    worst = std::max(worst, std::abs(sprung.reading().position - 0.2 * std::sin(10 * t)));
  }
  // A fifth-order method at 0.04 rad a step; a relative 5e-5 a substep is what it may err by.
  CHECK(worst < 1e-5);
}

TEST_CASE("joint spring: a slide with a spring and a damper follows the damped oscillation") {
  // w0 = 10 / s, damping ratio 0.3; started 0.1 m from rest.
  const double w0 = 10, ratio = 0.3, w = w0 * std::sqrt(1 - ratio * ratio);
  JointDef<double> def{
      .kind = JointKind::prismatic,
      .spring = {.stiffness = 2 * w0 * w0, .damping = 4 * ratio * w0, .rest = 0.1}};
  auto sprung = make_sprung<double>(def, 1.0 / 240);
  double worst = 0;
  for (int i = 1; i <= 480; ++i) {
    const double before = sprung.reading().velocity;
    sprung.world.step();
    const JointReading<double> reading = sprung.reading();
    CHECK(reading.reaction.force.x() ==
          test::relative(2 * 240 * (reading.velocity - before)).epsilon(1e-9));
    const double t = i / 240.0;
    const double exact = 0.1 - 0.1 * std::exp(-ratio * w0 * t) *
                                   (std::cos(w * t) + ratio * w0 / w * std::sin(w * t));
    worst = std::max(worst, std::abs(sprung.reading().position - exact));
  }
  CHECK(worst < 1e-6);
}

TEST_CASE("joint spring: a spring winds up over whole turns") {
  JointDef<double> def{.kind = JointKind::revolute, .spring = {.stiffness = 0.01, .rest = 7}};
  auto sprung = make_sprung<double>(def, 1.0 / 240);
  // w0 = 1 / s: half a swing later it is twice as far.
  sprung.run(pi);
  CHECK(sprung.reading().position == test::relative(14).epsilon(1e-5));
  sprung.run(pi);
  CHECK(std::abs(sprung.reading().position) < 1e-3);
}

TEST_CASE("joint spring: springs too stiff for the step are stable and lose energy only") {
  for (const JointKind kind : {JointKind::revolute, JointKind::prismatic}) {
    for (const double stiffness : {1e4, 1e6, 1e9, 1e12, 1e15}) {
      for (const double damping : {0.0, 1e-3, 1e3, 1e9}) {
        CAPTURE(static_cast<int>(kind));
        CAPTURE(stiffness);
        CAPTURE(damping);
        JointDef<double> def{.kind = kind, .spring = {.stiffness = stiffness, .damping = damping}};
        auto sprung = make_sprung<double>(def, 1.0 / 60);
        sprung.world.set_velocity(sprung.body, {{1, 0, 0}, {3, 0, 0}});
        const bool slides = kind == JointKind::prismatic;
        const double mass = slides ? 2 : 0.01;
        const auto energy = [&] {
          const auto reading = sprung.reading();
          return 0.5 * mass * reading.velocity * reading.velocity +
                 0.5 * stiffness * reading.position * reading.position;
        };
        double before = 0.5 * mass * (slides ? 1 : 9);
        for (int i = 0; i < 120; ++i) {
          sprung.world.step();
          REQUIRE(energy() <= before * (1 + 1e-6) + 1e-15);
          before = energy();
        }
        CHECK(std::abs(sprung.reading().velocity) < 1e-3);
      }
    }
  }
}

TEST_CASE_TEMPLATE("joint spring: a load stretches a spring by F / k, however stiff", S, float,
                   double) {
  for (const S stiffness : {S(50), S(2000), S(1e6), S(1e9)}) {
    CAPTURE(stiffness);
    JointDef<S> def{.kind = JointKind::prismatic,
                    .spring = {.stiffness = stiffness, .damping = std::sqrt(stiffness)}};
    auto sprung = make_sprung<S>(def, S(1) / S(240), {S(-10), 0, 0});
    sprung.run(20);
    CHECK(static_cast<double>(sprung.reading().position * stiffness) ==
          test::relative(-20).epsilon(2e-3));
    CHECK(static_cast<double>(sprung.reading().reaction.force.x()) ==
          test::relative(20).epsilon(2e-3));
    CHECK(static_cast<double>(std::abs(sprung.reading().velocity)) < 1e-3);
  }
}

TEST_CASE("joint spring: a spring between free bodies keeps their momentum") {
  for (const double stiffness : {1.0, 1e6}) {
    CAPTURE(stiffness);
    WorldDef<double> world_def;
    world_def.gravity.setZero();
    world_def.time_step = 1e-3;
    World<double> world(world_def);
    const std::array<BodyId, 2> bodies{world.add_body(sprung_block<double>({0.1, 0, 0})),
                                       world.add_body(sprung_block<double>({0.3, 0, 0}))};
    JointDef<double> def{.kind = JointKind::revolute,
                         .body_a = bodies[0],
                         .body_b = bodies[1],
                         .spring = {.stiffness = stiffness, .rest = 0.5}};
    def.X_AJ.translation = {0.1, 0, 0};
    def.X_BJ.translation = {-0.1, 0, 0};
    world.add_joint(def);
    world.set_velocity(bodies[0], {{0, 0, 0.2}, {1, 0, 0}});
    const auto before = test::momentum_of(world, std::span<const BodyId>(bodies));
    for (int i = 0; i < 500; ++i) world.step();
    const auto after = test::momentum_of(world, std::span<const BodyId>(bodies));
    CHECK((after.force - before.force).norm() < 1e-12);
    // Of first order in the step, as for any joint between bodies that circle each other.
    CHECK((after.torque - before.torque).norm() < 2e-3 * before.torque.norm());
  }
}

TEST_CASE("joint spring: a stiff spring goes on from a snapshot with the same bits") {
  JointDef<double> def{.kind = JointKind::revolute, .spring = {.stiffness = 500, .rest = 4}};
  auto sprung = make_sprung<double>(def, 1.0 / 60);
  sprung.run(0.2);
  const auto saved = sprung.world.snapshot();
  sprung.run(0.5);
  const auto hash = sprung.world.state_hash();
  sprung.world.restore(saved);
  sprung.run(0.5);
  CHECK(sprung.world.state_hash() == hash);
}

TEST_CASE("six_dof: at rest each spring is stretched by its share of the load") {
  CHECK(locked_rows(JointKind::six_dof) == 0);
  JointDef<double> def{.kind = JointKind::six_dof};
  def.bushing.stiffness << 100, 200, 400, 2, 3, 5;
  def.bushing.damping << 20, 20, 20, 0.2, 0.3, 0.4;
  const Quat<double> turn = exp_rotation<double>({0.4, -0.2, 0.7});
  def.X_AJ.rotation = turn;
  def.X_BJ.rotation = turn;
  auto sprung = make_sprung<double>(def, 1.0 / 240);
  const V force(1, -2, 3), torque(0.3, -0.2, 0.1);
  for (int i = 0; i < 2400; ++i) {
    const V point = sprung.world.body(sprung.body).center_pose.translation;
    sprung.world.apply_force(sprung.body, force, point);
    sprung.world.apply_wrench(sprung.body, {V::Zero(), torque});
    sprung.world.step();
  }
  const Transform<double> X = sprung.world.pose(sprung.body);
  const V offset_J = turn.conjugate() * X.translation;
  const V force_J = turn.conjugate() * force;
  for (int i = 0; i < 3; ++i) {
    CHECK(offset_J[i] == test::relative(force_J[i] / def.bushing.stiffness[i]).epsilon(1e-6));
  }
  // phi . K phi / 2 grows by torque . w in a small turn w of the body, whichever way.
  const auto energy = [&](const Quat<double>& rotation) {
    const V phi = log_rotation<double>(turn.conjugate() * rotation * turn);
    return 0.5 * phi.dot(def.bushing.stiffness.tail<3>().cwiseProduct(phi));
  };
  const double h = 1e-5;
  for (int i = 0; i < 3; ++i) {
    const V w = h * V::Unit(i);
    const double slope = (energy(exp_rotation<double>(w) * X.rotation) -
                          energy(exp_rotation<double>(-w) * X.rotation)) /
                         (2 * h);
    CHECK(slope == test::relative(torque[i]).epsilon(1e-6));
  }
  const Wrench<double> reaction = sprung.reading().reaction;
  CHECK((reaction.force + force).norm() < 1e-6);
  CHECK((reaction.torque + torque).norm() < 1e-6);
}

TEST_CASE("six_dof: never gains energy, at any stiffness, turned far or not") {
  for (const double stiffness : {1.0, 1e3, 1e6, 1e10}) {
    CAPTURE(stiffness);
    JointDef<double> def{.kind = JointKind::six_dof};
    def.bushing.stiffness << stiffness * V(1, 2, 3), stiffness * V(0.01, 0.03, 0.02);
    auto sprung = make_sprung<double>(def, 1.0 / 240);
    sprung.world.set_velocity(sprung.body, {{1, 2, -1}, {3, -5, 4}});
    const auto energy = [&] {
      const Transform<double> X = sprung.world.pose(sprung.body);
      const V phi = log_rotation<double>(X.rotation);
      return sprung.world.body(sprung.body).kinetic_energy() +
             0.5 * X.translation.dot(def.bushing.stiffness.head<3>().cwiseProduct(X.translation)) +
             0.5 * phi.dot(def.bushing.stiffness.tail<3>().cwiseProduct(phi));
    };
    const double start = energy();
    for (int i = 0; i < 480; ++i) {
      sprung.world.step();
      REQUIRE(energy() < start * (1 + 1e-6));
    }
  }
}

TEST_CASE("six_dof: two free bodies keep their momentum") {
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  world_def.time_step = 1e-3;
  World<double> world(world_def);
  const std::array<BodyId, 2> bodies{world.add_body(sprung_block<double>({0, 0, 0})),
                                     world.add_body(sprung_block<double>({0.3, 0.1, 0}))};
  JointDef<double> def{.kind = JointKind::six_dof, .body_a = bodies[0], .body_b = bodies[1]};
  def.bushing.stiffness << 300, 200, 100, 2, 3, 4;
  def.bushing.damping << 1, 2, 3, 0.01, 0.02, 0.03;
  def.X_AJ.translation = {0.2, 0, 0};
  world.add_joint(def);
  world.set_velocity(bodies[0], {{0.1, 0.3, 0}, {1, 2, -1}});
  const auto before = test::momentum_of(world, std::span<const BodyId>(bodies));
  for (int i = 0; i < 500; ++i) world.step();
  const auto after = test::momentum_of(world, std::span<const BodyId>(bodies));
  CHECK((after.force - before.force).norm() < 1e-12);
  CHECK((after.torque - before.torque).norm() < 2e-3 * before.torque.norm());
}
