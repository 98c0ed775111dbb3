/// @file
/// Tests of the triangles that shapes are drawn with.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/geometry/meshes/drawn_mesh.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/geometry/shapes/shape_properties.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

using namespace bristle;

TEST_CASE_TEMPLATE("drawn_mesh: closed, facing outwards, and as large as the shape", S, float,
                   double) {
  const std::vector<Vec3<S>> points{{S(0), S(0), S(0)}, {S(1), S(0), S(0)}, {S(0), S(1), S(0)},
                                    {S(0), S(0), S(1)}, {S(1), S(1), S(1)}, {S(1), S(1), S(0)}};
  for (const Shape<S>& shape :
       {Shape<S>(Sphere<S>{S(0.3)}), Shape<S>(Box<S>{{S(0.1), S(0.2), S(0.3)}}),
        Shape<S>(Capsule<S>{S(0.1), S(0.2)}), Shape<S>(Cylinder<S>{S(0.1), S(0.2)}),
        Shape<S>(Cone<S>{S(0.1), S(0.2)}), Shape<S>(Ellipsoid<S>{{S(0.1), S(0.2), S(0.3)}}),
        Shape<S>(convex_hull<S>(points)), Shape<S>(sphere_mesh<S>(S(0.2), 3))}) {
    CAPTURE(std::string(name_of(kind_of(shape))));
    const TriangleMesh<S> mesh = drawn_mesh(shape);
    CHECK_NOTHROW(validate_solid(mesh));
    // Of a polygon of 32 corners in a circle 0.64 % of the area are missing, of an icosahedron
    // whose edges have six parts 2.4 % of a sphere's volume.
    const S volume = unit_mass_properties(shape).mass;
    const S drawn = unit_mass_properties(Shape<S>(mesh)).mass;
    CHECK(drawn <= volume * S(1.00001));
    CHECK(drawn >= volume * S(0.97));
  }
}

TEST_CASE("drawn_mesh: middles of a sphere's triangles lie 1 % of the radius below it at most") {
  const TriangleMesh<double> mesh = drawn_mesh<double>(Sphere<double>{2});
  for (const auto& t : mesh.triangles) {
    const Vec3<double> middle =
        (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
    CHECK(middle.norm() > 0.99 * 2);
  }
}

TEST_CASE("drawn_mesh: middles of a capsule's triangles lie 1 % of the radius below it at most") {
  const TriangleMesh<double> mesh = drawn_mesh<double>(Capsule<double>{2, 3});
  for (const auto& t : mesh.triangles) {
    const Vec3<double> middle =
        (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
    const double z = std::max(0.0, std::abs(middle.z()) - 3);
    CHECK(std::hypot(middle.x(), middle.y(), z) > 0.99 * 2);
  }
}

TEST_CASE("drawn_mesh: a half-space is a square in its plane that faces outwards") {
  const Vec3<double> normal = Vec3<double>(1, -2, 2) / 3;
  const TriangleMesh<double> mesh = drawn_mesh<double>(HalfSpace<double>{normal, 0.7}, 3.0);
  for (const Vec3<double>& v : mesh.vertices) CHECK(std::abs(normal.dot(v) - 0.7) < 1e-15);
  Vec3<double> area = Vec3<double>::Zero();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) area += area_vector(mesh, i) / 2;
  CHECK((area - 9 * normal).norm() < 1e-13);
}

TEST_CASE("drawn_mesh: what is no shape has no triangles") {
  CHECK_THROWS_AS((void)drawn_mesh<double>(Sphere<double>{-1}), InvalidArgument);
  CHECK_THROWS_WITH_AS((void)drawn_mesh<double>(HalfSpace<double>{}, 0.0),
                       doctest::Contains("plane_size"), InvalidArgument);
}
