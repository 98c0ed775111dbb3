/// @file
/// The two integrators in closed form: free fall, landing, bouncing, stopping, and a gap that
/// closes.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/numbers.hpp"
#include "support/relative.hpp"

#include <bristle/math/rotation.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

using namespace bristle;
using bristle::test::g;

namespace {

constexpr double radius = 0.1;

/// One body above a half-space.
struct Fall {
  World<double> world;
  BodyId body{};

  [[nodiscard]] const Body<double>& state() const { return world.body(body); }
  [[nodiscard]] double height() const { return state().center_pose.translation.z(); }
};

Fall make_fall(const Shape<double>& shape, const Vec3<double>& position, double dt,
               double restitution = 0, Integrator integrator = Integrator::trapezoidal,
               const Quat<double>& orientation = Quat<double>::Identity(),
               const Vec3<double>& velocity = Vec3<double>::Zero()) {
  WorldDef<double> world_def;
  world_def.time_step = dt;
  world_def.gravity = {0, 0, -g};
  world_def.integrator = integrator;
  Fall fall{World<double>(world_def), {}};
  BodyDef<double> ground;
  ground.motion = Motion::fixed;
  ground.shape = HalfSpace<double>{};
  fall.world.add_body(ground);
  BodyDef<double> def;
  def.mass = 0.5;
  def.shape = shape;
  def.material.restitution = restitution;
  def.position = position;
  def.orientation = orientation;
  def.velocity = velocity;
  fall.body = fall.world.add_body(def);
  return fall;
}

constexpr double rates[] = {60, 100, 240, 500, 1000};
constexpr double heights[] = {0.003, 0.05, 0.37, 1, 1.7, 3.31};

/// [m] Position error that `SolverDef::position_tolerance` leaves where several points share a
/// load: 1e-6 of the distance by which gravity moves a body in a step.
double left_alone(double rate) { return 1e-6 * g / (rate * rate); }

/// [m] Lowest corner of a box of these half sizes.
double lowest_corner(const Transform<double>& X, const Vec3<double>& half) {
  return X.translation.z() - half.dot(X.rotation_matrix().row(2).transpose().cwiseAbs());
}

}  // namespace

TEST_CASE("integrator: the trapezoidal rule falls along the exact parabola") {
  for (const double rate : rates) {
    const double dt = 1 / rate;
    Fall fall = make_fall(Sphere<double>{radius}, {0, 0, 20}, dt, 0, Integrator::trapezoidal,
                          Quat<double>::Identity(), {1, 2, 3});
    for (int n = 1; n <= static_cast<int>(rate); ++n) {
      fall.world.step();
      const double t = n * dt;
      const Vec3<double> expected(t, 2 * t, 20 + 3 * t - g * t * t / 2);
      // Each step rounds a height of 20 m and a speed of 10 m/s a few times, at worst one way.
      const double bound = 4 * n * 20 * std::numeric_limits<double>::epsilon();
      REQUIRE((fall.state().center_pose.translation - expected).norm() <= bound);
    }
  }
}

TEST_CASE("integrator: symplectic Euler is g dt t / 2 below it") {
  for (const double rate : rates) {
    const double dt = 1 / rate;
    Fall fall = make_fall(Sphere<double>{radius}, {0, 0, 20}, dt, 0, Integrator::symplectic_euler);
    for (int n = 1; n <= static_cast<int>(rate); ++n) {
      fall.world.step();
      const double t = n * dt;
      const double expected = 20 - g * t * t / 2 - g * dt * t / 2;
      const double bound = 4 * n * 20 * std::numeric_limits<double>::epsilon();
      REQUIRE(std::abs(fall.height() - expected) <= bound);
    }
  }
}

TEST_CASE("integrator: a ball lands without overlap and lies exactly on the plane") {
  for (const double rate : rates) {
    for (const double height : heights) {
      CAPTURE(rate);
      CAPTURE(height);
      Fall fall = make_fall(Sphere<double>{radius}, {0.3, 0.2, radius + height}, 1 / rate);
      const int landing = static_cast<int>(std::ceil(std::sqrt(2 * height / g) * rate));
      double deepest = 0;
      for (int n = 1; n <= landing + 100; ++n) {
        fall.world.step();
        deepest = std::max(deepest, radius - fall.height());
        if (n < landing + 2) continue;
        // Two steps after it arrived nothing is left: neither height nor speed.
        CHECK(std::abs(fall.height() - radius) < 1e-12);
        CHECK(fall.state().twist.linear.norm() < 1e-12);
      }
      // The round-off of heights of up to 3 m.
      CHECK(deepest < 1e-14);
    }
  }
}

