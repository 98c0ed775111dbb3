/// @file
/// Contact of two boxes by the separating axis test.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/box_face_clip.hpp>
#include <bristle/geometry/contacts/contact_clip.hpp>
#include <bristle/geometry/contacts/contact_normal.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/shapes/convex_view.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Appends the manifold of two boxes if their gap is at most `margin` [m]. X_AB is the pose of B in
/// A.
///
/// The normal is the axis of least overlap (Gottschalk, Lin, Manocha 1996). There are 15 axes: 3 +
/// 3 face normals and 9 pairs of edges. Boxes that are apart get the axis of largest separation.
/// Gaps are along it. Boxes that pass each other cornerwise, without facing along it, have no
/// contact.
///
/// Faces are preferred to edges, and large faces to small ones. Of equal faces, A's is preferred.
/// Another axis must be better by a twentieth. So resting boxes keep their normal.
template <Scalar S>
void collide_shapes(const Box<S>& a, const Box<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out);

// Implementation ----------------------------------------------------------------------------------

/// [1] Places on a face that are nearer to each other or to its rim than this, by the size of the
/// boxes, count as one. Boxes that slide in a heap jitter by what the solver leaves of their
/// velocities, and their corners must not come and go with that. Gaps are not rounded.
template <Scalar S>
[[nodiscard]] S beside_tolerance() {
  return std::max(Tolerance<S>::equal(), S(chosen::box_corner_merging));
}

/// Axis of largest separation of two boxes. It has its gap, with which other axes are compared.
template <Scalar S>
struct BoxAxis {
  /// [m] Distance along the axis. Negative where the boxes overlap along every axis.
  S gap = -infinity<S>;
  /// [-] Number of the axis.
  int axis = 0;

  /// [m] Gap above which another axis is clearly better.
  /// @param least_gain  [m] Smaller differences count as none.
  [[nodiscard]] S bar(S least_gain) const {
    using std::abs;
    return gap + S(chosen::box_axis_preference) * abs(gap) + least_gain;
  }
};

/// Returns the axis of the largest gap, or the first of equals: round-off must not decide anew in
/// each step along which axis boxes touch that meet at a corner, as in a wall of bricks.
/// @param least_gain  [m] Smaller differences count as none.
template <Scalar S>
[[nodiscard]] BoxAxis<S> best_axis(const Vec3<S>& gaps, S least_gain) {
  BoxAxis<S> best{gaps[0], 0};
  for (int i = 1; i < 3; ++i) {
    if (gaps[i] > best.gap + least_gain) best = {gaps[i], i};
  }
  return best;
}

/// [m^2] Area of the faces across an axis.
template <Scalar S>
[[nodiscard]] S face_area(const Box<S>& box, int axis) {
  const Vec3<S>& h = box.half_extents;
  return S(4) * h[axis < 2 ? axis + 1 : 0] * h[axis > 0 ? axis - 1 : 2];
}

/// Two boxes in the frame of the first. It spares the functions below four parameters.
template <Scalar S>
struct BoxPair {
  const Vec3<S>& a;  // [m] Half extents.
  const Vec3<S>& b;
  const Mat3<S>& R;  // Pose of B.
  const Vec3<S>& p;
};

/// The edges along axis `i` of A and `j` of B, and the separation across both. The search keeps the
/// best pair in it, of which `collide_edges` computes the contact.
template <Scalar S>
struct BoxEdges {
  int i = 0;
  int j = 0;
  /// [m] Distance along the common normal.
  S gap = -infinity<S>;
  /// [1] Sine of the angle between the edges; 0 for none.
  S sine = S(0);
  /// [1] Side of A on which B lies, along the cross product.
  S side = S(1);
};

