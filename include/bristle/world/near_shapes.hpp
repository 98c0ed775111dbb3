/// @file
/// Shapes that may touch, and their contacts.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world_state.hpp>

#include <algorithm>

namespace bristle::inline BRISTLE_ABI::detail {

/// [m] Swept margin: how far any point of a shape that can meet `other` may move within the step.
template <Scalar S>
[[nodiscard]] S reach_of(const WorldState<S>& state, const Collider<S>& c,
                         const Collider<S>& other) {
  const Twist<S>& free = state.solver_bodies[c.body.index].free;
  S radius = c.radius;
  if (c.half_space) {
    // A half-space has no farthest point. The position of the other shape counts.
    radius = other.radius + (state.body_of(other).center_pose.translation -
                             state.body_of(c).center_pose.translation)
                                .norm();
  }
  return state.def.time_step * (free.linear.norm() + free.angular.norm() * radius);
}

/// [m] Present box; infinite for a half-space.
template <Scalar S>
[[nodiscard]] Aabb<S> box_of(const WorldState<S>& state, const Collider<S>& c) {
  if (c.half_space) return c.bounds;
  const Transform<S>& X = state.body_of(c).center_pose;
  if (c.kind == ShapeKind::sphere && c.is_centered) {
    return {c.bounds.lower + X.translation, c.bounds.upper + X.translation};
  }
  return transformed(c.bounds, c.is_centered ? X : X * c.X_CmS);
}

/// [m] Box inflated by the swept margin.
template <Scalar S>
[[nodiscard]] Aabb<S> swept_box(const WorldState<S>& state, const Collider<S>& c) {
  const Aabb<S> box = box_of(state, c);
  return c.half_space ? box : box.inflated(reach_of(state, c, c));
}

/// Returns whether `c` can reach the half-space `plane` within the step. True if `plane` is not a
/// half-space: its box was tested already.
/// @param swept  [m] Swept box of `c`.
template <Scalar S>
[[nodiscard]] bool reaches_plane(const WorldState<S>& state, const Collider<S>& c,
                                 const Aabb<S>& swept, const Collider<S>& plane) {
  return !plane.half_space || state.reaches(swept.inflated(reach_of(state, plane, c)), plane);
}

/// Returns whether the backend is queried for two shapes with overlapping boxes. Their boxes in the
/// broad phase must be swept boxes of this step.
template <Scalar S>
[[nodiscard]] bool may_touch(const WorldState<S>& state, std::uint32_t tag_a, std::uint32_t tag_b) {
  const Collider<S>& a = state.colliders.at(tag_a);
  const Collider<S>& b = state.colliders.at(tag_b);
  if (a.body == b.body) return false;
  const Body<S>& body_a = state.body_of(a);
  const Body<S>& body_b = state.body_of(b);
  if (!body_a.is_dynamic() && !body_b.is_dynamic()) return false;
  if (!may_meet(body_a.filter, body_b.filter)) return false;
  const ShapePair bodies{std::min(a.body.index, b.body.index),
                         std::max(a.body.index, b.body.index)};
  if (std::binary_search(state.unpaired.begin(), state.unpaired.end(), bodies)) return false;
  if (!reaches_plane(state, a, state.broad_phase.swept(tag_a), b) ||
      !reaches_plane(state, b, state.broad_phase.swept(tag_b), a)) {
    return false;
  }
  return !state.def.may_collide || state.def.may_collide(a.user_data, b.user_data);
}

/// Appends the manifolds of a pair, in the frame of its first shape. Gaps are those that can close
/// within the step.
template <Scalar S>
ContactStatus collide_pair(const WorldState<S>& state, const ShapePair& pair,
                           ContactManifolds<S>& out) {
  const Collider<S>& a = state.colliders.at(pair.a);
  const Collider<S>& b = state.colliders.at(pair.b);
  const Transform<S>& X_WA = state.body_of(a).center_pose;
  const Transform<S>& X_WB = state.body_of(b).center_pose;
  // Poses about the centre of mass of each shape's body, world axes. Centres of mass are subtracted
  // first, which keeps precision far from the world's origin.
  const auto about_center = [](const Transform<S>& X, const Collider<S>& c) -> Transform<S> {
    if (c.is_centered) return {X.rotation, zero<Vec3<S>>()};
    return {X.rotation * c.X_CmS.rotation, X.rotation * c.X_CmS.translation};
  };
  const Transform<S> X_a = about_center(X_WA, a);
  const Transform<S> X_b = about_center(X_WB, b);
  const Vec3<S> p = (X_WB.translation - X_WA.translation) + X_b.translation - X_a.translation;
  const Quat<S> R_SaW = X_a.rotation.conjugate();
  const Transform<S> X_SaSb{R_SaW * X_b.rotation, R_SaW * p};
  return a.shape.collide(b.shape, X_SaSb, reach_of(state, a, b) + reach_of(state, b, a), out);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
