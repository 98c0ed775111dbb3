/// @file
/// Distances that arrays of rays measure, against single rays and closed forms.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/sensors/ray_fan.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;

using namespace bristle::detail;

namespace {

SensorLayout<double> full_turn(std::size_t columns, double range) {
  RayFanDef<double> def;
  def.width = 2 * std::numbers::pi;
  def.columns = columns;
  def.range = range;
  return ray_fan(def);
}

}  // namespace

// A scanner at the origin in a room of four walls at 1 m: the distance along azimuth a is
// 1 / max(|cos a|, |sin a|), whatever way its body is turned about z.
TEST_CASE_TEMPLATE("proximity: a room, by its closed form", S, float, double) {
  World<S> world({.gravity = {0, 0, 0}});
  for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    world.add_body(
        {.motion = Motion::fixed, .shape = HalfSpace<S>{Vec3<S>(S(-x), S(-y), 0), S(-1)}});
  }
  const S turn = S(0.3);
  const BodyId scanner =
      world.add_body({.motion = Motion::kinematic,
                      .orientation = Quat<S>(Eigen::AngleAxis<S>(turn, Vec3<S>::UnitZ()))});
  RayFanDef<S> def;
  def.width = S(2) * S(std::numbers::pi);
  def.columns = 64;
  def.range = S(2);
  ProximityArray<S> array(ray_fan(def));
  world.sense(scanner, array);
  for (std::size_t i = 0; i < array.size(); ++i) {
    const S azimuth =
        (S(i) + S(0.5)) / S(64) * S(2) * S(std::numbers::pi) - S(std::numbers::pi) + turn;
    const S expected = S(1) / std::max(std::abs(std::cos(azimuth)), std::abs(std::sin(azimuth)));
    CHECK(array.distance()[i] ==
          test::relative(double(expected)).epsilon(std::is_same_v<S, float> ? 1e-5 : 1e-12));
  }
  CHECK(array.rays_cast() == 4 * 64);
}

// The same rays one by one through the world; poses far from the origin cost some digits.
TEST_CASE("proximity: an array meets what single rays meet") {
  test::Random random(11);
  World<double> world({.gravity = {0, 0, 0}});
  for (int i = 0; i < 40; ++i) {
    const Vec3<double> at(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
                          random.uniform(-0.2, 0.2));
    if (at.norm() < 0.35) continue;  // No ray starts inside of anything.
    if (i % 2 == 0) {
      world.add_body({.shape = Sphere<double>{0.1}, .position = at});
    } else {
      world.add_body({.shape = Box<double>{{0.1, 0.05, 0.2}}, .position = at});
    }
  }
  const BodyId scanner = world.add_body({.motion = Motion::kinematic,
                                         .shape = Sphere<double>{0.05},
                                         .position = {0.03, -0.02, 0.01}});
  ProximityArray<double> array(full_turn(200, 0.6));
  world.sense(scanner, array);
  std::size_t met = 0;
  for (std::size_t i = 0; i < array.size(); ++i) {
    const Transform<double> X = world.pose(scanner);
    const Ray<double> ray{X * array.rays().start[i], X.rotate(array.rays().direction[i]), 0.6};
    const WorldHit<double> hit = world.cast_ray(ray, {.excluded = {scanner}});
    REQUIRE(hit.is_hit() == (array.distance()[i] < infinity<double>));
    CHECK(array.body()[i] == hit.body);
    if (!hit.is_hit()) continue;
    ++met;
    CHECK(hit.distance > 0);
    CHECK(array.distance()[i] == test::relative(hit.distance).epsilon(1e-9));
    CHECK((X.rotate(array.normal(i)) - hit.normal).norm() < 1e-9);
  }
  CHECK(met > 20);
  CHECK(met < 200);
  const std::size_t nearest = array.nearest();
  for (const double d : array.distance()) CHECK(d >= array.distance()[nearest]);
}

TEST_CASE("proximity: filters, and nothing in reach casts nothing") {
  World<double> world({.gravity = {0, 0, 0}});
  const BodyId a = world.add_body({.shape = Sphere<double>{0.1}, .position = {0.5, 0, 0}});
  BodyDef<double> behind{.shape = Sphere<double>{0.1}, .position = {0.8, 0, 0}};
  behind.filter.category = 4;
  const BodyId b = world.add_body(behind);
  const BodyId carrier = world.add_body({.motion = Motion::kinematic});
  SensorLayout<double> ray;
  ray.add(Vec3<double>(0, 0, 0), Vec3<double>(1, 0, 0), 1.0);

  ProximityArray<double> all(ray);
  world.sense(carrier, all);
  CHECK(all.distance()[0] == test::relative(0.4));
  CHECK(all.body()[0] == a);
  ProximityArray<double> fourth(ray, {.sense_mask = 4});
  world.sense(carrier, fourth);
  CHECK(fourth.distance()[0] == test::relative(0.7));
  CHECK(fourth.body()[0] == b);
  ProximityArray<double> others(ray, {.excluded = {a, b}});
  world.sense(carrier, others);
  CHECK(others.nearest() == others.size());
  CHECK_FALSE(world.contains(others.body()[0]));

  world.set_pose(carrier, {Quat<double>::Identity(), {0, 5, 0}});
  world.sense(carrier, all);
  CHECK(all.rays_cast() == 0);
  CHECK(all.nearest() == 1);
  CHECK_THROWS_AS(world.sense(BodyId{}, all), InvalidArgument);
}

TEST_CASE("proximity: asking changes nothing") {
  const auto run = [](bool asks) {
    World<double> world;
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    const BodyId ball = world.add_body({.shape = Sphere<double>{0.1}, .position = {0, 0, 0.3}});
    ProximityArray<double> array(full_turn(16, 1));
    for (int i = 0; i < 100; ++i) {
      world.step();
      if (asks) world.sense(ball, array);
    }
    return world.state_hash();
  };
  CHECK(run(true) == run(false));
}
