/// @file
/// Uses of a mesh by loaders after they read it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/sensors/placement.hpp>

namespace bristle::test {

/// Calls an action that may refuse its data.
template <typename Action>
void may_refuse(Action&& action) {
  try {
    action();
  } catch (const InvalidArgument&) {
    // A mesh that can be read need not be good for anything.
  }
}

inline void use_mesh(const TriangleMesh<double>& mesh) {
  may_refuse([&] { validate_solid(weld(mesh)); });
  may_refuse([&] { (void)convex_hull(mesh); });
  may_refuse([&] { (void)sensors_from_mesh<double>(mesh, {.vertices = true, .edges = true}); });
}

}  // namespace bristle::test
