/// @file
/// Contacts of triangle meshes that FCL holds: with convex solids, half-spaces and each other.
///
/// FCL finds the triangles (its tree is walked, with the margin added) and, by GJK, the direction
/// in which each is touched. What FCL itself reports for a mesh has no meaningful depth (fcl#106,
/// #491, #574) and is not used.
///
/// Limits, all of them of the triangle-by-triangle view. A convex solid that the surface cuts
/// always has a contact, but a deep one may get the normal of the nearest triangle instead of the
/// shortest way out; a solid wholly inside, cut by no triangle, is not seen. Two meshes get
/// contacts up to a depth of half the thickness of the thinner one; where they meet corner to
/// corner, faces beside the corners may answer too (one pose in thirty in tests). Cost: a GJK for
/// each triangle near the other solid (0.5 to 2 us), and for each near pair of two meshes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contact_clip.hpp>
#include <bristle/geometry/fcl_contact_normal.hpp>
#include <bristle/geometry/fcl_contact_sink.hpp>
#include <bristle/geometry/fcl_mesh_surface.hpp>
#include <bristle/geometry/fcl_mesh_tree.hpp>
#include <bristle/geometry/mesh_rays.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace bristle {

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
  [[nodiscard]] bool is_facing(const Vec3<double>&) const { return false; }
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
  /// Whether the triangle looks against n, within 25 degrees: tilted more, surfaces that pass
  /// through each other cut each other, and need no help.
  [[nodiscard]] bool is_facing(const Vec3<double>& n) const {
    return X_BA.rotate(n).dot(mesh.normal(triangle)) < -0.9;
  }
};

/// The contacts of one convex solid with one mesh, triangle by triangle.
template <Scalar S, typename ConvexShape>
class MeshConvexContacts {
 public:
  MeshConvexContacts(const FclMeshSurface& mesh, const ConvexShape& shape, const FclConvex& convex,
                     const Transform<double>& X_MC, double margin, ContactSink<S>& sink)
      : mesh_(mesh), shape_(shape), convex_(convex), X_MC_(X_MC), margin_(margin), sink_(sink) {}

  /// @param opposite  Of the other side: `judge(n) -> Verdict`, what a normal means to it, the
  /// `key()`
  ///                  of its face, and for surfaces the `depth()` [m] up to which two of them that
  ///                  are `is_facing(n)` may have passed through each other.
  template <typename Opposite>
  void add_all(const Opposite& opposite) {
    bool is_any = false;
    const double reach = std::max(margin_, opposite.depth());
    mesh_.tree().overlap(bounds_in(convex_, X_MC_).inflated(reach), [&](std::uint32_t i) {
      is_any = add(i, opposite) || is_any;
      return true;
    });
    // Surfaces get none: triangle by triangle it would find contacts where there are better ones.
    if (!is_any && !(opposite.depth() > 0.0)) add_last_resort();
  }

 private:
  using Verdict = FclMeshSurface::Verdict;

  template <typename Opposite>
  bool add(std::uint32_t i, const Opposite& opposite) {
    const MeshTriangle triangle = mesh_.triangle(i);
    const FclConvex plate = fcl_convex(triangle.triangle);
    FclContactNormal found =
        fcl_contact_normal(plate, convex_, X_MC_, std::max(margin_, opposite.depth()));
    if (found.nearness != FclNearness::near) return false;
    if (found.gap < 0.0 && found.gap > plate_contact_.gap) {
      plate_ = i;
      plate_contact_ = found;
    }
    const Vec3<double>& face_normal = mesh_.normal(i);
    bool is_behind = found.normal.dot(face_normal) <= 0.0;
    if (is_behind && opposite.depth() > 0.0) return add_passed(i, opposite);
    Verdict verdict = mesh_.judge(i, found.normal);
    if (verdict == Verdict::inner_edge) {
      found = fcl_contact_normal(fcl_convex(mesh_.face(i)), convex_, X_MC_, margin_);
      if (found.nearness != FclNearness::near) return false;
      is_behind = found.normal.dot(face_normal) <= 0.0;
      verdict = mesh_.judge(i, found.normal);
      // Still: the face is touched at another of its triangles.
      if (verdict == Verdict::inner_edge) return false;
    }
    if (verdict == Verdict::none) {
      if (is_behind) note_way_out(i, triangle.triangle);
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
    if (gap < -opposite.depth() || !opposite.is_facing(n)) return false;
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
    return X_MC_ *
           support_point(shape_, Vec3<double>(X_MC_.rotation.conjugate() * Vec3<double>(-n)));
  }

  /// Whether a point is above or below a triangle of normal n, its edges and a hair beyond
  /// included.
  [[nodiscard]] static bool is_over(const Triangle<double>& triangle, const Vec3<double>& n,
                                    const Vec3<double>& point) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<double> edge = triangle.corners[(k + 1) % 3] - triangle.corners[k];
      const double beside = edge.cross(point - triangle.corners[k]).dot(n);
      if (beside < -Tolerance<double>::equal() * edge.squaredNorm()) return false;
    }
    return true;
  }

  /// Remembers the face through which a solid whose middle has got inside leaves soonest.
  void note_way_out(std::uint32_t i, const Triangle<double>& triangle) {
    const Vec3<double> middle = X_MC_ * convex_.center;
    const Vec3<double>& n = mesh_.normal(i);
    const double depth = n.dot(triangle.corners[0] - middle);
    if (!(depth >= 0.0 && depth < way_out_depth_)) return;
    if (!is_over(triangle, n, middle)) return;
    way_out_ = i;
    way_out_depth_ = depth;
  }

  /// The surface cuts the solid, but at every triangle the shortest way off it, being only a local
  /// one, was a neighbour's business. A contact there must be, or the solid falls through.
  void add_last_resort() {
    if (way_out_ && is_inside_mesh<double>(mesh_.tree(), X_MC_ * convex_.center)) {
      sink_.add(face_manifold(*way_out_));
    } else if (plate_) {
      const MeshTriangle triangle = mesh_.triangle(*plate_);
      const Vec3<double>& n = plate_contact_.normal;
      ContactManifold<double> manifold = contact_manifold(triangle, shape_, X_MC_, n, margin_);
      manifold.key = mix(edge_name(triangle, n), 1);
      sink_.add(manifold);
    }
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
  // For the last resort.
  std::optional<std::uint32_t> way_out_;
  double way_out_depth_ = infinity<double>;
  std::optional<std::uint32_t> plate_;
  FclContactNormal plate_contact_{.gap = -infinity<double>};
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
