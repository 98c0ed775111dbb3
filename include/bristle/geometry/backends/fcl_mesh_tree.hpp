/// @file
/// Rays through the tree inside an FCL mesh, by its public nodes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/rays/ray_box.hpp>
#include <bristle/geometry/trees/aabb.hpp>

#include <fcl/geometry/bvh/BVH_model.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace bristle::inline BRISTLE_ABI::detail {

/// FCL mesh of a `TriangleMesh`: a tree of axis-aligned boxes with one triangle a leaf. FCL's
/// oriented boxes take four times the memory and building time, and rays gain nothing by them.
template <typename S>
using FclMesh = fcl::BVHModel<fcl::AABB<S>>;

/// A view of an FCL mesh: its triangles, and the ray query of `AabbTree`, with the triangle's
/// number as payload. The mesh must outlive it and have its tree (`endModel`).
///
/// The traversal is recursive, as deep as FCL's tree is high. FCL splits at the mean, which gives
/// about the logarithm of the number of triangles. It sets no bound.
template <Scalar S>
class FclMeshTree {
 public:
  using ScalarType = S;

  explicit FclMeshTree(const FclMesh<S>& mesh) : mesh_(&mesh) {}

  /// [-] Number of triangles.
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(mesh_->num_tris); }

  /// [m] Corners of a triangle, counter-clockwise seen from outside.
  [[nodiscard]] std::array<Vec3<S>, 3> corners(std::uint32_t i) const {
    const fcl::Triangle& t = mesh_->tri_indices[i];
    return {mesh_->vertices[t[0]], mesh_->vertices[t[1]], mesh_->vertices[t[2]]};
  }

  /// [-] Vertex numbers of a triangle.
  [[nodiscard]] std::array<std::uint32_t, 3> vertex_numbers(std::uint32_t i) const {
    const fcl::Triangle& t = mesh_->tri_indices[i];
    return {static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]),
            static_cast<std::uint32_t>(t[2])};
  }

  /// The triangles by themselves, in another scalar.
  template <Scalar P>
  [[nodiscard]] TriangleMesh<P> mesh() const {
    TriangleMesh<P> triangles;
    for (int i = 0; i < mesh_->num_vertices; ++i) {
      triangles.vertices.push_back(mesh_->vertices[i].template cast<P>());
    }
    for (std::uint32_t i = 0; i < size(); ++i) triangles.triangles.push_back(vertex_numbers(i));
    return triangles;
  }

  /// Box around all triangles.
  [[nodiscard]] Aabb<S> root_box() const { return mesh_->getNumBVs() > 0 ? box(0) : Aabb<S>{}; }

  /// Calls `visit(triangle, max_distance) -> new max_distance` for every triangle whose box the ray
  /// meets before max_distance [m]. It starts as the ray's length. Nearer boxes come first.
  template <typename Visit>
  void walk_ray(const Ray<S>& ray, Visit&& visit) const {
    if (mesh_->getNumBVs() == 0) return;
    const SlabTest<S> slabs(ray);
    S reach = std::min(ray.length, std::numeric_limits<S>::max() / S(2));
    walk_below(0, slabs.enter(box(0), reach), slabs, reach, visit);
  }

 private:
  [[nodiscard]] Aabb<S> box(int node) const {
    const fcl::AABB<S>& bv = mesh_->getBV(node).bv;
    return {bv.min_, bv.max_};
  }

  template <typename Visit>
  void walk_below(int id, S enter, const SlabTest<S>& slabs, S& reach, Visit& visit) const {
    // The reach may have shrunk since the entry was computed.
    if (!(enter <= reach * (S(1) + Tolerance<S>::round_off()))) return;
    const auto& node = mesh_->getBV(id);
    if (node.isLeaf()) {
      reach = visit(static_cast<std::uint32_t>(node.primitiveId()), reach);
      return;
    }
    int near = node.leftChild();
    int far = node.rightChild();
    S enter_near = slabs.enter(box(near), reach);
    S enter_far = slabs.enter(box(far), reach);
    if (enter_far < enter_near) {
      std::swap(near, far);
      std::swap(enter_near, enter_far);
    }
    walk_below(near, enter_near, slabs, reach, visit);
    walk_below(far, enter_far, slabs, reach, visit);
  }

  const FclMesh<S>* mesh_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
