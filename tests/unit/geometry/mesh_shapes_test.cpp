// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;
using namespace bristle::detail;

TEST_CASE_TEMPLATE("box_mesh: is a solid with the box's volume and ordered faces", S, float,
                   double) {
  const TriangleMesh<S> mesh = box_mesh<S>({1, 2, 3});
  CHECK_NOTHROW(validate_solid(mesh));
  CHECK(signed_volume(mesh) == test::relative(48.0));
  REQUIRE(mesh.triangles.size() == 12);
  for (std::size_t t = 0; t < 12; ++t) {
    Vec3<S> expected = Vec3<S>::Zero();
    expected[static_cast<int>(t / 4)] = t % 4 < 2 ? S(-1) : S(1);
    CHECK(triangle_normal(mesh, t) == expected);
  }
}

TEST_CASE_TEMPLATE("sphere_mesh: has 10 f^2 + 2 vertices, all on the sphere", S, float, double) {
  for (const std::uint32_t f : {1u, 2u, 5u, 20u}) {
    const TriangleMesh<S> mesh = sphere_mesh(S(0.25), f);
    CHECK(mesh.vertices.size() == 10 * f * f + 2);
    CHECK(mesh.triangles.size() == 20 * f * f);
    CHECK_NOTHROW(validate_solid(mesh));
    for (const auto& v : mesh.vertices) {
      CHECK(std::abs(v.norm() - S(0.25)) <= Tolerance<S>::round_off());
    }
  }
  // Edges of 2 pi / (5 f) leave gaps of the order of their squares: 0.4 % at f = 20.
  CHECK(signed_volume(sphere_mesh(S(1), 20)) ==
        test::relative(4.0 / 3.0 * std::numbers::pi).epsilon(0.005));
}

TEST_CASE_TEMPLATE("cylinder_mesh: has the volume of its prism", S, float, double) {
  const TriangleMesh<S> mesh = cylinder_mesh<S>({.radius = S(2), .half_length = S(1.5)}, 12);
  CHECK_NOTHROW(validate_solid(mesh));
  CHECK(mesh.triangles.size() == 48);
  // Area of a regular n-gon: n / 2 r^2 sin(2 pi / n) = 6 * 4 * 0.5.
  CHECK(signed_volume(mesh) == test::relative(12.0 * 3.0));
}

TEST_CASE_TEMPLATE("grid_mesh: covers its rectangle once, facing up", S, float, double) {
  const TriangleMesh<S> mesh = grid_mesh<S>({3, 2}, {6, 5});
  CHECK_NOTHROW(validate_surface(mesh));
  CHECK(mesh.vertices.size() == 42);
  REQUIRE(mesh.triangles.size() == 60);
  S area = S(0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    area += triangle_area(mesh, t);
    CHECK((triangle_normal(mesh, t) - Vec3<S>::UnitZ()).norm() <= Tolerance<S>::round_off());
  }
  CHECK(area == test::relative(6.0));
  CHECK(mesh_bounds(mesh).lower == Vec3<S>(S(-1.5), -1, 0));
  CHECK(mesh_bounds(mesh).upper == Vec3<S>(S(1.5), 1, 0));
}

TEST_CASE_TEMPLATE("mesh generators: refuse sizes and counts that make no mesh", S, float, double) {
  CHECK_THROWS_AS((void)box_mesh<S>({1, 0, 1}), InvalidArgument);
  CHECK_THROWS_AS((void)sphere_mesh(S(-1), 2), InvalidArgument);
  CHECK_THROWS_AS((void)sphere_mesh(S(1), 0), InvalidArgument);
  CHECK_THROWS_AS((void)cylinder_mesh<S>({S(1), S(1)}, 2), InvalidArgument);
  CHECK_THROWS_AS((void)cylinder_mesh<S>({S(1), S(0)}, 8), InvalidArgument);
  CHECK_THROWS_AS((void)grid_mesh<S>({1, 0}, {1, 1}), InvalidArgument);
  CHECK_THROWS_AS((void)grid_mesh<S>({1, 1}, {0, 1}), InvalidArgument);
  CHECK_THROWS_AS((void)grid_mesh<S>({1, 1}, {1, 0}), InvalidArgument);
}

TEST_CASE("mesh_shapes: more vertices than 32 bits can number are refused by field") {
  constexpr std::uint32_t all = 0xffffffffu;
  CHECK_THROWS_WITH_AS((void)grid_mesh<double>({1, 1}, {all, 1}),
                       doctest::Contains("grid_mesh: cells[0]"), InvalidArgument);
  CHECK_THROWS_WITH_AS((void)grid_mesh<double>({1, 1}, {1u << 15, 1u << 17}),
                       doctest::Contains("grid_mesh: cells[1]"), InvalidArgument);
  CHECK_THROWS_WITH_AS((void)sphere_mesh<double>(1, all),
                       doctest::Contains("sphere_mesh: frequency"), InvalidArgument);
  CHECK_THROWS_WITH_AS((void)cylinder_mesh<double>({1, 1}, all),
                       doctest::Contains("cylinder_mesh: segments"), InvalidArgument);
}
