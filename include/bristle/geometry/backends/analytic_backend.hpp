/// @file
/// The shape backend that needs nothing but Eigen.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/backends/shape_backend.hpp>

#include <cstdint>
#include <memory>

namespace bristle::inline BRISTLE_ABI {

template <Scalar S>
class AnalyticShape;

/// Rays in closed form against every shape. Contacts in closed form where analytic_contacts.hpp and
/// box_box.hpp have a formula, which is computed in S; all others as solid_contacts.hpp finds them,
/// in `Precise<S>`. Satisfies `ShapeBackend`, which says what each function does.
struct AnalyticBackend {
  template <Scalar S>
  using Collidable = std::shared_ptr<const AnalyticShape<S>>;

  static constexpr bool asks_slices = true;

  template <Scalar S>
  [[nodiscard]] static Collidable<S> make(const Shape<S>& shape);

  template <Scalar S>
  [[nodiscard]] static ShapeKind kind(const std::shared_ptr<const AnalyticShape<S>>& c);
  template <Scalar S>
  [[nodiscard]] static Aabb<S> bounds(const std::shared_ptr<const AnalyticShape<S>>& c);
  template <Scalar S>
  [[nodiscard]] static MassProperties<S> mass_properties(
      const std::shared_ptr<const AnalyticShape<S>>& c);

  /// All pairs but two half-spaces.
  [[nodiscard]] static constexpr bool can_collide(ShapeKind a, ShapeKind b) {
    return a != ShapeKind::half_space || b != ShapeKind::half_space;
  }

  template <Scalar S>
  static ContactStatus collide(const std::shared_ptr<const AnalyticShape<S>>& a,
                               const std::shared_ptr<const AnalyticShape<S>>& b,
                               const Transform<S>& X_AB, S margin,
                               ContactManifolds<S>& out) noexcept;

  template <Scalar S>
  static void cast_rays(const std::shared_ptr<const AnalyticShape<S>>& c, const Transform<S>& X_RC,
                        const RayBatch<S>& rays, std::uint32_t tag, RayHits<S>& hits) noexcept;

  /// Meshes only.
  template <Scalar S>
  [[nodiscard]] static bool is_clear(const std::shared_ptr<const AnalyticShape<S>>& c,
                                     const Transform<S>& X_RC, const RayBatch<S>& rays) noexcept;
};

}  // namespace bristle::inline BRISTLE_ABI

// Implementation -----------------------------------------------------------------------------------

#if BRISTLE_HAS_DEFINITIONS
#include <bristle/geometry/contacts/analytic_contacts.hpp>
#include <bristle/geometry/contacts/box_box.hpp>
#include <bristle/geometry/contacts/shape_cast.hpp>
#include <bristle/geometry/contacts/solid_contacts.hpp>
#include <bristle/geometry/meshes/mesh_tree.hpp>
#include <bristle/geometry/rays/bundle_mesh_rays.hpp>
#include <bristle/geometry/rays/ray_lanes.hpp>
#include <bristle/geometry/rays/ray_shapes.hpp>
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

/// A shape as `AnalyticBackend` keeps it: checked, measured, with a tree and a surface if it is a
/// mesh, and seen as a solid.
template <Scalar S>
class AnalyticShape {
 public:
  /// The alternatives of `Shape` in the same order.
  using Prepared = std::variant<Sphere<S>, Box<S>, Capsule<S>, Cylinder<S>, Cone<S>, Ellipsoid<S>,
                                HalfSpace<S>, ConvexHull<S>, MeshTree<S>>;

  /// @pre `validate(shape)` has passed.
  explicit AnalyticShape(const Shape<S>& shape);
  // What it is seen as points into it.
  AnalyticShape(const AnalyticShape&) = delete;
  AnalyticShape& operator=(const AnalyticShape&) = delete;

  [[nodiscard]] const Prepared& shape() const { return shape_; }
  /// [m] In the shape's own frame.
  [[nodiscard]] const Aabb<S>& bounds() const { return bounds_; }
  /// [kg] and so on, at unit density.
  [[nodiscard]] const MassProperties<S>& mass_properties() const { return mass_properties_; }
  /// For iterative contacts; empty for a half-space.
  [[nodiscard]] const SolidView<Precise<S>, MeshTree<S>>& solid() const { return solid_; }

 private:
  Prepared shape_;
  Aabb<S> bounds_;
  MassProperties<S> mass_properties_;
  // Of convex shapes: themselves, in the scalar that iterations want.
  Shape<Precise<S>> precise_;
  SolidView<Precise<S>, MeshTree<S>> solid_;
};

