/// @file
/// A step takes no body past something that it was not asked about.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/dynamics/bodies/islands.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/world/near_shapes.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Ends the way of an island where one of its bodies gets into a shape that it has no contact with.
///
/// Contacts are sought as far as bodies move freely. What is hit, or driven by a motor, goes
/// farther, and may get past a thin wall. The whole island then goes only so far. Its velocities
/// stay, so the next step seeks that contact.
template <Scalar S>
class WayLimit {
 public:
  using State = WorldState<S>;

  /// Shortens the motions of a solved step.
  /// @param moving   Tags of the shapes that may move.
  /// @param islands  Those of the step.
  void apply(State& state, const DynamicArray<std::uint32_t>& moving,
             const DynamicArray<Island>& islands) {
    // Without constraints bodies move freely. Sensors may push them then, too.
    if (islands.empty() && state.report.explicit_pairs == 0) return;
    shares_.reserve(state.solver_bodies.size());
    shares_.clear();
    for (const std::uint32_t tag : moving) {
      const Collider<S>& c = state.colliders.at(tag);
      if (c.is_trigger || !is_beyond_reach(state, c)) continue;
      look_ahead(state, tag);
    }
    if (shares_.empty()) return;
    for (const Island& island : islands) {
      S least = S(1);
      for (const std::uint32_t slot : island.bodies) least = std::min(least, shares_[slot]);
      for (const std::uint32_t slot : island.bodies) shares_[slot] = least;
      state.report.delayed_islands += least < S(1) ? 1 : 0;
    }
    for (std::size_t slot = 0; slot < shares_.size(); ++slot) {
      Twist<S>& motion = state.solver_bodies[slot].motion;
      if (shares_[slot] < S(1)) motion = shares_[slot] * motion;
    }
  }

 private:
  /// [-] Bound of the steps of an advancement. Each ends before the shapes touch.
  static constexpr int most_advances = 16;

  /// Returns whether a shape moves farther than contacts were sought.
  [[nodiscard]] static bool is_beyond_reach(const State& state, const Collider<S>& c) {
    const SolverBody<S>& body = state.solver_bodies[c.body.index];
    if (!body.moves || body.follows_joints) return false;
    if (body.motion.linear.squaredNorm() <= body.free.linear.squaredNorm() &&
        body.motion.angular.squaredNorm() <= body.free.angular.squaredNorm()) {
      return false;
    }
    // Free motion by the trapezoidal rule may be longer than by the velocity at its end.
    const S forced = state.def.time_step * (body.free.linear - body.start.linear).norm();
    return way_of(state, c) > reach_of(state, c, c) + forced;
  }
  /// [m] How far the points of a shape move, at most.
  [[nodiscard]] static S way_of(const State& state, const Collider<S>& c) {
    const Twist<S>& motion = state.solver_bodies[c.body.index].motion;
    return state.def.time_step * (motion.linear.norm() + motion.angular.norm() * c.radius);
  }

  void look_ahead(const State& state, std::uint32_t tag) {
    const Collider<S>& c = state.colliders.at(tag);
    const Aabb<S> box = box_of(state, c).inflated(way_of(state, c));
    state.broad_phase.overlap(box, [&](std::uint32_t other) {
      if (!is_unasked(state, tag, other)) return true;
      const Collider<S>& met = state.colliders.at(other);
      const S share = share_until_in(state, c, met);
      if (!(share < S(1))) return true;
      if (shares_.empty()) shares_.assign(state.solver_bodies.size(), S(1));
      for (const std::uint32_t slot : {c.body.index, met.body.index}) {
        if (state.solver_bodies[slot].moves) shares_[slot] = std::min(shares_[slot], share);
      }
      return true;
    });
  }

  /// Returns whether two shapes push each other where they meet, and have no contact in this step.
  /// Nothing passes a half-space.
  [[nodiscard]] static bool is_unasked(const State& state, std::uint32_t tag, std::uint32_t other) {
    const Collider<S>& c = state.colliders.at(other);
    if (c.is_trigger || c.half_space || !may_push(state, tag, other)) return false;
    const ShapePair pair{std::min(tag, other), std::max(tag, other)};
    const DynamicArray<CachedManifold<S>>& manifolds = state.contacts.manifolds();
    const auto place = std::lower_bound(
        manifolds.begin(), manifolds.end(), pair,
        [](const CachedManifold<S>& m, const ShapePair& p) { return m.shapes < p; });
    return place == manifolds.end() || place->shapes != pair || !place->has_rows();
  }

  /// [1] Share of the step after which two shapes are so far in each other that the next step may
  /// not find the way back, or 1 (conservative advancement, Mirtich 1996).
  [[nodiscard]] S share_until_in(const State& state, const Collider<S>& a, const Collider<S>& b) {
    const S dt = state.def.time_step;
    const S way = way_of(state, a) + way_of(state, b);
    const Twist<S>& motion_a = state.solver_bodies[a.body.index].motion;
    const Twist<S>& motion_b = state.solver_bodies[b.body.index].motion;
    const S turns = dt * (motion_a.angular.norm() * a.radius + motion_b.angular.norm() * b.radius);
    const Vec3<S> parting = dt * (motion_b.linear - motion_a.linear);
    const S touching = S(1e-4) * a.radius;
    // Convex shapes are pushed back out as long as neither is half through. Meshes may be thin.
    const bool is_mesh = a.kind == ShapeKind::triangle_mesh || b.kind == ShapeKind::triangle_mesh;
    const S depth = is_mesh ? S(0) : S(0.5) * std::min(a.inner.radius, b.inner.radius);
    S share = S(0);
    for (int i = 0; i < most_advances; ++i) {
      const auto about_center = [&](const Collider<S>& c, const Twist<S>& motion) -> Transform<S> {
        const Quat<S> R =
            exp_rotation<S>(share * dt * motion.angular) * state.body_of(c).center_pose.rotation;
        return {R * c.X_CmS.rotation, R * c.X_CmS.translation};
      };
      const Transform<S> X_a = about_center(a, motion_a);
      const Transform<S> X_b = about_center(b, motion_b);
      const Vec3<S> between =
          (state.body_of(b).center_pose.translation - state.body_of(a).center_pose.translation) +
          share * parting + X_b.translation - X_a.translation;
      const Quat<S> R_aW = X_a.rotation.conjugate();
      found_.clear();
      if (a.shape.collide(b.shape, {R_aW * X_b.rotation, R_aW * between}, (S(1) - share) * way,
                          found_) != ContactStatus::ok) {
        return S(1);
      }
      S next = S(1);
      S into = S(1);
      bool touches = false;
      for (const ContactManifold<S>& m : found_) {
        const S closing = turns - m.normal.dot(R_aW * parting);
        for (std::size_t k = 0; k < m.size; ++k) {
          const S gap = m.points[k].gap;
          // What overlaps already was put off: a pair of a crowd.
          if (i == 0 && gap <= S(0)) return S(1);
          if (!(share + gap / closing < S(1) && closing > S(0))) continue;
          touches = touches || gap <= touching;
          next = std::min(next, share + std::max(S(0), gap) / closing);
          into = std::min(into, share + std::max(S(0), gap + depth) / closing);
        }
      }
      if (touches || next >= S(1)) return into;
      share = next;
    }
    return share;
  }

  // [1] Share of its motion that a body makes, by slot. Empty if each makes all of it.
  DynamicArray<S> shares_;
  ContactManifolds<S> found_;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
