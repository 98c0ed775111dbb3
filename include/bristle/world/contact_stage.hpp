/// @file
/// First stage of a step: broad phase and contacts.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/crowd_limit.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/contacts/contact_target.hpp>
#include <bristle/dynamics/contacts/rolling_friction.hpp>
#include <bristle/world/near_shapes.hpp>
#include <bristle/world/world_constants.hpp>
#include <bristle/world/world_state.hpp>

#include <algorithm>
#include <functional>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Moves the boxes of all shapes and finds the pairs that may touch. Queries the backend for their
/// contacts. Turns contacts between steps into rows.
template <Scalar S>
class ContactStage {
 public:
  using State = WorldState<S>;

  /// Updates the broad phase and the contact cache.
  void find_contacts(State& state) {
    sweep_boxes(state);
    pairs_.clear();
    state.contacts.begin_step(state.def.time_step);
    const auto may_touch = [&](std::uint32_t a, std::uint32_t b) {
      if (is_dormant(state, {a, b}) || !detail::may_touch(state, a, b)) return false;
      if (!state.broad_phase.is_loose(a) && !state.broad_phase.is_loose(b)) return true;
      refine(state, a);
      refine(state, b);
      return state.broad_phase.swept(a).overlaps(state.broad_phase.swept(b)) &&
             detail::may_touch(state, a, b);
    };
    state.broad_phase.find_pairs(moving_, may_touch, pairs_, state.report.pairs_tested);
    state.report.pairs_put_off +=
        crowd_.thin(pairs_, state.colliders.slot_count(),
                    [&](std::uint32_t tag) { return ball_of(state, tag); });
    collide_pairs(state);
    add_contacts(state);
  }

  /// Adds the constraints of all contacts.
  void add_constraints(State& state) const {
    const DynamicArray<CachedPoint<S>>& points = state.contacts.points();
    for (CachedManifold<S>& m : state.contacts.manifolds()) {
      if (!m.has_rows()) continue;
      const Collider<S>& a = state.colliders.at(m.shapes.a);
      const Collider<S>& b = state.colliders.at(m.shapes.b);
      const Material<S> material = state.material_of(a, b);
      detail::add_contacts(m, points, material, state.drift_of(a, b), a.body.index, b.body.index,
                           state.constraints);
      if (!(material.rolling_friction > S(0))) continue;
      add_rolling_friction(m, points, material.rolling_friction, state.body_of(a), state.body_of(b),
                           a.body.index, b.body.index, state.constraints);
    }
  }

  /// Moves the boxes of shapes that impulses took out of their swept boxes, so that queries between
  /// steps find them.
  void settle_boxes(State& state) const {
    using std::sqrt;
    for (std::size_t k = 0; k < moving_.size(); ++k) {
      const std::uint32_t i = moving_[k];
      const Collider<S>& c = state.colliders.at(i);
      const Start& start = starts_[k];
      const Transform<S>& end = state.body_of(c).center_pose;
      const S turn2 = (end.rotation.coeffs() - start.center_pose.rotation.coeffs()).squaredNorm();
      const S shift2 = (end.translation - start.center_pose.translation).squaredNorm();
      // A point at the distance r moves by 2 r sin(angle / 2), and unit quaternions by 2 sin(angle
      // / 4).
      const S turn = S(2) * c.radius * sqrt(turn2);
      if (state.broad_phase.settle(i, end.translation, sqrt(shift2), turn, start.reach)) continue;
      const Aabb<S> box = box_of(state, c);
      if (!state.broad_phase.swept(i).contains(box)) state.broad_phase.move(i, box);
    }
  }

  /// Stores the solved impulses in the contact cache.
  void store_impulses(State& state) const {
    DynamicArray<CachedPoint<S>>& points = state.contacts.points();
    std::size_t contact = 0;
    for (CachedManifold<S>& m : state.contacts.manifolds()) {
      if (!m.has_rows()) continue;
      for (std::uint32_t i = m.first; i < m.first + m.count; ++i) {
        const ContactConstraint<S>& c = state.constraints.contacts[contact++];
        points[i].impulse = c.impulse;
        points[i].transient_impulse = c.transient_impulse;
        points[i].position_excess = c.position_excess;
        points[i].took_impact = c.is_impact;
      }
      m.rolling_impulse = rolling_impulse(m, state.constraints);
    }
  }

 private:
  /// Result for a pair: manifolds in its chunk's buffer.
  struct Found {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    bool has_failed = false;
  };

  /// Start pose of a moving shape, and the margin of its swept box.
  struct Start {
    Transform<S> center_pose;
    S reach = S(0);
  };

  /// Computes the swept box of a loose shape.
  static void refine(State& state, std::uint32_t tag) {
    if (!state.broad_phase.is_loose(tag)) return;
    state.broad_phase.refine(tag, swept_box(state, state.colliders.at(tag)));
  }

  void sweep_boxes(State& state) {
    moving_.clear();
    starts_.clear();
    for (const std::uint32_t i : state.colliders.live_slots()) {
      const Collider<S>& c = state.colliders.at(i);
      // Forces do not move the bodies of half-spaces. Half-spaces are always listed.
      const Body<S>& body = state.body_of(c);
      // A fixed trigger that was put somewhere may hold sleepers, which do not look for it.
      const bool is_put = c.is_trigger && body.sleep.is_dirty;
      if ((body.motion == Motion::fixed && !is_put) || c.half_space || body.is_asleep()) continue;
      const S reach = reach_of(state, c, c);
      const Vec3<S>& center = body.center_pose.translation;
      if (!state.broad_phase.stays(i, reach, center)) {
        state.broad_phase.move(i, box_of(state, c).inflated(reach), reach, center);
      }
      // Moving shapes find the shapes at rest.
      if (!state.is_active(c.body.index)) continue;
      moving_.push_back(i);
      starts_.push_back({body.center_pose, reach});
    }
  }

