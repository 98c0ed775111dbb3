/// @file
/// Contacts of solid triangle meshes with convex solids and with each other.
///
/// A tree finds the plates of the surface (mesh_plates.hpp) near the other solid. Each gets its
/// contact direction from `contact_normal`. The surface (mesh_surface.hpp) decides which of
/// neighbouring plates owns a contact. All plates of a flat face share one manifold of at most
/// eight points.
///
/// Surfaces of two meshes may have passed through each other. They are searched within both boxes,
/// if the meshes cut or touch each other or one is inside the other. The first corner decides about
/// inside, also for meshes of several parts. Bodies that are apart cost only the plates within the
/// margin.
///
/// Limits of this plate-by-plate view:
/// - A convex solid that the surface cuts always has a contact. A deep one may get the normal of
///   the nearest plate instead of the shortest way out.
/// - A solid wholly inside leaves through the face nearest to its middle.
/// - Two meshes get contacts up to a depth of half the thickness of the thinner one.
/// - Contacts beside hollow edges may be deeper than the solids are, by less than half in tests.
///
/// The cost is a GJK for each plate that faces the other solid within the margin (0.5 to 2 us), or
/// for each such pair. Meshes that cut each other also cost a search behind each plate of B that is
/// near the surface of A or inside.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_clip.hpp>
#include <bristle/geometry/contacts/contact_normal.hpp>
#include <bristle/geometry/contacts/contact_sink.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/meshes/mesh_plates.hpp>
#include <bristle/geometry/meshes/mesh_surface.hpp>
#include <bristle/geometry/shapes/convex_view.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// Adds the contacts of a mesh with a convex solid at X_MC in the mesh's frame. Normals run from
/// the mesh to the solid.
///
/// @tparam Distance  As in `contact_normal`.
template <typename Distance, Scalar S, typename Tree>
void collide_mesh(const MeshSurface<Precise<S>, Tree>& mesh, const ConvexView<Precise<S>>& convex,
                  const Transform<Precise<S>>& X_MC, Precise<S> margin, ContactSink<S>& sink);

/// The same for two meshes, with B at X_AB.
template <typename Distance, Scalar S, typename Tree>
void collide_meshes(const MeshSurface<Precise<S>, Tree>& a, const MeshSurface<Precise<S>, Tree>& b,
                    const Transform<Precise<S>>& X_AB, Precise<S> margin, ContactSink<S>& sink);

// Implementation ----------------------------------------------------------------------------------

/// Opposite side of a contact that is a convex solid. Any normal suits it.
template <typename Surface, Scalar P>
struct ConvexOpposite {
  Transform<P> X_CM;
  Aabb<P> box;  // [m] Around the solid, in its own frame.

  [[nodiscard]] typename Surface::Region region_of(const Vec3<P>&) const {
    return Surface::Region::edge;
  }
  [[nodiscard]] std::uint32_t key() const { return 1; }
  [[nodiscard]] P depth() const { return P(0); }
  [[nodiscard]] bool is_facing(const Vec3<P>&) const { return false; }
  /// Returns whether a plate comes within a margin of the box. Along the axes of many solids
  /// that is the exact distance.
  [[nodiscard]] bool is_within(const Plate<P>& plate, P margin) const {
    Aabb<P> other;
    for (const Vec3<P>& p : plate.corners) other.include(Vec3<P>(X_CM * p));
    return other.overlaps(box.inflated(margin));
  }
};

/// Opposite side of a contact that is a plate of a mesh B, queried in the frame of A.
template <typename Surface, Scalar P>
class MeshOpposite {
 public:
  /// @param largest_depth  [m] Depth up to which surfaces that have passed each other are found.
  MeshOpposite(const Surface& mesh, std::uint32_t number, const Transform<P>& X_AB, P largest_depth)
      : mesh_(mesh),
        number_(number),
        X_AB_(X_AB),
        largest_depth_(largest_depth),
        normal_(X_AB.rotate(mesh.normal(number))) {
    const Plate<P> plate = mesh.plate(number);
    for (const Vec3<P>& corner : plate.corners) {
      corners_[count_++] = X_AB * corner;
      hair_ = std::max(hair_, Tolerance<P>::equal() * (corner - plate.corners[0]).norm());
    }
    for (std::size_t k = 0; k < count_; ++k) {
      const Vec3<P>& next = corners_[k + 1 < count_ ? k + 1 : 0];
      outwards_[k] = (next - corners_[k]).cross(normal_).normalized();
    }
  }

