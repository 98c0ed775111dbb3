/// @file
/// DART's shapes as bristle's.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/hosts/engine_mesh.hpp>
#include <bristle/math/transform.hpp>

#include <assimp/scene.h>
#include <cstddef>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/CapsuleShape.hpp>
#include <dart/dynamics/ConeShape.hpp>
#include <dart/dynamics/CylinderShape.hpp>
#include <dart/dynamics/EllipsoidShape.hpp>
#include <dart/dynamics/MeshShape.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/PyramidShape.hpp>
#include <dart/dynamics/ShapeNode.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// The same pose.
[[nodiscard]] inline Transform<double> dart_pose(const Eigen::Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  return {Quat<double>(q.w(), q.x(), q.y(), q.z()).normalized(), Vec3<double>(X.translation())};
}

/// The triangles of all meshes of a scene, as DART collides them: without the poses of its nodes.
[[nodiscard]] inline TriangleMesh<double> dart_mesh(const dart::dynamics::MeshShape& shape) {
  std::vector<Vec3<double>> corners;
  const aiScene& scene = *shape.getMesh();
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      require(mesh.mFaces[f].mNumIndices == 3, "MeshShape: corners of a face",
              mesh.mFaces[f].mNumIndices, "must be 3");
      for (unsigned k = 0; k < 3; ++k) {
        const aiVector3D& v = mesh.mVertices[mesh.mFaces[f].mIndices[k]];
        const Vec3<double> place(static_cast<double>(v.x), static_cast<double>(v.y),
                                 static_cast<double>(v.z));
        corners.push_back(place.cwiseProduct(shape.getScale()));
      }
    }
  }
  return engine_mesh(std::move(corners));
}

/// The shape of a shape node, in the frame of its body.
/// @throws InvalidArgument when no shape of bristle matches.
[[nodiscard]] inline ShapeDef<double> dart_shape(const dart::dynamics::ShapeNode& node) {
  namespace shapes = dart::dynamics;
  const shapes::Shape* shape = node.getShape().get();
  ShapeDef<double> def;
  def.X_BS = dart_pose(node.getRelativeTransform());
  if (const auto* box = dynamic_cast<const shapes::BoxShape*>(shape)) {
    def.shape = Box<double>{Vec3<double>(0.5 * box->getSize())};
  } else if (const auto* ball = dynamic_cast<const shapes::SphereShape*>(shape)) {
    def.shape = Sphere<double>{ball->getRadius()};
  } else if (const auto* capsule = dynamic_cast<const shapes::CapsuleShape*>(shape)) {
    def.shape = Capsule<double>{capsule->getRadius(), 0.5 * capsule->getHeight()};
  } else if (const auto* cylinder = dynamic_cast<const shapes::CylinderShape*>(shape)) {
    def.shape = Cylinder<double>{cylinder->getRadius(), 0.5 * cylinder->getHeight()};
  } else if (const auto* cone = dynamic_cast<const shapes::ConeShape*>(shape)) {
    def.shape = Cone<double>{cone->getRadius(), 0.5 * cone->getHeight()};
  } else if (const auto* pyramid = dynamic_cast<const shapes::PyramidShape*>(shape)) {
    const double x = 0.5 * pyramid->getBaseWidth();
    const double y = 0.5 * pyramid->getBaseDepth();
    const double z = 0.5 * pyramid->getHeight();
    def.shape = convex_hull<double>(
        std::vector<Vec3<double>>{{x, y, -z}, {x, -y, -z}, {-x, y, -z}, {-x, -y, -z}, {0, 0, z}});
  } else if (const auto* ellipsoid = dynamic_cast<const shapes::EllipsoidShape*>(shape)) {
    def.shape = Ellipsoid<double>{Vec3<double>(ellipsoid->getRadii())};
  } else if (const auto* plane = dynamic_cast<const shapes::PlaneShape*>(shape)) {
    def.shape = HalfSpace<double>{Vec3<double>(plane->getNormal()), plane->getOffset()};
  } else if (const auto* mesh = dynamic_cast<const shapes::MeshShape*>(shape)) {
    def.shape = dart_mesh(*mesh);
  } else {
    require(false, "BodyNode: shape", shape->getType().c_str(),
            "must be a box, sphere, capsule, cylinder, cone, pyramid, ellipsoid, plane or mesh");
  }
  return def;
}

/// The shapes that a body collides by, or all of its shape nodes where it collides by none. A mesh
/// must be closed.
/// @throws InvalidArgument when no shape of bristle matches one of them.
[[nodiscard]] inline std::vector<ShapeDef<double>> dart_shapes(
    const dart::dynamics::BodyNode& node) {
  const bool collides = node.getNumShapeNodesWith<dart::dynamics::CollisionAspect>() > 0;
  std::vector<ShapeDef<double>> shapes;
  for (std::size_t i = 0; i < node.getNumShapeNodes(); ++i) {
    const dart::dynamics::ShapeNode& shape = *node.getShapeNode(i);
    if (!collides || shape.hasCollisionAspect()) shapes.push_back(dart_shape(shape));
  }
  return shapes;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
