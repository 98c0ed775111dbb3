/// @file
/// Features of a convex shape that are farthest in a direction: point, edge, face.
///
/// All functions work in the shape's own frame. Directions are unit vectors. Every function is
/// O(1), for hulls O(corners of all faces).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Feature of a convex surface: a point, an edge of two points or a convex polygon.
template <Scalar S>
struct SupportFeature {
  /// [-] Most corners.
  static constexpr std::size_t capacity = 16;

  /// [m] Corners. A polygon's run counter-clockwise seen from outside.
  std::array<Vec3<S>, capacity> points{};
  /// [-] Ids of the corners within the shape, the same for all directions.
  std::array<std::uint32_t, capacity> ids{};
  std::size_t size = 0;
  /// [1] Outward normal of a polygon's plane.
  Vec3<S> normal = zero<Vec3<S>>();
  /// [1] Cosine between a polygon's normal and the direction. 0 for edges and points.
  S cosine = S(0);
  /// True if the corners are samples of a curve.
  bool is_round = false;
  /// [-] For each corner of a polygon, true if its edge to the next is inside a larger flat face.
  /// Clipping asks it of shape A alone, whose corners keep their order there.
  std::array<bool, capacity> is_inner_edge{};

  [[nodiscard]] bool is_polygon() const { return size >= 3; }
  void add(const Vec3<S>& point, std::uint32_t id) {
    BRISTLE_ASSERT(size < capacity);
    points[size] = point;
    ids[size++] = id;
  }
  /// Returns the same feature in frame A, with its own frame at the pose `X_AB`.
  [[nodiscard]] SupportFeature transformed(const Transform<S>& X_AB) const {
    SupportFeature result = *this;
    const Mat3<S> R = X_AB.rotation_matrix();
    for (std::size_t i = 0; i < size; ++i) result.points[i] = R * points[i] + X_AB.translation;
    result.normal = R * normal;
    return result;
  }
};

/// Convex polygon in space as a two-sided plate: a part of a mesh's surface, for contacts. Refers
/// to its corners.
template <Scalar S>
struct Plate {
  /// [m] Three corners or more, counter-clockwise seen from the front.
  std::span<const Vec3<S>> corners;
  /// [-] Ids of the corners in a contact.
  std::span<const std::uint32_t> names;
  /// [1] Unit normal of the front.
  Vec3<S> normal;
};

// For each shape:
// - support_point: the farthest point along the direction, or one of several.
// - support_edge: the edge through that point if it is across the direction within
//   `edge_across_sine`, else the point. Lines on the side of a cylinder or cone are edges.
// - support_face: the face at that point that is nearest to perpendicular to the direction.
//   `SupportFeature::cosine` says how near. Disks are sampled at fixed angles and at their farthest
//   point. Capsules have lines for faces, balls points.

template <Scalar S>
[[nodiscard]] Vec3<S> support_point(const Sphere<S>& sphere, const Vec3<S>& direction) {
  return sphere.radius * direction;
}
template <Scalar S>
[[nodiscard]] Vec3<S> support_point(const Box<S>& box, const Vec3<S>& direction) {
  const Vec3<S>& h = box.half_extents;
  return {direction.x() < S(0) ? -h.x() : h.x(), direction.y() < S(0) ? -h.y() : h.y(),
          direction.z() < S(0) ? -h.z() : h.z()};
}
template <Scalar S>
[[nodiscard]] Vec3<S> support_point(const Capsule<S>& capsule, const Vec3<S>& direction) {
  const S end = direction.z() < S(0) ? -capsule.half_length : capsule.half_length;
  return Vec3<S>(S(0), S(0), end) + capsule.radius * direction;
}
template <Scalar S>
[[nodiscard]] Vec3<S> support_point(const Cylinder<S>& cylinder, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] Vec3<S> support_point(const Cone<S>& cone, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] Vec3<S> support_point(const Ellipsoid<S>& ellipsoid, const Vec3<S>& direction) {
  const Vec3<S> stretched = cwise_product(ellipsoid.radii, direction);
  return cwise_product(ellipsoid.radii, stretched) / stretched.norm();
}
template <Scalar S>
[[nodiscard]] Vec3<S> support_point(const ConvexHull<S>& hull, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] Vec3<S> support_point(const Plate<S>& plate, const Vec3<S>& direction);

