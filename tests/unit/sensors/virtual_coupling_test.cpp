// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/sensors/virtual_coupling.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

using namespace bristle;

namespace {

/// Sensors on a wall that fills x < 0, as a haptic loop gives them: for a tool that keeps its
/// velocity over the substep.
template <typename S>
struct CouplingWall {
  S stiffness = S(500);
  S damping = S(0);

  [[nodiscard]] Wrench<S> on(const VirtualCoupling<S>& tool, S h) const {
    const S depth = -tool.pose().translation.x();
    const S speed = -tool.twist().linear.x();
    Wrench<S> wrench;
    if (depth > S(0)) {
      wrench.force.x() = stiffness * depth + (h * stiffness + damping) * speed;
    }
    return wrench;
  }
};

template <typename S>
Transform<S> device_at(S x) {
  return {Quat<S>::Identity(), {x, 0, 0}};
}

}  // namespace

TEST_CASE_TEMPLATE("VirtualCoupling: a hand feels wall and spring in series", S, double, float) {
  for (const S h : {S(1e-3), S(5e-3)}) {
    for (const S stiffness : {S(100), S(1000), S(1e5)}) {
      CAPTURE(h);
      CAPTURE(stiffness);
      const CouplingWall<S> wall;
      CouplingDef<S> def{.stiffness = stiffness, .damping = S(2)};
      def.mass = std::max(S(0.02), S(1.5) * least_coupled_mass(def, wall.stiffness, S(0), h));
      VirtualCoupling<S> coupling(def, device_at(S(0)));
      for (int i = 0; i < 4000; ++i) {
        coupling.step(device_at(S(-0.01)), {}, wall.on(coupling, h), h);
      }
      const S expected = S(0.01) / (S(1) / stiffness + S(1) / wall.stiffness);
      const double precise = sizeof(S) == 4 ? 1e-4 : 1e-9;
      CHECK(coupling.wrench().force.x() == test::relative(expected).epsilon(precise));
      CHECK(coupling.pose().translation.x() ==
            test::relative(-expected / wall.stiffness).epsilon(precise));
      CHECK(coupling.wrench().torque.isZero(0));
    }
  }
}

TEST_CASE("VirtualCoupling: in the air a hand feels the tool's mass, and nothing at one speed") {
  const CouplingDef<double> def;
  const double h = 1e-3;
  VirtualCoupling<double> coupling(def, device_at(0.0));
  const Vec3<double> speed(0.2, -0.1, 0.3);
  Vec3<double> place(0, 0, 0);
  Vec3<double> momentum = Vec3<double>::Zero();
  for (int i = 0; i < 3000; ++i) {
    const Wrench<double> on_device =
        coupling.step({Quat<double>::Identity(), place}, {speed, Vec3<double>::Zero()}, {}, h);
    momentum -= h * on_device.force;
    place += h * speed;
  }
  CHECK((coupling.pose().translation - place).norm() < 1e-12);
  CHECK((coupling.twist().linear - speed).norm() < 1e-12);
  CHECK(coupling.wrench().force.norm() < 1e-9);
  // What the hand gave is what the tool has.
  CHECK((momentum - def.mass * speed).norm() < 1e-12);

  // Steady acceleration a takes m a.
  const double a = 3;
  double x = place.x();
  double v = speed.x();
  for (int i = 0; i < 3000; ++i) {
    // Positions as the velocity of each substep takes them.
    v += h * a;
    coupling.step({Quat<double>::Identity(), {x, place.y(), place.z()}}, {{v, 0, 0}, {0, 0, 0}}, {},
                  h);
    x += h * v;
  }
  CHECK(coupling.wrench().force.x() == test::relative(-def.mass * a).epsilon(1e-9));
}

TEST_CASE("VirtualCoupling: turns are those of a torsion spring, about the right axis") {
  CouplingDef<double> def;
  def.angular_stiffness = 2;
  const Vec3<double> axis = Vec3<double>(1, 2, -2) / 3;
  const Transform<double> device{exp_rotation<double>(0.3 * axis), {0, 0, 0}};
  VirtualCoupling<double> coupling(def, {});
  Wrench<double> held;
  held.torque = 0.25 * Vec3<double>(2, 1, 2) / 3;
  for (int i = 0; i < 4000; ++i) coupling.step(device, {}, held, 1e-3);
  // At rest the spring carries the torque: 0.125 rad from the device, and the device feels it.
  const Vec3<double> behind =
      log_rotation<double>(coupling.pose().rotation * device.rotation.conjugate());
  CHECK((behind - held.torque / 2).norm() < 1e-9);
  CHECK((coupling.wrench().torque - held.torque).norm() < 1e-9);
  CHECK(coupling.wrench().force.isZero(0));
}

