/// @file
/// The meshes that the scenes of examples/scenes/ name; a test holds the files to them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/meshes/mesh_shapes.hpp>

#include <utility>

namespace bristle::test {

/// A rectangle of 24 mm x 20 mm in the plane y = 0, facing -y: the skin of a finger.
inline TriangleMesh<double> pad_mesh() {
  TriangleMesh<double> mesh = grid_mesh<double>({0.024, 0.02}, {2, 2});
  for (Vec3<double>& v : mesh.vertices) v = {v.x(), 0.0, v.y()};
  return mesh;
}

/// A square of 60 mm in the plane z = -30 mm, facing down: the sole of a box.
inline TriangleMesh<double> sole_mesh() {
  TriangleMesh<double> mesh = grid_mesh<double>({0.06, 0.06}, {4, 4});
  for (Vec3<double>& v : mesh.vertices) v.z() = -0.03;
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

}  // namespace bristle::test
