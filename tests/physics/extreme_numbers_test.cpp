/// @file
/// Numbers at the ends of the range: what cannot be computed with is refused at the call, and what
/// can takes nothing from its neighbours.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/brick.hpp"
#include "scenes/medley.hpp"
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

/// The field that a call names as wrong; empty where it is accepted.
template <typename Call>
std::string refused_field(Call&& call) {
  try {
    call();
  } catch (const InvalidArgument& error) {
    return error.field();
  }
  return {};
}

template <typename S>
BodyDef<S> extreme_ball(S radius) {
  BodyDef<S> def;
  def.shape = Sphere<S>{radius};
  return def;
}

}  // namespace

TEST_CASE_TEMPLATE("extreme_numbers: a body whose mass or inertia has no inverse is refused", S,
                   float, double) {
  World<S> world;
  const auto refused = [&](BodyDef<S> def) {
    const std::uint64_t before = world.state_hash();
    const std::string field = refused_field([&] { world.add_body(def); });
    CHECK(world.state_hash() == before);
    CHECK(world.body_count() == 0);
    return field;
  };
  using Limits = std::numeric_limits<S>;
  BodyDef<S> light = extreme_ball<S>(S(0.1));
  light.mass = Limits::min() / S(4);
  CHECK(refused(light) == "BodyDef::mass");
  BodyDef<S> heavy = extreme_ball<S>(S(0.1));
  heavy.mass = Limits::max() / S(4);
  CHECK(refused(heavy) == "BodyDef::mass");
  // The volume overflows where the radius and its square do not.
  CHECK(refused(extreme_ball<S>(std::cbrt(Limits::max()))) ==
        "BodyDef::density: mass of the shapes");
  // 1 kg, but a moment of inertia of which the inverse overflows.
  BodyDef<S> point = extreme_ball<S>(std::sqrt(Limits::min()) / S(4));
  point.mass = S(1);
  CHECK(refused(point) != "");
  BodyDef<S> rough = extreme_ball<S>(S(0.1));
  rough.material.friction = Limits::max() / S(4);
  CHECK(refused(rough) == "Material::friction");
  BodyDef<S> off_center = extreme_ball<S>(S(0.1));
  off_center.center_of_mass = Vec3<S>(Limits::max() / S(4), 0, 0);
  CHECK(refused(off_center) == "BodyDef::center_of_mass[0]");
  BodyDef<S> wide;
  wide.mass = S(1);
  wide.shape = Box<S>{Vec3<S>::Constant(Limits::max() / S(4))};
  CHECK(refused(wide) != "");
}

TEST_CASE_TEMPLATE("extreme_numbers: friction of two surfaces is finite for all that are accepted",
                   S, float, double) {
  const Material<S> m{largest_number<S>, S(0)};
  CHECK_NOTHROW(validate(m));
  CHECK(combined(m, m).friction == largest_number<S>);
}

TEST_CASE("extreme_numbers: a body that overflows takes no support from the stack it lies on") {
  World<double> world;
  BodyDef<double> floor;
  floor.motion = Motion::fixed;
  floor.shape = HalfSpace<double>{};
  world.add_body(floor);
  BodyDef<double> box;
  box.mass = 1;
  box.shape = Box<double>{{0.1, 0.1, 0.1}};
  std::array<BodyId, 6> stack;
  for (std::size_t i = 0; i < stack.size(); ++i) {
    box.position = {0, 0, 0.1 + 0.2 * double(i)};
    // The topmost is so light, and turns so fast, that products of what an impulse does to it
    // overflow; its momentum is that of a feather.
    if (i + 1 == stack.size()) box.mass = 2 / largest_number<double>;
    stack[i] = world.add_body(box);
  }
  std::uint64_t overflows = 0;
  for (int i = 0; i < 480; ++i) {
    world.set_velocity(stack.back(), {{0, 0, 0}, {1e-3 * largest_number<double>, 0, 0}});
    world.step();
    overflows += world.report().discarded_islands;
  }
  CHECK(overflows > 0);
  for (std::size_t i = 0; i + 1 < stack.size(); ++i) {
    CAPTURE(i);
    CHECK(world.pose(stack[i]).translation.z() ==
          test::relative(0.1 + 0.2 * double(i)).epsilon(0.01));
  }
}

