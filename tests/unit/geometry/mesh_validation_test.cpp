// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"
#include "support/texts.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>

#include <doctest/doctest.h>

#include <chrono>
#include <limits>
#include <string>
#include <support/random.hpp>
#include <utility>
#include <vector>

using namespace bristle;
using bristle::test::contains;
using bristle::test::error_of;
using bristle::test::Random;

namespace {

template <typename S>
TriangleMesh<S> cube() {
  return box_mesh<S>({1, 1, 1});
}

template <typename S>
std::string solid_error(const TriangleMesh<S>& mesh) {
  return error_of([&] { validate_solid(mesh); });
}
template <typename S>
std::string surface_error(const TriangleMesh<S>& mesh) {
  return error_of([&] { validate_surface(mesh); });
}

}  // namespace

TEST_CASE_TEMPLATE("validate_solid: accepts closed meshes at every scale and place", S, float,
                   double) {
  for (const S scale : {S(1e-6), S(1e-3), S(1), S(1e3)}) {
    for (const S shift : {S(0), S(100)}) {
      for (TriangleMesh<S> mesh :
           {cube<S>(), sphere_mesh(S(1), 8), cylinder_mesh<S>({S(0.5), S(2)}, 40)}) {
        for (auto& v : mesh.vertices) v = scale * (v + shift * Vec3<S>(1, -2, 3));
        CAPTURE(scale);
        CAPTURE(shift);
        CHECK(solid_error(mesh) == "");
      }
    }
  }
}

TEST_CASE_TEMPLATE("validate_solid: accepts a hollow body", S, float, double) {
  TriangleMesh<S> hollow = cube<S>();
  for (auto t : cube<S>().triangles) {
    std::swap(t[1], t[2]);
    hollow.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  }
  for (const auto& v : cube<S>().vertices) hollow.vertices.push_back(S(0.5) * v);
  CHECK(solid_error(hollow) == "");
  CHECK(signed_volume(hollow) == test::relative(7.0));
}

TEST_CASE_TEMPLATE("validate_solid: names the edge where a mesh is open", S, float, double) {
  TriangleMesh<S> mesh = cube<S>();
  mesh.triangles.pop_back();
  const std::string error = solid_error(mesh);
  CHECK(contains(error, "open"));
  CHECK(contains(error, "edge (4, 6)"));
  CHECK(surface_error(mesh) == "");
  CHECK(contains(solid_error(grid_mesh<S>({1, 1}, {2, 2})), "open"));
}

TEST_CASE_TEMPLATE("validate_solid: names the triangle that is wound the other way", S, float,
                   double) {
  TriangleMesh<S> mesh = cube<S>();
  std::swap(mesh.triangles[7][1], mesh.triangles[7][2]);
  const std::string error = solid_error(mesh);
  CHECK(contains(error, "wound consistently"));
  CHECK(contains(error, "triangle"));
  CHECK(surface_error(mesh) == "");
}

TEST_CASE_TEMPLATE("validate_solid: refuses an inverted mesh", S, float, double) {
  TriangleMesh<S> mesh = cube<S>();
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  CHECK(contains(solid_error(mesh), "inverted"));
  CHECK(signed_volume(mesh) == test::relative(-8.0));
  CHECK(surface_error(mesh) == "");
}

TEST_CASE_TEMPLATE("validate_solid: refuses a sheet with two sides and no volume", S, float,
                   double) {
  const TriangleMesh<S> sheet{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}};
  CHECK(contains(solid_error(sheet), "volume"));
}

TEST_CASE_TEMPLATE("validate_solid: refuses edges with more than two triangles", S, float, double) {
  // Two cubes that touch along one edge only.
  TriangleMesh<S> mesh = cube<S>();
  for (const auto& t : cube<S>().triangles)
    mesh.triangles.push_back({t[0] + 8, t[1] + 8, t[2] + 8});
  for (const auto& v : cube<S>().vertices) mesh.vertices.push_back(v + Vec3<S>(2, 2, 0));
  const std::string error = solid_error(weld(mesh));
  CHECK(contains(error, "manifold"));
  CHECK(contains(error, "4 triangles"));
}

TEST_CASE_TEMPLATE("validate_solid: names the degenerate triangle at every scale", S, float,
                   double) {
  for (const S scale : {S(1e-6), S(1), S(1e6)}) {
    TriangleMesh<S> mesh = cube<S>();
    mesh.triangles.push_back({0, 1, 1});
    for (auto& v : mesh.vertices) v *= scale;
    CHECK(contains(solid_error(mesh), "triangles[12] = (0, 1, 1): must not be degenerate"));
    CHECK(surface_error(mesh) == "");
  }
}

TEST_CASE_TEMPLATE("degenerate_triangles: finds triangles whose normal is lost in rounding", S,
                   float, double) {
  const std::uint64_t seed = 5;
  CAPTURE(seed);
  Random random(seed);
  for (int i = 0; i < 200; ++i) {
    const Vec3<S> a = random.in_cube(S(1));
    const Vec3<S> b = random.in_cube(S(1));
    const S scale = S(1) / (S(1) + random.uniform(S(0), S(1000)));
    // On the line through a and b up to the rounding of its coordinates.
    const Vec3<S> on_line = a + random.uniform(S(-1), S(2)) * (b - a);
    TriangleMesh<S> mesh{{scale * a, scale * b, scale * on_line}, {{0, 1, 2}}};
    CHECK(degenerate_triangles(mesh).size() == 1);
    // A height of 1e-3 of the edge is thin, but has a normal.
    const Vec3<S> aside = (b - a).cross(random.direction<S>());
    mesh.vertices[2] = scale * (S(0.5) * (a + b) + S(1e-3) * (b - a).norm() * aside.normalized());
    if ((b - a).norm() > S(0.1)) CHECK(degenerate_triangles(mesh).empty());
  }
  const TriangleMesh<S> point{{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}, {{0, 1, 2}}};
  CHECK(degenerate_triangles(point).size() == 1);
  const TriangleMesh<S> origin{{{0, 0, 0}}, {{0, 0, 0}}};
  CHECK(degenerate_triangles(origin).size() == 1);
}

TEST_CASE_TEMPLATE("validate_surface: names what is wrong and where", S, float, double) {
  CHECK(contains(surface_error(TriangleMesh<S>{}), "at least one triangle"));
  TriangleMesh<S> mesh = cube<S>();
  mesh.triangles[3][1] = 8;
  CHECK(contains(surface_error(mesh), "TriangleMesh::triangles[3]"));
  CHECK(contains(surface_error(mesh), "below 8"));
  for (const S bad : {std::numeric_limits<S>::quiet_NaN(), infinity<S>}) {
    mesh = cube<S>();
    mesh.vertices[5].z() = bad;
    CHECK(contains(surface_error(mesh), "TriangleMesh::vertices[5]"));
    CHECK(contains(solid_error(mesh), "must be finite"));
  }
}

TEST_CASE("validate_solid: takes well under a second for 100 000 triangles") {
  const TriangleMesh<double> mesh = sphere_mesh(1.0, 71);
  REQUIRE(mesh.triangles.size() > 100000);
  const auto start = std::chrono::steady_clock::now();
  validate_solid(mesh);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
  // 0.1 s optimised; the bound leaves room for sanitizers and busy machines, not for O(n^2).
  CHECK(elapsed.count() < 5.0);
}