namespace detail {

/// There is a formula for A and B in this order.
template <typename A, typename B, typename S>
concept AnalyticPair = requires(const A& a, const B& b, const Transform<S>& X, S margin,
                                ContactManifolds<S>& out) {
  collide_shapes(a, b, X, margin, out);
};

/// Adds the manifolds of A and B if there is a formula for them in this order. One shape after the
/// other: a table of all pairs would have nine times as many entries, most of them empty.
/// @return Whether there is.
template <typename Prepared, Scalar S>
bool collide_in_closed_form(const Prepared& a, const Prepared& b, const Transform<S>& X_AB,
                            S margin, ContactManifolds<S>& out) {
  const auto collide_with = [&](const auto& shape_a) {
    return std::visit(
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

/// Manifolds of (B, A) in B turned into those of (A, B) in A.
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
AnalyticShape<S>::AnalyticShape(const Shape<S>& shape)
    : shape_(std::visit(
          [](const auto& s) {
            if constexpr (std::same_as<std::remove_cvref_t<decltype(s)>, TriangleMesh<S>>) {
              return Prepared(MeshTree<S>(s));
            } else {
              return Prepared(s);
            }
          },
          shape)),
      bounds_(local_bounds(shape)),
      mass_properties_(unit_mass_properties(shape)),
      precise_(std::visit(detail::ShapeCast<Precise<S>, S>{}, shape)) {
  if (const auto* tree = std::get_if<MeshTree<S>>(&shape_)) {
    solid_.mesh.emplace(*tree);
    return;
  }
  std::visit(
      [this](const auto& s) {
        if constexpr (requires { convex_view(s); }) solid_.convex.emplace(convex_view(s));
      },
      precise_);
}

template <Scalar S>
ShapeKind AnalyticBackend::kind(const std::shared_ptr<const AnalyticShape<S>>& c) {
  return static_cast<ShapeKind>(c->shape().index());
}

template <Scalar S>
Aabb<S> AnalyticBackend::bounds(const std::shared_ptr<const AnalyticShape<S>>& c) {
  return c->bounds();
}

template <Scalar S>
MassProperties<S> AnalyticBackend::mass_properties(
    const std::shared_ptr<const AnalyticShape<S>>& c) {
  return c->mass_properties();
}

template <Scalar S>
bool AnalyticBackend::is_clear(const std::shared_ptr<const AnalyticShape<S>>& c,
                               const Transform<S>& X_RC, const RayBatch<S>& rays) noexcept {
  const auto* mesh = std::get_if<MeshTree<S>>(&c->shape());
  return mesh != nullptr && is_clear_of_mesh(mesh->for_rays(), X_RC, rays);
}

template <Scalar S>
auto AnalyticBackend::make(const Shape<S>& shape) -> Collidable<S> {
  validate(shape);
  return std::make_shared<const AnalyticShape<S>>(shape);
}

template <Scalar S>
ContactStatus AnalyticBackend::collide(const std::shared_ptr<const AnalyticShape<S>>& a,
                                       const std::shared_ptr<const AnalyticShape<S>>& b,
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
  using P = Precise<S>;
  ContactSink<S> sink(out);
  const Transform<P> X = X_AB.template cast<P>();
  if (collide_solids<GjkDistance>(a->solid(), b->solid(), X, P(margin), sink) && sink.is_sound()) {
    return ContactStatus::ok;
  }
  sink.clear();
  return ContactStatus::failed;
}

template <Scalar S>
void AnalyticBackend::cast_rays(const std::shared_ptr<const AnalyticShape<S>>& c,
                                const Transform<S>& X_RC, const RayBatch<S>& rays,
                                std::uint32_t tag, RayHits<S>& hits) noexcept {
  // One dispatch for the whole batch.
  std::visit(
      [&](const auto& shape) {
        if constexpr (std::same_as<std::remove_cvref_t<decltype(shape)>, MeshTree<S>>) {
          cast_rays_at_mesh(shape.for_rays(), X_RC, rays, tag, hits);
        } else {
          cast_rays_in_lanes(shape, X_RC, rays, tag, hits);
        }
      },
      c->shape());
}

}  // namespace bristle::inline BRISTLE_ABI
#endif

#if defined(BRISTLE_COMPILED) && BRISTLE_HAS_DEFINITIONS
namespace bristle::inline BRISTLE_ABI {

BRISTLE_BACKEND_FUNCTIONS(extern template, AnalyticBackend, float)
BRISTLE_BACKEND_FUNCTIONS(extern template, AnalyticBackend, double)

}  // namespace bristle::inline BRISTLE_ABI
#endif
