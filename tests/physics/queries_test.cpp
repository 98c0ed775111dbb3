/// @file
/// Hits of rays through a world between steps.
// SPDX-License-Identifier: BSD-3-Clause
#include <doctest/doctest.h>

using namespace bristle;

using namespace bristle::detail;

namespace {

BodyDef<double> asked_cube(double mass, const Vec3<double>& position) {
  BodyDef<double> def;
  def.mass = mass;
  def.shape = Box<double>{{0.05, 0.05, 0.05}};
  def.position = position;
  return def;
}

Ray<double> down_at(double x) {
  Ray<double> ray;
  ray.origin = {x, 0, 1};
  ray.direction = {0, 0, -1};
  ray.length = 2;
  return ray;
}

}  // namespace

TEST_CASE("queries: a body that was hit in the last step is found where it is now") {
  WorldDef<double> def;
  def.gravity.setZero();
  def.time_step = 1.0 / 60;
  World<double> world(def);
  const BodyId light = world.add_body(asked_cube(0.1, {0, 0, 0}));
  BodyDef<double> heavy = asked_cube(10, {-0.101, 0, 0});
  heavy.velocity = {3, 0, 0};
  world.add_body(heavy);
  world.step();
  const double front = world.pose(light).translation.x() + 0.05;
  REQUIRE(front > 0.06);  // It moved by much more than free motion, which is none.
  const auto hit = world.cast_ray(down_at(front - 0.001));
  CHECK(hit.is_hit());
  CHECK(hit.body == light);
  CHECK_FALSE(world.cast_ray(down_at(front + 0.001)).is_hit());
}

TEST_CASE("queries: one fast step does not leave a body's box large for ever") {
  BroadPhase<double> boxes;
  const Aabb<double> still{Vec3<double>(-1, -1, -1), Vec3<double>(1, 1, 1)};
  boxes.insert(0, still);
  boxes.move(0, still.inflated(1000));
  boxes.move(0, still);
  int visits = 0;
  Ray<double> ray;
  ray.origin = {50, 50, 50};
  ray.direction = {0, 0, -1};
  ray.length = 100;
  boxes.walk_ray(ray, [&](std::uint32_t, double length) {
    ++visits;
    return length;
  });
  CHECK(visits == 0);
}

TEST_CASE("queries: of two shapes at the same distance the first one added is met") {
  // Both solids contain the start; what the tree visits first must not matter.
  for (const bool is_crowded : {false, true}) {
    WorldDef<double> def;
    World<double> world(def);
    const BodyId first = world.add_body(asked_cube(1, {0, 0, 0}));
    world.add_body(asked_cube(1, {0.01, 0, 0}));
    if (is_crowded) {
      for (int i = 0; i < 20; ++i) world.add_body(asked_cube(1, {1.0 + 0.3 * i, 0.2 * i, 0}));
    }
    Ray<double> ray;
    ray.direction = {0, 0, 1};
    ray.length = 1;
    const auto hit = world.cast_ray(ray);
    CHECK(hit.distance == 0);
    CHECK(hit.body == first);
  }
}
