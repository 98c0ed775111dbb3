// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/sensors/patch_mesh.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace bristle;
using namespace bristle::detail;

namespace {

template <typename S>
constexpr S near_zero_of_rays = S(16) * Tolerance<S>::round_off();

/// Returns whether triangles face the way of their vertices' normals.
template <typename S>
bool looks_outwards(const PatchMesh<S>& patch) {
  for (std::size_t t = 0; t < patch.mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : patch.mesh.triangles[t]) {
      if (!(triangle_normal(patch.mesh, t).dot(patch.normals[v]) > S(0))) return false;
    }
  }
  return true;
}

template <typename S>
S area(const PatchMesh<S>& patch) {
  S sum = S(0);
  for (std::size_t t = 0; t < patch.mesh.triangles.size(); ++t) sum += triangle_area(patch.mesh, t);
  return sum;
}

}  // namespace

TEST_CASE_TEMPLATE("plane_patch: a grid that faces up", S, float, double) {
  const PatchMesh<S> patch = plane_patch<S>({S(0.2), S(0.1)}, {4, 3});
  CHECK(patch.mesh.vertices.size() == 20);
  CHECK(patch.normals.size() == 20);
  CHECK(looks_outwards(patch));
  CHECK(area(patch) == test::relative(0.02));
}

TEST_CASE_TEMPLATE("cylinder_patch: an open strip lies on its cylinder, about +z", S, float,
                   double) {
  const S r = S(0.3);
  const S arc = S(std::numbers::pi / 2);
  const PatchMesh<S> patch =
      cylinder_patch<S>({.radius = r, .length = S(0.4), .arc = arc, .cells = {6, 2}});
  REQUIRE(patch.mesh.vertices.size() == 7 * 3);
  CHECK(patch.mesh.triangles.size() == 2 * 6 * 2);
  CHECK(looks_outwards(patch));
  for (std::size_t v = 0; v < patch.mesh.vertices.size(); ++v) {
    const Vec3<S>& p = patch.mesh.vertices[v];
    CHECK(std::abs(std::hypot(p.x(), p.z()) - r) <= near_zero_of_rays<S>);
    CHECK(std::abs(p.y()) <= S(0.2) + near_zero_of_rays<S>);
    CHECK(std::abs(std::atan2(p.x(), p.z())) <= arc / S(2) + near_zero_of_rays<S>);
    CHECK((r * patch.normals[v] - Vec3<S>(p.x(), 0, p.z())).norm() <= near_zero_of_rays<S>);
  }
  // Six chords of 15 degrees, 0.4 m long.
  const double chord = 2 * 0.3 * std::sin(std::numbers::pi / 24);
  CHECK(area(patch) == test::relative(6 * chord * 0.4));
}

TEST_CASE_TEMPLATE("cylinder_patch: a closed wall has no seam", S, float, double) {
  const PatchMesh<S> patch =
      cylinder_patch<S>({.radius = S(0.3), .length = S(0.4), .cells = {12, 1}});
  CHECK(patch.mesh.vertices.size() == 24);
  CHECK(patch.mesh.triangles.size() == 24);
  CHECK(looks_outwards(patch));
  // With its two ends closed it would be a solid: every edge but those of the rims is shared.
  TriangleMesh<S> solid = patch.mesh;
  for (std::uint32_t i = 1; i + 1 < 12; ++i) {
    // Columns follow one another along x; row 0 is at -y, row 1 at +y.
    solid.triangles.push_back({0, i + 1, i});
    solid.triangles.push_back({12, 12 + i, 12 + i + 1});
  }
  CHECK_NOTHROW(validate_solid(solid));
}

TEST_CASE_TEMPLATE("half_sphere_patch: rings from the pole to the rim", S, float, double) {
  const PatchMesh<S> patch = half_sphere_patch<S>(S(0.3), 4, 8);
  REQUIRE(patch.mesh.vertices.size() == 1 + 4 * 8);
  CHECK(patch.mesh.triangles.size() == 8 + 2 * 8 * 3);
  CHECK(looks_outwards(patch));
  for (std::size_t v = 0; v < patch.mesh.vertices.size(); ++v) {
    CHECK(patch.normals[v].norm() == test::relative(1.0));
    CHECK((S(0.3) * patch.normals[v] - patch.mesh.vertices[v]).norm() <= near_zero_of_rays<S>);
    CHECK(patch.mesh.vertices[v].z() >= S(0));
  }
  for (std::size_t v = 25; v < 33; ++v) CHECK(patch.mesh.vertices[v].z() == S(0));
  const S fine = area(half_sphere_patch<S>(S(0.3), 32, 64));
  CHECK(fine == test::relative(2 * std::numbers::pi * 0.09).epsilon(2e-3));
}

TEST_CASE_TEMPLATE("patch_from_mesh: joins seams and takes the mean normals of the faces", S, float,
                   double) {
  // Two sides of a roof of 90 degrees that repeat the vertices of their ridge.
  const TriangleMesh<S> roof{
      {{-1, 0, -1}, {0, -1, 0}, {0, 1, 0}, {1, 0, -1}, {0, 1, 0}, {0, -1, 0}},
      {{0, 1, 2}, {3, 4, 5}}};
  const PatchMesh<S> patch = patch_from_mesh(roof);
  REQUIRE(patch.mesh.vertices.size() == 4);
  CHECK((patch.normals[1] - Vec3<S>::UnitZ()).norm() <= near_zero_of_rays<S>);
  CHECK((patch.normals[2] - Vec3<S>::UnitZ()).norm() <= near_zero_of_rays<S>);
  const S half = std::sqrt(S(0.5));
  CHECK((patch.normals[0] - Vec3<S>(-half, 0, half)).norm() <= near_zero_of_rays<S>);
  // Both sides of one sheet leave no direction.
  const TriangleMesh<S> sheet{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}};
  for (const Vec3<S>& n : patch_from_mesh(sheet).normals) CHECK(n == Vec3<S>::Zero());
}

TEST_CASE("patches: refuse what makes no surface") {
  CHECK_THROWS_AS((void)plane_patch<double>({0, 1}, {1, 1}), InvalidArgument);
  CHECK_THROWS_AS((void)cylinder_patch<double>({.radius = -1}), InvalidArgument);
  CHECK_THROWS_AS((void)cylinder_patch<double>({.length = 0}), InvalidArgument);
  CHECK_THROWS_AS((void)cylinder_patch<double>({.arc = 6.3}), InvalidArgument);
  CHECK_THROWS_AS((void)cylinder_patch<double>({.cells = {2, 1}}), InvalidArgument);
  CHECK_NOTHROW((void)cylinder_patch<double>({.arc = 1, .cells = {1, 1}}));
  CHECK_THROWS_AS((void)half_sphere_patch<double>(1, 0, 8), InvalidArgument);
  CHECK_THROWS_AS((void)half_sphere_patch<double>(1, 1, 2), InvalidArgument);
  CHECK_THROWS_AS((void)patch_from_mesh(TriangleMesh<double>{}), InvalidArgument);
}

TEST_CASE("half_sphere_patch: more vertices than 32 bits can number are refused") {
  CHECK_THROWS_WITH_AS((void)half_sphere_patch<double>(1, 0xffffffffu, 3),
                       doctest::Contains("half_sphere_patch: rings"), InvalidArgument);
}
