// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_tree.hpp>
#include <bristle/geometry/rays/ray_shapes.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <support/random.hpp>
#include <support/rounds.hpp>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

/// A ring about z: a mesh with a hole and with both kinds of curvature.
template <typename S>
TriangleMesh<S> torus_mesh(S ring, S tube, std::uint32_t around, std::uint32_t across) {
  TriangleMesh<S> mesh;
  for (std::uint32_t i = 0; i < around; ++i) {
    const S u = S(2 * std::numbers::pi) * S(i) / S(around);
    for (std::uint32_t j = 0; j < across; ++j) {
      const S v = S(2 * std::numbers::pi) * S(j) / S(across);
      const S r = ring + tube * std::cos(v);
      mesh.vertices.push_back({r * std::cos(u), r * std::sin(u), tube * std::sin(v)});
    }
  }
  for (std::uint32_t i = 0; i < around; ++i) {
    for (std::uint32_t j = 0; j < across; ++j) {
      const std::uint32_t a = i * across + j;
      const std::uint32_t b = (i + 1) % around * across + j;
      const std::uint32_t c = (i + 1) % around * across + (j + 1) % across;
      const std::uint32_t d = i * across + (j + 1) % across;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

/// Nearest crossing of any triangle, and whether the start is inside by winding number: no tree, no
/// watertight test (Moeller and Trumbore 1997), in double.
template <typename S>
double brute_force(const TriangleMesh<S>& mesh, const Ray<S>& ray) {
  const Vec3<double> o = ray.origin.template cast<double>();
  const Vec3<double> d = ray.direction.template cast<double>();
  double nearest = infinity<double>;
  double half_angles = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3<double> a = mesh.vertices[t[0]].template cast<double>() - o;
    const Vec3<double> b = mesh.vertices[t[1]].template cast<double>() - o;
    const Vec3<double> c = mesh.vertices[t[2]].template cast<double>() - o;
    half_angles +=
        std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                          b.dot(c) * a.norm() + c.dot(a) * b.norm());
    const Vec3<double> e1 = b - a;
    const Vec3<double> e2 = c - a;
    const double det = e1.dot(d.cross(e2));
    if (det == 0.0) continue;
    const double u = -a.dot(d.cross(e2)) / det;
    const double v = d.dot((-a).cross(e1)) / det;
    const double distance = e2.dot((-a).cross(e1)) / det;
    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance >= 0.0) {
      nearest = std::min(nearest, distance);
    }
  }
  if (half_angles > std::numbers::pi) return 0.0;
  return nearest <= double(ray.length) ? nearest : infinity<double>;
}

template <typename S>
Ray<S> ray_to(const Vec3<S>& from, const Vec3<S>& to, S length = infinity<S>) {
  return {from, (to - from).normalized(), length};
}

}  // namespace

TEST_CASE_TEMPLATE("MeshTree: random rays agree with every triangle tried in turn", S, float,
                   double) {
  Random random(31);
  for (const TriangleMesh<S>& mesh :
       {torus_mesh<S>(S(1), S(0.4), 24, 12), sphere_mesh<S>(S(1.2), 4)}) {
    const MeshTree<S> tree(mesh);
    const int count = test::rounds(2000);
    int inside_count = 0;
    for (int i = 0; i < count; ++i) {
      const S length = i % 2 == 0 ? infinity<S> : random.uniform(S(0), S(1));
      const Ray<S> ray = ray_to<S>(random.in_cube(S(1.5)), random.in_cube(S(1.2)), length);
      const RayHit<S> hit = ray_cast(tree, ray);
      const double expected = brute_force(mesh, ray);
      CAPTURE(i);
      // Random rays stay away from edges and reaches from surfaces by more than round-off.
      REQUIRE((hit.distance < infinity<S>) == (expected < infinity<double>));
      if (!(hit.distance < infinity<S>)) continue;
      CHECK(std::abs(double(hit.distance) - expected) < double(S(8) * Tolerance<S>::equal()));
      CHECK(hit.normal.dot(ray.direction) <= S(0));
      CHECK(std::abs(hit.normal.norm() - S(1)) < Tolerance<S>::round_off());
      inside_count += hit.distance == S(0) ? 1 : 0;
    }
    CHECK(inside_count > count / 20);
  }
}

