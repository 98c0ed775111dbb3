/// @file
/// Contacts in closed form. Each pair of shapes with a formula has an overload of
/// `collide_shapes(a, b, X_AB, margin, out)`. It appends the manifold of A and B to `out` if their
/// gap is at most `margin` [m]. Manifolds are in A's frame; X_AB is the pose of B in A. Two boxes
/// are in box_box.hpp.
///
/// Shapes with coinciding centres or axes have no natural contact normal. Each overload says which
/// normal it takes then. No overload throws.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_clip.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/shapes/convex_view.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/geometry/shapes/support.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Ball and ball. Concentric balls get the normal +z.
template <Scalar S>
void collide_shapes(const Sphere<S>& a, const Sphere<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out);
/// Capsule and ball. A ball centred on the axis gets the normal +x.
template <Scalar S>
void collide_shapes(const Capsule<S>& a, const Sphere<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out);
/// Box and ball. A centre inside leaves through the nearest face. Of equally near faces it takes
/// the first axis, upwards.
template <Scalar S>
void collide_shapes(const Box<S>& a, const Sphere<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out);
/// Two capsules. Crossing axes are separated along the normal of both. Parallel sides get two
/// points.
template <Scalar S>
void collide_shapes(const Capsule<S>& a, const Capsule<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out);

/// A shape with a face to stand on.
template <typename T, typename S>
concept SupportedShape = Scalar<S> && requires(const T& shape, const Vec3<S>& direction) {
  { support_face(shape, direction) } -> std::same_as<SupportFeature<S>>;
};

/// Half-space and any convex shape. Takes the corners of the face towards the plane.
template <Scalar S, SupportedShape<S> Convex>
void collide_shapes(const HalfSpace<S>& a, const Convex& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out);
/// Half-space and box, likewise.
template <Scalar S>
void collide_shapes(const HalfSpace<S>& a, const Box<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out);

// Implementation ----------------------------------------------------------------------------------

/// Contact of two balls of the given radii around two points.
/// @param fallback  [1] Normal of concentric balls.
template <Scalar S>
void collide_balls(const Vec3<S>& center_a, S radius_a, const Vec3<S>& center_b, S radius_b,
                   const Vec3<S>& fallback, S margin, ContactManifolds<S>& out) {
  const Vec3<S> between = center_b - center_a;
  const S distance = between.norm();
  const S gap = distance - radius_a - radius_b;
  if (!(gap <= margin)) return;
  ContactManifold<S>& manifold = out.emplace_back();
  manifold.normal = distance > S(0) ? Vec3<S>(between.stableNormalized()) : fallback;
  manifold.add({center_a + (radius_a + S(0.5) * gap) * manifold.normal, gap, 0});
}

/// Closest points of the segments of two capsules: heights on the axes of A and of B.
/// @param center, axis  Those of B, in A.
template <Scalar S>
[[nodiscard]] std::array<S, 2> closest_heights(const Capsule<S>& a, const Capsule<S>& b,
                                               const Vec3<S>& center, const Vec3<S>& axis) {
  // Projected along A's axis, the closest point of B's line is a foot of a perpendicular. For
  // parallel axes every point is. The middle serves as well as any.
  const Vec2<S> across = xy_of(axis);
  const S sine2 = across.squaredNorm();
  S on_b = sine2 > S(0) ? -xy_of(center).dot(across) / sine2 : S(0);
  on_b = std::clamp(on_b, -b.half_length, b.half_length);
  const S on_a = std::clamp(center.z() + on_b * axis.z(), -a.half_length, a.half_length);
  // If A's end limited the height, the closest point of B moves.
  on_b = std::clamp(axis.dot(Vec3<S>(S(0), S(0), on_a) - center), -b.half_length, b.half_length);
  return {on_a, on_b};
}

/// Contacts of points with the plane of a half-space, thinned as in `build_manifold`.
template <Scalar S>
class PlaneContacts {
 public:
  PlaneContacts(const HalfSpace<S>& plane, S margin, S extent)
      : plane_(plane), contacts_(margin, extent) {
    tangent_basis(plane.normal, t1_, t2_);
  }

  void add(const Vec3<S>& point, std::uint32_t name) {
    contacts_.add({t1_.dot(point), t2_.dot(point)}, plane_.offset, plane_.normal.dot(point), name);
  }

  /// @param limit  [-] Largest number of points.
  [[nodiscard]] ContactManifold<S> manifold(std::size_t limit) {
    contacts_.thin(limit);
    ContactManifold<S> manifold;
    manifold.normal = plane_.normal;
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const ClipContact<S>& c = contacts_[i];
      manifold.add(
          {c.place.x() * t1_ + c.place.y() * t2_ + c.height * plane_.normal, c.gap, c.name});
    }
    return manifold;
  }

 private:
  HalfSpace<S> plane_;
  Vec3<S> t1_;
  Vec3<S> t2_;
  ClipContacts<S> contacts_;
};

template <Scalar S>
void collide_shapes(const Sphere<S>& a, const Sphere<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out) {
  collide_balls<S>(zero<Vec3<S>>(), a.radius, X_AB.translation, b.radius, unit_z<Vec3<S>>(), margin,
                   out);
}

template <Scalar S>
void collide_shapes(const Capsule<S>& a, const Sphere<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out) {
  const S height = std::clamp(X_AB.translation.z(), -a.half_length, a.half_length);
  collide_balls<S>({S(0), S(0), height}, a.radius, X_AB.translation, b.radius, unit_x<Vec3<S>>(),
                   margin, out);
}

