/// @file
/// Shape backend that needs only Eigen.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/shape_backend.hpp>
#include <bristle/geometry/shapes/visit_shape.hpp>

#include <cstdint>
#include <memory>

namespace bristle::inline BRISTLE_ABI {

namespace detail {
template <Scalar S>
class AnalyticShape;
}  // namespace detail

/// Rays in closed form against every shape. Contacts in closed form, in S, if analytic_contacts.hpp
/// or box_box.hpp has a formula. All others are found as in solid_contacts.hpp, in `Precise<S>`.
/// Satisfies `ShapeBackend`, which documents each function.
struct AnalyticBackend {
  /// A prepared shape. Copies share it.
  template <Scalar S>
  using Collidable = std::shared_ptr<const detail::AnalyticShape<S>>;

  /// `cast_rays` casts only the rays of `RayBatch::range`.
  static constexpr bool asks_ranges = true;

  /// Prepares a shape.
  /// @throws InvalidArgument as `validate`.
  template <Scalar S>
  [[nodiscard]] static Collidable<S> make(const Shape<S>& shape);

  /// Kind of the shape.
  template <Scalar S>
  [[nodiscard]] static ShapeKind kind(const std::shared_ptr<const detail::AnalyticShape<S>>& c);
  /// [m] Box around the shape, in its own frame. Infinite for a half-space.
  template <Scalar S>
  [[nodiscard]] static Aabb<S> bounds(const std::shared_ptr<const detail::AnalyticShape<S>>& c);
  /// Mass properties at unit density, in the shape's own frame.
  template <Scalar S>
  [[nodiscard]] static MassProperties<S> mass_properties(
      const std::shared_ptr<const detail::AnalyticShape<S>>& c);

  /// Returns true for all pairs but two half-spaces.
  [[nodiscard]] static constexpr bool can_collide(ShapeKind a, ShapeKind b) {
    return a != ShapeKind::half_space || b != ShapeKind::half_space;
  }

  /// Appends the manifolds of A and B in the frame of A, as `ShapeBackend` requires.
  template <Scalar S>
  static ContactStatus collide(const std::shared_ptr<const detail::AnalyticShape<S>>& a,
                               const std::shared_ptr<const detail::AnalyticShape<S>>& b,
                               const Transform<S>& X_AB, S margin,
                               ContactManifolds<S>& out) noexcept;

  /// Offers the nearest hit of each ray to `hits`, as `ShapeBackend` requires.
  template <Scalar S>
  static void cast_rays(const std::shared_ptr<const detail::AnalyticShape<S>>& c,
                        const Transform<S>& X_RC, const RayBatch<S>& rays, std::uint32_t tag,
                        RayHits<S>& hits) noexcept;

  /// Early out for meshes. False for other shapes.
  template <Scalar S>
  [[nodiscard]] static bool is_clear(const std::shared_ptr<const detail::AnalyticShape<S>>& c,
                                     const Transform<S>& X_RC, const RayBatch<S>& rays) noexcept;

  /// The shape that was prepared, as it was given.
  template <Scalar S>
  [[nodiscard]] static Shape<S> shape(const std::shared_ptr<const detail::AnalyticShape<S>>& c);

  /// Calls `visit` with the solid: a HalfSpace, a ConvexView or a MeshSurface, in `Precise<S>`.
  template <Scalar S, typename Visit>
  static void visit_solid(const std::shared_ptr<const detail::AnalyticShape<S>>& c, Visit&& visit);
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation ----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/geometry/contacts/analytic_contacts.hpp>
#include <bristle/geometry/contacts/box_box.hpp>
#include <bristle/geometry/contacts/plane_mesh_contacts.hpp>
#include <bristle/geometry/contacts/shape_cast.hpp>
#include <bristle/geometry/contacts/solid_contacts.hpp>
#include <bristle/geometry/meshes/mesh_tree.hpp>
#include <bristle/geometry/rays/ray_lanes.hpp>
#include <bristle/geometry/rays/ray_shapes.hpp>
#include <bristle/geometry/rays/ray_tree_mesh_query.hpp>
#include <bristle/geometry/shapes/shape_properties.hpp>

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// A shape prepared by `AnalyticBackend`: checked, measured, with a view as a solid. A mesh has a
/// tree and a surface, too.
template <Scalar S>
class AnalyticShape {
 public:
  /// The alternatives of `Shape` in the same order.
  using Prepared = std::variant<Sphere<S>, Box<S>, Capsule<S>, Cylinder<S>, Cone<S>, Ellipsoid<S>,
                                HalfSpace<S>, ConvexHull<S>, MeshTree<S>>;

