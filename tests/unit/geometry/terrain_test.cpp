// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/meshes/terrain.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using bristle::test::Random;

namespace {

/// The message of the refusal of an extrusion. Empty if it is none.
template <Scalar S>
std::string refusal_of_extrusion(const TriangleMesh<S>& surface, const Vec3<S>& offset) {
  try {
    (void)extruded_mesh<S>(surface, offset);
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "";
}

bool is_told(const std::string& message, const std::string& part) {
  return message.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE_TEMPLATE("height_field_mesh: has each height at its place, row by row, and faces up", S,
                   float, double) {
  // z = 1 + 2 x + 3 y over 4 by 2 cells of 0.5 m by 0.25 m.
  std::vector<S> heights;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 5; ++i) {
      heights.push_back(S(1) + S(2) * (S(0.5) * S(i) - S(1)) + S(3) * (S(0.25) * S(j) - S(0.25)));
    }
  }
  const TriangleMesh<S> mesh = height_field_mesh<S>({2, S(0.5)}, {4, 2}, heights);
  CHECK_NOTHROW(validate_surface(mesh));
  REQUIRE(mesh.vertices.size() == 15);
  CHECK(mesh.triangles.size() == 16);
  for (const Vec3<S>& v : mesh.vertices) {
    CHECK(v.z() == test::relative(S(1) + S(2) * v.x() + S(3) * v.y()).epsilon(1e-6));
  }
  CHECK(mesh.vertices[1] == Vec3<S>(S(-0.5), S(-0.25), heights[1]));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) CHECK(area_vector(mesh, t).z() > S(0));
}

TEST_CASE_TEMPLATE("height_field_mesh: refuses heights that are not one for each corner, or none",
                   S, float, double) {
  std::vector<S> heights(12, S(0));
  CHECK_NOTHROW((void)height_field_mesh<S>({1, 1}, {3, 2}, heights));
  CHECK_THROWS_AS((void)height_field_mesh<S>({1, 1}, {2, 2}, heights), InvalidArgument);
  CHECK_THROWS_AS((void)height_field_mesh<S>({1, 0}, {3, 2}, heights), InvalidArgument);
  CHECK_THROWS_AS((void)height_field_mesh<S>({1, 1}, {0, 11}, heights), InvalidArgument);
  heights[7] = std::numeric_limits<S>::quiet_NaN();
  try {
    (void)height_field_mesh<S>({1, 1}, {3, 2}, heights);
    FAIL("a height that is no number was taken");
  } catch (const InvalidArgument& error) {
    CHECK(is_told(error.what(), "heights[7]"));
  }
}

TEST_CASE_TEMPLATE("extruded_mesh: is a solid of area seen along the offset times its length", S,
                   float, double) {
  Random random(4);
  const double tolerance = 100 * static_cast<double>(Tolerance<S>::round_off());
  for (int round = 0; round < 20; ++round) {
    std::vector<S> heights;
    for (int i = 0; i < 7 * 5; ++i) heights.push_back(random.uniform(S(-0.05), S(0.05)));
    const TriangleMesh<S> surface = height_field_mesh<S>({3, 2}, {6, 4}, heights);
    const Vec3<S> offset(random.uniform(S(-0.2), S(0.2)), random.uniform(S(-0.2), S(0.2)), S(-0.5));
    Vec3<S> area = Vec3<S>::Zero();
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      area += area_vector(surface, t) / S(2);
    }
    CHECK(area.z() == test::relative(6.0).epsilon(tolerance));
    const TriangleMesh<S> solid = extruded_mesh<S>(surface, offset);
    CHECK_NOTHROW(validate_solid(solid));
    CHECK(signed_volume(solid) == test::relative(-area.dot(offset)).epsilon(tolerance));
    // The surface stays in front, the copy is below, and a wall is two triangles of a border edge.
    CHECK(solid.triangles.size() == 2 * surface.triangles.size() + 2 * 2 * (6 + 4));
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      CHECK(solid.triangles[t] == surface.triangles[t]);
    }
    for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
      CHECK(solid.vertices[v] == surface.vertices[v]);
      CHECK(solid.vertices[surface.vertices.size() + v] == Vec3<S>(surface.vertices[v] + offset));
    }
  }
}

TEST_CASE_TEMPLATE("extruded_mesh: walls go around holes, and around each of several pieces", S,
                   float, double) {
  // 5 by 5 cells of 1 m2 without the one in the middle and one at a corner.
  TriangleMesh<S> surface = grid_mesh<S>({5, 5}, {5, 5});
  const std::vector<std::uint32_t> gone{0, 1, 24, 25};
  surface = without_triangles<S>(surface, gone);
  // Another piece, elsewhere.
  const TriangleMesh<S> island = grid_mesh<S>({1, 2}, {1, 1});
  const auto first = static_cast<std::uint32_t>(surface.vertices.size());
  for (const Vec3<S>& v : island.vertices) surface.vertices.push_back(v + Vec3<S>(9, 0, 1));
  for (const auto& t : island.triangles) {
    surface.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  const TriangleMesh<S> solid = extruded_mesh<S>(surface, {0, 0, S(-2)});
  CHECK_NOTHROW(validate_solid(solid));
  CHECK(signed_volume(solid) == test::relative((23.0 + 2.0) * 2.0));
}

TEST_CASE_TEMPLATE("extruded_mesh: refuses what encloses no ground, and names the place", S, float,
                   double) {
  const TriangleMesh<S> flat = grid_mesh<S>({1, 1}, {2, 2});
  CHECK(is_told(refusal_of_extrusion<S>(flat, {0, 0, S(1)}), "triangles[0]"));
  CHECK(is_told(refusal_of_extrusion<S>(flat, {S(1), 0, 0}), "must face against the offset"));
  CHECK(is_told(refusal_of_extrusion<S>(flat, {0, 0, 0}), "must not be 0"));
  CHECK(is_told(refusal_of_extrusion<S>(flat, {0, 0, -infinity<S>}), "offset"));
  // All around there is no side that all triangles face.
  CHECK(is_told(refusal_of_extrusion<S>(box_mesh<S>({1, 1, 1}), {0, 0, S(-1)}), "offset"));

  TriangleMesh<S> turned = flat;
  std::swap(turned.triangles[5][0], turned.triangles[5][1]);
  CHECK(is_told(refusal_of_extrusion<S>(turned, {0, 0, S(-1)}), "triangles[5]"));

  TriangleMesh<S> doubled = flat;
  doubled.triangles.push_back(doubled.triangles[3]);
  CHECK(is_told(refusal_of_extrusion<S>(doubled, {0, 0, S(-1)}), "edge ("));

  // Two squares that share nothing but a corner: the walls under it would meet.
  const std::vector<std::uint32_t> others{2, 3, 4, 5};
  const TriangleMesh<S> pinched = without_triangles<S>(flat, others);
  CHECK(is_told(refusal_of_extrusion<S>(pinched, {0, 0, S(-1)}), "vertex 4"));

  TriangleMesh<S> missing = flat;
  missing.triangles[1][2] = 99;
  CHECK(is_told(refusal_of_extrusion<S>(missing, {0, 0, S(-1)}), "triangles[1]"));
  CHECK(is_told(refusal_of_extrusion<S>(TriangleMesh<S>{}, {0, 0, S(-1)}), "triangles.size()"));
}
