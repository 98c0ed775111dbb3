/// @file
/// The surface of a mesh that FCL holds: neighbours, flat faces, and who answers for a contact.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/geometry/convex_hull.hpp>
#include <bristle/geometry/fcl_mesh_tree.hpp>
#include <bristle/geometry/support.hpp>
#include <bristle/math/rotation.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace bristle {

/// A triangle of a mesh for the contact clip: corners carry the mesh's vertex numbers, so that
/// neighbours name their common corners and edges alike.
struct MeshTriangle {
  Triangle<double> triangle;
  std::array<std::uint32_t, 3> vertices{};
};

/// What contacts need to know of a closed mesh besides its triangles: who is whose neighbour.
class FclMeshSurface {
 public:
  /// What a direction of contact means to a triangle.
  enum class Verdict {
    /// Contact of the triangle's face: its own normal counts.
    face,
    /// Contact of an edge or corner: the direction counts.
    edge,
    /// The direction leads over an inner edge of a flat face: the face has to be asked as a whole.
    inner_edge,
    /// A neighbour's business, or nobody's.
    none
  };

  /// @pre The mesh is closed (`validate_solid`) and outlives this.
  explicit FclMeshSurface(const FclMeshTree<double>& tree);

  [[nodiscard]] const FclMeshTree<double>& tree() const { return tree_; }
  /// [1] Outward unit normal.
  [[nodiscard]] const Vec3<double>& normal(std::uint32_t triangle) const {
    return normals_[triangle];
  }
  /// [-] Number that all triangles of one flat face share.
  [[nodiscard]] std::uint32_t patch(std::uint32_t triangle) const { return patches_[triangle]; }
  /// The flat face of a triangle as a convex plate: its corners, and as normals those of the face
  /// and of its outer edges. For what support_point and GJK need; it is no solid.
  [[nodiscard]] const ConvexHull<double>& face(std::uint32_t triangle) const {
    return faces_[patches_[triangle]];
  }
  [[nodiscard]] MeshTriangle triangle(std::uint32_t triangle) const {
    return {{tree_.corners(triangle)}, tree_.vertex_numbers(triangle)};
  }

  /// Who answers for a contact of `triangle` along the unit direction n, out of the mesh.
  ///
  /// An edge is touched along n only between the normals of its two faces; beyond, the neighbour is
  /// nearer (its Voronoi region, Mirtich 1998, "V-Clip"). Inner edges of flat faces and hollow
  /// edges are not touched at all, only the faces beside them: without this a body that slides over
  /// a flat mesh stumbles.
  [[nodiscard]] Verdict judge(std::uint32_t triangle, const Vec3<double>& n) const;

 private:
  void find_neighbours();
  void find_patches();
  void find_faces();
  /// [1] Direction in the plane of the neighbour across edge k, away from the neighbour.
  [[nodiscard]] Vec3<double> away_from_neighbour(std::uint32_t triangle, std::size_t k) const;

  enum class Edge : std::uint8_t { convex, flat, hollow };

  FclMeshTree<double> tree_;
  std::vector<Vec3<double>> normals_;
  // Across edge k, from corner k to the next.
  std::vector<std::array<std::uint32_t, 3>> neighbours_;
  std::vector<std::array<Edge, 3>> edges_;
  std::vector<std::uint32_t> patches_;
  std::vector<ConvexHull<double>> faces_;  // By patch.
};

// Implementation -----------------------------------------------------------------------------------

namespace detail {

[[nodiscard]] inline SupportFeature<double> renamed(SupportFeature<double> feature,
                                                    const MeshTriangle& t) {
  for (std::size_t i = 0; i < feature.size; ++i) feature.ids[i] = t.vertices[feature.ids[i]];
  return feature;
}

}  // namespace detail

