// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/rigid/tumbling.hpp"
#include "support/frame_mesh.hpp"
#include "support/random.hpp"
#include "support/relative.hpp"

#include <bristle/geometry/meshes/mesh_plates.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_tree.hpp>
#include <bristle/geometry/meshes/terrain.hpp>

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;

namespace {

/// [m2] Area vector of corners that go around.
template <typename Corners>
Vec3<double> area_of(const Corners& corners) {
  Vec3<double> area = Vec3<double>::Zero();
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
    area += (corners[k] - corners[0]).cross(corners[k + 1] - corners[0]) / 2;
  }
  return area;
}

/// A box of which each side has n by n squares of two triangles.
TriangleMesh<double> tiled_box(const Vec3<double>& half, int n) {
  TriangleMesh<double> mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const auto at = [&](int i, int j) {
        Vec3<double> p;
        p[axis] = side;
        p[(axis + 1) % 3] = side * (2.0 * i / n - 1);
        p[(axis + 2) % 3] = 2.0 * j / n - 1;
        mesh.vertices.push_back(p.cwiseProduct(half));
        return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
      };
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const std::uint32_t a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1),
                              d = at(i, j + 1);
          mesh.triangles.push_back({a, b, c});
          mesh.triangles.push_back({a, c, d});
        }
      }
    }
  }
  return weld(mesh, 1e-9);
}

/// A bar of L-shaped section, 1 m long: its caps are not convex, and have straight corners.
TriangleMesh<double> angle_bar() {
  TriangleMesh<double> mesh;
  const double section[7][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}, {0, 1}};
  for (const double z : {0.0, 1.0}) {
    for (const auto& p : section) mesh.vertices.push_back({p[0], p[1], z});
  }
  constexpr std::array<std::array<std::uint32_t, 3>, 5> cap{
      {{0, 1, 2}, {0, 2, 3}, {0, 3, 6}, {6, 3, 4}, {6, 4, 5}}};
  for (const auto& t : cap) {
    mesh.triangles.push_back({t[0], t[2], t[1]});
    mesh.triangles.push_back({7 + t[0], 7 + t[1], 7 + t[2]});
  }
  for (std::uint32_t i = 0; i < 7; ++i) {
    const std::uint32_t next = (i + 1) % 7;
    mesh.triangles.push_back({i, next, 7 + next});
    mesh.triangles.push_back({i, 7 + next, 7 + i});
  }
  return mesh;
}

/// A slab whose flat top is two fans beside a seam with one short, slightly turned edge: joined
/// without regard to where the line of that edge leads, the upper plate would lose a part.
TriangleMesh<double> seamed() {
  TriangleMesh<double> mesh;
  const double top[12][2] = {{-1, 0},   {0, 0},  {1e-5, 1.5e-6}, {1, 0},     {1, 1},    {0.3, 1},
                             {-0.3, 1}, {-1, 1}, {-1, -1},       {-0.3, -1}, {0.3, -1}, {1, -1}};
  for (const auto& p : top) mesh.vertices.push_back({p[0], p[1], 0});
  constexpr std::array<std::array<std::uint32_t, 3>, 12> cap{{{3, 4, 5},
                                                              {2, 3, 5},
                                                              {1, 2, 5},
                                                              {1, 5, 6},
                                                              {0, 1, 6},
                                                              {0, 6, 7},
                                                              {0, 8, 9},
                                                              {0, 9, 1},
                                                              {1, 9, 10},
                                                              {1, 10, 2},
                                                              {2, 10, 3},
                                                              {3, 10, 11}}};
  for (const auto& t : cap) mesh.triangles.push_back(t);
  constexpr std::array<std::uint32_t, 10> rim{0, 8, 9, 10, 11, 3, 4, 5, 6, 7};
  for (const std::uint32_t v : rim) {
    mesh.vertices.push_back(mesh.vertices[v] - Vec3<double>(0, 0, 0.4));
  }
  mesh.vertices.push_back({0, 0, -0.4});
  for (std::uint32_t i = 0; i < 10; ++i) {
    const std::uint32_t next = (i + 1) % 10;
    mesh.triangles.push_back({rim[i], 12 + i, 12 + next});
    mesh.triangles.push_back({rim[i], 12 + next, rim[next]});
    mesh.triangles.push_back({22, 12 + next, 12 + i});
  }
  return mesh;
}

