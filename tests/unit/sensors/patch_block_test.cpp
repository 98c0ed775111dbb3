// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/sensors/patch_block.hpp>

#include <doctest/doctest.h>

using namespace bristle;

namespace {

/// A patch whose contacts are random but possible.
SensorPatch<double> random_patch(test::Random& random, PatchPair<double>& pair) {
  SensorPatch<double> patch;
  patch.def.parameters = {2, 0.05, 3000, 0.4, 1e-3};
  patch.def.options.normal =
      random.index(2) == 0 ? NormalDirection::ray : NormalDirection::gradient;
  pair.first = 0;
  pair.count = 9;
  for (std::uint32_t i = 0; i < pair.count; ++i) {
    PatchContact<double> c{};
    c.sensor = i;
    c.n = random.direction<double>();
    Vec3<double> m;
    do {
      m = random.direction<double>();
    } while (m.dot(c.n) > -0.3);
    c.g = depth_gradient<double>(c.n, m);
    c.rho = random.in_cube(0.1);
    c.depth = random.uniform(0.1, 0.9);
    c.length = 0.01;
    c.is_touching = true;
    c.start_velocity = random.in_cube(0.01);
    c.stretch = tangential<double>(random.in_cube(5e-4), c.n);
    patch.contacts.push_back(c);
  }
  set_scheme(pair, 9 * 3000 * 1.0, 9 * 0.4, 0.5, 1e-3);
  return patch;
}

Vec6<double> random_motion(test::Random& random, double size) {
  Vec6<double> u;
  u << random.in_cube(size), random.in_cube(size);
  return u;
}

}  // namespace

TEST_CASE_TEMPLATE("set_scheme: nearly conservative when soft, implicit Euler when stiff", S, float,
                   double) {
  PatchPair<S> pair;
  set_scheme(pair, S(0), S(0), S(1), S(1e-3));
  CHECK(pair.alpha == S(0));
  CHECK(pair.beta == S(1) / S(12));
  CHECK(pair.theta == S(0.5));
  set_scheme(pair, S(1e12), S(0), S(1), S(1));
  CHECK(static_cast<double>(pair.alpha) == doctest::Approx(1));
  CHECK(static_cast<double>(pair.beta) == doctest::Approx(0));
  CHECK(static_cast<double>(pair.theta) == doctest::Approx(1));
  // x = w (dt^2 k + dt c) = 0.5 (0.01 * 100 + 0.1 * 10) = 1.
  set_scheme(pair, S(100), S(10), S(0.5), S(0.1));
  CHECK(static_cast<double>(pair.alpha) == doctest::Approx(0.5).epsilon(1e-6));
  CHECK(static_cast<double>(pair.beta) == doctest::Approx(0.25 / 12).epsilon(1e-6));
}

TEST_CASE("fill_block: is the sum of its sensors, and never gives energy") {
  test::Random random(5);
  for (int round = 0; round < 20; ++round) {
    PatchPair<double> pair;
    SensorPatch<double> patch = random_patch(random, pair);
    start_linearisation(patch, pair, 1e-3);
    SoftBlock<double> block;
    fill_block(patch, pair, block);
    // Symmetric positive semidefinite.
    CHECK((block.matrix - block.matrix.transpose()).norm() < 1e-12 * block.matrix.norm());
    for (int i = 0; i < 10; ++i) {
      const Vec6<double> u = random_motion(random, 1);
      CHECK(u.dot(block.matrix * u) >= -1e-12 * block.matrix.norm());
    }
    // What each sensor gives at a motion adds up to offset + matrix u. Small: no sensor may part.
    const Vec6<double> u = random_motion(random, 1e-4);
    const Wrench<double> sum = evaluate_impulses(patch, pair, u);
    Vec6<double> expected = block.offset + block.matrix * u;
    CHECK((sum.force - expected.head<3>()).norm() < 1e-14);
    CHECK((sum.torque - expected.tail<3>()).norm() < 1e-14);
  }
}

TEST_CASE("start_linearisation: at rest gives what the explicit law gives") {
  test::Random random(6);
  PatchPair<double> pair;
  SensorPatch<double> patch = random_patch(random, pair);
  for (PatchContact<double>& c : patch.contacts) c.start_velocity.setZero();
  const double dt = 1e-3;
  start_linearisation(patch, pair, dt);
  (void)evaluate_impulses<double>(patch, pair, Vec6<double>::Zero());
  for (const PatchContact<double>& c : patch.contacts) {
    const SensorContact<double> contact{c.depth, c.length, c.n, c.g, Vec3<double>::Zero()};
    const SensorForce<double> f =
        sensor_force(patch.def.parameters, patch.def.options, contact, c.stretch, dt);
    CHECK((c.impulse - dt * f.total()).norm() < 1e-15);
    CHECK(c.normal_impulse == doctest::Approx(dt * f.normal).epsilon(1e-12));
  }
}

TEST_CASE("update_linearisation: a settled patch needs no further solve") {
  test::Random random(7);
  PatchPair<double> pair;
  SensorPatch<double> patch = random_patch(random, pair);
  for (PatchContact<double>& c : patch.contacts) c.start_velocity.setZero();
  start_linearisation(patch, pair, 1e-3);
  (void)evaluate_impulses<double>(patch, pair, Vec6<double>::Zero());
  CHECK_FALSE(update_linearisation<double>(patch, pair, Vec6<double>::Zero(), 1e-3, 1, false));
}

TEST_CASE("update_linearisation: notices parting and slip") {
  test::Random random(8);
  PatchPair<double> pair;
  SensorPatch<double> patch = random_patch(random, pair);
  start_linearisation(patch, pair, 1e-3);
  Vec6<double> u = Vec6<double>::Zero();
  u.head<3>() = -1e3 * patch.contacts[0].g.normalized();
  (void)evaluate_impulses(patch, pair, u);
  CHECK(patch.contacts[0].normal_impulse == 0);
  CHECK(update_linearisation<double>(patch, pair, u, 1e-3, 1, false));
  CHECK_FALSE(patch.contacts[0].is_pushing);
  CHECK(patch.contacts[0].force == 0);
  // 1 m in a step is far beyond sigma_a.
  CHECK(patch.contacts[1].is_slipping);
}
