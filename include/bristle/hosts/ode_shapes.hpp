/// @file
/// ODE's geoms as bristle's shapes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/hosts/engine_mesh.hpp>
#include <bristle/hosts/ode_conversions.hpp>

#include <ode/ode.h>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// ODE's name of a geom's class.
[[nodiscard]] inline const char* ode_class_name(dGeomID geom) {
  constexpr const char* names[] = {"sphere", "box",    "capsule",   "cylinder", "plane",
                                   "ray",    "convex", "transform", "trimesh",  "heightfield"};
  const int number = dGeomGetClass(geom);
  return number < dFirstSpaceClass ? names[number] : number < dFirstUserClass ? "space" : "user";
}

/// The triangles of a mesh geom, in its own frame.
[[nodiscard]] inline TriangleMesh<double> ode_mesh(dGeomID geom) {
  // ODE lists them in the world, and may round them there: corners that were equal stay equal.
  dQuaternion q;
  dGeomGetQuaternion(geom, q);
  const Transform<double> X_GW = ode_transform(q, dGeomGetPosition(geom)).inverse();
  std::vector<Vec3<double>> corners;
  for (int i = 0; i < dGeomTriMeshGetTriangleCount(geom); ++i) {
    dVector3 triangle[3];
    dGeomTriMeshGetTriangle(geom, i, &triangle[0], &triangle[1], &triangle[2]);
    for (const dVector3& corner : triangle) corners.push_back(X_GW * ode_vector(corner));
  }
  return engine_mesh(std::move(corners));
}

/// The shape of a geom in the frame of its body.
/// @throws InvalidArgument naming the class of a geom that has no shape of bristle's like it. ODE
///         does not disclose the points of convex geoms, nor the heights of height fields.
[[nodiscard]] inline ShapeDef<double> ode_shape(dGeomID geom, const Transform<double>& X_BS) {
  ShapeDef<double> def;
  def.X_BS = X_BS;
  dVector4 size;
  switch (dGeomGetClass(geom)) {
    case dPlaneClass:
      dGeomPlaneGetParams(geom, size);
      def.shape = HalfSpace<double>{ode_vector(size), size[3]};
      break;
    case dSphereClass:
      def.shape = Sphere<double>{dGeomSphereGetRadius(geom)};
      break;
    case dCapsuleClass:
      dGeomCapsuleGetParams(geom, &size[0], &size[1]);
      def.shape = Capsule<double>{size[0], size[1] / 2};
      break;
    case dCylinderClass:
      dGeomCylinderGetParams(geom, &size[0], &size[1]);
      def.shape = Cylinder<double>{size[0], size[1] / 2};
      break;
    case dBoxClass:
      dGeomBoxGetLengths(geom, size);
      def.shape = Box<double>{ode_vector(size) / 2};
      break;
    case dTriMeshClass:
      def.shape = ode_mesh(geom);
      break;
    default:
      require(false, "geom", ode_class_name(geom),
              "must be a plane, box, sphere, capsule, cylinder or mesh of triangles");
  }
  return def;
}

/// The shapes of a body's present geoms. Rays among them are left out. A mesh must be closed.
/// @throws InvalidArgument as for one geom.
[[nodiscard]] inline std::vector<ShapeDef<double>> ode_shapes(dBodyID body) {
  std::vector<ShapeDef<double>> shapes;
  for (dGeomID geom = dBodyGetFirstGeom(body); geom != nullptr; geom = dBodyGetNextGeom(geom)) {
    if (dGeomGetClass(geom) == dRayClass) continue;
    dQuaternion q;
    dGeomGetOffsetQuaternion(geom, q);
    shapes.push_back(ode_shape(geom, ode_transform(q, dGeomGetOffsetPosition(geom))));
  }
  return shapes;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