[[nodiscard]] inline Vec3<double> support_point(const MeshTriangle& t, const Vec3<double>& d) {
  return support_point(t.triangle, d);
}
[[nodiscard]] inline SupportFeature<double> support_edge(const MeshTriangle& t,
                                                         const Vec3<double>& d) {
  return detail::renamed(support_edge(t.triangle, d), t);
}
[[nodiscard]] inline SupportFeature<double> support_face(const MeshTriangle& t,
                                                         const Vec3<double>& d) {
  return detail::renamed(support_face(t.triangle, d), t);
}

namespace detail {

/// [1] Cosine and sine of the angle, 0.01 degrees, within which directions count as equal: what GJK
/// leaves, and less than any edge of a mesh that is not meant to be flat.
inline constexpr double same_direction_cosine = 1.0 - 1.5e-8;
inline constexpr double same_direction_sine = 1.7e-4;
/// [1] Sine of the angle below which two triangles are one flat face: meshes from files are no
/// flatter than single precision.
inline constexpr double flat_sine = static_cast<double>(Tolerance<float>::equal());

[[nodiscard]] inline bool is_same_plane(const Vec3<double>& normal, const Vec3<double>& other) {
  return normal.cross(other).norm() < flat_sine && normal.dot(other) > 0.0;
}

/// Leaves of a plate's points the corners of their outline, and adds the normals of its edges: the
/// monotone chain (Andrew 1979) in the plane.
inline void outline_face(ConvexHull<double>& face) {
  const Vec3<double> n = face.face_normals[0];
  Vec3<double> t1;
  Vec3<double> t2;
  tangent_basis(n, t1, t2);
  std::vector<Vec3<double>>& points = face.vertices;
  std::sort(points.begin(), points.end(), [&](const Vec3<double>& a, const Vec3<double>& b) {
    const double xa = t1.dot(a);
    const double xb = t1.dot(b);
    return xa < xb || (xa == xb && t2.dot(a) < t2.dot(b));
  });
  std::vector<Vec3<double>> outline;
  for (int side = 0; side < 2; ++side) {
    const std::size_t start = outline.size();
    for (const Vec3<double>& p : points) {
      while (outline.size() >= start + 2) {
        const Vec3<double>& last = outline.back();
        const Vec3<double>& before = outline[outline.size() - 2];
        if ((last - before).cross(p - before).dot(n) > 0.0) break;
        outline.pop_back();
      }
      outline.push_back(p);
    }
    outline.pop_back();  // The first of the other side.
    std::reverse(points.begin(), points.end());
  }
  points = std::move(outline);
  for (std::size_t k = 0; k < points.size(); ++k) {
    face.face_normals.push_back(
        (points[(k + 1) % points.size()] - points[k]).cross(n).normalized());
  }
}

}  // namespace detail

inline FclMeshSurface::FclMeshSurface(const FclMeshTree<double>& tree) : tree_(tree) {
  normals_.reserve(tree_.size());
  for (std::uint32_t i = 0; i < tree_.size(); ++i) {
    const auto c = tree_.corners(i);
    normals_.push_back((c[1] - c[0]).cross(c[2] - c[0]).stableNormalized());
  }
  find_neighbours();
  find_patches();
  find_faces();
}

inline void FclMeshSurface::find_neighbours() {
  struct HalfEdge {
    std::uint32_t low, high;
    std::uint32_t triangle;
    std::uint32_t k;
  };
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * tree_.size());
  for (std::uint32_t i = 0; i < tree_.size(); ++i) {
    const auto v = tree_.vertex_numbers(i);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t w = v[(k + 1) % 3];
      half_edges.push_back({std::min(v[k], w), std::max(v[k], w), i, k});
    }
  }
  std::sort(half_edges.begin(), half_edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  neighbours_.resize(tree_.size());
  edges_.resize(tree_.size());
  for (std::size_t i = 0; i + 1 < half_edges.size(); i += 2) {
    const HalfEdge& a = half_edges[i];
    const HalfEdge& b = half_edges[i + 1];
    BRISTLE_ASSERT(a.low == b.low && a.high == b.high);
    neighbours_[a.triangle][a.k] = b.triangle;
    neighbours_[b.triangle][b.k] = a.triangle;
    // How far the neighbour's far corner is below the plane tells convex from hollow.
    const auto corners = tree_.corners(a.triangle);
    const Vec3<double> far = tree_.corners(b.triangle)[(b.k + 2) % 3] - corners[a.k];
    Edge kind = normals_[a.triangle].dot(far) < 0.0 ? Edge::convex : Edge::hollow;
    if (detail::is_same_plane(normals_[a.triangle], normals_[b.triangle])) kind = Edge::flat;
    edges_[a.triangle][a.k] = kind;
    edges_[b.triangle][b.k] = kind;
  }
}

