/// @file
/// Distance of a convex solid from any solid, and the way it can go along a line before it touches.
///
/// Both rest on the distance of convex cores (gjk.hpp). A cast goes by conservative advancement
/// (Mirtich 1996): a solid at the distance g along the normal n, which moves by d, cannot touch
/// before the fraction g / -(n.d) of the way. It goes there and measures again. Of solids that are
/// convex the direction is that of a separating plane, so that one that moves away along it never
/// touches at all.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_normal.hpp>
#include <bristle/geometry/contacts/gjk.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/meshes/mesh_surface.hpp>
#include <bristle/geometry/shapes/convex_view.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <cstdint>
#include <variant>

namespace bristle::inline BRISTLE_ABI::detail {

/// Nearest point of a target to a query, in the frame of the target.
template <Scalar P>
struct SolidGap {
  /// [m] Distance of the two. 0 where they overlap or touch. Its value before a search bounds the
  /// search: nothing that is as far changes it.
  P distance = infinity<P>;
  /// [1] Unit normal out of the target, towards the query. Zero where they overlap.
  Vec3<P> normal = zero<Vec3<P>>();
  /// [m] The nearest point of the target, or one of several. A point of the query where they
  /// overlap.
  Vec3<P> point = zero<Vec3<P>>();
};

/// First touch of a query that moves along a line, in the frame of the target.
template <Scalar P>
struct SolidTouch {
  /// [1] Part of the way before the touch. Its value before a search bounds the search.
  P fraction = infinity<P>;
  /// [1] Unit normal out of the target. Against the motion where the solids overlap at its start.
  Vec3<P> normal = zero<Vec3<P>>();
  /// [m] Point of the touch, or one of several.
  Vec3<P> point = zero<Vec3<P>>();
};

/// Lowers `nearest` to the gap between a target and a query at X_TQ, if that is less.
///
/// The error is that of GJK: round-off for cores that are points, segments, boxes or hulls, and
/// about 1e-8 of the solids' size for others.
template <Scalar P>
void find_gap(const HalfSpace<P>& target, const ConvexView<P>& query, const Transform<P>& X_TQ,
              SolidGap<P>& nearest);
template <Scalar P>
void find_gap(const ConvexView<P>& target, const ConvexView<P>& query, const Transform<P>& X_TQ,
              SolidGap<P>& nearest);
template <Scalar P, typename Tree>
void find_gap(const MeshSurface<P, Tree>& target, const ConvexView<P>& query,
              const Transform<P>& X_TQ, SolidGap<P>& nearest);

/// Lowers `first` to the first touch of a target by a query that starts at X_TQ and moves by `way`
/// [m], if that is sooner. The query stops short of the target by at most a part `near` [1] of
/// the smaller of their sizes. Solids that are as near or overlap as little at the start touch
/// where they approach, and do not where they move along each other or apart.
/// @param near  [1] At least `Tolerance::equal`, which is what distances are good for.
template <Scalar P>
void find_touch(const HalfSpace<P>& target, const ConvexView<P>& query, const Transform<P>& X_TQ,
                const Vec3<P>& way, P near, SolidTouch<P>& first);
template <Scalar P>
void find_touch(const ConvexView<P>& target, const ConvexView<P>& query, const Transform<P>& X_TQ,
                const Vec3<P>& way, P near, SolidTouch<P>& first);
template <Scalar P, typename Tree>
void find_touch(const MeshSurface<P, Tree>& target, const ConvexView<P>& query,
                const Transform<P>& X_TQ, const Vec3<P>& way, P near, SolidTouch<P>& first);

// Implementation ----------------------------------------------------------------------------------

/// Distance of two solids and the direction of it. Zero where they overlap or touch, and `far` [m]
/// or more where they are farther apart than that.
template <Scalar P>
[[nodiscard]] GjkResult<P> convex_distance(const ConvexView<P>& target, const ConvexView<P>& query,
                                           const Transform<P>& X_TQ, P far) {
  const PlacedConvex<P> a{&target, identity<Mat3<P>>(), zero<Vec3<P>>(), P(1)};
  const PlacedConvex<P> b{&query, X_TQ.rotation_matrix(), X_TQ.translation, P(1)};
  const Vec3<P> between = X_TQ * query.center - target.center;
  const P rounding = target.rounding + query.rounding;
  // A search that ends early knows a distance that is surely beyond the bound, whatever is rounded.
  const P enough = (far + rounding) * (P(1) + Tolerance<P>::equal());
  GjkResult<P> result =
      GjkDistance{}(a, b, between == zero<Vec3<P>>() ? unit_x<Vec3<P>>() : between, enough);
  result.distance -= rounding;
  result.is_apart = result.is_apart && result.distance > P(0);
  if (!result.is_apart) result.distance = P(0);
  return result;
}

/// [m] Width of the gap between two solids along a direction n [1] out of the target. Where it is
/// more than 0, a plane across n parts them.
template <Scalar P>
[[nodiscard]] P gap_along(const ConvexView<P>& target, const ConvexView<P>& query,
                          const Transform<P>& X_TQ, const Vec3<P>& n) {
  const Vec3<P> back = X_TQ.rotation.conjugate() * Vec3<P>(-n);
  return n.dot(X_TQ * query.support(back)) - n.dot(target.support(n)) - target.rounding -
         query.rounding;
}

/// [m] The point of a solid that is nearest to a point, which may be the point itself.
template <Scalar P>
[[nodiscard]] Vec3<P> project(const Vec3<P>& point, const ConvexView<P>& solid) {
  const Sphere<P> none{P(0)};
  Transform<P> X;
  X.translation = point;
  const GjkResult<P> found = convex_distance(solid, convex_view(none), X, infinity<P>);
  return found.is_apart ? Vec3<P>(point - found.distance * found.normal) : point;
}

/// A nearest point of the target, where distance and normal are known.
///
/// An extreme point of the target need not be under the query, nor the other way round. Projecting
/// to one solid and the other in turn leads to a pair of nearest points (Cheney and Goldstein
/// 1959), for faces over each other and corners in one or two rounds.
template <Scalar P>
[[nodiscard]] Vec3<P> point_of_gap(const ConvexView<P>& target, const ConvexView<P>& query,
                                   const Transform<P>& X_TQ, const Vec3<P>& normal, P distance) {
  const P enough = distance + Tolerance<P>::equal() * std::min(target.reach, query.reach);
  // A ball has one point that is nearest.
  if (std::holds_alternative<const Sphere<P>*>(query.shape)) {
    return X_TQ.translation - (distance + query.rounding) * normal;
  }
  const Transform<P> X_QT = X_TQ.inverse();
  Vec3<P> point = support_point(target, normal);
  for (int i = 0; i < chosen::gap_projections; ++i) {
    const Vec3<P> opposite = X_TQ * project(Vec3<P>(X_QT * point), query);
    if ((opposite - point).norm() <= enough) break;
    point = project(opposite, target);
  }
  return point;
}

/// The lowest point of a query over a half-space, and its height.
template <Scalar P>
[[nodiscard]] SolidGap<P> height_over(const HalfSpace<P>& target, const ConvexView<P>& query,
                                      const Transform<P>& X_TQ) {
  const Vec3<P> down = X_TQ.rotation.conjugate() * Vec3<P>(-target.normal);
  const Vec3<P> lowest = X_TQ * support_point(query, down);
  return {target.normal.dot(lowest) - target.offset, target.normal, lowest};
}

template <Scalar P>
void find_gap(const HalfSpace<P>& target, const ConvexView<P>& query, const Transform<P>& X_TQ,
              SolidGap<P>& nearest) {
  const SolidGap<P> height = height_over(target, query, X_TQ);
  if (!(height.distance < nearest.distance)) return;
  if (height.distance > P(0)) {
    nearest = {height.distance, target.normal, height.point - height.distance * target.normal};
  } else {
    nearest = {P(0), zero<Vec3<P>>(), height.point};
  }
}

template <Scalar P>
void find_gap(const ConvexView<P>& target, const ConvexView<P>& query, const Transform<P>& X_TQ,
              SolidGap<P>& nearest) {
  const GjkResult<P> found = convex_distance(target, query, X_TQ, nearest.distance);
  if (!(found.distance < nearest.distance)) return;
  if (found.is_apart && gap_along(target, query, X_TQ, found.normal) > P(0)) {
    nearest = {found.distance, found.normal,
               point_of_gap(target, query, X_TQ, found.normal, found.distance)};
  } else {
    nearest = {P(0), zero<Vec3<P>>(), X_TQ * query.center};
  }
}

/// Returns whether the middle of a query is in a mesh.
template <Scalar P, typename Tree>
[[nodiscard]] bool holds_center(const MeshSurface<P, Tree>& target, const ConvexView<P>& query,
                                const Transform<P>& X_TQ) {
  const Vec3<P> center = X_TQ * query.center;
  return target.bounds().contains(center) && target.contains(center);
}

template <Scalar P, typename Tree>
void find_gap(const MeshSurface<P, Tree>& target, const ConvexView<P>& query,
              const Transform<P>& X_TQ, SolidGap<P>& nearest) {
  // A query that meets no plate is inside or outside as a whole.
  if (nearest.distance > P(0) && holds_center(target, query, X_TQ)) {
    nearest = {P(0), zero<Vec3<P>>(), X_TQ * query.center};
  }
  const Aabb<P> box = bounds_at(query, X_TQ);
  target.find(
      [&](const Aabb<P>& other) {
        return other.distance2_to(box) <= nearest.distance * nearest.distance;
      },
      [&](std::uint32_t i) {
        const Plate<P> plate = target.plate(i);
        find_gap(convex_view(plate), query, X_TQ, nearest);
        return nearest.distance > P(0);
      });
}

/// The touch of a query that overlaps a target before it moves.
template <Scalar P>
[[nodiscard]] SolidTouch<P> touch_at_start(const ConvexView<P>& query, const Transform<P>& X_TQ,
                                           const Vec3<P>& way) {
  return {P(0), -way.stableNormalized(), X_TQ * query.center};
}

/// Returns whether a motion ends a gap [m] within the part of the way that is left. From a touch it
/// must come nearer by more than its direction is rounded.
/// @param closing  [m] Approach on the whole way.
/// @param least    [m] Approach that counts as none where the gap is 0.
template <Scalar P>
[[nodiscard]] bool closes(P gap, P closing, P least, P left) {
  return closing > (gap > P(0) ? P(0) : least) && gap < left * closing;
}

template <Scalar P>
void find_touch(const HalfSpace<P>& target, const ConvexView<P>& query, const Transform<P>& X_TQ,
                const Vec3<P>& way, P near, SolidTouch<P>& first) {
  const SolidGap<P> height = height_over(target, query, X_TQ);
  if (height.distance < -near * query.reach) {
    if (first.fraction > P(0)) first = touch_at_start(query, X_TQ, way);
    return;
  }
  const P gap = height.distance > near * query.reach ? height.distance : P(0);
  const P closing = -target.normal.dot(way);
  if (!closes(gap, closing, P(near * way.norm()), first.fraction)) return;
  first.fraction = gap / closing;
  first.normal = target.normal;
  first.point = height.point + first.fraction * way;
}

template <Scalar P>
void find_touch(const ConvexView<P>& target, const ConvexView<P>& query, const Transform<P>& X_TQ,
                const Vec3<P>& way, P near, SolidTouch<P>& first) {
  // Each measurement takes away all of the way that it proves free. Faces and corners end after one
  // or two of them; round solids leave a part of the way that shrinks with its square. The bound is
  // there for numbers that go on to creep.
  const P touching = near * std::min(target.reach, query.reach);
  const P least = near * way.norm();
  Transform<P> X = X_TQ;
  P fraction = P(0);
  Vec3<P> normal = zero<Vec3<P>>();
  for (int i = 0; i < chosen::sweep_distances; ++i) {
    const GjkResult<P> found = convex_distance(target, query, X, infinity<P>);
    // The direction of solids that all but touch may be any. Only a plane that parts them counts.
    const P gap = found.is_apart ? gap_along(target, query, X, found.normal) : P(0);
    if (!(gap > P(0))) break;
    const P closing = -found.normal.dot(way);
    const P left = first.fraction - fraction;
    if (!closes(gap > touching || i > 0 ? gap : P(0), closing, least, left)) return;
    normal = found.normal;
    if (gap <= touching) break;
    fraction += gap / closing;
    X.translation = X_TQ.translation + fraction * way;
  }
  if (normal == zero<Vec3<P>>()) {
    // They touch or overlap at the start. Which of the two tells the direction of least overlap.
    const ContactNormal<P> found = contact_normal<GjkDistance>(target, query, X_TQ, touching);
    if (found.nearness == Nearness::near && found.gap >= -touching) {
      normal = found.normal;
      if (!closes(P(0), P(-normal.dot(way)), least, first.fraction)) return;
    } else {
      if (first.fraction > P(0)) first = touch_at_start(query, X_TQ, way);
      return;
    }
  }
  first = {fraction, normal, point_of_gap(target, query, X, normal, P(0))};
}

template <Scalar P, typename Tree>
void find_touch(const MeshSurface<P, Tree>& target, const ConvexView<P>& query,
                const Transform<P>& X_TQ, const Vec3<P>& way, P near, SolidTouch<P>& first) {
  if (first.fraction > P(0) && holds_center(target, query, X_TQ)) {
    first = touch_at_start(query, X_TQ, way);
  }
  const Aabb<P> box = bounds_at(query, X_TQ);
  target.find(
      [&](const Aabb<P>& other) {
        return box.swept(Vec3<P>(std::min(first.fraction, P(1)) * way)).overlaps(other);
      },
      [&](std::uint32_t i) {
        const Plate<P> plate = target.plate(i);
        find_touch(convex_view(plate), query, X_TQ, way, near, first);
        return first.fraction > P(0);
      });
}

}  // namespace bristle::inline BRISTLE_ABI::detail