/// Searches for a pair of edges that separates the boxes by more than `best.gap`.
///
/// @return True if the boxes come within `margin`. Else the search ends early.
template <Scalar S>
[[nodiscard]] bool search_edges(const BoxPair<S>& boxes, const Mat3<S>& absolute, S margin,
                                BoxEdges<S>& best) {
  using std::abs;
  using std::sqrt;
  const auto& [a, b, R, p] = boxes;
  for (int i = 0; i < 3; ++i) {
    const int i1 = i < 2 ? i + 1 : 0;
    const int i2 = i > 0 ? i - 1 : 2;
    // Lengths are along the cross products of the edges. Those have the sines as length.
    const Vec3<S> distance = p[i2] * row_of(R, i1) - p[i1] * row_of(R, i2);
    const Vec3<S> reach_a = a[i1] * row_of(absolute, i2) + a[i2] * row_of(absolute, i1);
    const Vec3<S> reach_b(b[1] * absolute(i, 2) + b[2] * absolute(i, 1),
                          b[2] * absolute(i, 0) + b[0] * absolute(i, 2),
                          b[0] * absolute(i, 1) + b[1] * absolute(i, 0));
    const Vec3<S> between = cwise_abs(distance) - reach_a - reach_b;
    for (int j = 0; j < 3; ++j) {
      // Division by a sine makes overlaps larger still. So most axes need no square root.
      if (between[j] <= std::min(best.gap, S(0))) continue;
      // Parallel edges span a face, which is tested already.
      const S sine = sqrt(R(i1, j) * R(i1, j) + R(i2, j) * R(i2, j));
      if (sine <= Tolerance<S>::equal()) continue;
      const S gap = between[j] / sine;
      if (gap > margin) return false;
      if (gap > best.gap) best = {i, j, gap, sine, distance[j] < S(0) ? S(-1) : S(1)};
    }
  }
  return true;
}

/// Contact of a face of A or B with the other box.
template <Scalar S>
void collide_face(const BoxPair<S>& boxes, bool is_of_a, int axis, S margin, S tolerance,
                  ContactManifold<S>& manifold) {
  const auto& [a, b, R, p] = boxes;
  if (is_of_a) {
    const BoxFace<S> face{a, axis, p[axis] < S(0) ? S(-1) : S(1), true};
    const BoxFacePatch<S> patch(face, b, R, p, tolerance);
    patch.add_to(manifold, margin, identity<Mat3<S>>(), zero<Vec3<S>>());
    manifold.normal = face.side * unit_vector<Vec3<S>>(axis);
  } else {
    const Mat3<S> R_BA = transposed(R);
    const Vec3<S> p_BA = -(R_BA * p);
    const BoxFace<S> face{b, axis, p_BA[axis] > S(0) ? S(1) : S(-1), false};
    const BoxFacePatch<S> patch(face, a, R_BA, p_BA, tolerance);
    patch.add_to(manifold, margin, R, p);
    manifold.normal = -face.side * column_of(R, axis);
  }
}

/// Contact of two crossed edges, at their closest points.
template <Scalar S>
void collide_edges(const BoxPair<S>& boxes, const BoxEdges<S>& edges, const Vec3<S>& normal,
                   const Vec3<S>& normal_B, ContactManifold<S>& manifold) {
  const auto& [a, b, R, p] = boxes;
  std::uint32_t corner_a = 0;
  std::uint32_t corner_b = 0;
  Vec3<S> middle_a = a;
  Vec3<S> middle_b = b;
  for (int k = 0; k < 3; ++k) {
    if (normal[k] < S(0)) {
      middle_a[k] = -a[k];
    } else {
      corner_a |= 1u << k;
    }
    if (normal_B[k] > S(0)) {
      middle_b[k] = -b[k];
    } else {
      corner_b |= 1u << k;
    }
  }
  middle_a[edges.i] = S(0);
  middle_b[edges.j] = S(0);
  middle_b = R * middle_b + p;
  const Vec3<S> along_b = column_of(R, edges.j);
  const Vec3<S> between = middle_b - middle_a;
  const S cosine = R(edges.i, edges.j);
  const S on_a = between[edges.i];
  const S on_b = between.dot(along_b);
  const S sine2 = edges.sine * edges.sine;
  const S s = std::clamp((on_a - cosine * on_b) / sine2, -a[edges.i], a[edges.i]);
  const S t = std::clamp((cosine * on_a - on_b) / sine2, -b[edges.j], b[edges.j]);
  middle_a[edges.i] = s;
  manifold.normal = normal;
  manifold.add({S(0.5) * (middle_a + middle_b + t * along_b), edges.gap,
                box_crossing_name(box_edge(corner_a, edges.i), box_edge(corner_b, edges.j))});
}

