// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/geometry/meshes/mesh_surface.hpp>
#include <bristle/geometry/meshes/mesh_tree.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <support/random.hpp>
#include <type_traits>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

/// A closed lens of `n` segments: two poles, and rings at a quarter, a half and three quarters of
/// the way between them. So flat (1 : 1000) that each side counts as one face.
TriangleMesh<double> lens(std::uint32_t n, double radius) {
  TriangleMesh<double> mesh;
  mesh.vertices.push_back({0, 0, 1e-3 * radius});
  for (int ring = 1; ring <= 3; ++ring) {
    const double v = std::numbers::pi * ring / 4;
    for (std::uint32_t i = 0; i < n; ++i) {
      const double u = 2 * std::numbers::pi * i / n;
      mesh.vertices.push_back(radius * Vec3<double>(std::sin(v) * std::cos(u),
                                                    std::sin(v) * std::sin(u), 1e-3 * std::cos(v)));
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

/// A closed disc about z whose caps are fans of `segments` triangles: no point of a cap is its
/// middle, so that the outline has every corner.
template <Scalar S>
TriangleMesh<S> disc_mesh(std::uint32_t segments, S radius, S thickness) {
  TriangleMesh<S> mesh;
  for (std::uint32_t i = 0; i < segments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / segments;
    for (const S z : {thickness / S(2), -thickness / S(2)}) {
      mesh.vertices.push_back({radius * S(std::cos(angle)), radius * S(std::sin(angle)), z});
    }
  }
  const auto top = [&](std::uint32_t i) { return 2 * (i % segments); };
  const auto bottom = [&](std::uint32_t i) { return top(i) + 1; };
  for (std::uint32_t i = 0; i < segments; ++i) {
    mesh.triangles.push_back({bottom(i), bottom(i + 1), top(i)});
    mesh.triangles.push_back({top(i), bottom(i + 1), top(i + 1)});
    if (i == 0 || i + 1 == segments) continue;
    mesh.triangles.push_back({top(0), top(i), top(i + 1)});
    mesh.triangles.push_back({bottom(0), bottom(i + 1), bottom(i)});
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
        REQUIRE(turned == test::relative(2 * std::numbers::pi).epsilon(1e-3));
        if (t > 2 * n) break;  // Others have the same faces.
      }
    }
  }
}

// Of a regular polygon no three corners are on a line: the outline has all of them. Where corners
// have the same coordinate but for round-off, as pairs across an axis have, an order that is
// computed anew for each comparison contradicts itself as soon as products and sums are fused in
// one copy of it and not in another.
TEST_CASE_TEMPLATE(
    "MeshSurface: the caps of a disc have all its corners, at every size and attitude", S, float,
    double) {
  Random random(7);
  // The needles of a fan of more are turned by round-off in float, by more than a flat face bears.
  const std::uint32_t most = std::is_same_v<S, float> ? 100 : 200;
  for (const std::uint32_t segments : {8u, 16u, 50u, 100u, 200u}) {
    if (segments > most) continue;
    for (int round = 0; round < 42; ++round) {
      const S radius = S(std::pow(10.0, round % 7 - 3));
      TriangleMesh<S> mesh = disc_mesh<S>(segments, radius, S(0.02) * radius);
      const bool is_turned = round >= 21;
      const Quat<S> turn = is_turned ? random.template rotation<S>() : Quat<S>(1, 0, 0, 0);
      for (Vec3<S>& v : mesh.vertices) v = turn * v;
      CAPTURE(segments);
      CAPTURE(round);
      const MeshTree<S> tree(mesh);
      const MeshSurface<Precise<S>, MeshTree<S>> surface(tree);
      for (std::uint32_t i = 0; i < surface.size(); ++i) {
        const ConvexHull<Precise<S>>& face = surface.face(i);
        const bool is_cap =
            std::abs(surface.normal(i).dot((turn * Vec3<S>::UnitZ()).template cast<Precise<S>>())) >
            Precise<S>(0.5);
        CHECK(face.vertices.size() == (is_cap ? segments : 4));
        // The face's own normal, and one for each edge.
        CHECK(face.face_normals.size() == face.vertices.size() + 1);
      }
    }
  }
}
