/// @file
/// Conversion of shapes to FCL geometry and back. Includes FCL's shapes and its mesh tree, none of
/// its collision code.
///
/// FCL's geometry is always in double, for every scalar of the user. Float converts to it without
/// loss, and FCL's own float instances cost every translation unit about a minute of compile time.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/fcl_geometry.hpp>
#include <bristle/geometry/backends/fcl_mesh_tree.hpp>
#include <bristle/geometry/shapes/shapes.hpp>

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/ellipsoid.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Converts a shape to FCL geometry and computes its local box. Axes, origin and sizes mean the
/// same in both.
///
/// @pre `validate(shape)` has passed.
/// @throws InvalidArgument if FCL refuses the mesh (more than 2^31 - 1 vertices or triangles).
template <Scalar S>
[[nodiscard]] FclGeometry to_fcl(const Shape<S>& shape);

/// An FCL geometry as a `Shape`, with the mesh left inside FCL. The alternatives are in the order
/// of `ShapeKind`.
template <Scalar S>
using FclView = std::variant<Sphere<S>, Box<S>, Capsule<S>, Cylinder<S>, Cone<S>, Ellipsoid<S>,
                             HalfSpace<S>, ConvexHull<S>, FclMeshTree<S>>;

/// Reads sizes and data from an FCL object. A mesh must outlive the result.
///
/// Faces of a `Convex` get planes here; FCL stores none. FCL's data must be as FCL documents it:
/// flat convex faces, counter-clockwise from outside.
///
/// @throws InvalidArgument for geometry without a shape in bristle: planes, octrees, point clouds,
///         meshes over other boxes than `FclMesh`, meshes without their tree.
template <Scalar S>
[[nodiscard]] FclView<S> from_fcl(const fcl::CollisionGeometry<S>& geometry);

// Implementation ----------------------------------------------------------------------------------

/// One FCL geometry for each alternative of `Shape`.
template <Scalar S>
struct FclGeometryMaker {
  using Geometry = std::shared_ptr<fcl::CollisionGeometry<double>>;

