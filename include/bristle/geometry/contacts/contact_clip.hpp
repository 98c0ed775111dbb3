/// @file
/// Full contact manifold of two convex shapes from their contact normal alone.
///
/// Along the normal n, the surfaces are height fields over a plane. The facing faces, edges or
/// points are projected into that plane and intersected there. The contacts are the corners of the
/// intersection. The gap of each is the difference of heights. This is the clipping of incident
/// against reference face in a form that treats both shapes alike (Gregorius, "Robust contact
/// creation for physics simulations", GDC 2015).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_manifold.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/shapes/support.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Returns the manifold of two convex shapes along a given normal. It has the corners of the common
/// patch whose gap is at most `margin` [m]. They are thinned to the manifold's capacity. If a face
/// is rounded, four remain. It is empty if every gap is larger.
///
/// Shapes are those of support.hpp. There is a contact if the shapes' extents along the normal come
/// within the margin. So a slightly wrong normal loses no contact.
///
/// @param X_AB    Pose of B in A.
/// @param normal  [1] Unit normal from A into B, in A, from any method. A direction of smaller
///                overlap or larger distance gives a better manifold.
template <Scalar S, typename ShapeA, typename ShapeB>
[[nodiscard]] ContactManifold<S> contact_manifold(const ShapeA& a, const ShapeB& b,
                                                  const Transform<S>& X_AB, const Vec3<S>& normal,
                                                  S margin);

/// The same, appended to `out` with a key, unless it has no points.
///
/// @return True if a manifold was appended.
template <Scalar S, typename ShapeA, typename ShapeB>
bool build_manifold(const ShapeA& a, const ShapeB& b, const Transform<S>& X_AB,
                    const Vec3<S>& normal, S margin, ContactManifolds<S>& out,
                    std::uint32_t key = 0);

// Implementation ----------------------------------------------------------------------------------

/// Mixes two numbers into one: MurmurHash3's finaliser over a weighted sum. Names of features use
/// it. Two names in one manifold agree with a chance of 1e-8.
[[nodiscard]] constexpr std::uint32_t mix(std::uint32_t a, std::uint32_t b) {
  std::uint32_t h = a * 0x9e3779b9u + b + 0x7f4a7c15u;
  h = (h ^ (h >> 16)) * 0x85ebca6bu;
  h = (h ^ (h >> 13)) * 0xc2b2ae35u;
  return h ^ (h >> 16);
}
[[nodiscard]] constexpr std::uint32_t mix_unordered(std::uint32_t a, std::uint32_t b) {
  return mix(std::min(a, b), std::max(a, b));
}

/// A feature over the plane across the normal: coordinates in the plane, and height along n.
template <Scalar S>
class HeightField {
 public:
  static constexpr std::size_t capacity = SupportFeature<S>::capacity;

