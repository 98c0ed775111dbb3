/// @file
/// Contact of a face of one box with another box. The facing face of the other is clipped to it.
///
/// The reference face is a rectangle in its own box's axes. So clipping the incident face takes
/// four comparisons of coordinates (Gregorius, "Robust contact creation for physics simulations",
/// GDC 2015). The general method in contact_clip.hpp does the same at many times the cost. The
/// contacts are the same.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_manifold.hpp>
#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Ids of the contacts of two boxes. A corner's number holds the signs of its coordinates, as in
/// support.hpp. An edge is given by the common bits of its ends and the differing one. An id names
/// the two features alone. So it stays when the reference face changes to the other box.
enum : std::uint32_t { box_edge_count = 64, box_corner_names = 8, box_crossing_names = 16 };

/// Edge along `axis` from the corner whose bit of that axis is unset.
[[nodiscard]] constexpr std::uint32_t box_edge(std::uint32_t corner, int axis) {
  return (corner & ~(1u << axis)) | 8u << axis;
}
[[nodiscard]] constexpr std::uint32_t box_corner_name(std::uint32_t corner, bool is_of_a) {
  return is_of_a ? corner : box_corner_names + corner;
}
[[nodiscard]] constexpr std::uint32_t box_crossing_name(std::uint32_t edge_a,
                                                        std::uint32_t edge_b) {
  return box_crossing_names + box_edge_count * edge_a + edge_b;
}

/// A face of a box around the origin.
template <Scalar S>
struct BoxFace {
  /// [m] Half of each edge of the box.
  const Vec3<S>& half_extents;
  /// [-] Axis across the face.
  int axis;
  /// [1] Side of the box on which the face lies, 1 or -1.
  S side;
  /// True if its box is the first of the pair.
  bool is_of_a;

  [[nodiscard]] int u() const { return axis < 2 ? axis + 1 : 0; }
  [[nodiscard]] int v() const { return axis > 0 ? axis - 1 : 2; }
  /// [-] Bit common to all corners of the face.
  [[nodiscard]] std::uint32_t bit() const { return side > S(0) ? 1u << axis : 0u; }
};

/// The part of one box's face that lies over a face of the other box.
template <Scalar S>
class BoxFacePatch {
 public:
  /// Clips the other box's facing face to the reference face.
  ///
  /// @param half_extents  [m] Half of each edge of the other box.
  /// @param R, p          Pose of the other box in the axes of the reference face's.
  /// @param tolerance     [m] Points beyond the reference face by less are kept. Corners of equal
  ///         boxes coincide. They must not come and go with the last bits of the poses.
  BoxFacePatch(const BoxFace<S>& reference, const Vec3<S>& half_extents, const Mat3<S>& R,
               const Vec3<S>& p, S tolerance)
      : reference_(reference), tolerance_(tolerance) {
    using std::abs;
    const int k = reference.axis;
    int axis = abs(R(k, 1)) > abs(R(k, 0)) ? 1 : 0;
    if (abs(R(k, 2)) > abs(R(k, axis))) axis = 2;
    const BoxFace<S> face{half_extents, axis, reference.side * R(k, axis) > S(0) ? S(-1) : S(1),
                          !reference.is_of_a};
    const int u = face.u();
    const int v = face.v();
    Vec3<S> middle = local(p) + face.side * half_extents[axis] * local(column_of(R, axis));
    middle.z() -= reference.half_extents[k];
    const Vec3<S> along_u = half_extents[u] * local(column_of(R, u));
    const Vec3<S> along_v = half_extents[v] * local(column_of(R, v));
    // Either order around the face: clipping does not depend on it.
    const std::uint32_t id = face.bit();
    const std::uint32_t id_u = id | 1u << u;
    const std::uint32_t id_v = id | 1u << v;
    auto& corners = buffers_[0];
    corners[0] = {middle - along_u - along_v, name(id), box_edge(id, u)};
    corners[1] = {middle + along_u - along_v, name(id_u), box_edge(id_u, v)};
    corners[2] = {middle + along_u + along_v, name(id_u | id_v), box_edge(id_v, u)};
    corners[3] = {middle - along_u + along_v, name(id_v), box_edge(id, v)};
    size_ = 4;
    cut(0, reference.u(), reference.v(), middle.x(), abs(along_u.x()) + abs(along_v.x()));
    cut(1, reference.v(), reference.u(), middle.y(), abs(along_u.y()) + abs(along_v.y()));
  }