/// A box with a pit in its top that touches the middle of an upper edge. So two edges in a line are
/// between the same two faces, and others begin between them.
TriangleMesh<double> pitted_box() {
  TriangleMesh<double> mesh;
  mesh.vertices = {{0, 0, 0},     {1, 0, 0},      {2, 0, 0},  {2, 1, 0},  {0, 1, 0},  {1.2, 0.5, 0},
                   {0.8, 0.5, 0}, {1, 0.3, -0.2}, {0, 0, -1}, {2, 0, -1}, {2, 1, -1}, {0, 1, -1}};
  mesh.triangles = {{0, 1, 6},  {0, 6, 4},  {1, 2, 5},  {2, 3, 5},   {6, 5, 3},
                    {6, 3, 4},  {6, 1, 7},  {1, 5, 7},  {5, 6, 7},   {8, 9, 2},
                    {8, 2, 1},  {8, 1, 0},  {9, 10, 3}, {9, 3, 2},   {10, 11, 4},
                    {10, 4, 3}, {11, 8, 0}, {11, 0, 4}, {8, 11, 10}, {8, 10, 9}};
  return mesh;
}

/// Checks what holds for the plates of any mesh.
/// @param straight  [1] How straight its inner edges are, of its size.
void check_partition(const TriangleMesh<double>& mesh, double straight = 1e-12) {
  const MeshTree<double> tree(mesh);
  const MeshPlates<double> plates(tree);
  const double size = tree.root_box().half_extents().norm();
  double area = 0;
  std::map<std::uint32_t, std::map<std::uint32_t, double>> lengths;
  for (std::uint32_t i = 0; i < plates.size(); ++i) {
    CAPTURE(i);
    const Plate<double> plate = plates.plate(i);
    const std::size_t count = plate.corners.size();
    REQUIRE(count >= 3);
    REQUIRE(count <= MeshPlates<double>::capacity);
    area += area_of(plate.corners).norm();
    CHECK(area_of(plate.corners).normalized().dot(plate.normal) == test::relative(1));
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t next = (k + 1) % count;
      CHECK(mesh.vertices[plate.names[k]] == plate.corners[k]);
      // Everything is in the plane, and behind each edge.
      const Vec3<double> edge = plate.corners[next] - plate.corners[k];
      for (const Vec3<double>& corner : plate.corners) {
        CHECK(std::abs(plate.normal.dot(corner - plate.corners[0])) <= 4e-6 * size);
        CHECK(edge.cross(corner - plate.corners[k]).dot(plate.normal) >=
              -1e-12 * size * edge.norm());
      }
      const std::uint32_t other = plates.neighbour(i, k);
      REQUIRE(other != i);
      if (plates.is_inner_edge(i, k)) {
        CHECK(plates.face(other) == plates.face(i));
        continue;
      }
      // Across an outer edge the neighbour has a part of the same crease, the other way.
      const Plate<double> beside = plates.plate(other);
      bool is_shared = false;
      for (std::size_t j = 0; j < beside.corners.size(); ++j) {
        if (plates.crease(other, j) != plates.crease(i, k)) continue;
        CHECK(plates.edge(other, j) == plates.edge(i, k));
        const Vec3<double> back =
            beside.corners[(j + 1) % beside.corners.size()] - beside.corners[j];
        CHECK(edge.dot(back) == test::relative(-edge.norm() * back.norm()));
        for (const Vec3<double>& end : {plate.corners[k], plate.corners[next]}) {
          CHECK(back.cross(end - beside.corners[j]).norm() <= 4e-6 * size * back.norm());
        }
        const double begin = back.dot(plate.corners[next] - beside.corners[j]);
        const double end = back.dot(plate.corners[k] - beside.corners[j]);
        is_shared = is_shared || (end > 0 && begin < back.squaredNorm());
      }
      CHECK(is_shared);
      lengths[plates.crease(i, k)][plates.face(i)] += edge.norm();
    }
  }
  // Both faces have the whole of a crease.
  for (const auto& of_crease : lengths) {
    CAPTURE(of_crease.first);
    const std::map<std::uint32_t, double>& by_face = of_crease.second;
    REQUIRE(by_face.size() == 2);
    CHECK(by_face.begin()->second == test::relative(by_face.rbegin()->second).epsilon(straight));
  }
  double expected = 0;
  for (const auto& t : mesh.triangles) {
    expected +=
        area_of(std::array{mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}).norm();
  }
  CHECK(area == test::relative(expected).epsilon(straight));
}

}  // namespace

