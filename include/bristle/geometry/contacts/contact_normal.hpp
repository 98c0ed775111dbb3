/// @file
/// Contact normal of two convex solids, apart or overlapping.
///
/// The overlap f(n) along a unit direction n is the distance that B must move along n to be free of
/// A. The gap is -f(n). The search for the direction of least overlap has this order.
///
/// 1. Face normals of both and the line of centres. A later direction must be better to replace
///    them. So resting contacts keep the normal of their face to the last bit.
/// 2. Distance of the cores, if they are apart.
/// 3. An expanding polytope (expanding_polytope.hpp), if they overlap. It finds the direction of
///    the global minimum, up to its resolution.
/// 4. Pushing. With the overlap f(n) and the push (f(n) + e) n the distance of the solids is at
///    least e. So the direction n' of that distance has f(n') = (f(n) + e) n.n' - distance <= f(n).
///    The limit is a local minimum. GJK is good at distances of solids that are well apart.
/// 5. Newton's method, if a solid is curved.
///
/// Supports check every direction, whatever the distance method said. Solids reported apart *are*
/// apart along it. The reported overlap is that along the normal. The larger solid has the size 1
/// throughout.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/config.hpp>
#include <bristle/geometry/contacts/expanding_polytope.hpp>
#include <bristle/geometry/contacts/gjk.hpp>
#include <bristle/geometry/geometry_constants.hpp>
#include <bristle/geometry/shapes/convex_view.hpp>
#include <bristle/geometry/shapes/visit_shape.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/transform.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <type_traits>
#include <variant>

namespace bristle::inline BRISTLE_ABI::detail {

/// Relation of a pair of convex solids.
enum class Nearness {
  /// They overlap, touch or are no farther apart than the margin. Normal and gap are valid.
  near,
  /// They are farther apart than the margin.
  apart,
  /// Unknown: the pose is not finite.
  unknown
};

/// Result of `contact_normal`.
template <Scalar S>
struct ContactNormal {
  Nearness nearness = Nearness::unknown;
  /// [1] Unit normal from A into B, in the frame of A.
  Vec3<S> normal = unit_z<Vec3<S>>();
  /// [m] Distance along the normal, negative where the solids overlap.
  S gap = S(0);
};

/// A solid in the frame and unit of a pair's search. Supports then need no tolerance with a length.
template <Scalar S>
struct PlacedConvex {
  const ConvexView<S>* convex;
  Mat3<S> rotation;
  Vec3<S> position;
  S scale;

  /// Farthest point of the core along a direction of any length > 0.
  [[nodiscard]] Vec3<S> support(const Vec3<S>& direction) const {
    return rotation * (scale * convex->support(rotation.transpose() * direction)) + position;
  }
};

/// Distance of two cores by the library's own GJK: the default method of `contact_normal`.
struct GjkDistance {
  template <Scalar S>
  [[nodiscard]] GjkResult<S> operator()(const PlacedConvex<S>& a, const PlacedConvex<S>& b,
                                        const Vec3<S>& towards, S far) const {
    const auto support = [&](const Vec3<S>& d) { return Vec3<S>(a.support(d) - b.support(-d)); };
    const bool is_curved = a.convex->is_curved() || b.convex->is_curved();
    const S enough =
        is_curved ? Tolerance<S>::equal() / S(chosen::curved_distance_refinement) : S(0);
    return gjk_distance<S>(support, support(towards), far, enough);
  }
};

/// Returns the direction of least overlap of A and B, with B at X_AB.
///
/// Errors are relative to the size of the pair. The gap is right to 1e-11 for cores that are
/// points, segments, boxes, plates or hulls. For other cores the gap is right to about 1e-8, the
/// normal to 1e-4. Most are far better. For overlapping solids the direction is the global minimum.
/// For curved solids its overlap may exceed the minimum by a fiftieth. Hulls whose corners exceed
/// the polytope may get a local minimum.
///
/// The cost is bounded: at most 64 faces of a polytope and 25 distances of at most 64 supports
/// each. A compass search adds at most 9024 directions. Allocates nothing. Throws only what
/// `Distance` does.
///
/// @tparam Distance  (a, b, towards, far) -> GjkResult: distance of two placed cores, where
///                   `towards` is a guess at the direction from A to B. May stop once they are
///                   proved to be farther apart than `far`.
template <typename Distance = GjkDistance, Scalar S>
[[nodiscard]] ContactNormal<S> contact_normal(const ConvexView<S>& a, const ConvexView<S>& b,
                                              const Transform<S>& X_AB, S margin);

// Implementation ----------------------------------------------------------------------------------

/// Search for the direction of least overlap of one pair, in units of the larger solid.
template <Scalar S, typename Distance>
class OverlapSearch {
 public:
  OverlapSearch(const ConvexView<S>& a, const ConvexView<S>& b, const Transform<S>& X_AB, S scale)
      : a_{&a, identity<Mat3<S>>(), zero<Vec3<S>>(), scale},
        b_{&b, X_AB.rotation_matrix(), scale * X_AB.translation, scale},
        rounding_(scale * (a.rounding + b.rounding)),
        push_(scale * std::min(a.reach, b.reach) / S(chosen::overlap_push_divisor)),
        is_curved_(a.is_curved() || b.is_curved()),
        settled_(is_curved_ ? Tolerance<S>::equal() / S(chosen::curved_gain_refinement)
                            : Tolerance<S>::round_off()) {}