  /// [-] The plate.
  [[nodiscard]] std::uint32_t number() const { return number_; }
  /// [1] Its normal.
  [[nodiscard]] const Vec3<P>& normal() const { return normal_; }

  [[nodiscard]] typename Surface::Region region_of(const Vec3<P>& n) const {
    return mesh_.region_of(number_, X_AB_.rotation.conjugate() * Vec3<P>(-n));
  }
  [[nodiscard]] std::uint32_t key() const { return mix(mesh_.face_number(number_), 2); }
  [[nodiscard]] P depth() const { return largest_depth_; }
  /// Returns whether the plate faces against n, within 25 degrees. Surfaces at larger angles cut
  /// each other when they pass through each other. They need no help.
  [[nodiscard]] bool is_facing(const Vec3<P>& n) const {
    return n.dot(normal_) < -P(1 - chosen::opposing_plates_versine);
  }
  /// Returns whether a plate of A comes within a margin of this one along its normal and across its
  /// edges, and is not behind it.
  [[nodiscard]] bool is_within(const Plate<P>& other, P margin) const {
    P low = infinity<P>;
    P high = -infinity<P>;
    for (const Vec3<P>& p : other.corners) {
      const P height = normal_.dot(p - corners_[0]);
      low = std::min(low, height);
      high = std::max(high, height);
    }
    if (!(low <= margin && high >= -hair_)) return false;
    for (std::size_t k = 0; k < count_; ++k) {
      P beyond = infinity<P>;
      for (const Vec3<P>& p : other.corners) {
        beyond = std::min(beyond, outwards_[k].dot(p - corners_[k]));
      }
      if (beyond > margin) return false;
    }
    return true;
  }

 private:
  const Surface& mesh_;
  std::uint32_t number_;
  const Transform<P>& X_AB_;
  P largest_depth_;
  Vec3<P> normal_;
  std::array<Vec3<P>, MeshPlates<P>::capacity> corners_;   // [m]
  std::array<Vec3<P>, MeshPlates<P>::capacity> outwards_;  // [1] Across its edges.
  std::size_t count_ = 0;
  P hair_ = P(0);  // [m] Round-off.
};

/// A plate that cuts a solid, and the shortest way of the solid off it. A solid that is moved to
/// where it is free is off each plate. So none of these ways is longer than that of the solid.
template <Scalar P>
struct PlateCut {
  std::uint32_t plate;
  ContactNormal<P> way_off;
};

/// The contacts of one convex solid with one mesh, plate by plate.
template <typename Distance, Scalar S, typename Tree>
class MeshConvexContacts {
 public:
  using P = Precise<S>;
  using Surface = MeshSurface<P, Tree>;

  MeshConvexContacts(const Surface& mesh, const ConvexView<P>& convex, const Transform<P>& X_MC,
                     P margin, ContactSink<S>& sink)
      : mesh_(mesh),
        convex_(convex),
        X_MC_(X_MC),
        R_CM_(rotation_matrix<P>(X_MC.rotation.conjugate())),
        margin_(margin),
        sink_(sink) {}

  /// @param opposite  The other side. `region_of(n)` is the region of a normal there.
  ///                 `key()` names its face. `depth()` [m] bounds how far two surfaces that are
  ///                 `is_facing(n)` may have passed through each other; 0 for a convex solid.
  template <typename Opposite>
  void add_all(const Opposite& opposite) {
    bool is_any = false;
    const Aabb<P> near = bounds_at(convex_, X_MC_).inflated(margin_);
    mesh_.find([&](const Aabb<P>& box) { return box.overlaps(near); },
               [&](std::uint32_t i) {
                 is_any = add(i, opposite) || is_any;
                 return true;
               });
    // Surfaces get no last resort. It would add worse contacts, plate by plate.
    if (opposite.depth() > P(0)) return;
    // Where the surface cuts the solid, contacts that are still open do not hold it.
    if (!is_any || (deepest_cut_ && !sink_.reaches(P(0)))) add_last_resort();
  }

