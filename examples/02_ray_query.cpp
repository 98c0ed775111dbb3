// Casts rays and shapes through a world, and checks each distance against its closed form.
//
// A ray o + t d meets a sphere of radius r around c where t = -b - sqrt(b^2 - |o - c|^2 + r^2) with
// b = d . (o - c), and a plane n . p = h where t = (h - n . o) / (n . d). Where the ray starts
// inside a solid, t = 0 and the normal is -d; where it meets nothing, t is infinite.
//
// Expected output: 02_ray_query.expected
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/bristle.hpp>

#include <array>
#include <cmath>
#include <cstdio>

using namespace bristle;

int main() {
  World<double> world;
  const auto add = [&](const Shape<double>& shape, const Vec3<double>& position) {
    return world.add_body({.motion = Motion::fixed, .shape = shape, .position = position});
  };
  const BodyId floor = add(HalfSpace<double>{}, {0, 0, 0});
  const BodyId ball = add(Sphere<double>{.radius = 0.5}, {2, 0, 1});
  const BodyId crate = add(Box<double>{.half_extents = {0.5, 0.5, 0.5}}, {4, 0, 0.5});
  const BodyId mesh = add(sphere_mesh<double>(0.5, 16), {6, 0, 1});
  const auto name = [&](BodyId body) {
    if (body == floor) return "floor";
    if (body == ball) return "ball";
    if (body == crate) return "crate";
    return body == mesh ? "mesh" : "nothing";
  };

  const double root = std::sqrt(0.5);
  struct Query {
    const char* what;
    Ray<double> ray;
    double expected;
  };
  const std::array queries{
      Query{"down", {{0, 0, 1}, {0, 0, -1}}, 1.0},
      Query{"slanting down", {{0, 0, 1}, {0, root, -root}}, std::sqrt(2.0)},
      Query{"at the ball", {{0, 0, 1}, {1, 0, 0}}, 1.5},
      Query{"at the ball, off its centre", {{0, 0, 1.3}, {1, 0, 0}}, 2 - std::sqrt(0.25 - 0.09)},
      Query{"above the ball", {{0, 0, 1.6}, {1, 0, 0}}, infinity<double>},
      Query{"below it, at the crate", {{0, 0, 0.25}, {1, 0, 0}}, 3.5},
      Query{"the same, too short", {{0, 0, 0.25}, {1, 0, 0}, 3.0}, infinity<double>},
      // Triangles lie inside the sphere they stand for, here by up to 0.1 % of its radius.
      Query{"at the mesh of a ball", {{6.1, 0.05, 3}, {0, 0, -1}}, 2 - std::sqrt(0.25 - 0.0125)},
      Query{"from inside the crate", {{4, 0, 0.5}, {1, 0, 0}}, 0.0}};

  std::puts("ray                          hits     distance  expected  normal");
  for (const Query& query : queries) {
    const WorldHit<double> hit = world.cast_ray(query.ray);
    std::printf("%-28s %-7s  %8.3f  %8.3f", query.what, name(hit.body), hit.distance,
                query.expected);
    if (hit.is_hit()) {
      std::printf("  (%.2f, %.2f, %.2f)", hit.normal.x() + 0.0, hit.normal.y() + 0.0,
                  hit.normal.z() + 0.0);
    }
    std::puts("");
  }

  // A query can exclude the body that a ray starts from, or whole categories of bodies.
  const WorldHit<double> behind =
      world.cast_ray({.origin = {2, 0, 1}, .direction = {1, 0, 0}}, {.excluded = {ball}});
  std::printf("from the ball's centre without the ball: %s at %.3f m\n", name(behind.body),
              behind.distance);

  // What else is on the way of a ray, nearest first.
  std::printf("behind each other:");
  for (const auto& hit : world.cast_ray_through({.origin = {0, 0, 0.8}, .direction = {1, 0, 0}})) {
    std::printf(" %s at %.3f m,", name(hit.body), hit.distance);
  }
  std::puts(" then nothing");

  // From (2, 2, 1) the ball is 2 - 0.5 away, and its nearest point is (2, 0.5, 1).
  const WorldHit<double> nearest =
      world.closest(Vec3<double>(2, 2, 1), 10.0, {.excluded = {floor}});
  std::printf("nearest to a point: %s at %.3f m, at (%.2f, %.2f, %.2f)\n", name(nearest.body),
              nearest.distance, nearest.point.x(), nearest.point.y(), nearest.point.z());

  // A box of 0.2 m that moves along x touches the crate's side after 3.5 - 0.1 m.
  const Transform<double> start{.rotation = Quat<double>::Identity(), .translation = {0, 0, 0.3}};
  const Box<double> box{.half_extents = {0.1, 0.1, 0.1}};
  const WorldHit<double> touched = world.cast_shape(box, start, {10, 0, 0});
  std::printf("a box that moves along x: %s after %.3f m\n", name(touched.body), touched.distance);

  // A ball of 0.7 m at (3, 0, 0.9) overlaps both, and not the floor 0.9 m below its middle.
  const Transform<double> between{.rotation = Quat<double>::Identity(), .translation = {3, 0, 0.9}};
  std::printf("a ball between ball and crate overlaps");
  for (const auto& hit : world.overlaps(Sphere<double>{.radius = 0.7}, between)) {
    std::printf(" %s", name(hit.body));
  }
  std::puts("");
}