  [[nodiscard]] S overlap() const { return overlap_; }
  [[nodiscard]] const Vec3<S>& normal() const { return normal_; }
  /// [-] Number of directions tried.
  [[nodiscard]] int evaluations() const { return evaluations_; }

  /// Tries the cheap directions: line of centres and face normals. Stops at a direction along which
  /// the solids are farther apart than `margin`.
  void try_candidates(S margin) {
    const Vec3<S> between =
        b_.rotation * (b_.scale * b_.convex->center) + b_.position - a_.scale * a_.convex->center;
    const Vec3<S> towards = between.stableNormalized();
    // The square of a unit vector is 1, that of a vector that has no direction 0.
    offer(towards.squaredNorm() > S(0.5) ? towards : unit_x<Vec3<S>>());
    for (const S side : {S(1), S(-1)}) {
      const PlacedConvex<S>& solid = side > S(0) ? a_ : b_;
      // Only those faces of a hull or plate are tried that face the other solid. The rest are left
      // to search_everywhere().
      const bool has_many = std::holds_alternative<const ConvexHull<S>*>(solid.convex->shape) ||
                            std::holds_alternative<const Plate<S>*>(solid.convex->shape);
      const Vec3<S> ahead = side * (solid.rotation.transpose() * between);
      const auto try_axis = [&](const Vec3<S>& axis) {
        if (has_many && axis.dot(ahead) < S(0)) return;
        if (overlap_ >= -margin) offer(side * (solid.rotation * axis));
      };
      visit_shape([&](const auto* shape) { for_face_normals(*shape, try_axis); },
                  solid.convex->shape);
    }
    if (is_box(a_) && is_box(b_)) try_edges(between);
  }

  /// Takes the direction of the cores' distance. Returns true if that is enough. The cores are then
  /// clearly apart, or farther apart than `margin`. If cores nearly touch, the error of their
  /// distance exceeds it. The direction is as wrong.
  bool search_apart(S margin) {
    const GjkResult<S> found =
        Distance{}(a_, b_, normal_, margin < infinity<S> ? margin + rounding_ : margin);
    if (!found.is_apart) return false;
    offer(found.normal);
    if (overlap_ < -margin) return true;
    return residual(found, zero<Vec3<S>>()) <= settled_;
  }

  /// Searches for the global minimum of the overlap. Skipped if all candidates were tried already.
  /// Exact for polyhedra. The polytope of curved solids never ends. Their search stops within a
  /// fiftieth.
  void search_everywhere() {
    if (is_box(a_) && is_box(b_)) return;
    // The overlap is too little for a better direction.
    if (overlap_ - rounding_ <= Tolerance<S>::equal()) return;
    ExpandingPolytope<S> polytope;
    if (!start(polytope)) return;
    for (std::size_t i = 0; i < ExpandingPolytope<S>::max_corners; ++i) {
      const auto face = polytope.nearest();
      const S enough =
          (is_curved_ ? S(1 - chosen::curved_overlap_slack) : S(1)) * (overlap_ - rounding_);
      if (face.distance >= enough - settled_) return;
      offer(face.normal);
      if (!polytope.expand(core_witness(face.normal))) return;
    }
  }

