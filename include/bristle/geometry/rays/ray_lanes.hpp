/// @file
/// Hits of rays in lanes with shapes. These are the closed forms of ray_shapes.hpp without
/// branches. That file explains the forms and cites their sources.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/rays/ray.hpp>
#include <bristle/geometry/shapes/shapes.hpp>
#include <bristle/math/pack3.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace bristle::inline BRISTLE_ABI::detail {

/// A ray for each lane, in the shape's frame.
template <Scalar S>
struct RayLanes {
  Pack3<S> origin, direction;
  Pack<S> length;
};

/// A hit for each lane, as `RayHit`. Lanes without a hit have an infinite distance.
template <Scalar S>
struct RayHitLanes {
  Pack<S> distance;
  Pack3<S> normal;
};

/// Offers to `hits` the nearest hit of each ray with a shape at X_RC, as `ShapeBackend::cast_rays`
/// does.
template <Scalar S, typename ConvexShape>
void cast_rays_in_lanes(const ConvexShape& shape, const Transform<S>& X_RC, const RayBatch<S>& rays,
                        std::uint32_t tag, RayHits<S>& hits);

// Implementation ----------------------------------------------------------------------------------

/// A hit at `distance` if `is_hit` and the ray reaches it. At the start if `is_inside`.
template <Scalar S>
BRISTLE_FORCE_INLINE RayHitLanes<S> hit_mask(const RayLanes<S>& ray, const Mask<S>& is_inside,
                                             const Mask<S>& is_hit, const Pack<S>& distance,
                                             const Pack3<S>& normal) {
  const Mask<S> counts = is_hit & (distance <= ray.length) & (distance < Pack<S>(infinity<S>));
  const Pack<S> there = select(counts, max(distance, Pack<S>(S(0))), Pack<S>(infinity<S>));
  return {select(is_inside, Pack<S>(S(0)), there), select(is_inside, -ray.direction, normal)};
}

template <Scalar S>
BRISTLE_FORCE_INLINE RayHitLanes<S> no_hits() {
  const Pack<S> zero(S(0));
  return {Pack<S>(infinity<S>), {zero, zero, zero}};
}

/// True if rays are long enough to reach the surroundings of a core, up to rounding. The early out
/// pays if only a part of a patch touches. Many rays are then too short, and neighbours are alike.
/// @param apart2  [m^2] Squared distance of their starts from the core.
/// @param radius  [m] Radius of the shape around its core.
/// @param extent  [m] Radius of the shape around its origin, to which rounding is relative, too.
template <Scalar S>
BRISTLE_FORCE_INLINE Mask<S> may_reach(const RayLanes<S>& ray, const Pack<S>& apart2, S radius,
                                       S extent) {
  constexpr S slack = Tolerance<S>::round_off();
  const Pack<S> reach = (S(1) + slack) * (ray.length + radius) + slack * extent;
  return apart2 <= reach * reach;
}

template <Scalar S>
BRISTLE_FORCE_INLINE Pack3<S> normalized(const Pack3<S>& v) {
  return (S(1) / sqrt(dot(v, v))) * v;
}

/// Normalises vectors that are unit to round-off, without root and division: of the square 1 + e,
/// which becomes 1 - 3/4 e^2. Exact normalisation if the error would show in a lane that matters.
template <Scalar S>
BRISTLE_FORCE_INLINE Pack3<S> renormalized(const Pack3<S>& v, const Mask<S>& matters) {
  const Pack<S> excess = dot(v, v) - S(1);
  if (any(matters & !(abs(excess) <= Pack<S>(Tolerance<S>::equal())))) return normalized(v);
  return (S(1) - S(0.5) * excess) * v;
}

/// `Chord` in lanes.
template <Scalar S>
struct ChordLanes {
  Pack<S> enter{-infinity<S>};
  Pack<S> leave{infinity<S>};

  [[nodiscard]] BRISTLE_FORCE_INLINE Mask<S> is_ahead() const {
    return (enter <= leave) & (enter + leave >= Pack<S>(S(0)));
  }
};

