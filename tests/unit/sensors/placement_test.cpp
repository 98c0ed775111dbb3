// SPDX-License-Identifier: BSD-3-Clause
#include "support/relative.hpp"
#include "support/texts.hpp"

#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/sensors/placement.hpp>

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <support/random.hpp>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using bristle::test::contains;
using bristle::test::error_of;
using bristle::test::Random;

namespace {

template <typename S>
constexpr S near_zero_of_placement = S(4) * Tolerance<S>::round_off();

/// Where the ray of a sensor crosses the surface it was placed on.
template <typename S>
Vec3<S> surface_point(const SensorLayout<S>& layout, std::size_t i, S depth) {
  return layout.start[i] + depth * layout.direction[i];
}

template <typename S>
std::string placement_error(const TriangleMesh<S>& mesh, const PlacementDef<S>& def) {
  return error_of([&] { (void)sensors_from_mesh(mesh, def); });
}

}  // namespace

TEST_CASE_TEMPLATE("sensors_from_mesh: puts one sensor on each face, as in Algorithm 2", S, float,
                   double) {
  const TriangleMesh<S> mesh{{{0, 0, 0}, {3, 0, 0}, {0, 3, 0}}, {{0, 1, 2}}};
  const SensorLayout<S> layout = sensors_from_mesh<S>(mesh, {.depth = S(0.5), .range = S(1.25)});
  layout.validate();
  REQUIRE(layout.size() == 1);
  // Midpoint (1, 1, 0): the mean of the corners, not their sum (3, 3, 0).
  CHECK((layout.start[0] - Vec3<S>(1, 1, S(-0.5))).norm() <= near_zero_of_placement<S>);
  CHECK((layout.direction[0] - Vec3<S>(0, 0, 1)).norm() <= near_zero_of_placement<S>);
  CHECK(layout.length[0] == S(1.25));
}

TEST_CASE_TEMPLATE("sensors_from_mesh: faces of a cube, in the order of its triangles", S, float,
                   double) {
  const TriangleMesh<S> mesh = box_mesh<S>({S(0.3), S(0.3), S(0.3)});
  PlacementReport report;
  const SensorLayout<S> layout =
      sensors_from_mesh<S>(mesh, {.depth = S(0.1), .range = S(0.25)}, &report);
  layout.validate();
  REQUIRE(layout.size() == 12);
  CHECK(report.face_sensors == 12);
  CHECK(report.vertex_sensors == 0);
  CHECK(report.edge_sensors == 0);
  for (std::size_t i = 0; i < 12; ++i) {
    CHECK((surface_point(layout, i, S(0.1)) - triangle_centroid(mesh, i)).norm() <=
          near_zero_of_placement<S>);
    // The start is 0.1 below the face, the end 0.15 above it.
    CHECK(layout.start[i].cwiseAbs().maxCoeff() == test::relative(0.2));
    const Vec3<S> end = layout.start[i] + layout.length[i] * layout.direction[i];
    CHECK(end.cwiseAbs().maxCoeff() == test::relative(0.45));
  }
}

TEST_CASE_TEMPLATE("sensors_from_mesh: corners and edges of a cube look along their bisectors", S,
                   float, double) {
  const S h = S(0.3);
  PlacementReport report;
  const SensorLayout<S> layout = sensors_from_mesh<S>(
      box_mesh<S>({h, h, h}),
      {.depth = S(0.1), .range = S(0.2), .faces = false, .vertices = true, .edges = true}, &report);
  layout.validate();
  CHECK(report.face_sensors == 0);
  CHECK(report.vertex_sensors == 8);
  // The cube's 12 edges and one diagonal on each of its faces.
  CHECK(report.edge_sensors == 18);
  REQUIRE(layout.size() == 26);
  const S third = S(1) / std::sqrt(S(3));
  for (std::size_t i = 0; i < 8; ++i) {
    // Weights by angle make the diagonal exact, however the faces are cut into triangles.
    const Vec3<S> corner = surface_point(layout, i, S(0.1));
    CHECK((corner - box_mesh<S>({h, h, h}).vertices[i]).norm() <= near_zero_of_placement<S>);
    CHECK((layout.direction[i] - third / h * corner).norm() <= near_zero_of_placement<S>);
  }
  int on_faces = 0;
  for (std::size_t i = 8; i < 26; ++i) {
    // Middles of edges have two coordinates at h, middles of faces one; the normals are parallel.
    const Vec3<S> middle = surface_point(layout, i, S(0.1));
    CHECK((layout.direction[i] - middle.normalized()).norm() <= S(4) * near_zero_of_placement<S>);
    if (std::abs(middle.norm() - h) <= near_zero_of_placement<S>) ++on_faces;
  }
  CHECK(on_faces == 6);
}