TEST_CASE("VirtualCoupling: no more than the largest force and torque, in their directions") {
  CouplingDef<double> def{.max_force = 3, .max_torque = 0.1};
  VirtualCoupling<double> coupling(def, {});
  const Vec3<double> far(3, -4, 0);
  const Vec3<double> axis(0, 0.6, 0.8);
  const Wrench<double> on_device =
      coupling.step({exp_rotation<double>(2.0 * axis), far}, {}, {}, 1e-3);
  CHECK((on_device.force + 3 * far / 5).norm() < 1e-12);
  CHECK((on_device.torque + 0.1 * axis).norm() < 1e-12);
  // The tool gets the same impulses.
  CHECK((coupling.twist().linear - 1e-3 / def.mass * 3 * far / 5).norm() < 1e-12);
  CHECK((coupling.twist().angular - 1e-3 / def.inertia * 0.1 * axis).norm() < 1e-12);
}

TEST_CASE("least_coupled_mass: just above it a tool comes to rest, just below it does not") {
  const double h = 1e-3;
  for (const CouplingWall<double> wall :
       {CouplingWall<double>{2e4, 0}, CouplingWall<double>{2e4, 30},
        CouplingWall<double>{10, 100}}) {
    for (const double share : {0.0, 0.5}) {
      CAPTURE(wall.damping);
      CAPTURE(share);
      // The coupling does a part of it, by its damper or its spring.
      const double needed = h * (3 * h * wall.stiffness + 2 * wall.damping) / 4;
      CouplingDef<double> def{.stiffness = 1e-6, .damping = 2 * share * needed / h};
      if (wall.damping == 0) {
        def.stiffness = 1e-6 + 4 * share * needed / (h * h);
        def.damping = 0;
      }
      const double least = least_coupled_mass(def, wall.stiffness, wall.damping, h);
      CHECK(least == test::relative((1 - share) * needed).epsilon(1e-6));
      for (const double factor : {0.99, 1.01}) {
        CAPTURE(factor);
        def.mass = factor * needed - share * needed;
        VirtualCoupling<double> coupling(def, device_at(-1.0));
        // A push, deep in the wall so that it never leaves it.
        Wrench<double> push;
        const auto swing = [&](int substeps) {
          double most = 0;
          for (int i = 0; i < substeps; ++i) {
            Wrench<double> on_tool = wall.on(coupling, h);
            // The force of the depth it started at is taken away.
            on_tool.force.x() -= wall.stiffness;
            on_tool.force += push.force;
            coupling.step(device_at(-1.0), {}, on_tool, h);
            push = {};
            most = std::max(most, std::abs(coupling.twist().linear.x()));
          }
          return most;
        };
        push.force.x() = 1e-6;
        (void)swing(200);
        const double before = swing(100);
        (void)swing(300);
        const double after = swing(100);
        CHECK((after > before) == (factor < 1));
      }
    }
  }
}

TEST_CASE(
    "least_coupled_mass: a tool that sensors move and turn at once needs q / m + q r^2 / I < 1") {
  const double h = 1e-3;
  const double K = 2e4;
  const double r = 0.05;
  CouplingDef<double> def{.stiffness = 1e-9, .damping = 0, .angular_stiffness = 1e-9};
  def.angular_damping = 0;
  const double q = least_coupled_mass(def, K, 0.0, h);
  // The mass has a share of the bound, the inertia what is left.
  for (const double share : {0.3, 0.5, 0.8}) {
    for (const double factor : {0.99, 1.01}) {
      CAPTURE(share);
      CAPTURE(factor);
      def.mass = factor * q / share;
      def.inertia = factor * q * r * r / (1 - share);
      VirtualCoupling<double> coupling(def, {});
      double push = 1e-9;
      const auto swing = [&](int substeps) {
        double most = 0;
        for (int i = 0; i < substeps; ++i) {
          // One spring along z, at r in x.
          const double turn = log_rotation<double>(coupling.pose().rotation).y();
          const double z = coupling.pose().translation.z() - r * turn;
          const double v = coupling.twist().linear.z() - r * coupling.twist().angular.y();
          Wrench<double> on_tool;
          on_tool.force.z() = push - K * z - h * K * v;
          on_tool.torque.y() = -r * on_tool.force.z();
          push = 0;
          coupling.step({}, {}, on_tool, h);
          most = std::max(most, std::abs(v));
        }
        return most;
      };
      (void)swing(200);
      const double before = swing(100);
      (void)swing(300);
      CHECK((swing(100) > before) == (factor < 1));
    }
  }
}