template <Scalar S>
BRISTLE_FORCE_INLINE ChordLanes<S> slab_chord(const Pack<S>& origin, const Pack<S>& direction,
                                              S low, S high) {
  const Pack<S> inverse = S(1) / direction;
  const Pack<S> to_low = (low - origin) * inverse;
  const Pack<S> to_high = (high - origin) * inverse;
  const Mask<S> is_down = inverse < Pack<S>(S(0));
  // max and min ignore a NaN.
  return {max(select(is_down, to_high, to_low), Pack<S>(-infinity<S>)),
          min(select(is_down, to_low, to_high), Pack<S>(infinity<S>))};
}

/// The slab of a box about the axis of one coordinate. Rays mostly stay between two of the pairs of
/// planes. Those bound nothing, and need no division.
template <Scalar S>
BRISTLE_FORCE_INLINE ChordLanes<S> box_chord(const Pack<S>& origin, const Pack<S>& direction,
                                             const Pack<S>& length, S half) {
  const Pack<S> end = origin + length * direction;
  if (all((abs(origin) < Pack<S>(half)) & (abs(end) < Pack<S>(half)))) return {};
  return slab_chord(origin, direction, -half, half);
}

/// `Roots` in lanes, in ascending order.
template <Scalar S>
BRISTLE_FORCE_INLINE ChordLanes<S> roots(const Pack<S>& a, const Pack<S>& b, const Pack<S>& c,
                                         const Pack<S>& root) {
  const Pack<S> zero(S(0));
  const Pack<S> far(infinity<S>);
  const Pack<S> q = select(b < zero, b - root, b + root);
  const Pack<S> first = select(a != zero, q / a, select(b < zero, far, -far));
  const Pack<S> second = select(q != zero, c / q, zero);
  return {min(first, second), max(first, second)};
}

template <Scalar S>
BRISTLE_FORCE_INLINE ChordLanes<S> tube_chord(const Pack3<S>& origin, const Pack3<S>& direction,
                                              S radius) {
  const Pack<S> zero(S(0));
  const Pack<S> far(infinity<S>);
  const Pack<S> a = direction.x * direction.x + direction.y * direction.y;
  const Pack<S> b = -(origin.x * direction.x + origin.y * direction.y);
  const Pack<S> distance = sqrt(origin.x * origin.x + origin.y * origin.y);
  const Pack<S> c = (distance - radius) * (distance + radius);
  const Pack<S> cross = origin.x * direction.y - origin.y * direction.x;
  const Pack<S> discriminant = a * (radius * radius) - cross * cross;
  const ChordLanes<S> sloping = roots(a, b, c, sqrt(max(discriminant, zero)));
  const Mask<S> is_along = !(a > zero);
  const Mask<S> is_missed = (is_along & !(c <= zero)) | ((discriminant < zero) & !is_along);
  return {select(is_missed, far, select(is_along, -far, sloping.enter)),
          select(is_missed, -far, select(is_along, far, sloping.leave))};
}

/// `Approach` in lanes.
template <Scalar S>
struct ApproachLanes {
  Pack<S> skipped;
  Pack3<S> origin;
  Mask<S> is_near;

  BRISTLE_FORCE_INLINE ApproachLanes(const RayLanes<S>& ray, S radius) {
    const Pack<S> closest = -dot(ray.origin, ray.direction);
    skipped = select(closest > Pack<S>(radius), closest - radius, Pack<S>(S(0)));
    origin = ray.origin + skipped * ray.direction;
    const Pack3<S> foot = ray.origin + closest * ray.direction;
    is_near = dot(foot, foot) <= Pack<S>(S(chosen::ball_early_out_area) * radius * radius);
  }
};

