// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/sensors/passivity_observer.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace bristle;

namespace {

Wrench<double> push(double f) { return {{f, 0, 0}, Vec3<double>::Zero()}; }
Twist<double> move(double v) { return {{v, 0, 0}, Vec3<double>::Zero()}; }

/// A wall of stiffness k sampled every dt, and a hand that pushes into it and back: the force of a
/// substep is that of the depth at its start, so it lags, and the wall gives k dt v^2 dt / 2 a
/// substep.
template <typename Feel>
void press_and_release(double k, double dt, int substeps, Feel&& feel) {
  double x = 0;
  for (int i = 0; i < 2 * substeps; ++i) {
    const double v = i < substeps ? 0.1 : -0.1;
    feel(push(-k * x), move(v));
    x += dt * v;
  }
}

}  // namespace

// Pressing by n substeps of v and back gives the sum over substeps of dt k x v: sum_{i<n} i on the
// way in and sum_{i<=n} i on the way out, times k v^2 dt^2: n k v^2 dt^2 comes out in all.
TEST_CASE("passivity observer: a sampled spring gives energy, by the closed form") {
  constexpr double k = 1000, dt = 1e-3, v = 0.1;
  constexpr int n = 50;
  PassivityObserver<double> observer;
  press_and_release(k, dt, n, [&](const auto& f, const auto& u) { observer.observe(f, u, dt); });
  CHECK(observer.energy() == test::relative(-n * k * v * v * dt * dt).epsilon(1e-9));
  CHECK_FALSE(observer.is_passive());
  PassivityObserver<double> lenient(1.01 * n * k * v * v * dt * dt);
  press_and_release(k, dt, n, [&](const auto& f, const auto& u) { lenient.observe(f, u, dt); });
  CHECK(lenient.is_passive());
}

// The same, told of each substep when it is over: but for the one in which the hand turns, its
// velocity is as foreseen.
TEST_CASE("passivity observer: control takes out just that much") {
  constexpr double k = 1000, dt = 1e-3, v = 0.1;
  constexpr int n = 50;
  PassivityObserver<double> observer;
  double damped_ticks = 0;
  Twist<double> was = move(0);
  press_and_release(k, dt, n, [&](const Wrench<double>& f, const Twist<double>& u) {
    const Wrench<double> sent = observer.control(f, was, dt);
    const double added = sent.force.x() - f.force.x();
    if (added != 0) {
      ++damped_ticks;
      CHECK(added * was.linear.x() < 0);  // A damper opposes the motion.
    }
    was = u;
  });
  CHECK(observer.control({}, was, dt).force.isZero(0));
  CHECK(observer.is_passive());
  CHECK(observer.energy() == doctest::Approx(0).epsilon(1e-12));
  CHECK(observer.damped_energy() == test::relative(n * k * v * v * dt * dt).epsilon(1e-9));
  CHECK(damped_ticks > 0);
}

// 1 N is sent along 0.1 m/s that turn out to be -0.1 m/s, and is on credit: 0.1 mJ come out. The
// next substep is to pay it back: alpha = 1e-4 / (1e-3 * 0.01) = 10, so 1 N against the motion, and
// all is even once that is over.
TEST_CASE("passivity observer: what the velocity did not do as foreseen is paid later") {
  PassivityObserver<double> observer(0, 100);
  CHECK(observer.control(push(-1), move(0.1), 1e-3).force.x() == -1);
  CHECK(observer.energy() == 0);  // Nothing has acted yet.
  CHECK(observer.control({}, move(-0.1), 1e-3).force.x() == test::relative(1));
  CHECK(observer.energy() == test::relative(-1e-4));
  CHECK(observer.damped_energy() == 0);
  CHECK_FALSE(observer.is_passive());
  CHECK(observer.control({}, move(-0.1), 1e-3).force.x() == doctest::Approx(0));
  CHECK(observer.energy() == doctest::Approx(0));
  CHECK(observer.damped_energy() == test::relative(1e-4));
}

// 0.02 J came out unseen; a tool at 1 mm/s would need 20 kN to give them back within a substep.
TEST_CASE_TEMPLATE("passivity observer: never asks more of a device than it may", S, float,
                   double) {
  PassivityObserver<S> observer(S(0), S(10));
  const Twist<S> fast{{S(0.1), 0, 0}, Vec3<S>::Zero()};
  const Twist<S> slow{{S(1e-3), 0, 0}, Vec3<S>::Zero()};
  for (int i = 0; i < 100; ++i) observer.observe({{S(2), 0, 0}, Vec3<S>::Zero()}, fast, S(1e-3));
  const S owed = -observer.energy();
  CHECK(owed == test::relative(0.02).epsilon(1e-5));
  CHECK(observer.control({}, slow, S(1e-3)).force.x() == test::relative(-0.01));
  (void)observer.control({}, slow, S(1e-3));
  CHECK(-observer.energy() < owed);  // The rest stays owed, and is paid in time.
  for (int i = 0; i < 1000; ++i) (void)observer.control({}, fast, S(1e-3));
  CHECK(std::abs(observer.energy()) < S(1e-3) * owed);
  // Nothing but rounding is owed now, so nothing is asked of a tool that hardly moves.
  const Twist<S> still{{S(1e-9), 0, 0}, Vec3<S>::Zero()};
  CHECK(observer.control({}, still, S(1e-3)).force.norm() < S(1e-6));
}

TEST_CASE("passivity observer: a damper is passive and left alone") {
  PassivityObserver<double> observer;
  for (int i = 0; i < 100; ++i) {
    const double v = std::sin(0.1 * i);
    const Wrench<double> f = push(-3 * v);
    CHECK(observer.control(f, move(v), 1e-3).force == f.force);
  }
  CHECK(observer.is_passive());
  CHECK(observer.energy() > 0);
  CHECK(observer.damped_energy() == 0);
}

TEST_CASE("passivity observer: counts torques, and damps them with the radius it is given") {
  PassivityObserver<double> observer(0, 100, 0.1);
  const Wrench<double> on_tool{Vec3<double>::Zero(), {0, 0, 2}};
  const Twist<double> tool{Vec3<double>::Zero(), {0, 0, 3}};
  const Wrench<double> sent = observer.control(on_tool, tool, 0.01);
  // 0.06 J would come out; alpha = 0.06 / (0.01 * 0.01 * 9) = 66.7 takes all of it.
  CHECK(sent.torque.z() == doctest::Approx(0).epsilon(1e-12));
  (void)observer.control({}, tool, 0.01);
  CHECK(observer.damped_energy() == test::relative(0.06));
}

TEST_CASE("passivity observer: what is no number does not count") {
  PassivityObserver<double> observer;
  observer.observe(push(std::numeric_limits<double>::quiet_NaN()), move(1), 1e-3);
  observer.observe(push(std::numeric_limits<double>::infinity()), move(1), 1e-3);
  CHECK(observer.energy() == 0);
  const Wrench<double> broken = push(std::numeric_limits<double>::quiet_NaN());
  CHECK(observer.control(broken, move(1), 1e-3).force.isZero(0));
  // Not even where energy is owed: what is sent is finite.
  observer.observe(push(2), move(0.1), 1e-3);
  for (const double speed :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e200}) {
    CHECK(observer.control(push(1), move(speed), 1e-3).force.x() == 1);
  }
  CHECK_THROWS_AS(PassivityObserver<double>(-1), InvalidArgument);
  CHECK_THROWS_AS(PassivityObserver<double>(0, 0), InvalidArgument);
  CHECK_THROWS_AS(PassivityObserver<double>(0, 1, 0), InvalidArgument);
}