  /// Adds surfaces that have passed through a plate of the other side by more than the margin.
  /// They are behind a plate that faces against them. So the search sweeps from the other side
  /// against its normal.
  /// @param within  Box of the plates to search, in the frame of the mesh.
  template <typename Opposite>
  void add_all_passed(const Opposite& opposite, const Aabb<P>& within) {
    const Aabb<P> here = bounds_at(convex_, X_MC_);
    const Aabb<P> near = here.inflated(margin_);
    // Plates that face against it within 25 degrees are within this distance of the line.
    const P beside = P(chosen::passed_plate_spread) * opposite.depth();
    const Vec3<P> back = -opposite.depth() * opposite.normal();
    Aabb<P> swept = here;
    swept.include(Aabb<P>{here.lower + back, here.upper + back});
    swept = swept.inflated(beside);
    swept = {cwise_max(swept.lower, within.lower), cwise_min(swept.upper, within.upper)};
    const Vec3<P> middle = X_MC_ * convex_.center;
    mesh_.find([&](const Aabb<P>& box) { return box.overlaps(swept); },
               [&](std::uint32_t i) {
                 const Vec3<P>& n = mesh_.normal(i);
                 if (!opposite.is_facing(n)) return true;
                 const Plate<P> plate = mesh_.plate(i);
                 const ConvexView<P> view = convex_view(plate);
                 const Vec3<P> away = middle - view.center;
                 const P height = n.dot(away);
                 const P reach = P(1 + Tolerance<P>::equal()) * (view.reach + convex_.reach);
                 if (!((away - height * n).squaredNorm() <= reach * reach)) return true;
                 // Plates near the solid were tested by add_all().
                 Aabb<P> box;
                 for (const Vec3<P>& corner : plate.corners) box.include(corner);
                 if (!box.overlaps(near)) {
                   (void)add_passed(i, lowest_above(plate, n), opposite);
                 }
                 return true;
               });
  }

  /// Returns whether any plate in range cuts or touches the solid.
  [[nodiscard]] bool has_cut() const { return has_cut_; }
  /// The plate that is deepest in the solid, if any cuts it.
  [[nodiscard]] const std::optional<PlateCut<P>>& deepest_cut() const { return deepest_cut_; }
  /// Adds the contact of a plate that cuts the solid.
  void add_cut(const PlateCut<P>& cut) {
    const Plate<P> plate = mesh_.plate(cut.plate);
    const Vec3<P>& n = cut.way_off.normal;
    ContactManifold<P> manifold = contact_manifold(convex_view(plate), convex_, X_MC_, n, margin_);
    manifold.key = mix(mesh_.edge_name(cut.plate, n), 1);
    sink_.add(manifold);
  }

 private:
  using Region = typename Surface::Region;

  template <typename Opposite>
  bool add(std::uint32_t i, const Opposite& opposite) {
    // Along the normal of the plate the solid reaches from `low` to `high` above it.
    const Vec3<P>& face_normal = mesh_.normal(i);
    const Plate<P> plate = mesh_.plate(i);
    const P low = lowest_above(plate, face_normal);
    if (low > margin_) return false;
    const P high = -lowest_above(plate, -face_normal);
    const bool is_surface = opposite.depth() > P(0);
    const auto add_if_passed = [&] {
      return is_surface && low < P(0) && add_passed(i, low, opposite);
    };
    // A solid behind the plate does not touch it. A hair less may be a cut.
    if (high < -hair()) {
      if (!is_surface) note_way_out(i, plate);
      return add_if_passed();
    }
    if (!opposite.is_within(plate, margin_)) return add_if_passed();
    if (is_beside(plate)) return false;
    const ConvexView<P> view = convex_view(plate);
    ContactNormal<P> found = contact_normal<Distance>(view, convex_, X_MC_, margin_);
    if (found.nearness != Nearness::near) return add_if_passed();
    has_cut_ = has_cut_ || found.gap <= hair();
    if (found.gap < -hair() && !(deepest_cut_ && deepest_cut_->way_off.gap <= found.gap)) {
      deepest_cut_ = PlateCut<P>{i, found};
    }
    bool is_behind = found.normal.dot(face_normal) <= P(0);
    if (is_behind && is_surface) return add_passed(i, low, opposite);
    Region region = mesh_.region_of(i, found.normal);
    if (region == Region::inner_edge) {
      found = face_normal_of(i);
      if (found.nearness != Nearness::near) return false;
      is_behind = found.normal.dot(face_normal) <= P(0);
      region = mesh_.region_of(i, found.normal);
      // The face is touched at another of its plates.
      if (region == Region::inner_edge) return false;
    }
    if (region == Region::none) {
      if (is_behind) note_way_out(i, plate);
      return false;
    }
    const Vec3<P>& normal = region == Region::face ? face_normal : found.normal;
    const Region other_region = opposite.region_of(normal);
    if (other_region == Region::none) return false;
    ContactManifold<P> manifold;
    if (region == Region::face) {
      manifold = face_manifold(i);
    } else {
      manifold = contact_manifold(view, convex_, X_MC_, normal, margin_);
      manifold.key = other_region == Region::face ? opposite.key()
                                                  : mix(mesh_.edge_name(i, normal), opposite.key());
    }
    sink_.add(manifold);
    return manifold.size > 0;
  }

