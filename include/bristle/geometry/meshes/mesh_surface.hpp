/// @file
/// The surface of a solid mesh for contacts: convex plates in a tree, flat faces, and the owner of
/// a contact.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/core/dynamic_array.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/meshes/mesh_plates.hpp>
#include <bristle/geometry/rays/mesh_rays.hpp>
#include <bristle/geometry/shapes/convex_hull.hpp>
#include <bristle/geometry/shapes/support.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/geometry/trees/aabb_tree.hpp>
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

/// The plates of a closed mesh (mesh_plates.hpp), found by box.
///
/// @tparam S     Scalar of contacts. May be more precise than the tree's.
/// @tparam Tree  As `MeshTree`: `size()`, `corners(i)`, `vertex_numbers(i)`, `root_box()`,
///               `walk_ray(ray, visit)`.
template <Scalar S, typename Tree>
class MeshSurface {
 public:
  /// Region of directions around a plate, which tells the feature that a contact belongs to.
  enum class Region {
    /// Contact of the plate's face: take its own normal.
    face,
    /// Contact of an edge or corner: take the direction.
    edge,
    /// The direction leads over an inner edge of a flat face: query the face as a whole.
    inner_edge,
    /// The contact belongs to a neighbour, or to none.
    none
  };

  /// @pre The mesh is closed (`validate_solid`), outlives this and does not move.
  explicit MeshSurface(const Tree& mesh);

  /// [-] Number of plates.
  [[nodiscard]] std::size_t size() const { return plates_.size(); }
  /// Returns a plate. Its names are vertex numbers of the mesh.
  [[nodiscard]] Plate<S> plate(std::uint32_t i) const { return plates_.plate(i); }
  /// [m] Box around all plates.
  [[nodiscard]] Aabb<S> bounds() const { return tree_.root_box(); }
  /// Returns whether a point is in the solid, to round-off of the mesh's scalar.
  [[nodiscard]] bool contains(const Vec3<S>& point) const {
    using T = typename Tree::ScalarType;
    return is_inside_mesh<T>(*mesh_, Vec3<T>(point.template cast<T>()));
  }
  /// Calls `visit(plate) -> bool` for every plate whose box `accept(box) -> bool` takes together
  /// with all boxes around it, until a visit returns false.
  template <typename Accept, typename Visit>
  void find(Accept&& accept, Visit&& visit) const {
    tree_.find(accept, visit);
  }
  /// Returns whether the box of some plate overlaps a box.
  [[nodiscard]] bool comes_near(const Aabb<S>& box) const {
    bool is_near = false;
    tree_.overlap(box, [&](std::uint32_t) {
      is_near = true;
      return false;
    });
    return is_near;
  }
  /// [1] Outward unit normal of a plate.
  [[nodiscard]] const Vec3<S>& normal(std::uint32_t plate) const { return plates_.normal(plate); }
  /// Returns whether edge k of a plate, which runs from corner k to the next, is inside a flat
  /// face.
  [[nodiscard]] bool is_inner_edge(std::uint32_t plate, std::size_t k) const {
    return plates_.is_inner_edge(plate, k);
  }
  /// [-] Name of the edge or corner of a plate that is farthest along n. An edge has that of its
  /// crease, so that both sides of it have one contact.
  [[nodiscard]] std::uint32_t edge_name(std::uint32_t plate, const Vec3<S>& n) const;
  /// [m] Round-off of the plates. Between two of a face there may be as much.
  [[nodiscard]] S hair() const { return plates_.hair(); }
  /// [-] Number that all plates of one flat face share.
  [[nodiscard]] std::uint32_t face_number(std::uint32_t plate) const { return plates_.face(plate); }
  /// The flat face of a plate as a convex whole. It has the corners of the face, its normal and
  /// those of its outer edges. It serves support_point and GJK. It is no solid.
  [[nodiscard]] const ConvexHull<S>& face(std::uint32_t plate) const {
    return faces_[plates_.face(plate)];
  }

  /// Tells which feature owns a contact of a plate along the unit direction n, out of the mesh.
  ///
  /// An edge is touched along n only between the normals of its two faces. Beyond that the
  /// neighbour is nearer (its Voronoi region, Mirtich 1998, "V-Clip"). Inner edges of flat faces
  /// and hollow edges have no contacts. Only the faces beside them have. Without this rule a body
  /// that slides over a flat mesh stumbles.
  [[nodiscard]] Region region_of(std::uint32_t plate, const Vec3<S>& n) const;

  /// Returns whether points behind a plate are out sooner past a neighbour: all of them are less
  /// deep behind it than the deepest is behind the plate. Neighbours across hollow edges do not
  /// count.
  [[nodiscard]] bool has_shorter_way_out(std::uint32_t plate,
                                         std::span<const Vec3<S>> points) const {
    const auto depth_behind = [&](std::uint32_t i) {
      const Plate<S> in_front = plates_.plate(i);
      S deepest = -infinity<S>;
      for (const Vec3<S>& p : points) {
        deepest = std::max(deepest, in_front.normal.dot(in_front.corners[0] - p));
      }
      return deepest;
    };
    const S depth = depth_behind(plate);
    for (std::size_t k = 0; k < plates_.plate(plate).corners.size(); ++k) {
      if (plates_.edge(plate, k) == SurfaceEdge::convex &&
          depth_behind(plates_.neighbour(plate, k)) < depth) {
        return true;
      }
    }
    return false;
  }

