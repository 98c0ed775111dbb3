/// @file
/// Definitions of `World`: queries with rays and shapes. Included by world.hpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/contacts/convex_query.hpp>
#include <bristle/geometry/contacts/shape_cast.hpp>
#include <bristle/geometry/shapes/convex_view.hpp>
#include <bristle/geometry/shapes/visit_shape.hpp>
#include <bristle/world/world.hpp>

#include <algorithm>
#include <limits>
#include <optional>
#include <variant>

namespace bristle::inline BRISTLE_ABI {

namespace detail {

/// A pose in the scalar of queries, with a rotation that is one in that scalar, too.
template <Scalar S>
[[nodiscard]] Transform<Precise<S>> precise(const Transform<S>& X) {
  Transform<Precise<S>> result = X.template cast<Precise<S>>();
  result.rotation.normalize();
  return result;
}

/// A convex shape placed in the world, to query with.
template <Scalar S>
class ShapeQuery {
 public:
  using P = Precise<S>;

  /// @throws InvalidArgument when the shape is not valid or not convex, or the pose not finite.
  ShapeQuery(const Shape<S>& shape, const Transform<S>& X_WQ)
      : shape_(checked(shape, X_WQ)), pose_(precise(X_WQ)) {
    visit_shape(
        [this](const auto& s) {
          if constexpr (requires { convex_view(s); }) view_.emplace(convex_view(s));
        },
        shape_);
  }
  /// A point is a ball without a radius, which no body could have.
  explicit ShapeQuery(const Vec3<S>& point) : shape_(Sphere<P>{P(0)}) {
    require_all_finite("point", point);
    pose_.translation = point.template cast<P>();
    view_.emplace(convex_view(std::get<Sphere<P>>(shape_)));
  }
  // `view_` points into this object.
  ShapeQuery(const ShapeQuery&) = delete;
  ShapeQuery& operator=(const ShapeQuery&) = delete;

  [[nodiscard]] const ConvexView<P>& view() const { return *view_; }
  /// [m] Box in the world.
  [[nodiscard]] Aabb<P> bounds() const { return bounds_at(*view_, pose_); }
  /// [m] A vector of the world in the frame of a target, in which the pose is X_TQ.
  [[nodiscard]] Vec3<P> in_target(const Transform<P>& X_TQ, const Vec3<P>& vector) const {
    return X_TQ.rotate(Vec3<P>(pose_.rotation.conjugate() * vector));
  }
  /// Pose in the frame of a target.
  [[nodiscard]] Transform<P> pose_in(const Transform<P>& X_WT) const {
    return X_WT.inverse() * pose_;
  }

 private:
  [[nodiscard]] static Shape<P> checked(const Shape<S>& shape, const Transform<S>& X_WQ) {
    const ShapeKind kind = kind_of(shape);
    require(kind != ShapeKind::half_space && kind != ShapeKind::triangle_mesh, "shape",
            name_of(kind), "must be convex and bounded: no half-space and no mesh");
    validate(shape);
    require_all_finite("X_WQ.translation", X_WQ.translation);
    require_unit<S>("X_WQ.rotation", X_WQ.rotation);
    return visit_shape(ShapeCast<P, S>{}, shape);
  }

