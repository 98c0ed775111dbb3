/// @file
/// Contacts of the last step as callers see them: which bodies touch, since when, and with what
/// impulse. Computed on request from the solver's own data.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/contact_cache.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/dynamics/bodies/body.hpp>
#include <bristle/math/spatial.hpp>

#include <algorithm>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI {

/// Two shapes whose contact began, persisted or ended. Shapes *touch* in a step when one of their
/// contacts exchanged an impulse along its normal, or had a gap <= 0 when the step began.
struct ContactEvent {
  /// Change of a contact in the last step.
  enum class Phase {
    /// The shapes touch, unlike in the step before.
    begin,
    /// The shapes touched in both steps.
    persist,
    /// The shapes touched in the step before and no longer do, or one of them was removed.
    end
  };

  /// Change of the contact.
  Phase phase = Phase::begin;
  /// [-] Shape with the smaller index. After an end it may be removed, as may all below.
  ShapeId shape_a{};
  /// [-] Shape with the larger index.
  ShapeId shape_b{};
  /// [-] Body of `shape_a`.
  BodyId body_a{};
  /// [-] Body of `shape_b`.
  BodyId body_b{};
};

/// All contacts of two shapes in the last step. Valid until the world changes.
template <Scalar S>
class ContactReading {
 public:
  /// One contact point. World axes. The cache of contacts keeps arms and impulses along
  /// tangents, which are the solver's own; this is their meaning for a caller.
  struct Point {
    /// [m] Position when the step began.
    Vec3<S> position = detail::zero<Vec3<S>>();
    /// [1] Unit normal from shape a to shape b.
    Vec3<S> normal = detail::unit_z<Vec3<S>>();
    /// [m] Distance of the surfaces when the step began. Negative where they overlap.
    S gap = S(0);
    /// [N s] Impulse on b along the normal, >= 0.
    S normal_impulse = S(0);
    /// [N s] Impulse of friction on b.
    Vec3<S> friction_impulse = detail::zero<Vec3<S>>();
  };

  /// [-] Shape with the smaller index.
  ShapeId shape_a{};
  /// [-] Shape with the larger index.
  ShapeId shape_b{};
  /// [-] Body of `shape_a`.
  BodyId body_a{};
  /// [-] Body of `shape_b`.
  BodyId body_b{};

  /// @param manifolds  All manifolds of the two shapes, at least one.
  ContactReading(std::span<const detail::CachedManifold<S>> manifolds,
                 const detail::DynamicArray<detail::CachedPoint<S>>& points)
      : manifolds_(manifolds), points_(&points) {}

  /// Returns whether they touch, as in `ContactEvent`.
  [[nodiscard]] bool is_touching() const;

  /// Calls visit(const Point&) for each point.
  template <typename Visit>
  void for_each_point(Visit&& visit) const;

  /// [N s, N m s] Total impulse on b about a point [m] of the world. Its negative acts on a.
  [[nodiscard]] Wrench<S> impulse_about(const Vec3<S>& point) const;

  /// [N s, N m s] Total impulse on body a about its centre of mass at the start of the step.
  /// The contact's part of its change of (angular) momentum.
  [[nodiscard]] Wrench<S> impulse_on_a() const;
  /// [N s, N m s] The same on body b about its own centre of mass.
  [[nodiscard]] Wrench<S> impulse_on_b() const;

 private:
  /// Sums over points with the arms `arm_of(manifold, point)`.
  template <typename ArmOf>
  [[nodiscard]] Wrench<S> sum(ArmOf&& arm_of) const;

  std::span<const detail::CachedManifold<S>> manifolds_;
  const detail::DynamicArray<detail::CachedPoint<S>>* points_;
};

// Implementation ----------------------------------------------------------------------------------