TEST_CASE_TEMPLATE("MeshTree: a box of triangles is a box, for 100 000 rays", S, float, double) {
  Random random(32);
  const Box<S> box{{S(0.5), S(0.7), S(0.9)}};
  const MeshTree<S> tree(box_mesh<S>(box.half_extents));
  for (int i = 0; i < 100000; ++i) {
    const Ray<S> ray =
        ray_to<S>(random.in_cube(S(1.5)), random.in_cube(S(1)), i % 2 == 0 ? infinity<S> : S(1));
    const S expected = ray_cast(box, ray).distance;
    const S distance = ray_cast(tree, ray).distance;
    // Where an answer hangs on round-off both are right: at an edge, or at the ray's end.
    const bool agrees = (distance < infinity<S>) ==
                        (expected < infinity<S>)&&(!(distance < infinity<S>) ||
                                                   std::abs(distance - expected) <=
                                                       S(8) * Tolerance<S>::round_off());
    if (agrees) continue;
    const S reach = std::min(distance, expected);
    const Vec3<S> excess = (ray.origin + reach * ray.direction).cwiseAbs() - box.half_extents;
    const S off_edge = std::abs(excess[0]) + std::abs(excess[1]) + std::abs(excess[2]) -
                       excess.cwiseAbs().maxCoeff();
    const bool is_close_call = off_edge < S(16) * Tolerance<S>::round_off() ||
                               std::abs(reach - ray.length) < S(16) * Tolerance<S>::round_off();
    CHECK(is_close_call);
  }
}

TEST_CASE_TEMPLATE("MeshTree: no ray from outside slips through an edge or a corner", S, float,
                   double) {
  Random random(33);
  const TriangleMesh<S> mesh = sphere_mesh<S>(S(1), 6);
  const MeshTree<S> tree(mesh);
  for (int i = 0; i < 20000; ++i) {
    const auto& t = mesh.triangles[random.index(mesh.triangles.size())];
    const Vec3<S>& a = mesh.vertices[t[0]];
    const Vec3<S>& b = mesh.vertices[t[1]];
    // On the corner, or on the edge as well as rounding lets it be.
    const Vec3<S> target = i % 2 == 0 ? a : Vec3<S>(a + random.uniform(S(0), S(1)) * (b - a));
    const Vec3<S> from = target + (target + S(0.9) * random.direction<S>());
    const RayHit<S> hit = ray_cast(tree, ray_to<S>(from, target));
    CAPTURE(i);
    const S distance = (target - from).norm();
    // The mesh may be met a little before the target, where its surface bulges, but never inside.
    REQUIRE(hit.distance > S(0));
    REQUIRE(hit.distance <= distance * (S(1) + S(8) * Tolerance<S>::round_off()));
  }
}

TEST_CASE_TEMPLATE("MeshTree: no ray from inside misses its being inside", S, float, double) {
  Random random(34);
  for (const TriangleMesh<S>& mesh :
       {sphere_mesh<S>(S(1), 5), torus_mesh<S>(S(1), S(0.4), 16, 8)}) {
    const MeshTree<S> tree(mesh);
    const Vec3<S> inside(S(1.05), S(0.01), S(0.02));  // In the ring; scaled, in the ball.
    const Vec3<S> start = mesh.vertices.size() > 200 ? Vec3<S>(S(0.3) * inside) : inside;
    for (const Vec3<S>& corner : mesh.vertices) {
      const RayHit<S> hit = ray_cast(tree, ray_to<S>(start, corner, S(0.001)));
      REQUIRE(hit.distance == S(0));
    }
    for (const auto& t : mesh.triangles) {
      const Vec3<S> middle = (mesh.vertices[t[0]] + mesh.vertices[t[1]]) / S(2);
      REQUIRE(ray_cast(tree, ray_to<S>(start, middle, S(0.001))).distance == S(0));
    }
  }
}

TEST_CASE_TEMPLATE("MeshTree: a ray that grazes an edge or a corner from outside is not inside", S,
                   float, double) {
  Random random(35);
  const Vec3<S> half = Vec3<S>::Constant(S(0.5));
  // A block with a tower, so that its box holds starts that are outside.
  TriangleMesh<S> mesh = box_mesh<S>(half);
  TriangleMesh<S> far = box_mesh<S>(half);
  for (Vec3<S>& v : far.vertices) v += Vec3<S>::Constant(S(4));
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), far.vertices.begin(), far.vertices.end());
  for (const auto& t : far.triangles) {
    mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  const MeshTree<S> tree(mesh);
  REQUIRE(tree.root_box().contains(Vec3<S>(S(2), S(2), S(2))));
  for (int i = 0; i < 20000; ++i) {
    // Over the edge x = z = 0.5 of the block, along a line that only touches it there: the
    // direction lies between the two faces' planes.
    const S y = i % 4 == 0 ? S(0.5) : random.uniform(S(-0.4), S(0.4));
    const Vec3<S> edge(S(0.5), y, S(0.5));
    const Vec3<S> direction =
        Vec3<S>(random.uniform(S(0.05), S(1)), random.uniform(S(-0.5), S(0.5)),
                -random.uniform(S(0.05), S(1)))
            .normalized();
    const Vec3<S> start = edge - random.uniform(S(0.1), S(0.45)) * direction;
    if ((start.array().abs() <= half.array()).all()) continue;
    const RayHit<S> hit = ray_cast(tree, Ray<S>{start, direction, infinity<S>});
    CAPTURE(i);
    REQUIRE(hit.distance > S(0));
    if (!(hit.distance < infinity<S>)) continue;
    REQUIRE(hit.normal.dot(direction) <= S(0));
  }
}