template <Scalar S>
void collide_shapes(const Box<S>& a, const Sphere<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out) {
  const Vec3<S>& center = X_AB.translation;
  const Vec3<S> nearest = cwise_min(cwise_max(center, -a.half_extents), a.half_extents);
  if (nearest != center) {
    collide_balls<S>(nearest, S(0), center, b.radius, unit_z<Vec3<S>>(), margin, out);
    return;
  }
  int axis = 0;
  const S depth = (a.half_extents - cwise_abs(center)).minCoeff(&axis);
  ContactManifold<S> manifold;
  manifold.normal = (center[axis] < S(0) ? S(-1) : S(1)) * unit_vector<Vec3<S>>(axis);
  const S gap = -depth - b.radius;
  // Halfway between the box's face and the far side of the ball.
  manifold.add({center - (b.radius + S(0.5) * gap) * manifold.normal, gap, 0});
  out.push_back(manifold);
}

template <Scalar S>
void collide_shapes(const Capsule<S>& a, const Capsule<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out) {
  using std::abs;
  const Vec3<S>& center = X_AB.translation;
  const Vec3<S> axis = X_AB.rotate(unit_z<Vec3<S>>());
  const auto [on_a, on_b] = closest_heights(a, b, center, axis);
  const Vec3<S> point_a(S(0), S(0), on_a);
  const Vec3<S> point_b = center + on_b * axis;
  const Vec2<S> across = xy_of(axis);
  const S sine = across.norm();

  Vec3<S> fallback = unit_x<Vec3<S>>();
  if (sine > S(0)) fallback = Vec3<S>(-across.y(), across.x(), S(0)) / sine;
  const Vec3<S> between = point_b - point_a;
  const S distance = between.norm();
  const Vec3<S> normal = distance > S(0) ? Vec3<S>(between.stableNormalized()) : fallback;
  const S across_sine = S(chosen::edge_across_sine);
  const bool is_lengthwise =
      sine <= across_sine && abs(normal.z()) <= across_sine && abs(normal.dot(axis)) <= across_sine;
  if (is_lengthwise && distance - a.radius - b.radius <= margin) {
    const auto features = feature_pair(convex_view(a), convex_view(b), X_AB, normal);
    const auto manifold = clip_features(features.a, features.b, normal, margin);
    if (manifold.size > 0) {
      out.push_back(manifold);
      return;
    }
  }
  collide_balls<S>(point_a, a.radius, point_b, b.radius, fallback, margin, out);
}

template <Scalar S, SupportedShape<S> Convex>
void collide_shapes(const HalfSpace<S>& a, const Convex& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out) {
  const Vec3<S> down_B = X_AB.rotation.conjugate() * Vec3<S>(-a.normal);
  // Early out of most pairs: the lowest point is beyond the margin.
  if (a.normal.dot(X_AB * support_point(b, down_B)) - a.offset > margin) return;
  const SupportFeature<S> face = support_face(b, down_B).transformed(X_AB);
  S extent = S(0);
  for (std::size_t i = 0; i < face.size; ++i) {
    extent = std::max(extent, (face.points[i] - face.points[0]).norm());
  }
  PlaneContacts<S> contacts(a, margin, extent);
  for (std::size_t i = 0; i < face.size; ++i) contacts.add(face.points[i], face.ids[i]);
  const ContactManifold<S> manifold = contacts.manifold(
      face.is_round ? ContactManifold<S>::round_capacity : ContactManifold<S>::capacity);
  if (manifold.size > 0) out.push_back(manifold);
}

template <Scalar S>
void collide_shapes(const HalfSpace<S>& a, const Box<S>& b, const Transform<S>& X_AB, S margin,
                    ContactManifolds<S>& out) {
  using std::abs;
  const Vec3<S>& half = b.half_extents;
  const Mat3<S> R = X_AB.rotation_matrix();
  const Vec3<S> up_B = R.transpose() * a.normal;
  // [m] Heights of the centre over the plane, and of the ends of the half axes over the centre.
  const S height = a.normal.dot(X_AB.translation) - a.offset;
  const Vec3<S> rise = cwise_product(half, up_B);
  if (height - cwise_abs(rise).sum() > margin) return;
  // The face whose normal is nearest to straight down.
  int axis = abs(up_B[1]) > abs(up_B[0]) ? 1 : 0;
  if (abs(up_B[2]) > abs(up_B[axis])) axis = 2;
  const int u = axis < 2 ? axis + 1 : 0;
  const int v = axis > 0 ? axis - 1 : 2;
  const S side = up_B[axis] > S(0) ? S(-1) : S(1);
  const Vec3<S> middle = X_AB.translation + (side * half[axis]) * column_of(R, axis);
  const S middle_gap = height + side * rise[axis];

  ContactManifold<S>& manifold = out.emplace_back();
  manifold.normal = a.normal;
  for (std::uint32_t k = 0; k < 4; ++k) {
    const bool u_up = k == 1 || k == 2;
    const bool v_up = k >= 2;
    const S gap = middle_gap + (u_up ? rise[u] : -rise[u]) + (v_up ? rise[v] : -rise[v]);
    if (!(gap <= margin)) continue;
    // Corner ids are those of support.hpp.
    const std::uint32_t id =
        (side > S(0) ? 1u << axis : 0u) | (u_up ? 1u << u : 0u) | (v_up ? 1u << v : 0u);
    manifold.add({middle + (u_up ? half[u] : -half[u]) * column_of(R, u) +
                      (v_up ? half[v] : -half[v]) * column_of(R, v) - (S(0.5) * gap) * a.normal,
                  gap, id});
  }
  if (manifold.size == 0) out.pop_back();
}

}  // namespace bristle::inline BRISTLE_ABI::detail