TEST_CASE_TEMPLATE("extreme_numbers: an impulse that overflows is not applied, and not read", S,
                   float, double) {
  // Two bodies that a joint holds, or that meet. Their velocities are finite and stay so.
  for (const bool is_joined : {true, false}) {
    CAPTURE(is_joined);
    World<S> world({.gravity = Vec3<S>::Zero()});
    BodyDef<S> def = extreme_ball<S>(S(1));
    def.mass = S(0.1) * largest_number<S>;
    def.velocity = {S(0.1) * largest_number<S>, 0, 0};
    const BodyId a = world.add_body(def);
    def.position = {S(1.99), 0, 0};
    def.velocity = -def.velocity;
    const BodyId b = world.add_body(def);
    JointId joint;
    if (is_joined) {
      JointDef<S> held{.kind = JointKind::fixed, .body_a = a, .body_b = b};
      held.X_AJ.translation = {S(1.99), 0, 0};
      joint = world.add_joint(held);
    }
    world.step();
    if (is_joined) {
      const Wrench<S> reaction = world.reading(joint).reaction;
      CHECK(reaction.force.allFinite());
      CHECK(reaction.torque.allFinite());
    }
    world.for_each_contact([](const ContactReading<S>& contact) {
      CHECK(std::isfinite(contact.impulse_on_b().force.squaredNorm()));
    });
    CHECK(world.report().discarded_islands == 1);
    World<S> copy = world;
    CHECK_NOTHROW(copy.restore(world.snapshot()));
  }
}

TEST_CASE_TEMPLATE("extreme_numbers: balls and boxes of any size fall and rest", S, float, double) {
  const S g = S(9.81);
  for (const S size : {S(1e-5), S(1e-4), S(3e-4), S(1e-3), S(0.1), S(10), S(100), S(1000)}) {
    CAPTURE(size);
    for (const bool is_box : {false, true}) {
      CAPTURE(is_box);
      // A step in proportion to the time of a fall through the size: all sizes look alike.
      const S dt = S(0.05) * std::sqrt(size / g);
      World<S> world({.time_step = dt});
      BodyDef<S> floor;
      floor.motion = Motion::fixed;
      floor.shape = HalfSpace<S>{};
      world.add_body(floor);
      BodyDef<S> def = extreme_ball<S>(size);
      const Vec3<S> half(size, S(0.8) * size, S(0.6) * size);
      if (is_box) def.shape = Box<S>{half};
      const S rest = is_box ? half.z() : size;
      def.position = {0, 0, S(3) * size};
      const BodyId id = world.add_body(def);
      const Body<S>& body = world.body(id);
      CHECK((body.inertia_B * body.inverse_inertia_B).isApprox(Mat3<S>::Identity()));
      for (int i = 0; i < 20; ++i) world.step();
      // 20 steps: a time of sqrt(size / g), so half a size of fall; exact but for round-off.
      CHECK(world.pose(id).translation.z() / size == test::relative(2.5).epsilon(1e-4));
      for (int i = 0; i < 400; ++i) world.step();
      CHECK(world.pose(id).translation.z() / rest == test::relative(1).epsilon(1e-3));
      CHECK(world.report().discarded_islands == 0);
    }
  }
}

TEST_CASE_TEMPLATE("extreme_numbers: a small top keeps its energy as a large one does", S, float,
                   double) {
  for (const S size : {S(1e-5), S(1e-3), S(1), S(1000)}) {
    CAPTURE(size);
    World<S> world({.gravity = {0, 0, 0}, .time_step = S(1e-3)});
    BodyDef<S> def;
    def.shape = Box<S>{{size, S(0.8) * size, S(0.3) * size}};
    def.angular_velocity = {30, 50, 20};
    const BodyId id = world.add_body(def);
    const S energy = world.body(id).kinetic_energy();
    const Quat<S> start = world.pose(id).rotation;
    for (int i = 0; i < 100; ++i) world.step();
    CHECK(world.pose(id).rotation.angularDistance(start) > S(0.1));
    CHECK(world.body(id).kinetic_energy() / energy == test::relative(1).epsilon(1e-4));
  }
}

