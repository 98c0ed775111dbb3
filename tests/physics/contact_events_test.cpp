/// @file
/// Contacts as callers see them: forces against statics and momentum, and touches that come and go.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/ground.hpp"
#include "scenes/medley.hpp"
#include "support/numbers.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using bristle::test::g;
using namespace bristle::scenes;

namespace {

BodyDef<double> solid_box(double mass, const Vec3<double>& half, const Vec3<double>& position) {
  BodyDef<double> def;
  def.mass = mass;
  def.shape = Box<double>{half};
  def.position = position;
  return def;
}

void advance(World<double>& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step();
}

/// The events of the last step as text: "b" begin, "p" persist, "e" end, and the slots of the
/// bodies.
std::string events_of(const World<double>& world) {
  std::string text;
  world.for_each_contact_event([&](const ContactEvent& e) {
    const char* phase = e.phase == ContactEvent::Phase::begin     ? "b"
                        : e.phase == ContactEvent::Phase::persist ? "p"
                                                                  : "e";
    text += phase + std::to_string(e.body_a.index) + std::to_string(e.body_b.index) + " ";
  });
  return text;
}

/// The different events of some steps, in order.
std::string history_of(World<double>& world, int steps) {
  std::string history;
  std::string last = "?";
  for (int i = 0; i < steps; ++i) {
    world.step();
    const std::string now = events_of(world);
    if (now != last) history += "[" + now + "]";
    last = now;
  }
  return history;
}

}  // namespace

// Forces ------------------------------------------------------------------------------------------

TEST_CASE("contact_forces: a weight on a plate weighs m g, from either side") {
  World<double> world;
  BodyDef<double> def = solid_box(1, {0.5, 0.5, 0.05}, {0, 0, 0});
  def.motion = Motion::fixed;
  const BodyId plate = world.add_body(def);
  const BodyId weight = world.add_body(solid_box(3, {0.1, 0.1, 0.1}, {0.2, -0.1, 0.15}));
  advance(world, 200);
  const Vec3<double> on_weight = world.contact_impulse(weight, plate).force;
  const Vec3<double> expected(0, 0, 3 * g * world.time_step());
  // Sweeps end at 1e-9 of the speed that gravity gives in a step.
  CHECK((on_weight - expected).norm() < 1e-8 * expected.norm());
  CHECK(world.contact_impulse(plate, weight).force == -on_weight);
  CHECK(world.contact_impulse(weight).force == on_weight);
  // The load acts at the middle of the weight: its moment about the plate's.
  const Vec3<double> torque = world.contact_impulse(plate).torque;
  const Vec3<double> arm(0.2, -0.1, 0.05);
  CHECK((torque - arm.cross(-expected)).norm() < 1e-8 * expected.norm());
  // The same about a point of one's own.
  const Vec3<double> corner(0.5, 0.5, 0.05);
  int pairs = 0;
  world.for_each_contact([&](const ContactReading<double>& contact) {
    ++pairs;
    CHECK(contact.body_a == plate);
    CHECK(contact.body_b == weight);
    CHECK(contact.is_touching());
    const Wrench<double> about = contact.impulse_about(corner);
    const Vec3<double> moment = Vec3<double>(-0.3, -0.6, 0).cross(expected);
    CHECK((about.torque - moment).norm() < 1e-8 * expected.norm());
    int corners = 0;
    double normal = 0;
    Vec3<double> friction = Vec3<double>::Zero();
    contact.for_each_point([&](const ContactReading<double>::Point& p) {
      ++corners;
      normal += p.normal_impulse;
      CHECK(std::abs(std::abs(p.position.x() - 0.2) - 0.1) < 1e-6);
      CHECK(std::abs(std::abs(p.position.y() + 0.1) - 0.1) < 1e-6);
      CHECK(std::abs(p.position.z() - 0.05) < 1e-6);
      CHECK((p.normal - Vec3<double>::UnitZ()).norm() < 1e-9);
      CHECK(std::abs(p.gap) < 1e-6);
      friction += p.friction_impulse;
    });
    // That of single points need not vanish: corners may pull at each other.
    CHECK(friction.norm() < 1e-8 * expected.norm());
    CHECK(corners == 4);
    CHECK(std::abs(normal - expected.z()) < 1e-8 * expected.z());
  });
  CHECK(pairs == 1);
}

