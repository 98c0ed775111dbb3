/// @file
/// Contacts of this step with the impulses of the last one: persistence of manifolds.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/broadphase.hpp>
#include <bristle/geometry/contact_manifold.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/transform.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace bristle {

/// One point of contact between two bodies.
template <Scalar S>
struct CachedPoint {
  /// [m] From each centre of mass to the point, world axes.
  Vec3<S> arm_a = Vec3<S>::Zero();
  Vec3<S> arm_b = Vec3<S>::Zero();
  /// [m] Distance of the surfaces; negative where they overlap.
  S gap = S(0);
  /// [-] Features that meet here; see `ContactPoint::feature`.
  std::uint32_t feature = 0;
  /// [N s] Impulse along the normal, and along the two tangents of `tangent_basis`.
  std::array<S, 3> impulse{};
  /// Whether no contact of the last step tells what to expect of this one.
  bool is_fresh = true;
  /// Whether the impulse stopped an approach, and says nothing about the step to come.
  bool took_impact = false;
};

/// Points with one normal between two shapes.
template <Scalar S>
struct CachedManifold {
  ShapePair shapes{};
  /// [-] Tells manifolds of one pair apart; see `ContactManifold::key`.
  std::uint32_t key = 0;
  /// [1] From a to b, world axes.
  Vec3<S> normal = Vec3<S>::UnitZ();
  /// [-] Its points are [first, first + count).
  std::uint32_t first = 0;
  std::uint32_t count = 0;
};

/// Two generations of manifolds, sorted by pair. The older one gives its impulses to points of the
/// younger one with the same pair, key and feature. Where features change names while nothing moves
/// (corners of equal boxes coincide, and either box may name them) the point in the same place is
/// taken.
template <Scalar S>
class ContactCache {
 public:
  /// Starts a new generation.
  void begin_step() {
    manifolds_.swap(old_manifolds_);
    points_.swap(old_points_);
    manifolds_.clear();
    points_.clear();
    cursor_ = 0;
  }

  /// Adds the manifolds of one pair; pairs come in ascending order.
  ///
  /// @param X_WS  Pose of shape a: [1] its axes in the world, [m] its origin from a's centre of
  /// mass.
  /// @param p_ab  [m] From a's centre of mass to b's, world axes.
  void add(ShapePair shapes, const ContactManifolds<S>& found, const Mat3<S>& R_WS,
           const Vec3<S>& p_as, const Vec3<S>& p_ab) {
    for (const ContactManifold<S>& m : found) {
      CachedManifold<S> cached;
      cached.shapes = shapes;
      cached.key = m.key;
      cached.normal = R_WS * m.normal;
      cached.first = static_cast<std::uint32_t>(points_.size());
      cached.count = static_cast<std::uint32_t>(m.size);
      const CachedManifold<S>* old = find_old(shapes, m.key);
      for (std::size_t i = 0; i < m.size; ++i) {
        CachedPoint<S>& point = points_.emplace_back();
        point.arm_a = p_as + R_WS.lazyProduct(m.points[i].position);
        point.arm_b = point.arm_a - p_ab;
        point.gap = m.points[i].gap;
        point.feature = m.points[i].feature;
      }
      if (old != nullptr) inherit(*old, cached);
      manifolds_.push_back(cached);
    }
  }

  /// Forgets the contacts of a shape, so that nothing is inherited by the next one with its tag.
  void forget(std::uint32_t tag) {
    for (CachedManifold<S>& m : manifolds_) {
      if (m.shapes.a != tag && m.shapes.b != tag) continue;
      for (std::uint32_t i = m.first; i < m.first + m.count; ++i) points_[i].took_impact = true;
    }
  }

  [[nodiscard]] std::vector<CachedManifold<S>>& manifolds() { return manifolds_; }
  [[nodiscard]] const std::vector<CachedManifold<S>>& manifolds() const { return manifolds_; }
  [[nodiscard]] std::vector<CachedPoint<S>>& points() { return points_; }
  [[nodiscard]] const std::vector<CachedPoint<S>>& points() const { return points_; }

 private:
  [[nodiscard]] const CachedManifold<S>* find_old(ShapePair shapes, std::uint32_t key) {
    while (cursor_ < old_manifolds_.size() && old_manifolds_[cursor_].shapes < shapes) ++cursor_;
    for (std::size_t i = cursor_; i < old_manifolds_.size() && old_manifolds_[i].shapes == shapes;
         ++i) {
      if (old_manifolds_[i].key == key) return &old_manifolds_[i];
    }
    return nullptr;
  }

  /// Carries friction over as a vector: the tangents of two nearly equal normals may be opposite.
  class TangentTurn {
   public:
    TangentTurn(const Vec3<S>& from, const Vec3<S>& to) {
      Vec3<S> t1, t2, u1, u2;
      tangent_basis<S>(from, t1, t2);
      tangent_basis<S>(to, u1, u2);
      t1_ = {t1.dot(u1), t1.dot(u2)};
      t2_ = {t2.dot(u1), t2.dot(u2)};
    }
    [[nodiscard]] std::array<S, 3> operator()(const std::array<S, 3>& impulse) const {
      const Vec2<S> friction = impulse[1] * t1_ + impulse[2] * t2_;
      return {impulse[0], friction.x(), friction.y()};
    }

   private:
    Vec2<S> t1_;  // The old tangents along the new ones.
    Vec2<S> t2_;
  };

  /// Gives the points of a manifold the impulses of their predecessors: first by feature, then what
  /// is left by place.
  void inherit(const CachedManifold<S>& old, const CachedManifold<S>& young) {
    const TangentTurn turn(old.normal, young.normal);
    std::array<bool, ContactManifold<S>::capacity> is_taken{};
    std::uint32_t fresh = young.count;
    const auto match = [&](const auto& is_same) {
      for (std::uint32_t i = 0; i < young.count; ++i) {
        CachedPoint<S>& point = points_[young.first + i];
        // Points mostly keep their order: what stood in this one's place is asked first.
        std::uint32_t k = i < old.count ? i : 0;
        for (std::uint32_t asked = 0; asked < old.count && point.is_fresh; ++asked) {
          const CachedPoint<S>& other = old_points_[old.first + k];
          if (!is_taken[k] && !other.took_impact && is_same(point, other)) {
            is_taken[k] = true;
            point.is_fresh = false;
            point.impulse = turn(other.impulse);
            --fresh;
          }
          k = k + 1 < old.count ? k + 1 : 0;
        }
      }
    };
    match([](const CachedPoint<S>& a, const CachedPoint<S>& b) { return a.feature == b.feature; });
    if (fresh == 0) return;
    // A hundredth of the patch is much more than resting points move and much less than they are
    // apart.
    S extent2 = S(0);
    for (std::uint32_t k = 0; k < old.count; ++k) {
      extent2 = std::max(
          extent2, (old_points_[old.first + k].arm_a - old_points_[old.first].arm_a).squaredNorm());
    }
    match([&](const CachedPoint<S>& a, const CachedPoint<S>& b) {
      return (a.arm_a - b.arm_a).squaredNorm() <= S(1e-4) * extent2;
    });
  }

  std::vector<CachedManifold<S>> manifolds_, old_manifolds_;
  std::vector<CachedPoint<S>> points_, old_points_;
  std::size_t cursor_ = 0;
};

}  // namespace bristle
