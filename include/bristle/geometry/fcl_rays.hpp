/// @file
/// Rays over FCL's own geometry, which has no ray query of its own (fcl#310).
///
/// FCL is the container: sizes are read from its shapes and met in closed form, its mesh tree is
/// walked through its public nodes. Everything is computed in double in the geometry's frame, for
/// float users too: it costs scalar code nothing.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/fcl_shapes.hpp>
#include <bristle/geometry/mesh_rays.hpp>
#include <bristle/geometry/ray_shapes.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <variant>

namespace bristle {

/// Nearest hit of a ray with an FCL mesh, as `ray_cast_mesh` finds it.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const FclMeshTree<S>& mesh, const Ray<S>& ray) {
  return ray_cast_mesh(mesh, ray);
}

/// Nearest hit of a ray with what an FCL geometry holds, in its frame.
template <Scalar S>
[[nodiscard]] RayHit<S> ray_cast(const FclView<S>& view, const Ray<S>& ray) {
  return std::visit([&](const auto& shape) { return ray_cast(shape, ray); }, view);
}

/// An FCL geometry made ready for rays. Immutable; several threads may cast at once.
class FclRayTarget {
 public:
  /// @throws InvalidArgument as `from_fcl` does.
  explicit FclRayTarget(FclGeometry geometry)
      : geometry_(std::move(geometry)), view_(from_fcl(*geometry_)) {}

  [[nodiscard]] const FclGeometry& geometry() const { return geometry_; }
  /// What the geometry holds.
  [[nodiscard]] const FclView<double>& view() const { return view_; }

  /// Offers to `hits` the nearest hit of each ray, as `ShapeBackend::cast_rays` does. X_RC is the
  /// geometry's pose in the rays' frame; one that is not finite hits nothing.
  ///
  /// Allocates nothing.
  template <Scalar S>
  void cast_rays(const Transform<S>& X_RC, const RayBatch<S>& rays, std::uint32_t tag,
                 RayHits<S>& hits) const noexcept;

 private:
  FclGeometry geometry_;
  FclView<double> view_;
};

// Implementation -----------------------------------------------------------------------------------

template <Scalar S>
void FclRayTarget::cast_rays(const Transform<S>& X_RC, const RayBatch<S>& rays, std::uint32_t tag,
                             RayHits<S>& hits) const noexcept {
  const Transform<double> X = X_RC.template cast<double>();
  if (!X.translation.allFinite() || !X.rotation.coeffs().allFinite()) return;
  const Mat3<double> R_RC = X.rotation_matrix();
  std::visit(
      [&](const auto& shape) {
        for (std::size_t i = 0; i < rays.size(); ++i) {
          const Ray<S> ray_R = rays[i];
          const Vec3<double> from_origin = ray_R.origin.template cast<double>() - X.translation;
          // What lies beyond a hit that is known already need not be looked at.
          const Ray<double> ray{
              .origin = R_RC.transpose() * from_origin,
              .direction = R_RC.transpose() * ray_R.direction.template cast<double>(),
              .length = double(std::min(ray_R.length, hits.distance[i]))};
          const RayHit<double> hit = ray_cast(shape, ray);
          if (hit.distance < infinity<double>) {
            const Vec3<double> normal = R_RC * hit.normal;
            hits.offer(i, {S(hit.distance), normal.template cast<S>()}, tag);
          }
        }
      },
      view_);
}

}  // namespace bristle
