/// @file
/// Fig. 7 (b): a plate at rest on its sensors, level and on an incline.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plate.hpp"
#include "support/integrations.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::both_integrations;
using namespace bristle::scenes;

namespace {

constexpr InclineBy inclines[] = {InclineBy::gravity, InclineBy::surface};

template <typename S>
constexpr S degrees(S angle) {
  return angle * std::numbers::pi_v<S> / S(180);
}

/// Mean stretch of the bristles, weighted with the normal force: |sum F_S| / (mu_S sum F_N), since
/// all sensors stretch the same way.
template <typename Scene>
double mean_stretch(const Scene& scene) {
  const auto reading = scene.world.reading(scene.patch);
  return static_cast<double>(reading.total_shear() /
                             (scene.def.parameters.static_friction * reading.total_normal()));
}

}  // namespace

TEST_CASE_TEMPLATE("incline_hold: at rest every sensor carries its share (R1)", S, float, double) {
  // e_N = m g / (n K_N) = 0.5 * 9.81 / 16 and z = L (1 - e_N), the rays ending 5 mm below.
  const double depth = 0.5 * 9.81 / 16;
  const double height = 0.01 * (1 - depth);
  CHECK(depth == test::relative(0.3065625).epsilon(1e-12));
  // Float: positions of a few mm beside arms of 0.1 m, so a few 1e-8 m, or 1e-5 of the ray.
  const double tolerance = std::is_same_v<S, double> ? 1e-9 : 2e-5;
  for (const Integration integration : both_integrations) {
    PlateDef<S> def;
    def.integration = integration;
    def.drop = S(0.001);
    auto scene = make_plate<S>(def);
    scene.run(S(3));
    const auto reading = scene.world.reading(scene.patch);
    for (std::size_t i = 0; i < reading.size(); ++i) {
      CHECK(std::abs(static_cast<double>(reading.depth[i]) - depth) < tolerance);
    }
    CHECK(std::abs(static_cast<double>(scene.position().z()) - height) < 0.01 * tolerance);
    CHECK(static_cast<double>(reading.total_normal()) ==
          test::relative(0.5 * 9.81).epsilon(tolerance));
  }
}

TEST_CASE(
    "incline_hold: a plate that cannot tilt stretches its bristles by tan(angle) / mu_S (R4)") {
  const double stretch = std::tan(degrees(30.0)) / 5000;
  CHECK(stretch == test::relative(0.115470e-3).epsilon(1e-5));
  for (const InclineBy way : inclines) {
    for (const Integration integration : both_integrations) {
      PlateDef<double> def;
      def.incline = degrees(30.0);
      def.incline_by = way;
      def.integration = integration;
      def.inertia_factor = 1e12;
      // The undamped ring-down decays at n mu_V / (2 m) = 1.6 / s only; damp it critically.
      def.parameters.sliding_friction = 15;
      auto scene = make_plate<double>(def);
      scene.run(10);
      // In 10 s the plate turns by 5e-10 rad.
      CHECK(mean_stretch(scene) == test::relative(stretch).epsilon(1e-6));
    }
  }
}

TEST_CASE("incline_hold: the centre of a plate that tilts sits where statics puts it (R4)") {
  for (const double dt : {1e-3, 4e-3, 1.0 / 60}) {
    for (const InclineBy way : inclines) {
      for (const Integration integration : both_integrations) {
        // Explicit only where it is stable: the limit is 8.7 ms here (R13).
        if (integration == Integration::explicit_ && dt > 5e-3) continue;
        PlateDef<double> def;
        def.incline = degrees(30.0);
        def.incline_by = way;
        def.integration = integration;
        def.time_step = dt;
        auto scene = make_plate<double>(def);
        scene.run(12);
        const Vec3<double> settled = scene.position();
        // The tabled value has the measured digits; the closed form is linear in the tilt, which it
        // leaves out 0.8 % by.
        CHECK(settled.x() == test::relative(0.143020e-3).epsilon(1e-4));
        CHECK(settled.x() == test::relative(plate_rest_shift(def)).epsilon(8e-3));
        // The bristles hold the part of gravity across the tilted rays.
        const Transform<double> X_IP =
            scene.X_WI.inverse() * scene.world.body(scene.plate).center_pose;
        const double tilt = log_rotation<double>(X_IP.rotation).y();
        CHECK(mean_stretch(scene) ==
              test::relative(std::tan(def.incline + tilt) / 5000).epsilon(1e-6));
        scene.run(5);
        CHECK((scene.position() - settled).norm() < 1e-9);
      }
    }
  }
}