template <Scalar S>
BRISTLE_FORCE_INLINE RayHitLanes<S> ray_cast(const Sphere<S>& sphere, const RayLanes<S>& ray) {
  const Pack<S> zero(S(0));
  const Pack<S> radius2(sphere.radius * sphere.radius);
  const Pack<S> apart2 = dot(ray.origin, ray.origin);
  if (none(may_reach(ray, apart2, sphere.radius, sphere.radius))) return no_hits<S>();
  const Pack<S> closest = -dot(ray.origin, ray.direction);
  const Pack3<S> foot = ray.origin + closest * ray.direction;
  const Pack<S> half2 = radius2 - dot(foot, foot);
  const Pack<S> half = sqrt(max(half2, zero));
  const Pack3<S> point = foot - half * ray.direction;
  const Mask<S> may_hit = (closest >= zero) & (half2 >= zero);
  return hit_mask(ray, apart2 <= radius2, may_hit, closest - half,
                  renormalized((S(1) / sphere.radius) * point, may_hit));
}

template <Scalar S>
BRISTLE_FORCE_INLINE RayHitLanes<S> ray_cast(const Box<S>& box, const RayLanes<S>& ray) {
  const Pack<S> zero(S(0));
  const Vec3<S>& half = box.half_extents;
  const ChordLanes<S> x = box_chord(ray.origin.x, ray.direction.x, ray.length, half.x());
  const ChordLanes<S> y = box_chord(ray.origin.y, ray.direction.y, ray.length, half.y());
  const ChordLanes<S> z = box_chord(ray.origin.z, ray.direction.z, ray.length, half.z());
  const Mask<S> y_later = y.enter > x.enter;
  const Pack<S> enter_xy = max(y.enter, x.enter);
  const Mask<S> z_later = z.enter > enter_xy;
  const ChordLanes<S> chord{max(z.enter, enter_xy), min(z.leave, min(y.leave, x.leave))};
  const auto against = [&](const Pack<S>& direction) {
    return select(direction > zero, Pack<S>(S(-1)), Pack<S>(S(1)));
  };
  const Pack3<S> normal{select(y_later | z_later, zero, against(ray.direction.x)),
                        select(y_later & !z_later, against(ray.direction.y), zero),
                        select(z_later, against(ray.direction.z), zero)};
  const Mask<S> is_inside = (abs(ray.origin.x) <= Pack<S>(half.x())) &
                            (abs(ray.origin.y) <= Pack<S>(half.y())) &
                            (abs(ray.origin.z) <= Pack<S>(half.z()));
  return hit_mask(ray, is_inside, chord.is_ahead(), chord.enter, normal);
}

/// Entry of rays into an infinite cylinder about the z axis: the nearer end of `tube_chord`.
template <Scalar S>
struct TubeEntry {
  Pack<S> distance;
  /// `is_met`: the line meets the cylinder. `is_ahead`: it does so in front of the start, as the
  /// line's point nearest to the axis is ahead.
  Mask<S> is_met, is_ahead;

  BRISTLE_FORCE_INLINE TubeEntry(const Pack3<S>& origin, const Pack3<S>& direction, S radius) {
    const Pack<S> zero(S(0));
    const Pack<S> radius2(radius * radius);
    const Pack<S> a = direction.x * direction.x + direction.y * direction.y;
    const Pack<S> b = -(origin.x * direction.x + origin.y * direction.y);
    const Pack<S> c = origin.x * origin.x + origin.y * origin.y - radius2;
    const Pack<S> cross = origin.x * direction.y - origin.y * direction.x;
    const Pack<S> discriminant = a * radius2 - cross * cross;
    const Pack<S> q = b + sqrt(max(discriminant, zero));
    const Mask<S> is_sloping = a > zero;
    distance = select(q > zero, c / q, zero);
    const Mask<S> is_along = !is_sloping;
    is_met = (is_sloping & (discriminant >= zero)) | (is_along & (c <= zero));
    is_ahead = is_met & is_sloping & (b >= zero);
  }
};

