/// @file
/// Wraps a primitive patch around a shape (Algorithm 3).
///
/// Wrapping puts sensors on a curved surface. A patch of a simple form is laid over the shape and
/// drawn onto it vertex by vertex. Algorithm 2 covers it with sensors. The patch keeps its
/// resolution and smooths finer detail. It covers only the part that it lies over, so one body may
/// carry several patches with different constants.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/rays/mesh_rays.hpp>
#include <bristle/geometry/rays/ray_mesh.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/sensors/patch_mesh.hpp>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Direction of a wrapped vertex's offset from the surface.
enum class WrapOffset {
  /// Back along its ray, as in Algorithm 3. On faces that the ray meets at an angle, the clearance
  /// is the offset times the cosine of that angle.
  ray,
  /// Along the normal of the face it met. The clearance is the offset.
  normal
};

/// Definition of a wrap.
template <Scalar S>
struct WrapDef {
  /// [m] Distance between the shape and its patch, p_off in Algorithm 3. Finite, >= 0.
  S offset = S(0);
  /// [-] Direction of the offset.
  WrapOffset offset_along = WrapOffset::ray;
  /// [m] Farthest distance at which a vertex finds the shape. > 0, may be infinite.
  S reach = infinity<S>;
  /// [m] Pose of the patch in the shape's frame.
  Transform<S> X_SM{};
};

/// Result of wrapping a patch: indices of its vertices and triangles, ascending.
struct WrapReport {
  /// [-] Discarded vertices: their rays meet nothing in range.
  std::vector<std::uint32_t> missed;
  /// [-] Vertices whose rays meet a face from behind, as rays that start inside the shape do.
  std::vector<std::uint32_t> met_from_behind;
  /// [-] Vertices whose rays meet the shape closer than the offset.
  std::vector<std::uint32_t> too_near;
  /// [-] Vertices without a normal to cast along.
  std::vector<std::uint32_t> without_normal;
  /// [-] Triangles dropped because they lost a vertex.
  std::vector<std::uint32_t> dropped_faces;

  /// [-] Number of discarded vertices.
  [[nodiscard]] std::size_t discarded() const {
    return missed.size() + met_from_behind.size() + too_near.size() + without_normal.size();
  }
};

/// Draws the patch onto a shape. Each vertex is cast at it against its normal, and moves to the
/// hit, less the offset. The result is in the frame of the shape. It suits `sensors_from_mesh`, or
/// `save_obj` and `save_stl` to edit it by hand.
///
/// Vertices that meet nothing are discarded with their faces. So are vertices that are left without
/// a face. If none is left, the mesh is empty. The others keep their order. Normals are those of
/// the triangles.
///
/// It departs from Algorithm 3 in two points. The patch faces outwards, like the surface it
/// becomes, so rays run against its normals. A vertex whose ray meets nothing is discarded, where
/// Algorithm 3 would leave it in place.
///
/// @param shape   Any surface, open or closed. Rays pass degenerate triangles.
/// @param report  Receives the discarded vertices and triangles. May be null.
/// @throws InvalidArgument when one of the meshes is no valid surface (see `validate_surface`), a
///         normal is neither zero nor of length 1, or the definition breaks a rule.
/// @note O((v + t) log t) for v vertices and a shape of t triangles.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> wrap_patch(const PatchMesh<S>& patch, const TriangleMesh<S>& shape,
                                         const WrapDef<S>& def = {}, WrapReport* report = nullptr);

// Implementation ----------------------------------------------------------------------------------

namespace detail {

template <Scalar S>
void require_wrappable(const PatchMesh<S>& patch, const TriangleMesh<S>& shape,
                       const WrapDef<S>& def) {
  using std::abs;
  require_not_negative("WrapDef::offset", def.offset);
  require(def.reach > S(0), "WrapDef::reach", def.reach, "must be > 0");
  require_pose("WrapDef::X_SM", def.X_SM);
  validate_surface(patch.mesh);
  validate_surface(shape);
  require(patch.normals.size() == patch.mesh.vertices.size(), "PatchMesh::normals: size",
          patch.normals.size(),
          "must be the number of vertices, " + std::to_string(patch.mesh.vertices.size()));
  for (std::size_t i = 0; i < patch.normals.size(); ++i) {
    const S length = patch.normals[i].norm();
    require(length == S(0) || abs(length - S(1)) <= Tolerance<S>::equal(),
            "PatchMesh::normals[" + std::to_string(i) + "]: length", length, "must be 0 or 1");
  }
}

/// The mesh of the vertices that `is_kept` and of the triangles between them. `dropped` receives
/// the indices of the other triangles.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> kept_part(const TriangleMesh<S>& mesh,
                                        const DynamicArray<bool>& is_kept,
                                        std::vector<std::uint32_t>& dropped) {
  TriangleMesh<S> part;
  DynamicArray<bool> is_used(mesh.vertices.size(), false);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    if (is_kept[a] && is_kept[b] && is_kept[c]) {
      part.triangles.push_back(mesh.triangles[t]);
      is_used[a] = is_used[b] = is_used[c] = true;
    } else {
      dropped.push_back(t);
    }
  }
  DynamicArray<std::uint32_t> renumber(mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    renumber[v] = static_cast<std::uint32_t>(part.vertices.size());
    if (is_used[v]) part.vertices.push_back(mesh.vertices[v]);
  }
  for (auto& triangle : part.triangles) {
    for (std::uint32_t& v : triangle) v = renumber[v];
  }
  return part;
}

}  // namespace detail

template <Scalar S>
TriangleMesh<S> wrap_patch(const PatchMesh<S>& patch, const TriangleMesh<S>& shape,
                           const WrapDef<S>& def, WrapReport* report) {
  detail::require_wrappable(patch, shape, def);
  const TriangleMesh<S> target = without_triangles<S>(shape, degenerate_triangles(shape));
  const detail::RayMesh<S> surface(target.triangles.size(), [&target](std::uint32_t t) {
    const auto& [a, b, c] = target.triangles[t];
    return std::array<Vec3<S>, 3>{target.vertices[a], target.vertices[b], target.vertices[c]};
  });

  WrapReport result;
  TriangleMesh<S> moved = patch.mesh;
  detail::DynamicArray<bool> is_kept(moved.vertices.size(), false);
  for (std::uint32_t v = 0; v < moved.vertices.size(); ++v) {
    if (patch.normals[v] == detail::zero<Vec3<S>>()) {
      result.without_normal.push_back(v);
      continue;
    }
    const Ray<S> ray{def.X_SM * moved.vertices[v],
                     Vec3<S>(-def.X_SM.rotate(patch.normals[v]).normalized()), def.reach};
    const detail::MeshCrossings<S> met = detail::mesh_crossings(surface, ray);
    if (!(met.distance <= ray.length && met.distance < infinity<S>)) {
      result.missed.push_back(v);
      continue;
    }
    const Vec3<S> normal = triangle_normal(target, met.triangle);
    if (!(normal.dot(ray.direction) < S(0))) {
      result.met_from_behind.push_back(v);
    } else if (met.distance < def.offset) {
      result.too_near.push_back(v);
    } else {
      const Vec3<S> out = def.offset_along == WrapOffset::ray ? Vec3<S>(-ray.direction) : normal;
      moved.vertices[v] = ray.origin + met.distance * ray.direction + def.offset * out;
      is_kept[v] = true;
    }
  }
  moved = detail::kept_part(moved, is_kept, result.dropped_faces);
  if (report != nullptr) *report = std::move(result);
  return moved;
}

}  // namespace bristle::inline BRISTLE_ABI
