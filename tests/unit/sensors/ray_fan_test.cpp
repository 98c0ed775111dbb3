// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/sensors/ray_fan.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

using namespace bristle;
using namespace bristle::detail;

TEST_CASE_TEMPLATE("ray fan: cells of azimuth and elevation, row by row", S, float, double) {
  RayFanDef<S> def;
  def.origin = {S(1), S(2), S(3)};
  def.forward = {S(0), S(2), S(0)};
  def.up = {S(0), S(1), S(3)};  // Not perpendicular; what is left of it is +z.
  def.width = S(std::numbers::pi) / S(2);
  def.height = S(std::numbers::pi) / S(3);
  def.columns = 2;
  def.rows = 3;
  def.start = S(0.1);
  def.range = S(0.5);
  const SensorLayout<S> rays = ray_fan(def);
  REQUIRE(rays.size() == 6);
  CHECK_NOTHROW(rays.validate());
  // Azimuths -22.5 and 22.5 degrees, elevations -20, 0, 20. Left of +y, seen from +z, is -x.
  const S quarter = S(std::numbers::pi) / S(8);
  for (std::size_t row = 0; row < 3; ++row) {
    const S elevation = (S(row) - S(1)) * S(std::numbers::pi) / S(9);
    for (std::size_t column = 0; column < 2; ++column) {
      const S azimuth = column == 0 ? -quarter : quarter;
      const Vec3<S> expected(-std::sin(azimuth) * std::cos(elevation),
                             std::cos(azimuth) * std::cos(elevation), std::sin(elevation));
      const std::size_t i = row * 2 + column;
      CHECK((rays.direction[i] - expected).norm() < Tolerance<S>::round_off());
      CHECK((rays.start[i] - def.origin - S(0.1) * expected).norm() <
            Tolerance<S>::round_off() * S(4));
      CHECK(rays.length[i] == S(0.5));
    }
  }
}

TEST_CASE("ray fan: goes round without a ray twice") {
  RayFanDef<double> def;
  def.width = 2 * std::numbers::pi;
  def.columns = 8;
  const SensorLayout<double> rays = ray_fan(def);
  Vec3<double> sum = Vec3<double>::Zero();
  for (std::size_t i = 0; i < 8; ++i) {
    sum += rays.direction[i];
    CHECK(rays.direction[i].dot(rays.direction[(i + 1) % 8]) ==
          test::relative(std::sqrt(0.5)).epsilon(1e-12));
  }
  CHECK(sum.norm() < 1e-14);
}

TEST_CASE("ray fan: refuses what is no fan") {
  const auto field = [](auto change) -> std::string {
    RayFanDef<double> def;
    change(def);
    try {
      (void)ray_fan(def);
    } catch (const InvalidArgument& e) {
      return e.field();
    }
    return {};
  };
  using Def = RayFanDef<double>;
  CHECK(field([](Def&) {}).empty());
  CHECK(field([](Def& d) { d.up = d.forward; }) == "RayFanDef::up");
  CHECK(field([](Def& d) { d.forward.setZero(); }) == "RayFanDef::forward");
  CHECK(field([](Def& d) { d.width = 7; }) == "RayFanDef::width");
  CHECK(field([](Def& d) { d.height = -0.1; }) == "RayFanDef::height");
  CHECK(field([](Def& d) { d.columns = 0; }) == "RayFanDef::columns");
  CHECK(field([](Def& d) { d.rows = 0; }) == "RayFanDef::rows");
  CHECK(field([](Def& d) { d.start = -1; }) == "RayFanDef::start");
  CHECK(field([](Def& d) { d.range = 0; }) == "RayFanDef::range");
}
