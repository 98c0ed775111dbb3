/// @file
/// The plane in which two shapes meet that are apart when a step begins.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_manifold.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <cstddef>
#include <limits>

namespace bristle::inline BRISTLE_ABI::detail {

/// [m] Smallest gap of a manifold.
template <Scalar S>
[[nodiscard]] S least_gap(const ContactManifold<S>& manifold) {
  S least = manifold.points[0].gap;
  for (std::size_t i = 1; i < manifold.size; ++i) {
    least = std::min(least, manifold.points[i].gap);
  }
  return least;
}

/// Moves the contact of two convex shapes that are apart to where they meet.
///
/// Any plane between two shapes keeps them apart: neither passes the other in a step. The plane
/// between the points that are nearest at the start stands across the way of whatever flies past,
/// and is not that in which shapes meet. So the shapes are moved along their way by the velocities
/// of the start. Where a plane between them at the end of it is one between them at the start, it
/// is taken, and nothing is in the way. Else they are advanced until they touch, or are nearest
/// (conservative advancement; Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems,
/// 1996). Each step of that gives a plane that is between them at the start, too, so their number
/// decides only how well the plane fits.
///
/// @param manifold  The only one of the pair, at the start.
/// @param way       [m] Motion of B relative to A by the velocities of the start, in the frame of
/// A.
/// @param free_way  [m] The same with what forces add. Shapes that it leaves apart need no other
///                  plane.
/// @param collide   collide(shift [m]) replaces `manifold` by that of the shapes with B displaced;
///                  false where there is not one.
/// @param round_off [m] Gaps that are as good as none.
template <Scalar S, typename Collide>
void advance_contact(ContactManifold<S>& manifold, const Vec3<S>& way, const Vec3<S>& free_way,
                     const S& round_off, Collide&& collide) {
  // [m] By how much B comes closer in the whole step.
  const auto approach = [&] { return S(-manifold.normal.dot(way)); };
  const auto set_shift = [&](const S& share) {
    manifold.shift = share * way;
    for (std::size_t i = 0; i < manifold.size; ++i) {
      manifold.points[i].gap += share * approach();
    }
  };
  S gap = least_gap(manifold);
  // Surfaces that rest, slide or part have their plane.
  if (gap < -round_off || approach() <= round_off) return;
  if (gap >= std::max(approach(), S(-manifold.normal.dot(free_way)))) return;
  const ContactManifold<S> start = manifold;
  if (collide(way) && least_gap(manifold) >= -round_off &&
      least_gap(manifold) + approach() >= -round_off) {
    set_shift(S(1));
    return;
  }
  manifold = start;
  // Each step halves the rest of a way that grazes, and ends one that hits a flat face.
  S share = S(0);
  S beyond = infinity<S>;  // A share at which the nearest place lies behind.
  for (int i = 0; i < chosen::impact_advancements; ++i) {
    if (gap <= round_off || gap >= (S(1) - share) * approach()) break;
    const ContactManifold<S> last = manifold;
    S next = share + gap / approach();
    if (next >= beyond) next = S(0.5) * (share + beyond);
    if (!collide(Vec3<S>(next * way))) {
      manifold = last;
      break;
    }
    if (least_gap(manifold) + next * approach() < -round_off) {
      // This plane is not between the shapes at the start.
      manifold = last;
      beyond = next;
      continue;
    }
    share = next;
    gap = least_gap(manifold);
  }
  // In the same plane the points of the start are as good, and closer to where slow bodies end up.
  if (manifold.normal.dot(start.normal) >= S(1) - Tolerance<S>::equal()) {
    manifold = start;
  } else {
    set_shift(share);
  }
}

/// Adds the contact of the ball within one of the two shapes. Impulses far off its centre turn a
/// fast body by radians within a step: its middle would go on, through what only keeps a corner
/// out. The ball stays where it is however the body turns.
/// @param center  [m] Of the ball, in the frame of A, where the points lie as they do.
/// @param is_b    True for a ball in B.
template <Scalar S>
void add_inner_ball(ContactManifold<S>& manifold, const Vec3<S>& center, const S& radius,
                    bool is_b) {
  const Vec3<S>& n = manifold.normal;
  const S shift = n.dot(manifold.shift);
  // Height along the normal of the surface that the ball meets: its outermost point.
  S surface = is_b ? -infinity<S> : infinity<S>;
  for (std::size_t i = 0; i < manifold.size; ++i) {
    const S middle = n.dot(manifold.points[i].position);
    const S half_gap = S(0.5) * (manifold.points[i].gap + shift);
    surface =
        is_b ? std::max(surface, S(middle - half_gap)) : std::min(surface, S(middle + half_gap));
  }
  const S side = is_b ? S(1) : S(-1);
  const S gap = side * (n.dot(center) - surface) - radius;
  ContactPoint<S> point;
  point.position = center - (side * (radius + S(0.5) * gap)) * n;
  point.gap = gap - shift;
  point.feature = is_b ? 0xffffffffu : 0xfffffffeu;
  manifold.add(point);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