template <Scalar S>
BRISTLE_FORCE_INLINE RayHitLanes<S> ray_cast(const Capsule<S>& capsule, const RayLanes<S>& ray) {
  const Pack<S> zero(S(0));
  const Pack<S> half(capsule.half_length);
  const Pack<S> radius2(capsule.radius * capsule.radius);
  const Pack3<S>& o = ray.origin;
  const Pack3<S> from_axis{o.x, o.y, o.z - max(-half, min(o.z, half))};
  const Pack<S> apart2 = dot(from_axis, from_axis);
  if (none(may_reach(ray, apart2, capsule.radius, capsule.half_length + capsule.radius)))
    return no_hits<S>();
  const auto against_end = [&](const Pack<S>& end) {
    const Pack3<S> from_end{o.x, o.y, o.z - end};
    return ray_cast(Sphere<S>{capsule.radius}, RayLanes<S>{from_end, ray.direction, ray.length});
  };
  // Neighbours that stay beyond one end meet only its ball. For a ray that grazes both the ball and
  // the tube, rounding and the branch taken decide on a hit.
  const Pack<S> last_z = o.z + ray.length * ray.direction.z;
  if (all((o.z > half) & (last_z > half))) return against_end(half);
  if (all((o.z < -half) & (last_z < -half))) return against_end(-half);
  const ApproachLanes<S> near(ray, capsule.half_length + capsule.radius);
  const TubeEntry<S> tube(near.origin, ray.direction, capsule.radius);
  const Mask<S> is_beyond_end =
      (abs(near.origin.z) > half) &
      (near.origin.x * near.origin.x + near.origin.y * near.origin.y <= radius2);
  const Pack3<S> point = near.origin + tube.distance * ray.direction;
  const Pack<S> z = select(is_beyond_end, near.origin.z, point.z);
  const Mask<S> may_hit = near.is_near & tube.is_met & (is_beyond_end | tube.is_ahead);
  const Mask<S> is_side = (abs(z) <= half) & !is_beyond_end;
  const Mask<S> is_inside = apart2 <= radius2;
  const Pack<S> inverse_radius(S(1) / capsule.radius);
  const RayHitLanes<S> side =
      hit_mask(ray, is_inside, may_hit & is_side, near.skipped + tube.distance,
               renormalized(Pack3<S>{inverse_radius * point.x, inverse_radius * point.y, zero},
                            may_hit & is_side));
  const Mask<S> takes_end = may_hit & !is_side & !is_inside;
  if (none(takes_end)) return side;
  const RayHitLanes<S> end = against_end(select(z < zero, -half, half));
  return {select(takes_end, end.distance, side.distance),
          select(takes_end, end.normal, side.normal)};
}

template <Scalar S>
BRISTLE_FORCE_INLINE RayHitLanes<S> ray_cast(const Cylinder<S>& cylinder, const RayLanes<S>& ray) {
  const Pack<S> zero(S(0));
  const S half = cylinder.half_length;
  const Pack3<S>& o = ray.origin;
  const Mask<S> is_inside = (o.x * o.x + o.y * o.y <= Pack<S>(cylinder.radius * cylinder.radius)) &
                            (abs(o.z) <= Pack<S>(half));
  const ApproachLanes<S> near(ray, half + cylinder.radius);
  const ChordLanes<S> tube = tube_chord(near.origin, ray.direction, cylinder.radius);
  const ChordLanes<S> slab = slab_chord(near.origin.z, ray.direction.z, -half, half);
  const ChordLanes<S> chord{near.skipped + max(tube.enter, slab.enter),
                            near.skipped + min(tube.leave, slab.leave)};
  const Pack3<S> point = near.origin + tube.enter * ray.direction;
  const Pack3<S> cap{zero, zero, select(ray.direction.z > zero, Pack<S>(S(-1)), Pack<S>(S(1)))};
  return hit_mask(
      ray, is_inside, near.is_near & chord.is_ahead(), chord.enter,
      select(slab.enter >= tube.enter, cap, normalized(Pack3<S>{point.x, point.y, zero})));
}