TEST_CASE_TEMPLATE("sensors_from_mesh: on a flat grid all look up, in documented order", S, float,
                   double) {
  const TriangleMesh<S> mesh = grid_mesh<S>({S(0.2), S(0.1)}, {4, 3});
  const S depth = S(0.005);
  PlacementReport report;
  const SensorLayout<S> layout = sensors_from_mesh<S>(
      mesh, {.depth = depth, .range = S(0.01), .vertices = true, .edges = true}, &report);
  layout.validate();
  const std::size_t faces = 24, vertices = 20, edges = 4 * 4 + 3 * 5 + 12;
  CHECK(report.face_sensors == faces);
  CHECK(report.vertex_sensors == vertices);
  CHECK(report.edge_sensors == edges);
  REQUIRE(layout.size() == faces + vertices + edges);
  for (std::size_t i = 0; i < layout.size(); ++i) {
    CHECK((layout.direction[i] - Vec3<S>::UnitZ()).norm() <= near_zero_of_placement<S>);
    CHECK(std::abs(layout.start[i].z() + depth) <= near_zero_of_placement<S>);
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    CHECK((surface_point(layout, faces + v, depth) - mesh.vertices[v]).norm() <=
          near_zero_of_placement<S>);
  }
  // Vertex 0 meets 1 along the side, 5 up the other and 6 along the diagonal.
  const std::uint32_t others[] = {1, 5, 6};
  for (std::size_t e = 0; e < 3; ++e) {
    const Vec3<S> middle = S(0.5) * (mesh.vertices[0] + mesh.vertices[others[e]]);
    const Vec3<S> found = surface_point(layout, faces + vertices + e, depth);
    CHECK((found - middle).norm() <= near_zero_of_placement<S>);
  }
}

TEST_CASE_TEMPLATE("sensors_from_mesh: on a sphere all look away from its centre", S, float,
                   double) {
  const std::uint32_t f = 8;
  const SensorLayout<S> layout =
      sensors_from_mesh<S>(sphere_mesh(S(0.1), f),
                           {.depth = S(0.02), .range = S(0.05), .vertices = true, .edges = true});
  layout.validate();
  REQUIRE(layout.size() == 20 * f * f + (10 * f * f + 2) + 30 * f * f);
  // The radius through the centroid or vertex of a triangle leans against the normal by less than
  // half of what its edges turn, 2 pi / (5 f).
  const S lean = S(std::numbers::pi / 5.0) / S(f);
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const S cosine = layout.direction[i].dot(surface_point(layout, i, S(0.02)).normalized());
    CHECK(cosine >= std::cos(lean));
  }
}