 private:
  void find_faces();
  /// [1] Direction in the plane of the neighbour across edge k, away from the neighbour.
  [[nodiscard]] Vec3<S> away_from_neighbour(std::uint32_t plate, std::size_t k) const;

  const Tree* mesh_;
  MeshPlates<S> plates_;
  AabbTree<S> tree_;  // Payloads are numbers of plates.
  DynamicArray<ConvexHull<S>> faces_;
};

// Implementation ----------------------------------------------------------------------------------

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
  DynamicArray<Place> places;
  places.reserve(corners.size());
  for (const Vec3<S>& p : corners) {
    places.push_back({t1.dot(p), t2.dot(p), static_cast<std::uint32_t>(places.size())});
  }
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return std::tie(a.x, a.y, a.corner) < std::tie(b.x, b.y, b.corner);
  });
  DynamicArray<Vec3<S>> points;
  points.reserve(places.size());
  for (const Place& place : places) points.push_back(corners[place.corner]);
  DynamicArray<Vec3<S>> outline;
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
  corners.assign(outline.begin(), outline.end());
  for (std::size_t k = 0; k < corners.size(); ++k) {
    face.face_normals.push_back(
        (corners[(k + 1) % corners.size()] - corners[k]).cross(n).normalized());
  }
}

template <Scalar S, typename Tree>
MeshSurface<S, Tree>::MeshSurface(const Tree& mesh) : mesh_(&mesh), plates_(mesh) {
  DynamicArray<Aabb<S>> boxes(size());
  for (std::uint32_t i = 0; i < size(); ++i) {
    for (const Vec3<S>& corner : plates_.plate(i).corners) boxes[i].include(corner);
  }
  tree_.build(boxes);
  find_faces();
}

template <Scalar S, typename Tree>
void MeshSurface<S, Tree>::find_faces() {
  faces_.resize(plates_.face_count());
  for (std::uint32_t i = 0; i < size(); ++i) {
    ConvexHull<S>& face = faces_[plates_.face(i)];
    if (face.face_normals.empty()) face.face_normals = {plates_.normal(i)};
    const Plate<S> plate = plates_.plate(i);
    face.vertices.insert(face.vertices.end(), plate.corners.begin(), plate.corners.end());
  }
  for (ConvexHull<S>& face : faces_) outline_face(face);
}

template <Scalar S, typename Tree>
Vec3<S> MeshSurface<S, Tree>::away_from_neighbour(std::uint32_t plate, std::size_t k) const {
  const std::span<const Vec3<S>> c = plates_.plate(plate).corners;
  const Vec3<S> along = c[(k + 1) % c.size()] - c[k];
  // The neighbour runs through the edge the other way: its outward side is (-along) x normal.
  return plates_.normal(plates_.neighbour(plate, k)).cross(along).normalized();
}

template <Scalar S, typename Tree>
std::uint32_t MeshSurface<S, Tree>::edge_name(std::uint32_t plate, const Vec3<S>& n) const {
  const Plate<S> of = plates_.plate(plate);
  const SupportFeature<S> edge = support_edge(of, n);
  if (edge.size == 1) return 2 * edge.ids[0];
  const std::size_t count = of.names.size();
  std::size_t k = 0;
  while (of.names[k] != edge.ids[0]) ++k;
  if (of.names[(k + 1) % count] != edge.ids[1]) k = (k + count - 1) % count;
  return 2 * plates_.crease(plate, k) + 1;
}

template <Scalar S, typename Tree>
auto MeshSurface<S, Tree>::region_of(std::uint32_t plate, const Vec3<S>& n) const -> Region {
  using std::abs;
  const Vec3<S>& normal = plates_.normal(plate);
  const S cosine = n.dot(normal);
  if (cosine >= S(1) - S(chosen::same_direction_versine)) return Region::face;
  const std::span<const Vec3<S>> c = plates_.plate(plate).corners;
  const std::size_t count = c.size();
  // Takes edges across n that are farthest along it, or else those of the farthest corner.
  const std::size_t top = farthest_corner<S>(c, n);
  const std::array<std::size_t, 2> sides{top, (top + count - 1) % count};
  std::optional<std::size_t> across;
  for (const std::size_t k : sides) {
    const Vec3<S> edge = c[(k + 1) % count] - c[k];
    if (abs(edge.dot(n)) <= S(chosen::same_direction_sine) * edge.norm()) across = k;
  }
  bool is_over_edge = false;
  for (const std::size_t k : sides) {
    if (across && *across != k) continue;
    const Vec3<S> along = c[(k + 1) % count] - c[k];
    const Vec3<S> outwards = along.cross(normal).normalized();
    if (n.dot(outwards) <= S(chosen::same_direction_sine)) continue;
    const SurfaceEdge edge = plates_.edge(plate, k);
    if (edge == SurfaceEdge::flat) return Region::inner_edge;
    if (edge == SurfaceEdge::hollow) return cosine > S(0) ? Region::face : Region::none;
    if (n.dot(away_from_neighbour(plate, k)) <= S(chosen::same_direction_sine)) {
      return Region::none;
    }
    is_over_edge = true;
  }
  if (cosine <= S(0)) return Region::none;
  if (!is_over_edge) return Region::face;
  return Region::edge;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
