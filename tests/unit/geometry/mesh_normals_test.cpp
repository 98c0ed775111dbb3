// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/geometry/meshes/mesh_normals.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE_TEMPLATE("face_normals: one a triangle, zero where there is none", S, float, double) {
  const TriangleMesh<S> box = box_mesh<S>({1, 2, 3});
  const std::vector<std::uint32_t> none{4, 7};
  const DynamicArray<Vec3<S>> normals = face_normals<S>(box, none);
  REQUIRE(normals.size() == 12);
  for (std::size_t t = 0; t < 12; ++t) {
    const bool has_none = t == 4 || t == 7;
    CHECK(normals[t] == (has_none ? Vec3<S>(Vec3<S>::Zero()) : triangle_normal(box, t)));
  }
}

TEST_CASE_TEMPLATE("vertex_normals: weights by angle make a box's corners look along its diagonals",
                   S, float, double) {
  const TriangleMesh<S> box = box_mesh<S>({1, 2, 3});
  const DynamicArray<NormalSum<S>> sums = vertex_normals<S>(box, face_normals<S>(box, {}));
  REQUIRE(sums.size() == 8);
  for (std::size_t v = 0; v < 8; ++v) {
    CHECK(sums[v].has_direction());
    // Three right angles, however many triangles share them.
    CHECK(sums[v].weight == test::relative(1.5 * std::numbers::pi));
    const Vec3<S> sign = box.vertices[v].cwiseQuotient(Vec3<S>(1, 2, 3));
    CHECK((sums[v].sum.normalized() - sign.normalized()).norm() <=
          S(8) * Tolerance<S>::round_off());
  }
}

TEST_CASE("vertex_normals: faces that cancel and faces without a normal leave no direction") {
  // Both sides of one sheet, a degenerate triangle on a vertex of its own.
  const TriangleMesh<double> mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}},
                                  {{0, 1, 2}, {0, 2, 1}, {3, 3, 0}}};
  const std::vector<std::uint32_t> degenerate{2};
  const DynamicArray<NormalSum<double>> sums =
      vertex_normals<double>(mesh, face_normals<double>(mesh, degenerate));
  for (std::size_t v = 0; v < 3; ++v) {
    CHECK(sums[v].weight > 0);
    CHECK(!sums[v].has_direction());
  }
  CHECK(sums[3].weight == 0);
  CHECK(!sums[3].has_direction());
}
