/// @file
/// Random islands of contacts for tests of solvers, and how far a solution is from the rules of
/// contact.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/random.hpp"

#include <bristle/dynamics/solver/solver_types.hpp>
#include <bristle/math/rotation.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace bristle::test {

using namespace bristle::detail;

/// Bodies on an immovable one (slot 0), each on the one before, with all their contacts.
template <typename S>
struct ContactIsland {
  std::vector<SolverBody<S>> bodies;
  Constraints<S> constraints;
  std::vector<std::uint32_t> moving, contacts;

  [[nodiscard]] Island island() const { return {moving, contacts, {}, {}}; }
};

/// @param heaviest  [kg] Masses are spread from 1 to this, evenly in their logarithm.
template <typename S>
ContactIsland<S> random_pile(Random& random, std::uint32_t count, std::uint32_t points, S friction,
                             S heaviest) {
  ContactIsland<S> pile;
  pile.bodies.resize(count + 1);
  for (std::uint32_t i = 1; i <= count; ++i) {
    SolverBody<S>& body = pile.bodies[i];
    body.mass = std::pow(heaviest, random.uniform(S(0), S(1)));
    body.inverse_mass.setConstant(S(1) / body.mass);
    const Mat3<S> R = random.rotation<S>().toRotationMatrix();
    body.inertia =
        body.mass * (R * Vec3<S>(S(0.02), S(0.03), S(0.04)).asDiagonal() * R.transpose());
    body.inverse_inertia = body.inertia.inverse();
    body.moves = true;
    body.free = {Vec3<S>(random.uniform(S(-0.1), S(0.1)), random.uniform(S(-0.1), S(0.1)), S(-1)),
                 random.in_cube(S(0.2))};
    body.twist = body.free;
    pile.moving.push_back(i);
  }
  for (std::uint32_t i = 1; i <= count; ++i) {
    ContactConstraint<S> c;
    c.body_a = i - 1;
    c.body_b = i;
    c.axes[0] = (Vec3<S>(S(0), S(0), S(1)) + random.in_cube(S(0.2))).normalized();
    tangent_basis<S>(c.axes[0], c.axes[1], c.axes[2]);
    c.friction = friction;
    for (std::uint32_t k = 0; k < points; ++k) {
      // Corners of a patch: loads on them have no other choice than to be shared.
      const S angle = S(6.2831853) * (S(k) + random.uniform(S(0), S(0.3))) / S(points);
      const Vec3<S> place = S(0.2) * (std::cos(angle) * c.axes[1] + std::sin(angle) * c.axes[2]);
      c.arm_a = place + S(0.1) * c.axes[0];
      c.arm_b = place - S(0.1) * c.axes[0];
      pile.contacts.push_back(static_cast<std::uint32_t>(pile.constraints.contacts.size()));
      pile.constraints.contacts.push_back(c);
    }
  }
  return pile;
}

/// [m/s] How far impulses and velocities are from the rules of contact: no approach, no pull, no
/// push on what parts, friction within the disk and against the slip at its edge. Zero for a
/// solution.
template <typename S>
S contact_error(const ContactIsland<S>& pile) {
  using std::abs;
  using std::max;
  S worst = S(0);
  for (const ContactConstraint<S>& c : pile.constraints.contacts) {
    const SolverBody<S>& a = pile.bodies[c.body_a];
    const SolverBody<S>& b = pile.bodies[c.body_b];
    const ContactResponse<S> K = contact_response(c, ContactFrame<S>(c, a, b));
    const Vec3<S> v = c.velocity(a.twist, b.twist);
    const S normal = c.impulse[0] - (c.axes[0].dot(v) - c.target) / K.nn;
    worst = max(worst, K.nn * abs(c.impulse[0] - max(S(0), normal)));
    S x = c.impulse[1] - c.axes[1].dot(v) / K.largest;
    S y = c.impulse[2] - c.axes[2].dot(v) / K.largest;
    const S size = std::hypot(x, y);
    const S radius = c.friction * c.impulse[0];
    if (size > radius) {
      x *= radius / size;
      y *= radius / size;
    }
    worst = max(worst, K.largest * std::hypot(c.impulse[1] - x, c.impulse[2] - y));
  }
  return worst;
}

}  // namespace bristle::test
