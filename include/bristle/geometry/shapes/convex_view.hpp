/// @file
/// A convex solid as iterative methods see it: a core, and a radius by which the core is grown.
///
/// A sphere's core is its centre, a capsule's its segment; others are their own. Where cores are
/// apart the radius only shifts the surface, so round parts are exact whatever the method is.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/geometry/shapes/support.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

namespace bristle::inline BRISTLE_ABI {

/// View of a shape that support.hpp knows. Points to the shape it is made from.
template <Scalar S>
struct ConvexView {
  std::variant<const Sphere<S>*, const Box<S>*, const Capsule<S>*, const Cylinder<S>*,
               const Cone<S>*, const Ellipsoid<S>*, const ConvexHull<S>*, const Triangle<S>*>
      shape;
  /// [m] Radius around the core: that of a sphere or capsule, else 0.
  S rounding = S(0);
  /// [m] A point inside, and the distance from it to the farthest point of the solid.
  Vec3<S> center = Vec3<S>::Zero();
  S reach = S(0);

  /// [m] The core's farthest point along a direction of any length > 0, in the solid's frame.
  [[nodiscard]] Vec3<S> support(const Vec3<S>& direction) const;
  /// Whether the core has curved parts.
  [[nodiscard]] bool is_curved() const {
    return std::holds_alternative<const Cylinder<S>*>(shape) ||
           std::holds_alternative<const Cone<S>*>(shape) ||
           std::holds_alternative<const Ellipsoid<S>*>(shape);
  }
};

namespace detail {

// The scalar of a shape that has a view. A parameter for templates of a Scalar would tell, too, but
// clang 14 crashes where it writes one into a precompiled header.
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
S scalar_of(const Triangle<S>&);

template <typename ConvexShape>
using ScalarOfShape = decltype(scalar_of(std::declval<const ConvexShape&>()));

}  // namespace detail

/// The view of a shape, which must outlive the answer.
template <typename ConvexShape>
[[nodiscard]] ConvexView<detail::ScalarOfShape<ConvexShape>> convex_view(const ConvexShape& shape);

/// Farthest point, edge and face of the whole solid, as support.hpp has them for each shape: what
/// is done with pairs of solids is compiled once, and not for every pair of shapes.
template <Scalar S>
[[nodiscard]] Vec3<S> support_point(const ConvexView<S>& convex, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_edge(const ConvexView<S>& convex, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_face(const ConvexView<S>& convex, const Vec3<S>& direction);

/// [m] The box around a solid that stands at X.
template <Scalar S>
[[nodiscard]] Aabb<S> bounds_at(const ConvexView<S>& convex, const Transform<S>& X);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

template <Scalar S>
[[nodiscard]] Vec3<S> support_core(const Sphere<S>&, const Vec3<S>&) {
  return Vec3<S>::Zero();
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
void measure(ConvexView<S>& convex, const Triangle<S>& s) {
  measure_corners<S>(convex, s.corners);
}

/// Calls `try_axis` with directions in which the way out of the shape may be shortest: those its
/// faces look in.
template <typename Self, typename Try>
void for_face_normals(const Self& shape, const Try& try_axis) {
  using S = ScalarOfShape<Self>;
  if constexpr (std::is_same_v<Self, Box<S>>) {
    for (int axis = 0; axis < 3; ++axis) {
      try_axis(Vec3<S>(Vec3<S>::Unit(axis)));
      try_axis(Vec3<S>(-Vec3<S>::Unit(axis)));
    }
  } else if constexpr (std::is_same_v<Self, Cylinder<S>>) {
    try_axis(Vec3<S>(Vec3<S>::UnitZ()));
    try_axis(Vec3<S>(-Vec3<S>::UnitZ()));
  } else if constexpr (std::is_same_v<Self, Cone<S>>) {
    try_axis(Vec3<S>(-Vec3<S>::UnitZ()));
  } else if constexpr (std::is_same_v<Self, ConvexHull<S>>) {
    for (const Vec3<S>& n : shape.face_normals) try_axis(n);
  } else if constexpr (std::is_same_v<Self, Triangle<S>>) {
    const Vec3<S> n = support_face(shape, Vec3<S>(Vec3<S>::UnitZ())).normal;
    try_axis(n);
    try_axis(Vec3<S>(-n));
    // Past its edges, within its plane: often the shortest way off a plate.
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<S> edge = shape.corners[(k + 1) % 3] - shape.corners[k];
      const Vec3<S> across = edge.cross(n).normalized();
      const bool is_outwards = across.dot(shape.corners[(k + 2) % 3] - shape.corners[k]) <= S(0);
      try_axis(is_outwards ? across : Vec3<S>(-across));
    }
  }
}

}  // namespace detail

template <Scalar S>
Vec3<S> ConvexView<S>::support(const Vec3<S>& direction) const {
  return std::visit([&](const auto* s) { return detail::support_core(*s, direction); }, shape);
}

template <typename ConvexShape>
ConvexView<detail::ScalarOfShape<ConvexShape>> convex_view(const ConvexShape& shape) {
  ConvexView<detail::ScalarOfShape<ConvexShape>> convex{.shape = &shape};
  detail::measure(convex, shape);
  return convex;
}

template <Scalar S>
Vec3<S> support_point(const ConvexView<S>& convex, const Vec3<S>& direction) {
  return std::visit([&](const auto* s) { return support_point(*s, direction); }, convex.shape);
}

template <Scalar S>
SupportFeature<S> support_edge(const ConvexView<S>& convex, const Vec3<S>& direction) {
  return std::visit([&](const auto* s) { return support_edge(*s, direction); }, convex.shape);
}

template <Scalar S>
SupportFeature<S> support_face(const ConvexView<S>& convex, const Vec3<S>& direction) {
  return std::visit([&](const auto* s) { return support_face(*s, direction); }, convex.shape);
}

template <Scalar S>
Aabb<S> bounds_at(const ConvexView<S>& convex, const Transform<S>& X) {
  const Mat3<S> R = X.rotation_matrix();
  Aabb<S> box;
  for (int i = 0; i < 3; ++i) {
    const Vec3<S> d = R.row(i).transpose();
    box.upper[i] = d.dot(convex.support(d)) + convex.rounding + X.translation[i];
    box.lower[i] = d.dot(convex.support(-d)) - convex.rounding + X.translation[i];
  }
  return box;
}

}  // namespace bristle::inline BRISTLE_ABI
