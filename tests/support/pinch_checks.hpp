/// @file
/// Requirements on a pinch in every engine.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <scenes/pinch.hpp>

namespace bristle::scenes {

/// How exact an engine is by its own arithmetic.
struct PinchBars {
  /// [m/s] Creep that its numbers do not tell from none.
  double creep = 1e-9;
  /// [1] Relative error of a force.
  double force = 1e-9;
};

inline constexpr double pinch_steps[] = {5e-4, 1e-3, 2e-3, 1.0 / 240, 1.0 / 120, 1.0 / 60};

/// Held for a minute: it sags by m g / (mu_S sum F_N), then stays, and its weight is read.
template <typename EnginePinch>
void check_holds(PinchDef def, const PinchBars& bars, double seconds = 60) {
  for (const double dt : pinch_steps) {
    CAPTURE(def.mass);
    CAPTURE(def.is_geared);
    CAPTURE(dt);
    def.dt = dt / def.substeps;
    EnginePinch pinch(def);
    pinch.run(1);
    const double start = pinch.place().z();
    pinch.gravity = {0, 0, -9.81};
    pinch.run(2);
    const Vec3<double> there = pinch.place();
    pinch.run(seconds);
    CHECK((pinch.place() - there).norm() < bars.creep * seconds);
    CHECK(start - there.z() == test::relative(pinch.expected_sag()).epsilon(1e-3));
    CHECK(pinch.weight() == test::relative(def.mass * 9.81).epsilon(bars.force));
    CHECK(pinch.normal() == test::relative(2 * def.squeeze).epsilon(bars.force));
  }
}

/// Pads on an arm of seven joints that gives way: they hold a part as on slides.
template <typename EnginePinch>
void check_on_arm(const PinchBars& bars = {1e-8, 1e-6}) {
  for (const double dt : {1e-3, 1.0 / 240, 1.0 / 120}) {
    CAPTURE(dt);
    EnginePinch pinch({.dt = dt, .has_arm = true});
    pinch.run(1);
    const double start = pinch.place().z();
    pinch.gravity = {0, 0, -9.81};
    pinch.run(5);
    const Vec3<double> there = pinch.place();
    pinch.run(2);
    CHECK((pinch.place() - there).norm() < 2 * bars.creep);
    CHECK(start - there.z() == test::relative(pinch.expected_sag()).epsilon(0.02));
    CHECK(pinch.weight() == test::relative(pinch.def.mass * 9.81).epsilon(bars.force));
  }
}

/// A little above Coulomb's limit it is held, a little below it is not.
template <typename EnginePinch>
void check_lets_go() {
  for (const double dt : {1e-3, 1.0 / 60}) {
    for (const double factor : {1.01, 0.99}) {
      CAPTURE(dt);
      CAPTURE(factor);
      EnginePinch pinch({.dt = dt});
      const double limit = pinch.def.mass * 9.81 / (2 * pinch.def.friction);
      pinch.run(0.5);
      pinch.gravity = {0, 0, -9.81};
      pinch.run(0.5);
      while (pinch.def.squeeze > factor * limit) {
        pinch.def.squeeze *= 0.99;
        pinch.run(1.0 / 60);
      }
      pinch.def.squeeze = factor * limit;
      const double start = pinch.place().z();
      pinch.run(3);
      CHECK((std::abs(pinch.place().z() - start) < 1e-4) == (factor > 1));
    }
  }
}

/// Shaken across the pads at 1 g and 5 Hz, 60 % of what they can hold: the part swings as a mass on
/// a spring and a damper, and is where it was when that ends.
template <typename EnginePinch>
void check_shaken() {
  using Complex = std::complex<double>;
  const double w = 2 * 3.14159265358979 * 5;
  for (const double dt : pinch_steps) {
    CAPTURE(dt);
    PinchDef def;
    def.dt = dt;
    def.squeeze = def.mass * 9.81 / (2 * def.friction * 0.6);
    EnginePinch pinch(def);
    pinch.run(1);
    const SensorParameters<double> p = pinch.world().patch(pinch.patches[0]).def.parameters;
    const double k = p.static_friction * pinch.normal();
    const double c = p.sliding_friction *
                     static_cast<double>(pinch.reading(0).touching() + pinch.reading(1).touching());
    // docs/sensors.md, section 4: a pad's weights of a step's start and end, from the mean mobility
    // of the part 5 mm beside its centre, which turns too, and of the pad, which slides along x.
    const double arm = 0.005;
    const double mobility =
        (3 + 2 * arm * arm / (1.25e-4 / 3)) / (3 * def.mass) + 1 / (3 * pinch.pad_mass);
    const double x = mobility * dt * (dt * k + c) / 2;
    const double alpha = x / (1 + x), beta = (1 - alpha) * (1 - alpha) / 12;
    const double theta = (1 + alpha) / 2;
    // Amplitudes at the end of a step: before times its place, v its velocity.
    const Complex before = std::exp(Complex(0, -w * dt)), v = (1.0 - before) / dt;
    const Complex spring = before + (alpha + beta) * dt * v - beta * dt * before * v;
    const Complex damper = (1 - theta) * before * v + theta * v;
    // Gravity is the mean over a step of -9.81 sin(w t) m/s^2.
    const double mean = std::sin(w * dt / 2) / (w * dt / 2);
    const Complex stepped =
        -9.81 * mean * std::sqrt(before) / (v * v + (k * spring + c * damper) / def.mass);
    const Complex continuous = -9.81 / (Complex(k - def.mass * w * w, c * w) / def.mass);
    if (dt < 5e-3) CHECK(std::abs(stepped - continuous) < 0.02 * std::abs(continuous));
    const double start = pinch.place().y();
    double error = 0;
    const long steps = std::lround(3 / dt);
    for (long i = 0; i < steps; ++i) {
      const double t = static_cast<double>(i) * dt;
      pinch.gravity.y() = -9.81 * mean * std::sin(w * (t + dt / 2));
      pinch.step();
      const double expected = std::imag(stepped * std::exp(Complex(0, w * (t + dt))));
      if (t > 2) error = std::max(error, std::abs(pinch.place().y() - start - expected));
    }
    CHECK(error < 1e-4 * std::abs(continuous));
    pinch.gravity.setZero();
    pinch.run(3);
    CHECK(std::abs(pinch.place().y() - start) < 1e-9);
  }
}

/// Pads that come from out of reach at 0.2 m/s, at long steps: they catch the part, and at no step
/// is there more energy than at the start: motion, and what is left of the squeeze's way.
template <typename EnginePinch>
void check_caught(const PinchBars& bars) {
  for (const double dt : {1.0 / 240, 1.0 / 60}) {
    CAPTURE(dt);
    EnginePinch pinch({.dt = dt});
    pinch.open(0.02, 0.2);
    const double start = pinch.pad_mass * 0.2 * 0.2;
    const double way = pinch.pad(1).x() - pinch.pad(0).x();
    Vec3<double> last[3] = {pinch.part(), pinch.pad(0), pinch.pad(1)};
    double most = 0;
    for (int i = 0; i < 5 / dt; ++i) {
      pinch.step();
      const Vec3<double> now[3] = {pinch.part(), pinch.pad(0), pinch.pad(1)};
      double energy = pinch.def.squeeze * (now[2].x() - now[1].x() - way);
      for (std::size_t k = 0; k < 3; ++k) {
        const double mass = k == 0 ? pinch.def.mass : pinch.pad_mass;
        energy += mass / 2 * ((now[k] - last[k]) / dt).squaredNorm();
        last[k] = now[k];
      }
      most = std::max(most, energy);
    }
    CHECK(most < start);
    CHECK(pinch.normal() == test::relative(2 * pinch.def.squeeze).epsilon(bars.force));
    CHECK((last[0] - 0.5 * (last[1] + last[2])).norm() < 1e-3);
  }
}

/// In every step of a catch under gravity the part gains what the readings say, and its weight.
template <typename EnginePinch>
void check_momentum(const PinchBars& bars = {}) {
  for (const double dt : {1e-3, 1.0 / 120}) {
    CAPTURE(dt);
    EnginePinch pinch({.dt = dt});
    pinch.open(0.005, 0.2);
    pinch.gravity = {0, 0.5, -9.81};
    const double mass = pinch.def.mass;
    Vec3<double> place = pinch.part();
    Vec3<double> velocity = Vec3<double>::Zero();
    double most = 0, error = 0;
    for (int i = 0; i < 0.3 / dt; ++i) {
      pinch.step();
      // Places follow from the velocity at the end of a step in all of these engines.
      const Vec3<double> now = (pinch.part() - place) / dt;
      const Vec3<double> gained = mass * (now - velocity) / dt - mass * pinch.gravity;
      const Vec3<double> read = -pinch.reading(0).wrench.force - pinch.reading(1).wrench.force;
      most = std::max(most, pinch.reading(0).wrench.force.norm());
      error = std::max(error, (gained - read).norm());
      place = pinch.part();
      velocity = now;
    }
    CHECK(most > pinch.def.squeeze);
    CHECK(error < bars.force * most);
  }
}

/// A body of the mirror that the engine does not know is reported as missing, and what the pads
/// hold stays held.
template <typename EnginePinch>
void check_stranger() {
  EnginePinch pinch({});
  pinch.run(0.5);
  const BodyId stranger = pinch.world().add_body(
      {.motion = Motion::kinematic, .shape = Sphere<double>{0.009}, .position = {0, 0, 0.1}});
  PatchDef<double> patch = pinch_pad(1, pinch.def.spec());
  (void)pinch.world().add_patch(stranger, patch);
  pinch.run(0.1);
  CHECK(pinch.missing() == 1);
  CHECK(pinch.normal() == test::relative(2 * pinch.def.squeeze).epsilon(1e-4));
}

}  // namespace bristle::scenes