  /// The contact direction of the flat face of a plate as a whole. The last one is kept, since most
  /// plates of a face come one after the other.
  [[nodiscard]] const ContactNormal<P>& face_normal_of(std::uint32_t i) {
    const std::uint32_t face = mesh_.face_number(i);
    if (last_face_ != face) {
      last_face_ = face;
      last_found_ = contact_normal<Distance>(convex_view(mesh_.face(i)), convex_, X_MC_, margin_);
    }
    return last_found_;
  }

  /// Adds two surfaces that have passed through each other face to face. As plates they are apart.
  /// Each is on the wrong side of the other.
  /// @param gap  [m] Height of the solid's lowest point above the plate.
  template <typename Opposite>
  bool add_passed(std::uint32_t i, P gap, const Opposite& opposite) {
    const Vec3<P>& n = mesh_.normal(i);
    if (gap < -opposite.depth() || gap > margin_ || !opposite.is_facing(n)) return false;
    const ContactManifold<P> manifold = face_manifold(i);
    if (manifold.size == 0) return false;
    std::array<Vec3<P>, ContactManifold<P>::capacity> places;
    for (std::size_t k = 0; k < manifold.size; ++k) {
      const ContactPoint<P>& point = manifold.points[k];
      places[k] = point.position + P(0.5) * point.gap * n;
    }
    if (mesh_.has_shorter_way_out(i, std::span(places).first(manifold.size))) return false;
    sink_.add(manifold);
    return true;
  }

  /// Contacts of the part of the solid over the plate, along its normal, that are corners of the
  /// contact with the whole face. Empty if there is none.
  [[nodiscard]] ContactManifold<P> face_manifold(std::uint32_t i) const {
    const Plate<P> plate = mesh_.plate(i);
    const Vec3<P>& n = plate.normal;
    const ConvexView<P> view = convex_view(plate);
    auto features = feature_pair(view, convex_, X_MC_, n);
    for (std::size_t k = 0; k < features.a.size; ++k) {
      features.a.is_inner_edge[k] = mesh_.is_inner_edge(i, k);
    }
    // Two plates of one face differ by the round-off of both.
    const ContactManifold<P> clipped =
        clip_features(features.a, features.b, n, margin_, P(2) * mesh_.hair());
    ContactManifold<P> manifold;
    manifold.normal = n;
    manifold.key = mix(mesh_.face_number(i), 0);
    P gap = margin_;
    for (std::size_t k = 0; k < clipped.size; ++k) {
      const ContactPoint<P>& point = clipped.points[k];
      if (!is_over(plate, point.position)) continue;
      manifold.add(point);
      gap = std::min(gap, point.gap);
    }
    // Rims of round shapes are clipped as polygons. The deepest point may lie between their
    // corners.
    const P least = lowest_above(plate, n);
    if (least < gap - hair() && is_over(plate, deepest_place(n))) {
      if (manifold.size == manifold.capacity) --manifold.size;
      manifold.add({deepest_place(n) - P(0.5) * least * n, least, 0});
    }
    return manifold;
  }