  /// @param t1, t2, n  Orthonormal basis.
  /// @param side       Distinguishes the names of A's features from those of B.
  HeightField(const SupportFeature<S>& feature, const Vec3<S>& t1, const Vec3<S>& t2,
              const Vec3<S>& n, std::uint32_t side)
      : size_(feature.size) {
    for (std::size_t i = 0; i < size_; ++i) {
      place_[i] = {t1.dot(feature.points[i]), t2.dot(feature.points[i])};
      height_[i] = n.dot(feature.points[i]);
      name_[i] = mix(side, feature.ids[i]);
      is_inner_edge_[i] = feature.is_inner_edge[i];
      extent_ = std::max(extent_, cwise_abs(feature.points[i]).maxCoeff());
    }
    // Both faces run counter-clockwise seen from +n. That of B is seen from behind.
    if (is_polygon() && feature.normal.dot(n) < S(0)) {
      const auto count = static_cast<std::ptrdiff_t>(size_);
      std::reverse(place_.begin(), place_.begin() + count);
      std::reverse(height_.begin(), height_.begin() + count);
      std::reverse(name_.begin(), name_.begin() + count);
    }
    if (is_polygon()) {
      slope_ = -Vec2<S>(t1.dot(feature.normal), t2.dot(feature.normal)) / n.dot(feature.normal);
    } else if (size_ == 2) {
      const Vec2<S> along = place_[1] - place_[0];
      slope_ = along * ((height_[1] - height_[0]) / along.squaredNorm());
    }
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool is_polygon() const { return size_ >= 3; }
  [[nodiscard]] const Vec2<S>& place(std::size_t i) const { return place_[i]; }
  [[nodiscard]] std::uint32_t name(std::size_t i) const { return name_[i]; }
  [[nodiscard]] std::size_t next(std::size_t i) const { return i + 1 < size_ ? i + 1 : 0; }
  /// Name of the edge from corner i to the next. It is the same from both sides.
  [[nodiscard]] std::uint32_t edge_name(std::size_t i) const {
    return mix_unordered(name_[i], name_[next(i)]);
  }
  /// Returns whether a point of a polygon's outline is inside a larger flat face: within
  /// `tolerance` [m] of an edge there, and of no other edge.
  [[nodiscard]] bool is_inside_face(const Vec2<S>& place, S tolerance) const {
    using std::abs;
    bool is_on_inner_edge = false;
    for (std::size_t i = 0; i < size_; ++i) {
      const Vec2<S> along = (place_[next(i)] - place_[i]).normalized();
      const Vec2<S> r = place - place_[i];
      if (abs(along.x() * r.y() - along.y() * r.x()) > tolerance) continue;
      if (!is_inner_edge_[i]) return false;
      is_on_inner_edge = true;
    }
    return is_on_inner_edge;
  }
  /// [m] Largest coordinate: the scale of rounding errors.
  [[nodiscard]] S extent() const { return extent_; }

  /// [m] Height above a point, clamped to the heights of the corners.
  [[nodiscard]] S height(const Vec2<S>& place) const {
    const auto first = height_.begin();
    const auto last = first + static_cast<std::ptrdiff_t>(size_);
    const S h = height_[0] + slope_.dot(place - place_[0]);
    return std::clamp(h, *std::min_element(first, last), *std::max_element(first, last));
  }

 private:
  std::array<Vec2<S>, capacity> place_;
  std::array<S, capacity> height_;
  std::array<std::uint32_t, capacity> name_;
  std::array<bool, capacity> is_inner_edge_;
  std::size_t size_;
  Vec2<S> slope_ = zero<Vec2<S>>();
  S extent_ = S(0);
};

/// Corner of an intersection. It carries names through the cuts, since contacts are matched by them
/// from step to step. `edge` names the edge that starts there. `is_cut` tells a corner that a cut
/// has made from one of the polygon's own.
template <Scalar S>
struct ClipCorner {
  Vec2<S> place;
  std::uint32_t name = 0;
  std::uint32_t edge = 0;
  bool is_cut = false;
};

/// A convex polygon, open path of two corners, or single corner that is clipped.
template <Scalar S>
class ClipPolygon {
 public:
  // Each cut adds at most one corner.
  static constexpr std::size_t capacity = 2 * HeightField<S>::capacity;

  explicit ClipPolygon(const HeightField<S>& field) : size_(field.size()) {
    for (std::size_t i = 0; i < size_; ++i) {
      corners_[i] = {field.place(i), field.name(i), field.edge_name(i)};
    }
  }

  [[nodiscard]] std::span<const ClipCorner<S>> corners() const { return {corners_.data(), size_}; }

  /// Keeps the part to the left of the line through a and b. Points within `tolerance` [m] of it
  /// stay. Sutherland and Hodgman 1974.
  void cut(const Vec2<S>& a, const Vec2<S>& b, std::uint32_t edge, S tolerance) {
    const Vec2<S> along = (b - a).normalized();
    std::array<S, capacity> side;
    for (std::size_t i = 0; i < size_; ++i) {
      const Vec2<S> r = corners_[i].place - a;
      side[i] = along.x() * r.y() - along.y() * r.x();
    }
    std::array<ClipCorner<S>, capacity> kept;
    std::size_t count = 0;
    const auto keep = [&](const ClipCorner<S>& corner) {
      if (count < capacity) kept[count++] = corner;
    };
    for (std::size_t i = 0; i < size_; ++i) {
      const std::size_t j = i + 1 < size_ ? i + 1 : 0;
      const bool is_in = side[i] >= -tolerance;
      if (is_in) keep(corners_[i]);
      // A path of two corners has no edge back.
      if (size_ < 3 && j == 0) break;
      if (is_in == (side[j] >= -tolerance)) continue;
      const S t = std::clamp(side[i] / (side[i] - side[j]), S(0), S(1));
      const Vec2<S> crossing = corners_[i].place + t * (corners_[j].place - corners_[i].place);
      keep(
          {crossing, mix_unordered(corners_[i].edge, edge), is_in ? edge : corners_[i].edge, true});
    }
    corners_ = kept;
    size_ = count;
  }

