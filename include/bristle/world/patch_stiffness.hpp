/// @file
/// How stiff a patch holds the bodies that it touches.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/math/spatial.hpp>
#include <bristle/sensors/patch_contacts.hpp>
#include <bristle/sensors/stability.hpp>
#include <bristle/world/patch_rays.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Stiffness of a patch on a body. A patch touches several bodies, and each has arms and a sum of
/// its own. So they are visited one by one.
template <Scalar S>
struct BodyStiffness {
  /// [-] Index of the body.
  std::uint32_t body = 0;
  /// [m] The point of `sum` from each centre of mass, world axes.
  Vec3<S> arm_a = zero<Vec3<S>>();
  Vec3<S> arm_b = zero<Vec3<S>>();
  ContactStiffness<S> sum{};
};

/// Finds the stiffness of patches as bodies lie and move at present. It casts their rays anew:
/// steps keep no hits. Its memory serves all patches.
template <Scalar S>
class StiffnessFinder {
 public:
  using State = WorldState<S>;

  /// Calls visit(BodyStiffness<S>) for each body in reach of a patch's rays that is wanted.
  /// @param is_wanted  Callable: bool is_wanted(body), of an index.
  template <typename IsWanted, typename Visit>
  void find(const State& state, std::uint32_t patch_index, IsWanted&& is_wanted, Visit&& visit) {
    const SensorPatch<S>& patch = state.patches.at(patch_index);
    if (!patch.is_active) return;
    cast(state, patch);
    const Body<S>& A = state.bodies.at(patch.body.index);
    const Mat3<S> R_WA = A.center_pose.rotation_matrix();
    for (std::size_t k = 0; k < tags_.size(); ++k) {
      const auto body_of = [&](std::uint32_t tag) { return state.colliders.at(tag).body.index; };
      const std::uint32_t body = body_of(tags_[k]);
      const auto is_same = [&](std::uint32_t tag) { return body_of(tag) == body; };
      const auto own = tags_.begin() + static_cast<std::ptrdiff_t>(k);
      if (!is_wanted(body) || std::any_of(tags_.begin(), own, is_same)) continue;
      const Body<S>& B = state.bodies.at(body);
      const Vec3<S> p_AB = B.center_pose.translation - A.center_pose.translation;
      const Vec3<S> arm = R_WA * patch.geometry->box.center();
      visit(
          BodyStiffness<S>{body, arm, arm - p_AB,
                           sum_stiffness(patch, hits_, is_same, R_WA, motion_between(A, B, R_WA))});
    }
  }

  /// [s] Longest explicit step of a patch by itself, with the present contacts. Several patches on
  /// one body add up.
  [[nodiscard]] S largest_stable_step(const State& state, std::uint32_t patch_index) {
    S smallest = infinity<S>;
    const Body<S>& A = state.bodies.at(state.patches.at(patch_index).body.index);
    const auto all = [](std::uint32_t) { return true; };
    find(state, patch_index, all, [&](const BodyStiffness<S>& on) {
      const Body<S>& B = state.bodies.at(on.body);
      const Mat6<S> both = mobility(A.inverse_mass_W(), A.inverse_inertia_W(), on.arm_a) +
                           mobility(B.inverse_mass_W(), B.inverse_inertia_W(), on.arm_b);
      smallest = std::min(smallest, on.sum.largest_stable_step(both));
    });
    return smallest;
  }

 private:
  /// Casts the rays at all shapes in their reach, by ascending tags.
  void cast(const State& state, const SensorPatch<S>& patch) {
    const Body<S>& A = state.bodies.at(patch.body.index);
    tags_.clear();
    state.broad_phase.overlap(transformed(patch.geometry->box, A.center_pose),
                              [&](std::uint32_t tag) {
                                if (senses(state, patch, state.colliders.at(tag))) {
                                  tags_.push_back(tag);
                                }
                                return true;
                              });
    std::sort(tags_.begin(), tags_.end());
    hits_.reset(patch.geometry->packets.size() * packet_size);
    for (const std::uint32_t tag : tags_) {
      const Collider<S>& c = state.colliders.at(tag);
      const Transform<S> X_AB = relative_pose(A.center_pose, state.body_of(c).center_pose);
      c.shape.cast_rays(X_AB * c.X_CmS, patch.geometry->rays(S(0)), tag, hits_);
    }
  }

  RayHits<S> hits_;
  DynamicArray<std::uint32_t> tags_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
