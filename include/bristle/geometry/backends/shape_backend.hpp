/// @file
/// The only interface between the library and the geometry queries.
///
/// A backend is a struct of static functions over a nested template `Collidable<S>`. That is its
/// own prepared, immutable form of a shape, cheap to copy (a shared pointer, usually). It moves
/// without a throw.
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
#include <type_traits>

namespace bristle::inline BRISTLE_ABI {

/// Requirements of `World<S, B>` on a backend B.
///
/// - `make(shape)` checks and prepares a shape. Throws InvalidArgument. No later function throws.
/// - `kind(c)` is the kind of the shape it was made from.
/// - `bounds(c)` [m] is a box in the shape's own frame. Infinite for a half-space.
/// - `mass_properties(c)` is of the solid at unit density, in the shape's own frame. Zero mass for
///   a half-space.
/// - `can_collide(a, b)` returns whether `collide` knows the pair, in either order. The world
///   refuses shapes that would meet one it does not know.
/// - `collide(a, b, X_AB, margin, out)` appends to `out` all manifolds with a gap of at most
///   `margin` [m], in the frame of A. Returns ContactStatus::failed instead of throwing.
/// - `cast_rays(c, X_RC, rays, tag, hits)` offers to `hits` the nearest hit of each ray within its
///   length. X_RC is the shape's pose in the rays' frame. The solid is closed: a ray that starts
///   inside is hit at distance 0 with the normal -direction. Triangles are hit from both sides.
///   Arithmetic is done in the shape's frame and knows no absolute length.
///
/// All functions are safe to call from several threads at once.
///
/// A backend with `static constexpr bool asks_ranges = true` casts only the rays of
/// `RayBatch::range`, in the order of the batch or of its nodes. The same ray gives the same bits
/// in any range. Hits of other rays are neither read nor written. Then threads share the rays of
/// one large patch.
///
/// A backend with `is_clear(c, X_RC, rays)` returns true early if no ray can meet the shape. It may
/// return false then, too. Large patches that meet nothing then cost less.
///
/// A backend with `visit_solid(c, visit)` calls `visit` with the solid in `Precise<S>`: a
/// HalfSpace, a ConvexView or a MeshSurface. Then a world can be asked what overlaps a shape, is
/// nearest to it, or is touched first on its way.
///
/// A backend with `shape(c)` gives the shape that `c` was made from. Then worlds can be drawn and
/// recorded without a copy of their definitions.
template <typename B, typename S>
concept ShapeBackend = Scalar<S> && std::copyable<typename B::template Collidable<S>> &&
    std::is_nothrow_move_constructible_v<typename B::template Collidable<S>> &&
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

/// True if `cast_rays` of a backend casts only the rays of `RayBatch::range`.
template <typename B>
inline constexpr bool asks_ranges = requires {
  requires B::asks_ranges;
};

namespace detail {

/// True for a backend that gives the shape a collidable was made from.
template <typename B, typename S>
concept TellsShapes = requires(const typename B::template Collidable<S>& c) {
  { B::shape(c) } -> std::same_as<Shape<S>>;
};

/// True for a backend that shows its solids.
template <typename B, typename S>
concept ShowsSolids = requires(const typename B::template Collidable<S>& c) {
  B::visit_solid(c, [](const auto&) {});
};

}  // namespace detail

/// Returns true only if no ray of a batch can meet the shape. False if the backend cannot tell. See
/// `ShapeBackend`.
template <Scalar S, typename B>
[[nodiscard]] bool is_surely_clear(const typename B::template Collidable<S>& c,
                                   const Transform<S>& X_RC, const RayBatch<S>& rays) {
  if constexpr (requires { B::is_clear(c, X_RC, rays); }) return B::is_clear(c, X_RC, rays);
  return false;
}

}  // namespace bristle::inline BRISTLE_ABI

/// Declares (`extern template`) or defines (`template`) the functions of a backend in a scalar that
/// a step calls.
#define BRISTLE_BACKEND_QUERIES(instantiate, Backend, S)                                           \
  instantiate ShapeKind Backend::kind<S>(const Backend::Collidable<S>&);                           \
  instantiate Aabb<S> Backend::bounds<S>(const Backend::Collidable<S>&);                           \
  instantiate ContactStatus Backend::collide<S>(                                                   \
      const Backend::Collidable<S>&, const Backend::Collidable<S>&, const Transform<S>&, S,        \
      ContactManifolds<S>&) noexcept;                                                              \
  instantiate void Backend::cast_rays<S>(const Backend::Collidable<S>&, const Transform<S>&,       \
                                         const RayBatch<S>&, std::uint32_t, RayHits<S>&) noexcept; \
  instantiate bool Backend::is_clear<S>(const Backend::Collidable<S>&, const Transform<S>&,        \
                                        const RayBatch<S>&) noexcept;

/// The same for the functions that make a collidable and tell what it was made from. Only the
/// baseline has them.
#define BRISTLE_BACKEND_MAKERS(instantiate, Backend, S)                                     \
  instantiate Backend::Collidable<S> Backend::make<S>(const Shape<S>&);                     \
  instantiate MassProperties<S> Backend::mass_properties<S>(const Backend::Collidable<S>&); \
  instantiate Shape<S> Backend::shape<S>(const Backend::Collidable<S>&);
