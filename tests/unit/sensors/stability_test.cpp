// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/sensors/stability.hpp>

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// Returns whether symplectic Euler with explicit damping keeps one mode bounded: v += dt (-k x - c
/// v) / m, x += dt v.
bool stays(const Mode<double>& mode, double dt) {
  double x = 1;
  double v = 1;
  for (int i = 0; i < 20000; ++i) {
    v += dt * (-mode.stiffness * x - mode.damping * v) / mode.mass;
    x += dt * v;
    if (std::abs(x) > 1e6) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("Mode: the longest stable step is where the recurrence begins to grow") {
  for (const Mode<double>& mode : {Mode<double>{1, 4, 0}, Mode<double>{2, 5000, 3},
                                   Mode<double>{0.5, 10, 100}, Mode<double>{1, 0, 7}}) {
    const double step = mode.largest_stable_step();
    CHECK(mode.stiffness * step * step + 2 * mode.damping * step ==
          test::relative(4 * mode.mass).epsilon(1e-12));
    CHECK(stays(mode, 0.999 * step));
    CHECK_FALSE(stays(mode, 1.001 * step));
  }
}

TEST_CASE_TEMPLATE("Mode: without stiffness and damping any step will do", S, float, double) {
  CHECK(Mode<S>{S(1), S(0), S(0)}.largest_stable_step() == infinity<S>);
}

TEST_CASE_TEMPLATE("ContactStiffness: infinite where nothing touches, and where nothing moves", S,
                   float, double) {
  ContactStiffness<S> contacts;
  CHECK(contacts.largest_stable_step(Mat6<S>(Mat6<S>::Identity())) == infinity<S>);
  contacts.stiffness = Mat6<S>::Identity() * S(100);
  CHECK(contacts.largest_stable_step(Mat6<S>(Mat6<S>::Zero())) == infinity<S>);
  // dt^2 k / m = 4.
  CHECK(double(contacts.largest_stable_step(Mat6<S>(Mat6<S>::Identity()))) ==
        test::relative(0.2).epsilon(1e-6));
}