TEST_CASE_TEMPLATE("sensors_from_mesh: takes vertices that repeat along seams once", S, float,
                   double) {
  const TriangleMesh<S> whole = box_mesh<S>({1, 1, 1});
  TriangleMesh<S> soup;
  for (const auto& t : whole.triangles) {
    for (const std::uint32_t v : t) soup.vertices.push_back(whole.vertices[v]);
    const auto first = static_cast<std::uint32_t>(soup.vertices.size() - 3);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  const PlacementDef<S> def{.vertices = true, .edges = true};
  const SensorLayout<S> a = sensors_from_mesh(whole, def);
  const SensorLayout<S> b = sensors_from_mesh(soup, def);
  CHECK(a.size() == 12 + 8 + 18);
  CHECK(b.size() == a.size());
}

TEST_CASE_TEMPLATE("sensors_from_mesh: skips and reports what has no normal", S, float, double) {
  // A triangle, one without area, one that repeats a corner, and a sheet with two sides.
  const TriangleMesh<S> mesh{
      {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}},
      {{0, 1, 2}, {0, 1, 3}, {1, 1, 2}, {4, 5, 6}, {4, 6, 5}}};
  PlacementReport report;
  report.degenerate_faces = {99};
  const SensorLayout<S> layout =
      sensors_from_mesh<S>(mesh, {.vertices = true, .edges = true}, &report);
  layout.validate();
  CHECK(report.degenerate_faces == std::vector<std::uint32_t>{1, 2});
  CHECK(report.face_sensors == 3);
  CHECK(report.vertex_sensors == 3);
  CHECK(report.edge_sensors == 3);
  CHECK(report.vertices_without_normal == std::vector<std::uint32_t>{4, 5, 6});
  CHECK(report.edges_without_normal ==
        std::vector<std::array<std::uint32_t, 2>>{{4, 5}, {4, 6}, {5, 6}});
  CHECK(layout.size() == 9);
}

TEST_CASE_TEMPLATE("sensors_from_mesh: moves with the mesh's pose in the body", S, float, double) {
  const std::uint64_t seed = 43;
  CAPTURE(seed);
  Random random(seed);
  const TriangleMesh<S> mesh = box_mesh<S>({S(0.1), S(0.2), S(0.3)});
  PlacementDef<S> def{.depth = S(0.01), .range = S(0.03), .vertices = true, .edges = true};
  const SensorLayout<S> own = sensors_from_mesh(mesh, def);
  def.X_AM = random.pose(S(1));
  const SensorLayout<S> moved = sensors_from_mesh(mesh, def);
  moved.validate();
  REQUIRE(moved.size() == own.size());
  for (std::size_t i = 0; i < own.size(); ++i) {
    CHECK((moved.start[i] - def.X_AM * own.start[i]).norm() <= near_zero_of_placement<S>);
    CHECK((moved.direction[i] - def.X_AM.rotate(own.direction[i])).norm() <=
          near_zero_of_placement<S>);
    CHECK(moved.length[i] == own.length[i]);
  }
}

TEST_CASE_TEMPLATE("sensors_from_mesh: gives the same sensors at x0.001 and x1000", S, float,
                   double) {
  const TriangleMesh<S> mesh = sphere_mesh(S(1), 3);
  const PlacementDef<S> def{.depth = S(0.1), .range = S(0.3), .vertices = true, .edges = true};
  const SensorLayout<S> one = sensors_from_mesh(mesh, def);
  for (const S k : {S(0.001), S(1000)}) {
    TriangleMesh<S> scaled = mesh;
    for (auto& v : scaled.vertices) v *= k;
    PlacementDef<S> scaled_def = def;
    scaled_def.depth *= k;
    scaled_def.range *= k;
    const SensorLayout<S> layout = sensors_from_mesh(scaled, scaled_def);
    REQUIRE(layout.size() == one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      CHECK((layout.start[i] / k - one.start[i]).norm() <= near_zero_of_placement<S>);
      CHECK((layout.direction[i] - one.direction[i]).norm() <= near_zero_of_placement<S>);
    }
  }
}

