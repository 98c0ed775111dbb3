/// @file
/// Shapes that may touch, and their contacts.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/impact_plane.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/world/world_constants.hpp>
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

/// Returns whether a shape is convex and has an end.
[[nodiscard]] inline bool is_convex_body(ShapeKind kind) {
  return kind != ShapeKind::half_space && kind != ShapeKind::triangle_mesh;
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
  const S reach = reach_of(state, a, b) + reach_of(state, b, a);
  const std::size_t first = out.size();
  const ContactStatus status = a.shape.collide(b.shape, X_SaSb, reach, out);
  // Nothing passes a half-space, nor flies past one, and triggers stop nothing. Bodies of
  // symplectic Euler move by the velocities of the end alone: their impulses act at the start, at
  // one point of both.
  if (status != ContactStatus::ok || out.size() == first || a.half_space || b.half_space ||
      a.is_trigger || b.is_trigger || state.def.integrator != Integrator::trapezoidal) {
    return status;
  }
  const auto way_by = [&](const Twist<S> SolverBody<S>::*twist) -> Vec3<S> {
    const auto velocity = [&](const Collider<S>& c, const Vec3<S>& place) {
      return (state.solver_bodies[c.body.index].*twist).at(place);
    };
    return S(chosen::contact_lookahead) * state.def.time_step *
           (R_SaW * (velocity(b, X_b.translation) - velocity(a, X_a.translation)));
  };
  const Vec3<S> way = way_by(&SolverBody<S>::start);
  // Arms of contacts move along with it, and are squared.
  if (!has_finite_square(way)) return status;
  if (out.size() == first + 1 && is_convex_body(a.kind) && is_convex_body(b.kind)) {
    const S round_off = Tolerance<S>::equal() * (a.radius + b.radius + reach);
    // Queries rewrite the place of the manifold.
    ContactManifold<S> manifold = out[first];
    const auto collide = [&](const Vec3<S>& shift) {
      out.resize(first);
      const Transform<S> moved{X_SaSb.rotation, X_SaSb.translation + shift};
      const bool has_one = a.shape.collide(b.shape, moved, reach, out) == ContactStatus::ok &&
                           out.size() == first + 1;
      if (has_one) manifold = out[first];
      return has_one;
    };
    advance_contact(manifold, way, way_by(&SolverBody<S>::free), round_off, collide);
    out.resize(first + 1);
    out[first] = manifold;
  }
  const auto add_ball = [&](ContactManifold<S>& manifold, const Collider<S>& c,
                            const Transform<S>& X_W, const Vec3<S>& place, bool is_b) {
    if (c.kind == ShapeKind::sphere || !state.body_of(c).is_dynamic()) return;
    const S& radius = c.inner.radius;
    if (!(radius > S(0) && -manifold.normal.dot(way) > radius)) return;
    const Vec3<S> center = R_SaW * (place + X_W.rotate(c.inner.center));
    add_inner_ball(manifold, is_b ? Vec3<S>(center + manifold.shift) : center, radius, is_b);
  };
  const Vec3<S> p_a = -X_a.translation;
  const Vec3<S> p_b = (X_WB.translation - X_WA.translation) - X_a.translation;
  for (std::size_t i = first; i < out.size(); ++i) {
    add_ball(out[i], a, X_WA, p_a, false);
    add_ball(out[i], b, X_WB, p_b, true);
  }
  return status;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
