/// @file
/// Polytope of EPA (van den Bergen 2001). It has corners of a convex set, and knows its face
/// nearest to the origin.
///
/// The set is that of all differences a - b of points of two overlapping solids. Its least depth is
/// bounded below by the distance of the nearest face. It is bounded above by the extent of the set
/// along that face's normal. Expanding that face closes in on the global minimum. A descent cannot
/// promise that.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/math/types.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// Convex polytope of a fixed capacity. Distances of faces are signed, so the origin may be
/// outside.
template <Scalar S>
class ExpandingPolytope {
 public:
  /// [-] Most corners. A polyhedron whose difference with another has more gets a local minimum.
  static constexpr std::size_t max_corners = 64;

  struct Face {
    std::array<std::uint8_t, 3> corners;
    /// [1] Outward unit normal.
    Vec3<S> normal;
    /// [m] Distance of its plane from the origin, along the normal.
    S distance;
  };

  /// Starts as a tetrahedron. Returns false if that is flat to round-off.
  bool start(const std::array<Vec3<S>, 4>& corners);

  /// Face with the least distance.
  [[nodiscard]] const Face& nearest() const { return faces_[nearest_]; }

  /// Adds a corner outside. Returns false if it is not outside, or the capacity is exhausted.
  bool expand(const Vec3<S>& corner);

 private:
  // Bound of a closed polytope of triangles, by Euler's formula.
  static constexpr std::size_t max_faces = 2 * max_corners - 4;

  struct Edge {
    std::uint8_t from, to;
  };

  bool add_face(std::uint8_t a, std::uint8_t b, std::uint8_t c);
  void find_nearest();

  std::array<Vec3<S>, max_corners> corners_;
  std::array<Face, max_faces> faces_;
  std::array<Edge, 3 * max_faces> horizon_;
  std::size_t corner_count_ = 0;
  std::size_t face_count_ = 0;
  std::size_t nearest_ = 0;
  S size_ = S(0);
};

// Implementation ----------------------------------------------------------------------------------

template <Scalar S>
bool ExpandingPolytope<S>::start(const std::array<Vec3<S>, 4>& corners) {
  corner_count_ = 0;
  face_count_ = 0;
  size_ = S(0);
  for (const Vec3<S>& p : corners) {
    corners_[corner_count_++] = p;
    size_ = std::max(size_, cwise_abs(p).maxCoeff());
  }
  const Vec3<S> u = corners[1] - corners[0];
  const Vec3<S> v = corners[2] - corners[0];
  const Vec3<S> n = u.cross(v);
  const S height = n.dot(corners[3] - corners[0]);
  using std::abs;
  if (!(abs(height) > Tolerance<S>::round_off() * size_ * n.norm())) return false;
  // Counter-clockwise seen from outside. The fourth corner is behind the face of the other three.
  const bool is_behind = height < S(0);
  const std::uint8_t b = is_behind ? 1 : 2;
  const std::uint8_t c = is_behind ? 2 : 1;
  const bool is_solid =
      add_face(0, b, c) && add_face(0, 3, b) && add_face(b, 3, c) && add_face(c, 3, 0);
  find_nearest();
  return is_solid;
}

template <Scalar S>
bool ExpandingPolytope<S>::expand(const Vec3<S>& corner) {
  if (corner_count_ == max_corners) return false;
  size_ = std::max(size_, cwise_abs(corner).maxCoeff());
  const S tolerance = Tolerance<S>::round_off() * size_;
  // Faces that see the corner go. Edges that only one of them has are the rim of the hole.
  std::size_t edge_count = 0;
  for (std::size_t f = 0; f < face_count_;) {
    const Face& face = faces_[f];
    if (!(face.normal.dot(corner) - face.distance > tolerance)) {
      ++f;
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const Edge edge{face.corners[k], face.corners[(k + 1) % 3]};
      std::size_t i = 0;
      while (i < edge_count && (horizon_[i].from != edge.to || horizon_[i].to != edge.from)) ++i;
      if (i < edge_count) {
        horizon_[i] = horizon_[--edge_count];
      } else {
        horizon_[edge_count++] = edge;
      }
    }
    faces_[f] = faces_[--face_count_];
  }
  if (edge_count == 0) return false;
  const auto added = static_cast<std::uint8_t>(corner_count_);
  corners_[corner_count_++] = corner;
  bool is_closed = true;
  for (std::size_t i = 0; i < edge_count; ++i) {
    is_closed = add_face(horizon_[i].from, horizon_[i].to, added) && is_closed;
  }
  if (face_count_ == 0) return false;
  find_nearest();
  return is_closed;
}

template <Scalar S>
bool ExpandingPolytope<S>::add_face(std::uint8_t a, std::uint8_t b, std::uint8_t c) {
  if (face_count_ == max_faces) return false;
  const Vec3<S> n = (corners_[b] - corners_[a]).cross(corners_[c] - corners_[a]).stableNormalized();
  // A sliver has no normal, only a zero vector: the polytope would have a hole.
  if (!(n.squaredNorm() > S(0.5))) return false;
  faces_[face_count_++] = {{a, b, c}, n, n.dot(corners_[a])};
  return true;
}

template <Scalar S>
void ExpandingPolytope<S>::find_nearest() {
  nearest_ = 0;
  for (std::size_t f = 1; f < face_count_; ++f) {
    if (faces_[f].distance < faces_[nearest_].distance) nearest_ = f;
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