TEST_CASE("integrator: the peaks of a bouncing ball are e^2k of its height") {
  for (const double rate : rates) {
    for (const double e : {0.5, 0.8, 1.0}) {
      for (const double height : {0.37, 1.0, 1.7}) {
        CAPTURE(rate);
        CAPTURE(e);
        CAPTURE(height);
        Fall fall = make_fall(Sphere<double>{radius}, {0, 0, radius + height}, 1 / rate, e);
        double last_speed = 0;
        int k = 0;
        double deepest = 0;
        for (int n = 0; n < 20 * static_cast<int>(rate) && k < 5; ++n) {
          fall.world.step();
          const double v = fall.state().twist.linear.z();
          const double h = fall.height() - radius;
          deepest = std::max(deepest, -h);
          if (last_speed > 0 && v <= 0) {
            ++k;
            const double peak = height * std::pow(e, 2 * k);
            CHECK(h + v * v / (2 * g) == test::relative(peak).epsilon(1e-12));
          }
          last_speed = v;
        }
        // A bounce that is over within a step is none: flights of two steps and more must be there.
        int expected = 0;
        while (expected < 5 && std::sqrt(2 * height / g) * std::pow(e, expected + 1) * rate > 1) {
          ++expected;
        }
        CHECK(k >= expected);
        CHECK(deepest < 1e-14);
      }
    }
  }
}

TEST_CASE("integrator: a box lands flat, on an edge or on a corner without overlap") {
  const Vec3<double> half(0.1, 0.08, 0.05);
  const std::vector<Vec3<double>> tilts{{0, 0, 0}, {0, 0.3, 0}, {0.5, 0, 0}, {0.4, 0.5, 0}};
  for (const double rate : rates) {
    for (const Vec3<double>& tilt : tilts) {
      for (const double drop : {0.01, 0.2, 1.0}) {
        CAPTURE(rate);
        CAPTURE(drop);
        CAPTURE(tilt.x());
        CAPTURE(tilt.y());
        const Quat<double> q = exp_rotation<double>(tilt);
        const double reach = -lowest_corner({q, Vec3<double>::Zero()}, half);
        Fall fall = make_fall(Box<double>{half}, {0, 0, reach + drop}, 1 / rate, 0,
                              Integrator::trapezoidal, q);
        double deepest = 0;
        for (int n = 0; n < 2 * static_cast<int>(rate); ++n) {
          fall.world.step();
          deepest = std::max(deepest, -lowest_corner(fall.world.pose(fall.body), half));
        }
        if (tilt.isZero(0)) {
          CHECK(deepest < left_alone(rate));
          CHECK(std::abs(fall.height() - half.z()) < left_alone(rate));
        } else {
          // A corner that turns moves along an arc. Contacts are linear in the step, so it may sink
          // by what the arc leaves the tangent: w^2 l / 2 dt^2, and w < 2 sqrt(3 g H) / l.
          const double l = half.norm();
          const double w = 2 * std::sqrt(3 * g * (drop + l)) / l;
          CHECK(deepest < w * w * l / (2 * rate * rate));
        }
        CHECK(fall.state().twist.linear.norm() < 1e-6);
      }
    }
  }
}

TEST_CASE("integrator: a box that stops within a step errs by mu g dt^2 / 8") {
  // In its last step it would stop after the time s, having gone v s / 2 with v = mu g s; the mean
  // of the velocities makes it v dt / 2. The difference, mu g s (dt - s) / 2, is at most that.
  const double mu = 0.5;  // The default material on both sides.
  for (const double rate : rates) {
    for (int phase = 0; phase < 10; ++phase) {
      CAPTURE(rate);
      CAPTURE(phase);
      const double speed = 1 + 0.1 * phase * mu * g / rate;
      Fall fall = make_fall(Box<double>{{0.1, 0.1, 0.02}}, {0, 0, 0.02}, 1 / rate, 0,
                            Integrator::trapezoidal, Quat<double>::Identity(), {speed, 0, 0});
      for (int n = 0; n < static_cast<int>(rate); ++n) fall.world.step();
      const double x = fall.state().center_pose.translation.x();
      const double error = x - speed * speed / (2 * mu * g);
      CHECK(error > -1e-9);
      CHECK(error < mu * g / (8 * rate * rate) + 1e-9);
      CHECK(fall.state().twist.linear.norm() < 1e-9);
    }
  }
}

TEST_CASE("integrator: a box let go 0.1 mm above the ground comes to touch it") {
  constexpr double gap = 1e-4;
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    for (const double rate : rates) {
      CAPTURE(rate);
      Fall fall =
          make_fall(Box<double>{{0.1, 0.1, 0.02}}, {0, 0, 0.02 + gap}, 1 / rate, 0, integrator);
      // The fall takes 4.5 ms; two more steps to arrive and stand.
      const int steps = static_cast<int>(std::ceil(std::sqrt(2 * gap / g) * rate)) + 2;
      for (int n = 0; n < steps; ++n) fall.world.step();
      CHECK(std::abs(fall.height() - 0.02) < left_alone(rate));
      for (int n = 0; n < 100; ++n) fall.world.step();
      CHECK(std::abs(fall.height() - 0.02) < left_alone(rate));
      CHECK(fall.state().twist.linear.norm() < 1e-9);
    }
  }
}
