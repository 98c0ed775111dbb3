/// @file
/// Contacts of any two solids, convex or meshes, over one method for the distance of convex cores.
/// Both backends use it. They differ in that method and in the trees over their meshes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_clip.hpp>
#include <bristle/geometry/contacts/contact_manifold.hpp>
#include <bristle/geometry/contacts/contact_normal.hpp>
#include <bristle/geometry/contacts/contact_sink.hpp>
#include <bristle/geometry/contacts/mesh_contacts.hpp>
#include <bristle/geometry/meshes/mesh_surface.hpp>
#include <bristle/geometry/shapes/convex_view.hpp>
#include <bristle/math/finite.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

namespace bristle::inline BRISTLE_ABI::detail {

/// A solid prepared for contacts. Either `convex` or `mesh` is set, and refers to its source.
template <Scalar S, typename Tree>
struct SolidView {
  std::optional<ConvexView<S>> convex;
  std::optional<MeshSurface<S, Tree>> mesh;
};

/// Adds the contacts of A and B within `margin` [m], with B at X_AB. Contacts are in the frame of
/// A, normals from A to B.
///
/// @tparam Distance  As in `contact_normal`.
/// @return False if nothing is known: the pose is not finite.
template <typename Distance, Scalar S, typename Tree>
bool collide_solids(const SolidView<Precise<S>, Tree>& a, const SolidView<Precise<S>, Tree>& b,
                    const Transform<Precise<S>>& X_AB, Precise<S> margin, ContactSink<S>& sink);

// Implementation ----------------------------------------------------------------------------------

template <typename Distance, Scalar S, Scalar P>
bool collide_convex(const ConvexView<P>& a, const ConvexView<P>& b, const Transform<P>& X_AB,
                    P margin, ContactSink<S>& sink) {
  const ContactNormal<P> found = contact_normal<Distance>(a, b, X_AB, margin);
  if (found.nearness != Nearness::near) return found.nearness == Nearness::apart;
  ContactManifold<P> manifold = contact_manifold(a, b, X_AB, found.normal, margin);
  // Rims and sides of round shapes are clipped as polygons and lines. The deepest point may lie
  // between those.
  const P deep = found.gap + Tolerance<P>::equal() * a.reach;
  const auto points = std::span(manifold.points).first(manifold.size);
  if (std::none_of(points.begin(), points.end(), [&](const auto& p) { return p.gap <= deep; })) {
    sink.add(manifold);
    manifold.size = 0;
    manifold.add(extreme_contact(a, b, X_AB, found.normal));
  }
  sink.add(manifold);
  return true;
}

template <typename Distance, Scalar S, typename Tree>
bool collide_solids(const SolidView<Precise<S>, Tree>& a, const SolidView<Precise<S>, Tree>& b,
                    const Transform<Precise<S>>& X_AB, Precise<S> margin, ContactSink<S>& sink) {
  using P = Precise<S>;
  using std::isfinite;
  if (!all_finite(X_AB.translation) || !all_finite(X_AB.rotation.coeffs()) || !isfinite(margin)) {
    return false;
  }
  if (a.mesh && b.mesh) {
    sink.set_frame({}, false);
    collide_meshes<Distance>(*a.mesh, *b.mesh, X_AB, margin, sink);
    return true;
  }
  if (!a.mesh && !b.mesh) {
    sink.set_frame({}, false);
    return collide_convex<Distance>(*a.convex, *b.convex, X_AB, margin, sink);
  }
  // Contacts are computed in the frame of the mesh.
  const bool is_first = a.mesh.has_value();
  sink.set_frame(is_first ? Transform<P>{} : X_AB, !is_first);
  const Transform<P> X_MC = is_first ? X_AB : X_AB.inverse();
  const ConvexView<P>& convex = is_first ? *b.convex : *a.convex;
  collide_mesh<Distance>(is_first ? *a.mesh : *b.mesh, convex, X_MC, margin, sink);
  return true;
}

}  // namespace bristle::inline BRISTLE_ABI::detail
