/// @file
/// Hard contact without sensors: friction, sliding, bouncing.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/momentum.hpp"
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

using namespace bristle;
using namespace bristle::detail;

namespace {

/// A flat box on a half-space.
template <typename S>
struct Slider {
  World<S> world;
  BodyId box{};
};

template <typename S>
Slider<S> make_slider(const Vec3<S>& gravity, S friction, S restitution = S(0), S drop = S(0),
                      S dt = S(1e-3)) {
  WorldDef<S> world_def;
  world_def.gravity = gravity;
  world_def.time_step = dt;
  Slider<S> slider{World<S>(world_def), {}};
  BodyDef<S> plane;
  plane.motion = Motion::fixed;
  plane.shape = HalfSpace<S>{};
  plane.material = {friction, S(0)};
  slider.world.add_body(plane);
  BodyDef<S> box;
  box.mass = S(1);
  box.shape = Box<S>{{S(0.1), S(0.1), S(0.01)}};
  box.material = {friction, restitution};
  box.position = {S(0), S(0), S(0.01) + drop};
  slider.box = slider.world.add_body(box);
  return slider;
}

}  // namespace

TEST_CASE_TEMPLATE("hard_contact: friction sticks below atan mu and slides above", S, float,
                   double) {
  const S mu = S(0.5);
  for (const S factor : {S(0.9), S(1.1)}) {
    const S angle = std::atan(factor * mu);
    const S g = S(9.81);
    auto slider = make_slider<S>({g * std::sin(angle), 0, -g * std::cos(angle)}, mu);
    for (int i = 0; i < 1000; ++i) slider.world.step();
    const Body<S>& box = slider.world.body(slider.box);
    if (factor < S(1)) {
      CHECK(static_cast<double>(box.twist.linear.norm()) < 1e-6);
      CHECK(static_cast<double>(std::abs(box.center_pose.translation.x())) < 1e-6);
    } else {
      // a = g (sin - mu cos), for 1 s.
      const double a = static_cast<double>(g * (std::sin(angle) - mu * std::cos(angle)));
      CHECK(static_cast<double>(box.twist.linear.x()) == test::relative(a).epsilon(1e-3));
    }
  }
}

TEST_CASE("hard_contact: friction is a disk, so it opposes a slide in any direction") {
  // A pyramid would brake a slide at 30 degrees by up to cos 30 + sin 30 = 1.37 mu g, and turn it.
  const double mu = 0.4;
  for (const double degrees : {0.0, 30.0, 45.0, 200.0}) {
    const double a = degrees * std::numbers::pi / 180;
    const Vec3<double> direction(std::cos(a), std::sin(a), 0);
    auto slider = make_slider<double>({0, 0, -9.81}, mu);
    slider.world.step();
    slider.world.set_velocity(slider.box, {2 * direction, Vec3<double>::Zero()});
    for (int i = 0; i < 300; ++i) slider.world.step();
    const Vec3<double> v = slider.world.body(slider.box).twist.linear;
    CHECK(v.dot(direction) == test::relative(2 - mu * 9.81 * 0.3).epsilon(1e-3));
    CHECK((v - v.dot(direction) * direction).norm() < 2e-3);
  }
}

TEST_CASE("hard_contact: friction of a pair is the geometric mean, restitution the larger") {
  const Material<double> pair = combined<double>({0.9, 0.2}, {0.4, 0.7});
  CHECK(pair.friction == test::relative(0.6));
  CHECK(pair.restitution == 0.7);
}

TEST_CASE("hard_contact: a bounce gives back e times the speed") {
  for (const double e : {0.0, 0.5, 0.8, 1.0}) {
    auto slider = make_slider<double>({0, 0, -9.81}, 0.5, e, 0.2);
    double before = 0;
    double after = 0;
    double energy_before = 0;
    // Per mass, from the height at which it rests.
    const auto energy = [&] {
      const double v = slider.world.body(slider.box).twist.linear.z();
      return v * v / 2 + 9.81 * (slider.world.pose(slider.box).translation.z() - 0.01);
    };
    for (int i = 0; i < 400; ++i) {
      before = slider.world.body(slider.box).twist.linear.z();
      energy_before = energy();
      slider.world.step();
      after = slider.world.body(slider.box).twist.linear.z();
      if (after > before) break;
    }
    REQUIRE(before < -1.9);
    if (e > 0) {
      // It hits within the step, so what e^2 is exactly about is the energy of the flight.
      CHECK(energy() == test::relative(e * e * energy_before).epsilon(1e-9));
    } else {
      // It arrives: the gap is closed exactly and not passed.
      for (int i = 0; i < 5; ++i) slider.world.step();
      CHECK(std::abs(slider.world.pose(slider.box).translation.z() - 0.01) < 1e-9);
      CHECK(std::abs(slider.world.body(slider.box).twist.linear.z()) < 1e-9);
    }
  }
}

