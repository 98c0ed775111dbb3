/// @file
/// Contact of two boxes by the separating axis test.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contact_clip.hpp>
#include <bristle/geometry/contact_normal.hpp>
#include <bristle/geometry/convex_view.hpp>
#include <bristle/geometry/shapes.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <span>

namespace bristle {

/// Appends the manifold of two boxes, B standing at X_AB in A, if they overlap or come within
/// `margin` [m].
///
/// The normal is that of least overlap among the 15 axes (3 + 3 face normals, 9 pairs of edges;
/// Gottschalk, Lin, Manocha 1996). Where boxes are apart it is the axis that separates them most,
/// and the gaps are distances along it; where what is nearest along it does not face the other box,
/// as when boxes pass cornerwise, it is the direction of their distance. Faces are preferred to
/// edges, and faces of A to those of B, until the other is better by a twentieth: so resting boxes
/// keep their normal.
template <Scalar S>
void collide_shapes(const Box<S>& a, const Box<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// Best separating axis so far: the one with the largest distance between the shapes along it.
template <Scalar S>
struct SeparatingAxis {
  /// [m] Distance along the axis; negative where the shapes overlap along every axis.
  S gap = -infinity<S>;
  /// [1] Unit, from A to B.
  Vec3<S> normal = Vec3<S>::UnitZ();

  /// Takes another axis if it is clearly better.
  /// @param least_gain  [m] What counts as no difference.
  void offer(S other_gap, const Vec3<S>& other_normal, S least_gain) {
    using std::abs;
    if (gap == -infinity<S> || other_gap > gap + S(0.05) * abs(gap) + least_gain) {
      gap = other_gap;
      normal = other_normal;
    }
  }
  /// Takes another axis if it is better at all.
  void offer(S other_gap, const Vec3<S>& other_normal) {
    if (other_gap > gap) {
      gap = other_gap;
      normal = other_normal;
    }
  }
};

}  // namespace detail

template <Scalar S>
void collide_shapes(const Box<S>& a, const Box<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out) {
  using std::abs;
  using std::sqrt;
  const Mat3<S> R = X_AB.rotation_matrix();
  const Mat3<S> absolute = R.cwiseAbs();
  const Vec3<S>& p = X_AB.translation;
  const Vec3<S> p_B = R.transpose() * p;
  const Vec3<S> gaps_a = p.cwiseAbs() - a.half_extents - absolute * b.half_extents;
  const Vec3<S> gaps_b = p_B.cwiseAbs() - b.half_extents - absolute.transpose() * a.half_extents;
  if (gaps_a.maxCoeff() > margin || gaps_b.maxCoeff() > margin) return;

  detail::SeparatingAxis<S> face_a;
  detail::SeparatingAxis<S> face_b;
  detail::SeparatingAxis<S> edges;
  for (int i = 0; i < 3; ++i) {
    face_a.offer(gaps_a[i], (p[i] < S(0) ? S(-1) : S(1)) * Vec3<S>::Unit(i));
    face_b.offer(gaps_b[i], (p_B[i] < S(0) ? S(-1) : S(1)) * R.col(i));
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Vec3<S> cross = Vec3<S>::Unit(i).cross(R.col(j));
      const S sine = cross.norm();
      // Parallel edges span a face, which has been looked at.
      if (sine <= Tolerance<S>::equal()) continue;
      const Vec3<S> axis = cross / sine;
      const S reach = a.half_extents.dot(axis.cwiseAbs()) +
                      b.half_extents.dot((R.transpose() * axis).cwiseAbs());
      const S distance = p.dot(axis);
      edges.offer(abs(distance) - reach, distance < S(0) ? Vec3<S>(-axis) : axis);
    }
  }
  if (edges.gap > margin) return;

  const S least_gain =
      Tolerance<S>::equal() * (a.half_extents.maxCoeff() + b.half_extents.maxCoeff());
  detail::SeparatingAxis<S> best = face_a;
  best.offer(face_b.gap, face_b.normal, least_gain);
  best.offer(edges.gap, edges.normal, least_gain);

  if (best.gap <= S(0)) {
    build_manifold(a, b, X_AB, best.normal, margin, out);
    return;
  }
  const auto features = detail::feature_pair(a, b, X_AB, best.normal);
  const auto manifold = detail::clip_features(features.a, features.b, best.normal, margin);
  const auto points = std::span(manifold.points).first(manifold.size);
  if (std::any_of(points.begin(), points.end(), [&](const ContactPoint<S>& point) {
        return point.gap <= best.gap + least_gain;
      })) {
    out.push_back(manifold);
    return;
  }
  // What separates the boxes least is beside what faces: a corner passes a corner or an edge. No
  // axis of the fifteen is that of their distance.
  using P = Precise<S>;
  const Box<P> precise_a{a.half_extents.template cast<P>()};
  const Box<P> precise_b{b.half_extents.template cast<P>()};
  const auto found = contact_normal(convex_view(precise_a), convex_view(precise_b),
                                    X_AB.template cast<P>(), P(margin));
  if (found.nearness != Nearness::near) return;
  build_manifold(a, b, X_AB, Vec3<S>(found.normal.template cast<S>().normalized()), margin, out);
}

}  // namespace bristle
