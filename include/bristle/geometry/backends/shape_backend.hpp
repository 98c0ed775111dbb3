/// @file
/// The only door between the library and whatever computes geometry.
///
/// A backend is a struct of static functions over a nested template `Collidable<S>`: its own
/// prepared, immutable form of a shape, cheap to copy (a shared pointer, usually).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/contact_manifold.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/geometry/trees/aabb.hpp>
#include <bristle/math/mass_properties.hpp>
#include <bristle/math/transform.hpp>

#include <concepts>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI {

/// What `World<S, B>` asks of a backend B.
///
/// - `make(shape)` checks and prepares a shape. Throws InvalidArgument; nothing after it throws.
/// - `kind(c)` is the kind of the shape it was made from.
/// - `bounds(c)` [m] in the shape's own frame; infinite for a half-space.
/// - `mass_properties(c)` of the solid at unit density, in the shape's own frame; zero mass for a
///   half-space.
/// - `can_collide(a, b)` says whether `collide` knows the pair, in either order; the world refuses
///   shapes that would meet one it does not know.
/// - `collide(a, b, X_AB, margin, out)` appends to `out` the manifolds of all contact with a gap of
///   at most `margin` [m], in the frame of A. Returns ContactStatus::failed instead of throwing.
/// - `cast_rays(c, X_RC, rays, tag, hits)` offers to `hits` the nearest hit of each ray within its
///   reach, where X_RC is the shape's pose in the rays' frame. The solid is closed: a ray that
///   starts inside is hit at distance 0 with the normal -direction. Triangles are met from both
///   sides. Arithmetic is done in the shape's frame and knows no absolute length.
///
/// All functions are safe to call from several threads at once. A backend that has a
/// `static constexpr bool asks_slices = true` casts only the rays of `RayBatch::slice`, in the
/// order of the batch or of its bundles, and the same ray to the same bits in any slice; hits of
/// other rays it neither reads nor writes. Then threads share the rays of one large patch. One that
/// has `is_clear(c, X_RC, rays)` says quickly, and not always, that no ray can meet the shape: then
/// large patches that meet nothing cost less.
template <typename B, typename S>
concept ShapeBackend = Scalar<S> && std::copyable<typename B::template Collidable<S>> &&
    requires(const Shape<S>& shape, const typename B::template Collidable<S>& c,
             const Transform<S>& X, S margin, ContactManifolds<S>& manifolds,
             const RayBatch<S>& rays, std::uint32_t tag, RayHits<S>& hits, ShapeKind kind) {
  { B::template make<S>(shape) } -> std::same_as<typename B::template Collidable<S>>;
  { B::kind(c) } -> std::same_as<ShapeKind>;
  { B::bounds(c) } -> std::same_as<Aabb<S>>;
  { B::mass_properties(c) } -> std::same_as<MassProperties<S>>;
  { B::can_collide(kind, kind) } -> std::same_as<bool>;
  { B::collide(c, c, X, margin, manifolds) }
  noexcept->std::same_as<ContactStatus>;
  { B::cast_rays(c, X, rays, tag, hits) }
  noexcept;
};

/// Whether `cast_rays` of a backend casts only the rays of `RayBatch::slice`.
template <typename B>
inline constexpr bool asks_slices = requires {
  requires B::asks_slices;
};

/// Whether no ray of a batch can meet a shape, as far as a backend that can says. See
/// `ShapeBackend`.
template <Scalar S, typename B>
[[nodiscard]] bool is_surely_clear(const typename B::template Collidable<S>& c,
                                   const Transform<S>& X_RC, const RayBatch<S>& rays) {
  if constexpr (requires { B::is_clear(c, X_RC, rays); }) return B::is_clear(c, X_RC, rays);
  return false;
}

}  // namespace bristle::inline BRISTLE_ABI

/// Declares (`extern template`) or makes (`template`) the functions of a backend in a scalar.
#define BRISTLE_BACKEND_FUNCTIONS(instantiate, Backend, S)                                         \
  instantiate Backend::Collidable<S> Backend::make<S>(const Shape<S>&);                            \
  instantiate ShapeKind Backend::kind<S>(const Backend::Collidable<S>&);                           \
  instantiate Aabb<S> Backend::bounds<S>(const Backend::Collidable<S>&);                           \
  instantiate MassProperties<S> Backend::mass_properties<S>(const Backend::Collidable<S>&);        \
  instantiate ContactStatus Backend::collide<S>(                                                   \
      const Backend::Collidable<S>&, const Backend::Collidable<S>&, const Transform<S>&, S,        \
      ContactManifolds<S>&) noexcept;                                                              \
  instantiate void Backend::cast_rays<S>(const Backend::Collidable<S>&, const Transform<S>&,       \
                                         const RayBatch<S>&, std::uint32_t, RayHits<S>&) noexcept; \
  instantiate bool Backend::is_clear<S>(const Backend::Collidable<S>&, const Transform<S>&,        \
                                        const RayBatch<S>&) noexcept;
