// SPDX-License-Identifier: BSD-3-Clause
#include "support/body_motion.hpp"
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/sensors/law.hpp>
#include <bristle/sensors/sensor_wrench.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

namespace {

template <typename S>
constexpr S law_round_off = S(8) * Tolerance<S>::round_off();

template <typename S>
SensorParameters<S> constants() {
  return {S(2), S(0.05), S(3000), S(0.4), S(1e-3)};
}

/// Random pair of poses and an anchor between them.
template <typename S>
PairPose<S> random_law_pair(test::Random& random) {
  return {random.rotation<S>().toRotationMatrix(), random.in_cube(S(0.1))};
}

}  // namespace

TEST_CASE_TEMPLATE("sensor_depth: 1 at the start of the ray, 0 at its end, negative beyond", S,
                   float, double) {
  // L = 1/64 m, so that 1 / L is exact.
  const S per_length = S(64);
  CHECK(sensor_depth(S(0), per_length) == S(1));
  CHECK(sensor_depth(S(0.25) / per_length, per_length) == S(0.75));
  CHECK(sensor_depth(S(1) / per_length, per_length) == S(0));
  CHECK(sensor_depth(S(1.5) / per_length, per_length) == S(-0.5));
}

TEST_CASE_TEMPLATE("depth_gradient: is n head-on, and g . n = 1 always", S, float, double) {
  const Vec3<S> n(0, 0, -1);
  CHECK(depth_gradient<S>(n, Vec3<S>(0, 0, 1)) == n);
  test::Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Vec3<S> d = random.direction<S>();
    Vec3<S> m = random.direction<S>();
    if (m.dot(d) > S(-0.1)) continue;
    const Vec3<S> g = depth_gradient<S>(d, m);
    CHECK(std::abs(g.dot(d) - S(1)) < law_round_off<S> / -m.dot(d));
    // Moving the sensor along the surface does not change the depth.
    Vec3<S> along = m.cross(d);
    CHECK(std::abs(g.dot(along)) < S(10) * law_round_off<S>);
  }
}

TEST_CASE("depth_gradient: is the derivative of the depth") {
  // A plane with normal m through the origin, a ray from s along n: distance = -(m.s) / (m.n).
  test::Random random(2);
  for (int i = 0; i < 50; ++i) {
    const Vec3<double> n = random.direction<double>();
    const Vec3<double> m = random.direction<double>();
    if (m.dot(n) > -0.2) continue;
    const Vec3<double> s = random.in_cube(0.01);
    const Vec3<double> step = 1e-4 * random.direction<double>();
    const double length = 0.03;
    const auto depth = [&](const Vec3<double>& start) {
      return sensor_depth(-m.dot(start) / m.dot(n), 1 / length);
    };
    // The depth is linear in the start, so the difference quotient is exact.
    CHECK(depth(s + step) - depth(s) ==
          test::relative(depth_gradient<double>(n, m).dot(step) / length).epsilon(1e-9));
  }
}

TEST_CASE_TEMPLATE("normal_force: spring and damper, never adhesive", S, float, double) {
  const SensorParameters<S> p = constants<S>();
  CHECK(normal_force(p, S(0.5), S(0)) == S(1));
  CHECK(normal_force(p, S(0.5), S(10)) == S(1) + S(0.05) * S(10));
  CHECK(normal_force(p, S(0.5), S(-20)) == S(0));
  CHECK(normal_force(p, S(0.5), S(-21)) == S(0));
}

TEST_CASE_TEMPLATE("bristle_stiffness: grows with force (Eq. 1), depth (Eq. 11) or nothing", S,
                   float, double) {
  const SensorParameters<S> p = constants<S>();
  CHECK(bristle_stiffness(p, FrictionScaling::normal_force, S(0.5), S(0.25)) == S(1500));
  CHECK(bristle_stiffness(p, FrictionScaling::depth, S(0.5), S(0.25)) == S(750));
  CHECK(bristle_stiffness(p, FrictionScaling::none, S(0.5), S(0.25)) == S(3000));
}