inline void FclMeshSurface::find_patches() {
  constexpr std::uint32_t unknown = 0xffffffffu;
  patches_.assign(tree_.size(), unknown);
  std::vector<std::uint32_t> open;
  std::uint32_t count = 0;
  for (std::uint32_t seed = 0; seed < tree_.size(); ++seed) {
    if (patches_[seed] != unknown) continue;
    patches_[seed] = count;
    open.assign(1, seed);
    while (!open.empty()) {
      const std::uint32_t at = open.back();
      open.pop_back();
      for (const std::uint32_t next : neighbours_[at]) {
        // Compared with the seed, or a finely curved surface would become one patch.
        if (patches_[next] == unknown && detail::is_same_plane(normals_[next], normals_[seed])) {
          patches_[next] = count;
          open.push_back(next);
        }
      }
    }
    ++count;
  }
}

inline void FclMeshSurface::find_faces() {
  for (std::uint32_t i = 0; i < tree_.size(); ++i) {
    if (patches_[i] == faces_.size()) faces_.emplace_back().face_normals = {normals_[i]};
    for (const Vec3<double>& corner : tree_.corners(i)) {
      faces_[patches_[i]].vertices.push_back(corner);
    }
  }
  for (ConvexHull<double>& face : faces_) detail::outline_face(face);
}

inline Vec3<double> FclMeshSurface::away_from_neighbour(std::uint32_t triangle,
                                                        std::size_t k) const {
  const auto corners = tree_.corners(triangle);
  const Vec3<double> along = corners[(k + 1) % 3] - corners[k];
  // The neighbour runs through the edge the other way: its outward side is (-along) x normal.
  return normals_[neighbours_[triangle][k]].cross(along).normalized();
}

inline auto FclMeshSurface::judge(std::uint32_t triangle, const Vec3<double>& n) const -> Verdict {
  const double cosine = n.dot(normals_[triangle]);
  if (cosine >= detail::same_direction_cosine) return Verdict::face;
  const auto corners = tree_.corners(triangle);
  // Edges that lie across n and are farthest along it; where there is none, those of the corner
  // that is.
  std::array<double, 3> height;
  for (std::size_t k = 0; k < 3; ++k) height[k] = n.dot(corners[k] - corners[0]);
  const std::size_t top =
      static_cast<std::size_t>(std::max_element(height.begin(), height.end()) - height.begin());
  std::optional<std::size_t> across;
  for (const std::size_t k : {top, (top + 2) % 3}) {
    const Vec3<double> edge = corners[(k + 1) % 3] - corners[k];
    if (std::abs(edge.dot(n)) <= detail::same_direction_sine * edge.norm()) across = k;
  }
  bool is_over_edge = false;
  for (const std::size_t k : {top, (top + 2) % 3}) {
    if (across && *across != k) continue;
    const Vec3<double> along = corners[(k + 1) % 3] - corners[k];
    const Vec3<double> outwards = along.cross(normals_[triangle]).normalized();
    if (n.dot(outwards) <= detail::same_direction_sine) continue;
    if (edges_[triangle][k] == Edge::flat) return Verdict::inner_edge;
    if (edges_[triangle][k] == Edge::hollow) return Verdict::face;
    if (n.dot(away_from_neighbour(triangle, k)) <= detail::same_direction_sine) {
      return Verdict::none;
    }
    is_over_edge = true;
  }
  if (cosine <= 0.0) return Verdict::none;
  if (!is_over_edge) return Verdict::face;
  return Verdict::edge;
}

}  // namespace bristle