  Shape<P> shape_;
  Transform<P> pose_{};
  std::optional<ConvexView<P>> view_;
};

/// The hit of a shape of a world, from what was found in the shape's frame.
template <Scalar S, Scalar P>
[[nodiscard]] WorldHit<S> world_hit(const WorldState<S>& state, std::uint32_t tag, P distance,
                                    const Vec3<P>& point_T, const Vec3<P>& normal_T) {
  const Collider<S>& c = state.colliders.at(tag);
  const Transform<P> X_WT = precise<S>(state.body_of(c).center_pose * c.X_CmS);
  WorldHit<S> hit;
  hit.distance = S(distance);
  hit.point = (X_WT * point_T).template cast<S>();
  hit.normal = X_WT.rotate(normal_T).template cast<S>();
  hit.body = c.body;
  hit.shape = state.colliders.handle(tag);
  return hit;
}

/// Calls visit(tag, solid, X_TQ) -> bool for every solid that a filter lets a query meet, whose box
/// in the world accept(box) takes, until a visit returns false.
template <Scalar S, typename Backend, typename Accept, typename Visit>
void for_each_solid(const WorldState<S>& state, const ShapeQuery<S>& query,
                    const QueryFilter& filter, Accept&& accept, Visit&& visit) {
  state.broad_phase.find(
      [&](const Aabb<S>& box) {
        // Boxes are rounded in the scalar of the world.
        using P = Precise<S>;
        const P size =
            std::max(P(box.lower.cwiseAbs().maxCoeff()), P(box.upper.cwiseAbs().maxCoeff()));
        const Aabb<P> precise_box{box.lower.template cast<P>(), box.upper.template cast<P>()};
        return accept(precise_box.inflated(P(Tolerance<S>::round_off()) * size));
      },
      [&](std::uint32_t tag) {
        const Collider<S>& c = state.colliders.at(tag);
        const Body<S>& body = state.body_of(c);
        if (!can_meet_shape(filter, c, body)) return true;
        const auto X_TQ = query.pose_in(precise<S>(body.center_pose * c.X_CmS));
        bool goes_on = true;
        Backend::visit_solid(c.shape.template as<typename Backend::template Collidable<S>>(),
                             [&](const auto& solid) { goes_on = visit(tag, solid, X_TQ); });
        return goes_on;
      });
}

/// A little more than a bound, so that what lies at the bound is found, too.
template <Scalar P>
[[nodiscard]] P beyond(const P& bound) {
  return bound * (P(1) + std::numeric_limits<P>::epsilon()) + std::numeric_limits<P>::min();
}

/// As `World::closest`.
template <Scalar S, typename Backend>
[[nodiscard]] WorldHit<S> find_closest(const WorldState<S>& state, const ShapeQuery<S>& query,
                                       S reach, const QueryFilter& filter) {
  using P = Precise<S>;
  require(reach > S(0), "reach", static_cast<double>(reach), "must be > 0");
  SolidGap<P> nearest;
  nearest.distance = beyond(P(reach));
  std::optional<std::uint32_t> nearest_tag;
  const Aabb<P> box = query.bounds();
  for_each_solid<S, Backend>(
      state, query, filter,
      [&](const Aabb<P>& other) {
        return other.distance2_to(box) <= nearest.distance * nearest.distance;
      },
      [&](std::uint32_t tag, const auto& solid, const Transform<P>& X_TQ) {
        SolidGap<P> gap;
        gap.distance = nearest_tag ? beyond(nearest.distance) : nearest.distance;
        const P bound = gap.distance;
        find_gap(solid, query.view(), X_TQ, gap);
        if (!(gap.distance < bound)) return true;
        const bool is_first = !nearest_tag || gap.distance < nearest.distance ||
                              (gap.distance == nearest.distance && tag < *nearest_tag);
        if (is_first) {
          nearest = gap;
          nearest_tag = tag;
        }
        return true;
      });
  if (!nearest_tag) return {};
  return world_hit(state, *nearest_tag, nearest.distance, nearest.point, nearest.normal);
}

}  // namespace detail

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
auto World<S, Backend>::cast_ray_through(const Ray<S>& ray, const QueryFilter& filter) const
    -> std::vector<WorldHit<S>> {
  detail::require_ray(ray);
  std::vector<WorldHit<S>> hits;
  RayHits<S> scratch;
  state_.broad_phase.walk_ray(ray, [&](std::uint32_t tag, S nearest) {
    const detail::Collider<S>& c = state_.colliders.at(tag);
    if (!detail::can_meet_shape(filter, c, state_.body_of(c))) return nearest;
    const RayHit<S> hit = detail::cast_ray_at(state_, tag, ray, ray.length, scratch);
    if (hit.distance < infinity<S>) hits.push_back(detail::world_hit(state_, tag, ray, hit));
    return nearest;
  });
  std::sort(hits.begin(), hits.end(), [](const WorldHit<S>& a, const WorldHit<S>& b) {
    return a.distance < b.distance || (a.distance == b.distance && a.shape < b.shape);
  });
  return hits;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
auto World<S, Backend>::overlaps(const Shape<S>& shape, const Transform<S>& X_WQ,
                                 const QueryFilter& filter) const -> std::vector<WorldHit<S>>
requires detail::ShowsSolids<Backend, S> {
  using P = detail::Precise<S>;
  const detail::ShapeQuery<S> query(shape, X_WQ);
  const Aabb<P> box = query.bounds();
  std::vector<WorldHit<S>> hits;
  detail::for_each_solid<S, Backend>(
      state_, query, filter, [&](const Aabb<P>& other) { return other.overlaps(box); },
      [&](std::uint32_t tag, const auto& solid, const Transform<P>& X_TQ) {
        detail::SolidGap<P> gap;
        gap.distance = std::numeric_limits<P>::min();
        detail::find_gap(solid, query.view(), X_TQ, gap);
        if (gap.distance == P(0)) {
          hits.push_back(detail::world_hit(state_, tag, gap.distance, gap.point, gap.normal));
        }
        return true;
      });
  std::sort(hits.begin(), hits.end(),
            [](const WorldHit<S>& a, const WorldHit<S>& b) { return a.shape < b.shape; });
  return hits;
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
auto World<S, Backend>::closest(const Shape<S>& shape, const Transform<S>& X_WQ, S reach,
                                const QueryFilter& filter) const -> WorldHit<S>
requires detail::ShowsSolids<Backend, S> {
  return detail::find_closest<S, Backend>(state_, detail::ShapeQuery<S>(shape, X_WQ), reach,
                                          filter);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
auto World<S, Backend>::closest(const Vec3<S>& point, S reach, const QueryFilter& filter) const
    -> WorldHit<S>
requires detail::ShowsSolids<Backend, S> {
  return detail::find_closest<S, Backend>(state_, detail::ShapeQuery<S>(point), reach, filter);
}

template <Scalar S, typename Backend>
requires ShapeBackend<Backend, S>
auto World<S, Backend>::cast_shape(const Shape<S>& shape, const Transform<S>& X_WQ,
                                   const Vec3<S>& way, const QueryFilter& filter) const
    -> WorldHit<S>
requires detail::ShowsSolids<Backend, S> {
  using P = detail::Precise<S>;
  const detail::ShapeQuery<S> query(shape, X_WQ);
  detail::require_all_finite("way", way);
  const P length = way.template cast<P>().stableNorm();
  detail::require(length > P(0), "way", static_cast<double>(length), "must not be zero");
  const Vec3<P> way_W = way.template cast<P>();
  // Poses are rounded in the scalar of the world.
  const P near = std::max(detail::Tolerance<P>::equal(), P(detail::Tolerance<S>::round_off()));
  detail::SolidTouch<P> first;
  first.fraction = detail::beyond(P(1));
  std::optional<std::uint32_t> first_tag;
  const Aabb<P> box = query.bounds();
  detail::for_each_solid<S, Backend>(
      state_, query, filter,
      [&](const Aabb<P>& other) {
        return box.swept(Vec3<P>(first.fraction * way_W)).overlaps(other);
      },
      [&](std::uint32_t tag, const auto& solid, const Transform<P>& X_TQ) {
        detail::SolidTouch<P> touch;
        touch.fraction = first_tag ? detail::beyond(first.fraction) : first.fraction;
        const P bound = touch.fraction;
        const Vec3<P> way_T = query.in_target(X_TQ, way_W);
        detail::find_touch(solid, query.view(), X_TQ, way_T, near, touch);
        if (!(touch.fraction < bound)) return true;
        if (!first_tag || touch.fraction < first.fraction ||
            (touch.fraction == first.fraction && tag < *first_tag)) {
          first = touch;
          first_tag = tag;
        }
        return true;
      });
  if (!first_tag) return {};
  return detail::world_hit(state_, *first_tag, P(first.fraction * length), first.point,
                           first.normal);
}

}  // namespace bristle::inline BRISTLE_ABI
