/// @file
/// Contact cache: contacts of this step with the impulses of the last one.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/broadphase.hpp>
#include <bristle/collision/collision_constants.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/core/no_index.hpp>
#include <bristle/geometry/contacts/contact_manifold.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// One point of contact between two bodies. It outlives the step, which `ContactPoint` of a query
/// and `ContactConstraint` of the solver do not. So it holds the impulses of the warm start.
template <Scalar S>
struct CachedPoint {
  /// [m] Arm from each centre of mass to the point at the start of the step, world axes.
  Vec3<S> arm_a = zero<Vec3<S>>();
  Vec3<S> arm_b = zero<Vec3<S>>();
  /// [m] Offset from these arms to those in the middle of the step, as far as they are known to
  /// move (`time_contact`).
  Vec3<S> mid_offset_a = zero<Vec3<S>>();
  Vec3<S> mid_offset_b = zero<Vec3<S>>();
  /// [m] Distance of the surfaces; negative where they overlap.
  S gap = S(0);
  /// [-] Pair of features in contact; see `ContactPoint::feature`.
  std::uint32_t feature = 0;
  /// [-] Number of the point of the last step that it goes on from; `no_index` for a new point.
  /// Valid within the step that has found the point.
  std::uint32_t last = no_index;
  /// [N s] Impulses along the normal, and along the two tangents of `tangent_basis`.
  std::array<S, 3> impulse{};
  /// [N s] Part that the next step does not need; see `ContactConstraint::transient_impulse`.
  std::array<S, 3> transient_impulse{};
  /// [N s] See `ContactConstraint::position_excess`.
  S position_excess = S(0);
  /// True if no contact of the last step predicts this one.
  bool is_fresh = true;
  /// True if the impulse stopped an approach. It does not predict the next step.
  bool took_impact = false;
  /// True if the impulse acts in the middle of the step.
  bool acts_at_mid = false;

  /// [m] Arms at which the impulse acts.
  [[nodiscard]] Vec3<S> acting_arm_a() const { return acts_at_mid ? arm_a + mid_offset_a : arm_a; }
  [[nodiscard]] Vec3<S> acting_arm_b() const { return acts_at_mid ? arm_b + mid_offset_b : arm_b; }
};

/// Contact points with a common normal between two shapes.
template <Scalar S>
struct CachedManifold {
  ShapePair shapes{};
  /// [-] Tells manifolds of one pair apart; see `ContactManifold::key`.
  std::uint32_t key = 0;
  /// [1] From a to b, world axes.
  Vec3<S> normal = unit_z<Vec3<S>>();
  /// [m] a's centre of mass in the world when the contact was found. The arm `arm_a` starts there.
  Vec3<S> center_a = zero<Vec3<S>>();
  /// [-] Its points are [first, first + count).
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  /// [-] True if it persists from the last step.
  bool is_persisted = false;
  /// [-] True if one of the shapes is a trigger.
  bool is_trigger = false;
  /// [N m s] Impulse of its rolling friction on b, world axes.
  Vec3<S> rolling_impulse = zero<Vec3<S>>();
  /// [-] First block of its rolling friction in this step, and number of its blocks.
  std::uint32_t rolling_block = 0;
  std::uint32_t rolling_blocks = 0;

  /// Returns whether it pushes in this step.
  [[nodiscard]] bool has_rows() const { return !is_persisted && !is_trigger; }
};

/// [N s] Friction impulse of a point on b, world axes.
template <Scalar S>
[[nodiscard]] Vec3<S> friction_impulse(const CachedManifold<S>& manifold,
                                       const CachedPoint<S>& point) {
  Vec3<S> t1, t2;
  tangent_basis<S>(manifold.normal, t1, t2);
  return point.impulse[1] * t1 + point.impulse[2] * t2;
}

/// Two generations of manifolds, sorted by pair. A new point inherits the impulses of the old point
/// with the same pair, key and feature. Features may change names while nothing moves. Corners of
/// equal boxes coincide. Either box may name them. Then the old point in the same place is
/// taken.
template <Scalar S>
class ContactCache {
 public:
  /// Positions of a pair's shapes when their manifolds are added.
  struct PairFrame {
    /// [1] Axes of shape a in the world.
    Mat3<S> R_WS = identity<Mat3<S>>();
    /// [m] From a's centre of mass to the origin of its shape, world axes.
    Vec3<S> p_as = zero<Vec3<S>>();
    /// [m] From a's centre of mass to b's, world axes.
    Vec3<S> p_ab = zero<Vec3<S>>();
    /// [m] a's centre of mass in the world.
    Vec3<S> center_a = zero<Vec3<S>>();
    /// [-] True if one of the shapes is a trigger.
    bool is_trigger = false;
  };

