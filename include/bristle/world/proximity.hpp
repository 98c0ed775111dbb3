/// @file
/// Sensors of distance: the rays of resistive sensors without their forces.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/rays/ray_bundles.hpp>
#include <bristle/sensors/sensor_layout.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// Whom sensors of distance see.
struct ProximityFilter {
  /// [-] Categories of the bodies that are seen.
  std::uint32_t sees = 0xffffffffu;
  /// [-] Bodies that are not seen, besides the one that carries the sensors.
  std::vector<BodyId> excluded{};
};

/// An array of rays on a body and what they met last.
///
/// It belongs to no world: `world.sense(body, array)` fills it when somebody wants to know, so that
/// sensors which are read every tenth step, or not at all, cost nothing in between, and no state of
/// the world depends on whether it was asked. A body far from the array costs one test of boxes.
template <Scalar S>
class ProximityArray {
 public:
  /// @throws InvalidArgument as `SensorLayout::validate`, or when there are no rays.
  explicit ProximityArray(SensorLayout<S> rays, ProximityFilter filter = {})
      : rays_(std::move(rays)), filter_(std::move(filter)) {
    rays_.validate();
    detail::require(rays_.size() > 0, "ProximityArray: rays.size()", rays_.size(), "must be > 0");
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      box_.include(rays_.start[i]);
      box_.include(rays_.start[i] + rays_.length[i] * rays_.direction[i]);
    }
    bundles_ = RayBundles<S>(batch(nullptr));
    hits_.reset(rays_.size());
    body_.resize(rays_.size());
  }

  [[nodiscard]] std::size_t size() const { return rays_.size(); }
  [[nodiscard]] const SensorLayout<S>& rays() const { return rays_; }

  /// [m] Distance of each ray's start from what it met; infinite where it met nothing, 0 where it
  /// starts inside.
  [[nodiscard]] std::span<const S> distance() const { return hits_.distance; }
  /// [-] What each ray met; names nothing where it met nothing.
  [[nodiscard]] std::span<const BodyId> body() const { return body_; }
  /// [1] Outward unit normal of the surface that a ray met, in the frame of the carrying body.
  [[nodiscard]] Vec3<S> normal(std::size_t ray) const { return hits_.normal[ray]; }
  /// [-] The ray with the shortest distance, the first of equals; `size()` where none met anything.
  [[nodiscard]] std::size_t nearest() const {
    const auto least = std::min_element(hits_.distance.begin(), hits_.distance.end());
    return *least < infinity<S> ? static_cast<std::size_t>(least - hits_.distance.begin()) : size();
  }
  /// [-] Rays that were cast in the last call: rays times shapes in reach.
  [[nodiscard]] std::uint64_t rays_cast() const { return rays_cast_; }

  /// What `World::sense` calls.
  template <typename Backend>
  void sense(const WorldState<S, Backend>& state, BodyId carrier);

 private:
  template <typename Backend>
  [[nodiscard]] bool sees(const WorldState<S, Backend>& state, BodyId carrier,
                          const Collider<S, Backend>& c) const {
    return c.body != carrier && (filter_.sees & state.body_of(c).filter.category) != 0 &&
           std::find(filter_.excluded.begin(), filter_.excluded.end(), c.body) ==
               filter_.excluded.end();
  }

  [[nodiscard]] RayBatch<S> batch(const RayBundles<S>* bundles) const {
    RayBatch<S> batch = rays_.rays();
    batch.bundles = bundles;
    return batch;
  }

  SensorLayout<S> rays_;
  RayBundles<S> bundles_;
  ProximityFilter filter_;
  Aabb<S> box_{};
  RayHits<S> hits_;
  std::vector<BodyId> body_;
  std::vector<std::uint32_t> near_;
  std::uint64_t rays_cast_ = 0;
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation -----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

template <Scalar S>
template <typename Backend>
void ProximityArray<S>::sense(const WorldState<S, Backend>& state, BodyId carrier) {
  const Transform<S> X_WA = state.bodies.get(carrier, "BodyId").pose();
  const Aabb<S> box = transformed(box_, X_WA);
  near_.clear();
  state.broad_phase.overlap(box, [&](std::uint32_t tag) {
    const Collider<S, Backend>& c = state.colliders.at(tag);
    if (!sees(state, carrier, c)) return true;
    const Transform<S> X_AS = relative_pose(X_WA, state.body_of(c).center_pose) * c.X_CmS;
    const bool is_near =
        c.half_space ? state.reaches(box, c) : transformed(box_, X_AS.inverse()).overlaps(c.bounds);
    if (is_near) near_.push_back(tag);
    return true;
  });
  // Ties go to the lower tag, as they do for patches.
  std::sort(near_.begin(), near_.end());
  hits_.reset(size());
  rays_cast_ = near_.size() * size();
  for (const std::uint32_t tag : near_) {
    const Collider<S, Backend>& c = state.colliders.at(tag);
    Backend::cast_rays(c.shape, relative_pose(X_WA, state.body_of(c).center_pose) * c.X_CmS,
                       batch(&bundles_), tag, hits_);
  }
  for (std::size_t i = 0; i < size(); ++i) {
    body_[i] = hits_.is_hit(i) ? state.colliders.at(hits_.tag[i]).body : BodyId{};
  }
}

}  // namespace bristle::inline BRISTLE_ABI
#endif
