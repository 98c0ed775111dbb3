/// @file
/// The shape backend that needs nothing but Eigen.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/analytic_contacts.hpp>
#include <bristle/geometry/box_box.hpp>
#include <bristle/geometry/mesh_tree.hpp>
#include <bristle/geometry/ray_shapes.hpp>
#include <bristle/geometry/shape_backend.hpp>
#include <bristle/geometry/shape_properties.hpp>

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

namespace bristle {

/// A shape as `AnalyticBackend` keeps it: checked, measured, and with a tree if it is a mesh.
template <Scalar S>
struct AnalyticShape {
  /// The alternatives of `Shape` in the same order.
  std::variant<Sphere<S>, Box<S>, Capsule<S>, Cylinder<S>, Cone<S>, Ellipsoid<S>, HalfSpace<S>,
               ConvexHull<S>, MeshTree<S>>
      shape;
  /// [m] In the shape's own frame.
  Aabb<S> bounds;
  /// [kg] and so on, at unit density.
  MassProperties<S> mass_properties;
};

/// Rays in closed form against every shape, and contacts of the pairs for which
/// analytic_contacts.hpp has a formula. Satisfies `ShapeBackend`, which says what each function
/// does.
struct AnalyticBackend {
  template <Scalar S>
  using Collidable = std::shared_ptr<const AnalyticShape<S>>;

  template <Scalar S>
  [[nodiscard]] static Collidable<S> make(const Shape<S>& shape);

  template <Scalar S>
  [[nodiscard]] static ShapeKind kind(const std::shared_ptr<const AnalyticShape<S>>& c) {
    return static_cast<ShapeKind>(c->shape.index());
  }
  template <Scalar S>
  [[nodiscard]] static Aabb<S> bounds(const std::shared_ptr<const AnalyticShape<S>>& c) {
    return c->bounds;
  }
  template <Scalar S>
  [[nodiscard]] static MassProperties<S> mass_properties(
      const std::shared_ptr<const AnalyticShape<S>>& c) {
    return c->mass_properties;
  }

  /// Today: sphere, box, capsule and half-space among each other, but for capsule with box; and
  /// every shape with a half-space. Two half-spaces never collide.
  [[nodiscard]] static constexpr bool can_collide(ShapeKind a, ShapeKind b);

  template <Scalar S>
  static ContactStatus collide(const std::shared_ptr<const AnalyticShape<S>>& a,
                               const std::shared_ptr<const AnalyticShape<S>>& b,
                               const Transform<S>& X_AB, S margin,
                               ContactManifolds<S>& out) noexcept;

  template <Scalar S>
  static void cast_rays(const std::shared_ptr<const AnalyticShape<S>>& c, const Transform<S>& X_RC,
                        const RayBatch<S>& rays, std::uint32_t tag, RayHits<S>& hits) noexcept;
};

// Implementation -----------------------------------------------------------------------------------

namespace detail {

/// Whether there is a formula for A and B in this order.
template <typename A, typename B, typename S>
concept AnalyticPair = requires(const A& a, const B& b, const Transform<S>& X, S margin,
                                ContactManifolds<S>& out) {
  collide_shapes(a, b, X, margin, out);
};

/// Which kinds `AnalyticBackend` can collide, read off the overloads there are.
template <Scalar S>
struct AnalyticPairs {
  using Variant = decltype(AnalyticShape<S>::shape);
  template <std::size_t I>
  using Alternative = std::variant_alternative_t<I, Variant>;

  template <std::size_t I, std::size_t... J>
  [[nodiscard]] static constexpr std::array<bool, sizeof...(J)> row(std::index_sequence<J...>) {
    return {(AnalyticPair<Alternative<I>, Alternative<J>, S> ||
             AnalyticPair<Alternative<J>, Alternative<I>, S>)...};
  }
  template <std::size_t... I>
  [[nodiscard]] static constexpr auto table(std::index_sequence<I...> all) {
    return std::array{row<I>(all)...};
  }
};

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
auto AnalyticBackend::make(const Shape<S>& shape) -> Collidable<S> {
  validate(shape);
  using Prepared = decltype(AnalyticShape<S>::shape);
  Prepared prepared = std::visit(
      [](const auto& s) {
        if constexpr (std::same_as<std::remove_cvref_t<decltype(s)>, TriangleMesh<S>>) {
          return Prepared(MeshTree<S>(s));
        } else {
          return Prepared(s);
        }
      },
      shape);
  return std::make_shared<const AnalyticShape<S>>(
      AnalyticShape<S>{std::move(prepared), local_bounds(shape), unit_mass_properties(shape)});
}

constexpr bool AnalyticBackend::can_collide(ShapeKind a, ShapeKind b) {
  constexpr auto table =
      detail::AnalyticPairs<double>::table(std::make_index_sequence<shape_kind_count>{});
  return table[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
}

template <Scalar S>
ContactStatus AnalyticBackend::collide(const std::shared_ptr<const AnalyticShape<S>>& a,
                                       const std::shared_ptr<const AnalyticShape<S>>& b,
                                       const Transform<S>& X_AB, S margin,
                                       ContactManifolds<S>& out) noexcept {
  return std::visit(
      [&](const auto& shape_a, const auto& shape_b) {
        using A = std::remove_cvref_t<decltype(shape_a)>;
        using B = std::remove_cvref_t<decltype(shape_b)>;
        if constexpr (detail::AnalyticPair<A, B, S>) {
          collide_shapes(shape_a, shape_b, X_AB, margin, out);
          return ContactStatus::ok;
        } else if constexpr (detail::AnalyticPair<B, A, S>) {
          const std::size_t before = out.size();
          collide_shapes(shape_b, shape_a, X_AB.inverse(), margin, out);
          detail::swap_sides<S>(std::span(out).subspan(before), X_AB);
          return ContactStatus::ok;
        } else {
          return ContactStatus::failed;
        }
      },
      a->shape, b->shape);
}

template <Scalar S>
void AnalyticBackend::cast_rays(const std::shared_ptr<const AnalyticShape<S>>& c,
                                const Transform<S>& X_RC, const RayBatch<S>& rays,
                                std::uint32_t tag, RayHits<S>& hits) noexcept {
  const Mat3<S> R_RC = X_RC.rotation_matrix();
  const Mat3<S> R_CR = R_RC.transpose();
  // One dispatch for the whole batch.
  std::visit(
      [&](const auto& shape) {
        for (std::size_t i = 0; i < rays.size(); ++i) {
          const S best = hits.distance[i];
          if (!(best > S(0))) continue;
          const Ray<S> ray = rays[i];
          const Ray<S> ray_C{R_CR * (ray.origin - X_RC.translation), R_CR * ray.direction,
                             std::min(ray.length, best)};
          const RayHit<S> hit = ray_cast(shape, ray_C);
          if (hit.distance < best) hits.offer(i, {hit.distance, R_RC * hit.normal}, tag);
        }
      },
      c->shape);
}

static_assert(ShapeBackend<AnalyticBackend, float> && ShapeBackend<AnalyticBackend, double>);

}  // namespace bristle