  /// [m] Round-off of places on the solid.
  [[nodiscard]] P hair() const { return Tolerance<P>::equal() * convex_.reach; }
  /// [m] The solid's farthest point against n.
  [[nodiscard]] Vec3<P> deepest_place(const Vec3<P>& n) const {
    return X_MC_ * support_point(convex_, Vec3<P>(X_MC_.rotation.conjugate() * Vec3<P>(-n)));
  }
  /// [m] Height of the solid's lowest point along n above the plane through a plate across n.
  [[nodiscard]] P lowest_above(const Plate<P>& plate, const Vec3<P>& n) const {
    return -core_height(-n) - convex_.rounding - n.dot(plate.corners[0]);
  }
  /// [m] Largest x.direction of the points x of the solid's core. The direction may have any
  /// length.
  [[nodiscard]] P core_height(const Vec3<P>& direction) const {
    const Vec3<P> in_solid = R_CM_ * direction;
    return in_solid.dot(convex_.support(in_solid)) + direction.dot(X_MC_.translation);
  }

  /// Returns whether the solid is farther than the margin beyond an edge of a plate.
  [[nodiscard]] bool is_beside(const Plate<P>& plate) const {
    const P apart = margin_ + convex_.rounding;
    for (std::size_t k = 0; k < plate.corners.size(); ++k) {
      const Vec3<P> outwards = edge_of(plate, k).cross(plate.normal);
      const P beyond = -core_height(-outwards) - outwards.dot(plate.corners[k]);
      if (beyond > P(0) && beyond * beyond > apart * apart * outwards.squaredNorm()) return true;
    }
    return false;
  }

  /// Returns whether a point is above or below a plate. Its edges and a hair beyond are included.
  [[nodiscard]] bool is_over(const Plate<P>& plate, const Vec3<P>& point) const {
    for (std::size_t k = 0; k < plate.corners.size(); ++k) {
      const Vec3<P> edge = edge_of(plate, k);
      const P beside = edge.cross(point - plate.corners[k]).dot(plate.normal);
      const P length = edge.norm();
      // The edge and the point may both be off.
      const P hair = std::max(Tolerance<P>::equal() * length, P(2) * mesh_.hair());
      if (beside < -hair * length) return false;
    }
    return true;
  }
  /// [m] From corner k of a plate to the next.
  [[nodiscard]] static Vec3<P> edge_of(const Plate<P>& plate, std::size_t k) {
    return plate.corners[k + 1 < plate.corners.size() ? k + 1 : 0] - plate.corners[k];
  }

  /// Remembers the nearest face through which a solid whose middle is inside can leave.
  void note_way_out(std::uint32_t i, const Plate<P>& plate) {
    const Vec3<P> middle = X_MC_ * convex_.center;
    const P depth = plate.normal.dot(plate.corners[0] - middle);
    if (!(depth >= P(0) && depth < way_out_depth_)) return;
    if (!is_over(plate, middle)) return;
    way_out_ = i;
    way_out_depth_ = depth;
  }

  /// Adds a contact for a solid that would fall through otherwise. Such a solid may be all inside.
  /// Or the surface cuts it, but the contact of every plate belonged to a neighbour. That
  /// happens as the shortest way out is only a local one.
  void add_last_resort() {
    const Vec3<P> middle = X_MC_ * convex_.center;
    const bool is_inside = mesh_.bounds().contains(middle) && mesh_.contains(middle);
    if (is_inside && !way_out_ && !deepest_cut_) {
      mesh_.find([](const Aabb<P>&) { return true; },
                 [&](std::uint32_t i) {
                   note_way_out(i, mesh_.plate(i));
                   return true;
                 });
    }
    if (way_out_ && is_inside) {
      const Plate<P> plate = mesh_.plate(*way_out_);
      ContactManifold<P> manifold =
          contact_manifold(convex_view(plate), convex_, X_MC_, plate.normal, margin_);
      manifold.key = mix(mesh_.face_number(*way_out_), 0);
      sink_.add(manifold);
    } else if (deepest_cut_) {
      add_cut(*deepest_cut_);
    }
  }

  const Surface& mesh_;
  const ConvexView<P>& convex_;
  const Transform<P>& X_MC_;
  Mat3<P> R_CM_;
  P margin_;
  ContactSink<S>& sink_;
  bool has_cut_ = false;
  std::optional<std::uint32_t> last_face_;
  ContactNormal<P> last_found_;
  // For the last resort.
  std::optional<std::uint32_t> way_out_;
  P way_out_depth_ = infinity<P>;
  std::optional<PlateCut<P>> deepest_cut_;
};