TEST_CASE_TEMPLATE("wrapped: keeps what exceeds whole multiples; clipped: at most sigma", S, float,
                   double) {
  const Vec3<S> h = Vec3<S>(S(0.6), 0, S(-0.8));
  const S sigma = S(0.5);
  CHECK(wrapped<S>(S(0.4) * h, sigma) == S(0.4) * h);
  CHECK(wrapped<S>(S(0.7) * h, sigma).isApprox(S(0.2) * h, law_round_off<S>));
  CHECK(wrapped<S>(S(1.9) * h, sigma).isApprox(S(0.4) * h, S(4) * law_round_off<S>));
  CHECK(clipped<S>(S(0.4) * h, sigma) == S(0.4) * h);
  CHECK(clipped<S>(S(1.9) * h, sigma).isApprox(sigma * h, law_round_off<S>));
  CHECK(wrapped<S>(Vec3<S>::Zero(), sigma) == Vec3<S>::Zero());
  CHECK(after_reset<S>(S(0.7) * h, sigma, SlipReset::drag).isApprox(sigma * h, law_round_off<S>));
  CHECK(
      after_reset<S>(S(0.7) * h, sigma, SlipReset::release).isApprox(S(0.2) * h, law_round_off<S>));
}

TEST_CASE_TEMPLATE("anchored: an anchor has the stretch it was given, whatever the poses", S, float,
                   double) {
  test::Random random(3);
  for (int i = 0; i < 100; ++i) {
    const PairPose<S> pair = random_law_pair<S>(random);
    const Vec3<S> r_A = random.in_cube(S(0.1));
    const Vec3<S> n = random.direction<S>();
    const Vec3<S> stretch = tangential<S>(random.in_cube(S(0.01)), n);
    const Anchor<S> anchor = anchored<S>(pair, r_A, stretch);
    CHECK((anchor_stretch(anchor, pair, n) - stretch).norm() < S(0.2) * law_round_off<S>);
  }
}

TEST_CASE_TEMPLATE("anchor_stretch: A displaced by +x against B is stretched by +x", S, float,
                   double) {
  PairPose<S> pair;
  pair.p_AB = {0, 0, S(-0.1)};
  const Vec3<S> n(0, 0, -1);
  const Anchor<S> anchor = anchored<S>(pair, Vec3<S>(0, 0, S(-0.05)), Vec3<S>::Zero());
  pair.p_AB.x() -= S(0.01);
  pair.p_AB.z() += S(0.02);  // Along n: no stretch.
  CHECK(anchor_stretch(anchor, pair, n).isApprox(Vec3<S>(S(0.01), 0, 0), S(10) * law_round_off<S>));
}

TEST_CASE_TEMPLATE("advance_anchor: roots, keeps, and resets beyond sigma", S, float, double) {
  PairPose<S> pair;
  const Vec3<S> n(0, 0, -1);
  const Vec3<S> r_A(0, 0, S(-0.05));
  const S sigma = S(1e-3);
  Anchor<S> anchor;
  bool did_slip = true;
  CHECK(advance_anchor(anchor, false, pair, n, r_A, sigma, SlipReset::release, did_slip) ==
        Vec3<S>::Zero());
  CHECK_FALSE(did_slip);
  pair.p_AB.x() = -S(0.9e-3);
  const Anchor<S> before = anchor;
  Vec3<S> stretch = advance_anchor(anchor, true, pair, n, r_A, sigma, SlipReset::release, did_slip);
  CHECK(std::abs(stretch.x() - S(0.9e-3)) < S(1e-3) * law_round_off<S>);
  CHECK_FALSE(did_slip);
  CHECK(anchor.q_A == before.q_A);
  CHECK(anchor.q_B == before.q_B);
  pair.p_AB.x() = -S(1.3e-3);
  for (const SlipReset reset : {SlipReset::release, SlipReset::drag}) {
    Anchor<S> moved = anchor;
    stretch = advance_anchor(moved, true, pair, n, r_A, sigma, reset, did_slip);
    const S kept = reset == SlipReset::drag ? sigma : S(0.3e-3);
    CHECK(did_slip);
    CHECK(std::abs(stretch.x() - kept) < S(1e-2) * law_round_off<S>);
    // The new roots say the same in the next step.
    CHECK(std::abs(anchor_stretch(moved, pair, n).x() - kept) < S(1e-2) * law_round_off<S>);
  }
}

