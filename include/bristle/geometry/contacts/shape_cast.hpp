/// @file
/// Shapes converted to another scalar.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/shapes.hpp>

namespace bristle::inline BRISTLE_ABI::detail {

/// Converts a convex shape or half-space to another scalar. Hulls keep their numbers.
template <Scalar P, Scalar S>
struct ShapeCast {
  Shape<P> operator()(const Sphere<S>& s) const { return Sphere<P>{P(s.radius)}; }
  Shape<P> operator()(const Box<S>& s) const { return Box<P>{s.half_extents.template cast<P>()}; }
  Shape<P> operator()(const Capsule<S>& s) const {
    return Capsule<P>{P(s.radius), P(s.half_length)};
  }
  Shape<P> operator()(const Cylinder<S>& s) const {
    return Cylinder<P>{P(s.radius), P(s.half_length)};
  }
  Shape<P> operator()(const Cone<S>& s) const { return Cone<P>{P(s.radius), P(s.half_length)}; }
  Shape<P> operator()(const Ellipsoid<S>& s) const {
    return Ellipsoid<P>{s.radii.template cast<P>()};
  }
  Shape<P> operator()(const HalfSpace<S>& s) const {
    return HalfSpace<P>{s.normal.template cast<P>(), P(s.offset)};
  }
  Shape<P> operator()(const ConvexHull<S>& s) const {
    ConvexHull<P> hull;
    for (const Vec3<S>& v : s.vertices) hull.vertices.push_back(v.template cast<P>());
    hull.face_vertices = s.face_vertices;
    hull.face_starts = s.face_starts;
    for (const Vec3<S>& n : s.face_normals) {
      hull.face_normals.push_back(n.template cast<P>().normalized());
    }
    hull.face_offsets.assign(s.face_offsets.begin(), s.face_offsets.end());
    return hull;
  }
  // Meshes are read through their trees.
  Shape<P> operator()(const TriangleMesh<S>&) const { return Sphere<P>{}; }
};

}  // namespace bristle::inline BRISTLE_ABI::detail
