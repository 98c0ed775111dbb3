// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/dynamics/contacts/contact_target.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// A ball above a floor: height, speed and acceleration along the normal.
struct Fall {
  SolverBody<double> floor{}, ball{};
  ContactConstraint<double> contact{};
  SolveContext<double> context{};

  Fall(double gap, double start, double acceleration, double restitution, double dt = 0.1) {
    ball.start.linear = {0, 0, start};
    ball.free.linear = {0, 0, start + dt * acceleration};
    contact.axes = {Vec3<double>::UnitZ(), Vec3<double>::UnitX(), Vec3<double>::UnitY()};
    contact.gap = gap;
    contact.restitution = restitution;
    contact.impulse = {7, 1, 2};
    context.dt = dt;
    context.speed_change = context.driven_change = dt * std::abs(acceleration);
    context.position_tolerance = 1e-12;
    context.restitution_speed = 0.01;
  }
  void target() {
    ball.mean_free = mean_free_velocity(ball, context.integrator);
    target_contact(contact, floor, ball, context);
  }
};

}  // namespace

TEST_CASE("closing_time: the first root of the fall") {
  for (const double gap : {1e-6, 0.01, 0.05}) {
    for (const double v0 : {-1.0, -0.06}) {
      for (const double a : {-0.5, 0.0, 0.01}) {
        const double t = detail::closing_time(gap, v0, a);
        const double closed = gap + v0 * t + a * t * t / 2;
        CHECK((std::abs(closed) < 1e-15 || t == 1));
      }
    }
  }
  CHECK(detail::closing_time(0.0, -1.0, -1.0) == 0);
  CHECK(detail::closing_time(-0.1, -1.0, 0.0) == 0);
}

TEST_CASE("target_contact: a fall that does not reach the floor is not felt") {
  Fall fall(0.5, -1, -10, 0);  // Falls 0.1 + 0.05 within the step.
  fall.target();
  CHECK(fall.contact.target <= fall.ball.free.linear.z());
  CHECK_FALSE(fall.contact.is_impact);
  // Others may push the bodies together by the gap at most.
  Fall slow(0.5, 0, 0, 0);
  slow.target();
  CHECK(slow.contact.target == test::relative(-0.5 / 0.1));
}

TEST_CASE("target_contact: a gap that the step closes exactly at its end is closed") {
  // Speculative contacts leave such speeds, to round-off. It must not decide.
  for (const double round_off : {-1e-15, 0.0, 1e-15}) {
    Fall fall(0.1 + round_off, -1, 0, 0);
    fall.target();
    CHECK(fall.contact.target == 0);
  }
  // What bounces flies on as long as it does not touch.
  Fall bounce(0.1 + 1e-15, -1, 0, 0.5);
  bounce.target();
  CHECK(bounce.contact.target <= -1);
}

TEST_CASE("target_contact: what closes stops, and an impact takes no load over") {
  Fall impact(0.05, -1, -10, 0);
  impact.target();
  CHECK(impact.contact.target == 0);
  CHECK(impact.contact.is_impact == false);  // As slow as one step of gravity makes it.
  Fall hard(0.05, -3, -10, 0);
  hard.target();
  CHECK(hard.contact.target == 0);
  CHECK(hard.contact.is_impact);
  CHECK(hard.contact.impulse[0] == 0);
  // Motors press it by more than it approaches: that is an error of the last step.
  Fall pressed(0.05, -3, -10, 0);
  pressed.context.driven_change = 2.9;
  pressed.target();
  CHECK(pressed.contact.is_impact);
  pressed = Fall(0.05, -3, -10, 0);
  pressed.context.driven_change = 3.1;
  pressed.target();
  CHECK(pressed.contact.target == 0);
  CHECK_FALSE(pressed.contact.is_impact);
  CHECK(pressed.contact.impulse[0] == 7);
  Fall rest(0, 0, -10, 0.5);
  rest.target();
  CHECK(rest.contact.target == 0);
  CHECK(rest.contact.impulse[0] == 7);
  CHECK(rest.contact.restitution_share < 0);
}

TEST_CASE(
    "target_contact: a bounce leaves at e times the speed it hits with, at the time it hits") {
  const double gap = 0.05, v0 = -1, a = -10, e = 0.8, dt = 0.1;
  Fall fall(gap, v0, a, e, dt);
  fall.target();
  // v^2 = v0^2 + 2 |a| gap at the floor, reached after (|v| - |v0|) / |a|.
  const double hit = std::sqrt(v0 * v0 - 2 * a * gap);
  const double time = (hit + v0) / -a;
  CHECK(fall.contact.target == test::relative(e * hit + a * (dt - time)));
  CHECK(fall.contact.restitution_share == test::relative(1 - time / dt));
  fall.contact.impulse[0] = 3;
  set_position_impulse(fall.contact, fall.contact.target, fall.context);
  CHECK(fall.contact.position_impulse == test::relative(3 * (1 - time / dt)));
  CHECK(fall.contact.least_position_impulse == fall.contact.position_impulse);
}