  Geometry operator()(const Sphere<S>& s) const {
    return std::make_shared<fcl::Sphere<double>>(double(s.radius));
  }
  Geometry operator()(const Box<S>& s) const {
    return std::make_shared<fcl::Box<double>>(2.0 * s.half_extents.template cast<double>());
  }
  // `lz` is the height without the caps.
  Geometry operator()(const Capsule<S>& s) const {
    return std::make_shared<fcl::Capsule<double>>(double(s.radius), 2.0 * double(s.half_length));
  }
  Geometry operator()(const Cylinder<S>& s) const {
    return std::make_shared<fcl::Cylinder<double>>(double(s.radius), 2.0 * double(s.half_length));
  }
  Geometry operator()(const Cone<S>& s) const {
    return std::make_shared<fcl::Cone<double>>(double(s.radius), 2.0 * double(s.half_length));
  }
  Geometry operator()(const Ellipsoid<S>& s) const {
    return std::make_shared<fcl::Ellipsoid<double>>(s.radii.template cast<double>());
  }
  Geometry operator()(const HalfSpace<S>& s) const {
    return std::make_shared<fcl::Halfspace<double>>(s.normal.template cast<double>(),
                                                    double(s.offset));
  }
  Geometry operator()(const ConvexHull<S>& s) const {
    auto faces = std::make_shared<std::vector<int>>();
    for (std::size_t f = 0; f < s.face_count(); ++f) {
      faces->push_back(static_cast<int>(s.face(f).size()));
      for (const std::uint32_t v : s.face(f)) faces->push_back(static_cast<int>(v));
    }
    auto vertices = std::make_shared<const std::vector<Vec3<double>>>(cast(s.vertices));
    return std::make_shared<fcl::Convex<double>>(std::move(vertices),
                                                 static_cast<int>(s.face_count()), faces);
  }
  Geometry operator()(const TriangleMesh<S>& s) const {
    std::vector<fcl::Triangle> triangles;
    triangles.reserve(s.triangles.size());
    for (const auto& t : s.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    auto mesh = std::make_shared<FclMesh<double>>();
    mesh->beginModel(static_cast<int>(s.triangles.size()), static_cast<int>(s.vertices.size()));
    mesh->addSubModel(cast(s.vertices), triangles);
    const int status = mesh->endModel();
    require(status == fcl::BVH_OK, "TriangleMesh::triangles", static_cast<double>(status),
            "must be a mesh that FCL can build a tree over (BVHModel::endModel)");
    return mesh;
  }

 private:
  static std::vector<Vec3<double>> cast(const std::vector<Vec3<S>>& points) {
    std::vector<Vec3<double>> result;
    result.reserve(points.size());
    for (const Vec3<S>& p : points) result.push_back(p.template cast<double>());
    return result;
  }
};

template <Scalar S>
[[nodiscard]] ConvexHull<S> hull_from_fcl(const fcl::Convex<S>& convex) {
  ConvexHull<S> hull;
  hull.vertices = convex.getVertices();
  hull.face_starts.push_back(0);
  std::size_t next = 0;
  for (int f = 0; f < convex.getFaceCount(); ++f) {
    const auto corners = static_cast<std::size_t>(convex.getFaces()[next++]);
    // Newell's method (Sutherland, Sproull, Schumacker 1974): twice the area vector of a polygon.
    // It is good for any number of corners and for nearly straight ones. Corners are taken relative
    // to the first, so that a hull far from its origin loses nothing.
    Vec3<S> area = zero<Vec3<S>>();
    const Vec3<S>& first = hull.vertices[static_cast<std::size_t>(convex.getFaces()[next])];
    Vec3<S> mean = zero<Vec3<S>>();
    for (std::size_t i = 0; i < corners; ++i) {
      const auto v = static_cast<std::size_t>(convex.getFaces()[next + i]);
      const auto w = static_cast<std::size_t>(convex.getFaces()[next + (i + 1) % corners]);
      area += (hull.vertices[v] - first).cross(hull.vertices[w] - first);
      mean += hull.vertices[v] / S(corners);
      hull.face_vertices.push_back(static_cast<std::uint32_t>(v));
    }
    next += corners;
    hull.face_starts.push_back(static_cast<std::uint32_t>(hull.face_vertices.size()));
    hull.face_normals.push_back(area.normalized());
    hull.face_offsets.push_back(hull.face_normals.back().dot(mean));
  }
  return hull;
}

template <Scalar S>
[[nodiscard]] FclMeshTree<S> mesh_from_fcl(const FclMesh<S>& mesh) {
  require(mesh.getModelType() == fcl::BVH_MODEL_TRIANGLES && mesh.getNumBVs() > 0,
          "fcl::BVHModel::getModelType", static_cast<double>(mesh.getModelType()),
          "must be a mesh of triangles with its tree built (endModel)");
  return FclMeshTree<S>(mesh);
}

template <Scalar S>
FclGeometry to_fcl(const Shape<S>& shape) {
  auto geometry = std::visit(FclGeometryMaker<S>{}, shape);
  geometry->computeLocalAABB();
  return geometry;
}

template <Scalar S>
FclView<S> from_fcl(const fcl::CollisionGeometry<S>& geometry) {
  // The node type names the class (fcl/geometry/collision_geometry.h), so no RTTI is needed.
  switch (geometry.getNodeType()) {
    case fcl::GEOM_SPHERE:
      return Sphere<S>{.radius = static_cast<const fcl::Sphere<S>&>(geometry).radius};
    case fcl::GEOM_BOX:
      return Box<S>{.half_extents = S(0.5) * static_cast<const fcl::Box<S>&>(geometry).side};
    case fcl::GEOM_CAPSULE: {
      const auto& s = static_cast<const fcl::Capsule<S>&>(geometry);
      return Capsule<S>{.radius = s.radius, .half_length = S(0.5) * s.lz};
    }
    case fcl::GEOM_CYLINDER: {
      const auto& s = static_cast<const fcl::Cylinder<S>&>(geometry);
      return Cylinder<S>{.radius = s.radius, .half_length = S(0.5) * s.lz};
    }
    case fcl::GEOM_CONE: {
      const auto& s = static_cast<const fcl::Cone<S>&>(geometry);
      return Cone<S>{.radius = s.radius, .half_length = S(0.5) * s.lz};
    }
    case fcl::GEOM_ELLIPSOID:
      return Ellipsoid<S>{.radii = static_cast<const fcl::Ellipsoid<S>&>(geometry).radii};
    case fcl::GEOM_HALFSPACE: {
      const auto& s = static_cast<const fcl::Halfspace<S>&>(geometry);
      return HalfSpace<S>{.normal = s.n, .offset = s.d};
    }
    case fcl::GEOM_CONVEX:
      return hull_from_fcl(static_cast<const fcl::Convex<S>&>(geometry));
    case fcl::BV_AABB:
      return mesh_from_fcl(static_cast<const FclMesh<S>&>(geometry));
    default:
      raise(InvalidArgument("fcl::CollisionGeometry::getNodeType",
                            std::to_string(geometry.getNodeType()),
                            "must be a type that bristle has a shape for"));
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
