/// @file
/// Contacts of triangle meshes that FCL holds: with convex solids, half-spaces and each other.
///
/// FCL finds the triangles (its tree is walked, with the margin added) and, by GJK, the direction in
/// which each is touched. What FCL itself reports for a mesh has no meaningful depth (fcl#106, #491,
/// #574) and is not used.
///
/// Limits, all of them of the triangle-by-triangle view: a solid that is deeper in than a triangle
/// is wide is pushed out along the nearest triangle's normal or not at all, and one that is wholly
/// inside, touching no triangle, is not seen. Simulate with steps in which nothing gets that deep.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contact_clip.hpp>
#include <bristle/geometry/fcl_contact_normal.hpp>
#include <bristle/geometry/fcl_contact_sink.hpp>
#include <bristle/geometry/fcl_mesh_tree.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <tuple>
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
  [[nodiscard]] MeshTriangle triangle(std::uint32_t triangle) const {
    return {{tree_.corners(triangle)}, tree_.vertex_numbers(triangle)};
  }

  /// Who answers for a contact of `triangle` along the unit direction n, out of the mesh.
  ///
  /// An edge is touched along n only between the normals of its two faces; beyond, the neighbour is
  /// nearer (its Voronoi region, Mirtich 1998, "V-Clip"). Flat and hollow edges are not touched at
  /// all, only the faces beside them: without this a body that slides over a flat mesh stumbles over
  /// its inner edges.
  [[nodiscard]] Verdict judge(std::uint32_t triangle, const Vec3<double>& n) const;

 private:
  void find_neighbours();
  void find_patches();
  /// [1] Direction in the plane of the neighbour across edge k, away from the neighbour.
  [[nodiscard]] Vec3<double> away_from_neighbour(std::uint32_t triangle, std::size_t k) const;

  enum class Edge : std::uint8_t { convex, flat, hollow };

  FclMeshTree<double> tree_;
  std::vector<Vec3<double>> normals_;
  // Across edge k, from corner k to the next.
  std::vector<std::array<std::uint32_t, 3>> neighbours_;
  std::vector<std::array<Edge, 3>> edges_;
  std::vector<std::uint32_t> patches_;
};

/// Adds the contacts of a mesh with a convex solid that stands at X_MC in the mesh's frame, with
/// normals from the mesh to the solid. `shape` is what `convex` was made from.
template <Scalar S, typename ConvexShape>
void collide_mesh(const FclMeshSurface& mesh, const ConvexShape& shape, const FclConvex& convex,
                  const Transform<double>& X_MC, double margin, ContactSink<S>& sink);

/// The same for two meshes, B standing at X_AB. O(triangles of B near A).
template <Scalar S>
void collide_meshes(const FclMeshSurface& a, const FclMeshSurface& b, const Transform<double>& X_AB,
                    double margin, ContactSink<S>& sink);

/// Adds the vertices of a mesh that are within `margin` of the half-space below `plane`, which
/// is given in the mesh's frame. Normals point from the half-space to the mesh.
template <Scalar S>
void collide_mesh(const FclMeshSurface& mesh, const HalfSpace<double>& plane, double margin,
                  ContactSink<S>& sink);

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
/// [1] Sine of the angle below which two triangles are one flat face: meshes from files are no flatter
/// than single precision.
inline constexpr double flat_sine = static_cast<double>(Tolerance<float>::equal());

}  // namespace detail

inline FclMeshSurface::FclMeshSurface(const FclMeshTree<double>& tree) : tree_(tree) {
  normals_.reserve(tree_.size());
  for (std::uint32_t i = 0; i < tree_.size(); ++i) {
    const auto c = tree_.corners(i);
    normals_.push_back((c[1] - c[0]).cross(c[2] - c[0]).stableNormalized());
  }
  find_neighbours();
  find_patches();
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
    if (normals_[a.triangle].cross(normals_[b.triangle]).norm() < detail::flat_sine &&
        normals_[a.triangle].dot(normals_[b.triangle]) > 0.0) {
      kind = Edge::flat;
    }
    edges_[a.triangle][a.k] = kind;
    edges_[b.triangle][b.k] = kind;
  }
}

