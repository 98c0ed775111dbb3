/// @file
/// First stage of a step: who is near whom, and where they touch.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/contact_aim.hpp>
#include <bristle/world/world_state.hpp>

#include <vector>

namespace bristle {

/// Moves the boxes of all shapes, finds the pairs that may touch, asks the backend where they do,
/// and turns contacts between steps into rows.
template <Scalar S, typename Backend>
class ContactStage {
 public:
  using State = WorldState<S, Backend>;

  /// Updates the broad phase and the contact cache.
  void find_contacts(State& state) {
    sweep_boxes(state);
    pairs_.clear();
    state.contacts.begin_step();
    if (moving_.empty()) return;
    state.broad_phase.find_pairs(
        moving_, [&](std::uint32_t a, std::uint32_t b) { return accepts(state, a, b); }, pairs_,
        state.report.pairs_tested);
    for (const ShapePair& pair : pairs_) collide(state, pair);
    state.report.contact_points = state.contacts.points().size();
  }

  /// Adds the constraints of all contacts.
  void add_constraints(State& state) const {
    for (const CachedManifold<S>& m : state.contacts.manifolds()) {
      const Collider<S, Backend>& a = state.colliders.at(m.shapes.a);
      const Collider<S, Backend>& b = state.colliders.at(m.shapes.b);
      add_contacts(m, state.contacts.points(), combined(a.material, b.material), a.body.index,
                   b.body.index, state.constraints);
    }
  }

  /// Moves the boxes of shapes that impulses took out of what free motion would sweep, so that
  /// queries between steps find them.
  void settle_boxes(State& state) const {
    for (const std::uint32_t i : moving_) {
      const Collider<S, Backend>& c = state.colliders.at(i);
      const Aabb<S> box = transformed(c.bounds, state.body_of(c).center_pose * c.X_CmS);
      if (!state.broad_phase.swept(i).contains(box)) state.broad_phase.move(i, box);
    }
  }

  /// Keeps the impulses that the solver found.
  void store_impulses(State& state) const {
    std::vector<CachedPoint<S>>& points = state.contacts.points();
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].impulse = state.constraints.contacts[i].impulse;
      points[i].took_impact = state.constraints.contacts[i].is_impact;
    }
  }

 private:
  void sweep_boxes(State& state) {
    moving_.clear();
    for (std::uint32_t i = 0; i < state.colliders.slot_count(); ++i) {
      if (!state.colliders.is_live(i)) continue;
      const Collider<S, Backend>& c = state.colliders.at(i);
      // Half-spaces belong to bodies that forces do not move, and are always listed.
      if (state.body_of(c).motion == Motion::fixed || c.half_space) continue;
      state.broad_phase.move(i, swept_box(state, c));
      moving_.push_back(i);
    }
  }

  [[nodiscard]] bool accepts(const State& state, std::uint32_t tag_a, std::uint32_t tag_b) const {
    const Collider<S, Backend>& a = state.colliders.at(tag_a);
    const Collider<S, Backend>& b = state.colliders.at(tag_b);
    if (a.body == b.body) return false;
    const Body<S>& body_a = state.body_of(a);
    const Body<S>& body_b = state.body_of(b);
    if (!body_a.is_dynamic() && !body_b.is_dynamic()) return false;
    if (!may_meet(body_a.filter, body_b.filter)) return false;
    const ShapePair bodies{std::min(a.body.index, b.body.index),
                           std::max(a.body.index, b.body.index)};
    if (std::binary_search(state.unpaired.begin(), state.unpaired.end(), bodies)) return false;
    return reaches_plane(state, tag_a, b) && reaches_plane(state, tag_b, a);
  }

  /// Whether a shape can get to another one within the step that is a half-space and may move, too;
  /// true for all others, whose boxes overlap.
  [[nodiscard]] bool reaches_plane(const State& state, std::uint32_t tag,
                                   const Collider<S, Backend>& plane) const {
    return !plane.half_space || state.reaches(state.broad_phase.swept(tag).inflated(
                                                  reach_of(state, plane, state.colliders.at(tag))),
                                              plane);
  }

  [[nodiscard]] Aabb<S> swept_box(const State& state, const Collider<S, Backend>& c) const {
    if (c.half_space) return c.bounds;
    return transformed(c.bounds, state.body_of(c).center_pose * c.X_CmS)
        .inflated(reach_of(state, c, c));
  }

  /// [m] How far any point of a shape that can meet another one can get within the step.
  [[nodiscard]] S reach_of(const State& state, const Collider<S, Backend>& c,
                           const Collider<S, Backend>& other) const {
    const Twist<S>& free = state.solver_bodies[c.body.index].free;
    S radius = c.radius;
    if (c.half_space) {
      // It has no farthest point; what counts is where the other shape is.
      radius = other.radius + (state.body_of(other).center_pose.translation -
                               state.body_of(c).center_pose.translation)
                                  .norm();
    }
    return state.def.time_step * (free.linear.norm() + free.angular.norm() * radius);
  }

  void collide(State& state, const ShapePair& pair) {
    const Collider<S, Backend>& a = state.colliders.at(pair.a);
    const Collider<S, Backend>& b = state.colliders.at(pair.b);
    const Body<S>& body_a = state.body_of(a);
    const Body<S>& body_b = state.body_of(b);
    // Centres of mass are subtracted first: far from the world's origin nothing else is lost.
    const Vec3<S> between = body_b.center_pose.translation - body_a.center_pose.translation;
    const Transform<S> X_a = pose_at_center(body_a, a);
    const Transform<S> X_b = pose_at_center(body_b, b);
    const Mat3<S> R_a = X_a.rotation_matrix();
    const Transform<S> X_SaSb{
        X_a.rotation.conjugate() * X_b.rotation,
        R_a.transpose().lazyProduct(Vec3<S>(between + X_b.translation - X_a.translation))};
    const S margin = reach_of(state, a, b) + reach_of(state, b, a);
    found_.clear();
    ++state.report.pairs_collided;
    if (Backend::collide(a.shape, b.shape, X_SaSb, margin, found_) != ContactStatus::ok) {
      ++state.report.backend_failures;
      return;
    }
    state.contacts.add(pair, found_, R_a, X_a.translation, between);
  }

  /// [m] Where a shape stands from its body's centre of mass, world axes.
  [[nodiscard]] static Transform<S> pose_at_center(const Body<S>& body,
                                                   const Collider<S, Backend>& c) {
    const Quat<S>& R_WC = body.center_pose.rotation;
    return {R_WC * c.X_CmS.rotation, R_WC * c.X_CmS.translation};
  }

  std::vector<std::uint32_t> moving_;
  std::vector<ShapePair> pairs_;
  ContactManifolds<S> found_;
};

}  // namespace bristle
