// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/sensors/elastic_skin.hpp>
#include <bristle/sensors/law.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

using namespace bristle;

using namespace bristle::detail;

// A ball of radius R pressed by d into an elastic foundation of k [Pa/m] meets the paraboloid
// d - r^2 / (2 R), whose volume times k is pi k R d^2. Sensors on a grid sum it by the midpoint
// rule; its error on a disk of radius sqrt(2 R d) = 4.5 mm with cells of 0.1 mm is that of the rim,
// some cells' worth of almost no depth: below 1e-3.
TEST_CASE_TEMPLATE("elastic skin: a ball meets Winkler's force", S, float, double) {
  ElasticSkin<S> skin;
  const S side = S(1e-4);
  skin.area_per_sensor = side * side;
  const SensorParameters<S> p = skin.parameters();
  const S R = S(0.02);
  const S d = S(5e-4);
  S force = S(0);
  for (int i = -50; i < 50; ++i) {
    for (int j = -50; j < 50; ++j) {
      const S x = (S(i) + S(0.5)) * side;
      const S y = (S(j) + S(0.5)) * side;
      const S depth = d - (x * x + y * y) / (S(2) * R);
      if (depth > S(0)) force += normal_force(p, depth / skin.length, S(0));
    }
  }
  const S expected = S(std::numbers::pi) * skin.normal_stiffness_per_area() * R * d * d;
  CHECK(static_cast<double>(force) == test::relative(static_cast<double>(expected)).epsilon(1e-3));
}

// By hand: nu = 0.25, E = 1 MPa, h = 2 mm: 0.75 / (1.25 * 0.5) E / h = 6e8 Pa/m, G / h = 2e8 Pa/m.
TEST_CASE("elastic skin: constants of a case worked by hand") {
  ElasticSkin<double> skin;
  skin.young_modulus = 1e6;
  skin.poisson_ratio = 0.25;
  skin.thickness = 2e-3;
  skin.length = 1e-3;
  skin.area_per_sensor = 1e-6;
  skin.friction = 0.5;
  skin.relaxation_time = 2e-3;
  skin.working_pressure = 1e5;
  const SensorParameters<double> p = skin.parameters();
  CHECK(p.normal_stiffness == test::relative(0.6));       // 6e8 Pa/m * 1e-6 m^2 * 1e-3 m
  CHECK(p.normal_damping == test::relative(1.2e-3));      // 2 ms of it
  CHECK(p.static_friction == test::relative(2000));       // 2e8 Pa/m / 1e5 Pa
  CHECK(p.breakaway_distance == test::relative(2.5e-4));  // 0.5 / 2000
  CHECK(p.sliding_friction == test::relative(0.4));       // 2 ms * 2e8 Pa/m * 1e-6 m^2
  // At the working pressure the bristles are as stiff as the layer in shear.
  const double force = skin.working_pressure * skin.area_per_sensor;
  CHECK(bristle_stiffness(p, FrictionScaling::normal_force, force, 0.1) ==
        test::relative(skin.shear_stiffness_per_area() * skin.area_per_sensor));
}

TEST_CASE("elastic skin: refuses what is no material") {
  const auto field = [](auto change) -> std::string {
    ElasticSkin<double> skin;
    change(skin);
    try {
      (void)skin.parameters();
    } catch (const InvalidArgument& e) {
      return e.field();
    }
    return {};
  };
  using Skin = ElasticSkin<double>;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(field([](Skin&) {}).empty());
  CHECK(field([](Skin& s) { s.young_modulus = 0; }) == "ElasticSkin::young_modulus");
  CHECK(field([](Skin& s) { s.poisson_ratio = 0.5; }) == "ElasticSkin::poisson_ratio");
  CHECK(field([](Skin& s) { s.poisson_ratio = -0.1; }) == "ElasticSkin::poisson_ratio");
  CHECK(field([&](Skin& s) { s.thickness = nan; }) == "ElasticSkin::thickness");
  CHECK(field([](Skin& s) { s.area_per_sensor = 0; }) == "ElasticSkin::area_per_sensor");
  CHECK(field([](Skin& s) { s.length = 0.0031; }) == "ElasticSkin::length");
  CHECK(field([](Skin& s) { s.friction = 0; }) == "ElasticSkin::friction");
  CHECK(field([&](Skin& s) { s.relaxation_time = nan; }) == "ElasticSkin::relaxation_time");
  CHECK(field([](Skin& s) { s.working_pressure = 0; }) == "ElasticSkin::working_pressure");
}
