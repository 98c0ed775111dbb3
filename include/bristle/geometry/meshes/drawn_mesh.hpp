/// @file
/// Triangles that look like a shape.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/geometry/shapes/visit_shape.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/types.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <variant>

namespace bristle::inline BRISTLE_ABI {

/// Triangles to draw a shape with, in its own frame, facing outwards. Corners of round shapes lie
/// on the surface; triangles lie up to 1 % of a radius below it. A half-space is a square.
///
/// @param plane_size  [m] Side of that square, > 0; its middle is next to the origin.
/// @throws InvalidArgument as `validate`, or when `plane_size` is not > 0.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> drawn_mesh(const Shape<S>& shape, S plane_size = S(2));

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// [-] Segments of drawn solids of revolution. The chord misses the circle by 0.5 % of the radius.
inline constexpr std::uint32_t drawn_segments = 32;

/// A solid of revolution about z.
/// @param profile  [m] Radius and height of its rings from low to high; a radius of 0 is a point.
template <Scalar S>
[[nodiscard]] TriangleMesh<S> lathe_mesh(const DynamicArray<std::pair<S, S>>& profile) {
  using std::cos;
  using std::sin;
  constexpr std::uint32_t segments = drawn_segments;
  TriangleMesh<S> mesh;
  DynamicArray<std::uint32_t> ring;
  for (const auto& [radius, height] : profile) {
    DynamicArray<std::uint32_t> next;
    for (std::uint32_t i = 0; i < segments; ++i) {
      const S angle = S(2) * S(std::numbers::pi) * S(i) / S(segments);
      if (i == 0 || radius > S(0)) {
        mesh.vertices.push_back({radius * cos(angle), radius * sin(angle), height});
      }
      next.push_back(static_cast<std::uint32_t>(mesh.vertices.size() - 1));
    }
    for (std::uint32_t i = 0; i < segments && !ring.empty(); ++i) {
      const std::uint32_t j = (i + 1) % segments;
      if (ring[i] != ring[j]) mesh.triangles.push_back({ring[i], ring[j], next[j]});
      if (next[i] != next[j]) mesh.triangles.push_back({ring[i], next[j], next[i]});
    }
    ring = std::move(next);
  }
  return mesh;
}

template <Scalar S>
struct ShapeDrawer {
  S plane_size;

  /// Such that the middle of a triangle lies less than 1 % of the radius below the sphere.
  static constexpr std::uint32_t sphere_frequency = 6;

  TriangleMesh<S> operator()(const Sphere<S>& s) const {
    return sphere_mesh<S>(s.radius, sphere_frequency);
  }
  TriangleMesh<S> operator()(const Box<S>& s) const { return box_mesh<S>(s.half_extents); }
  TriangleMesh<S> operator()(const Capsule<S>& s) const {
    using std::cos;
    using std::sin;
    constexpr int rings = drawn_segments / 4;  // Of a quarter of a circle.
    DynamicArray<std::pair<S, S>> profile;
    for (int i = -rings; i <= rings; ++i) {
      // From the lower pole to its rim, and from the upper rim to its pole; both rims at i = 0.
      const S angle = S(std::numbers::pi / 2) * S(rings - (i < 0 ? -i : i)) / S(rings);
      const S radius = s.radius * sin(angle), height = s.half_length + s.radius * cos(angle);
      if (i <= 0) profile.push_back({radius, -height});
      if (i >= 0) profile.push_back({radius, height});
    }
    return lathe_mesh<S>(profile);
  }
  TriangleMesh<S> operator()(const Cylinder<S>& s) const {
    return cylinder_mesh<S>(s, drawn_segments);
  }
  TriangleMesh<S> operator()(const Cone<S>& s) const {
    return lathe_mesh<S>(
        {{S(0), -s.half_length}, {s.radius, -s.half_length}, {S(0), s.half_length}});
  }
  TriangleMesh<S> operator()(const Ellipsoid<S>& s) const {
    TriangleMesh<S> mesh = sphere_mesh<S>(S(1), sphere_frequency);
    for (Vec3<S>& v : mesh.vertices) v = cwise_product(v, s.radii);
    return mesh;
  }
  TriangleMesh<S> operator()(const HalfSpace<S>& s) const {
    Vec3<S> t1, t2;
    tangent_basis<S>(s.normal, t1, t2);
    TriangleMesh<S> mesh = grid_mesh<S>({plane_size, plane_size}, {1, 1});
    for (Vec3<S>& v : mesh.vertices) {
      v = (v.x() * t1 + v.y() * t2 + s.offset * s.normal).eval();
    }
    return mesh;
  }
  TriangleMesh<S> operator()(const ConvexHull<S>& s) const {
    TriangleMesh<S> mesh{s.vertices, {}};
    for (std::size_t f = 0; f < s.face_count(); ++f) {
      const auto face = s.face(f);
      for (std::size_t i = 2; i < face.size(); ++i) {
        mesh.triangles.push_back({face[0], face[i - 1], face[i]});
      }
    }
    return mesh;
  }
  TriangleMesh<S> operator()(const TriangleMesh<S>& s) const { return s; }
};

}  // namespace detail

template <Scalar S>
TriangleMesh<S> drawn_mesh(const Shape<S>& shape, S plane_size) {
  validate(shape);
  detail::require_positive("drawn_mesh: plane_size", plane_size);
  return detail::visit_shape(detail::ShapeDrawer<S>{plane_size}, shape);
}

}  // namespace bristle::inline BRISTLE_ABI
