// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/mesh_surface.hpp>
#include <bristle/geometry/mesh_tree.hpp>
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

using namespace bristle;

namespace {

/// A closed lens of `n` segments: two poles, and rings at a quarter, a half and three quarters of the
/// way between them. So flat (1 : 1000) that each side counts as one face.
TriangleMesh<double> lens(std::uint32_t n, double radius) {
  TriangleMesh<double> mesh;
  mesh.vertices.push_back({0, 0, 1e-3 * radius});
  for (int ring = 1; ring <= 3; ++ring) {
    const double v = std::numbers::pi * ring / 4;
    for (std::uint32_t i = 0; i < n; ++i) {
      const double u = 2 * std::numbers::pi * i / n;
      mesh.vertices.push_back(radius * Vec3<double>(std::sin(v) * std::cos(u),
                                                    std::sin(v) * std::sin(u),
                                                    1e-3 * std::cos(v)));
    }
  }
  mesh.vertices.push_back({0, 0, -1e-3 * radius});
  const std::uint32_t last = 3 * n + 1;
  const auto at = [n](std::uint32_t ring, std::uint32_t i) { return 1 + ring * n + i % n; };
  for (std::uint32_t i = 0; i < n; ++i) {
    mesh.triangles.push_back({0, at(0, i), at(0, i + 1)});
    for (std::uint32_t ring = 0; ring < 2; ++ring) {
      mesh.triangles.push_back({at(ring, i), at(ring + 1, i), at(ring, i + 1)});
      mesh.triangles.push_back({at(ring, i + 1), at(ring + 1, i), at(ring + 1, i + 1)});
    }
    mesh.triangles.push_back({last, at(2, i + 1), at(2, i)});
  }
  return mesh;
}

}  // namespace

// Built with and without fused multiply-adds (tests/CMakeLists.txt): an order of corners by numbers
// that are computed at each comparison is none where the compiler contracts one of them, and
// std::sort leaves its range.
TEST_CASE("MeshSurface: outlines of flat faces go around, whatever the rounding of the compiler") {
  for (int exponent = -3; exponent <= 3; ++exponent) {
    for (const std::uint32_t n : {64u, 200u, 201u}) {
      const MeshTree<double> tree(lens(n, std::pow(10.0, exponent)));
      const MeshSurface<double, MeshTree<double>> surface(tree);
      for (std::uint32_t t = 0; t < surface.size(); ++t) {
        const ConvexHull<double>& face = surface.face(t);
        const Vec3<double>& up = face.face_normals[0];
        const std::size_t count = face.vertices.size();
        REQUIRE(count >= 3);
        REQUIRE(face.face_normals.size() == count + 1);
        // Each corner turns left, and all of them together turn once.
        double turned = 0;
        for (std::size_t k = 0; k < count; ++k) {
          const Vec3<double> a = face.vertices[(k + 1) % count] - face.vertices[k];
          const Vec3<double> b = face.vertices[(k + 2) % count] - face.vertices[(k + 1) % count];
          const double left = a.cross(b).dot(up);
          REQUIRE(left > -1e-12 * a.norm() * b.norm());
          turned += std::atan2(left, a.dot(b));
        }
        // Out of the plane by a thousandth, which is what `flat` allows.
        REQUIRE(turned == doctest::Approx(2 * std::numbers::pi).epsilon(1e-3));
        if (t > 2 * n) break;  // Others have the same faces.
      }
    }
  }
}
