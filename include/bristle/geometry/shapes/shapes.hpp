/// @file
/// Shapes of bodies, as plain structs in their own frame.
///
/// Axes of revolution run along z. A backend checks the sizes of its shapes (`validate`) and never
/// repairs them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/error.hpp>
#include <bristle/geometry/meshes/mesh_validation.hpp>
#include <bristle/geometry/meshes/triangle_mesh.hpp>
#include <bristle/geometry/shapes/convex_hull.hpp>
#include <bristle/geometry/shapes/visit_shape.hpp>
#include <bristle/math/types.hpp>

#include <concepts>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>

namespace bristle::inline BRISTLE_ABI {

/// Ball around the origin.
template <Scalar S>
struct Sphere {
  /// [m] Radius, > 0.
  S radius = S(0);
};

/// Cuboid around the origin.
template <Scalar S>
struct Box {
  /// [m] Half of each edge, > 0.
  Vec3<S> half_extents = detail::zero<Vec3<S>>();
};

/// All points within `radius` of the segment from -half_length to +half_length on z.
template <Scalar S>
struct Capsule {
  /// [m] Radius, > 0.
  S radius = S(0);
  /// [m] Half the length of the segment, without the caps, > 0.
  S half_length = S(0);
};

/// Solid cylinder about z.
template <Scalar S>
struct Cylinder {
  /// [m] Radius, > 0.
  S radius = S(0);
  /// [m] Half the height, > 0.
  S half_length = S(0);
};

/// Solid cone about z: base disk at z = -half_length, apex at z = +half_length.
template <Scalar S>
struct Cone {
  /// [m] Radius of the base, > 0.
  S radius = S(0);
  /// [m] Half the height, > 0.
  S half_length = S(0);
};

/// Ellipsoid around the origin.
template <Scalar S>
struct Ellipsoid {
  /// [m] Semi-axes along x, y, z, > 0.
  Vec3<S> radii = detail::zero<Vec3<S>>();
};

/// All points p with normal . p <= offset: a floor, a wall, an incline. It has no finite mass, so
/// only bodies that forces do not move may have it.
template <Scalar S>
struct HalfSpace {
  /// [1] Unit outward normal.
  Vec3<S> normal = detail::unit_z<Vec3<S>>();
  /// [m] Signed distance of the surface from the origin along the normal.
  S offset = S(0);
};

/// Any shape. `ConvexHull` and `TriangleMesh` own their data. The world keeps one prepared copy.
template <Scalar S>
using Shape = std::variant<Sphere<S>, Box<S>, Capsule<S>, Cylinder<S>, Cone<S>, Ellipsoid<S>,
                           HalfSpace<S>, ConvexHull<S>, TriangleMesh<S>>;

/// Alternative of a `Shape`. The values equal `Shape::index()`.
enum class ShapeKind : std::size_t {
  sphere,
  box,
  capsule,
  cylinder,
  cone,
  ellipsoid,
  half_space,
  convex_hull,
  triangle_mesh
};
/// [-] Number of kinds.
inline constexpr std::size_t shape_kind_count = 9;

/// Returns the kind of a shape.
template <Scalar S>
[[nodiscard]] ShapeKind kind_of(const Shape<S>& shape) {
  return static_cast<ShapeKind>(shape.index());
}

/// Name of a kind in messages ("TriangleMesh").
[[nodiscard]] constexpr const char* name_of(ShapeKind kind) {
  constexpr const char* names[shape_kind_count] = {"Sphere",    "Box",        "Capsule",
                                                   "Cylinder",  "Cone",       "Ellipsoid",
                                                   "HalfSpace", "ConvexHull", "TriangleMesh"};
  return names[static_cast<std::size_t>(kind)];
}

namespace detail {

/// A shape or none. Copies share the data, so definitions with large meshes are cheap to pass
/// around.
template <Scalar S>
class OptionalShape {
 public:
  /// No shape.
  OptionalShape() = default;
  /// Any shape, or anything that converts to one.
  template <typename T>
  requires std::constructible_from<Shape<S>, T &&> &&
      (!std::same_as<std::remove_cvref_t<T>, OptionalShape>)OptionalShape(T&& shape)
      : shape_(std::make_shared<const Shape<S>>(std::forward<T>(shape))) {}

  /// Returns whether there is a shape.
  [[nodiscard]] explicit operator bool() const noexcept { return shape_ != nullptr; }
  /// Returns the shape. There must be one.
  [[nodiscard]] const Shape<S>& operator*() const noexcept { return *shape_; }

 private:
  std::shared_ptr<const Shape<S>> shape_;
};

}  // namespace detail

/// Checks a shape.
///
/// @throws InvalidArgument that names the field if a size is not finite and > 0, a half-space
///         normal is not unit length, or a hull or mesh is not a valid solid.
template <Scalar S>
void validate(const Shape<S>& shape);

// Implementation ----------------------------------------------------------------------------------

namespace detail {

template <Scalar S>
struct ShapeValidator {
  void operator()(const Sphere<S>& s) const { require_positive("Sphere::radius", s.radius); }
  void operator()(const Box<S>& s) const {
    require_positive("Box::half_extents[0]", s.half_extents.x());
    require_positive("Box::half_extents[1]", s.half_extents.y());
    require_positive("Box::half_extents[2]", s.half_extents.z());
  }
  void operator()(const Capsule<S>& s) const {
    require_positive("Capsule::radius", s.radius);
    require_positive("Capsule::half_length", s.half_length);
  }
  void operator()(const Cylinder<S>& s) const {
    require_positive("Cylinder::radius", s.radius);
    require_positive("Cylinder::half_length", s.half_length);
  }
  void operator()(const Cone<S>& s) const {
    require_positive("Cone::radius", s.radius);
    require_positive("Cone::half_length", s.half_length);
  }
  void operator()(const Ellipsoid<S>& s) const {
    require_positive("Ellipsoid::radii[0]", s.radii.x());
    require_positive("Ellipsoid::radii[1]", s.radii.y());
    require_positive("Ellipsoid::radii[2]", s.radii.z());
  }
  void operator()(const HalfSpace<S>& s) const {
    using std::abs;
    require_all_finite("HalfSpace::normal", s.normal);
    require(abs(s.normal.squaredNorm() - S(1)) <= Tolerance<S>::equal(), "HalfSpace::normal",
            s.normal.norm(), "must have length 1");
    require_finite("HalfSpace::offset", s.offset);
  }
  void operator()(const ConvexHull<S>& s) const { s.validate(); }
  void operator()(const TriangleMesh<S>& s) const { validate_solid(s); }
};

}  // namespace detail

template <Scalar S>
void validate(const Shape<S>& shape) {
  detail::visit_shape(detail::ShapeValidator<S>{}, shape);
}

}  // namespace bristle::inline BRISTLE_ABI