template <typename Distance, Scalar S, typename Tree>
void collide_mesh(const MeshSurface<Precise<S>, Tree>& mesh, const ConvexView<Precise<S>>& convex,
                  const Transform<Precise<S>>& X_MC, Precise<S> margin, ContactSink<S>& sink) {
  using P = Precise<S>;
  sink.set_nearest(Tolerance<P>::equal() * convex.reach);
  MeshConvexContacts<Distance, S, Tree> contacts(mesh, convex, X_MC, margin, sink);
  contacts.add_all(
      ConvexOpposite<MeshSurface<P, Tree>, P>{X_MC.inverse(), bounds_at(convex, Transform<P>())});
}

template <typename Distance, Scalar S, typename Tree>
void collide_meshes(const MeshSurface<Precise<S>, Tree>& a, const MeshSurface<Precise<S>, Tree>& b,
                    const Transform<Precise<S>>& X_AB, Precise<S> margin, ContactSink<S>& sink) {
  using P = Precise<S>;
  using Surface = MeshSurface<P, Tree>;
  const Transform<P> X_BA = X_AB.inverse();
  const Mat3<P> R_AB = X_AB.rotation_matrix();
  // Beyond half the thickness of the thinner one, in and out cannot be told apart.
  const P depth =
      std::min(a.bounds().half_extents().minCoeff(), b.bounds().half_extents().minCoeff());
  // Calls use(contacts, opposite) for each plate of B with a box that `accept(box in the frame
  // of A)` takes, together with all boxes around it.
  const auto for_each = [&](auto&& accept, auto&& use) {
    b.find([&](const Aabb<P>& box) { return accept(transformed<P>(box, R_AB, X_AB.translation)); },
           [&](std::uint32_t i) {
             const Plate<P> plate = b.plate(i);
             const ConvexView<P> view = convex_view(plate);
             sink.set_nearest(Tolerance<P>::equal() * view.reach);
             MeshConvexContacts<Distance, S, Tree> contacts(a, view, X_AB, margin, sink);
             use(contacts, MeshOpposite<Surface, P>(b, i, X_AB, depth));
             return true;
           });
  };
  bool have_cut = false;
  std::optional<PlateCut<P>> deepest;  // Of A in the plate of B `deepest_in`.
  std::uint32_t deepest_in = 0;
  for_each([&](const Aabb<P>& box) { return a.comes_near(box.inflated(margin)); },
           [&](auto& contacts, const auto& opposite) {
             contacts.add_all(opposite);
             have_cut = have_cut || contacts.has_cut();
             const std::optional<PlateCut<P>>& cut = contacts.deepest_cut();
             if (cut && !(deepest && deepest->way_off.gap <= cut->way_off.gap)) {
               deepest = cut;
               deepest_in = opposite.number();
             }
           });
  // A thin mesh may be all inside the other.
  const auto is_corner_within = [](const Surface& outer, const Surface& inner,
                                   const Transform<P>& X_OI) {
    const Vec3<P> corner = X_OI * inner.plate(0).corners[0];
    return outer.bounds().contains(corner) && outer.contains(corner);
  };
  if (have_cut || is_corner_within(a, b, X_AB) || is_corner_within(b, a, X_BA)) {
    const Aabb<P> within = transformed(b.bounds(), X_AB);
    // A box that no plate of A comes near is inside A as a whole, or outside.
    for_each(
        [&](const Aabb<P>& box) {
          return box.overlaps(a.bounds()) && (a.comes_near(box) || a.contains(box.center()));
        },
        [&](auto& contacts, const auto& opposite) { contacts.add_all_passed(opposite, within); });
  }
  // Each contact of plates that cut each other may have belonged to a neighbour.
  if (deepest && !sink.reaches(P(0))) {
    const Plate<P> plate = b.plate(deepest_in);
    const ConvexView<P> view = convex_view(plate);
    MeshConvexContacts<Distance, S, Tree>(a, view, X_AB, margin, sink).add_cut(*deepest);
  }
}

}  // namespace bristle::inline BRISTLE_ABI::detail