  /// Pushes the solids apart along the best direction and searches for a better one. Repeats until
  /// there is none. Returns whether the last direction was confirmed.
  ///
  /// Steps along a shallow valley shrink by a constant factor. From two of them the next push
  /// extrapolates to their limit (Aitken's process).
  bool search_overlapping() {
    S push = push_;
    Vec3<S> last_step = zero<Vec3<S>>();
    std::optional<Vec3<S>> leap;
    for (int i = 0; i < chosen::overlap_pushes; ++i) {
      if (!leap) polish();
      const Vec3<S> from = leap ? *leap : normal_;
      const Vec3<S> moved = (core_witness(from).dot(from) + push) * from;
      PlacedConvex<S> b = b_;
      b.position += moved;
      const GjkResult<S> found = Distance{}(a_, b, from, infinity<S>);
      const bool is_converged = found.is_apart && residual(found, moved) <= convergence();
      const S before = overlap_;
      if (found.is_apart) offer(found.normal);
      const bool is_better = overlap_ < before - settled_;
      if (is_converged && !is_better && !leap) return true;
      // The distance method stopped too early, as libccd sometimes does. Retry from elsewhere.
      if (!is_better && !leap) push /= S(2);
      const Vec3<S> step = found.normal - from;
      const S shrunk = step.norm() / last_step.norm();
      const bool was_leap = leap.has_value();
      leap.reset();
      set_zero(last_step);
      if (was_leap || !found.is_apart) continue;
      if (shrunk < infinity<S>) {
        // If steps hardly shrink, or grow as they do off a saddle, take many at once.
        const S steps = shrunk < S(1 - chosen::stalled_push_shrinkage)
                            ? shrunk / (S(1) - shrunk)
                            : S(chosen::stalled_push_leap);
        leap = (found.normal + steps * step).normalized();
      } else {
        last_step = step;
      }
    }
    return false;
  }

  /// Compass search over directions: slow and sure. It is for pairs on which the distance method
  /// fails. A round that gained is followed by leaps in the same direction, each twice as far. So a
  /// long valley takes few rounds (Hooke and Jeeves 1961, "Direct search").
  ///
  /// The search is bounded. Steps halve from a quarter of a radian, 24 times in double, 10 times in
  /// float. The first goes half around the sphere in pi / atan(1/4) = 13 rounds. So no step gets
  /// more than 16. Leaps that double from a step s exceed any way on the sphere after log2(4 / s)
  /// of them. With 8 directions in a round, double has at most 9024 directions, float 2640. Mostly
  /// each step takes one round.
  void search_by_compass() {
    int max_leaps = 4;  // log2(4 / step) for the first step.
    for (S step = S(chosen::compass_first_step); step > Tolerance<S>::equal();
         step /= S(2), ++max_leaps) {
      bool is_better = true;
      for (int round = 0; round < chosen::compass_rounds && is_better; ++round) {
        is_better = false;
        const Vec3<S> from = normal_;
        Vec3<S> t1, t2;
        tangent_basis(normal_, t1, t2);
        for (const auto& [x, y] : compass) {
          const Vec3<S> beside = normal_ + step * (S(x) * t1 + S(y) * t2);
          is_better = offer(beside.normalized()) || is_better;
        }
        bool leaps = is_better;
        for (int leap = 0; leap < max_leaps && leaps; ++leap) {
          leaps = offer((normal_ + S(2) * (normal_ - from)).normalized());
        }
      }
    }
  }

  /// Newton's method on the sphere, for curved solids. Distances leave their direction rough. The
  /// overlap f is positively homogeneous. Its gradient is the support point w. Along the tangent
  /// step u, f = f0 + w.u + u'(W - f0)u / 2. W is the derivative of w, taken by differences. Only
  /// better directions are kept, so corners and edges do no harm.
  void polish() {
    if (!is_curved_) return;
    const S difference = S(chosen::newton_difference);
    const S longest2 = S(chosen::newton_longest_step) * S(chosen::newton_longest_step);
    for (int i = 0; i < chosen::newton_steps; ++i) {
      Vec3<S> t1, t2;
      tangent_basis(normal_, t1, t2);
      const Vec3<S> w = witness(normal_);
      const auto slope = [&](const Vec3<S>& t) {
        return Vec3<S>((witness(normal_ + difference * t) - witness(normal_ - difference * t)) /
                       (S(2) * difference));
      };
      const Vec3<S> dw1 = slope(t1);
      const Vec3<S> dw2 = slope(t2);
      const S h11 = dw1.dot(t1) - overlap_;
      const S h22 = dw2.dot(t2) - overlap_;
      const S h12 = (dw1.dot(t2) + dw2.dot(t1)) / S(2);
      const S determinant = h11 * h22 - h12 * h12;
      const S g1 = w.dot(t1);
      const S g2 = w.dot(t2);
      const S u1 = -(h22 * g1 - h12 * g2) / determinant;
      const S u2 = -(h11 * g2 - h12 * g1) / determinant;
      // A long step means a flat or broken region where Newton fails; NaN fails too.
      if (!(u1 * u1 + u2 * u2 < longest2)) return;
      if (!offer((normal_ + u1 * t1 + u2 * t2).normalized())) return;
    }
  }

 private:
  /// [1] Sine of 45 degrees.
  static constexpr double diagonal = 0.7071067811865476;
  static constexpr double compass[8][2] = {
      {1, 0},  {diagonal, diagonal},   {0, 1},  {-diagonal, diagonal},
      {-1, 0}, {-diagonal, -diagonal}, {0, -1}, {diagonal, -diagonal}};