template <Scalar S>
BRISTLE_FORCE_INLINE RayHitLanes<S> ray_cast(const Cone<S>& cone, const RayLanes<S>& ray) {
  const Pack<S> zero(S(0));
  const Pack<S> one(S(1));
  const Pack<S> far(infinity<S>);
  const S height = S(2) * cone.half_length;
  const Pack<S> k(cone.radius / height);
  const auto across = [](const Pack3<S>& v) { return sqrt(v.x * v.x + v.y * v.y); };
  const Pack<S> start_depth = cone.half_length - ray.origin.z;
  const Mask<S> is_inside = (start_depth >= zero) & (start_depth <= Pack<S>(height)) &
                            (across(ray.origin) <= k * start_depth);
  const ApproachLanes<S> near(ray, cone.half_length + cone.radius);
  const Pack3<S>& o = near.origin;
  const Pack3<S>& d = ray.direction;
  const Pack<S> w = cone.half_length - o.z;
  const Pack<S> dw = -d.z;
  const Pack<S> a = d.x * d.x + d.y * d.y - k * k * dw * dw;
  const Pack<S> b = k * k * w * dw - (o.x * d.x + o.y * d.y);
  const Pack<S> c = (across(o) - k * w) * (across(o) + k * w);
  const Pack<S> cross = o.x * d.y - o.y * d.x;
  const Pack<S> mixed_x = w * d.x - dw * o.x;
  const Pack<S> mixed_y = w * d.y - dw * o.y;
  const Pack<S> discriminant = k * k * (mixed_x * mixed_x + mixed_y * mixed_y) - cross * cross;
  const ChordLanes<S> between = roots(a, b, c, sqrt(max(discriminant, zero)));
  const Mask<S> is_shallow = a > zero;
  const Mask<S> is_down = dw > zero;
  const ChordLanes<S> side{select(is_shallow, between.enter, select(is_down, between.leave, -far)),
                           select(is_shallow, between.leave, select(is_down, far, between.enter))};
  const ChordLanes<S> slab = slab_chord(w, dw, S(0), height);
  const ChordLanes<S> chord{near.skipped + max(side.enter, slab.enter),
                            near.skipped + min(side.leave, slab.leave)};
  const Pack3<S> point = o + side.enter * d;
  const Pack3<S> gradient{point.x, point.y, k * k * (cone.half_length - point.z)};
  const Mask<S> is_apex = !(dot(gradient, gradient) > zero);
  const Pack3<S> on_side = select(is_apex, Pack3<S>{zero, zero, one}, normalized(gradient));
  const Pack3<S> base{zero, zero, select(is_down, one, -one)};
  const Mask<S> may_hit = near.is_near & !((discriminant < zero) & is_shallow);
  return hit_mask(ray, is_inside, may_hit & chord.is_ahead(), chord.enter,
                  select(slab.enter >= side.enter, base, on_side));
}

template <Scalar S>
BRISTLE_FORCE_INLINE RayHitLanes<S> ray_cast(const Ellipsoid<S>& ellipsoid,
                                             const RayLanes<S>& ray) {
  const Pack<S> zero(S(0));
  const Vec3<S> scale = cwise_inverse(ellipsoid.radii);
  const auto scaled = [&](const Pack3<S>& v) {
    return Pack3<S>{v.x * scale.x(), v.y * scale.y(), v.z * scale.z()};
  };
  const Pack3<S> start = scaled(ray.origin);
  const ApproachLanes<S> near(ray, ellipsoid.radii.maxCoeff());
  const Pack3<S> o = scaled(near.origin);
  const Pack3<S> d = scaled(ray.direction);
  const Pack<S> speed2 = dot(d, d);
  const Pack<S> closest = -dot(o, d) / speed2;
  const Pack3<S> foot = o + closest * d;
  const Pack<S> half2 = (S(1) - dot(foot, foot)) / speed2;
  const Pack<S> half = sqrt(max(half2, zero));
  return hit_mask(ray, dot(start, start) <= Pack<S>(S(1)),
                  near.is_near & (near.skipped + closest >= zero) & (half2 >= zero),
                  near.skipped + (closest - half), normalized(scaled(foot - half * d)));
}

template <Scalar S>
BRISTLE_FORCE_INLINE RayHitLanes<S> ray_cast(const HalfSpace<S>& half_space,
                                             const RayLanes<S>& ray) {
  const Pack<S> zero(S(0));
  const Pack3<S> normal = Pack3<S>::all(half_space.normal);
  const Pack<S> height = dot(normal, ray.origin) - half_space.offset;
  const Pack<S> speed = dot(normal, ray.direction);
  return hit_mask(ray, height <= zero, speed < zero, height / -speed, normal);
}