  /// Adds the corners with a gap of at most `margin` [m] to a manifold. Of neighbours closer than
  /// the tolerance, only the deeper is added.
  ///
  /// @param R, p  Pose of the reference face's box in the frame of the manifold.
  void add_to(ContactManifold<S>& manifold, S margin, const Mat3<S>& R, const Vec3<S>& p) const {
    const Vec3<S> u = column_of(R, reference_.u());
    const Vec3<S> v = column_of(R, reference_.v());
    const Vec3<S> n = reference_.side * column_of(R, reference_.axis);
    const Vec3<S> middle = p + reference_.half_extents[reference_.axis] * n;
    const std::array<Corner, capacity>& corners = buffers_[current_];
    const Corner* first = nullptr;  // Of the added corners.
    const Corner* last = nullptr;
    for (std::size_t i = 0; i < size_; ++i) {
      const Corner& corner = corners[i];
      const S gap = corner.place.z();
      if (!(gap <= margin)) continue;
      std::size_t point = manifold.size;
      if (last != nullptr && are_near(corner, *last)) {
        point = manifold.size - 1;
      } else if (last != nullptr && i + 1 == size_ && are_near(corner, *first)) {
        point = 0;
      }
      last = &corner;
      if (first == nullptr) first = &corner;
      if (point < manifold.size && !(gap < manifold.points[point].gap)) continue;
      ContactPoint<S>& contact = manifold.points[point];
      contact.position = middle + corner.place.x() * u + corner.place.y() * v + (S(0.5) * gap) * n;
      contact.gap = gap;
      if (point < manifold.size) continue;
      contact.feature = corner.name;
      ++manifold.size;
    }
  }

 private:
  // A rectangle has four corners, and each of four cuts adds at most one.
  static constexpr std::size_t capacity = ContactManifold<S>::capacity;
  static_assert(capacity >= 8);

  /// Bit in the number of an edge that belongs to the reference face.
  static constexpr std::uint32_t of_reference = box_edge_count;

  /// Has no initialisers, so that the buffers are not cleared for every pair.
  struct Corner {
    /// [m] Coordinates along u and v of the reference face, and height over it: the gap.
    Vec3<S> place;
    std::uint32_t name;
    /// [-] Edge that starts here.
    std::uint32_t edge;
  };

  /// Coordinates in the axes u, v and outwards of the reference face.
  template <typename Vector>
  [[nodiscard]] Vec3<S> local(const Vector& r) const {
    return {r[reference_.u()], r[reference_.v()], reference_.side * r[reference_.axis]};
  }

  [[nodiscard]] std::uint32_t name(std::uint32_t corner) const {
    return box_corner_name(corner, !reference_.is_of_a);
  }
  /// Id of the point where an edge of the patch crosses a side of the reference face.
  [[nodiscard]] std::uint32_t crossing_name(std::uint32_t side, std::uint32_t edge) const {
    // Two sides of the reference face meet in a corner with the bits of both.
    if ((edge & of_reference) != 0) return box_corner_name((side | edge) & 7u, reference_.is_of_a);
    return reference_.is_of_a ? box_crossing_name(side, edge) : box_crossing_name(edge, side);
  }

  /// Clips at both sides of the reference face across one coordinate.
  ///
  /// @param across, along  [-] Axes of the reference face's box: that of the coordinate, and the
  ///         other.
  /// @param middle, reach  [m] Middle and half width of the incident face: most faces need few
  ///         cuts.
  void cut(int coordinate, int across, int along, S middle, S reach) {
    const S limit = reference_.half_extents[across];
    const std::uint32_t id = reference_.bit();
    if (middle + reach > limit + tolerance_) {
      cut(coordinate, S(1), limit, box_edge(id | 1u << across, along));
    }
    if (middle - reach < -limit - tolerance_) cut(coordinate, S(-1), limit, box_edge(id, along));
  }

  /// Keeps corners with sign * coordinate <= limit. Sutherland and Hodgman 1974.
  void cut(int coordinate, S sign, S limit, std::uint32_t side) {
    const std::array<Corner, capacity>& from = buffers_[current_];
    std::array<Corner, capacity>& to = buffers_[1 - current_];
    std::size_t count = 0;
    const auto depth = [&](std::size_t i) { return limit - sign * from[i].place[coordinate]; };
    S inside = size_ > 0 ? depth(0) : S(0);
    for (std::size_t i = 0; i < size_; ++i) {
      const std::size_t next = i + 1 < size_ ? i + 1 : 0;
      const S inside_next = depth(next);
      const bool is_in = inside >= -tolerance_;
      if (is_in && count < capacity) to[count++] = from[i];
      if (is_in != (inside_next >= -tolerance_) && count < capacity) {
        const S t = std::clamp(inside / (inside - inside_next), S(0), S(1));
        to[count++] = {from[i].place + t * (from[next].place - from[i].place),
                       crossing_name(side, from[i].edge),
                       is_in ? side | of_reference : from[i].edge};
      }
      inside = inside_next;
    }
    current_ = 1 - current_;
    size_ = count;
  }

  [[nodiscard]] bool are_near(const Corner& a, const Corner& b) const {
    const S du = a.place.x() - b.place.x();
    const S dv = a.place.y() - b.place.y();
    return du * du + dv * dv <= tolerance_ * tolerance_;
  }

  BoxFace<S> reference_;
  S tolerance_;
  std::array<std::array<Corner, capacity>, 2> buffers_;
  std::size_t current_ = 0;
  std::size_t size_ = 0;
};

}  // namespace bristle::inline BRISTLE_ABI::detail
