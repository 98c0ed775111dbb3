/// @file
/// View of a convex solid for iterative methods. It is a core, and a radius by which the core is
/// inflated.
///
/// A sphere's core is its centre, a capsule's its segment. Other shapes are their own core. The
/// radius only shifts the surface of cores that are apart. So round parts are exact for any method.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/geometry/shapes/support.hpp>
#include <bristle/geometry/shapes/visit_shape.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

namespace bristle::inline BRISTLE_ABI::detail {

/// View of a shape of support.hpp. Refers to the shape it is made from.
template <Scalar S>
struct ConvexView {
  std::variant<const Sphere<S>*, const Box<S>*, const Capsule<S>*, const Cylinder<S>*,
               const Cone<S>*, const Ellipsoid<S>*, const ConvexHull<S>*, const Plate<S>*>
      shape;
  /// [m] Radius around the core: that of a sphere or capsule, else 0.
  S rounding = S(0);
  /// [m] A point inside, and the distance from it to the farthest point of the solid.
  Vec3<S> center = zero<Vec3<S>>();
  S reach = S(0);

  /// [m] The core's farthest point along a direction of any length > 0, in the solid's frame.
  [[nodiscard]] Vec3<S> support(const Vec3<S>& direction) const;
  /// Returns whether the core has curved parts.
  [[nodiscard]] bool is_curved() const {
    return std::holds_alternative<const Cylinder<S>*>(shape) ||
           std::holds_alternative<const Cone<S>*>(shape) ||
           std::holds_alternative<const Ellipsoid<S>*>(shape);
  }
};

// Scalar of a shape that has a view. A template template parameter over Scalar would do, too. But
// clang 14 crashes when it writes one into a precompiled header.
template <Scalar S>
S scalar_of(const Sphere<S>&);
template <Scalar S>
S scalar_of(const Box<S>&);
template <Scalar S>
S scalar_of(const Capsule<S>&);
template <Scalar S>
S scalar_of(const Cylinder<S>&);
template <Scalar S>
S scalar_of(const Cone<S>&);
template <Scalar S>
S scalar_of(const Ellipsoid<S>&);
template <Scalar S>
S scalar_of(const ConvexHull<S>&);
template <Scalar S>
S scalar_of(const Plate<S>&);

template <typename ConvexShape>
using ScalarOfShape = decltype(scalar_of(std::declval<const ConvexShape&>()));

/// Returns the view of a shape, which must outlive it.
template <typename ConvexShape>
[[nodiscard]] ConvexView<ScalarOfShape<ConvexShape>> convex_view(const ConvexShape& shape);

/// Farthest point, edge and face of the whole solid, as in support.hpp for each shape. So code for
/// pairs of solids is compiled only once.
template <Scalar S>
[[nodiscard]] Vec3<S> support_point(const ConvexView<S>& convex, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_edge(const ConvexView<S>& convex, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_face(const ConvexView<S>& convex, const Vec3<S>& direction);

/// [m] Box around a solid at X.
template <Scalar S>
[[nodiscard]] Aabb<S> bounds_at(const ConvexView<S>& convex, const Transform<S>& X);

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
[[nodiscard]] Vec3<S> support_core(const Sphere<S>&, const Vec3<S>&) {
  return zero<Vec3<S>>();
}
template <Scalar S>
[[nodiscard]] Vec3<S> support_core(const Capsule<S>& s, const Vec3<S>& d) {
  return {S(0), S(0), d.z() < S(0) ? -s.half_length : s.half_length};
}
template <typename ConvexShape, Scalar S>
[[nodiscard]] Vec3<S> support_core(const ConvexShape& s, const Vec3<S>& d) {
  return support_point(s, d);
}

/// Centre and reach of a set of corners.
template <Scalar S>
void measure_corners(ConvexView<S>& convex, std::span<const Vec3<S>> corners) {
  for (const Vec3<S>& p : corners) convex.center += p / S(corners.size());
  for (const Vec3<S>& p : corners) {
    convex.reach = std::max(convex.reach, (p - convex.center).norm());
  }
}

template <Scalar S>
void measure(ConvexView<S>& convex, const Sphere<S>& s) {
  convex.rounding = s.radius;
  convex.reach = s.radius;
}
template <Scalar S>
void measure(ConvexView<S>& convex, const Box<S>& s) {
  convex.reach = s.half_extents.norm();
}
template <Scalar S>
void measure(ConvexView<S>& convex, const Capsule<S>& s) {
  convex.rounding = s.radius;
  convex.reach = s.half_length + s.radius;
}
template <Scalar S>
void measure(ConvexView<S>& convex, const Cylinder<S>& s) {
  convex.reach = Vec2<S>(s.radius, s.half_length).norm();
}
template <Scalar S>
void measure(ConvexView<S>& convex, const Cone<S>& s) {
  convex.reach = Vec2<S>(s.radius, s.half_length).norm();
}
template <Scalar S>
void measure(ConvexView<S>& convex, const Ellipsoid<S>& s) {
  convex.reach = s.radii.maxCoeff();
}
template <Scalar S>
void measure(ConvexView<S>& convex, const ConvexHull<S>& s) {
  measure_corners<S>(convex, s.vertices);
}
template <Scalar S>
void measure(ConvexView<S>& convex, const Plate<S>& s) {
  measure_corners<S>(convex, s.corners);
}

/// Calls `try_axis` with the normals of the shape's faces: candidates for the shortest way out.
template <typename Self, typename Try>
void for_face_normals(const Self& shape, const Try& try_axis) {
  using S = ScalarOfShape<Self>;
  if constexpr (std::is_same_v<Self, Box<S>>) {
    for (int axis = 0; axis < 3; ++axis) {
      try_axis(unit_vector<Vec3<S>>(axis));
      try_axis(-unit_vector<Vec3<S>>(axis));
    }
  } else if constexpr (std::is_same_v<Self, Cylinder<S>>) {
    try_axis(unit_z<Vec3<S>>());
    try_axis(-unit_z<Vec3<S>>());
  } else if constexpr (std::is_same_v<Self, Cone<S>>) {
    try_axis(-unit_z<Vec3<S>>());
  } else if constexpr (std::is_same_v<Self, ConvexHull<S>>) {
    for (const Vec3<S>& n : shape.face_normals) try_axis(n);
  } else if constexpr (std::is_same_v<Self, Plate<S>>) {
    try_axis(shape.normal);
    try_axis(Vec3<S>(-shape.normal));
  }
}

template <Scalar S>
Vec3<S> ConvexView<S>::support(const Vec3<S>& direction) const {
  return visit_shape([&](const auto* s) { return support_core(*s, direction); }, shape);
}

template <typename ConvexShape>
ConvexView<ScalarOfShape<ConvexShape>> convex_view(const ConvexShape& shape) {
  ConvexView<ScalarOfShape<ConvexShape>> convex{.shape = &shape};
  measure(convex, shape);
  return convex;
}

template <Scalar S>
Vec3<S> support_point(const ConvexView<S>& convex, const Vec3<S>& direction) {
  return visit_shape([&](const auto* s) { return support_point(*s, direction); }, convex.shape);
}

template <Scalar S>
SupportFeature<S> support_edge(const ConvexView<S>& convex, const Vec3<S>& direction) {
  return visit_shape([&](const auto* s) { return support_edge(*s, direction); }, convex.shape);
}

template <Scalar S>
SupportFeature<S> support_face(const ConvexView<S>& convex, const Vec3<S>& direction) {
  return visit_shape([&](const auto* s) { return support_face(*s, direction); }, convex.shape);
}

template <Scalar S>
Aabb<S> bounds_at(const ConvexView<S>& convex, const Transform<S>& X) {
  const Mat3<S> R = X.rotation_matrix();
  Aabb<S> box;
  for (int i = 0; i < 3; ++i) {
    const Vec3<S> d = row_of(R, i);
    box.upper[i] = d.dot(convex.support(d)) + convex.rounding + X.translation[i];
    box.lower[i] = d.dot(convex.support(-d)) - convex.rounding + X.translation[i];
  }
  return box;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