TEST_CASE("hard_contact: slow impacts do not bounce") {
  auto slider = make_slider<double>({0, 0, -9.81}, 0.5, 0.9, 4e-6);
  double highest = 0;
  for (int i = 0; i < 100; ++i) {
    slider.world.step();
    highest = std::max(highest, slider.world.body(slider.box).twist.linear.z());
  }
  CHECK(highest < 1e-9);
}

TEST_CASE("hard_contact: an overlap is pushed out without giving speed") {
  auto slider = make_slider<double>({0, 0, -9.81}, 0.5, 0.0, -0.002);
  double fastest = 0;
  for (int i = 0; i < 100; ++i) {
    slider.world.step();
    fastest = std::max(fastest, slider.world.body(slider.box).twist.linear.norm());
  }
  CHECK(fastest < 1e-8);
  CHECK(slider.world.pose(slider.box).translation.z() == test::relative(0.01).epsilon(1e-6));
}

TEST_CASE("hard_contact: a fast body does not tunnel") {
  auto slider = make_slider<double>({0, 0, -9.81}, 0.5, 0.0, 1.0, 1.0 / 60);
  slider.world.set_velocity(slider.box, {{0, 0, -500}, {0, 0, 0}});
  for (int i = 0; i < 60; ++i) slider.world.step();
  CHECK(slider.world.pose(slider.box).translation.z() == test::relative(0.01).epsilon(1e-6));
}

/// Two fingertips that forces press together, with a plate of 10 mm between them.
TEST_CASE("hard_contact: fingertips do not press on each other through what they hold") {
  struct Squeeze {
    double time_step, force;  // [s, N]
  };
  // Without the plate each pair would meet within the step: F h^2 / 2 m > 5 mm, half of its gap.
  for (const Squeeze& squeeze : {Squeeze{1.0 / 60, 30}, Squeeze{1.0 / 240, 120}}) {
    CAPTURE(squeeze.time_step);
    const double half_thickness = 0.005;
    const double radius = 0.01;
    const double mass = 0.1;
    REQUIRE(0.5 * squeeze.force / mass * squeeze.time_step * squeeze.time_step > half_thickness);
    World<double> world({.time_step = squeeze.time_step});
    const BodyId plate = world.add_body({.mass = 0.2,
                                         .shape = Box<double>{{half_thickness, 0.05, 0.1}},
                                         .material = {.friction = 0.8}});
    std::array<BodyId, 2> tips{};
    for (const std::size_t k : {0u, 1u}) {
      BodyDef<double> tip{
          .mass = mass, .shape = Sphere<double>{radius}, .material = {.friction = 0.8}};
      tip.gravity_scale = 0;
      tip.position.x() = (k == 0 ? -1 : 1) * (half_thickness + radius);
      tip.locked.linear = {false, true, true};
      tip.locked.angular = {true, true, true};
      tips[k] = world.add_body(tip);
    }
    const double carried = squeeze.force * squeeze.time_step;
    for (int i = 0; i < 60; ++i) {
      for (const std::size_t k : {0u, 1u}) {
        const double inwards = k == 0 ? squeeze.force : -squeeze.force;
        world.apply_force(tips[k], {inwards, 0, 0}, world.pose(tips[k]).translation);
      }
      world.step();
      int pressing = 0;
      int across = 0;
      world.for_each_contact([&](const ContactReading<double>& contact) {
        if (contact.body_a != plate && contact.body_b != plate) {
          contact.for_each_point([&](const ContactReading<double>::Point& point) {
            CHECK(point.normal_impulse == 0);
            ++across;
          });
          return;
        }
        contact.for_each_point([&](const ContactReading<double>::Point& point) {
          CHECK(point.normal_impulse == test::relative(carried).epsilon(1e-6));
          ++pressing;
        });
      });
      CHECK(pressing == 2);
      CHECK(across == 1);
    }
    CHECK(world.pose(plate).translation.norm() < 1e-9);
  }
}

TEST_CASE("hard_contact: two bodies that collide keep their momentum, about the origin too") {
  WorldDef<double> world_def;
  world_def.gravity.setZero();
  world_def.time_step = 1e-3;
  World<double> world(world_def);
  BodyDef<double> def;
  def.shape = Box<double>{{0.05, 0.06, 0.07}};
  def.mass = 1;
  def.material = {0.6, 0.5};
  def.position = {1, 2, 3};
  def.velocity = {1, 0.1, 0};
  def.angular_velocity = {0.5, 1, -2};
  std::array<BodyId, 2> bodies{};
  bodies[0] = world.add_body(def);
  def.mass = 3;
  def.position = {1.2, 2.03, 2.98};
  def.velocity = {-1, 0, 0.1};
  bodies[1] = world.add_body(def);
  const auto before = test::momentum_of(world, std::span<const BodyId>(bodies));
  const double energy = test::energy_of(world, std::span<const BodyId>(bodies));
  std::uint64_t touched = 0;
  for (int i = 0; i < 400; ++i) {
    world.step();
    touched += world.report().contact_points;
  }
  REQUIRE(touched > 0);
  const auto after = test::momentum_of(world, std::span<const BodyId>(bodies));
  // Impulses of about 2 N s at arms of 4 m.
  CHECK((after.force - before.force).norm() < 1e-13);
  CHECK((after.torque - before.torque).norm() < 1e-12);
  CHECK(test::energy_of(world, std::span<const BodyId>(bodies)) < energy);
}