  /// Starts a new generation, for a step of `dt` [s].
  void begin_step(S dt) {
    half_ = S(0.5) * (dt / last_step_);
    last_step_ = dt;
    manifolds_.swap(old_manifolds_);
    points_.swap(old_points_);
    manifolds_.clear();
    points_.clear();
    cursor_ = 0;
    is_repeated_ = false;
  }

  /// Repeats the present generation for a step without changes.
  void repeat() { is_repeated_ = true; }

  /// Adds the manifolds of one pair. Pairs come in ascending order.
  void add(ShapePair shapes, std::span<const ContactManifold<S>> found, const PairFrame& frame) {
    for (const ContactManifold<S>& m : found) {
      CachedManifold<S>& cached = manifolds_.emplace_back();
      cached.shapes = shapes;
      cached.key = m.key;
      cached.normal = frame.R_WS * m.normal;
      cached.center_a = frame.center_a;
      cached.first = static_cast<std::uint32_t>(points_.size());
      cached.count = static_cast<std::uint32_t>(m.size);
      cached.is_trigger = frame.is_trigger;
      const CachedManifold<S>* old = find_old(shapes, m.key);
      const Vec3<S> p_ab = frame.p_ab + frame.R_WS * m.shift;
      for (std::size_t i = 0; i < m.size; ++i) {
        CachedPoint<S>& point = points_.emplace_back();
        point.arm_a = frame.p_as + frame.R_WS * m.points[i].position;
        point.arm_b = point.arm_a - p_ab;
        point.gap = m.points[i].gap;
        point.feature = m.points[i].feature;
      }
      if (old != nullptr) {
        inherit(*old, cached);
        cached.rolling_impulse = old->rolling_impulse;
      }
    }
  }

  /// Persists, unchanged, the manifolds of all pairs before `end` that `keeps(shapes)` accepts.
  /// These pairs are in contact but not collided in this step.
  template <typename Keeps>
  void persist_before(ShapePair end, Keeps&& keeps) {
    for (; cursor_ < old_manifolds_.size() && old_manifolds_[cursor_].shapes < end; ++cursor_) {
      const CachedManifold<S>& old = old_manifolds_[cursor_];
      if (!keeps(old.shapes)) continue;
      manifolds_.push_back(old);
      manifolds_.back().first = static_cast<std::uint32_t>(points_.size());
      manifolds_.back().is_persisted = true;
      points_.append(old_points_.begin() + old.first, old_points_.begin() + old.first + old.count);
    }
  }

  /// Sets the offsets of a point to half of the change of its arms in the last step.
  void find_mid_offsets(CachedPoint<S>& point) const {
    if (point.last == no_index) return;
    const CachedPoint<S>& last = old_points_[point.last];
    point.mid_offset_a = mid_offset(point.arm_a, last.arm_a);
    point.mid_offset_b = mid_offset(point.arm_b, last.arm_b);
  }

  /// Removes the contacts of a shape. The next shape with its tag then inherits nothing.
  void forget(std::uint32_t tag) {
    forget(tag, manifolds_, points_);
    forget(tag, old_manifolds_, old_points_);
  }

  [[nodiscard]] DynamicArray<CachedManifold<S>>& manifolds() { return manifolds_; }
  [[nodiscard]] const DynamicArray<CachedManifold<S>>& manifolds() const { return manifolds_; }
  [[nodiscard]] DynamicArray<CachedPoint<S>>& points() { return points_; }
  [[nodiscard]] const DynamicArray<CachedPoint<S>>& points() const { return points_; }

  /// [s] Step length of the present generation.
  [[nodiscard]] S& last_step() { return last_step_; }
  [[nodiscard]] const S& last_step() const { return last_step_; }

  /// The generation of the step before.
  [[nodiscard]] const DynamicArray<CachedManifold<S>>& last_manifolds() const {
    return is_repeated_ ? manifolds_ : old_manifolds_;
  }
  [[nodiscard]] const DynamicArray<CachedPoint<S>>& last_points() const {
    return is_repeated_ ? points_ : old_points_;
  }

 private:
  [[nodiscard]] const CachedManifold<S>* find_old(ShapePair shapes, std::uint32_t key) {
    while (cursor_ < old_manifolds_.size() && old_manifolds_[cursor_].shapes < shapes) ++cursor_;
    for (std::size_t i = cursor_; i < old_manifolds_.size() && old_manifolds_[i].shapes == shapes;
         ++i) {
      if (old_manifolds_[i].key == key) return &old_manifolds_[i];
    }
    return nullptr;
  }

