/// @file
/// Meshes of simple shapes, for examples, tests and comparison with the exact shapes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/math/types.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace bristle::inline BRISTLE_ABI {

/// Cuboid around the origin: 8 vertices, 12 triangles. Two triangles for each of the faces -x, +x,
/// -y, +y, -z, +z in this order.
///
/// @param half_extents  [m] Half of each edge, > 0.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> box_mesh(const Vec3<S>& half_extents);

/// Geodesic sphere around the origin: an icosahedron whose edges are divided into `frequency`
/// parts. It has 10 f^2 + 2 vertices on the sphere and 20 f^2 nearly equal triangles.
///
/// @param radius  [m] > 0. The triangles are inside the sphere.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> sphere_mesh(S radius, std::uint32_t frequency);

/// Cylinder about z with vertices on its rims and the centres of its ends. Four triangles a
/// segment.
///
/// @param segments  [-] Segments around the axis, >= 3.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> cylinder_mesh(const Cylinder<S>& cylinder, std::uint32_t segments);

/// Flat open rectangle around the origin in the plane z = 0, facing +z: a pad for sensors.
///
/// @param size   [m] Whole sides along x and y, > 0.
/// @param cells  [-] Cells along x and y, >= 1 each. A cell is two triangles. Cells along x are
///               consecutive.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> grid_mesh(const detail::Vec2<S>& size,
                                        const std::array<std::uint32_t, 2>& cells);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
TriangleMesh<S> box_mesh(const Vec3<S>& half_extents) {
  validate<S>(Shape<S>(Box<S>{half_extents}));
  TriangleMesh<S> mesh;
  // Bit k of a vertex's number is the side along axis k.
  for (unsigned v = 0; v < 8; ++v) {
    const Vec3<S> sign(v & 1u ? S(1) : S(-1), v & 2u ? S(1) : S(-1), v & 4u ? S(1) : S(-1));
    mesh.vertices.push_back(cwise_product(sign, half_extents));
  }
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    const std::uint32_t u = 1u << (axis + 1) % 3;
    const std::uint32_t v = 1u << (axis + 2) % 3;
    const std::uint32_t high = 1u << axis;
    mesh.triangles.push_back({0, v, u + v});
    mesh.triangles.push_back({0, u + v, u});
    mesh.triangles.push_back({high, high + u, high + u + v});
    mesh.triangles.push_back({high, high + u + v, high + v});
  }
  return mesh;
}

template <Scalar S>
TriangleMesh<S> sphere_mesh(S radius, std::uint32_t frequency) {
  detail::require_positive("sphere_mesh: radius", radius);
  detail::require(frequency >= 1, "sphere_mesh: frequency", frequency, "must be >= 1");
  // Of each of twenty faces, before they share edges.
  detail::require_countable(
      "sphere_mesh: frequency", frequency,
      10 * (std::min<std::uint64_t>(frequency, 1u << 28) + 2) * (std::uint64_t{frequency} + 1));
  // Corners of an icosahedron: the cyclic permutations of (0, +-1, +-golden ratio).
  const S g = S(std::numbers::phi);
  const std::array<Vec3<S>, 12> corners{Vec3<S>(-1, g, 0),  Vec3<S>(1, g, 0),   Vec3<S>(-1, -g, 0),
                                        Vec3<S>(1, -g, 0),  Vec3<S>(0, -1, g),  Vec3<S>(0, 1, g),
                                        Vec3<S>(0, -1, -g), Vec3<S>(0, 1, -g),  Vec3<S>(g, 0, -1),
                                        Vec3<S>(g, 0, 1),   Vec3<S>(-g, 0, -1), Vec3<S>(-g, 0, 1)};
  constexpr std::uint8_t faces[20][3] = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};

  TriangleMesh<S> mesh;
  for (const auto& face : faces) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    // Row i holds the i + 1 points that are i steps away from the first corner.
    const auto number = [first](std::uint32_t i, std::uint32_t j) {
      return first + i * (i + 1) / 2 + j;
    };
    for (std::uint32_t i = 0; i <= frequency; ++i) {
      for (std::uint32_t j = 0; j <= i; ++j) {
        const Vec3<S> p = S(frequency - i) * corners[face[0]] + S(i - j) * corners[face[1]] +
                          S(j) * corners[face[2]];
        mesh.vertices.push_back(radius * p.normalized());
        if (i == 0) continue;
        if (j < i) mesh.triangles.push_back({number(i - 1, j), number(i, j), number(i, j + 1)});
        if (j > 0 && j < i) {
          mesh.triangles.push_back({number(i - 1, j - 1), number(i, j), number(i - 1, j)});
        }
      }
    }
  }
  // Faces repeat the points of their common edges, with other rounding.
  return weld(mesh, S(detail::chosen::weld_distance) * detail::Tolerance<S>::round_off());
}