inline void FclMeshSurface::find_patches() {
  constexpr std::uint32_t unknown = 0xffffffffu;
  patches_.assign(tree_.size(), unknown);
  std::vector<std::uint32_t> open;
  for (std::uint32_t seed = 0; seed < tree_.size(); ++seed) {
    if (patches_[seed] != unknown) continue;
    patches_[seed] = seed;
    open.assign(1, seed);
    while (!open.empty()) {
      const std::uint32_t at = open.back();
      open.pop_back();
      for (const std::uint32_t next : neighbours_[at]) {
        // Compared with the seed, or a finely curved surface would become one patch.
        if (patches_[next] == unknown &&
            normals_[next].cross(normals_[seed]).norm() < detail::flat_sine &&
            normals_[next].dot(normals_[seed]) > 0.0) {
          patches_[next] = seed;
          open.push_back(next);
        }
      }
    }
  }
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
  // Edges that lie across n and are farthest along it; where there is none, those of the corner that
  // is.
  std::array<double, 3> height;
  for (std::size_t k = 0; k < 3; ++k) height[k] = n.dot(corners[k] - corners[0]);
  const std::size_t top = static_cast<std::size_t>(
      std::max_element(height.begin(), height.end()) - height.begin());
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
    if (edges_[triangle][k] != Edge::convex) return Verdict::face;
    if (n.dot(away_from_neighbour(triangle, k)) <= detail::same_direction_sine) {
      return Verdict::none;
    }
    is_over_edge = true;
  }
  if (cosine <= 0.0) return Verdict::none;
  if (!is_over_edge) return Verdict::face;
  return Verdict::edge;
}

namespace detail {

/// The box around a convex solid in another frame.
[[nodiscard]] inline Aabb<double> bounds_in(const FclConvex& convex, const Transform<double>& X) {
  const Mat3<double> R = X.rotation_matrix();
  Aabb<double> box;
  for (int i = 0; i < 3; ++i) {
    const Vec3<double> d = R.row(i).transpose();
    box.upper[i] = d.dot(convex.support(d)) + convex.rounding + X.translation[i];
    box.lower[i] = d.dot(convex.support(-d)) - convex.rounding + X.translation[i];
  }
  return box;
}

/// The side of a contact that is a convex solid: any normal suits it.
struct ConvexOpposite {
  [[nodiscard]] FclMeshSurface::Verdict judge(const Vec3<double>&) const {
    return FclMeshSurface::Verdict::edge;
  }
  [[nodiscard]] std::uint32_t key() const { return 1; }
  [[nodiscard]] double depth() const { return 0.0; }
};

/// The side of a contact that is a triangle of a mesh B, asked in the frame of A.
struct MeshOpposite {
  const FclMeshSurface& mesh;
  std::uint32_t triangle;
  const Transform<double>& X_BA;
  double largest_depth;

  [[nodiscard]] FclMeshSurface::Verdict judge(const Vec3<double>& n) const {
    return mesh.judge(triangle, -X_BA.rotate(n));
  }
  [[nodiscard]] std::uint32_t key() const { return mix(mesh.patch(triangle), 2); }
  [[nodiscard]] double depth() const { return largest_depth; }
};

/// The contacts of one convex solid with one mesh, triangle by triangle.
template <Scalar S, typename ConvexShape>
class MeshConvexContacts {
 public:
  MeshConvexContacts(const FclMeshSurface& mesh, const ConvexShape& shape, const FclConvex& convex,
                     const Transform<double>& X_MC, double margin, ContactSink<S>& sink)
      : mesh_(mesh), shape_(shape), convex_(convex), X_MC_(X_MC), margin_(margin), sink_(sink) {}

  /// @param opposite  Of the other side: `judge(n) -> Verdict`, what a normal means to it, the `key()`
  ///                  of its face, and for surfaces the `depth()` [m] up to which two of them may
  ///                  have passed through each other.
  template <typename Opposite>
  void add_all(const Opposite& opposite) {
    bool is_any = false;
    const double reach = std::max(margin_, opposite.depth());
    mesh_.tree().overlap(bounds_in(convex_, X_MC_).inflated(reach), [&](std::uint32_t i) {
      is_any = add(i, opposite) || is_any;
      return true;
    });
    if (is_any || !fallback_) return;
    sink_.add(face_manifold(*fallback_));
  }

