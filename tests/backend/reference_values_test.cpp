/// @file
/// The reference values that depend on geometry, on every backend: rays on a plane and on boxes,
/// hard contact. Closed forms as in physics/, where the other values are.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/grasp.hpp"
#include "scenes/plate.hpp"
#include "scenes/stack.hpp"
#include "support/backends.hpp"
#include "support/integrations.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <type_traits>

using namespace bristle;
using bristle::test::both_integrations;
using namespace bristle::scenes;

namespace {

/// A tolerance in double, or what float resolves of lengths of 0.1 m where that is coarser.
template <typename S>
constexpr double tolerance(double in_double, double in_float) {
  return std::is_same_v<S, double> ? in_double : in_float;
}

}  // namespace

TEST_CASE_TEMPLATE("reference_values: depth and height at rest (R1)", T, BRISTLE_TEST_SETUPS) {
  using S = typename T::Scalar;
  const double depth = 0.5 * 9.81 / 16;
  for (const InclineBy way : {InclineBy::gravity, InclineBy::surface}) {
    PlateDef<S> def;
    def.drop = S(0.001);
    def.incline_by = way;
    auto scene = make_plate<S, typename T::Backend>(def);
    scene.run(S(3));
    for (const S e : scene.world.reading(scene.patch).depth) {
      CHECK(std::abs(static_cast<double>(e) - depth) < tolerance<S>(1e-9, 2e-5));
    }
    CHECK(std::abs(static_cast<double>(scene.position().z()) - 0.01 * (1 - depth)) <
          tolerance<S>(1e-11, 2e-7));
  }
}

TEST_CASE_TEMPLATE("reference_values: shift on an incline of 30 degrees (R4)", T,
                   BRISTLE_TEST_SETUPS) {
  using S = typename T::Scalar;
  for (const InclineBy way : {InclineBy::gravity, InclineBy::surface}) {
    for (const Integration integration : both_integrations) {
      PlateDef<S> def;
      def.incline = std::numbers::pi_v<S> / S(6);
      def.incline_by = way;
      def.integration = integration;
      def.parameters.sliding_friction = S(2);
      auto scene = make_plate<S, typename T::Backend>(def);
      scene.run(S(3));
      CHECK(static_cast<double>(scene.position().x()) ==
            test::relative(0.143020e-3).epsilon(tolerance<S>(1e-4, 2e-3)));
      const Vec3<S> settled = scene.position();
      scene.run(S(2));
      CHECK(static_cast<double>((scene.position() - settled).norm()) < tolerance<S>(1e-9, 1e-7));
    }
  }
}

TEST_CASE_TEMPLATE("reference_values: torsion (R11)", T, BRISTLE_TEST_SETUPS) {
  using S = typename T::Scalar;
  PlateDef<S> def;
  def.parameters.sliding_friction = S(5);
  auto scene = make_plate<S, typename T::Backend>(def);
  scene.world.step();
  for (int i = 0; i < 2000; ++i) {
    scene.world.apply_wrench(scene.plate, {Vec3<S>::Zero(), {S(0), S(0), S(0.2)}});
    scene.world.step();
  }
  // tau / (mu_S (N / n) sum r^2), sum r^2 = 0.1 m^2 on the 4 x 4 grid.
  const double yaw = 0.2 / (5000 * 0.5 * 9.81 / 16 * 0.1);
  CHECK(static_cast<double>(log_rotation<S>(scene.world.pose(scene.plate).rotation).z()) ==
        test::relative(yaw).epsilon(tolerance<S>(1e-4, 1e-3)));
}

TEST_CASE_TEMPLATE("reference_values: sag of a grasped box (R12)", T, BRISTLE_TEST_SETUPS) {
  using S = typename T::Scalar;
  for (const S finger_mass : {S(0), S(0.5)}) {
    for (const S dt : {S(1e-3), S(1) / S(60)}) {
      GraspDef<S> def;
      def.finger_mass = finger_mass;
      def.time_step = dt;
      auto scene = make_grasp<S, typename T::Backend>(def);
      scene.run(S(4));
      CHECK(static_cast<double>(scene.sag()) ==
            test::relative(245.25e-6).epsilon(tolerance<S>(1e-5, 1e-3)));
    }
  }
}

TEST_CASE_TEMPLATE(
    "reference_values: sensors beside hard contact on an incline of 25 degrees (R16)", T,
    BRISTLE_TEST_SETUPS) {
  using S = typename T::Scalar;
  for (const S dt : {S(1e-3), S(1) / S(60)}) {
    PlateDef<S> def;
    def.per_side = 2;
    def.incline = S(25) * std::numbers::pi_v<S> / S(180);
    def.has_contact = true;
    def.time_step = dt;
    def.parameters.sliding_friction = S(10);
    auto scene = make_plate<S, typename T::Backend>(def);
    scene.run(S(3));
    CHECK(static_cast<double>(scene.position().x()) ==
          test::relative(0.20729e-3).epsilon(tolerance<S>(1e-3, 3e-3)));
  }
}

TEST_CASE_TEMPLATE("reference_values: 1000 kg on 100 g (R19)", T, BRISTLE_TEST_SETUPS) {
  using S = typename T::Scalar;
  StackDef<S> def;
  def.by = StackBy::sensors;
  def.masses = {S(0.1), S(1000)};
  auto scene = make_stack<S, typename T::Backend>(def);
  scene.run(S(3));
  // In float the 1 N of the lower cube is a difference of 9810 N: 1e-3 of its 3 mm of depth.
  for (std::size_t k = 0; k < 2; ++k) {
    const S z = scene.world.pose(scene.cubes[k]).translation.z();
    CHECK(std::abs(static_cast<double>(z - scene.rest_heights[k])) < tolerance<S>(1e-6, 1e-5));
  }
}
