/// @file
/// Primitive patches to wrap around a shape: plane, cylinder, half sphere, or any mesh.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/meshes/mesh_normals.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/math/types.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Open surface with a normal at each vertex: M in Algorithm 3. It faces outwards, as the sensors
/// on it will.
template <Scalar S>
struct PatchMesh {
  /// [m] The surface.
  TriangleMesh<S> mesh;
  /// [1] Outward unit normals of the vertices; zero without one.
  std::vector<Vec3<S>> normals;
};

/// Rectangle around the origin in z = 0, facing +z.
///
/// @param size   [m] Whole sides along x and y, > 0.
/// @param cells  [-] Along x and y, >= 1 each; a cell is two triangles.
template <Scalar S>
[[nodiscard]] PatchMesh<S> plane_patch(const detail::Vec2<S>& size,
                                       const std::array<std::uint32_t, 2>& cells);

/// A cylinder's wall, or a strip of it.
template <Scalar S>
struct CylinderPatchDef {
  /// [m] Radius of the cylinder, whose axis is y. > 0.
  S radius = S(0.01);
  /// [m] Length along y, the origin in its middle. > 0.
  S length = S(0.01);
  /// [rad] Arc, in (0, 2 pi], with its middle at +z; 2 pi closes the wall.
  S arc = S(2) * S(std::numbers::pi);
  /// [-] Cells along the arc and along y, >= 1 each and >= 3 around a closed wall; a cell is two
  /// triangles.
  std::array<std::uint32_t, 2> cells{16, 4};
};

/// The plane patch bent about y, facing away from the axis.
/// @throws InvalidArgument when the definition breaks a rule.
template <Scalar S>
[[nodiscard]] PatchMesh<S> cylinder_patch(const CylinderPatchDef<S>& def);

/// Half sphere around the origin with its pole at +z, facing away from its centre. `rings` rings of
/// vertices follow the pole. The last one is the rim at z = 0.
///
/// @param radius    [m] > 0.
/// @param rings     [-] >= 1.
/// @param segments  [-] Vertices of each ring, >= 3.
template <Scalar S>
[[nodiscard]] PatchMesh<S> half_sphere_patch(S radius, std::uint32_t rings, std::uint32_t segments);

/// Patch from any mesh. Vertex normals are angle-weighted means of face normals. Vertices with
/// equal coordinates are welded: the surface does not tear along seams.
/// @throws InvalidArgument when the mesh is no valid surface (see `validate_surface`).
template <Scalar S>
[[nodiscard]] PatchMesh<S> patch_from_mesh(const TriangleMesh<S>& mesh);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
PatchMesh<S> plane_patch(const detail::Vec2<S>& size, const std::array<std::uint32_t, 2>& cells) {
  PatchMesh<S> patch{grid_mesh<S>(size, cells), {}};
  patch.normals.assign(patch.mesh.vertices.size(), detail::unit_z<Vec3<S>>());
  return patch;
}

template <Scalar S>
PatchMesh<S> cylinder_patch(const CylinderPatchDef<S>& def) {
  using std::cos;
  using std::sin;
  constexpr S whole = S(2) * S(std::numbers::pi);
  detail::require_positive("CylinderPatchDef::radius", def.radius);
  detail::require_positive("CylinderPatchDef::length", def.length);
  detail::require_positive("CylinderPatchDef::arc", def.arc);
  detail::require(def.arc <= whole, "CylinderPatchDef::arc", def.arc, "must be <= 2 pi");
  const std::uint32_t fewest = def.arc < whole ? 1 : 3;
  detail::require(def.cells[0] >= fewest, "CylinderPatchDef::cells[0]", def.cells[0],
                  "must be >= " + std::to_string(fewest));
  detail::require(def.cells[1] >= 1, "CylinderPatchDef::cells[1]", def.cells[1], "must be >= 1");

  TriangleMesh<S> mesh = grid_mesh<S>({def.arc, def.length}, def.cells);
  for (Vec3<S>& p : mesh.vertices) {
    p = {def.radius * sin(p.x()), p.y(), def.radius * cos(p.x())};
  }
  // A closed wall's ends coincide but for rounding.
  PatchMesh<S> patch{
      weld(mesh, S(detail::chosen::weld_distance) * detail::Tolerance<S>::round_off()), {}};
  for (const Vec3<S>& p : patch.mesh.vertices) {
    patch.normals.push_back(Vec3<S>(p.x(), S(0), p.z()).normalized());
  }
  return patch;
}

template <Scalar S>
PatchMesh<S> half_sphere_patch(S radius, std::uint32_t rings, std::uint32_t segments) {
  using std::cos;
  using std::sin;
  detail::require_positive("half_sphere_patch: radius", radius);
  detail::require(rings >= 1, "half_sphere_patch: rings", rings, "must be >= 1");
  detail::require(segments >= 3, "half_sphere_patch: segments", segments, "must be >= 3");
  detail::require_countable(
      rings > segments ? "half_sphere_patch: rings" : "half_sphere_patch: segments",
      std::max(rings, segments), std::uint64_t{rings} * segments + 1);
  PatchMesh<S> patch;
  patch.normals = {detail::unit_z<Vec3<S>>()};
  for (std::uint32_t i = 1; i <= rings; ++i) {
    const S polar = S(0.5) * S(std::numbers::pi) * S(i) / S(rings);
    // The rim lies exactly in the plane.
    const S height = i < rings ? S(cos(polar)) : S(0);
    for (std::uint32_t j = 0; j < segments; ++j) {
      const S turn = S(2) * S(std::numbers::pi) * S(j) / S(segments);
      patch.normals.push_back({sin(polar) * cos(turn), sin(polar) * sin(turn), height});
    }
  }
  for (const Vec3<S>& n : patch.normals) patch.mesh.vertices.push_back(radius * n);
  for (std::uint32_t j = 0; j < segments; ++j) {
    const std::uint32_t next = (j + 1) % segments;
    patch.mesh.triangles.push_back({0, 1 + j, 1 + next});
    for (std::uint32_t inner = 1; inner + segments < patch.normals.size(); inner += segments) {
      const std::uint32_t outer = inner + segments;
      patch.mesh.triangles.push_back({inner + j, outer + j, outer + next});
      patch.mesh.triangles.push_back({inner + j, outer + next, inner + next});
    }
  }
  return patch;
}

template <Scalar S>
PatchMesh<S> patch_from_mesh(const TriangleMesh<S>& mesh) {
  validate_surface(mesh);
  PatchMesh<S> patch{weld(mesh), {}};
  const detail::DynamicArray<Vec3<S>> faces =
      detail::face_normals<S>(patch.mesh, degenerate_triangles(patch.mesh));
  for (const detail::NormalSum<S>& n : detail::vertex_normals<S>(patch.mesh, faces)) {
    patch.normals.push_back(n.has_direction() ? n.sum.normalized() : detail::zero<Vec3<S>>());
  }
  return patch;
}

}  // namespace bristle::inline BRISTLE_ABI
