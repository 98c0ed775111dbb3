/// @file
/// Terrain: heights over a grid as a surface, and the solid ground under an open surface.
///
/// A shape is a solid, so that what is deep in it knows the way out and what comes from below is
/// stopped. Terrain is a surface without an inside. It becomes a solid by a copy of it some way
/// below and walls between their borders. Contacts, rays and queries are those of any mesh.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/math/types.hpp>

#include <array>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI {

/// Open surface of heights over a rectangle around the origin, facing +z.
///
/// Vertex j (cells[0] + 1) + i has heights[j (cells[0] + 1) + i] at the i-th of the equally spaced
/// places along x and the j-th along y. The diagonal of a cell runs from its corner of least x and
/// y to the opposite one.
///
/// @param size     [m] Whole sides along x and y, > 0.
/// @param cells    [-] Cells along x and y, >= 1 each. A cell is two triangles.
/// @param heights  [m] z at each corner of a cell, rows of equal y one after the other: as many as
///                 (cells[0] + 1) (cells[1] + 1).
/// @throws InvalidArgument if a size, a count or a height is not as above, or not finite.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> height_field_mesh(const detail::Vec2<S>& size,
                                                const std::array<std::uint32_t, 2>& cells,
                                                std::span<const S> heights);

/// Solid between an open surface and its copy moved by `offset`: ground for a `ShapeDef`.
///
/// The triangles of the surface come first, in their order, then those of the copy, then walls
/// along all borders. The solid has a volume of the surface's area seen along the offset, times the
/// offset's length.
///
/// @param surface  Every triangle faces against the offset, so that the ground lies behind it.
///                 Holes and several pieces are fine. Vertices that repeat along seams leave walls
///                 inside: see `weld`. No line along the offset may meet the surface twice within
///                 the offset's length; this is not checked.
/// @param offset   [m] From the surface into the ground, say (0, 0, -0.5): how thick the ground is.
/// @throws InvalidArgument that names the first triangle that faces along the offset or is
///         degenerate, an edge of more than two triangles or of two that are wound differently, a
///         vertex where two borders meet, a surface that is none (`validate_surface`), or an offset
///         that is not finite or 0.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> extruded_mesh(const TriangleMesh<S>& surface, const Vec3<S>& offset);

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S>
TriangleMesh<S> height_field_mesh(const detail::Vec2<S>& size,
                                  const std::array<std::uint32_t, 2>& cells,
                                  std::span<const S> heights) {
  const std::size_t corners = (std::size_t(cells[0]) + 1) * (std::size_t(cells[1]) + 1);
  detail::require(heights.size() == corners, "height_field_mesh: heights.size()", heights.size(),
                  "must be " + std::to_string(corners) + ", one for each corner of a cell");
  TriangleMesh<S> mesh = grid_mesh(size, cells);
  for (std::size_t v = 0; v < heights.size(); ++v) {
    detail::require_finite("height_field_mesh: heights[" + std::to_string(v) + "]", heights[v]);
    mesh.vertices[v].z() = heights[v];
  }
  return mesh;
}

template <Scalar S>
TriangleMesh<S> extruded_mesh(const TriangleMesh<S>& surface, const Vec3<S>& offset) {
  detail::require_all_finite("extruded_mesh: offset", offset);
  detail::require(offset.stableNorm() > S(0), "extruded_mesh: offset", S(0), "must not be 0");
  validate_surface(surface);
  const Vec3<S> up = -offset.stableNormalized();
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    // A triangle without a normal fails, too.
    if (triangle_normal(surface, t).dot(up) > detail::Tolerance<S>::round_off()) continue;
    detail::raise_triangle(t, detail::to_tuple_text(surface.triangles[t]),
                           "must face against the offset " + detail::to_tuple_text(offset));
  }
  const detail::DynamicArray<detail::EdgeUse> borders =
      detail::border_edges(detail::sorted_edges(surface.triangles));

  TriangleMesh<S> solid = surface;
  const auto below = static_cast<std::uint32_t>(surface.vertices.size());
  for (const Vec3<S>& vertex : surface.vertices) solid.vertices.push_back(vertex + offset);
  for (const auto& t : surface.triangles) {
    solid.triangles.push_back({below + t[0], below + t[2], below + t[1]});
  }
  std::vector<bool> has_wall(surface.vertices.size());
  for (const detail::EdgeUse& border : borders) {
    const std::uint32_t from = border.is_ascending ? border.low : border.high;
    const std::uint32_t to = border.is_ascending ? border.high : border.low;
    if (has_wall[from]) {
      detail::raise_triangle(border.triangle, "vertex " + std::to_string(from),
                             "must not lie on two borders, or on one twice");
    }
    has_wall[from] = true;
    solid.triangles.push_back({to, from, below + from});
    solid.triangles.push_back({to, below + from, below + to});
  }
  return solid;
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

/// Declares (`extern template`) or defines (`template`) the functions of terrain in a scalar.
#define BRISTLE_TERRAIN_FUNCTIONS(declare_or_make, S)                                       \
  declare_or_make TriangleMesh<S> height_field_mesh<S>(const detail::Vec2<S>& size,         \
                                                       const std::array<std::uint32_t, 2>&, \
                                                       std::span<const S> heights);         \
  declare_or_make TriangleMesh<S> extruded_mesh<S>(const TriangleMesh<S>& surface,          \
                                                   const Vec3<S>& offset);

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

BRISTLE_TERRAIN_FUNCTIONS(extern template, float)
BRISTLE_TERRAIN_FUNCTIONS(extern template, double)

}  // namespace bristle::inline BRISTLE_ABI
#endif