TEST_CASE("extreme_numbers: numbers that overflow only in what is computed from them") {
  auto m = make_medley<double>();
  for (int i = 0; i < 10; ++i) m.world.step();
  auto& world = m.world;
  BodyDef<double> def = brick();
  def.motion = Motion::kinematic;
  def.position = {9, 9, 9};
  const BodyId tool = world.add_body(def);
  const BodyId body = m.bodies[0];
  const Quat<double> upright = Quat<double>::Identity();
  const auto field_of = [&](auto call) {
    const std::uint64_t before = world.state_hash();
    const std::string field = refused_field(call);
    CHECK(world.state_hash() == before);
    return field;
  };
  constexpr double largest = largest_number<double>;
  const auto move_to = [&](double x) {
    return field_of([&] { world.move_to(tool, {upright, {x, 0, 0}}); });
  };
  CHECK(move_to(1e306) == "X_WB.translation[0]");
  CHECK(move_to(largest) == "X_WB.translation: velocity[0]");
  for (const double dt : {1e-200, 1e200}) {
    CHECK(field_of([&] { world.set_time_step(dt); }) == "dt");
  }
  const auto parameters = [&](SensorParameters<double> p) {
    return field_of([&] { world.set_parameters(m.patches[0], p); });
  };
  CHECK(parameters({1e308, 0, 0, 0, 1e-3}) == "SensorParameters::normal_stiffness");
  CHECK(parameters({1, 1e308, 0, 0, 1e-3}) == "SensorParameters::normal_damping");
  // Each is a fine number; their sum is not.
  const Wrench<double> push{{largest, 0, 0}, {0, 0, 0}};
  world.apply_wrench(body, push);
  CHECK(field_of([&] { world.apply_wrench(body, push); }) == "wrench.force: sum of the step[0]");
  CHECK(field_of([&] {
          world.apply_force(body, {1e100, 0, 0}, {0, 1e100, 0});
        }) == "wrench.torque[2]");
  PatchDef<double> far;
  far.sensors.add({0, 0, 0}, {0, 0, 1}, largest * 1.5);
  CHECK(field_of([&] { world.add_patch(body, far); }) == "SensorLayout::length[0]");
}

TEST_CASE_TEMPLATE("extreme_numbers: steps of any lengths follow each other", S, float, double) {
  constexpr S largest = largest_number<S>;
  World<S> world;
  (void)world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  BodyDef<S> def;
  def.shape = Box<S>{{S(0.1), S(0.2), S(0.1)}};
  def.position = {S(0), S(0), S(0.1)};
  def.angular_velocity = {S(1), S(2), S(0)};
  const BodyId box = world.add_body(def);
  for (const S dt : {S(1) / S(240), S(2) / largest, S(1) / S(240), S(1e-9), S(1) / S(60)}) {
    CAPTURE(dt);
    world.set_time_step(dt);
    // Twice: what is set between two steps comes to nothing.
    world.set_time_step(S(0.01));
    world.set_time_step(dt);
    World<S> copy = world;
    copy.restore(world.snapshot());
    CHECK(copy.state_hash() == world.state_hash());
    world.step();
    CHECK(world.pose(box).translation.allFinite());
    CHECK(world.body(box).twist.angular.allFinite());
  }
  CHECK(world.pose(box).translation.z() > S(0.05));
}

TEST_CASE(
    "extreme_numbers: a sensor whose force has no moment about the centre of mass reads none") {
  World<double> world;
  (void)world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  BodyDef<double> def;
  def.shape = Box<double>{{0.1, 0.1, 0.1}};
  def.center_of_mass = Vec3<double>(6e151, 0, 0);
  def.position = {0, 0, 0.1};
  def.angular_velocity = {0, 1e152, 1e152};
  const BodyId box = world.add_body(def);
  PatchDef<double> patch;
  patch.sensors.add({0.05, 0, -0.09}, {0.05, 0, -0.11});
  patch.sensors.add({-0.05, 0, -0.09}, {-0.05, 0, -0.11});
  patch.parameters = {10, 0.1, 300, 0.2, 1e-3};
  patch.integration = Integration::explicit_;
  const PatchId id = world.add_patch(box, patch);
  for (int i = 0; i < 3; ++i) {
    world.step();
    const PatchReading<double> reading = world.reading(id);
    for (std::size_t k = 0; k < reading.size(); ++k) CHECK(std::isfinite(reading.shear_1[k]));
    CHECK(reading.wrench.torque.allFinite());
    CHECK(reading.wrench.force.allFinite());
    CHECK(world.body(box).twist.angular.allFinite());
  }
}
