// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/dynamics/contacts/contact_constraint.hpp>

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// A response with given diagonal and one coupling, of the tangents.
template <typename S>
ContactResponse<S> response(S normal, S t1, S t2, S coupling = S(0)) {
  ContactResponse<S> K;
  K.nn = normal;
  K.a = t1;
  K.b = coupling;
  K.c = t2;
  K.prepare();
  return K;
}

template <typename S>
ContactConstraint<S> constraint_at(S friction) {
  ContactConstraint<S> c;
  c.axes = {Vec3<S>::UnitX(), Vec3<S>::UnitY(), Vec3<S>::UnitZ()};
  c.friction = friction;
  return c;
}

}  // namespace

TEST_CASE_TEMPLATE("solve_contact: stops approach and never pulls", S, float, double) {
  ContactConstraint<S> c = constraint_at(S(0));
  const ContactResponse<S> K = response<S>(2, 1, 1);
  CHECK(solve_contact(c, K, Vec3<S>(-4, 0, 0))[0] == S(2));
  CHECK(c.impulse[0] == S(2));
  CHECK(solve_contact(c, K, Vec3<S>(6, 0, 0))[0] == S(-2));
  CHECK(c.impulse[0] == S(0));
}

TEST_CASE_TEMPLATE("solve_contact: friction stops what the disk allows, in every direction", S,
                   float, double) {
  for (const S angle : {S(0), S(0.5), S(0.8), S(2), S(4)}) {
    const S x = std::cos(angle);
    const S y = std::sin(angle);
    // Sticks: slip of 1 needs 1, mu N = 2.
    ContactConstraint<S> stick = constraint_at(S(0.5));
    solve_contact(stick, response<S>(1, 1, 1), Vec3<S>(-4, x, y));
    CHECK(std::abs(stick.impulse[1] + x) < S(4) * Tolerance<S>::round_off());
    CHECK(std::abs(stick.impulse[2] + y) < S(4) * Tolerance<S>::round_off());
    // Slides: exactly mu N against the slip.
    ContactConstraint<S> slide = constraint_at(S(0.5));
    solve_contact(slide, response<S>(1, 1, 1), Vec3<S>(-4, 9 * x, 9 * y));
    CHECK(std::abs(slide.impulse[1] + 2 * x) < S(8) * Tolerance<S>::round_off());
    CHECK(std::abs(slide.impulse[2] + 2 * y) < S(8) * Tolerance<S>::round_off());
  }
}

TEST_CASE("solve_contact: where directions respond differently, friction still opposes the slip") {
  ContactConstraint<double> c = constraint_at(1.0);
  const ContactResponse<double> K = response<double>(1, 2, 0.5, 0.3);
  // Repeated with the velocities that follow, as a solver does.
  Vec3<double> velocity(-1, 5, 3);
  for (int i = 0; i < 500; ++i) {
    const auto x = solve_contact(c, K, velocity);
    velocity += Vec3<double>(K.nn * x[0], K.a * x[1] + K.b * x[2], K.b * x[1] + K.c * x[2]);
  }
  const double t1 = c.impulse[1];
  const double t2 = c.impulse[2];
  CHECK(std::hypot(t1, t2) == test::relative(1).epsilon(1e-9));
  CHECK(std::abs(t1 * velocity[2] - t2 * velocity[1]) < 1e-9);
  CHECK(t1 * velocity[1] + t2 * velocity[2] < 0);
}

TEST_CASE_TEMPLATE("solve_contact: between two immovable bodies nothing happens", S, float,
                   double) {
  ContactConstraint<S> c = constraint_at(S(0.5));
  for (const S x : solve_contact(c, response<S>(0, 0, 0), Vec3<S>(-1, 1, 1))) CHECK(x == S(0));
}

TEST_CASE_TEMPLATE("ContactConstraint: measures the velocity of B against A along the normal", S,
                   float, double) {
  ContactConstraint<S> c = constraint_at(S(0));
  c.arm_a = {0, 2, 0};
  c.arm_b = {0, 3, 0};
  const Twist<S> a{{1, 0, 0}, {0, 0, 10}};
  const Twist<S> b{{5, 0, 0}, {0, 0, 100}};
  // v + w x r: 5 - 100 * 3 against 1 - 10 * 2.
  CHECK(c.normal_velocity(a, b) == S(5 - 300 - (1 - 20)));
}

TEST_CASE_TEMPLATE("solve_contact: neither impulse nor friction exceeds the bound of a contact", S,
                   float, double) {
  ContactConstraint<S> c = constraint_at(S(0.5));
  c.most_impulse = S(3);
  const auto x = solve_contact(c, response<S>(1, 1, 1), Vec3<S>(-10, 4, 0));
  CHECK(x[0] == S(3));
  CHECK(c.impulse[1] == test::relative(-1.5));
  CHECK(c.impulse[2] == S(0));
}
