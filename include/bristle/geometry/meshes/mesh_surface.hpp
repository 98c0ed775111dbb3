/// @file
/// The surface of a solid mesh, with any tree over the triangles. It knows neighbours, flat faces,
/// and the owner of a contact.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/geometry/rays/mesh_rays.hpp>
#include <bristle/geometry/shapes/convex_hull.hpp>
#include <bristle/geometry/shapes/support.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/rotation.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace bristle::inline BRISTLE_ABI::detail {

/// Adjacency of a closed mesh for contacts: the neighbours of each triangle and its flat face.
///
/// @tparam S     Scalar of contacts. May be more precise than the tree's.
/// @tparam Tree  As `MeshTree`: `size()`, `corners(i)`, `vertex_numbers(i)`, `root_box()`,
///               `find(accept, visit)`.
template <Scalar S, typename Tree>
class MeshSurface {
 public:
  /// Meaning of a contact direction for a triangle.
  enum class Verdict {
    /// Contact of the triangle's face: take its own normal.
    face,
    /// Contact of an edge or corner: take the direction.
    edge,
    /// The direction leads over an inner edge of a flat face: query the face as a whole.
    inner_edge,
    /// The contact belongs to a neighbour, or to none.
    none
  };

  /// @pre The mesh is closed (`validate_solid`), outlives this and does not move.
  explicit MeshSurface(const Tree& tree);

  /// [-] Number of triangles.
  [[nodiscard]] std::size_t size() const { return tree_->size(); }
  /// [m] Corners of a triangle, counter-clockwise seen from outside.
  [[nodiscard]] std::array<Vec3<S>, 3> corners(std::uint32_t triangle) const {
    const auto c = tree_->corners(triangle);
    return {c[0].template cast<S>(), c[1].template cast<S>(), c[2].template cast<S>()};
  }
  /// [m] Box around all triangles.
  [[nodiscard]] Aabb<S> bounds() const { return precise(tree_->root_box()); }
  /// Returns whether a point is in the solid, to round-off of the tree's scalar.
  [[nodiscard]] bool contains(const Vec3<S>& point) const {
    using T = typename Tree::ScalarType;
    return is_inside_mesh<T>(*tree_, Vec3<T>(point.template cast<T>()));
  }
  /// Calls `visit(triangle) -> bool` for every triangle whose box `accept(box) -> bool` takes
  /// together with all boxes around it, until a visit returns false.
  template <typename Accept, typename Visit>
  void find(Accept&& accept, Visit&& visit) const {
    tree_->find([&](const auto& box) { return accept(precise(box)); }, visit);
  }
  /// Returns whether the box of some triangle overlaps a box.
  [[nodiscard]] bool comes_near(const Aabb<S>& box) const {
    bool is_near = false;
    find([&](const Aabb<S>& other) { return other.overlaps(box); },
         [&](std::uint32_t) {
           is_near = true;
           return false;
         });
    return is_near;
  }
  /// [1] Outward unit normal.
  [[nodiscard]] const Vec3<S>& normal(std::uint32_t triangle) const { return normals_[triangle]; }
  /// [-] Number that all triangles of one flat face share.
  [[nodiscard]] std::uint32_t patch(std::uint32_t triangle) const { return patches_[triangle]; }
  /// The flat face of a triangle as a convex plate. It has the corners of the face, its normal and
  /// those of its outer edges. It serves support_point and GJK. It is no solid.
  [[nodiscard]] const ConvexHull<S>& face(std::uint32_t triangle) const {
    return faces_[patches_[triangle]];
  }
  /// Returns a triangle. Its ids are vertex numbers of the mesh. So neighbours have the same ids
  /// for common corners and edges.
  [[nodiscard]] Triangle<S> triangle(std::uint32_t triangle) const {
    return {corners(triangle), tree_->vertex_numbers(triangle)};
  }

  /// Tells which feature owns a contact of `triangle` along the unit direction n, out of the mesh.
  ///
  /// An edge is touched along n only between the normals of its two faces. Beyond that the
  /// neighbour is nearer (its Voronoi region, Mirtich 1998, "V-Clip"). Inner edges of flat faces
  /// and hollow edges have no contacts. Only the faces beside them have. Without this rule a body
  /// that slides over a flat mesh stumbles.
  [[nodiscard]] Verdict judge(std::uint32_t triangle, const Vec3<S>& n) const;

  /// Returns whether points behind a triangle are out sooner past a neighbour: all of them are less
  /// deep behind it than the deepest is behind the triangle. Neighbours across hollow edges do not
  /// count.
  [[nodiscard]] bool has_shorter_way_out(std::uint32_t triangle,
                                         std::span<const Vec3<S>> points) const {
    const auto depth_behind = [&](std::uint32_t i) {
      const Vec3<S> on_plane = corners(i)[0];
      S deepest = -infinity<S>;
      for (const Vec3<S>& p : points) deepest = std::max(deepest, normals_[i].dot(on_plane - p));
      return deepest;
    };
    const S depth = depth_behind(triangle);
    for (std::size_t k = 0; k < 3; ++k) {
      if (edges_[triangle][k] == Edge::convex && depth_behind(neighbours_[triangle][k]) < depth) {
        return true;
      }
    }
    return false;
  }