  void cut_by(const HeightField<S>& polygon, S tolerance) {
    for (std::size_t i = 0; i < polygon.size() && size_ > 0; ++i) {
      cut(polygon.place(i), polygon.place(polygon.next(i)), polygon.edge_name(i), tolerance);
    }
  }

 private:
  std::array<ClipCorner<S>, capacity> corners_;
  std::size_t size_;
};

/// A contact before thinning. It stays in the plane, where distances and areas take two numbers,
/// and becomes a point in space only if it is chosen.
template <Scalar S>
struct ClipContact {
  Vec2<S> place;
  S gap;
  S height;
  std::uint32_t name;
};

/// Contacts of one manifold before thinning, without duplicates.
template <Scalar S>
class ClipContacts {
 public:
  static constexpr std::size_t capacity = ClipPolygon<S>::capacity;

  /// @param margin  [m] Contacts with a larger gap are dropped.
  /// @param extent  [m] Size of the coordinates: contacts closer than `Tolerance::equal` of it are
  ///                merged.
  ClipContacts(S margin, S extent)
      : margin_(margin),
        nearest_(Tolerance<S>::equal() * extent),
        round_off_(Tolerance<S>::round_off() * extent) {}

  void add(const Vec2<S>& place, S height_a, S height_b, std::uint32_t name) {
    const S gap = height_b - height_a;
    if (!(gap <= margin_) || size_ == capacity) return;
    ClipContact<S> contact{place, gap, S(0.5) * (height_a + height_b), name};
    for (std::size_t i = 0; i < size_; ++i) {
      if ((contacts_[i].place - place).squaredNorm() > nearest_ * nearest_) continue;
      // One contact at the greater depth, under the earlier name.
      contact.name = contacts_[i].name;
      if (gap < contacts_[i].gap) contacts_[i] = contact;
      return;
    }
    contacts_[size_++] = contact;
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] const ClipContact<S>& operator[](std::size_t i) const { return contacts_[i]; }

  /// Keeps `count` contacts in their order. The deepest stays, then always the one farthest from
  /// those kept.
  void thin(std::size_t count) {
    if (size_ <= count) return;
    std::array<bool, capacity> is_kept{};
    std::array<S, capacity> clearance;
    clearance.fill(infinity<S>);
    // Of nearly equal depths the first wins. So resting contacts do not take turns.
    const std::size_t first = deepest(nearest_);
    std::size_t next = first;
    for (std::size_t kept = 1;; ++kept) {
      is_kept[next] = true;
      if (kept == count) break;
      S farthest = S(-1);
      const Vec2<S> last = contacts_[next].place;
      for (std::size_t i = 0; i < size_; ++i) {
        clearance[i] = std::min(clearance[i], (contacts_[i].place - last).norm());
        if (!is_kept[i] && clearance[i] > farthest + nearest_) {
          farthest = clearance[i];
          next = i;
        }
      }
    }
    // The strictly deepest contact replaces the kept one nearest to it.
    const std::size_t best = deepest(round_off_);
    if (!is_kept[best]) {
      std::size_t beside = first;
      for (std::size_t i = 0; i < size_; ++i) {
        if (is_kept[i] && distance2(i, best) < distance2(beside, best)) beside = i;
      }
      is_kept[beside] = false;
      is_kept[best] = true;
    }
    std::size_t place = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      if (is_kept[i]) contacts_[place++] = contacts_[i];
    }
    size_ = place;
  }

 private:
  /// The deepest, or the first that no later contact exceeds by more than `tolerance` [m].
  [[nodiscard]] std::size_t deepest(S tolerance) const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < size_; ++i) {
      if (contacts_[i].gap < contacts_[best].gap - tolerance) best = i;
    }
    return best;
  }
  [[nodiscard]] S distance2(std::size_t i, std::size_t j) const {
    return (contacts_[i].place - contacts_[j].place).squaredNorm();
  }

  S margin_;
  S nearest_;
  S round_off_;
  std::array<ClipContact<S>, capacity> contacts_;
  std::size_t size_ = 0;
};

