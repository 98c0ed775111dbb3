/// @file
/// Impulses of manifolds whose points have moved along their bodies.
///
/// Edges that nearly coincide cross anywhere along each other. Such a point of contact jumps with
/// the last bits of the poses. An impulse that jumps with it turns bodies at rest, by up to ten
/// times as much in each step. The force and torque of a manifold are what its bodies need. How its
/// points share them is not.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/collision/contact_cache.hpp>
#include <bristle/dynamics/contacts/contact_constraint.hpp>
#include <bristle/dynamics/solver/solver_types.hpp>

#include <algorithm>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Changes the impulses that the contacts of an island start from, so that each manifold gives the
/// force and torque that it gave before its points moved. The changes are the smallest that do.
/// Points without load stay without. Loads do not become negative.
///
/// @param points  What each contact came from; see `ContactConstraint::point`.
/// @param dt      [s] Length of the last step.
template <Scalar S>
void keep_wrenches(const Island& island, Constraints<S>& constraints,
                   std::span<const CachedPoint<S>> points, std::span<const SolverBody<S>> bodies,
                   S dt);

// Implementation ----------------------------------------------------------------------------------

/// The loaded points of a manifold, in the plane of its tangents.
template <Scalar S>
class LoadedPoints {
 public:
  LoadedPoints(std::span<const std::uint32_t> manifold, Constraints<S>& constraints)
      : manifold_(manifold), constraints_(constraints) {
    for_each([&](const ContactConstraint<S>& c) {
      center_ += in_plane(c, c.arm_a);
      count_ += S(1);
    });
    center_ /= std::max(S(1), count_);
    for_each([&](const ContactConstraint<S>& c) {
      const Vec2<S> r = from_center(c);
      xx_ += r.x() * r.x();
      xy_ += r.x() * r.y();
      yy_ += r.y() * r.y();
    });
  }

  /// [N m s] Torques that impulses gain as their points move.
  struct Torques {
    /// By loads: the sum of load times shift.
    Vec2<S> tilt = zero<Vec2<S>>();
    /// By friction, about the normal.
    S twist = S(0);
  };
  template <typename Shift>
  [[nodiscard]] Torques gained(const Shift& shift) const {
    Torques sum;
    for_each([&](const ContactConstraint<S>& c) {
      const Vec2<S> moved = in_plane(c, shift(c));
      sum.tilt += c.impulse[0] * moved;
      sum.twist += moved.x() * c.impulse[2] - moved.y() * c.impulse[1];
    });
    return sum;
  }

  /// Takes torques out. Does nothing for points on a line, which tilt no body.
  void take_out(const Torques& torques) const {
    const S determinant = xx_ * yy_ - xy_ * xy_;
    const S spread = xx_ + yy_;
    if (!(determinant > Tolerance<S>::equal() * spread * spread)) return;
    const Vec2<S>& tilt = torques.tilt;
    const Vec2<S> gradient((yy_ * tilt.x() - xy_ * tilt.y()) / determinant,
                           (xx_ * tilt.y() - xy_ * tilt.x()) / determinant);
    const S spin = torques.twist / spread;
    for_each([&](ContactConstraint<S>& c) {
      const Vec2<S> r = from_center(c);
      c.impulse[0] = std::max(S(0), c.impulse[0] - gradient.dot(r));
      c.impulse[1] += spin * r.y();
      c.impulse[2] -= spin * r.x();
    });
  }

 private:
  [[nodiscard]] static Vec2<S> in_plane(const ContactConstraint<S>& c, const Vec3<S>& r) {
    return {c.axes[1].dot(r), c.axes[2].dot(r)};
  }
  [[nodiscard]] Vec2<S> from_center(const ContactConstraint<S>& c) const {
    return in_plane(c, c.arm_a) - center_;
  }
  template <typename Use>
  void for_each(const Use& use) const {
    for (const std::uint32_t i : manifold_) {
      if (constraints_.contacts[i].impulse[0] > S(0)) use(constraints_.contacts[i]);
    }
  }

  std::span<const std::uint32_t> manifold_;
  Constraints<S>& constraints_;
  Vec2<S> center_ = zero<Vec2<S>>();  // [m]
  S count_ = S(0);
  S xx_ = S(0);  // [m^2] Sums over the points.
  S xy_ = S(0);
  S yy_ = S(0);
};

template <Scalar S>
void keep_wrenches(const Island& island, Constraints<S>& constraints,
                   std::span<const CachedPoint<S>> points, std::span<const SolverBody<S>> bodies,
                   S dt) {
  for (std::size_t k = 0; k < island.contacts.size();) {
    const std::size_t begin = k;
    const ContactConstraint<S>& first = constraints.contacts[island.contacts[begin]];
    while (k < island.contacts.size() &&
           are_of_one_manifold(first, constraints.contacts[island.contacts[k]])) {
      ++k;
    }
    const LoadedPoints<S> loaded(std::span(island.contacts).subspan(begin, k - begin), constraints);
    // Arms also change as their bodies turn.
    const Vec3<S> turn_a = dt * bodies[first.body_a].start.angular;
    const Vec3<S> turn_b = dt * bodies[first.body_b].start.angular;
    const auto by_a = loaded.gained([&](const ContactConstraint<S>& c) -> Vec3<S> {
      return S(2) * points[c.point].mid_offset_a - turn_a.cross(c.arm_a);
    });
    const auto by_b = loaded.gained([&](const ContactConstraint<S>& c) -> Vec3<S> {
      return S(2) * points[c.point].mid_offset_b - turn_b.cross(c.arm_b);
    });
    // Where bodies slide, points that stay on one of them move along the other.
    loaded.take_out({by_a.tilt.squaredNorm() < by_b.tilt.squaredNorm() ? by_a.tilt : by_b.tilt,
                     by_a.twist * by_a.twist < by_b.twist * by_b.twist ? by_a.twist : by_b.twist});
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