template <Scalar S>
void collide_shapes(const Box<S>& a, const Box<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out) {
  const Mat3<S> R = X_AB.rotation_matrix();
  const Mat3<S> absolute = cwise_abs(R);
  const Vec3<S>& p = X_AB.translation;
  const BoxPair<S> boxes{a.half_extents, b.half_extents, R, p};

  const S size = a.half_extents.maxCoeff() + b.half_extents.maxCoeff();
  const S least_gain = Tolerance<S>::equal() * size;
  const BoxAxis<S> face_a =
      best_axis<S>(cwise_abs(p) - a.half_extents - absolute * b.half_extents, least_gain);
  if (face_a.gap > margin) return;
  const Vec3<S> p_B = R.transpose() * p;
  const BoxAxis<S> face_b = best_axis<S>(
      cwise_abs(p_B) - b.half_extents - absolute.transpose() * a.half_extents, least_gain);
  if (face_b.gap > margin) return;

  // Of two equally good faces the larger is the reference. Features within it need no clipping.
  const bool is_b_larger = face_area(b, face_b.axis) > face_area(a, face_a.axis);
  const bool is_of_a =
      is_b_larger ? face_a.gap > face_b.bar(least_gain) : !(face_b.gap > face_a.bar(least_gain));
  const BoxAxis<S>& face = is_of_a ? face_a : face_b;
  BoxEdges<S> edges;
  edges.gap = face.bar(least_gain);
  if (!search_edges(boxes, absolute, margin, edges)) return;

  // The manifold is built in place, as it is large.
  ContactManifold<S>& manifold = out.emplace_back();
  const bool is_face = !(edges.sine > S(0));
  Vec3<S> normal;
  if (is_face) {
    collide_face(boxes, is_of_a, face.axis, margin, beside_tolerance<S>() * size, manifold);
    normal = manifold.normal;
  } else {
    normal = (edges.side / edges.sine) * unit_vector<Vec3<S>>(edges.i).cross(column_of(R, edges.j));
    const Vec3<S> normal_B = R.transpose() * normal;
    const bool is_crossing = edges.sine > S(chosen::edge_across_sine) &&
                             cwise_abs(normal).maxCoeff() < S(1 - chosen::aligned_face_versine) &&
                             cwise_abs(normal_B).maxCoeff() < S(1 - chosen::aligned_face_versine);
    if (is_crossing) {
      collide_edges(boxes, edges, normal, normal_B, manifold);
    } else {
      // Nearly parallel faces or edges touch in more than a point.
      const auto features = feature_pair(convex_view(a), convex_view(b), X_AB, normal);
      manifold = clip_features(features.a, features.b, normal, margin);
    }
  }
  const S gap = is_face ? face.gap : edges.gap;
  const auto points = std::span(manifold.points).first(manifold.size);
  const S farthest = gap <= S(0) ? infinity<S> : gap + least_gain;
  if (std::any_of(points.begin(), points.end(),
                  [&](const ContactPoint<S>& point) { return point.gap <= farthest; })) {
    return;
  }
  out.pop_back();
  // Boxes that overlap touch somewhere, whatever rounding says.
  if (gap <= S(0)) {
    build_manifold(convex_view(a), convex_view(b), X_AB, normal, margin, out);
    return;
  }
  // The features along the axis do not face each other. A corner passes a corner or an edge. None
  // of the fifteen axes is the direction of their distance.
  using P = Precise<S>;
  const Box<P> precise_a{a.half_extents.template cast<P>()};
  const Box<P> precise_b{b.half_extents.template cast<P>()};
  const auto found = contact_normal(convex_view(precise_a), convex_view(precise_b),
                                    X_AB.template cast<P>(), P(margin));
  if (found.nearness != Nearness::near) return;
  build_manifold(convex_view(a), convex_view(b), X_AB,
                 Vec3<S>(found.normal.template cast<S>().normalized()), margin, out);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