TEST_CASE_TEMPLATE("sensor_force: F_N n + k_t e_T + mu_V v_T, normal damping as a rate", S, float,
                   double) {
  const SensorParameters<S> p = constants<S>();
  SensorContact<S> c;
  c.depth = S(0.5);
  c.inverse_length = S(50);
  c.n = {0, 0, -1};
  c.g = c.n;
  c.v = {S(0.1), S(-0.2), S(-0.06)};
  const Vec3<S> stretch(S(2e-4), 0, 0);
  const SensorForce<S> f = sensor_force(p, LawOptions{}, c, stretch, S(1e-3));
  // de_N/dt = g.v / L = 3 / s; F_N = 2 * 0.5 + 0.05 * 3.
  const S normal = S(1.15);
  CHECK(std::abs(f.normal - normal) < law_round_off<S>);
  CHECK(f.normal_vector.isApprox(Vec3<S>(0, 0, -normal), law_round_off<S>));
  CHECK(f.shear.isApprox(Vec3<S>(S(3000) * normal * S(2e-4) + S(0.4) * S(0.1), S(0.4) * S(-0.2), 0),
                         law_round_off<S>));
  CHECK(f.total() == f.normal_vector + f.shear);
  // Halving the step changes nothing: all terms are rates.
  const SensorForce<S> half = sensor_force(p, LawOptions{}, c, stretch, S(5e-4));
  CHECK(half.normal == f.normal);
  CHECK(half.shear == f.shear);
}

TEST_CASE_TEMPLATE("sensor_force: along the ray, or along the gradient", S, float, double) {
  SensorParameters<S> p = constants<S>();
  p.normal_damping = S(0);
  SensorContact<S> c;
  c.depth = S(0.5);
  c.inverse_length = S(50);
  c.n = Vec3<S>(S(0.6), 0, S(-0.8));
  c.g = depth_gradient<S>(c.n, Vec3<S>(0, 0, 1));
  LawOptions options;
  options.normal = NormalDirection::ray;
  CHECK(sensor_force(p, options, c, Vec3<S>(Vec3<S>::Zero()), S(1e-3))
            .total()
            .isApprox(c.n, law_round_off<S>));
  options.normal = NormalDirection::gradient;
  const SensorForce<S> f = sensor_force(p, options, c, Vec3<S>(Vec3<S>::Zero()), S(1e-3));
  CHECK(f.total().isApprox(Vec3<S>(0, 0, S(-1.25)), law_round_off<S>));
  // The same component along the ray either way.
  CHECK(std::abs(f.total().dot(c.n) - S(1)) < law_round_off<S>);
}

TEST_CASE_TEMPLATE("sensor_force: a bristle that passes whole stretches has its mean one", S, float,
                   double) {
  SensorParameters<S> p = constants<S>();
  p.sliding_friction = S(0);
  SensorContact<S> c;
  c.depth = S(0.5);
  c.n = {0, 0, -1};
  c.g = c.n;
  c.v = {0, S(3), 0};
  const Vec3<S> stretch(S(9e-4), 0, 0);
  LawOptions options;
  // 3 mm a step: sigma_a / 2 along the slip.
  const SensorForce<S> fast = sensor_force(p, options, c, stretch, S(1e-3));
  CHECK(fast.shear.isApprox(Vec3<S>(0, S(3000) * S(5e-4), 0), law_round_off<S>));
  options.reset = SlipReset::drag;
  CHECK(sensor_force(p, options, c, stretch, S(1e-3))
            .shear.isApprox(Vec3<S>(S(3000) * S(9e-4), 0, 0), law_round_off<S>));
}