TEST_CASE("target_contact: a bounce that ends within the step is none") {
  Fall fall(0.0, -0.4, -10, 0.5);  // Back after 0.04 s of 0.1.
  fall.target();
  CHECK(fall.contact.target == 0);
  CHECK(fall.contact.restitution_share < 0);
}

TEST_CASE(
    "target_contact: by symplectic Euler surfaces approach by their gap, and bounce at once") {
  Fall fall(0.05, -1, -10, 0.5);
  fall.context.integrator = Integrator::symplectic_euler;
  fall.target();
  CHECK(fall.contact.target == test::relative(0.5));
  Fall dead(0.05, -1, -10, 0);
  dead.context.integrator = Integrator::symplectic_euler;
  dead.target();
  CHECK(dead.contact.target == test::relative(-0.5));
  dead.contact.impulse[0] = 3;
  set_position_impulse(dead.contact, 0.0, dead.context);
  CHECK(dead.contact.position_impulse == 3);
}

TEST_CASE("set_position_impulse: bodies part where they bounce or fly apart, not by round-off") {
  const auto parts = [](double restitution, double target, double speed) {
    Fall fall(0, 0, 0, restitution);
    fall.contact.target = target;
    set_position_impulse(fall.contact, speed, fall.context);
    return fall.contact.is_separating;
  };
  CHECK_FALSE(parts(0.5, 0, 1e-9));
  CHECK_FALSE(parts(0.5, 0.005, -0.005));  // A bounce that ends the step falling again.
  CHECK(parts(0.5, 0.005, 0.005));
  CHECK(parts(0.5, 0, 0.02));
  CHECK_FALSE(parts(0, 0, 0.02));
}

namespace {

/// A contact that presses though the motion of its step leaves it apart, and what is asked of it.
template <typename S>
struct KeptOpen {
  Constraints<S> constraints{};
  std::array<SolverBody<S>, 2> bodies{};
  SolveContext<S> context{};

  KeptOpen() {
    ContactConstraint<S> contact;
    contact.body_a = 0;
    contact.body_b = 1;
    contact.axes = {Vec3<S>::UnitZ(), Vec3<S>::UnitX(), Vec3<S>::UnitY()};
    contact.gap = S(0.02);
    contact.impulse = {S(3), S(1), S(0)};
    constraints.contacts.push_back(contact);
    context.dt = S(0.1);
    context.position_tolerance = S(1e-5);
  }
  [[nodiscard]] ContactConstraint<S>& contact() { return constraints.contacts[0]; }
  [[nodiscard]] bool changes() {
    static constexpr std::array<std::uint32_t, 1> only{0};
    Island island;
    island.contacts = only;
    return open_contacts<S>(island, constraints, bodies, context);
  }
};

}  // namespace

TEST_CASE_TEMPLATE("open_contacts: what presses though its surfaces stay apart gives nothing", S,
                   float, double) {
  KeptOpen<S> open;
  REQUIRE(open.changes());
  REQUIRE(open.contact().is_open);
  target_contact(open.contact(), open.bodies[0], open.bodies[1], open.context);
  CHECK(open.contact().impulse == std::array<S, 3>{});
  CHECK(open.contact().target == -open.contact().gap / open.context.dt);
  CHECK_FALSE(open.changes());

  KeptOpen<S> closes;
  closes.bodies[1].motion.linear = {0, 0, S(-0.2)};  // All of the gap within the step.
  CHECK_FALSE(closes.changes());
  KeptOpen<S> touches;
  touches.contact().gap = 0;
  touches.bodies[1].motion.linear = {0, 0, S(0.2)};  // Apart at the end, but not from the start.
  CHECK_FALSE(touches.changes());
  KeptOpen<S> is_to_part;
  is_to_part.contact().target = S(0.1);
  CHECK_FALSE(is_to_part.changes());
  KeptOpen<S> silent;
  silent.contact().impulse = {};
  CHECK_FALSE(silent.changes());
  KeptOpen<S> bounces;
  bounces.contact().is_separating = true;
  CHECK_FALSE(bounces.changes());
  KeptOpen<S> is_moved_by_it;
  is_moved_by_it.contact().position_impulse = S(1);
  CHECK_FALSE(is_moved_by_it.changes());
}

TEST_CASE_TEMPLATE("open_contacts: what closes without its impulse is shut for good", S, float,
                   double) {
  KeptOpen<S> scene;
  REQUIRE(scene.changes());
  scene.contact().impulse[0] = S(2);  // It presses in the solution without it.
  REQUIRE(scene.changes());
  CHECK_FALSE(scene.contact().is_open);
  CHECK(scene.contact().is_shut);
  // The first solution comes back, and with it a gap: to open it again would never end.
  CHECK_FALSE(scene.changes());
}

TEST_CASE_TEMPLATE("open_contacts: gaps within the way of the surfaces are not known to be open", S,
                   float, double) {
  const auto opens = [](S speed) {
    KeptOpen<S> scene;
    scene.bodies[1].start.linear = {speed, 0, 0};
    return scene.changes();
  };
  CHECK(opens(S(0.19)));
  CHECK_FALSE(opens(S(0.21)));
}