/// Closest point of two edges in the plane, within both.
template <Scalar S>
[[nodiscard]] Vec2<S> edge_crossing(const HeightField<S>& a, const HeightField<S>& b) {
  const Vec2<S> u = a.place(1) - a.place(0);
  const Vec2<S> v = b.place(1) - b.place(0);
  const Vec2<S> r = b.place(0) - a.place(0);
  const S cross = u.x() * v.y() - u.y() * v.x();
  const S s = std::clamp((r.x() * v.y() - r.y() * v.x()) / cross, S(0), S(1));
  const S t = std::clamp((r.x() * u.y() - r.y() * u.x()) / cross, S(0), S(1));
  return S(0.5) * (a.place(0) + s * u + b.place(0) + t * v);
}

/// Returns whether two edges are parallel enough to touch along a line.
template <Scalar S>
[[nodiscard]] bool are_parallel(const HeightField<S>& a, const HeightField<S>& b) {
  using std::abs;
  const Vec2<S> u = (a.place(1) - a.place(0)).normalized();
  const Vec2<S> v = (b.place(1) - b.place(0)).normalized();
  return abs(u.x() * v.y() - u.y() * v.x()) <= S(chosen::edge_across_sine);
}

/// Clips an edge to the ends of a parallel one.
template <Scalar S>
void cut_along(ClipPolygon<S>& edge, const HeightField<S>& other, S tolerance) {
  const Vec2<S> along = other.place(1) - other.place(0);
  const Vec2<S> left(-along.y(), along.x());
  edge.cut(other.place(0), other.place(0) - left, other.name(0), tolerance);
  edge.cut(other.place(1), other.place(1) + left, other.name(1), tolerance);
}

/// Intersects two features over the plane.
template <Scalar S>
void intersect(const HeightField<S>& a, const HeightField<S>& b, S tolerance,
               ClipContacts<S>& contacts) {
  const auto add = [&](const Vec2<S>& place, std::uint32_t name) {
    contacts.add(place, a.height(place), b.height(place), name);
  };
  if (a.size() == 1 || b.size() == 1) {
    const bool is_of_a = a.size() == 1;
    const std::uint32_t name = a.size() == b.size() ? mix(a.name(0), b.name(0))
                               : is_of_a            ? a.name(0)
                                                    : b.name(0);
    // A rough normal leaves two points side by side. Take their middle.
    add(a.size() == b.size() ? Vec2<S>(S(0.5) * (a.place(0) + b.place(0)))
                             : (is_of_a ? a : b).place(0),
        name);
    return;
  }
  if (a.size() == 2 && b.size() == 2 && !are_parallel(a, b)) {
    add(edge_crossing(a, b), mix(a.edge_name(0), b.edge_name(0)));
    return;
  }
  // The lower-dimensional feature is cut by the other.
  ClipPolygon<S> common(a.size() == 2 ? a : b);
  if (a.size() == 2 && b.size() == 2) {
    cut_along(common, b, tolerance);
  } else {
    common.cut_by(a.size() == 2 ? b : a, tolerance);
  }
  for (const ClipCorner<S>& corner : common.corners()) {
    // Edges inside a flat face cut what it touches into pieces, which has no corners there.
    if (corner.is_cut && a.is_inside_face(corner.place, tolerance)) continue;
    add(corner.place, corner.name);
  }
}

/// The manifold of two features in one frame. Empty if they do not meet across the normal.
/// @param uncertainty  [m] How far the features' corners may be from their places across the
/// normal.
template <Scalar S>
[[nodiscard]] ContactManifold<S> clip_features(const SupportFeature<S>& a,
                                               const SupportFeature<S>& b, const Vec3<S>& normal,
                                               S margin, S uncertainty = S(0)) {
  Vec3<S> t1;
  Vec3<S> t2;
  tangent_basis(normal, t1, t2);
  const HeightField<S> field_a(a, t1, t2, normal, 1);
  const HeightField<S> field_b(b, t1, t2, normal, 2);
  const S extent = std::max(field_a.extent(), field_b.extent());
  ClipContacts<S> contacts(margin, extent);
  intersect(field_a, field_b, std::max(Tolerance<S>::equal() * extent, uncertainty), contacts);
  contacts.thin(a.is_round || b.is_round ? ContactManifold<S>::round_capacity
                                         : ContactManifold<S>::capacity);

  ContactManifold<S> manifold;
  manifold.normal = normal;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ClipContact<S>& c = contacts[i];
    manifold.add({c.place.x() * t1 + c.place.y() * t2 + c.height * normal, c.gap, c.name});
  }
  return manifold;
}