 private:
  using Verdict = FclMeshSurface::Verdict;

  template <typename Opposite>
  bool add(std::uint32_t i, const Opposite& opposite) {
    const MeshTriangle triangle = mesh_.triangle(i);
    const FclConvex plate = fcl_convex(triangle.triangle);
    const FclContactNormal found =
        fcl_contact_normal(plate, convex_, X_MC_, std::max(margin_, opposite.depth()));
    if (found.nearness != FclNearness::near) return false;
    const Vec3<double>& face_normal = mesh_.normal(i);
    const bool is_behind = found.normal.dot(face_normal) <= 0.0;
    if (is_behind && opposite.depth() > 0.0) return add_passed(i, opposite);
    const Verdict verdict = mesh_.judge(i, found.normal);
    if (verdict == Verdict::none) {
      if (is_behind) note_fallback(i, triangle.triangle);
      return false;
    }
    if (found.gap > margin_) return false;
    const Vec3<double>& normal = verdict == Verdict::face ? face_normal : found.normal;
    const Verdict other_verdict = opposite.judge(normal);
    if (other_verdict == Verdict::none) return false;
    ContactManifold<double> manifold;
    if (verdict == Verdict::face) {
      manifold = face_manifold(i);
    } else {
      manifold = contact_manifold(triangle, shape_, X_MC_, normal, margin_);
      manifold.key = other_verdict == Verdict::face
                         ? opposite.key()
                         : mix(edge_name(triangle, normal), opposite.key());
    }
    sink_.add(manifold);
    return manifold.size > 0;
  }

  /// Two surfaces that have passed through each other face to face: as plates they are apart, each
  /// on the wrong side of the other.
  template <typename Opposite>
  bool add_passed(std::uint32_t i, const Opposite& opposite) {
    const Vec3<double>& n = mesh_.normal(i);
    const double gap = n.dot(deepest_place(n) - mesh_.tree().corners(i)[0]);
    if (gap < -opposite.depth() || opposite.judge(n) != Verdict::face) return false;
    const ContactManifold<double> manifold = face_manifold(i);
    sink_.add(manifold);
    return manifold.size > 0;
  }

  /// What of the solid is over the triangle, along its normal. Empty where nothing is.
  [[nodiscard]] ContactManifold<double> face_manifold(std::uint32_t i) const {
    const MeshTriangle triangle = mesh_.triangle(i);
    const Vec3<double>& n = mesh_.normal(i);
    const auto features = feature_pair(triangle, shape_, X_MC_, n);
    const ContactManifold<double> clipped = clip_features(features.a, features.b, n, margin_);
    ContactManifold<double> manifold;
    manifold.normal = n;
    manifold.key = mix(mesh_.patch(i), 0);
    double gap = margin_;
    for (std::size_t k = 0; k < clipped.size; ++k) {
      const ContactPoint<double>& point = clipped.points[k];
      if (!is_over(triangle.triangle, n, point.position)) continue;
      manifold.add(point);
      gap = std::min(gap, point.gap);
    }
    // Rims of round shapes are clipped as polygons; what is deepest may lie between their corners.
    const ContactPoint<double> deepest = extreme_contact(triangle, shape_, X_MC_, n);
    if (deepest.gap < gap - Tolerance<double>::equal() * convex_.reach &&
        is_over(triangle.triangle, n, deepest_place(n))) {
      if (manifold.size == manifold.capacity) --manifold.size;
      manifold.add({deepest_place(n) - 0.5 * deepest.gap * n, deepest.gap, 0});
    }
    return manifold;
  }

  /// [m] The solid's farthest point against n.
  [[nodiscard]] Vec3<double> deepest_place(const Vec3<double>& n) const {
    return X_MC_ * support_point(shape_, Vec3<double>(X_MC_.rotation.conjugate() * Vec3<double>(-n)));
  }