  /// @pre `validate(shape)` has passed.
  explicit AnalyticShape(const Shape<S>& shape);
  // `solid_` points into this object.
  AnalyticShape(const AnalyticShape&) = delete;
  AnalyticShape& operator=(const AnalyticShape&) = delete;

  [[nodiscard]] const Prepared& shape() const { return shape_; }
  /// [m] Box in the shape's own frame.
  [[nodiscard]] const Aabb<S>& bounds() const { return bounds_; }
  /// Mass properties at unit density, in the shape's own frame.
  [[nodiscard]] const MassProperties<S>& mass_properties() const { return mass_properties_; }
  /// View for iterative contacts. Empty for a half-space.
  [[nodiscard]] const SolidView<Precise<S>, MeshTree<S>>& solid() const { return solid_; }

 private:
  Prepared shape_;
  Aabb<S> bounds_;
  MassProperties<S> mass_properties_;
  // A convex shape in the scalar of iterative methods.
  Shape<Precise<S>> precise_;
  SolidView<Precise<S>, MeshTree<S>> solid_;
};

/// True if A and B have a formula in this order.
template <typename A, typename B, typename S>
concept AnalyticPair = requires(const A& a, const B& b, const Transform<S>& X, S margin,
                                ContactManifolds<S>& out) {
  collide_shapes(a, b, X, margin, out);
};

/// Adds the manifolds of A and B if there is a formula for them in this order. Dispatches one shape
/// after the other: a table of all pairs would have nine times as many entries, most of them empty.
/// @return True if there is a formula.
template <typename Prepared, Scalar S>
bool collide_in_closed_form(const Prepared& a, const Prepared& b, const Transform<S>& X_AB,
                            S margin, ContactManifolds<S>& out) {
  const auto collide_with = [&](const auto& shape_a) {
    return visit_shape(
        [&](const auto& shape_b) {
          using A = std::remove_cvref_t<decltype(shape_a)>;
          using B = std::remove_cvref_t<decltype(shape_b)>;
          constexpr bool is_known = AnalyticPair<A, B, S>;
          if constexpr (is_known) collide_shapes(shape_a, shape_b, X_AB, margin, out);
          return is_known;
        },
        b);
  };
  if (const auto* plane = std::get_if<HalfSpace<S>>(&a)) return collide_with(*plane);
  if (const auto* box = std::get_if<Box<S>>(&a)) return collide_with(*box);
  if (const auto* capsule = std::get_if<Capsule<S>>(&a)) return collide_with(*capsule);
  if (const auto* ball = std::get_if<Sphere<S>>(&a)) return collide_with(*ball);
  return false;
}

/// Converts manifolds of (B, A) in B to those of (A, B) in A.
template <Scalar S>
void swap_sides(std::span<ContactManifold<S>> manifolds, const Transform<S>& X_AB) {
  const Mat3<S> R = X_AB.rotation_matrix();
  for (ContactManifold<S>& m : manifolds) {
    m.normal = -(R * m.normal);
    for (std::size_t i = 0; i < m.size; ++i) {
      m.points[i].position = R * m.points[i].position + X_AB.translation;
    }
  }
}

}  // namespace detail

template <Scalar S>
detail::AnalyticShape<S>::AnalyticShape(const Shape<S>& shape)
    : shape_(detail::visit_shape(
          [](const auto& s) {
            if constexpr (std::same_as<std::remove_cvref_t<decltype(s)>, TriangleMesh<S>>) {
              return Prepared(detail::MeshTree<S>(s));
            } else {
              return Prepared(s);
            }
          },
          shape)),
      bounds_(local_bounds(shape)),
      mass_properties_(unit_mass_properties(shape)),
      precise_(detail::visit_shape(detail::ShapeCast<detail::Precise<S>, S>{}, shape)) {
  if (const auto* tree = std::get_if<detail::MeshTree<S>>(&shape_)) {
    solid_.mesh.emplace(*tree);
    return;
  }
  detail::visit_shape(
      [this](const auto& s) {
        if constexpr (requires { detail::convex_view(s); })
          solid_.convex.emplace(detail::convex_view(s));
      },
      precise_);
}

template <Scalar S>
ShapeKind AnalyticBackend::kind(const std::shared_ptr<const detail::AnalyticShape<S>>& c) {
  return static_cast<ShapeKind>(c->shape().index());
}

template <Scalar S>
Aabb<S> AnalyticBackend::bounds(const std::shared_ptr<const detail::AnalyticShape<S>>& c) {
  return c->bounds();
}

template <Scalar S>
MassProperties<S> AnalyticBackend::mass_properties(
    const std::shared_ptr<const detail::AnalyticShape<S>>& c) {
  return c->mass_properties();
}

template <Scalar S>
bool AnalyticBackend::is_clear(const std::shared_ptr<const detail::AnalyticShape<S>>& c,
                               const Transform<S>& X_RC, const RayBatch<S>& rays) noexcept {
  const auto* mesh = std::get_if<detail::MeshTree<S>>(&c->shape());
  return mesh != nullptr && detail::misses_mesh(mesh->for_rays(), X_RC, rays);
}

template <Scalar S>
Shape<S> AnalyticBackend::shape(const std::shared_ptr<const detail::AnalyticShape<S>>& c) {
  return detail::visit_shape(
      [](const auto& prepared) -> Shape<S> {
        using Prepared = std::remove_cvref_t<decltype(prepared)>;
        if constexpr (std::is_same_v<Prepared, detail::MeshTree<S>>) {
          return prepared.mesh();
        } else {
          return prepared;
        }
      },
      c->shape());
}

template <Scalar S, typename Visit>
void AnalyticBackend::visit_solid(const std::shared_ptr<const detail::AnalyticShape<S>>& c,
                                  Visit&& visit) {
  const auto& solid = c->solid();
  if (solid.mesh) {
    visit(*solid.mesh);
  } else if (solid.convex) {
    visit(*solid.convex);
  } else {
    visit(std::get<HalfSpace<detail::Precise<S>>>(
        detail::ShapeCast<detail::Precise<S>, S>{}(std::get<HalfSpace<S>>(c->shape()))));
  }
}

/// As declared: throws InvalidArgument as `validate`.
template <Scalar S>
auto AnalyticBackend::make(const Shape<S>& shape) -> Collidable<S> {
  validate(shape);
  return std::make_shared<const detail::AnalyticShape<S>>(shape);
}

template <Scalar S>
ContactStatus AnalyticBackend::collide(const std::shared_ptr<const detail::AnalyticShape<S>>& a,
                                       const std::shared_ptr<const detail::AnalyticShape<S>>& b,
                                       const Transform<S>& X_AB, S margin,
                                       ContactManifolds<S>& out) noexcept {
  if (!can_collide(kind(a), kind(b))) return ContactStatus::failed;
  const std::size_t before = out.size();
  if (detail::collide_in_closed_form(a->shape(), b->shape(), X_AB, margin, out)) {
    return ContactStatus::ok;
  }
  if (detail::collide_in_closed_form(b->shape(), a->shape(), X_AB.inverse(), margin, out)) {
    detail::swap_sides<S>(std::span(out).subspan(before), X_AB);
    return ContactStatus::ok;
  }
  using P = detail::Precise<S>;
  detail::ContactSink<S> sink(out);
  const Transform<P> X = X_AB.template cast<P>();
  const auto collide_plane = [&](const auto& plane, const auto& other, const Transform<P>& X_PO) {
    const auto& half_space = std::get<HalfSpace<S>>(plane->shape());
    detail::collide_plane_mesh<S>(
        HalfSpace<P>{half_space.normal.template cast<P>(), P(half_space.offset)},
        *other->solid().mesh, X_PO, P(margin), sink);
  };
  bool is_known = true;
  if (kind(a) == ShapeKind::half_space) {
    sink.set_frame(X, false);
    collide_plane(a, b, X);
  } else if (kind(b) == ShapeKind::half_space) {
    sink.set_frame({}, true);
    collide_plane(b, a, X.inverse());
  } else {
    is_known =
        detail::collide_solids<detail::GjkDistance>(a->solid(), b->solid(), X, P(margin), sink);
  }
  if (is_known && sink.is_sound()) return ContactStatus::ok;
  sink.clear();
  return ContactStatus::failed;
}

template <Scalar S>
void AnalyticBackend::cast_rays(const std::shared_ptr<const detail::AnalyticShape<S>>& c,
                                const Transform<S>& X_RC, const RayBatch<S>& rays,
                                std::uint32_t tag, RayHits<S>& hits) noexcept {
  // One dispatch for the whole batch.
  detail::visit_shape(
      [&](const auto& shape) {
        if constexpr (std::same_as<std::remove_cvref_t<decltype(shape)>, detail::MeshTree<S>>) {
          detail::cast_rays_at_mesh(shape.for_rays(), X_RC, rays, tag, hits);
        } else {
          detail::cast_rays_in_lanes(shape, X_RC, rays, tag, hits);
        }
      },
      c->shape());
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

BRISTLE_BACKEND_QUERIES(extern template, AnalyticBackend, float)
BRISTLE_BACKEND_QUERIES(extern template, AnalyticBackend, double)
BRISTLE_BACKEND_MAKERS(extern template, AnalyticBackend, float)
BRISTLE_BACKEND_MAKERS(extern template, AnalyticBackend, double)

}  // namespace bristle::inline BRISTLE_ABI
#endif
