/// @file
/// A solid triangle mesh with a tree over its triangles, for rays and contacts.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/rays/mesh_rays.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/rays/ray_mesh.hpp>
#include <bristle/geometry/trees/aabb_tree.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// Immutable solid: the surface of a closed mesh and its inside.
template <Scalar S>
class MeshTree {
 public:
  using ScalarType = S;

  /// @param mesh  A solid that `validate_solid` accepts. Not checked again.
  explicit MeshTree(TriangleMesh<S> mesh);

  [[nodiscard]] const TriangleMesh<S>& mesh() const { return mesh_; }
  /// Tree over the triangles. Payloads are their numbers.
  [[nodiscard]] const AabbTree<S>& tree() const { return tree_; }
  /// [-] Number of triangles.
  [[nodiscard]] std::size_t size() const { return mesh_.triangles.size(); }
  /// [m] Corners of a triangle.
  [[nodiscard]] std::array<Vec3<S>, 3> corners(std::uint32_t triangle) const {
    const auto& t = mesh_.triangles[triangle];
    return {mesh_.vertices[t[0]], mesh_.vertices[t[1]], mesh_.vertices[t[2]]};
  }
  /// [-] Vertex numbers of a triangle.
  [[nodiscard]] const std::array<std::uint32_t, 3>& vertex_numbers(std::uint32_t triangle) const {
    return mesh_.triangles[triangle];
  }

  /// [m] Box around all triangles.
  [[nodiscard]] Aabb<S> root_box() const { return tree_.root_box(); }
  /// The same triangles in the layout for rays.
  [[nodiscard]] const RayMesh<S>& for_rays() const { return rays_; }
  /// As `RayMesh::walk_ray`.
  template <typename Visit>
  void walk_ray(const Ray<S>& ray, Visit&& visit) const {
    rays_.walk_ray(ray, visit);
  }

  /// Returns whether a point is in the solid. Its surface is, to round-off.
  [[nodiscard]] bool contains(const Vec3<S>& point) const { return is_inside_mesh(*this, point); }

 private:
  TriangleMesh<S> mesh_;
  AabbTree<S> tree_;
  RayMesh<S> rays_;
};

/// Nearest hit of a mesh, as by `ray_cast_mesh`.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const MeshTree<S>& mesh, const Ray<S>& ray);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
MeshTree<S>::MeshTree(TriangleMesh<S> mesh) : mesh_(std::move(mesh)) {
  DynamicArray<Aabb<S>> boxes(mesh_.triangles.size());
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    for (const std::uint32_t v : mesh_.triangles[t]) boxes[t].include(mesh_.vertices[v]);
  }
  tree_.build(boxes);
  rays_ = RayMesh<S>(size(), [this](std::uint32_t t) { return corners(t); });
}

template <Scalar S>
RayHit<S> ray_cast(const MeshTree<S>& mesh, const Ray<S>& ray) {
  return ray_cast_mesh(mesh, ray);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