template <Scalar S>
BRISTLE_FORCE_INLINE RayHitLanes<S> ray_cast(const ConvexHull<S>& hull, const RayLanes<S>& ray) {
  const Pack<S> zero(S(0));
  ChordLanes<S> chord;
  Pack3<S> normal{zero, zero, zero};
  Mask<S> is_inside = zero <= zero;
  Mask<S> is_passed = zero < zero;
  for (std::size_t f = 0; f < hull.face_count(); ++f) {
    const Pack3<S> face = Pack3<S>::all(hull.face_normals[f]);
    const Pack<S> height = dot(face, ray.origin) - hull.face_offsets[f];
    const Pack<S> speed = dot(face, ray.direction);
    const Pack<S> at = -height / speed;
    is_inside = is_inside & (height <= zero);
    const Mask<S> is_later = (speed < zero) & (at > chord.enter);
    chord.enter = select(is_later, at, chord.enter);
    normal = select(is_later, face, normal);
    chord.leave = select(speed > zero, min(at, chord.leave), chord.leave);
    is_passed = is_passed | ((speed == zero) & (height > zero));
  }
  return hit_mask(ray, is_inside, chord.is_ahead() & !is_passed, chord.enter, normal);
}

/// Where rays and their hits so far are stored, a row of numbers for each quantity.
template <Scalar S>
struct RayRows {
  /// Starts x, y, z, directions x, y, z, lengths.
  std::array<const S*, 7> rays;
  /// Distances, normals x, y, z.
  std::array<S*, 4> hits;
  std::uint32_t* tags;
};

/// Fewer rays than a pack has lanes, in rows of their own. The rest of the pack is filled with rays
/// that have been hit already.
template <Scalar S>
class PartOfPack {
 public:
  /// Copies `count` rays of `rows` from number `first` on.
  PartOfPack(const RayRows<S>& rows, std::size_t first, std::size_t count)
      : whole_(rows), first_(first), count_(count) {
    for (std::size_t r = 0; r < rows.rays.size(); ++r) {
      std::copy_n(rows.rays[r] + first, count, rays_[r].begin());
    }
    for (std::size_t r = 0; r < rows.hits.size(); ++r) {
      std::copy_n(rows.hits[r] + first, count, hits_[r].begin());
    }
    std::copy_n(rows.tags + first, count, tags_.begin());
  }

  [[nodiscard]] RayRows<S> rows() {
    RayRows<S> own;
    for (std::size_t r = 0; r < rays_.size(); ++r) own.rays[r] = rays_[r].data();
    for (std::size_t r = 0; r < hits_.size(); ++r) own.hits[r] = hits_[r].data();
    own.tags = tags_.data();
    return own;
  }

  /// Copies the hits back.
  void store() const {
    for (std::size_t r = 0; r < hits_.size(); ++r) {
      std::copy_n(hits_[r].begin(), count_, whole_.hits[r] + first_);
    }
    std::copy_n(tags_.begin(), count_, whole_.tags + first_);
  }

 private:
  using Row = std::array<S, lanes<S>>;

  RayRows<S> whole_;
  std::size_t first_;
  std::size_t count_;
  std::array<Row, 7> rays_{};
  std::array<Row, 4> hits_{};
  std::array<std::uint32_t, lanes<S>> tags_{};
};

/// A cast of packs of rays at one shape.
template <Scalar S>
struct PackCast {
  Mat3<S> R_RC, R_CR;
  Vec3<S> p_RC;
  S extra_length;
  std::uint32_t tag;
  const void* shape;
  /// Casts the rays from `first` to `end`, a whole number of packs.
  void (*cast)(const PackCast& self, RayRows<S> rows, std::size_t first, std::size_t end);

  /// Casts the rays from `first` to `end`.
  void operator()(const RayRows<S>& rows, std::size_t first, std::size_t end) const {
    const std::size_t rest = (end - first) % lanes<S>;
    if (rest < end - first) cast(*this, rows, first, end - rest);
    if (rest == 0) return;
    PartOfPack<S> part(rows, end - rest, rest);
    cast(*this, part.rows(), 0, lanes<S>);
    part.store();
  }
};