TEST_CASE("MeshPlates: tile the surface, are flat and convex, and know their neighbours") {
  check_partition(box_mesh<double>({0.1, 0.2, 0.3}));
  check_partition(tiled_box({0.1, 0.2, 0.3}, 5));
  check_partition(angle_bar());
  check_partition(bristle::test::frame_mesh());
  check_partition(pitted_box());
  // Its seam is off the line by less than single precision tells.
  check_partition(seamed(), 4e-6);
  check_partition(sphere_mesh<double>(0.2, 6));
  check_partition(scenes::parts::torus(0.05, 0.02, 16, 8).mesh);
  // Turned and moved, in coordinates that no number has exactly.
  Random random(3);
  for (int round = 0; round < 20; ++round) {
    TriangleMesh<double> mesh = round % 2 == 0 ? tiled_box({0.1, 0.2, 0.3}, 3) : angle_bar();
    const Quat<double> turn = random.rotation<double>();
    const Vec3<double> shift = random.in_cube(0.3);
    for (Vec3<double>& v : mesh.vertices) v = turn * v + shift;
    check_partition(mesh);
  }
}

TEST_CASE("MeshPlates: a side of a box is one plate, and a curved surface keeps its triangles") {
  const auto count = [](const TriangleMesh<double>& mesh) {
    const MeshTree<double> tree(mesh);
    return MeshPlates<double>(tree).size();
  };
  CHECK(count(box_mesh<double>({0.1, 0.2, 0.3})) == 6);
  // Each quadrangle of a ring is flat.
  CHECK(count(scenes::parts::torus(0.05, 0.02, 16, 8).mesh) == 128);
  const TriangleMesh<double> ball = sphere_mesh<double>(0.2, 6);
  CHECK(count(ball) == ball.triangles.size());
  // Two for each cap, six sides.
  CHECK(count(angle_bar()) == 10);
  CHECK(count(tiled_box({0.1, 0.2, 0.3}, 2)) == 6);
}

// Neither within a face nor along its rim are there corners of the solid.
TEST_CASE("MeshPlates: a flat face has as many plates as one that is meshed coarsely") {
  const auto count_of = [](const TriangleMesh<double>& mesh) {
    const MeshTree<double> tree(mesh);
    return static_cast<int>(MeshPlates<double>(tree).size());
  };
  for (const int n : {5, 10, 20, 40}) {
    CAPTURE(n);
    CHECK(count_of(tiled_box({0.1, 0.2, 0.3}, n)) == 6);
  }
}

// Turned, lengths that are equal differ by rounding. Tried in that order, edges left three times as
// many.
TEST_CASE_TEMPLATE("MeshPlates: a turned face has as few plates as one along the axes", S, float,
                   double) {
  const Quat<S> turn(Eigen::AngleAxis<S>(S(0.3), Vec3<S>(1, 2, 3).normalized()));
  for (const std::uint32_t n : {16u, 32u, 64u}) {
    CAPTURE(n);
    TriangleMesh<S> mesh = extruded_mesh<S>(grid_mesh<S>({1, 1}, {n, n}), {0, 0, S(-0.5)});
    const MeshTree<S> tree(mesh);
    for (Vec3<S>& v : mesh.vertices) v = turn * v;
    const MeshTree<S> turned(mesh);
    CHECK(MeshPlates<double>(tree).size() == 6);
    CHECK(MeshPlates<double>(turned).size() == 6);
  }
}

// A contact along a straight side takes one edge of a plate. Where a side had several, bodies fell
// off rails of several edges.
TEST_CASE("MeshPlates: turn at each corner, so that each side is one edge") {
  for (const TriangleMesh<double>& mesh :
       {angle_bar(), tiled_box({0.1, 0.2, 0.3}, 4), seamed(), bristle::test::frame_mesh()}) {
    const MeshTree<double> tree(mesh);
    const MeshPlates<double> plates(tree);
    for (std::uint32_t i = 0; i < plates.size(); ++i) {
      const Plate<double> plate = plates.plate(i);
      const std::size_t count = plate.corners.size();
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t next = (k + 1) % count;
        const Vec3<double> in = plate.corners[next] - plate.corners[k];
        const Vec3<double> out = plate.corners[(k + 2) % count] - plate.corners[next];
        CHECK(in.cross(out).dot(plate.normal) > 3e-4 * in.norm() * out.norm());
      }
    }
  }
}