TEST_CASE_TEMPLATE("sensors_from_mesh: refuses a bad definition or mesh by name", S, float,
                   double) {
  const TriangleMesh<S> mesh = box_mesh<S>({1, 1, 1});
  const S nan = std::numeric_limits<S>::quiet_NaN();
  CHECK(contains(placement_error<S>(mesh, {.depth = S(-1)}), "PlacementDef::depth"));
  CHECK(contains(placement_error<S>(mesh, {.depth = nan}), "PlacementDef::depth"));
  CHECK(contains(placement_error<S>(mesh, {.range = S(0)}), "PlacementDef::range"));
  CHECK(contains(placement_error<S>(mesh, {.range = infinity<S>}), "PlacementDef::range"));
  CHECK(
      contains(placement_error<S>(mesh, {.depth = S(1), .range = S(1)}), "must exceed depth = 1"));
  CHECK(contains(placement_error<S>(mesh, {.faces = false}), "PlacementDef::faces"));
  PlacementDef<S> def;
  def.X_AM.translation.x() = nan;
  CHECK(contains(placement_error(mesh, def), "PlacementDef::X_AM.translation[0]"));
  def = {};
  def.X_AM.rotation.w() = nan;
  CHECK(contains(placement_error(mesh, def), "PlacementDef::X_AM.rotation"));
  def.X_AM.rotation.w() = S(2);
  CHECK(contains(placement_error(mesh, def), "PlacementDef::X_AM.rotation: length = 2"));
  CHECK(contains(placement_error<S>(TriangleMesh<S>{}, {}), "at least one triangle"));
}

TEST_CASE_TEMPLATE("sensor_grid: fills the underside of a box with cells", S, float, double) {
  const S h = S(0.03);
  for (const std::size_t n : {std::size_t{2}, std::size_t{4}, std::size_t{10}}) {
    const SensorLayout<S> layout = sensor_grid<S>({.center = {0, 0, -h},
                                                   .side_u = {2 * h, 0, 0},
                                                   .side_v = {0, -2 * h, 0},
                                                   .count_u = n,
                                                   .count_v = n,
                                                   .depth = S(0.002),
                                                   .range = S(0.01)});
    layout.validate();
    REQUIRE(layout.size() == n * n);
    Vec3<S> mean = Vec3<S>::Zero();
    for (std::size_t i = 0; i < layout.size(); ++i) {
      mean += layout.start[i] / S(n * n);
      CHECK((layout.direction[i] + Vec3<S>::UnitZ()).norm() <= near_zero_of_placement<S>);
      CHECK(layout.length[i] == S(0.01));
    }
    CHECK((mean - Vec3<S>(0, 0, -h + S(0.002))).norm() <= near_zero_of_placement<S>);
    const S cell = 2 * h / S(n);
    CHECK((layout.start[0] - Vec3<S>(-h + cell / 2, h - cell / 2, -h + S(0.002))).norm() <=
          near_zero_of_placement<S>);
    // Along side_u first.
    CHECK((layout.start[1] - layout.start[0] - Vec3<S>(cell, 0, 0)).norm() <=
          near_zero_of_placement<S>);
    CHECK((layout.start[n] - layout.start[0] - Vec3<S>(0, -cell, 0)).norm() <=
          near_zero_of_placement<S>);
  }
}

TEST_CASE_TEMPLATE("sensor_grid: refuses a bad definition by name", S, float, double) {
  const auto error_of_grid = [](const SensorGridDef<S>& def) -> std::string {
    try {
      (void)sensor_grid(def);
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    return {};
  };
  const S nan = std::numeric_limits<S>::quiet_NaN();
  // Forgotten sides do not make a grid of a square metre.
  CHECK(contains(error_of_grid({}), "sides parallel or of no length"));
  CHECK(contains(error_of_grid({.center = {0, nan, 0}}), "SensorGridDef::center[1]"));
  CHECK(contains(error_of_grid({.side_u = {0, 0, 0}}), "parallel"));
  CHECK(contains(error_of_grid({.side_u = {0, S(1e-3), 0}}), "parallel"));
  CHECK(contains(error_of_grid({.side_v = {0, nan, 0}}), "SensorGridDef::side_v[1]"));
  CHECK(contains(error_of_grid({.count_u = 0}), "SensorGridDef::count_u"));
  CHECK(contains(error_of_grid({.count_v = 0}), "SensorGridDef::count_v"));
  CHECK(contains(error_of_grid({.depth = S(-1)}), "SensorGridDef::depth"));
  CHECK(contains(error_of_grid({.range = S(0.001)}), "SensorGridDef::range"));
}