  /// Persists friction as a vector. The tangents of two nearly equal normals may be opposite.
  class TangentTurn {
   public:
    TangentTurn(const Vec3<S>& from, const Vec3<S>& to) {
      // Faces at rest keep their friction to the last bit.
      if (from == to) return;
      Vec3<S> t1, t2, u1, u2;
      tangent_basis<S>(from, t1, t2);
      tangent_basis<S>(to, u1, u2);
      t1_ = {t1.dot(u1), t1.dot(u2)};
      t2_ = {t2.dot(u1), t2.dot(u2)};
    }
    [[nodiscard]] std::array<S, 3> operator()(const CachedPoint<S>& old) const {
      const Vec2<S> friction = (old.impulse[1] - old.transient_impulse[1]) * t1_ +
                               (old.impulse[2] - old.transient_impulse[2]) * t2_;
      return {old.impulse[0] - old.transient_impulse[0], friction.x(), friction.y()};
    }

   private:
    Vec2<S> t1_ = unit_x<Vec2<S>>();  // The old tangents along the new ones.
    Vec2<S> t2_ = unit_y<Vec2<S>>();
  };

  /// Passes the impulses of old points on to the points of a manifold. It matches by feature first,
  /// then the remaining ones by place.
  void inherit(const CachedManifold<S>& old, const CachedManifold<S>& young) {
    const TangentTurn turn(old.normal, young.normal);
    std::array<bool, ContactManifold<S>::capacity> is_taken{};
    std::uint32_t fresh = young.count;
    const auto match = [&](const auto& is_same) {
      for (std::uint32_t i = 0; i < young.count; ++i) {
        CachedPoint<S>& point = points_[young.first + i];
        // Points mostly keep their order. The old point of the same number is tried first.
        std::uint32_t k = i < old.count ? i : 0;
        for (std::uint32_t asked = 0; asked < old.count && point.is_fresh; ++asked) {
          const CachedPoint<S>& other = old_points_[old.first + k];
          if (!is_taken[k] && !other.took_impact && is_same(point, other)) {
            is_taken[k] = true;
            point.is_fresh = false;
            point.impulse = turn(other);
            point.position_excess = other.position_excess;
            point.last = old.first + k;
            --fresh;
          }
          k = k + 1 < old.count ? k + 1 : 0;
        }
      }
    };
    match([](const CachedPoint<S>& a, const CachedPoint<S>& b) { return a.feature == b.feature; });
    if (fresh == 0) return;
    S extent2 = S(0);
    for (std::uint32_t k = 0; k < old.count; ++k) {
      extent2 = std::max(
          extent2, (old_points_[old.first + k].arm_a - old_points_[old.first].arm_a).squaredNorm());
    }
    match([&](const CachedPoint<S>& a, const CachedPoint<S>& b) {
      return (a.arm_a - b.arm_a).squaredNorm() <= S(chosen::same_point_distance2) * extent2;
    });
  }

  /// Half of the change of an arm if it goes on as in the last step.
  [[nodiscard]] Vec3<S> mid_offset(const Vec3<S>& arm, const Vec3<S>& last) const {
    const Vec3<S> offset = half_ * (arm - last);
    // No rotation moves an arm by more than its length, whatever the lengths of the steps.
    return offset.squaredNorm() <= arm.squaredNorm() ? offset : zero<Vec3<S>>();
  }

  static void forget(std::uint32_t tag, DynamicArray<CachedManifold<S>>& manifolds,
                     DynamicArray<CachedPoint<S>>& points) {
    std::size_t kept = 0;
    std::uint32_t end = 0;
    for (CachedManifold<S> m : manifolds) {
      if (m.shapes.a == tag || m.shapes.b == tag) continue;
      std::copy_n(points.begin() + m.first, m.count, points.begin() + end);
      m.first = end;
      end += m.count;
      manifolds[kept++] = m;
    }
    manifolds.resize(kept);
    points.resize(end);
  }

  DynamicArray<CachedManifold<S>> manifolds_, old_manifolds_;
  DynamicArray<CachedPoint<S>> points_, old_points_;
  std::size_t cursor_ = 0;
  bool is_repeated_ = false;
  S last_step_ = S(1);
  S half_ = S(0.5);  // Half of this step as a multiple of the last one.
};

}  // namespace bristle::inline BRISTLE_ABI::detail