template <Scalar S>
[[nodiscard]] SupportFeature<S> support_edge(const Sphere<S>& sphere, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_edge(const Box<S>& box, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_edge(const Capsule<S>& capsule, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_edge(const Cylinder<S>& cylinder, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_edge(const Cone<S>& cone, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_edge(const Ellipsoid<S>& ellipsoid,
                                             const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_edge(const ConvexHull<S>& hull, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_edge(const Plate<S>& plate, const Vec3<S>& direction);

template <Scalar S>
[[nodiscard]] SupportFeature<S> support_face(const Sphere<S>& sphere, const Vec3<S>& direction) {
  return support_edge(sphere, direction);
}
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_face(const Box<S>& box, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_face(const Capsule<S>& capsule, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_face(const Cylinder<S>& cylinder, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_face(const Cone<S>& cone, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_face(const Ellipsoid<S>& ellipsoid,
                                             const Vec3<S>& direction) {
  return support_edge(ellipsoid, direction);
}
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_face(const ConvexHull<S>& hull, const Vec3<S>& direction);
template <Scalar S>
[[nodiscard]] SupportFeature<S> support_face(const Plate<S>& plate, const Vec3<S>& direction);

// Implementation ----------------------------------------------------------------------------------

/// Ids of features of bodies of revolution. Samples of a rim are numbered from 0.
enum : std::uint32_t { rim_farthest = 64, apex_id = 65 };

/// [-] Samples of a rim at fixed angles: the inscribed polygon keeps 97 % of the radius. With the
/// farthest point they fit into a `SupportFeature`.
inline constexpr std::uint32_t rim_samples = 12;

template <Scalar S>
[[nodiscard]] SupportFeature<S> point_feature(const Vec3<S>& point, std::uint32_t id) {
  SupportFeature<S> feature;
  feature.add(point, id);
  return feature;
}

/// The direction's unit projection along z, or the x axis if it vanishes.
template <Scalar S>
[[nodiscard]] Vec2<S> radial(const Vec3<S>& direction) {
  const Vec2<S> planar = xy_of(direction);
  const S length = planar.norm();
  return length > S(0) ? Vec2<S>(planar / length) : unit_x<Vec2<S>>();
}

template <Scalar S>
[[nodiscard]] Vec3<S> rim_point(S radius, S z, const Vec2<S>& towards) {
  return {radius * towards.x(), radius * towards.y(), z};
}

/// A disk at height z that faces up or down.
template <Scalar S>
[[nodiscard]] SupportFeature<S> disk_feature(S radius, S z, bool is_up, const Vec3<S>& direction) {
  using std::atan2;
  using std::cos;
  using std::sin;
  SupportFeature<S> disk;
  disk.is_round = true;
  disk.normal = Vec3<S>(S(0), S(0), is_up ? S(1) : S(-1));
  disk.cosine = disk.normal.dot(direction);
  constexpr S step = S(2) * S(std::numbers::pi) / S(rim_samples);
  const Vec2<S> farthest = radial(direction);
  S angle = S(2) * S(std::numbers::pi);  // Beyond the last sample: not to be inserted.
  if (xy_of(direction).norm() > Tolerance<S>::equal()) {
    angle = atan2(farthest.y(), farthest.x());
    if (angle < S(0)) angle += S(2) * S(std::numbers::pi);
  }
  const std::uint32_t offset = is_up ? 0 : 2 * rim_samples;
  bool is_inserted = angle >= S(2) * S(std::numbers::pi);
  for (std::uint32_t i = 0; i < rim_samples; ++i) {
    const S at = step * S(i);
    if (!is_inserted && angle <= at) {
      disk.add(rim_point(radius, z, farthest), offset + rim_farthest);
      is_inserted = true;
    }
    disk.add({radius * cos(at), radius * sin(at), z}, offset + i);
  }
  if (!is_inserted) disk.add(rim_point(radius, z, farthest), offset + rim_farthest);
  if (!is_up) {
    std::reverse(disk.points.begin(), disk.points.begin() + static_cast<std::ptrdiff_t>(disk.size));
    std::reverse(disk.ids.begin(), disk.ids.begin() + static_cast<std::ptrdiff_t>(disk.size));
  }
  return disk;
}

/// Index of the corner that is farthest along the direction, or the first of equals.
template <Scalar S>
[[nodiscard]] std::uint32_t farthest_corner(std::span<const Vec3<S>> corners,
                                            const Vec3<S>& direction) {
  std::uint32_t best = 0;
  S farthest = corners[0].dot(direction);
  for (std::uint32_t i = 1; i < corners.size(); ++i) {
    const S along = corners[i].dot(direction);
    if (along > farthest) {
      farthest = along;
      best = i;
    }
  }
  return best;
}

/// [1] Deviation of an edge from across the direction: the sine of the angle, >= 0.
template <Scalar S>
[[nodiscard]] S edge_slope(const Vec3<S>& edge, const Vec3<S>& direction) {
  using std::abs;
  return abs(edge.dot(direction)) / edge.norm();
}

template <Scalar S>
Vec3<S> support_point(const Cylinder<S>& cylinder, const Vec3<S>& direction) {
  return rim_point(cylinder.radius,
                   direction.z() < S(0) ? -cylinder.half_length : cylinder.half_length,
                   radial(direction));
}

template <Scalar S>
Vec3<S> support_point(const Cone<S>& cone, const Vec3<S>& direction) {
  const Vec3<S> rim = rim_point(cone.radius, -cone.half_length, radial(direction));
  const Vec3<S> apex(S(0), S(0), cone.half_length);
  return apex.dot(direction) >= rim.dot(direction) ? apex : rim;
}

template <Scalar S>
Vec3<S> support_point(const ConvexHull<S>& hull, const Vec3<S>& direction) {
  return hull.vertices[farthest_corner<S>(hull.vertices, direction)];
}

template <Scalar S>
Vec3<S> support_point(const Plate<S>& plate, const Vec3<S>& direction) {
  return plate.corners[farthest_corner<S>(plate.corners, direction)];
}

template <Scalar S>
SupportFeature<S> support_edge(const Sphere<S>& sphere, const Vec3<S>& direction) {
  return point_feature<S>(support_point(sphere, direction), 0);
}

template <Scalar S>
SupportFeature<S> support_edge(const Ellipsoid<S>& ellipsoid, const Vec3<S>& direction) {
  return point_feature<S>(support_point(ellipsoid, direction), 0);
}

// Corners of a box are numbered by the signs of their coordinates: bit i is set if coordinate i is
// positive.
template <Scalar S>
SupportFeature<S> support_edge(const Box<S>& box, const Vec3<S>& direction) {
  int across = 0;
  const S slope = cwise_abs(direction).minCoeff(&across);
  Vec3<S> corner = support_point(box, direction);
  std::uint32_t id = 0;
  for (int i = 0; i < 3; ++i) id |= corner[i] > S(0) ? 1u << i : 0u;
  SupportFeature<S> feature;
  if (slope > S(chosen::edge_across_sine)) {
    feature.add(corner, id);
    return feature;
  }
  corner[across] = -box.half_extents[across];
  feature.add(corner, id & ~(1u << across));
  corner[across] = box.half_extents[across];
  feature.add(corner, id | 1u << across);
  return feature;
}

template <Scalar S>
SupportFeature<S> support_face(const Box<S>& box, const Vec3<S>& direction) {
  int axis = 0;
  SupportFeature<S> face;
  face.cosine = cwise_abs(direction).maxCoeff(&axis);
  const bool is_up = !(direction[axis] < S(0));
  face.normal[axis] = is_up ? S(1) : S(-1);
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  for (std::uint32_t i = 0; i < 4; ++i) {
    // Counter-clockwise in (u, v) seen from +axis, clockwise from -axis.
    const std::uint32_t k = is_up ? i : 3 - i;
    const bool u_up = k == 1 || k == 2;
    const bool v_up = k >= 2;
    Vec3<S> corner;
    corner[axis] = face.normal[axis] * box.half_extents[axis];
    corner[u] = u_up ? box.half_extents[u] : -box.half_extents[u];
    corner[v] = v_up ? box.half_extents[v] : -box.half_extents[v];
    face.add(corner, (is_up ? 1u << axis : 0u) | (u_up ? 1u << u : 0u) | (v_up ? 1u << v : 0u));
  }
  return face;
}

template <Scalar S>
SupportFeature<S> support_edge(const Capsule<S>& capsule, const Vec3<S>& direction) {
  using std::abs;
  const Vec3<S> out = capsule.radius * direction;
  const Vec3<S> end(S(0), S(0), capsule.half_length);
  SupportFeature<S> feature;
  const bool is_across = abs(direction.z()) <= S(chosen::edge_across_sine);
  if (is_across || direction.z() < S(0)) feature.add(out - end, 0);
  if (is_across || !(direction.z() < S(0))) feature.add(out + end, 1);
  return feature;
}

// Both ends, at any tilt of the capsule, until one hides the other.
template <Scalar S>
SupportFeature<S> support_face(const Capsule<S>& capsule, const Vec3<S>& direction) {
  using std::abs;
  if (S(1) - abs(direction.z()) <= S(chosen::edge_across_sine)) {
    return support_edge(capsule, direction);
  }
  const Vec3<S> out = capsule.radius * direction;
  const Vec3<S> end(S(0), S(0), capsule.half_length);
  SupportFeature<S> feature;
  feature.add(out - end, 0);
  feature.add(out + end, 1);
  return feature;
}

template <Scalar S>
SupportFeature<S> support_edge(const Cylinder<S>& cylinder, const Vec3<S>& direction) {
  using std::abs;
  const Vec2<S> towards = radial(direction);
  const bool is_across = abs(direction.z()) <= S(chosen::edge_across_sine);
  SupportFeature<S> feature;
  feature.is_round = !is_across;
  if (is_across || direction.z() < S(0)) {
    feature.add(rim_point(cylinder.radius, -cylinder.half_length, towards), 0);
  }
  if (is_across || !(direction.z() < S(0))) {
    feature.add(rim_point(cylinder.radius, cylinder.half_length, towards), 1);
  }
  return feature;
}

template <Scalar S>
SupportFeature<S> support_face(const Cylinder<S>& cylinder, const Vec3<S>& direction) {
  using std::abs;
  const bool is_up = !(direction.z() < S(0));
  if (abs(direction.z()) >= xy_of(direction).norm()) {
    return disk_feature(cylinder.radius, is_up ? cylinder.half_length : -cylinder.half_length,
                        is_up, direction);
  }
  const Vec2<S> towards = radial(direction);
  SupportFeature<S> side;
  side.add(rim_point(cylinder.radius, -cylinder.half_length, towards), 0);
  side.add(rim_point(cylinder.radius, cylinder.half_length, towards), 1);
  return side;
}

template <Scalar S>
SupportFeature<S> support_edge(const Cone<S>& cone, const Vec3<S>& direction) {
  const Vec3<S> rim = rim_point(cone.radius, -cone.half_length, radial(direction));
  const Vec3<S> apex(S(0), S(0), cone.half_length);
  const bool is_across = edge_slope<S>(apex - rim, direction) <= S(chosen::edge_across_sine);
  const bool is_apex = apex.dot(direction) >= rim.dot(direction);
  SupportFeature<S> feature;
  feature.is_round = !is_across && !is_apex;
  if (is_across || !is_apex) feature.add(rim, rim_farthest);
  if (is_across || is_apex) feature.add(apex, apex_id);
  return feature;
}

template <Scalar S>
SupportFeature<S> support_face(const Cone<S>& cone, const Vec3<S>& direction) {
  const S height = S(2) * cone.half_length;
  const Vec2<S> side_normal = Vec2<S>(height, cone.radius).normalized();
  const S side_cosine = side_normal.dot(Vec2<S>(xy_of(direction).norm(), direction.z()));
  if (-direction.z() >= side_cosine) {
    return disk_feature(cone.radius, -cone.half_length, false, direction);
  }
  SupportFeature<S> side;
  side.add(rim_point(cone.radius, -cone.half_length, radial(direction)), rim_farthest);
  side.add({S(0), S(0), cone.half_length}, apex_id);
  return side;
}

template <Scalar S>
SupportFeature<S> support_edge(const ConvexHull<S>& hull, const Vec3<S>& direction) {
  const std::uint32_t corner = farthest_corner<S>(hull.vertices, direction);
  std::uint32_t other = corner;
  S least_slope = S(chosen::edge_across_sine);
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const auto face = hull.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      // The edge that starts at the corner. The face on its other side has the one that ends there.
      if (face[i] != corner) continue;
      const std::uint32_t next = face[(i + 1) % face.size()];
      const S slope = edge_slope<S>(hull.vertices[next] - hull.vertices[corner], direction);
      if (slope <= least_slope) {
        least_slope = slope;
        other = next;
      }
    }
  }
  SupportFeature<S> feature;
  feature.add(hull.vertices[corner], corner);
  if (other != corner) feature.add(hull.vertices[other], other);
  return feature;
}

template <Scalar S>
SupportFeature<S> support_face(const ConvexHull<S>& hull, const Vec3<S>& direction) {
  // Only a face with the farthest corner: otherwise the deepest point could be missed.
  const std::uint32_t corner = farthest_corner<S>(hull.vertices, direction);
  SupportFeature<S> feature;
  std::size_t best = 0;
  std::size_t corner_place = 0;
  feature.cosine = -infinity<S>;
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const S cosine = hull.face_normals[f].dot(direction);
    if (!(cosine > feature.cosine)) continue;
    const auto face = hull.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      if (face[i] != corner) continue;
      best = f;
      corner_place = i;
      feature.cosine = cosine;
    }
  }
  feature.normal = hull.face_normals[best];
  // Of a face with many corners, evenly spread ones, with the farthest among them.
  const auto face = hull.face(best);
  const std::size_t count = std::min(face.size(), SupportFeature<S>::capacity);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t v = face[(corner_place + i * face.size() / count) % face.size()];
    feature.add(hull.vertices[v], v);
  }
  return feature;
}

template <Scalar S>
SupportFeature<S> support_edge(const Plate<S>& plate, const Vec3<S>& direction) {
  const std::size_t count = plate.corners.size();
  const std::size_t corner = farthest_corner<S>(plate.corners, direction);
  std::size_t other = corner;
  S least_slope = S(chosen::edge_across_sine);
  for (const std::size_t next : {(corner + 1) % count, (corner + count - 1) % count}) {
    const S slope = edge_slope<S>(plate.corners[next] - plate.corners[corner], direction);
    if (slope <= least_slope) {
      least_slope = slope;
      other = next;
    }
  }
  SupportFeature<S> feature;
  feature.add(plate.corners[corner], plate.names[corner]);
  if (other != corner) feature.add(plate.corners[other], plate.names[other]);
  return feature;
}

template <Scalar S>
SupportFeature<S> support_face(const Plate<S>& plate, const Vec3<S>& direction) {
  SupportFeature<S> face;
  const S cosine = plate.normal.dot(direction);
  const bool is_front = cosine >= S(0);
  face.normal = is_front ? plate.normal : Vec3<S>(-plate.normal);
  face.cosine = is_front ? cosine : -cosine;
  const std::size_t count = plate.corners.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = is_front ? i : count - 1 - i;
    face.add(plate.corners[k], plate.names[k]);
  }
  return face;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