 private:
  template <typename Box>
  [[nodiscard]] static Aabb<S> precise(const Box& box) {
    return {box.lower.template cast<S>(), box.upper.template cast<S>()};
  }
  void find_neighbours();
  void find_patches();
  void find_faces();
  /// [1] Direction in the plane of the neighbour across edge k, away from the neighbour.
  [[nodiscard]] Vec3<S> away_from_neighbour(std::uint32_t triangle, std::size_t k) const;

  enum class Edge : std::uint8_t { convex, flat, hollow };

  const Tree* tree_;
  std::vector<Vec3<S>> normals_;
  // Neighbours across edge k, from corner k to the next.
  std::vector<std::array<std::uint32_t, 3>> neighbours_;
  std::vector<std::array<Edge, 3>> edges_;
  std::vector<std::uint32_t> patches_;
  std::vector<ConvexHull<S>> faces_;  // Indexed by patch.
};

// Implementation ----------------------------------------------------------------------------------

/// [1] Cosine and sine of the angle, 0.01 degrees, within which directions count as equal. It
/// exceeds the error of GJK and is less than any edge of a mesh that is not meant to be flat.
template <Scalar S>
inline constexpr S same_direction_cosine = S(1) - S(1.5e-8);
template <Scalar S>
inline constexpr S same_direction_sine = S(1.7e-4);
/// [1] Sine of the angle below which two triangles are one flat face. Meshes from files are no
/// flatter than single precision.
template <Scalar S>
inline constexpr S flat_sine = S(Tolerance<float>::equal());

template <Scalar S>
[[nodiscard]] bool is_same_plane(const Vec3<S>& normal, const Vec3<S>& other) {
  return normal.cross(other).norm() < flat_sine<S> && normal.dot(other) > S(0);
}

/// Reduces a plate's points to the corners of their outline. Adds the normals of its edges. Uses
/// the monotone chain (Andrew 1979) in the plane.
template <Scalar S>
void outline_face(ConvexHull<S>& face) {
  const Vec3<S> n = face.face_normals[0];
  Vec3<S> t1;
  Vec3<S> t2;
  tangent_basis(n, t1, t2);
  // Each corner once: with a fused multiply-add the cross product of equal vectors is not zero.
  std::vector<Vec3<S>>& corners = face.vertices;
  std::sort(corners.begin(), corners.end(), [](const Vec3<S>& a, const Vec3<S>& b) {
    return std::tie(a[0], a[1], a[2]) < std::tie(b[0], b[1], b[2]);
  });
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  // Keys are computed once. A dot product that a compiler contracts in one place and not in another
  // would give no order (docs/contributing.md).
  struct Place {
    S x, y;
    std::uint32_t corner;
  };
  std::vector<Place> places;
  places.reserve(corners.size());
  for (const Vec3<S>& p : corners) {
    places.push_back({t1.dot(p), t2.dot(p), static_cast<std::uint32_t>(places.size())});
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return std::tie(a.x, a.y, a.corner) < std::tie(b.x, b.y, b.corner);
  });
  std::vector<Vec3<S>> points;
  points.reserve(places.size());
  for (const Place& place : places) points.push_back(corners[place.corner]);
  std::vector<Vec3<S>> outline;
  for (int side = 0; side < 2; ++side) {
    const std::size_t start = outline.size();
    for (const Vec3<S>& p : points) {
      while (outline.size() >= start + 2) {
        const Vec3<S>& last = outline.back();
        const Vec3<S>& before = outline[outline.size() - 2];
        if ((last - before).cross(p - before).dot(n) > S(0)) break;
        outline.pop_back();
      }
      outline.push_back(p);
    }
    outline.pop_back();  // The first of the other side.
    std::reverse(points.begin(), points.end());
  }
  corners = std::move(outline);
  for (std::size_t k = 0; k < corners.size(); ++k) {
    face.face_normals.push_back(
        (corners[(k + 1) % corners.size()] - corners[k]).cross(n).normalized());
  }
}

template <Scalar S, typename Tree>
MeshSurface<S, Tree>::MeshSurface(const Tree& tree) : tree_(&tree) {
  normals_.reserve(size());
  for (std::uint32_t i = 0; i < size(); ++i) {
    const auto c = corners(i);
    normals_.push_back((c[1] - c[0]).cross(c[2] - c[0]).stableNormalized());
  }
  find_neighbours();
  find_patches();
  find_faces();
}