template <Scalar S>
TriangleMesh<S> cylinder_mesh(const Cylinder<S>& cylinder, std::uint32_t segments) {
  using std::cos;
  using std::sin;
  validate<S>(Shape<S>(cylinder));
  detail::require(segments >= 3, "cylinder_mesh: segments", segments, "must be >= 3");
  detail::require_countable("cylinder_mesh: segments", segments, 2 * std::uint64_t{segments} + 2);
  const S h = cylinder.half_length;
  TriangleMesh<S> mesh;
  mesh.vertices = {{S(0), S(0), -h}, {S(0), S(0), h}};
  for (std::uint32_t i = 0; i < segments; ++i) {
    const S angle = S(2) * S(std::numbers::pi) * S(i) / S(segments);
    const S x = cylinder.radius * cos(angle);
    const S y = cylinder.radius * sin(angle);
    mesh.vertices.push_back({x, y, -h});
    mesh.vertices.push_back({x, y, h});
  }
  for (std::uint32_t i = 0; i < segments; ++i) {
    const std::uint32_t low = 2 + 2 * i;
    const std::uint32_t next = 2 + 2 * ((i + 1) % segments);
    mesh.triangles.push_back({0, next, low});
    mesh.triangles.push_back({1, low + 1, next + 1});
    mesh.triangles.push_back({low, next, next + 1});
    mesh.triangles.push_back({low, next + 1, low + 1});
  }
  return mesh;
}

template <Scalar S>
TriangleMesh<S> grid_mesh(const detail::Vec2<S>& size, const std::array<std::uint32_t, 2>& cells) {
  detail::require_positive("grid_mesh: size[0]", size.x());
  detail::require_positive("grid_mesh: size[1]", size.y());
  detail::require(cells[0] >= 1, "grid_mesh: cells[0]", cells[0], "must be >= 1");
  detail::require(cells[1] >= 1, "grid_mesh: cells[1]", cells[1], "must be >= 1");
  const auto above = [](std::uint32_t n) { return std::uint64_t{n} + 1; };
  const std::size_t longer = cells[0] >= cells[1] ? 0 : 1;
  detail::require_countable(longer == 0 ? "grid_mesh: cells[0]" : "grid_mesh: cells[1]",
                            cells[longer], above(cells[0]) * above(cells[1]));
  TriangleMesh<S> mesh;
  for (std::uint32_t j = 0; j <= cells[1]; ++j) {
    for (std::uint32_t i = 0; i <= cells[0]; ++i) {
      mesh.vertices.push_back({(S(i) / S(cells[0]) - S(0.5)) * size.x(),
                               (S(j) / S(cells[1]) - S(0.5)) * size.y(), S(0)});
    }
  }
  const std::uint32_t row = cells[0] + 1;
  for (std::uint32_t j = 0; j < cells[1]; ++j) {
    for (std::uint32_t i = 0; i < cells[0]; ++i) {
      const std::uint32_t v = j * row + i;
      mesh.triangles.push_back({v, v + 1, v + row + 1});
      mesh.triangles.push_back({v, v + row + 1, v + row});
    }
  }
  return mesh;
}

}  // namespace bristle::inline BRISTLE_ABI
