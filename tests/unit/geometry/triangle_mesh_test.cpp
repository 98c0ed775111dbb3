// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <support/random.hpp>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using bristle::test::Random;

namespace {

/// Legs 3 and 4 along x and y.
template <typename S>
TriangleMesh<S> right_triangle() {
  return {{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, {{0, 1, 2}}};
}

/// The same triangles, each with three vertices of its own.
template <typename S>
TriangleMesh<S> soup_of(const TriangleMesh<S>& mesh) {
  TriangleMesh<S> soup;
  for (const auto& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const std::uint32_t v : t) soup.vertices.push_back(mesh.vertices[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  return soup;
}

}  // namespace

TEST_CASE_TEMPLATE("triangle_normal, triangle_area, triangle_centroid: of a 3-4-5 triangle", S,
                   float, double) {
  const TriangleMesh<S> mesh = right_triangle<S>();
  // All intermediate values are small integers, so these are exact.
  CHECK(area_vector(mesh, 0) == Vec3<S>(0, 0, 12));
  CHECK(triangle_normal(mesh, 0) == Vec3<S>(0, 0, 1));
  CHECK(triangle_area(mesh, 0) == S(6));
  CHECK(triangle_centroid(mesh, 0).isApprox(Vec3<S>(1, S(4) / S(3), 0)));
}

TEST_CASE_TEMPLATE("triangle_normal: is a unit vector at every scale", S, float, double) {
  for (const S scale : {S(1e-12), S(1e-3), S(1), S(1e6)}) {
    TriangleMesh<S> mesh = right_triangle<S>();
    for (auto& v : mesh.vertices) v *= scale;
    CHECK((triangle_normal(mesh, 0) - Vec3<S>(0, 0, 1)).norm() <= Tolerance<S>::round_off());
  }
}

TEST_CASE_TEMPLATE("mesh_bounds: counts only vertices that triangles use", S, float, double) {
  TriangleMesh<S> mesh = right_triangle<S>();
  mesh.vertices.push_back({100, 100, 100});
  const Aabb<S> box = mesh_bounds(mesh);
  CHECK(box.lower == Vec3<S>(0, 0, 0));
  CHECK(box.upper == Vec3<S>(3, 4, 0));
  CHECK(mesh_bounds(TriangleMesh<S>{}).is_empty());
}

TEST_CASE_TEMPLATE("weld: restores a mesh from its soup of triangles", S, float, double) {
  const TriangleMesh<S> mesh = sphere_mesh(S(0.3), 4);
  const TriangleMesh<S> soup = soup_of(mesh);
  const TriangleMesh<S> welded = weld(soup);
  REQUIRE(welded.vertices.size() == mesh.vertices.size());
  REQUIRE(welded.triangles.size() == mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(welded.vertices[welded.triangles[t][k]] == mesh.vertices[mesh.triangles[t][k]]);
    }
  }
  CHECK_THROWS_AS(validate_solid(soup), InvalidArgument);
  CHECK_NOTHROW(validate_solid(welded));
}

TEST_CASE_TEMPLATE("weld: keeps the first of equal vertices and takes -0 for 0", S, float, double) {
  const TriangleMesh<S> mesh{
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-S(0), 0, -S(0)}, {1, 0, 0}, {0, 0, 1}},
      {{0, 1, 2}, {3, 4, 5}}};
  const TriangleMesh<S> welded = weld(mesh);
  REQUIRE(welded.vertices.size() == 4);
  CHECK(welded.vertices[3] == Vec3<S>(0, 0, 1));
  CHECK(welded.triangles[0] == std::array<std::uint32_t, 3>{0, 1, 2});
  CHECK(welded.triangles[1] == std::array<std::uint32_t, 3>{0, 1, 3});
}

TEST_CASE_TEMPLATE("weld: with a tolerance merges what is nearer, at every scale and place", S,
                   float, double) {
  const std::uint64_t seed = 11;
  CAPTURE(seed);
  Random random(seed);
  const TriangleMesh<S> mesh = sphere_mesh(S(1), 3);
  for (const S scale : {S(1e-3), S(1), S(1e3)}) {
    TriangleMesh<S> noisy = soup_of(mesh);
    const Vec3<S> shift = scale * random.in_cube(S(2));
    // Noise of 1e-4 of the radius, tolerance of 1e-3 of the diagonal 2 sqrt(3): between noise and
    // the distance of neighbours, about 0.35 of the radius.
    for (auto& v : noisy.vertices) {
      v = scale * (v + S(1e-4) * random.direction<S>()) + shift;
    }
    CHECK(weld(noisy).vertices.size() == noisy.vertices.size());
    const TriangleMesh<S> welded = weld(noisy, S(1e-3));
    CHECK(welded.vertices.size() == mesh.vertices.size());
    CHECK_NOTHROW(validate_solid(welded));
  }
}

TEST_CASE_TEMPLATE("weld: leaves collapsed triangles for degenerate_triangles to find", S, float,
                   double) {
  const TriangleMesh<S> mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {S(0.001), 0, 0}},
                             {{0, 1, 2}, {0, 3, 2}}};
  CHECK(degenerate_triangles(mesh).empty());
  const TriangleMesh<S> welded = weld(mesh, S(0.01));
  REQUIRE(welded.triangles.size() == 2);
  CHECK(degenerate_triangles(welded) == std::vector<std::uint32_t>{1});
  const TriangleMesh<S> rest = without_triangles<S>(welded, degenerate_triangles(welded));
  REQUIRE(rest.triangles.size() == 1);
  CHECK(rest.triangles[0] == welded.triangles[0]);
  CHECK(rest.vertices.size() == welded.vertices.size());
}

TEST_CASE_TEMPLATE("weld: refuses vertices and tolerances that are no numbers", S, float, double) {
  TriangleMesh<S> mesh = right_triangle<S>();
  CHECK_THROWS_AS((void)weld(mesh, S(-1)), InvalidArgument);
  CHECK_THROWS_AS((void)weld(mesh, std::numeric_limits<S>::quiet_NaN()), InvalidArgument);
  mesh.vertices[1].y() = std::numeric_limits<S>::quiet_NaN();
  CHECK_THROWS_AS((void)weld(mesh), InvalidArgument);
  CHECK(weld(TriangleMesh<S>{}).vertices.empty());
}

TEST_CASE_TEMPLATE("TriangleMesh: what follows its triangles refuses one that names no vertex", S,
                   float, double) {
  TriangleMesh<S> mesh = box_mesh<S>({1, 1, 1});
  mesh.triangles[3][1] = 8;
  CHECK_THROWS_AS((void)weld(mesh), InvalidArgument);
  CHECK_THROWS_AS((void)convex_hull(mesh), InvalidArgument);
  CHECK_THROWS_AS((void)signed_volume(mesh), InvalidArgument);
  CHECK_THROWS_AS((void)degenerate_triangles(mesh), InvalidArgument);
  CHECK_THROWS_AS(validate_surface(mesh), InvalidArgument);
}
