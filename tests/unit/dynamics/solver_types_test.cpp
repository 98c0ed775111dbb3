// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/math/rotation.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// A contact in general position.
template <typename S>
ContactConstraint<S> contact() {
  ContactConstraint<S> c;
  c.body_a = 0;
  c.body_b = 1;
  c.axes[0] = Vec3<S>(1, 2, -2) / S(3);
  tangent_basis<S>(c.axes[0], c.axes[1], c.axes[2]);
  c.arm_a = {S(0.3), S(-0.2), S(0.5)};
  c.arm_b = {S(-0.4), S(0.1), S(0.7)};
  return c;
}

/// Change of the velocity along each axis by a unit impulse along each axis.
template <typename S>
Mat3<S> measured_change(const ContactConstraint<S>& c, const SolverBody<S>& a,
                        const SolverBody<S>& b) {
  Mat3<S> K;
  for (std::size_t j = 0; j < 3; ++j) {
    SolverBody<S> pushed_a = a;
    SolverBody<S> pushed_b = b;
    apply_at_contact<S>(c, c.axes[j], pushed_a, pushed_b, velocity_of);
    const Vec3<S> v = c.velocity(pushed_a.twist, pushed_b.twist);
    for (std::size_t i = 0; i < 3; ++i) {
      K(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = c.axes[i].dot(v);
    }
  }
  return K;
}

template <typename S>
void check_same(const ContactResponse<S>& K, const Mat3<S>& expected) {
  Mat3<S> found;
  found << K.nn, K.n1, K.n2, K.n1, K.a, K.b, K.n2, K.b, K.c;
  CHECK((found - expected).cwiseAbs().maxCoeff() <
        S(4) * Tolerance<S>::round_off() * expected.cwiseAbs().maxCoeff());
}

template <typename S>
SolverBody<S> body(const Vec3<S>& inverse_mass, const Mat3<S>& inverse_inertia) {
  SolverBody<S> result;
  result.moves = true;
  result.inverse_mass = inverse_mass;
  result.inverse_inertia = inverse_inertia;
  return result;
}

}  // namespace

TEST_CASE_TEMPLATE("contact_response: what impulses at the contact do", S, float, double) {
  const ContactConstraint<S> c = contact<S>();
  Mat3<S> skewed;
  skewed << S(3), S(0.5), S(-0.25), S(0.5), S(2), S(0.125), S(-0.25), S(0.125), S(1);
  const SolverBody<S> fixed;
  const SolverBody<S> crate = body<S>(Vec3<S>::Constant(S(2)), skewed);
  const SolverBody<S> on_rail = body<S>(Vec3<S>(1, 0, 3), skewed);
  SolverBody<S> ball = body<S>(Vec3<S>::Constant(S(0.5)), Mat3<S>::Identity() * S(4));
  ball.is_isotropic = true;
  const auto check_pair = [&](const SolverBody<S>& a, const SolverBody<S>& b) {
    check_same<S>(contact_response(c, ContactFrame<S>(c, a, b)), measured_change<S>(c, a, b));
  };
  check_pair(fixed, crate);
  check_pair(crate, on_rail);
  check_pair(on_rail, ball);
  check_pair(ball, fixed);
}

TEST_CASE_TEMPLATE("apply_impulses: the points of a manifold push as each does alone", S, float,
                   double) {
  Mat3<S> skewed;
  skewed << S(3), S(0.5), S(-0.25), S(0.5), S(2), S(0.125), S(-0.25), S(0.125), S(1);
  std::vector<SolverBody<S>> bodies{body<S>(Vec3<S>::Constant(S(2)), skewed),
                                    body<S>(Vec3<S>(1, 0, 3), skewed), SolverBody<S>{}};
  bodies[0].free.linear = {S(1), S(2), S(3)};
  Constraints<S> constraints;
  for (int i = 0; i < 5; ++i) {
    ContactConstraint<S> c = contact<S>();
    c.body_b = i < 3 ? 1 : 2;
    c.arm_a += Vec3<S>::Constant(S(0.1) * S(i));
    c.impulse = {S(1) + S(i), S(0.5), S(-0.25) * S(i)};
    constraints.contacts.push_back(c);
  }
  std::vector<SolverBody<S>> expected = bodies;
  for (SolverBody<S>& b : expected) b.twist = b.free;
  for (const ContactConstraint<S>& c : constraints.contacts) {
    apply_at_contact<S>(c, c.impulse_W(), expected[c.body_a], expected[c.body_b], velocity_of);
  }
  const std::vector<std::uint32_t> slots{0, 1}, contacts{0, 1, 2, 3, 4};
  Island island;
  island.bodies = slots;
  island.contacts = contacts;
  apply_impulses<S>(island, constraints, bodies);
  // Speeds of up to 40 m/s.
  const S tolerance = S(40) * Tolerance<S>::round_off();
  for (std::size_t i = 0; i < 3; ++i) {
    const Twist<S> difference = bodies[i].twist - expected[i].twist;
    CHECK(difference.linear.norm() <= tolerance);
    CHECK(difference.angular.norm() <= tolerance);
  }
}

TEST_CASE("apply_soft: neither body gains momentum that the other does not lose") {
  const double mass_a = 0.5;
  const double mass_b = 2;
  const Vec3<double> inertia_a(0.1, 0.2, 0.25);
  const Vec3<double> inertia_b(0.3, 0.4, 0.5);
  const auto make = [](double mass, const Vec3<double>& inertia) {
    return body<double>(Vec3<double>::Constant(1 / mass), inertia.cwiseInverse().asDiagonal());
  };
  SolverBody<double> a = make(mass_a, inertia_a);
  SolverBody<double> b = make(mass_b, inertia_b);
  SoftBlock<double> block;
  block.arm_a = {0.3, -0.2, 0.5};
  block.arm_b = {-0.4, 0.1, 0.7};
  Vec6<double> p;
  p << 1, -2, 3, 0.5, 0.25, -0.75;
  apply_soft<double>(block, p, a, b);
  CHECK((mass_b * b.twist.linear - p.head<3>()).norm() < 1e-15);
  CHECK((mass_a * a.twist.linear + p.head<3>()).norm() < 1e-15);
  // About the point where the block acts: a's centre is at -arm_a from it.
  const Vec3<double> L_a =
      inertia_a.cwiseProduct(a.twist.angular) - block.arm_a.cross(mass_a * a.twist.linear);
  const Vec3<double> L_b =
      inertia_b.cwiseProduct(b.twist.angular) - block.arm_b.cross(mass_b * b.twist.linear);
  CHECK((L_b - p.tail<3>()).norm() < 1e-14);
  CHECK((L_a + p.tail<3>()).norm() < 1e-14);
}
