// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/sensors/linear_model.hpp>

#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// [1] Of a handful of operations on numbers of one sign.
template <typename S>
constexpr S model_round_off = Tolerance<S>::round_off();

/// A contact with a flat face at the given depth, in A's axes.
template <typename S>
PatchContact<S> sensed_contact(test::Random& random, S depth) {
  PatchContact<S> c;
  c.n = random.direction<S>();
  c.g = depth_gradient<S>(c.n, -c.n);
  c.depth = depth;
  c.inverse_length = S(1) / random.uniform(S(0.005), S(0.02));
  c.is_in_contact = depth > S(0);
  return c;
}

}  // namespace

TEST_CASE_TEMPLATE("linearise_normal: implicit Euler on the depth", S, float, double) {
  test::Random random(1);
  for (int i = 0; i < 50; ++i) {
    const SensorParameters<S> p{random.uniform(S(0.5), S(2)), random.uniform(S(0.01), S(0.1)),
                                S(3000), S(0.4), S(1e-3)};
    const S dt = random.uniform(S(1e-4), S(1e-2));
    const S start = random.uniform(S(-0.2), S(1));
    PatchContact<S> c = sensed_contact<S>(random, start);
    linearise_normal<S>(p, c, dt);
    // Fast enough to be pressed in when the step ends, however far the surface is.
    const S rate = random.uniform(S(0.3), S(0.5)) / dt;
    const S end = start + dt * rate;
    const S found = c.normal_constant + c.a_normal * (rate / c.inverse_length);
    // A sensor that does not touch yet is pressed in from 0, at the mean rate end / dt.
    const S expected = dt * normal_force(p, end, start > S(0) ? rate : end / dt);
    CHECK(std::abs(found - expected) <= model_round_off<S> * (expected + dt * p.normal_stiffness));
  }
}

TEST_CASE_TEMPLATE("linearise_stuck: implicit Euler where bristles are stiff", S, float, double) {
  test::Random random(2);
  PatchPair<S> pair;
  pair.alpha = S(1);
  pair.beta = S(0);
  pair.theta = S(1);
  for (int i = 0; i < 50; ++i) {
    const SensorParameters<S> p{S(1), S(0.05), random.uniform(S(1e3), S(1e5)),
                                random.uniform(S(0.1), S(1)), S(1e-3)};
    const S dt = random.uniform(S(1e-4), S(1e-2));
    PatchContact<S> c = sensed_contact<S>(random, S(0.5));
    c.force = random.uniform(S(0.1), S(2));
    c.stretch = tangential<S>(S(1e-3) * random.direction<S>(), c.n);
    c.start_velocity = random.in_cube(S(0.3));
    const Vec3<S> constant = linearise_stuck<S>(p, {}, pair, c, dt);
    const Vec3<S> v = tangential<S>(random.in_cube(S(0.3)), c.n);
    const S k_t = p.static_friction * c.force;
    const Vec3<S> expected = dt * k_t * (c.stretch + dt * v) + dt * p.sliding_friction * v;
    CHECK((constant + c.a_across * v - expected).norm() <=
          S(4) * model_round_off<S> * dt * (k_t * (S(1e-3) + dt) + p.sliding_friction));
    CHECK(c.a_along == c.a_across);
  }
}

TEST_CASE_TEMPLATE(
    "mean_slip_stretch: the mean over a step that drags a bristle further than sigma", S, float,
    double) {
  test::Random random(3);
  const S sigma = S(1e-3);
  for (int i = 0; i < 50; ++i) {
    const S dt = random.uniform(S(1e-3), S(1e-2));
    const Vec3<S> along = random.direction<S>();
    const S start = random.uniform(S(0), sigma);
    const S passed = random.uniform(S(1.01), S(5)) * sigma;
    PatchContact<S> c;
    c.stretch = start * along;
    const Vec3<S> found =
        mean_slip_stretch<S>({}, c, (passed / dt) * along, sigma, SlipReset::drag, dt);
    // The stretch grows from `start` to sigma along the way, then stays there.
    const S expected = (sigma * sigma - start * start) / (S(2) * passed) +
                       sigma * (S(1) - (sigma - start) / passed);
    CHECK((found - expected * along).norm() <= S(8) * model_round_off<S> * sigma);
  }
}

TEST_CASE_TEMPLATE("update_normal: a contact that begins or ceases to push is told", S, float,
                   double) {
  // The force that it begins or ceases with may be too small to ask for another pass by itself.
  for (const bool was_loaded : {false, true}) {
    for (const bool pushes : {false, true}) {
      PatchContact<S> c;
      c.g = unit_z<Vec3<S>>();
      c.normal_constant = pushes ? S(1e-9) : S(-1e-9);
      c.a_normal = S(0);
      c.force = S(0);
      c.is_loaded = was_loaded;
      PassChange<S> change;
      update_normal<S>(c, true, zero<Vec3<S>>(), S(1e-3), change);
      CHECK(c.is_loaded == pushes);
      CHECK(change.did_switch == (was_loaded != pushes));
    }
  }
}

TEST_CASE_TEMPLATE("update_slip: a bristle that lets go, or turns out to stick, is told", S, float,
                   double) {
  const S sigma = S(1e-3);
  const S dt = S(1e-2);
  for (const SlipReset reset : {SlipReset::drag, SlipReset::release}) {
    for (const bool was_slipping : {false, true}) {
      for (const bool overshoots : {false, true}) {
        PatchContact<S> c;
        c.stretch = zero<Vec3<S>>();
        c.last_slip = zero<Vec3<S>>();
        c.is_in_contact = true;
        c.is_slipping = was_slipping;
        PassChange<S> change;
        const Vec3<S> v = (overshoots ? S(1.1) : S(0.9)) * (sigma / dt) * unit_z<Vec3<S>>();
        update_slip<S>(c, v, sigma, reset, dt, 0, false, change);
        // A released bristle stays released for the step.
        const bool slips = overshoots || (reset == SlipReset::release && was_slipping);
        CHECK(c.is_slipping == slips);
        CHECK(change.did_switch == (was_slipping != slips));
      }
    }
  }
}