TEST_CASE_TEMPLATE("MeshTree: a ray from inside that grazes a concave edge is inside", S, float,
                   double) {
  Random random(36);
  // The ring's inner corners are silhouettes for starts in its tube.
  const TriangleMesh<S> mesh = torus_mesh<S>(S(1), S(0.4), 12, 6);
  const MeshTree<S> tree(mesh);
  for (int i = 0; i < 5000; ++i) {
    const S u = S(2 * std::numbers::pi) * random.uniform(S(0), S(1));
    const Vec3<S> start(S(0.95) * std::cos(u), S(0.95) * std::sin(u), S(0.01));
    const Vec3<S> target = mesh.vertices[random.index(mesh.vertices.size())];
    REQUIRE(ray_cast(tree, ray_to<S>(start, target, S(0))).distance == S(0));
  }
}

TEST_CASE_TEMPLATE("MeshTree: the surface belongs to the solid", S, float, double) {
  const MeshTree<S> tree(box_mesh<S>(Vec3<S>::Constant(S(1))));
  const Vec3<S> up = Vec3<S>::UnitZ();
  // On a corner, on an edge, on a face: inwards at 0, whatever is said outwards.
  for (const Vec3<S>& start :
       {Vec3<S>(S(1), S(1), S(1)), Vec3<S>(S(1), S(0.3), S(1)), Vec3<S>(S(0.2), S(0.3), S(1))}) {
    const Vec3<S> inwards = (-start).normalized();
    CHECK(ray_cast(tree, Ray<S>{start, inwards, S(1)}).distance <= Tolerance<S>::round_off());
    CHECK(tree.contains(start));
  }
  CHECK(tree.contains(Vec3<S>::Zero()));
  CHECK(!tree.contains(Vec3<S>(S(0), S(0), S(1.001))));
  CHECK(!tree.contains(Vec3<S>(S(1.001), S(1), S(1))));
  // Outside and away.
  CHECK(ray_cast(tree, Ray<S>{S(1.5) * up, up, infinity<S>}).distance == infinity<S>);
}

TEST_CASE_TEMPLATE("MeshTree: reach counts to the end, also from within the box", S, float,
                   double) {
  const TriangleMesh<S> mesh = torus_mesh<S>(S(1), S(0.4), 24, 12);
  const MeshTree<S> tree(mesh);
  // From the middle of the hole the ring is at 0.6.
  Ray<S> ray{{S(0), S(0), S(0)}, {S(1), S(0), S(0)}, infinity<S>};
  const S distance = ray_cast(tree, ray).distance;
  CHECK(std::abs(distance - S(0.6)) <= Tolerance<S>::round_off());
  ray.length = S(0.59);
  CHECK(ray_cast(tree, ray).distance == infinity<S>);
  ray.length = S(0.61);
  CHECK(ray_cast(tree, ray).distance == distance);
}

TEST_CASE_TEMPLATE("MeshTree: sensor-sized rays on a fine mesh, at three scales", S, float,
                   double) {
  // 5 mm rays on 1 mm triangles of a 5 cm ball, and its copies a hundred times smaller and larger.
  Random random(37);
  for (const S scale : {S(0.01), S(1), S(100)}) {
    const S radius = S(0.05) * scale;
    const MeshTree<S> tree(sphere_mesh<S>(radius, 40));
    for (int i = 0; i < 500; ++i) {
      const Vec3<S> out = random.direction<S>();
      const RayHit<S> hit = ray_cast(tree, Ray<S>{S(1.05) * radius * out, -out, S(0.005) * scale});
      // The faces lie below the ball by at most edge^2 / (6 r) < 1e-3 of the radius.
      CHECK(std::abs(hit.distance - S(0.05) * radius) < S(1e-3) * radius);
      const RayHit<S> deep = ray_cast(tree, Ray<S>{S(0.95) * radius * out, out, S(0.005) * scale});
      CHECK(deep.distance == S(0));
    }
  }
}
