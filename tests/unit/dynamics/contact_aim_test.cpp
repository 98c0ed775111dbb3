// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/contact_aim.hpp>

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;

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
    context.speed_change = dt * std::abs(acceleration);
    context.position_tolerance = 1e-12;
    context.restitution_speed = 0.01;
  }
  void aim() {
    ball.free_motion = mean_free_motion(ball, context.integrator);
    aim_contact(contact, floor, ball, context);
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

TEST_CASE("aim_contact: a fall that does not reach the floor is not felt") {
  Fall fall(0.5, -1, -10, 0);  // Falls 0.1 + 0.05 within the step.
  fall.aim();
  CHECK(fall.contact.target <= fall.ball.free.linear.z());
  CHECK_FALSE(fall.contact.is_impact);
  // Others may push the bodies together by the gap at most.
  Fall slow(0.5, 0, 0, 0);
  slow.aim();
  CHECK(slow.contact.target == doctest::Approx(-0.5 / 0.1));
}

TEST_CASE("aim_contact: what closes stops, and an impact takes no load over") {
  Fall impact(0.05, -1, -10, 0);
  impact.aim();
  CHECK(impact.contact.target == 0);
  CHECK(impact.contact.is_impact == false);  // As slow as one step of gravity makes it.
  Fall hard(0.05, -3, -10, 0);
  hard.aim();
  CHECK(hard.contact.target == 0);
  CHECK(hard.contact.is_impact);
  CHECK(hard.contact.impulse[0] == 0);
  Fall rest(0, 0, -10, 0.5);
  rest.aim();
  CHECK(rest.contact.target == 0);
  CHECK(rest.contact.impulse[0] == 7);
  CHECK(rest.contact.bounce_share < 0);
}

TEST_CASE("aim_contact: a bounce leaves at e times the speed it hits with, at the time it hits") {
  const double gap = 0.05, v0 = -1, a = -10, e = 0.8, dt = 0.1;
  Fall fall(gap, v0, a, e, dt);
  fall.aim();
  // v^2 = v0^2 + 2 |a| gap at the floor, reached after (|v| - |v0|) / |a|.
  const double hit = std::sqrt(v0 * v0 - 2 * a * gap);
  const double time = (hit + v0) / -a;
  CHECK(fall.contact.target == doctest::Approx(e * hit + a * (dt - time)));
  CHECK(fall.contact.bounce_share == doctest::Approx(1 - time / dt));
  fall.contact.impulse[0] = 3;
  place_contact(fall.contact, fall.contact.target, fall.context);
  CHECK(fall.contact.placed == doctest::Approx(3 * (1 - time / dt)));
  CHECK(fall.contact.least_placed == fall.contact.placed);
}

TEST_CASE("aim_contact: a bounce that ends within the step is none") {
  Fall fall(0.0, -0.4, -10, 0.5);  // Back after 0.04 s of 0.1.
  fall.aim();
  CHECK(fall.contact.target == 0);
  CHECK(fall.contact.bounce_share < 0);
}

TEST_CASE("aim_contact: by symplectic Euler surfaces approach by their gap, and bounce at once") {
  Fall fall(0.05, -1, -10, 0.5);
  fall.context.integrator = Integrator::symplectic_euler;
  fall.aim();
  CHECK(fall.contact.target == doctest::Approx(0.5));
  Fall dead(0.05, -1, -10, 0);
  dead.context.integrator = Integrator::symplectic_euler;
  dead.aim();
  CHECK(dead.contact.target == doctest::Approx(-0.5));
  dead.contact.impulse[0] = 3;
  place_contact(dead.contact, 0.0, dead.context);
  CHECK(dead.contact.placed == 3);
}

TEST_CASE("place_contact: bodies part where they bounce or fly apart, not by round-off") {
  const auto parts = [](double restitution, double target, double speed) {
    Fall fall(0, 0, 0, restitution);
    fall.contact.target = target;
    place_contact(fall.contact, speed, fall.context);
    return fall.contact.parts;
  };
  CHECK_FALSE(parts(0.5, 0, 1e-9));
  CHECK_FALSE(parts(0.5, 0.005, -0.005));  // A bounce that ends the step falling again.
  CHECK(parts(0.5, 0.005, 0.005));
  CHECK(parts(0.5, 0, 0.02));
  CHECK_FALSE(parts(0, 0, 0.02));
}
