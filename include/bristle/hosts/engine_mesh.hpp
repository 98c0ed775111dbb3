/// @file
/// Meshes of engines, which list triangles without regard to seams and sides, as bristle's.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/math/types.hpp>

#include <cstdint>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Mesh of an engine's triangles. Equal corners become one vertex, triangles that repeat a corner
/// vanish, and a closed mesh faces outwards. The mesh of an open surface is open.
/// @param corners  [m] Three of each triangle.
/// @throws InvalidArgument when a corner is not finite.
[[nodiscard]] inline TriangleMesh<double> engine_mesh(std::vector<Vec3<double>> corners) {
  TriangleMesh<double> mesh;
  mesh.vertices = std::move(corners);
  for (std::uint32_t i = 0; i + 2 < mesh.vertices.size(); i += 3) {
    mesh.triangles.push_back({i, i + 1, i + 2});
  }
  mesh = weld(mesh);
  std::erase_if(mesh.triangles,
                [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  if (signed_volume(mesh) < 0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