TEST_CASE_TEMPLATE("sensor_wrench: is exactly zero without a hit, and forgets", S, float, double) {
  SensorMemory<S> memory;
  memory.is_anchored = true;
  const Ray<S> ray{Vec3<S>::Zero(), Vec3<S>(0, 0, -1), S(0.01)};
  const test::BodyMotion<S> A, B;
  for (const S distance : {S(0.01), S(0.02), infinity<S>}) {
    memory.is_anchored = true;
    const Wrench<S> w = sensor_wrench(constants<S>(), LawOptions{}, ray, distance, Vec3<S>(0, 0, 1),
                                      A.pose, A.twist, B.pose, B.twist, S(1e-3), memory);
    CHECK(w.force == Vec3<S>::Zero());
    CHECK(w.torque == Vec3<S>::Zero());
    CHECK_FALSE(memory.is_anchored);
  }
  // Grazing, and from behind.
  memory.is_anchored = true;
  const Wrench<S> w = sensor_wrench(constants<S>(), LawOptions{}, ray, S(0.005), Vec3<S>(1, 0, 0),
                                    A.pose, A.twist, B.pose, B.twist, S(1e-3), memory);
  CHECK(w.force == Vec3<S>::Zero());
  CHECK_FALSE(memory.is_anchored);
}

TEST_CASE_TEMPLATE("sensor_wrench: opposes displacement and turns A as r x F", S, float, double) {
  SensorParameters<S> p = constants<S>();
  p.sliding_friction = S(0);
  p.normal_damping = S(0);
  SensorMemory<S> memory;
  const Ray<S> ray{Vec3<S>(S(0.1), 0, 0), Vec3<S>(0, 0, -1), S(0.01)};
  test::BodyMotion<S> A, B;
  const Vec3<S> m(0, 0, 1);
  Wrench<S> w = sensor_wrench(p, LawOptions{}, ray, S(0.005), m, A.pose, A.twist, B.pose, B.twist,
                              S(1e-3), memory);
  CHECK(memory.is_anchored);
  // Pushed back along the ray by K_N / 2 = 1 N at (0.1, 0, -0.005).
  CHECK(w.force.isApprox(Vec3<S>(0, 0, 1), law_round_off<S>));
  CHECK(w.torque.isApprox(Vec3<S>(0, S(-0.1), 0), law_round_off<S>));
  A.pose.translation.y() = S(5e-4);
  w = sensor_wrench(p, LawOptions{}, ray, S(0.005), m, A.pose, A.twist, B.pose, B.twist, S(1e-3),
                    memory);
  CHECK(w.force.isApprox(Vec3<S>(0, S(-1.5), 1), S(1e3) * law_round_off<S>));
  CHECK(w.torque.isApprox(
      Vec3<S>(0, S(0.1), 0).cross(Vec3<S>::Zero()) + Vec3<S>(S(0.1), 0, S(-0.005)).cross(w.force),
      S(1e2) * law_round_off<S>));
}

TEST_CASE("sensor_wrench: does not depend on where the world's origin is") {
  test::Random random(4);
  for (int i = 0; i < 50; ++i) {
    const Ray<double> ray{random.in_cube(0.05), random.direction<double>(), 0.02};
    test::BodyMotion<double> A, B;
    A.pose = random.pose(0.1);
    B.pose = random.pose(0.1);
    A.twist = {random.in_cube(0.1), random.in_cube(1.0)};
    B.twist = {random.in_cube(0.1), random.in_cube(1.0)};
    const Vec3<double> m = -A.pose.rotate(ray.direction);
    const Vec3<double> shift = random.in_cube(8.0);
    SensorMemory<double> here, there;
    for (int step = 0; step < 2; ++step) {
      const auto w = sensor_wrench(constants<double>(), LawOptions{}, ray, 0.01, m, A.pose, A.twist,
                                   B.pose, B.twist, 1e-3, here);
      test::BodyMotion<double> A2 = A, B2 = B;
      A2.pose.translation += shift;
      B2.pose.translation += shift;
      const auto w2 = sensor_wrench(constants<double>(), LawOptions{}, ray, 0.01, m, A2.pose,
                                    A2.twist, B2.pose, B2.twist, 1e-3, there);
      CHECK((w.force - w2.force).norm() < 1e-10);
      CHECK((w.torque - w2.torque).norm() < 1e-11);
      A.pose.translation += 1e-3 * A.twist.linear;
    }
  }
}