namespace detail {

/// [N s] A point's impulse on b, world axes.
template <Scalar S>
[[nodiscard]] Vec3<S> point_impulse(const CachedManifold<S>& m, const CachedPoint<S>& point) {
  return point.impulse[0] * m.normal + friction_impulse(m, point);
}

/// Manifolds of the pair at index `first`.
template <Scalar S>
[[nodiscard]] std::span<const CachedManifold<S>> same_pair(
    const DynamicArray<CachedManifold<S>>& manifolds, std::size_t first) {
  std::size_t end = first;
  while (end < manifolds.size() && manifolds[end].shapes == manifolds[first].shapes) ++end;
  return std::span(manifolds).subspan(first, end - first);
}

template <Scalar S>
[[nodiscard]] bool touches(std::span<const CachedManifold<S>> manifolds,
                           const DynamicArray<CachedPoint<S>>& points) {
  for (const CachedManifold<S>& m : manifolds) {
    for (std::uint32_t i = m.first; i < m.first + m.count; ++i) {
      if (points[i].impulse[0] > S(0) || points[i].gap <= S(0)) return true;
    }
  }
  return false;
}

/// Calls visit(shapes, touched, touches) for each pair that touches now or did in the step before,
/// in ascending order.
template <Scalar S, typename Visit>
void for_each_touch(const ContactCache<S>& cache, Visit&& visit) {
  const DynamicArray<CachedManifold<S>>& before = cache.last_manifolds();
  const DynamicArray<CachedManifold<S>>& now = cache.manifolds();
  std::size_t i = 0;
  std::size_t k = 0;
  while (i < before.size() || k < now.size()) {
    const bool is_old =
        i < before.size() && (k == now.size() || !(now[k].shapes < before[i].shapes));
    const bool is_new =
        k < now.size() && (i == before.size() || !(before[i].shapes < now[k].shapes));
    const ShapePair shapes = is_old ? before[i].shapes : now[k].shapes;
    bool touched = false;
    bool touches_now = false;
    if (is_old) {
      const auto manifolds = same_pair(before, i);
      touched = touches(manifolds, cache.last_points());
      i += manifolds.size();
    }
    if (is_new) {
      const auto manifolds = same_pair(now, k);
      touches_now = touches(manifolds, cache.points());
      k += manifolds.size();
    }
    if (touched || touches_now) visit(shapes, touched, touches_now);
  }
}

/// Calls visit(const ContactEvent&) for each event of the last step, ends by removal first.
/// @param state  A `WorldState`.
template <typename State, typename Visit>
void for_each_event(const State& state, Visit&& visit) {
  for (const ContactEvent& event : state.ended) visit(event);
  for_each_touch(state.contacts, [&](ShapePair shapes, bool touched, bool touches) {
    const ContactEvent::Phase phase = !touched  ? ContactEvent::Phase::begin
                                      : touches ? ContactEvent::Phase::persist
                                                : ContactEvent::Phase::end;
    visit(ContactEvent{phase, state.colliders.handle(shapes.a), state.colliders.handle(shapes.b),
                       state.colliders.at(shapes.a).body, state.colliders.at(shapes.b).body});
  });
}

/// Adds the begins and ends of the last step to those that the world keeps.
template <typename State>
void keep_events(State& state) {
  for_each_event(state, [&](const ContactEvent& event) {
    if (event.phase != ContactEvent::Phase::persist) state.kept_events.push_back(event);
  });
}

}  // namespace detail

template <Scalar S>
bool ContactReading<S>::is_touching() const {
  return detail::touches(manifolds_, *points_);
}

template <Scalar S>
template <typename Visit>
void ContactReading<S>::for_each_point(Visit&& visit) const {
  for (const detail::CachedManifold<S>& m : manifolds_) {
    for (std::uint32_t i = m.first; i < m.first + m.count; ++i) {
      const detail::CachedPoint<S>& point = (*points_)[i];
      visit(Point{m.center_a + point.arm_a, m.normal, point.gap, point.impulse[0],
                  detail::friction_impulse(m, point)});
    }
  }
}

template <Scalar S>
template <typename ArmOf>
Wrench<S> ContactReading<S>::sum(ArmOf&& arm_of) const {
  Wrench<S> total;
  for (const detail::CachedManifold<S>& m : manifolds_) {
    for (std::uint32_t i = m.first; i < m.first + m.count; ++i) {
      const detail::CachedPoint<S>& point = (*points_)[i];
      total += Wrench<S>::at(arm_of(m, point), detail::point_impulse(m, point));
    }
    total.torque += m.rolling_impulse;
  }
  return total;
}

template <Scalar S>
Wrench<S> ContactReading<S>::impulse_about(const Vec3<S>& point) const {
  return sum([&](const detail::CachedManifold<S>& m, const detail::CachedPoint<S>& p) -> Vec3<S> {
    return m.center_a - point + p.acting_arm_a();
  });
}

template <Scalar S>
Wrench<S> ContactReading<S>::impulse_on_a() const {
  return -sum([](const detail::CachedManifold<S>&, const detail::CachedPoint<S>& p) {
    return p.acting_arm_a();
  });
}

template <Scalar S>
Wrench<S> ContactReading<S>::impulse_on_b() const {
  return sum([](const detail::CachedManifold<S>&, const detail::CachedPoint<S>& p) {
    return p.acting_arm_b();
  });
}

}  // namespace bristle::inline BRISTLE_ABI
