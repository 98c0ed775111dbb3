/// @file
/// Distance sensors: resistive sensors' rays without forces.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/rays/ray_tree.hpp>
#include <bristle/sensors/sensor_layout.hpp>
#include <bristle/world/query_filter.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace bristle::inline BRISTLE_ABI {

/// Rays on a body, with their last hits.
///
/// It belongs to no world: `world.sense(body, array)` fills it on request. Sensors that are read
/// every tenth step, or never, cost nothing in between. No state of the world depends on them. A
/// body far from the array costs one test of boxes.
template <Scalar S>
class ProximityArray {
 public:
  /// @throws InvalidArgument as `SensorLayout::validate`, or when there are no rays.
  explicit ProximityArray(SensorLayout<S> rays, QueryFilter filter = {})
      : rays_(std::move(rays)), filter_(std::move(filter)) {
    rays_.validate();
    detail::require(rays_.size() > 0, "ProximityArray: rays.size()", rays_.size(), "must be > 0");
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      box_.include(rays_.start[i]);
      box_.include(rays_.start[i] + rays_.length[i] * rays_.direction[i]);
    }
    ray_tree_ = detail::RayTree<S>(batch(nullptr));
    hits_.reset(rays_.size());
    body_.resize(rays_.size());
  }

  /// [-] Number of rays.
  [[nodiscard]] std::size_t size() const { return rays_.size(); }
  /// Rays of the array, in the carrier's frame.
  [[nodiscard]] const SensorLayout<S>& rays() const { return rays_; }

  /// [m] Distance from each ray's start to its hit. Infinite without a hit, 0 for an inside start.
  [[nodiscard]] std::span<const S> distance() const { return hits_.distance; }
  /// [-] Body that each ray hit; names nothing without a hit.
  [[nodiscard]] std::span<const BodyId> body() const { return {body_.data(), body_.size()}; }
  /// [1] Outward unit normal of the surface that a ray hit, in the frame of the carrying body.
  [[nodiscard]] Vec3<S> normal(std::size_t ray) const { return hits_.normal[ray]; }
  /// [-] Ray with the shortest distance, the first of equals; `size()` without any hit.
  [[nodiscard]] std::size_t nearest() const {
    const auto least = std::min_element(hits_.distance.begin(), hits_.distance.end());
    return *least < infinity<S> ? static_cast<std::size_t>(least - hits_.distance.begin()) : size();
  }
  /// [-] Rays cast in the last call: rays times shapes in range.
  [[nodiscard]] std::uint64_t rays_cast() const { return rays_cast_; }

  /// Called by `World::sense`.
  void sense(const detail::WorldState<S>& state, BodyId carrier);

 private:
  [[nodiscard]] RayBatch<S> batch(const detail::RayTree<S>* ray_tree) const {
    RayBatch<S> batch = rays_.rays();
    batch.ray_tree = ray_tree;
    return batch;
  }

  SensorLayout<S> rays_;
  detail::RayTree<S> ray_tree_;
  QueryFilter filter_;
  Aabb<S> box_{};
  RayHits<S> hits_;
  detail::DynamicArray<BodyId> body_;
  detail::DynamicArray<std::uint32_t> near_;
  std::uint64_t rays_cast_ = 0;
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

template <Scalar S>
void ProximityArray<S>::sense(const detail::WorldState<S>& state, BodyId carrier) {
  const Transform<S> X_WA = state.bodies.get(carrier, "BodyId").pose();
  const Aabb<S> box = transformed(box_, X_WA);
  near_.clear();
  state.broad_phase.overlap(box, [&](std::uint32_t tag) {
    const detail::Collider<S>& c = state.colliders.at(tag);
    if (c.body == carrier || !detail::can_meet_shape(filter_, c, state.body_of(c))) return true;
    const Transform<S> X_AS = relative_pose(X_WA, state.body_of(c).center_pose) * c.X_CmS;
    const bool is_near =
        c.half_space ? state.reaches(box, c) : transformed(box_, X_AS.inverse()).overlaps(c.bounds);
    if (is_near) near_.push_back(tag);
    return true;
  });
  // Ties go to the lower tag, as for patches.
  std::sort(near_.begin(), near_.end());
  hits_.reset(size());
  rays_cast_ = near_.size() * size();
  for (const std::uint32_t tag : near_) {
    const detail::Collider<S>& c = state.colliders.at(tag);
    c.shape.cast_rays(relative_pose(X_WA, state.body_of(c).center_pose) * c.X_CmS,
                      batch(&ray_tree_), tag, hits_);
  }
  for (std::size_t i = 0; i < size(); ++i) {
    body_[i] = hits_.is_hit(i) ? state.colliders.at(hits_.tag[i]).body : BodyId{};
  }
}

}  // namespace bristle::inline BRISTLE_ABI
#endif
