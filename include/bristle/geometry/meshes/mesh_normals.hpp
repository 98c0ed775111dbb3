/// @file
/// Normals of the faces and vertices of a triangle mesh that may have degenerate faces.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/math/types.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Sum of weighted unit normals, and whether it has a direction.
template <Scalar S>
struct NormalSum {
  /// [1] Weighted sum.
  Vec3<S> sum = zero<Vec3<S>>();
  /// [1] Sum of the weights; 0 if no triangle with a normal took part.
  S weight = S(0);

  void add(const Vec3<S>& normal, S w) {
    sum += w * normal;
    weight += w;
  }
  [[nodiscard]] bool has_direction() const { return sum.norm() > Tolerance<S>::equal() * weight; }
};

/// Outward unit normals of all triangles. Zero for those numbered in `degenerate`, which have none.
template <Scalar S>
[[nodiscard]] DynamicArray<Vec3<S>> face_normals(const TriangleMesh<S>& mesh,
                                                 std::span<const std::uint32_t> degenerate);

/// Sums the normals of each vertex's faces, weighted with the angles there. So the cut of a flat
/// face into triangles does not matter (Thuermer and Wuethrich 1998).
///
/// @param normals  Normals of the faces from `face_normals`. Zero for degenerate ones.
template <Scalar S>
[[nodiscard]] DynamicArray<NormalSum<S>> vertex_normals(const TriangleMesh<S>& mesh,
                                                        std::span<const Vec3<S>> normals);

// Implementation ----------------------------------------------------------------------------------

/// Angle [rad] of a triangle at its corner k.
template <Scalar S>
[[nodiscard]] S corner_angle(const TriangleMesh<S>& mesh, std::size_t triangle, std::size_t k) {
  using std::atan2;
  const auto& t = mesh.triangles[triangle];
  const Vec3<S> a = mesh.vertices[t[(k + 1) % 3]] - mesh.vertices[t[k]];
  const Vec3<S> b = mesh.vertices[t[(k + 2) % 3]] - mesh.vertices[t[k]];
  return atan2(a.cross(b).norm(), a.dot(b));
}

template <Scalar S>
DynamicArray<Vec3<S>> face_normals(const TriangleMesh<S>& mesh,
                                   std::span<const std::uint32_t> degenerate) {
  DynamicArray<Vec3<S>> normals;
  normals.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    normals.push_back(triangle_normal(mesh, t));
  }
  for (const std::uint32_t t : degenerate) set_zero(normals[t]);
  return normals;
}

template <Scalar S>
DynamicArray<NormalSum<S>> vertex_normals(const TriangleMesh<S>& mesh,
                                          std::span<const Vec3<S>> normals) {
  DynamicArray<NormalSum<S>> sums(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (normals[t] == zero<Vec3<S>>()) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      sums[mesh.triangles[t][k]].add(normals[t], corner_angle(mesh, t, k));
    }
  }
  return sums;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