  /// On curved cores the distance method may end with this much still to gain.
  [[nodiscard]] static S convergence() {
    return S(chosen::curved_distance_error) * Tolerance<S>::equal();
  }

  [[nodiscard]] static bool is_box(const PlacedConvex<S>& solid) {
    return std::holds_alternative<const Box<S>*>(solid.convex->shape);
  }

  /// Difference of the support points of both along n, without radii.
  [[nodiscard]] Vec3<S> core_witness(const Vec3<S>& n) const {
    return a_.support(n) - b_.support(-n);
  }
  [[nodiscard]] Vec3<S> witness(const Vec3<S>& direction) const {
    const Vec3<S> n = direction.normalized();
    return core_witness(n) + rounding_ * n;
  }

  /// Claimed distance minus the distance proved by supports along the normal. 0 if it is right.
  [[nodiscard]] S residual(const GjkResult<S>& found, const Vec3<S>& push) const {
    return found.distance - (push - core_witness(found.normal)).dot(found.normal);
  }

  /// Starts from a tetrahedron of corners that are far from each other. Returns false for sets
  /// without volume, as those of two segments.
  bool start(ExpandingPolytope<S>& polytope) const {
    using std::abs;
    Vec3<S> t1, t2;
    tangent_basis(normal_, t1, t2);
    std::array<Vec3<S>, 4> corners{core_witness(normal_), core_witness(-normal_)};
    const Vec3<S> line = corners[1] - corners[0];
    S farthest = S(0);
    for (const Vec3<S>& d : {t1, t2, Vec3<S>(-t1), Vec3<S>(-t2)}) {
      const Vec3<S> w = core_witness(d);
      const S beside = line.cross(w - corners[0]).norm();
      if (beside > farthest) {
        farthest = beside;
        corners[2] = w;
      }
    }
    const Vec3<S> n = line.cross(corners[2] - corners[0]);
    if (!(n.squaredNorm() > S(0))) return false;
    const Vec3<S> up = core_witness(n);
    const Vec3<S> down = core_witness(-n);
    const bool is_up = abs(n.dot(up - corners[0])) >= abs(n.dot(down - corners[0]));
    corners[3] = is_up ? up : down;
    return polytope.start(corners);
  }

  /// Tries the cross products of the boxes' edges. With the face normals these are all separating
  /// axes of boxes. So their minimum is global.
  void try_edges(const Vec3<S>& between) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const Vec3<S> axis = column_of(a_.rotation, i).cross(column_of(b_.rotation, j));
        // Nearly parallel edges have no direction of their own.
        if (axis.squaredNorm() < Tolerance<S>::equal()) continue;
        // Of symmetric solids the side that faces the other has less overlap.
        offer(axis.dot(between) < S(0) ? Vec3<S>(-axis.normalized()) : Vec3<S>(axis.normalized()));
      }
    }
  }

  /// Takes a unit direction if its overlap is less. Returns whether it did. Of equal directions of
  /// polyhedra the first remains: round-off must not decide anew in each step along which axis
  /// blocks touch that meet at a corner.
  bool offer(const Vec3<S>& n) {
    ++evaluations_;
    const S overlap = core_witness(n).dot(n) + rounding_;
    const S least_gain = is_curved_ ? S(0) : S(chosen::polyhedral_gap_error);
    if (!(overlap < overlap_ - least_gain)) return false;
    overlap_ = overlap;
    normal_ = n;
    return true;
  }

  PlacedConvex<S> a_;
  PlacedConvex<S> b_;
  S rounding_;
  S push_;
  bool is_curved_;
  // Gains smaller than this count as none. On curved solids polish() finds the rest.
  S settled_;
  S overlap_ = infinity<S>;
  Vec3<S> normal_ = unit_z<Vec3<S>>();
  int evaluations_ = 0;
};

template <typename Distance, Scalar S>
ContactNormal<S> contact_normal(const ConvexView<S>& a, const ConvexView<S>& b,
                                const Transform<S>& X_AB, S margin) {
  using std::isfinite;
  BRISTLE_ASSERT(a.reach > S(0) && b.reach > S(0));
  const S scale = S(1) / std::max(a.reach, b.reach);
  const S scaled_margin = scale * margin;
  OverlapSearch<S, Distance> search(a, b, X_AB, scale);
  search.try_candidates(scaled_margin);
  if (!isfinite(search.overlap())) return {};
  if (search.overlap() >= -scaled_margin && !search.search_apart(scaled_margin)) {
    search.search_everywhere();
    if (!search.search_overlapping()) search.search_by_compass();
  }
  if (search.overlap() >= -scaled_margin) search.polish();
  const S gap = -search.overlap() / scale;
  return {gap <= margin ? Nearness::near : Nearness::apart, search.normal(), gap};
}

}  // namespace bristle::inline BRISTLE_ABI::detail
