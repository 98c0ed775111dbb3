/// @file
/// Bullet's collision shapes as bristle's.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>
#include <bristle/hosts/bullet_conversions.hpp>
#include <bristle/hosts/engine_mesh.hpp>

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <btBulletCollisionCommon.h>
#include <cmath>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Collects the triangles of a mesh of Bullet's.
struct BulletTriangles : btTriangleCallback {
  std::vector<Vec3<double>> corners;
  void processTriangle(btVector3* triangle, int, int) override {
    for (int k = 0; k < 3; ++k) corners.push_back(from_bullet(triangle[k]));
  }
};

/// Appends the shapes that match one of Bullet's, in the frame X of the body.
/// @throws InvalidArgument when a shape of bristle matches none of them.
inline void add_bullet_shapes(const btCollisionShape& shape, const btTransform& X,
                              std::vector<ShapeDef<double>>& out) {
  if (const auto* all = dynamic_cast<const btCompoundShape*>(&shape)) {
    for (int i = 0; i < all->getNumChildShapes(); ++i) {
      add_bullet_shapes(*all->getChildShape(i), X * all->getChildTransform(i), out);
    }
    return;
  }
  ShapeDef<double> def;
  def.X_BS = from_bullet(X);
  // Bullet's rotationally symmetric shapes lie along one of three axes, bristle's along z.
  const auto turn_to = [&](int axis) {
    const double half = std::sqrt(0.5);
    const Quat<double> turns[] = {{half, 0, half, 0}, {half, -half, 0, 0}, {1, 0, 0, 0}};
    def.X_BS.rotation = def.X_BS.rotation * turns[axis];
  };
  const auto number = [](btScalar x) { return static_cast<double>(x); };
  if (const auto* box = dynamic_cast<const btBoxShape*>(&shape)) {
    def.shape = Box<double>{from_bullet(box->getHalfExtentsWithMargin())};
  } else if (const auto* ball = dynamic_cast<const btSphereShape*>(&shape)) {
    def.shape = Sphere<double>{number(ball->getRadius())};
  } else if (const auto* capsule = dynamic_cast<const btCapsuleShape*>(&shape)) {
    turn_to(capsule->getUpAxis());
    def.shape = Capsule<double>{number(capsule->getRadius()), number(capsule->getHalfHeight())};
  } else if (const auto* cylinder = dynamic_cast<const btCylinderShape*>(&shape)) {
    turn_to(cylinder->getUpAxis());
    const btVector3 half = cylinder->getHalfExtentsWithMargin();
    def.shape =
        Cylinder<double>{number(cylinder->getRadius()), number(half[cylinder->getUpAxis()])};
  } else if (const auto* cone = dynamic_cast<const btConeShape*>(&shape)) {
    turn_to(cone->getConeUpIndex());
    def.shape = Cone<double>{number(cone->getRadius()), 0.5 * number(cone->getHeight())};
  } else if (const auto* plane = dynamic_cast<const btStaticPlaneShape*>(&shape)) {
    const Vec3<double> n = from_bullet(plane->getPlaneNormal());
    def.shape = HalfSpace<double>{n.normalized(), number(plane->getPlaneConstant()) / n.norm()};
  } else if (const auto* polyhedron = dynamic_cast<const btPolyhedralConvexShape*>(&shape);
             polyhedron != nullptr && polyhedron->getNumVertices() > 0) {
    std::vector<Vec3<double>> points;
    for (int i = 0; i < polyhedron->getNumVertices(); ++i) {
      btVector3 point;
      polyhedron->getVertex(i, point);
      points.push_back(from_bullet(point));
    }
    def.shape = convex_hull<double>(points);
  } else if (const auto* mesh = dynamic_cast<const btConcaveShape*>(&shape)) {
    btVector3 low, high;
    mesh->getAabb(btTransform::getIdentity(), low, high);
    BulletTriangles triangles;
    mesh->processAllTriangles(&triangles, low, high);
    def.shape = engine_mesh(std::move(triangles.corners));
  } else {
    require(false, "btCollisionShape", shape.getName(),
            "must be a box, sphere, capsule, cylinder, cone, plane, polyhedron, mesh or compound");
  }
  out.push_back(std::move(def));
}

/// The shapes that match one of Bullet's, in the frame of its body. Polyhedra and cones are without
/// Bullet's margin. A mesh must be closed.
/// @throws InvalidArgument when no shape of bristle matches.
[[nodiscard]] inline std::vector<ShapeDef<double>> shapes_of(const btCollisionShape& shape) {
  std::vector<ShapeDef<double>> shapes;
  add_bullet_shapes(shape, btTransform::getIdentity(), shapes);
  return shapes;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