TEST_CASE("incline_hold: float holds as double does, within its resolution (R4)") {
  // Stretches of 0.14 mm come from differences of arms of 0.1 m: 1e-8 / 1.4e-4 is below 1e-3.
  for (const Integration integration : both_integrations) {
    PlateDef<float> def;
    def.incline = degrees(30.0F);
    def.integration = integration;
    auto scene = make_plate<float>(def);
    scene.run(10);
    const Vec3<float> settled = scene.position();
    CHECK(static_cast<double>(settled.x()) == test::relative(0.143020e-3).epsilon(1e-3));
    scene.run(5);
    CHECK((scene.position() - settled).norm() < 1e-7F);
  }
}

TEST_CASE("incline_hold: a slow tilt slips where the table says (R7)") {
  // All sensors reach sigma_a at atan(mu_S sigma_a) = 78.69 deg on a plate that cannot tilt; the
  // tilting one loses its uphill sensors a little earlier.
  struct Row {
    int per_side;
    double angle;
  };
  for (const Row row : {Row{10, 78.60}, Row{4, 78.13}}) {
    for (const Integration integration : both_integrations) {
      PlateDef<double> def;
      def.per_side = row.per_side;
      def.integration = integration;
      def.incline = degrees(66.0);
      // Let the sudden start ring down, then follow the table at 1 deg/s.
      def.parameters.sliding_friction = 5;
      auto scene = make_plate<double>(def);
      scene.run(1);
      auto parameters = def.parameters;
      parameters.sliding_friction = 0.1;
      scene.world.set_parameters(scene.patch, parameters);
      double angle = 66;
      const double start = scene.position().x();
      while (angle < 82 && std::abs(scene.position().x() - start) < 3e-3) {
        angle += 1e-3;
        const double a = degrees(angle);
        scene.world.set_gravity({9.81 * std::sin(a), 0, -9.81 * std::cos(a)});
        scene.world.step();
      }
      CHECK(std::abs(angle - row.angle) < 0.3);
    }
  }
}

TEST_CASE("incline_hold: sensors beside a hard contact carry the shear (R16)") {
  // Contact fixes the depth at 0.5, so sum F_N = n K_N / 2 whatever the weight, and the plate stays
  // flat: x = m g sin(angle) / (mu_S sum F_N).
  const double predicted = 0.5 * 9.81 * std::sin(degrees(25.0)) / (5000 * 4 * 0.5);
  CHECK(predicted == test::relative(0.20729e-3).epsilon(1e-4));
  for (const double dt : {1e-3, 1.0 / 60}) {
    for (const Integration integration : both_integrations) {
      if (integration == Integration::explicit_ && dt > 5e-3) continue;
      PlateDef<double> def;
      def.per_side = 2;
      def.integration = integration;
      def.incline = degrees(25.0);
      def.has_contact = true;
      def.time_step = dt;
      // n mu_V / (2 m) = 0.4 / s decays too slowly to wait for; a hundredfold settles in a second.
      def.parameters.sliding_friction = 10;
      auto scene = make_plate<double>(def);
      scene.run(3);
      CHECK(scene.position().x() == test::relative(0.20729e-3).epsilon(1e-3));
      CHECK(scene.position().x() == test::relative(predicted).epsilon(1e-6));
      CHECK(scene.world.reading(scene.patch).total_normal() == test::relative(2).epsilon(1e-6));
    }
  }
}