TEST_CASE("contact_forces: feet share the load as statics says") {
  for (const Vec3<double>& center : {Vec3<double>(0, 0, 0), Vec3<double>(0.11, -0.07, 0.02)}) {
    for (const bool has_three : {false, true}) {
      World<double> world;
      add_ground(world);
      BodyDef<double> def;
      def.mass = 8;
      def.inertia = Vec3<double>(0.3, 0.3, 0.5).asDiagonal();
      def.center_of_mass = center;
      def.position = {0, 0, 0.35};
      const BodyId table = world.add_body(def);
      std::vector<Vec3<double>> at{{-0.3, -0.2, -0.3}, {0.3, -0.2, -0.3}, {0.3, 0.2, -0.3}};
      if (has_three) {
        at[2] = {0, 0.2, -0.3};
      } else {
        at.push_back({-0.3, 0.2, -0.3});
      }
      std::vector<ShapeId> feet;
      for (const Vec3<double>& p : at) {
        ShapeDef<double> foot;
        foot.shape = Sphere<double>{0.05};
        foot.X_BS.translation = p;
        feet.push_back(world.add_shape(table, foot));
      }
      advance(world, 400);
      std::vector<double> load(at.size(), 0);
      world.for_each_contact([&](const ContactReading<double>& contact) {
        for (std::size_t k = 0; k < feet.size(); ++k) {
          if (contact.shape_b == feet[k] || contact.shape_a == feet[k]) {
            load[k] += std::abs(contact.impulse_on_b().force.z()) / world.time_step();
          }
        }
      });
      double sum = 0, moment_x = 0, moment_y = 0;
      for (std::size_t k = 0; k < at.size(); ++k) {
        sum += load[k];
        moment_x += load[k] * at[k].x();
        moment_y += load[k] * at[k].y();
      }
      INFO("centre ", center.x(), ", feet ", at.size());
      // Three equations of statics; with three feet they are the whole answer.
      CHECK(sum == test::relative(8 * g).epsilon(1e-7));
      CHECK(std::abs(moment_x - 8 * g * center.x()) < 1e-6);
      CHECK(std::abs(moment_y - 8 * g * center.y()) < 1e-6);
      if (has_three && center.isZero()) {
        CHECK(load[0] == test::relative(2 * g).epsilon(1e-6));
        CHECK(load[1] == test::relative(2 * g).epsilon(1e-6));
        CHECK(load[2] == test::relative(4 * g).epsilon(1e-6));
      }
    }
  }
}

TEST_CASE("contact_forces: friction of a sliding box is mu N, of a resting one m g sin") {
  const Material<double> material{0.4, 0};
  World<double> world;
  const BodyId floor = add_ground(world, material);
  BodyDef<double> def = solid_box(2, {0.1, 0.1, 0.02}, {0, 0, 0.02});
  def.material = material;
  def.velocity = {0.9, 1.2, 0};
  const BodyId box = world.add_body(def);
  advance(world, 30);
  REQUIRE(world.body(box).twist.linear.norm() > 0.5);
  const Vec3<double> force = world.contact_impulse(box, floor).force / world.time_step();
  CHECK(force.z() == test::relative(2 * g).epsilon(1e-6));
  CHECK(force.x() == test::relative(-0.4 * 2 * g * 0.6).epsilon(1e-6));
  CHECK(force.y() == test::relative(-0.4 * 2 * g * 0.8).epsilon(1e-6));

  // The same on an incline of 0.3, which 0.4 holds: gravity is turned instead of the floor.
  const double angle = 0.3;
  world.set_gravity({g * std::sin(angle), 0, -g * std::cos(angle)});
  world.set_velocity(box, {});
  advance(world, 200);
  CHECK(world.body(box).twist.linear.norm() < 1e-8);
  Vec3<double> friction = Vec3<double>::Zero();
  double normal = 0;
  world.for_each_contact([&](const ContactReading<double>& contact) {
    contact.for_each_point([&](const ContactReading<double>::Point& p) {
      friction += p.friction_impulse / world.time_step();
      normal += p.normal_impulse / world.time_step();
    });
  });
  CHECK(normal == test::relative(2 * g * std::cos(angle)).epsilon(1e-6));
  CHECK(friction.x() == test::relative(-2 * g * std::sin(angle)).epsilon(1e-6));
  CHECK(std::abs(friction.y()) < 1e-6 * g);
}