template <Scalar S, typename ConvexShape>
void cast_packs(const PackCast<S>& self, RayRows<S> rows, std::size_t first, std::size_t end) {
  // The loop has copies of its inputs: for all that a compiler knows, it writes hits over the
  // originals.
  const auto& shape = *static_cast<const ConvexShape*>(self.shape);
  const Mat3<S> R_RC = self.R_RC;
  const Mat3<S> R_CR = self.R_CR;
  const Pack3<S> p_RC = Pack3<S>::all(self.p_RC);
  const Pack<S> extra_length(self.extra_length);
  const std::uint32_t tag = self.tag;
  for (std::size_t i = first; i < end; i += lanes<S>) {
    const auto load = [&](std::size_t row) { return Pack<S>::load(rows.rays[row] + i); };
    const Pack<S> best = Pack<S>::load(rows.hits[0] + i);
    const Pack3<S> origin{load(0), load(1), load(2)};
    const Pack3<S> direction{load(3), load(4), load(5)};
    const Pack<S> length = load(6) + extra_length;
    const RayHitLanes<S> hit =
        ray_cast(shape, RayLanes<S>{R_CR * (origin - p_RC), R_CR * direction, min(length, best)});
    const Mask<S> is_nearer = hit.distance < best;
    if (none(is_nearer)) continue;
    const Pack3<S> normal = R_RC * hit.normal;
    const auto keep = [&](std::size_t row, const Pack<S>& value) {
      S* const p = rows.hits[row] + i;
      select(is_nearer, value, Pack<S>::load(p)).store(p);
    };
    keep(0, hit.distance);
    keep(1, normal.x);
    keep(2, normal.y);
    keep(3, normal.z);
    std::uint32_t* const tags = rows.tags + i;
    if (all(is_nearer)) {
      std::fill_n(tags, lanes<S>, tag);
      continue;
    }
    const std::uint32_t met = bits(is_nearer);
    // Compilers vectorise this selection, since it works by masks.
    for (std::uint32_t k = 0; k < lanes<S>; ++k) {
      tags[k] ^= (tags[k] ^ tag) & (0u - (met >> k & 1u));
    }
  }
}

/// Casts those rays of a batch that are asked for.
template <Scalar S>
void cast_in_packs(const PackCast<S>& cast, const RayBatch<S>& rays, RayHits<S>& hits) {
  const RayRows<S> rows{
      {rays.origin_x.data(), rays.origin_y.data(), rays.origin_z.data(), rays.direction_x.data(),
       rays.direction_y.data(), rays.direction_z.data(), rays.length.data()},
      {hits.distance.data(), hits.normal.x.data(), hits.normal.y.data(), hits.normal.z.data()},
      hits.tag.data()};
  const std::size_t n = std::min<std::size_t>(rays.range.end, rays.size());
  if (rays.near_packets == nullptr) {
    if (rays.range.first < n) cast(rows, rays.range.first, n);
    return;
  }
  auto near = std::lower_bound(rays.near_packets->begin(), rays.near_packets->end(),
                               rays.range.first / packet_size);
  // Neighbours are cast at once: a packet may be a single pack.
  while (near != rays.near_packets->end() && *near * packet_size < n) {
    const std::size_t first = *near * packet_size;
    std::size_t end = first;
    for (; near != rays.near_packets->end() && *near * packet_size == end; ++near) {
      end += packet_size;
    }
    cast(rows, first, std::min(n, end));
  }
}

template <Scalar S, typename ConvexShape>
void cast_rays_in_lanes(const ConvexShape& shape, const Transform<S>& X_RC, const RayBatch<S>& rays,
                        std::uint32_t tag, RayHits<S>& hits) {
  const Mat3<S> R_RC = X_RC.rotation_matrix();
  cast_in_packs<S>({R_RC, transposed(R_RC), X_RC.translation, rays.extra_length, tag, &shape,
                    &cast_packs<S, ConvexShape>},
                   rays, hits);
}

}  // namespace bristle::inline BRISTLE_ABI::detail