  /// Whether a point is above or below a triangle of normal n, its edges and a hair beyond included.
  [[nodiscard]] static bool is_over(const Triangle<double>& triangle, const Vec3<double>& n,
                                    const Vec3<double>& point) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<double> edge = triangle.corners[(k + 1) % 3] - triangle.corners[k];
      const double beside = edge.cross(point - triangle.corners[k]).dot(n);
      if (beside < -Tolerance<double>::equal() * edge.squaredNorm()) return false;
    }
    return true;
  }

  /// A solid whose middle is behind the triangle: the plate would be left on the wrong side. Of all
  /// triangles in front of the middle the one least deep under counts, if no other is touched.
  void note_fallback(std::uint32_t i, const Triangle<double>& triangle) {
    const Vec3<double> middle = X_MC_ * convex_.center;
    const Vec3<double>& n = mesh_.normal(i);
    const double depth = n.dot(triangle.corners[0] - middle);
    if (!(depth >= 0.0 && depth < fallback_depth_)) return;
    if (!is_over(triangle, n, middle)) return;
    fallback_ = i;
    fallback_depth_ = depth;
  }

  /// Name of the edge or corner of a triangle that is farthest along n.
  [[nodiscard]] static std::uint32_t edge_name(const MeshTriangle& triangle,
                                               const Vec3<double>& n) {
    const SupportFeature<double> edge = support_edge(triangle, n);
    return mix_unordered(edge.ids[0], edge.ids[edge.size - 1]);
  }

  const FclMeshSurface& mesh_;
  const ConvexShape& shape_;
  const FclConvex& convex_;
  const Transform<double>& X_MC_;
  double margin_;
  ContactSink<S>& sink_;
  std::optional<std::uint32_t> fallback_;
  double fallback_depth_ = infinity<double>;
};

}  // namespace detail

template <Scalar S, typename ConvexShape>
void collide_mesh(const FclMeshSurface& mesh, const ConvexShape& shape, const FclConvex& convex,
                  const Transform<double>& X_MC, double margin, ContactSink<S>& sink) {
  sink.set_nearest(Tolerance<double>::equal() * convex.reach);
  detail::MeshConvexContacts<S, ConvexShape> contacts(mesh, shape, convex, X_MC, margin, sink);
  contacts.add_all(detail::ConvexOpposite{});
}

template <Scalar S>
void collide_meshes(const FclMeshSurface& a, const FclMeshSurface& b, const Transform<double>& X_AB,
                    double margin, ContactSink<S>& sink) {
  const Transform<double> X_BA = X_AB.inverse();
  // At half the thickness of the thinner one, in and out cannot be told apart.
  const double depth = std::min(a.tree().root_box().half_extents().minCoeff(),
                                b.tree().root_box().half_extents().minCoeff());
  const Aabb<double> near =
      transformed(a.tree().root_box(), X_BA).inflated(std::max(margin, depth));
  b.tree().overlap(near, [&](std::uint32_t i) {
    const MeshTriangle triangle = b.triangle(i);
    const FclConvex plate = fcl_convex(triangle.triangle);
    sink.set_nearest(Tolerance<double>::equal() * plate.reach);
    detail::MeshConvexContacts<S, MeshTriangle> contacts(a, triangle, plate, X_AB, margin, sink);
    contacts.add_all(detail::MeshOpposite{b, i, X_BA, depth});
    return true;
  });
}

template <Scalar S>
void collide_mesh(const FclMeshSurface& mesh, const HalfSpace<double>& plane, double margin,
                  ContactSink<S>& sink) {
  sink.set_nearest(0.0);
  const Vec3<double>& n = plane.normal;
  const auto height = [&](const Vec3<double>& p) { return n.dot(p) - plane.offset; };
  ContactManifold<double> one;
  one.normal = n;
  one.size = 1;
  mesh.tree().find(
      [&](const Aabb<double>& box) {
        return height((n.array() < 0.0).select(box.upper, box.lower)) <= margin;
      },
      [&](std::uint32_t i) {
        const MeshTriangle triangle = mesh.triangle(i);
        for (std::size_t k = 0; k < 3; ++k) {
          const Vec3<double>& corner = triangle.triangle.corners[k];
          const double gap = height(corner);
          if (!(gap <= margin)) continue;
          one.points[0] = {corner - 0.5 * gap * n, gap, triangle.vertices[k]};
          sink.add(one);
        }
        return true;
      });
}

}  // namespace bristle
