/// @file
/// MuJoCo's geoms as bristle's shapes, and its sites as layouts of sensors.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/meshes/terrain.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/math/transform.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/sensor_layout.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <mujoco/mujoco.h>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// The vector of three of MuJoCo's numbers.
[[nodiscard]] inline Vec3<double> mujoco_vector(const mjtNum* x) { return {x[0], x[1], x[2]}; }

/// Pose number i of MuJoCo's arrays of places and quaternions.
[[nodiscard]] inline Transform<double> mujoco_pose(const mjtNum* places, const mjtNum* rotations,
                                                   int i) {
  const mjtNum* q = rotations + 4 * i;
  return {Quat<double>(q[0], q[1], q[2], q[3]).normalized(), mujoco_vector(places + 3 * i)};
}

/// The mesh of a mesh geom, in the frame of the geom.
[[nodiscard]] inline TriangleMesh<double> mujoco_mesh(const mjModel& model, int geom) {
  const int number = model.geom_dataid[geom];
  TriangleMesh<double> mesh;
  const float* vertex = model.mesh_vert + 3 * model.mesh_vertadr[number];
  for (int i = 0; i < model.mesh_vertnum[number]; ++i, vertex += 3) {
    mesh.vertices.push_back({static_cast<double>(vertex[0]), static_cast<double>(vertex[1]),
                             static_cast<double>(vertex[2])});
  }
  const int* face = model.mesh_face + 3 * model.mesh_faceadr[number];
  for (int i = 0; i < model.mesh_facenum[number]; ++i, face += 3) {
    mesh.triangles.push_back({static_cast<std::uint32_t>(face[0]),
                              static_cast<std::uint32_t>(face[1]),
                              static_cast<std::uint32_t>(face[2])});
  }
  return mesh;
}

/// The shape of a geom, in the frame of its body. A mesh is its convex hull, as MuJoCo collides it.
/// A height field is as it is now, as thick all over as MuJoCo has it below its zero.
/// @throws InvalidArgument when the geom is of a kind that has no shape.
[[nodiscard]] inline ShapeDef<double> mujoco_shape(const mjModel& model, int geom) {
  const Vec3<double> size = mujoco_vector(model.geom_size + 3 * geom);
  ShapeDef<double> def;
  def.X_BS = mujoco_pose(model.geom_pos, model.geom_quat, geom);
  switch (model.geom_type[geom]) {
    case mjGEOM_PLANE:
      def.shape = HalfSpace<double>{};
      break;
    case mjGEOM_SPHERE:
      def.shape = Sphere<double>{size.x()};
      break;
    case mjGEOM_CAPSULE:
      def.shape = Capsule<double>{size.x(), size.y()};
      break;
    case mjGEOM_CYLINDER:
      def.shape = Cylinder<double>{size.x(), size.y()};
      break;
    case mjGEOM_ELLIPSOID:
      def.shape = Ellipsoid<double>{size};
      break;
    case mjGEOM_BOX:
      def.shape = Box<double>{size};
      break;
    case mjGEOM_MESH:
      def.shape = convex_hull<double>(mujoco_mesh(model, geom).vertices);
      break;
    case mjGEOM_HFIELD: {
      const int field = model.geom_dataid[geom];
      const mjtNum* sizes = model.hfield_size + 4 * field;
      const int rows = model.hfield_nrow[field];
      const int columns = model.hfield_ncol[field];
      std::vector<double> heights(static_cast<std::size_t>(rows * columns));
      const float* next = model.hfield_data + model.hfield_adr[field];
      for (double& height : heights) height = sizes[2] * static_cast<double>(*next++);
      const std::array<std::uint32_t, 2> cells{static_cast<std::uint32_t>(columns - 1),
                                               static_cast<std::uint32_t>(rows - 1)};
      def.shape = extruded_mesh<double>(
          height_field_mesh<double>({2 * sizes[0], 2 * sizes[1]}, cells, heights),
          {0, 0, -sizes[3]});
      break;
    }
    default:
      require(false, "geom", geom, "must be of a kind that has a shape");
  }
  return def;
}

/// The shapes of all geoms of a body.
/// @throws InvalidArgument when a geom is of a kind that has no shape.
[[nodiscard]] inline std::vector<ShapeDef<double>> mujoco_shapes(const mjModel& model, int body) {
  std::vector<ShapeDef<double>> shapes;
  for (int i = 0; i < model.body_geomnum[body]; ++i) {
    shapes.push_back(mujoco_shape(model, model.body_geomadr[body] + i));
  }
  return shapes;
}

/// Rays over the x and y of a site, from its lower face to its upper one along z, in the frame of
/// its body.
/// @throws InvalidArgument when the site is no box.
[[nodiscard]] inline SensorLayout<double> mujoco_pad(const mjModel& model, int site,
                                                     std::uint32_t rows, std::uint32_t columns) {
  require(model.site_type[site] == mjGEOM_BOX, "site", mj_id2name(&model, mjOBJ_SITE, site),
          "must be of type box");
  const Transform<double> X_BS = mujoco_pose(model.site_pos, model.site_quat, site);
  const Vec3<double> half = mujoco_vector(model.site_size + 3 * site);
  SensorLayout<double> sensors;
  for (std::uint32_t i = 0; i < rows; ++i) {
    for (std::uint32_t j = 0; j < columns; ++j) {
      const double x = half.x() * ((2.0 * i + 1) / rows - 1);
      const double y = half.y() * ((2.0 * j + 1) / columns - 1);
      sensors.add(X_BS * Vec3<double>(x, y, -half.z()), X_BS * Vec3<double>(x, y, half.z()));
    }
  }
  return sensors;
}

/// Rays over the faces, vertices or edges of a mesh geom, in the frame of its body.
/// @throws InvalidArgument when the geom is no mesh, or as `sensors_from_mesh`.
[[nodiscard]] inline SensorLayout<double> mujoco_skin(const mjModel& model, int geom,
                                                      PlacementDef<double> def) {
  require(model.geom_type[geom] == mjGEOM_MESH, "geom", mj_id2name(&model, mjOBJ_GEOM, geom),
          "must be of type mesh");
  def.X_AM = mujoco_pose(model.geom_pos, model.geom_quat, geom) * def.X_AM;
  return sensors_from_mesh(mujoco_mesh(model, geom), def);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