TEST_CASE("hard_contact: filters, groups and connected bodies do not touch") {
  for (int variant = 0; variant < 4; ++variant) {
    auto slider = make_slider<double>({0, 0, -9.81}, 0.5, 0.0, 0.001);
    CollisionFilter filter;
    if (variant == 1) filter.mask = 2;
    if (variant == 2) filter.category = 0;
    if (variant == 3) filter.group = -7;
    slider.world.set_filter(slider.box, filter);
    if (variant == 3) slider.world.set_filter(BodyId{0, 0}, filter);
    for (int i = 0; i < 200; ++i) slider.world.step();
    const bool falls = slider.world.pose(slider.box).translation.z() < 0;
    CHECK(falls == (variant != 0));
  }
}

namespace {

/// Boxes on a driven plate, whose friction holds them.
struct Tray {
  static constexpr double dt = 1.0 / 240;
  World<double> world{WorldDef<double>{.time_step = dt}};
  BodyId plate;
  std::vector<BodyId> boxes{};
  std::vector<Vec3<double>> places{};
  std::uint64_t factorisations = 0;

  Tray() {
    BodyDef<double> def;
    def.motion = Motion::kinematic;
    def.shape = Box<double>{{0.5, 0.5, 0.05}};
    def.material = {0.6, 0};
    plate = world.add_body(def);
  }
  /// A box of 0.1 m height and twice `half` wide. `place` is above the top of the plate.
  void add(double half, const Vec3<double>& place) {
    BodyDef<double> def;
    def.mass = 1;
    def.shape = Box<double>{{half, half, 0.05}};
    def.position = place + Vec3<double>(0, 0, 0.05);
    def.material = {0.6, 0};
    boxes.push_back(world.add_body(def));
    places.push_back(def.position);
  }
  /// Steps with a velocity of the plate, and requires that all boxes follow it.
  ///
  /// The velocity of the plate is constant in each step, and that of a held box is the same at the
  /// end of it. By the trapezoidal rule the box lags by half of the change in each step, so by
  /// dt v / 2 in all. Velocities may be wrong by 4e-10 m/s, a hundred-millionth of g dt, so the lag
  /// by 6e-10 m in the end.
  void step(const Vec3<double>& velocity) {
    world.set_velocity(plate, {velocity, {0, 0, 0}});
    world.step();
    factorisations += world.report().factorisations;
    const Vec3<double> moved = world.pose(plate).translation - dt / 2 * velocity;
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      REQUIRE((world.pose(boxes[k]).translation - places[k] - moved).norm() < 1e-8);
    }
  }
};

}  // namespace

TEST_CASE(
    "hard_contact: a stack on a plate that is shaken follows it, by one factorisation a step") {
  Tray tray;
  for (int i = 0; i < 8; ++i) tray.add(0.1, {0, 0, 0.05 + 0.1 * i});
  const double rate = 2 * std::numbers::pi;  // [rad/s]
  const double speed = 0.15 * 9.81 / rate;   // [m/s] Friction needs a quarter of what it has.
  constexpr int steps = 360;
  for (int i = 0; i < steps; ++i) {
    tray.step({-speed * std::sin(rate * (i + 1) * Tray::dt), 0, 0});
  }
  // All that holds is linear. It took 16.5 a step from sweeps, and 3 by an eps that decreases.
  // In the first step nothing is known yet.
  CHECK(tray.factorisations < steps + 10);
}

// Each box rests on the corners of others. Their load is spread over more points than it needs, so
// that some are at the edge of their cones, although nothing slides.
TEST_CASE("hard_contact: a pyramid on a tray that circles stays, by few factorisations") {
  Tray tray;
  for (int layer = 0; layer < 3; ++layer) {
    const int n = 3 - layer;
    for (int i = 0; i < n * n; ++i) {
      tray.add(0.095,
               {0.2 * (i % n - 0.5 * (n - 1)), 0.2 * (i / n - 0.5 * (n - 1)), 0.05 + 0.1 * layer});
    }
  }
  const double rate = 3 * std::numbers::pi;  // [rad/s]
  const double speed = 0.2 * 9.81 / rate;    // [m/s] Friction needs a third of what it has.
  constexpr int steps = 160;
  for (int i = 0; i < steps; ++i) {
    const double angle = rate * (i + 1) * Tray::dt;
    tray.step(speed * Vec3<double>(-std::sin(angle), std::cos(angle) - 1, 0));
  }
  // It takes 6.5 a step. From sweeps it took 13, and boxes crept.
  CHECK(tray.factorisations < 8 * steps);
}