// Of backward Euler: m (v1 - v0) v1 >= the change of m v^2 / 2, and K d1 (d1 - d0) >= that of
// K d^2 / 2, with d1 the stretch at the end of the substep.
TEST_CASE("VirtualCoupling: gives no energy to a device whose motion it knows, nor to the wall") {
  test::Random random(7);
  for (const double damping : {0.0, 5.0}) {
    CAPTURE(damping);
    const CouplingDef<double> def{.stiffness = 3000, .damping = damping, .mass = 0.03};
    const double h = 1e-3;
    VirtualCoupling<double> coupling(def, {});
    Transform<double> device;
    const Vec3<double> axis = Vec3<double>(2, -1, 2) / 3;
    double brought = 0;
    double lost = 0;
    double least_loss = 0;
    for (int i = 0; i < 5000; ++i) {
      // Any way along, and turns about one axis.
      const Twist<double> speed{random.in_cube(1.0), random.uniform(-20.0, 20.0) * axis};
      const Wrench<double> on_tool{random.in_cube(30.0), random.uniform(-0.2, 0.2) * axis};
      const Wrench<double> on_device = coupling.step(device, speed, on_tool, h);
      device.translation += h * speed.linear;
      device.rotation = step_rotation<double>(device.rotation, speed.angular, h);
      const Twist<double>& tool = coupling.twist();
      brought += h * (on_tool.force.dot(tool.linear) - on_device.force.dot(speed.linear) +
                      on_tool.torque.dot(tool.angular) - on_device.torque.dot(speed.angular));
      const Vec3<double> stretch = device.translation - coupling.pose().translation;
      const Vec3<double> turn =
          log_rotation<double>(device.rotation * coupling.pose().rotation.conjugate());
      const double stored =
          0.5 *
          (def.mass * tool.linear.squaredNorm() + def.stiffness * stretch.squaredNorm() +
           def.inertia * tool.angular.squaredNorm() + def.angular_stiffness * turn.squaredNorm());
      least_loss = std::min(least_loss, brought - stored - lost);
      lost = brought - stored;
    }
    // Substep by substep, up to the round-off of sums of some joules.
    CHECK(least_loss > -1e-12);
    CHECK(lost > 0);
  }
}

TEST_CASE("VirtualCoupling: bad input is refused by name, and changes nothing") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto field_of_def = [](const CouplingDef<double>& def) {
    try {
      (void)VirtualCoupling<double>(def, {});
    } catch (const InvalidArgument& error) {
      return error.field();
    }
    return std::string();
  };
  CHECK(field_of_def({.stiffness = 0}) == "CouplingDef::stiffness");
  CHECK(field_of_def({.damping = -1}) == "CouplingDef::damping");
  CHECK(field_of_def({.angular_stiffness = nan}) == "CouplingDef::angular_stiffness");
  CHECK(field_of_def({.angular_damping = nan}) == "CouplingDef::angular_damping");
  CHECK(field_of_def({.mass = 0}) == "CouplingDef::mass");
  CHECK(field_of_def({.inertia = -1}) == "CouplingDef::inertia");
  CHECK(field_of_def({.max_force = 0}) == "CouplingDef::max_force");
  CHECK(field_of_def({.max_torque = nan}) == "CouplingDef::max_torque");
  CHECK_THROWS_AS(VirtualCoupling<double>({}, device_at(nan)), InvalidArgument);

  VirtualCoupling<double> coupling({}, {});
  coupling.step(device_at(0.01), {}, {}, 1e-3);
  const VirtualCoupling<double> before = coupling;
  Wrench<double> wrong;
  wrong.torque.y() = nan;
  CHECK_THROWS_AS(coupling.step(device_at(nan), {}, {}, 1e-3), InvalidArgument);
  CHECK_THROWS_AS(coupling.step({}, {{0, nan, 0}, {0, 0, 0}}, {}, 1e-3), InvalidArgument);
  CHECK_THROWS_AS(coupling.step({}, {}, wrong, 1e-3), InvalidArgument);
  CHECK_THROWS_AS(coupling.step({}, {}, {}, 0.0), InvalidArgument);
  CHECK_THROWS_AS(coupling.step({Quat<double>(2, 0, 0, 0), {0, 0, 0}}, {}, {}, 1e-3),
                  InvalidArgument);
  CHECK(coupling.pose().translation == before.pose().translation);
  CHECK(coupling.pose().rotation.coeffs() == before.pose().rotation.coeffs());
  CHECK(coupling.twist().linear == before.twist().linear);
  CHECK(coupling.twist().angular == before.twist().angular);
  CHECK(coupling.wrench().force == before.wrench().force);
  CHECK_THROWS_AS((void)least_coupled_mass<double>({}, nan, 0, 1e-3), InvalidArgument);
  CHECK_THROWS_AS((void)least_coupled_mass<double>({}, 1, -1, 1e-3), InvalidArgument);
  CHECK_THROWS_AS((void)least_coupled_mass<double>({}, 1, 0, 0), InvalidArgument);
}