TEST_CASE("contact_forces: contacts, joints, sensors and gravity account for all momentum") {
  auto m = make_medley<double>();
  World<double>& world = m.world;
  // A cube to be hit from the side, so that contacts have all directions.
  BodyDef<double> bullet = solid_box(0.4, {0.05, 0.05, 0.05}, {0.5, 2.02, 0.3});
  bullet.velocity = {-2, 0, 1};
  bullet.angular_velocity = {3, 5, -2};
  m.bodies.push_back(world.add_body(bullet));
  const Wrench<double> push{{0.3, -0.2, 0.4}, {0.01, 0.02, -0.03}};
  const double dt = world.time_step();
  int turning = 0;
  int touching = 0;
  for (int step = 0; step < 300; ++step) {
    for (const BodyId id : m.bodies) world.apply_wrench(id, push);
    std::vector<Body<double>> before;
    for (const BodyId id : m.bodies) before.push_back(world.body(id));
    world.step();
    // A displacement of the position correction turns bodies without a torque.
    const bool is_pure = world.report().position_sweeps == 0;
    for (std::size_t k = 0; k < m.bodies.size(); ++k) {
      const Body<double>& start = before[k];
      const Body<double>& end = world.body(m.bodies[k]);
      Wrench<double> sum = dt * push;
      sum.force += dt * start.mass * world.def().gravity;
      double scale = sum.force.norm();
      double turn_scale = sum.torque.norm();
      const auto add = [&](const Wrench<double>& w) {
        sum += w;
        scale += w.force.norm();
        turn_scale += w.torque.norm() + 0.1 * w.force.norm();
      };
      const Wrench<double> contact = world.contact_impulse(m.bodies[k]);
      touching += contact.force.norm() > 0 ? 1 : 0;
      add(contact);
      if (k < m.patches.size()) add(dt * world.reading(m.patches[k]).wrench);
      for (std::size_t j = 0; j < m.joints.size(); ++j) {
        // Both joints sit at the centre of their body B: the slider (6) and the hand (7).
        const Wrench<double> reaction = dt * world.reading(m.joints[j]).reaction;
        if (k == 6 + j) add(reaction);
        if (k == 5 + j && j == 1) {
          // [m] From the hand, where the reaction acts, to the slider.
          add(-reaction.shifted(start.center_pose.translation - before[7].center_pose.translation));
        }
      }
      const Vec3<double> change = end.mass * (end.twist.linear - start.twist.linear);
      // Round-off of velocities and of the sums: a few of 2e-16 each.
      CHECK((change - sum.force).norm() <=
            1e-12 * (scale + start.mass * start.twist.linear.norm()));
      if (!is_pure) continue;
      ++turning;
      const Vec3<double> spin = end.angular_momentum() - start.angular_momentum();
      CHECK((spin - sum.torque).norm() <= 1e-12 * (turn_scale + start.angular_momentum().norm()));
    }
  }
  CHECK(turning > 500);
  CHECK(touching > 500);
}

// Events ------------------------------------------------------------------------------------------

TEST_CASE("contact_events: a ball that bounces begins and ends its touches") {
  WorldDef<double> def;
  def.time_step = 1e-3;
  World<double> world(def);
  add_ground(world, {0.5, 0.5});
  BodyDef<double> ball;
  ball.mass = 0.1;
  ball.shape = Sphere<double>{0.05};
  ball.material = {0.5, 0.5};
  ball.position = {0, 0, 0.15};
  world.add_body(ball);
  // Falls for sqrt(2 * 0.1 / g) = 143 ms, hits with 1.4 m/s, flies for 143 ms, for 71 ms, ...
  const std::string history = history_of(world, 400);
  const std::string bounce = "[b01 ][e01 ][]";
  CHECK(history.substr(0, 2 + 2 * bounce.size()) == "[]" + bounce + bounce);
  // Bounces die out at the speed below which nothing bounces; then it rests.
  advance(world, 1000);
  CHECK(history_of(world, 50) == "[p01 ]");
}

