/// @file
/// Which shapes may touch within a step, and where they do.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world_state.hpp>

#include <algorithm>

namespace bristle::inline BRISTLE_ABI::detail {

/// [m] How far any point of a shape that can meet another one can get within the step.
template <Scalar S, typename Backend>
[[nodiscard]] S reach_of(const WorldState<S, Backend>& state, const Collider<S, Backend>& c,
                         const Collider<S, Backend>& other) {
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

/// [m] Box of a shape where it is; infinite for a half-space.
template <Scalar S, typename Backend>
[[nodiscard]] Aabb<S> box_of(const WorldState<S, Backend>& state, const Collider<S, Backend>& c) {
  if (c.half_space) return c.bounds;
  const Transform<S>& X = state.body_of(c).center_pose;
  if (c.kind == ShapeKind::sphere && c.is_centered) {
    return {c.bounds.lower + X.translation, c.bounds.upper + X.translation};
  }
  return transformed(c.bounds, c.is_centered ? X : X * c.X_CmS);
}

/// [m] Box of all that a shape can reach within the step.
template <Scalar S, typename Backend>
[[nodiscard]] Aabb<S> swept_box(const WorldState<S, Backend>& state,
                                const Collider<S, Backend>& c) {
  const Aabb<S> box = box_of(state, c);
  return c.half_space ? box : box.inflated(reach_of(state, c, c));
}

/// Whether a shape can get to another one within the step that is a half-space and may move, too;
/// true for all others, whose boxes overlap.
/// @param swept  [m] Box of all that the shape can reach.
template <Scalar S, typename Backend>
[[nodiscard]] bool reaches_plane(const WorldState<S, Backend>& state, const Collider<S, Backend>& c,
                                 const Aabb<S>& swept, const Collider<S, Backend>& plane) {
  return !plane.half_space || state.reaches(swept.inflated(reach_of(state, plane, c)), plane);
}

/// Whether two shapes with overlapping boxes are asked of the backend. Their boxes in the broad
/// phase must be those of all they can reach in this step.
template <Scalar S, typename Backend>
[[nodiscard]] bool may_touch(const WorldState<S, Backend>& state, std::uint32_t tag_a,
                             std::uint32_t tag_b) {
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
  return reaches_plane(state, a, state.broad_phase.swept(tag_a), b) &&
         reaches_plane(state, b, state.broad_phase.swept(tag_b), a);
}

/// Appends the manifolds of a pair, in the frame of its first shape, with gaps of at most what can
/// close within the step.
template <Scalar S, typename Backend>
ContactStatus collide_pair(const WorldState<S, Backend>& state, const ShapePair& pair,
                           ContactManifolds<S>& out) {
  const Collider<S, Backend>& a = state.colliders.at(pair.a);
  const Collider<S, Backend>& b = state.colliders.at(pair.b);
  const Transform<S>& X_WA = state.body_of(a).center_pose;
  const Transform<S>& X_WB = state.body_of(b).center_pose;
  // Of each shape about its body's centre of mass, world axes. Centres of mass are subtracted
  // first: far from the world's origin nothing else is lost.
  const auto about_center = [](const Transform<S>& X,
                               const Collider<S, Backend>& c) -> Transform<S> {
    if (c.is_centered) return {X.rotation, Vec3<S>::Zero()};
    return {X.rotation * c.X_CmS.rotation, X.rotation * c.X_CmS.translation};
  };
  const Transform<S> X_a = about_center(X_WA, a);
  const Transform<S> X_b = about_center(X_WB, b);
  const Vec3<S> p = (X_WB.translation - X_WA.translation) + X_b.translation - X_a.translation;
  const Quat<S> R_SaW = X_a.rotation.conjugate();
  const Transform<S> X_SaSb{R_SaW * X_b.rotation, R_SaW * p};
  return Backend::collide(a.shape, b.shape, X_SaSb, reach_of(state, a, b) + reach_of(state, b, a),
                          out);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