  /// The ball within a shape, in world axes. Only dynamic bodies take part in a crowd. Pairs with
  /// others are as few as they.
  [[nodiscard]] static InnerBall<S> ball_of(const State& state, std::uint32_t tag) {
    const Collider<S>& c = state.colliders.at(tag);
    const Body<S>& body = state.body_of(c);
    // A trigger does not push, so its pairs do not part: none of them waits.
    if (!body.is_dynamic() || c.is_trigger) return {};
    return {body.center_pose * c.inner.center, c.inner.radius};
  }

  /// Returns whether two shapes skip each other in this step because one of them sleeps on.
  [[nodiscard]] static bool is_dormant(const State& state, const ShapePair& pair) {
    const Collider<S>& a = state.colliders.at(pair.a);
    const Collider<S>& b = state.colliders.at(pair.b);
    if (!state.body_of(a).is_asleep() && !state.body_of(b).is_asleep()) return false;
    // A trigger that moves over a sleeper tells of it, and does not wake it.
    const bool has_trigger = a.is_trigger || b.is_trigger;
    return !has_trigger || (!state.is_active(a.body.index) && !state.is_active(b.body.index));
  }

  /// Queries the backend for all pairs, in chunks. Chunks are the same for any number of threads
  /// and write to buffers of their own.
  void collide_pairs(State& state) {
    const std::size_t chunks =
        (pairs_.size() + chosen::pairs_per_task - 1) / chosen::pairs_per_task;
    found_.resize(pairs_.size());
    if (buffers_.size() < chunks) buffers_.resize(chunks);
    for (std::size_t i = 0; i < chunks; ++i) {
      buffers_[i].clear();
      // Reserve the largest size so far: the pairs of a chunk change, which must not allocate.
      buffers_[i].reserve(most_manifolds_);
    }
    const auto task = [this, &state](std::size_t chunk) {
      const std::size_t end = std::min(pairs_.size(), (chunk + 1) * chosen::pairs_per_task);
      for (std::size_t i = chunk * chosen::pairs_per_task; i < end; ++i) {
        found_[i] = collide(state, pairs_[i], buffers_[chunk]);
      }
    };
    if (pairs_.size() < chosen::fewest_shared_pairs) {
      for (std::size_t i = 0; i < chunks; ++i) task(i);
    } else {
      state.def.parallel_for(chunks, std::cref(task));
    }
    for (std::size_t i = 0; i < chunks; ++i) {
      most_manifolds_ = std::max(most_manifolds_, buffers_[i].size());
    }
  }

  [[nodiscard]] static Found collide(const State& state, const ShapePair& pair,
                                     ContactManifolds<S>& out) {
    Found found;
    found.first = static_cast<std::uint32_t>(out.size());
    found.has_failed = collide_pair(state, pair, out) != ContactStatus::ok;
    if (found.has_failed) out.resize(found.first);
    found.count = static_cast<std::uint32_t>(out.size()) - found.first;
    return found;
  }

  /// Puts the backend's contacts into the cache, in the order of the pairs.
  void add_contacts(State& state) {
    state.report.pairs_collided += pairs_.size();
    // Contacts of sleeping bodies persist, in their position.
    const bool has_sleepers = state.sleeping_bodies > 0;
    const auto stays = [&](const ShapePair& pair) { return is_dormant(state, pair); };
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      if (found_[i].has_failed) ++state.report.backend_failures;
      if (found_[i].count == 0) continue;
      if (has_sleepers) state.contacts.persist_before(pairs_[i], stays);
      const Collider<S>& a = state.colliders.at(pairs_[i].a);
      const Transform<S>& X_WA = state.body_of(a).center_pose;
      const Collider<S>& b = state.colliders.at(pairs_[i].b);
      const Transform<S>& X_WB = state.body_of(b).center_pose;
      state.contacts.add(
          pairs_[i],
          std::span(buffers_[i / chosen::pairs_per_task]).subspan(found_[i].first, found_[i].count),
          {a.is_centered ? X_WA.rotation_matrix()
                         : rotation_matrix<S>(X_WA.rotation * a.X_CmS.rotation),
           a.is_centered ? zero<Vec3<S>>() : X_WA.rotate(a.X_CmS.translation),
           X_WB.translation - X_WA.translation, X_WA.translation, a.is_trigger || b.is_trigger});
    }
    if (has_sleepers) state.contacts.persist_before({~0u, ~0u}, stays);
    for (const CachedManifold<S>& m : state.contacts.manifolds()) {
      state.report.contact_points += m.has_rows() ? m.count : 0;
    }
  }

  DynamicArray<std::uint32_t> moving_;
  DynamicArray<Start> starts_;  // One for each of them.
  DynamicArray<ShapePair> pairs_;
  CrowdLimit<S> crowd_;
  DynamicArray<Found> found_;
  DynamicArray<ContactManifolds<S>> buffers_;
  std::size_t most_manifolds_ = chosen::pairs_per_task;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