TEST_CASE("contact_events: a box pushed off a table leaves it and lands") {
  World<double> world;
  add_ground(world);
  BodyDef<double> table = solid_box(1, {0.3, 0.3, 0.05}, {0, 0, 0.45});
  table.motion = Motion::fixed;
  world.add_body(table);
  BodyDef<double> def = solid_box(1, {0.05, 0.05, 0.05}, {0.2, 0, 0.55});
  def.velocity = {2.5, 0, 0};
  world.add_body(def);
  // It touches the table, leaves it, falls, and touches the floor.
  const std::string history = history_of(world, 480);
  const std::size_t leaves = history.find("e12");
  const std::size_t lands = history.find("b02");
  CHECK(history.substr(0, 12) == "[b12 ][p12 ]");
  CHECK(leaves != std::string::npos);
  CHECK(lands != std::string::npos);
  CHECK(leaves < lands);
  CHECK(history.find("b12", leaves) == std::string::npos);
  CHECK(history.substr(history.size() - 6) == "[p02 ]");
}

TEST_CASE("contact_events: what is removed while touching ends, under its own name") {
  World<double> world;
  const BodyId floor = add_ground(world);
  const BodyId low = world.add_body(solid_box(1, {0.1, 0.1, 0.1}, {0, 0, 0.1}));
  const BodyId high = world.add_body(solid_box(1, {0.1, 0.1, 0.1}, {0, 0, 0.3}));
  advance(world, 20);
  REQUIRE(events_of(world) == "p01 p12 ");
  std::vector<ShapeId> shapes;
  world.for_each_contact([&](const auto& contact) { shapes.push_back(contact.shape_b); });
  REQUIRE(shapes.size() == 2);

  world.remove_body(low);
  // Another one in its slot, which touches at once.
  const BodyId successor = world.add_body(solid_box(1, {0.1, 0.1, 0.1}, {0, 0, 0.1}));
  REQUIRE(successor.index == low.index);
  world.step();
  CHECK(events_of(world) == "e01 e12 b01 b12 ");
  std::vector<ContactEvent> events;
  world.for_each_contact_event([&](const ContactEvent& e) { events.push_back(e); });
  CHECK(events[0].body_a == floor);
  CHECK(events[0].body_b == low);
  CHECK(events[0].shape_b == shapes[0]);
  CHECK(events[1].body_a == low);
  CHECK(events[1].body_b == high);
  CHECK(events[2].body_b == successor);
  CHECK(events[2].shape_b != shapes[0]);
  CHECK_FALSE(world.contains(events[0].body_b));
  CHECK(world.contains(events[2].body_b));
  world.step();
  CHECK(events_of(world) == "p01 p12 ");

  // A shape alone, and a body that a step later does not exist at all.
  world.remove_shape(events[2].shape_b);
  world.step();
  CHECK(events_of(world) == "e01 e12 ");
  world.step();
  CHECK(events_of(world).empty());
}

TEST_CASE("contact_events: shapes near each other that do not touch make none") {
  World<double> world({.gravity = {0, 0, 0}});
  world.add_body(solid_box(1, {0.1, 0.1, 0.1}, {0, 0, 0}));
  BodyDef<double> def = solid_box(1, {0.1, 0.1, 0.1}, {0, 0, 0.201});
  def.velocity = {0.5, 0, 0};  // Within reach, but past.
  world.add_body(def);
  world.step();
  int near = 0;
  world.for_each_contact([&](const auto& contact) {
    ++near;
    CHECK_FALSE(contact.is_touching());
  });
  CHECK(near == 1);
  CHECK(events_of(world).empty());
}
