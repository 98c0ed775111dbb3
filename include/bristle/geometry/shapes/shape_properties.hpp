/// @file
/// Bounds and mass properties of every shape, in the shape's own frame.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/geometry/shapes/visit_shape.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/mass_properties.hpp>
#include <bristle/math/types.hpp>

#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <variant>

namespace bristle::inline BRISTLE_ABI {

/// Smallest axis-aligned box [m] around a shape, in the shape's own frame. Infinite in every
/// direction for a half-space, whatever its normal.
///
/// @pre `validate(shape)` has passed.
template <Scalar S>
[[nodiscard]] Aabb<S> local_bounds(const Shape<S>& shape);

/// Mass properties of the solid at density 1 kg/m^3, so that `mass` is the volume [m^3]. Multiply
/// by a density with `scaled`. Zero mass for a half-space.
///
/// Closed forms if there are any. Hulls and meshes use the divergence theorem about a point near
/// them. So a solid far from its frame's origin loses only the digits of its own coordinates.
///
/// @pre `validate(shape)` has passed.
template <Scalar S>
[[nodiscard]] MassProperties<S> unit_mass_properties(const Shape<S>& shape);

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// Box from -half to +half.
template <Scalar S>
[[nodiscard]] Aabb<S> centered_box(const Vec3<S>& half) {
  return {-half, half};
}

template <Scalar S>
struct LocalBounds {
  Aabb<S> operator()(const Sphere<S>& s) const {
    return centered_box<S>(filled<Vec3<S>>(s.radius));
  }
  Aabb<S> operator()(const Box<S>& s) const { return centered_box<S>(s.half_extents); }
  Aabb<S> operator()(const Capsule<S>& s) const {
    return centered_box<S>({s.radius, s.radius, s.half_length + s.radius});
  }
  Aabb<S> operator()(const Cylinder<S>& s) const {
    return centered_box<S>({s.radius, s.radius, s.half_length});
  }
  Aabb<S> operator()(const Cone<S>& s) const {
    return centered_box<S>({s.radius, s.radius, s.half_length});
  }
  Aabb<S> operator()(const Ellipsoid<S>& s) const { return centered_box<S>(s.radii); }
  Aabb<S> operator()(const HalfSpace<S>&) const {
    return centered_box<S>(filled<Vec3<S>>(infinity<S>));
  }
  Aabb<S> operator()(const ConvexHull<S>& s) const {
    Aabb<S> box;
    for (const Vec3<S>& v : s.vertices) box.include(v);
    return box;
  }
  Aabb<S> operator()(const TriangleMesh<S>& s) const { return mesh_bounds(s); }
};

/// Mass and inertia of a body that is symmetric in x, y, z about its centre of mass.
///
/// @param second_moments  [m^2] Mean of x^2, y^2 and z^2 over the body, about its centre of mass.
template <Scalar S>
[[nodiscard]] MassProperties<S> symmetric_body(S mass, const Vec3<S>& center,
                                               const Vec3<S>& second_moments) {
  const Vec3<S> diagonal = filled<Vec3<S>>(second_moments.sum()) - second_moments;
  return {mass, center, diagonal_matrix<S>(mass * diagonal)};
}

/// Integrals of 1, x and x x^T over a solid, summed over the triangles of its surface.
///
/// Each triangle closes a signed tetrahedron with the reference point. Parts outside the solid
/// cancel (divergence theorem). The tetrahedron's integrals are those of Blow and Binstock 2004,
/// "How to find the inertia tensor (or other mass properties) of a 3D solid body represented by a
/// triangle mesh".
template <Scalar S>
struct SolidMoments {
  /// [m] Origin of the integrals, best near the middle of the solid.
  Vec3<S> reference = zero<Vec3<S>>();
  /// [m^3] Volume.
  S volume = S(0);
  /// [m^4] Integral of x.
  Vec3<S> first = zero<Vec3<S>>();
  /// [m^5] Integral of x x^T.
  Mat3<S> second = zero<Mat3<S>>();