/// The features of two shapes that face each other along a normal, both in A. They are a pair,
/// since the choice of each depends on the other.
template <Scalar S>
struct FeaturePair {
  SupportFeature<S> a;
  SupportFeature<S> b;
};

/// Returns the faces if one of them is aligned with the normal. An edge replaces a face that does
/// not face the normal. Otherwise returns edges and points.
template <Scalar S, typename ShapeA, typename ShapeB>
[[nodiscard]] FeaturePair<S> feature_pair(const ShapeA& a, const ShapeB& b,
                                          const Transform<S>& X_AB, const Vec3<S>& normal) {
  const Vec3<S> towards_a = X_AB.rotation.conjugate() * Vec3<S>(-normal);
  SupportFeature<S> face_a = support_face(a, normal);
  SupportFeature<S> face_b = support_face(b, towards_a);
  const S aligned = S(1 - chosen::aligned_face_versine);
  const bool is_aligned = face_a.cosine >= aligned || face_b.cosine >= aligned;
  // No cosine reaches 2.
  const S least = is_aligned ? S(chosen::facing_face_cosine) : S(2);
  if (face_a.is_polygon() && face_a.cosine < least) face_a = support_edge(a, normal);
  if (face_b.is_polygon() && face_b.cosine < least) face_b = support_edge(b, towards_a);
  return {face_a, face_b.transformed(X_AB)};
}

/// Contact of the two farthest points. It lies at that of the shape whose face is turned more
/// against the normal, since all of a face across the normal is as far. Between two edges, or faces
/// that are turned alike, it lies halfway.
template <Scalar S, typename ShapeA, typename ShapeB>
[[nodiscard]] ContactPoint<S> extreme_contact(const ShapeA& a, const ShapeB& b,
                                              const Transform<S>& X_AB, const Vec3<S>& normal) {
  const Vec3<S> on_a = support_point(a, normal);
  const Vec3<S> on_b =
      X_AB * support_point(b, Vec3<S>(X_AB.rotation.conjugate() * Vec3<S>(-normal)));
  const S gap = normal.dot(on_b - on_a);
  const FeaturePair<S> features = feature_pair(a, b, X_AB, normal);
  const Vec3<S> beside_a = on_a + S(0.5) * gap * normal;
  const Vec3<S> beside_b = on_b - S(0.5) * gap * normal;
  if (features.a.cosine < features.b.cosine) return {beside_a, gap, 0};
  if (features.b.cosine < features.a.cosine) return {beside_b, gap, 0};
  return {S(0.5) * (beside_a + beside_b), gap, 0};
}

template <Scalar S, typename ShapeA, typename ShapeB>
ContactManifold<S> contact_manifold(const ShapeA& a, const ShapeB& b, const Transform<S>& X_AB,
                                    const Vec3<S>& normal, S margin) {
  const auto features = feature_pair(a, b, X_AB, normal);
  ContactManifold<S> manifold = clip_features(features.a, features.b, normal, margin);
  if (manifold.size == 0) {
    const ContactPoint<S> extreme = extreme_contact(a, b, X_AB, normal);
    if (extreme.gap <= margin) manifold.add(extreme);
  }
  return manifold;
}

template <Scalar S, typename ShapeA, typename ShapeB>
bool build_manifold(const ShapeA& a, const ShapeB& b, const Transform<S>& X_AB,
                    const Vec3<S>& normal, S margin, ContactManifolds<S>& out, std::uint32_t key) {
  const ContactManifold<S> manifold = contact_manifold(a, b, X_AB, normal, margin);
  if (manifold.size == 0) return false;
  out.push_back(manifold);
  out.back().key = key;
  return true;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