template <Scalar S, typename Tree>
void MeshSurface<S, Tree>::find_neighbours() {
  struct HalfEdge {
    std::uint32_t low, high;
    std::uint32_t triangle;
    std::uint32_t k;
  };
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * size());
  for (std::uint32_t i = 0; i < size(); ++i) {
    const auto v = tree_->vertex_numbers(i);
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t w = v[(k + 1) % 3];
      half_edges.push_back({std::min(v[k], w), std::max(v[k], w), i, k});
    }
  }
  std::sort(half_edges.begin(), half_edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  neighbours_.resize(size());
  edges_.resize(size());
  for (std::size_t i = 0; i + 1 < half_edges.size(); i += 2) {
    const HalfEdge& a = half_edges[i];
    const HalfEdge& b = half_edges[i + 1];
    BRISTLE_ASSERT(a.low == b.low && a.high == b.high);
    neighbours_[a.triangle][a.k] = b.triangle;
    neighbours_[b.triangle][b.k] = a.triangle;
    // The depth of the neighbour's far corner below the plane tells convex from hollow.
    const auto at = corners(a.triangle);
    const Vec3<S> far = corners(b.triangle)[(b.k + 2) % 3] - at[a.k];
    Edge kind = normals_[a.triangle].dot(far) < S(0) ? Edge::convex : Edge::hollow;
    if (is_same_plane(normals_[a.triangle], normals_[b.triangle])) kind = Edge::flat;
    edges_[a.triangle][a.k] = kind;
    edges_[b.triangle][b.k] = kind;
  }
}

template <Scalar S, typename Tree>
void MeshSurface<S, Tree>::find_patches() {
  constexpr std::uint32_t unknown = 0xffffffffu;
  patches_.assign(size(), unknown);
  std::vector<std::uint32_t> open;
  std::uint32_t count = 0;
  for (std::uint32_t seed = 0; seed < size(); ++seed) {
    if (patches_[seed] != unknown) continue;
    patches_[seed] = count;
    open.assign(1, seed);
    while (!open.empty()) {
      const std::uint32_t at = open.back();
      open.pop_back();
      for (const std::uint32_t next : neighbours_[at]) {
        // Compared with the seed: otherwise a finely curved surface would become one patch.
        if (patches_[next] == unknown && is_same_plane(normals_[next], normals_[seed])) {
          patches_[next] = count;
          open.push_back(next);
        }
      }
    }
    ++count;
  }
}

template <Scalar S, typename Tree>
void MeshSurface<S, Tree>::find_faces() {
  for (std::uint32_t i = 0; i < size(); ++i) {
    if (patches_[i] == faces_.size()) faces_.emplace_back().face_normals = {normals_[i]};
    for (const Vec3<S>& corner : corners(i)) {
      faces_[patches_[i]].vertices.push_back(corner);
    }
  }
  for (ConvexHull<S>& face : faces_) outline_face(face);
}

template <Scalar S, typename Tree>
Vec3<S> MeshSurface<S, Tree>::away_from_neighbour(std::uint32_t triangle, std::size_t k) const {
  const auto c = corners(triangle);
  const Vec3<S> along = c[(k + 1) % 3] - c[k];
  // The neighbour runs through the edge the other way: its outward side is (-along) x normal.
  return normals_[neighbours_[triangle][k]].cross(along).normalized();
}

template <Scalar S, typename Tree>
auto MeshSurface<S, Tree>::judge(std::uint32_t triangle, const Vec3<S>& n) const -> Verdict {
  using std::abs;
  const S cosine = n.dot(normals_[triangle]);
  if (cosine >= same_direction_cosine<S>) return Verdict::face;
  const auto c = corners(triangle);
  // Takes edges across n that are farthest along it, or else those of the farthest corner.
  std::array<S, 3> height;
  for (std::size_t k = 0; k < 3; ++k) height[k] = n.dot(c[k] - c[0]);
  const std::size_t top =
      static_cast<std::size_t>(std::max_element(height.begin(), height.end()) - height.begin());
  std::optional<std::size_t> across;
  for (const std::size_t k : {top, (top + 2) % 3}) {
    const Vec3<S> edge = c[(k + 1) % 3] - c[k];
    if (abs(edge.dot(n)) <= same_direction_sine<S> * edge.norm()) across = k;
  }
  bool is_over_edge = false;
  for (const std::size_t k : {top, (top + 2) % 3}) {
    if (across && *across != k) continue;
    const Vec3<S> along = c[(k + 1) % 3] - c[k];
    const Vec3<S> outwards = along.cross(normals_[triangle]).normalized();
    if (n.dot(outwards) <= same_direction_sine<S>) continue;
    if (edges_[triangle][k] == Edge::flat) return Verdict::inner_edge;
    if (edges_[triangle][k] == Edge::hollow) return cosine > S(0) ? Verdict::face : Verdict::none;
    if (n.dot(away_from_neighbour(triangle, k)) <= same_direction_sine<S>) {
      return Verdict::none;
    }
    is_over_edge = true;
  }
  if (cosine <= S(0)) return Verdict::none;
  if (!is_over_edge) return Verdict::face;
  return Verdict::edge;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
