/// @file
/// Contacts of a solid triangle mesh with a half-space.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/analytic_contacts.hpp>
#include <bristle/geometry/contacts/contact_sink.hpp>
#include <bristle/geometry/meshes/mesh_surface.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace bristle::inline BRISTLE_ABI::detail {

/// Converts a half-space from frame A to frame B at X_AB.
template <Scalar S>
[[nodiscard]] HalfSpace<S> seen_from(const Transform<S>& X_AB, const HalfSpace<S>& plane_A) {
  return {X_AB.rotation.conjugate() * plane_A.normal,
          plane_A.offset - plane_A.normal.dot(X_AB.translation)};
}

/// Adds the contact of a half-space with a mesh, in the frame of the mesh. Of its corners within
/// `margin` [m] of the plane it takes the deepest, and those farthest apart.
///
/// @param X_PM  Pose of the mesh in the frame of the half-space.
template <Scalar S, typename Tree>
void collide_plane_mesh(const HalfSpace<Precise<S>>& plane_P,
                        const MeshSurface<Precise<S>, Tree>& mesh,
                        const Transform<Precise<S>>& X_PM, Precise<S> margin,
                        ContactSink<S>& sink) {
  using P = Precise<S>;
  struct Corner {
    Vec3<P> point;
    std::uint32_t name;
  };
  const HalfSpace<P> plane = seen_from(X_PM, plane_P);
  const P extent = mesh.bounds().half_extents().norm();
  const P round_off = Tolerance<P>::round_off() * extent;
  const auto height = [&](const Vec3<P>& p) -> P { return plane.normal.dot(p) - plane.offset; };
  const auto for_low_corners = [&](const auto& use) {
    mesh.find(
        [&](const Aabb<P>& box) {
          return height(box.center()) - cwise_abs(plane.normal).dot(box.half_extents()) <=
                 margin + round_off;
        },
        [&](std::uint32_t i) {
          const Plate<P> plate = mesh.plate(i);
          for (std::size_t k = 0; k < plate.corners.size(); ++k) {
            const Vec3<P>& p = plate.corners[k];
            if (height(p) <= margin) use(Corner{p, plate.names[k]});
          }
          return true;
        });
  };
  // One traversal for each contact, and nothing to store. The deepest corner comes first. Then
  // always follows the corner farthest from those chosen.
  std::array<Corner, ContactManifold<P>::capacity> chosen{};
  std::size_t count = 0;
  P deepest = infinity<P>;
  for_low_corners([&](const Corner& corner) {
    const P gap = height(corner.point);
    if (gap < deepest - round_off) {
      deepest = gap;
      chosen[0] = corner;
      count = 1;
    }
  });
  if (count == 0) return;
  while (count < chosen.size()) {
    P farthest = Tolerance<P>::equal() * extent;
    std::optional<Corner> next;
    for_low_corners([&](const Corner& corner) {
      P clearance = infinity<P>;
      for (std::size_t i = 0; i < count; ++i) {
        const Vec3<P> apart = corner.point - chosen[i].point;
        clearance = std::min(clearance, (apart - plane.normal.dot(apart) * plane.normal).norm());
      }
      if (clearance > farthest) {
        farthest = clearance;
        next = corner;
      }
    });
    if (!next) break;
    chosen[count++] = *next;
  }
  PlaneContacts<P> contacts(plane, margin, extent);
  for (std::size_t i = 0; i < count; ++i) contacts.add(chosen[i].point, chosen[i].name);
  sink.add(contacts.manifold(ContactManifold<P>::capacity));
}

}  // namespace bristle::inline BRISTLE_ABI::detail
