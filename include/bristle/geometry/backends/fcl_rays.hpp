/// @file
/// Rays over FCL's own geometry, which has no ray query (fcl#310).
///
/// FCL is the container. Sizes and triangles are read from its geometry once. Rays are then cast at
/// them as in the analytic backend, in the user's scalar. Single rays (`ray_cast`) traverse FCL's
/// own trees in the scalar of the geometry.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/fcl_shapes.hpp>
#include <bristle/geometry/contacts/shape_cast.hpp>
#include <bristle/geometry/rays/mesh_rays.hpp>
#include <bristle/geometry/rays/ray_lanes.hpp>
#include <bristle/geometry/rays/ray_mesh.hpp>
#include <bristle/geometry/rays/ray_shapes.hpp>
#include <bristle/geometry/rays/ray_tree_mesh_query.hpp>
#include <bristle/geometry/shapes/visit_shape.hpp>
#include <bristle/math/finite.hpp>

#include <array>
#include <concepts>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <variant>

namespace bristle::inline BRISTLE_ABI::detail {

/// Nearest hit of a ray with an FCL mesh, as by `ray_cast_mesh`.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const FclMeshTree<S>& mesh, const Ray<S>& ray) {
  return ray_cast_mesh(mesh, ray);
}

/// Nearest hit of a ray with the shape of an FCL geometry, in its frame.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const FclView<S>& view, const Ray<S>& ray) {
  return visit_shape([&](const auto& shape) { return ray_cast(shape, ray); }, view);
}

/// An FCL geometry prepared for rays in S. Immutable. Several threads may cast at once.
template <Scalar S>
class FclRayTarget {
 public:
  /// @throws InvalidArgument as `from_fcl`.
  explicit FclRayTarget(FclGeometry geometry)
      : geometry_(std::move(geometry)),
        view_(from_fcl(*geometry_)),
        shape_(visit_shape([](const auto& view) { return prepared(view); }, view_)) {}

  [[nodiscard]] const FclGeometry& geometry() const { return geometry_; }
  /// View of the shape that rays are cast at.
  [[nodiscard]] const FclView<double>& view() const { return view_; }

  /// Offers to `hits` the nearest hit of each ray, as `ShapeBackend::cast_rays` does. X_RC is the
  /// geometry's pose in the rays' frame. A pose that is not finite hits nothing. Allocates nothing.
  void cast_rays(const Transform<S>& X_RC, const RayBatch<S>& rays, std::uint32_t tag,
                 RayHits<S>& hits) const noexcept;

  /// True only if no ray can meet the mesh, judged by boxes. False for other geometry.
  [[nodiscard]] bool misses(const Transform<S>& X_RC, const RayBatch<S>& rays) const noexcept {
    const auto* mesh = std::get_if<RayMesh<S>>(&shape_);
    return mesh != nullptr && misses_mesh(*mesh, X_RC, rays);
  }

 private:
  using Prepared = std::variant<Sphere<S>, Box<S>, Capsule<S>, Cylinder<S>, Cone<S>, Ellipsoid<S>,
                                HalfSpace<S>, ConvexHull<S>, RayMesh<S>>;

  template <typename View>
  [[nodiscard]] static Prepared prepared(const View& view) {
    return visit_shape(
        [](auto&& shape) -> Prepared {
          if constexpr (std::constructible_from<Prepared, decltype(shape)>) {
            return shape;
          } else {
            return RayMesh<S>();
          }
        },
        ShapeCast<S, double>{}(view));
  }
  [[nodiscard]] static Prepared prepared(const FclMeshTree<double>& mesh) {
    return RayMesh<S>(mesh.size(), [&](std::uint32_t i) {
      const auto [a, b, c] = mesh.corners(i);
      return std::array<Vec3<S>, 3>{a.template cast<S>(), b.template cast<S>(),
                                    c.template cast<S>()};
    });
  }

  FclGeometry geometry_;
  FclView<double> view_;
  Prepared shape_;
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
void FclRayTarget<S>::cast_rays(const Transform<S>& X_RC, const RayBatch<S>& rays,
                                std::uint32_t tag, RayHits<S>& hits) const noexcept {
  if (!all_finite(X_RC.translation) || !all_finite(X_RC.rotation.coeffs())) return;
  visit_shape(
      [&](const auto& shape) {
        if constexpr (std::same_as<std::remove_cvref_t<decltype(shape)>, RayMesh<S>>) {
          cast_rays_at_mesh(shape, X_RC, rays, tag, hits);
        } else {
          cast_rays_in_lanes(shape, X_RC, rays, tag, hits);
        }
      },
      shape_);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
