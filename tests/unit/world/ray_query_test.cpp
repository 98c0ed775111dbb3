// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

template <typename S>
Ray<S> ray_from(const Vec3<S>& origin, const Vec3<S>& direction, S length) {
  Ray<S> ray;
  ray.origin = origin;
  ray.direction = direction;
  ray.length = length;
  return ray;
}

/// Floor at z = 0 and three spheres of 0.5 m along x at height 1.
template <typename S>
struct Row {
  World<S> world;
  BodyId floor{};
  BodyId balls[3]{};
};

template <typename S>
Row<S> make_row() {
  Row<S> row;
  row.floor = row.world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
  for (int k = 0; k < 3; ++k) {
    BodyDef<S> def;
    def.motion = Motion::fixed;
    def.shape = Sphere<S>{S(0.5)};
    def.position = {S(2 * k), 0, 1};
    def.filter.category = 1u << (k + 1);
    row.balls[k] = row.world.add_body(def);
  }
  return row;
}

}  // namespace

TEST_CASE_TEMPLATE("cast_ray: finds the nearest of several, with point, normal and names", S, float,
                   double) {
  const auto row = make_row<S>();
  const auto hit = row.world.cast_ray(ray_from<S>({-3, 0, 1}, {1, 0, 0}, S(100)));
  REQUIRE(hit.is_hit());
  CHECK(hit.body == row.balls[0]);
  CHECK(static_cast<double>(hit.distance) == test::relative(2.5));
  CHECK(hit.point.isApprox(Vec3<S>(S(-0.5), 0, 1)));
  CHECK(hit.normal.isApprox(Vec3<S>(-1, 0, 0)));
  const auto down = row.world.cast_ray(ray_from<S>({S(1), 0, 5}, {0, 0, -1}, S(100)));
  CHECK(down.body == row.floor);
  CHECK(static_cast<double>(down.distance) == test::relative(5));
  CHECK_FALSE(row.world.cast_ray(ray_from<S>({0, 0, 5}, {0, 0, 1}, S(100))).is_hit());
  CHECK_FALSE(row.world.cast_ray(ray_from<S>({-3, 0, 1}, {1, 0, 0}, S(2))).is_hit());
  CHECK(row.world.cast_ray(ray_from<S>({0, 0, 1}, {1, 0, 0}, S(1))).distance == S(0));
}

TEST_CASE_TEMPLATE("cast_ray: filters by category and skips one body", S, float, double) {
  const auto row = make_row<S>();
  const Ray<S> ray = ray_from<S>({-3, 0, 1}, {1, 0, 0}, S(100));
  QueryFilter filter;
  filter.excluded = {row.balls[0]};
  CHECK(row.world.cast_ray(ray, filter).body == row.balls[1]);
  filter = {};
  filter.sense_mask = 1u << 3;
  CHECK(row.world.cast_ray(ray, filter).body == row.balls[2]);
  filter.sense_mask = 1u << 9;
  CHECK_FALSE(row.world.cast_ray(ray, filter).is_hit());
}

TEST_CASE("cast_rays: many rays give what each gives alone, also after bodies moved") {
  auto row = make_row<double>();
  row.world.set_pose(row.balls[1], {Quat<double>::Identity(), {2, 3, 1}});
  test::Random random(1);
  std::vector<Ray<double>> rays;
  for (int i = 0; i < 200; ++i) {
    rays.push_back(ray_from<double>(random.in_cube(4.0) + Vec3<double>(2, 0, 3),
                                    random.direction<double>(), 10.0));
  }
  std::vector<WorldHit<double>> hits(rays.size());
  row.world.cast_rays(rays, {}, hits);
  int count = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const auto alone = row.world.cast_ray(rays[i]);
    CHECK(hits[i].distance == alone.distance);
    CHECK(hits[i].body == alone.body);
    // The nearest of all shapes, by brute force over spheres and floor.
    double nearest = infinity<double>;
    const Ray<double>& r = rays[i];
    for (const BodyId id : row.balls) {
      const Vec3<double> to = r.origin - row.world.pose(id).translation;
      const double b = to.dot(r.direction);
      const double c = to.squaredNorm() - 0.25;
      if (c <= 0) nearest = 0;
      const double d = b * b - c;
      if (c > 0 && d >= 0 && b < 0) nearest = std::min(nearest, -b - std::sqrt(d));
    }
    if (r.origin.z() <= 0) nearest = 0;
    if (r.direction.z() < 0 && r.origin.z() > 0) {
      nearest = std::min(nearest, -r.origin.z() / r.direction.z());
    }
    if (nearest > 10) nearest = infinity<double>;
    CHECK(hits[i].is_hit() == (nearest < infinity<double>));
    if (!hits[i].is_hit()) continue;
    ++count;
    CHECK(hits[i].distance == test::relative(nearest).epsilon(1e-9));
  }
  CHECK(count > 20);
}