  /// Adds a triangle of the surface, counter-clockwise seen from outside.
  void add(const Vec3<S>& corner_a, const Vec3<S>& corner_b, const Vec3<S>& corner_c) {
    const Vec3<S> a = corner_a - reference;
    const Vec3<S> b = corner_b - reference;
    const Vec3<S> c = corner_c - reference;
    const Vec3<S> sum = a + b + c;
    const S v = a.dot(b.cross(c)) / S(6);
    volume += v;
    first += (v / S(4)) * sum;
    second += (v / S(20)) *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }

  [[nodiscard]] MassProperties<S> mass_properties() const {
    if (!(volume > S(0))) return {};
    const Vec3<S> center = first / volume;
    const Mat3<S> covariance = second - volume * center * center.transpose();
    return {volume, reference + center, covariance.trace() * identity<Mat3<S>>() - covariance};
  }
};

template <Scalar S>
struct UnitMassProperties {
  static constexpr S pi = S(std::numbers::pi);

  MassProperties<S> operator()(const Sphere<S>& s) const {
    return (*this)(Ellipsoid<S>{filled<Vec3<S>>(s.radius)});
  }
  MassProperties<S> operator()(const Box<S>& s) const {
    const Vec3<S>& h = s.half_extents;
    return symmetric_body<S>(S(8) * h.prod(), zero<Vec3<S>>(), cwise_square(h) / S(3));
  }
  MassProperties<S> operator()(const Capsule<S>& s) const {
    const S r = s.radius;
    const S h = s.half_length;
    const MassProperties<S> tube = (*this)(Cylinder<S>{r, h});
    // The caps are two half balls, each pushed outwards by h. With <z> = 3 r / 8 of a half ball,
    // <(z + h)^2> = r^2 / 5 + 3 r h / 4 + h^2.
    const S across = r * r / S(5);
    const MassProperties<S> caps =
        symmetric_body<S>(S(4) / S(3) * pi * r * r * r, zero<Vec3<S>>(),
                          {across, across, across + S(3) / S(4) * r * h + h * h});
    return tube + caps;
  }
  MassProperties<S> operator()(const Cylinder<S>& s) const {
    const S across = s.radius * s.radius / S(4);
    return symmetric_body<S>(S(2) * pi * s.radius * s.radius * s.half_length, zero<Vec3<S>>(),
                             {across, across, s.half_length * s.half_length / S(3)});
  }
  MassProperties<S> operator()(const Cone<S>& s) const {
    // The centre of mass is a quarter of the height above the base.
    const S across = S(3) / S(20) * s.radius * s.radius;
    return symmetric_body<S>(S(2) / S(3) * pi * s.radius * s.radius * s.half_length,
                             {S(0), S(0), -s.half_length / S(2)},
                             {across, across, S(3) / S(20) * s.half_length * s.half_length});
  }
  MassProperties<S> operator()(const Ellipsoid<S>& s) const {
    return symmetric_body<S>(S(4) / S(3) * pi * s.radii.prod(), zero<Vec3<S>>(),
                             cwise_square(s.radii) / S(5));
  }
  MassProperties<S> operator()(const HalfSpace<S>&) const { return {}; }
  MassProperties<S> operator()(const ConvexHull<S>& s) const {
    SolidMoments<S> moments{LocalBounds<S>{}(s).center()};
    for (std::size_t f = 0; f < s.face_count(); ++f) {
      const std::span<const std::uint32_t> face = s.face(f);
      for (std::size_t i = 2; i < face.size(); ++i) {
        moments.add(s.vertices[face[0]], s.vertices[face[i - 1]], s.vertices[face[i]]);
      }
    }
    return moments.mass_properties();
  }
  MassProperties<S> operator()(const TriangleMesh<S>& s) const {
    SolidMoments<S> moments{mesh_bounds(s).center()};
    for (const auto& t : s.triangles) {
      moments.add(s.vertices[t[0]], s.vertices[t[1]], s.vertices[t[2]]);
    }
    return moments.mass_properties();
  }
};

}  // namespace detail

template <Scalar S>
Aabb<S> local_bounds(const Shape<S>& shape) {
  return detail::visit_shape(detail::LocalBounds<S>{}, shape);
}

template <Scalar S>
MassProperties<S> unit_mass_properties(const Shape<S>& shape) {
  return detail::visit_shape(detail::UnitMassProperties<S>{}, shape);
}

}  // namespace bristle::inline BRISTLE_ABI
