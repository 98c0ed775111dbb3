/// @file
/// A ball within a shape. Two shapes are deep in each other where each has its middle in the
/// other's ball.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/geometry/shapes/visit_shape.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cstddef>
#include <variant>

namespace bristle::inline BRISTLE_ABI::detail {

/// A ball that lies in a shape. A radius of 0 says that none is known.
template <Scalar S>
struct InnerBall {
  Vec3<S> center = zero<Vec3<S>>();  // [m]
  S radius = S(0);                   // [m]
};

/// Returns a large ball in a shape, in the shape's own frame: the largest of round shapes and
/// boxes, for hulls the one about the mean of the corners. None is known of meshes and half-spaces.
///
/// @pre `validate(shape)` has passed.
template <Scalar S>
[[nodiscard]] InnerBall<S> inner_ball(const Shape<S>& shape);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
struct FindInnerBall {
  InnerBall<S> operator()(const Sphere<S>& s) const { return {.radius = s.radius}; }
  InnerBall<S> operator()(const Box<S>& s) const { return {.radius = s.half_extents.minCoeff()}; }
  InnerBall<S> operator()(const Capsule<S>& s) const { return {.radius = s.radius}; }
  InnerBall<S> operator()(const Cylinder<S>& s) const {
    return {.radius = std::min(s.radius, s.half_length)};
  }
  InnerBall<S> operator()(const Cone<S>& s) const {
    // The incircle of its triangle: twice the area over the circumference.
    const S height = S(2) * s.half_length;
    const S radius = s.radius * height / (s.radius + Vec2<S>(s.radius, height).norm());
    return {{S(0), S(0), radius - s.half_length}, radius};
  }
  InnerBall<S> operator()(const Ellipsoid<S>& s) const { return {.radius = s.radii.minCoeff()}; }
  InnerBall<S> operator()(const HalfSpace<S>&) const { return {}; }
  InnerBall<S> operator()(const ConvexHull<S>& s) const {
    InnerBall<S> ball;
    for (const Vec3<S>& v : s.vertices) ball.center += v / S(s.vertices.size());
    ball.radius = infinity<S>;
    for (std::size_t f = 0; f < s.face_count(); ++f) {
      const S depth = s.face_normals[f].dot(s.vertices[s.face(f)[0]] - ball.center);
      ball.radius = std::min(ball.radius, std::max(S(0), depth));
    }
    return ball;
  }
  InnerBall<S> operator()(const TriangleMesh<S>&) const { return {}; }
};

template <Scalar S>
InnerBall<S> inner_ball(const Shape<S>& shape) {
  return visit_shape(FindInnerBall<S>{}, shape);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
