/// @file
/// Solids from the meshes of an AMBF description.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/io/adf/adf_limits.hpp>
#include <bristle/io/adf/adf_meshes.hpp>
#include <bristle/io/adf/adf_model.hpp>
#include <bristle/io/adf/adf_report.hpp>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Converts a mesh to a solid: without triangles of no area, and facing outwards. Returns none if
/// the mesh is open.
template <Scalar S>
[[nodiscard]] std::optional<TriangleMesh<S>> closed_solid(const TriangleMesh<S>& mesh) {
  const std::vector<std::uint32_t> flat = degenerate_triangles(mesh);
  TriangleMesh<S> solid = flat.empty() ? mesh : without_triangles<S>(mesh, flat);
  if (solid.triangles.empty()) return std::nullopt;
  if (signed_volume(solid) < S(0)) {
    for (auto& t : solid.triangles) std::swap(t[1], t[2]);
  }
  try {
    validate_solid(solid);
  } catch (const InvalidArgument&) {
    return std::nullopt;
  }
  return solid;
}

/// Key of a body's collision mesh.
[[nodiscard]] inline const char* collision_mesh_key(const AdfBody& body) {
  return body.collision_mesh == body.visual_mesh ? "mesh" : "collision mesh";
}

/// Solids by file, type and scale, each built once.
template <Scalar S>
class AdfSolids {
 public:
  AdfSolids(const AdfModel& model, const AdfLimits& limits, AdfMeshes<S>& meshes, AdfReport& report)
      : model_(model), limits_(limits), meshes_(meshes), report_(report) {}

  /// Collision shape of a body with a mesh.
  /// @throws AdfError as `AdfMeshes::load`, if the mesh spans no volume, or if the bodies collide
  ///         with more triangles than the limit.
  [[nodiscard]] const Shape<S>& of(const AdfBody& body) {
    const TriangleMesh<S>& mesh = meshes_.load(body, collision_mesh_key(body), body.collision_mesh,
                                               AdfResolution::low, &body);
    const auto [at, is_new] = solids_.try_emplace({&mesh, body.mesh_type, body.scale});
    Solid& solid = at->second;
    if (is_new) {
      count(body, mesh.triangles.size());
      solid = made_of(mesh, body);
    }
    count(body, solid.triangles);
    if (solid.stands_for_open) {
      report_.add(AdfNoteKind::changed, body.key + "/collision mesh",
                  "no closed solid: its convex hull is taken", body.line);
    }
    return solid.shape;
  }

 private:
  struct Solid {
    Shape<S> shape;
    std::size_t triangles = 0;
    /// True for a hull in place of an open mesh.
    bool stands_for_open = false;
  };

  [[nodiscard]] Solid made_of(TriangleMesh<S> mesh, const AdfBody& body) const {
    for (Vec3<S>& v : mesh.vertices) v *= S(body.scale);
    const bool is_mesh = body.mesh_type == AdfMeshType::concave;
    if (is_mesh) {
      if (std::optional<TriangleMesh<S>> closed = closed_solid(mesh)) {
        const std::size_t triangles = closed->triangles.size();
        return {std::move(*closed), triangles, false};
      }
    }
    try {
      ConvexHull<S> hull = convex_hull(mesh);
      // A face of n corners is n - 2 triangles.
      const std::size_t triangles = hull.face_vertices.size() - 2 * hull.face_count();
      return {std::move(hull), triangles, is_mesh};
    } catch (const InvalidArgument& error) {
      fail(body, std::string("must have a convex hull: ") + error.what());
    }
  }

  void count(const AdfBody& body, std::size_t more) {
    triangles_ += more;
    if (triangles_ > limits_.max_triangles) {
      fail(body, "more than " + std::to_string(limits_.max_triangles) +
                     " triangles that bodies collide with");
    }
  }

  [[noreturn]] void fail(const AdfBody& body, std::string rule) const {
    raise(AdfError(model_.file.string(), body.line, body.key + "/" + collision_mesh_key(body),
                   printable(body.collision_mesh), std::move(rule)));
  }

  const AdfModel& model_;
  const AdfLimits& limits_;
  AdfMeshes<S>& meshes_;
  AdfReport& report_;
  std::map<std::tuple<const TriangleMesh<S>*, AdfMeshType, double>, Solid> solids_;
  std::size_t triangles_ = 0;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
