/// @file
/// Along which direction two convex solids touch: FCL's GJK over libccd, made safe for a
/// simulation.
///
/// What is used of FCL, and what is not, and why:
/// - `fcl::detail::GJKDistance`, the routine behind `fcl::distance`: every loop in it is bounded by
///   an iteration count, and it allocates nothing. It is asked with support functions of our own
///   because libccd compares squared areas of its simplex with an absolute 2.2e-16: millimetre
///   shapes in metres would count as touching or apart at random. Here the larger of the two solids
///   has the size 1 always.
/// - Not the contacts of `fcl::collide`: where FCL has no closed form they come from libccd's
/// portal
///   refinement, a loop without bound, along a normal that is not that of least depth (fcl#243,
///   libccd#71, fcl#545). Not the signed distance: its expanding polytope may loop for ever or
///   throw (fcl#578, fcl#493, drake#18704).
///
/// Overlapping solids are pushed apart along the best direction known, and GJK's answer there is a
/// better one: with the overlap f(n) and the push (f(n) + e) n their distance is at least e, so the
/// direction n' of that distance has f(n') = (f(n) + e) n.n' - distance <= f(n). The limit is a
/// direction of locally least depth. Every direction returned was checked with supports, whatever
/// GJK said: solids reported apart *are* apart along it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes.hpp>
#include <bristle/geometry/support.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/math/transform.hpp>

#include <fcl/narrowphase/detail/convexity_based_algorithm/gjk_libccd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <type_traits>
#include <variant>

namespace bristle {

/// A convex solid as GJK sees it: a core, and a radius by which the core is grown. A sphere's core
/// is its centre, a capsule's its segment; others are their own. Points to the shape it is made
/// from.
struct FclConvex {
  std::variant<const Sphere<double>*, const Box<double>*, const Capsule<double>*,
               const Cylinder<double>*, const Cone<double>*, const Ellipsoid<double>*,
               const ConvexHull<double>*, const Triangle<double>*>
      shape;
  /// [m] Radius around the core: that of a sphere or capsule, else 0.
  double rounding = 0.0;
  /// [m] A point inside, and the distance from it to the farthest point of the solid.
  Vec3<double> center = Vec3<double>::Zero();
  double reach = 0.0;

  /// [m] The core's farthest point along a direction of any length > 0, in the solid's frame.
  [[nodiscard]] Vec3<double> support(const Vec3<double>& direction) const;
};

/// The GJK view of a shape that support.hpp knows, which must outlive the answer.
template <typename ConvexShape>
[[nodiscard]] FclConvex fcl_convex(const ConvexShape& shape);

/// What is known about a pair of convex solids.
enum class FclNearness {
  /// They overlap, touch or are no farther apart than the margin; normal and gap are valid.
  near,
  /// They are farther apart than the margin.
  apart,
  /// Nothing is known: a pose that is not finite.
  unknown
};

/// Answer of `fcl_contact_normal`.
struct FclContactNormal {
  FclNearness nearness = FclNearness::unknown;
  /// [1] Unit normal from A into B, in the frame of A.
  Vec3<double> normal = Vec3<double>::UnitZ();
  /// [m] Distance along the normal, negative where the solids overlap.
  double gap = 0.0;
};

/// The direction of least separation between A and B, B standing at X_AB.
///
/// Errors relative to the size of the pair: the gap is right to 1e-11 where the cores are points,
/// segments, boxes, triangles or hulls, and to about 1e-8 for other pairs (the normal to 1e-4),
/// which are mostly far better. Overlapping boxes get the least depth of all directions; other
/// solids a *local* one, the best reached from the line of centres and the face normals of both,
/// which is the least where the overlap is small against the faces.
///
/// Never hangs; may throw where FCL does. Allocates nothing. 0.2 to 3 us for polyhedra and round
/// cores, 3 to 20 us where a core is curved (Zen 4, -O2).
[[nodiscard]] FclContactNormal fcl_contact_normal(const FclConvex& a, const FclConvex& b,
                                                  const Transform<double>& X_AB, double margin);

// Implementation -----------------------------------------------------------------------------------

namespace detail {

[[nodiscard]] inline Vec3<double> support_core(const Sphere<double>&, const Vec3<double>&) {
  return Vec3<double>::Zero();
}
[[nodiscard]] inline Vec3<double> support_core(const Capsule<double>& s, const Vec3<double>& d) {
  return {0.0, 0.0, d.z() < 0.0 ? -s.half_length : s.half_length};
}
template <typename ConvexShape>
[[nodiscard]] Vec3<double> support_core(const ConvexShape& s, const Vec3<double>& d) {
  return support_point(s, d);
}

/// Centre and reach of a set of corners.
inline void measure_corners(FclConvex& convex, std::span<const Vec3<double>> corners) {
  for (const Vec3<double>& p : corners) convex.center += p / static_cast<double>(corners.size());
  for (const Vec3<double>& p : corners) {
    convex.reach = std::max(convex.reach, (p - convex.center).norm());
  }
}

inline void measure(FclConvex& convex, const Sphere<double>& s) {
  convex.rounding = s.radius;
  convex.reach = s.radius;
}
inline void measure(FclConvex& convex, const Box<double>& s) {
  convex.reach = s.half_extents.norm();
}
inline void measure(FclConvex& convex, const Capsule<double>& s) {
  convex.rounding = s.radius;
  convex.reach = s.half_length + s.radius;
}
inline void measure(FclConvex& convex, const Cylinder<double>& s) {
  convex.reach = std::hypot(s.radius, s.half_length);
}
inline void measure(FclConvex& convex, const Cone<double>& s) {
  convex.reach = std::hypot(s.radius, s.half_length);
}
inline void measure(FclConvex& convex, const Ellipsoid<double>& s) {
  convex.reach = s.radii.maxCoeff();
}
inline void measure(FclConvex& convex, const ConvexHull<double>& s) {
  measure_corners(convex, s.vertices);
}
inline void measure(FclConvex& convex, const Triangle<double>& s) {
  measure_corners(convex, s.corners);
}

/// Calls `try_axis` with directions in which the way out of the shape may be shortest: those its
/// faces look in.
template <typename ConvexShape, typename Try>
void for_face_normals(const ConvexShape& shape, const Try& try_axis) {
  if constexpr (std::is_same_v<ConvexShape, Box<double>>) {
    for (int axis = 0; axis < 3; ++axis) {
      try_axis(Vec3<double>::Unit(axis));
      try_axis(-Vec3<double>::Unit(axis));
    }
  } else if constexpr (std::is_same_v<ConvexShape, Cylinder<double>>) {
    try_axis(Vec3<double>::UnitZ());
    try_axis(-Vec3<double>::UnitZ());
  } else if constexpr (std::is_same_v<ConvexShape, Cone<double>>) {
    try_axis(-Vec3<double>::UnitZ());
  } else if constexpr (std::is_same_v<ConvexShape, ConvexHull<double>>) {
    for (const Vec3<double>& n : shape.face_normals) try_axis(n);
  } else if constexpr (std::is_same_v<ConvexShape, Triangle<double>>) {
    const Vec3<double> n = support_face(shape, Vec3<double>(Vec3<double>::UnitZ())).normal;
    try_axis(n);
    try_axis(-n);
    // Past its edges, within its plane: often the shortest way off a plate.
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3<double> edge = shape.corners[(k + 1) % 3] - shape.corners[k];
      const Vec3<double> across = edge.cross(n).normalized();
      const bool is_outwards = across.dot(shape.corners[(k + 2) % 3] - shape.corners[k]) <= 0.0;
      try_axis(is_outwards ? across : Vec3<double>(-across));
    }
  }
}

/// Whether the core is.
[[nodiscard]] inline bool is_curved(const FclConvex& convex) {
  return std::holds_alternative<const Cylinder<double>*>(convex.shape) ||
         std::holds_alternative<const Cone<double>*>(convex.shape) ||
         std::holds_alternative<const Ellipsoid<double>*>(convex.shape);
}

/// A solid in the frame and unit in which a pair is looked at.
struct PlacedConvex {
  const FclConvex* convex;
  Mat3<double> rotation;
  Vec3<double> position;
  double scale;

  [[nodiscard]] Vec3<double> support(const Vec3<double>& direction) const {
    return rotation * (scale * convex->support(rotation.transpose() * direction)) + position;
  }
  /// What libccd calls: the object is a PlacedConvex.
  static void ccd_support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* result) {
    const Vec3<double> p = static_cast<const PlacedConvex*>(object)->support(
        {direction->v[0], direction->v[1], direction->v[2]});
    ccdVec3Set(result, p.x(), p.y(), p.z());
  }
};

/// The search for the direction of least overlap of one pair, in units of the larger solid.
class OverlapSearch {
 public:
  OverlapSearch(const FclConvex& a, const FclConvex& b, const Transform<double>& X_AB, double scale)
      : a_{&a, Mat3<double>::Identity(), Vec3<double>::Zero(), scale},
        b_{&b, X_AB.rotation_matrix(), scale * X_AB.translation, scale},
        rounding_(scale * (a.rounding + b.rounding)),
        push_(scale * std::min(a.reach, b.reach) / 8.0),
        settled_(is_curved(a) || is_curved(b) ? Tolerance<double>::equal()
                                              : Tolerance<double>::round_off()) {}

  [[nodiscard]] double overlap() const { return overlap_; }
  [[nodiscard]] const Vec3<double>& normal() const { return normal_; }

  /// The cheap directions: line of centres and face normals. Stops at one along which the solids
  /// are farther apart than `margin`.
  void try_candidates(double margin) {
    const Vec3<double> between =
        b_.rotation * (b_.scale * b_.convex->center) + b_.position - a_.scale * a_.convex->center;
    const Vec3<double> towards = between.stableNormalized();
    offer(towards.squaredNorm() > 0.5 ? towards : Vec3<double>::UnitX());
    for (const double side : {1.0, -1.0}) {
      const PlacedConvex& solid = side > 0.0 ? a_ : b_;
      const auto try_axis = [&](const Vec3<double>& axis) {
        if (overlap_ >= -margin) offer(side * (solid.rotation * axis));
      };
      std::visit([&](const auto* shape) { for_face_normals(*shape, try_axis); },
                 solid.convex->shape);
    }
    if (std::holds_alternative<const Box<double>*>(a_.convex->shape) &&
        std::holds_alternative<const Box<double>*>(b_.convex->shape)) {
      try_edges(between);
    }
  }

  /// GJK on the pair as it stands; enough where the cores are clearly apart. Whether it was. Cores
  /// that nearly touch have a distance that means less than its error, and so has the direction.
  bool search_apart() {
    const GjkAnswer answer = gjk(Vec3<double>::Zero());
    if (!answer.is_apart) return false;
    offer(answer.normal);
    return answer.residual <= Tolerance<double>::equal();
  }

  /// Pushes the solids apart along the best direction, and asks GJK for a better one, until there
  /// is none. Whether GJK confirmed the last one.
  bool search_overlapping() {
    double push = push_;
    for (int i = 0; i < max_pushes; ++i) {
      const GjkAnswer answer = gjk((overlap_ - rounding_ + push) * normal_);
      const bool is_converged = answer.is_apart && answer.residual <= convergence();
      const double before = overlap_;
      if (answer.is_apart) offer(answer.normal);
      const bool is_better = overlap_ < before - settled_;
      if (is_converged && !is_better) return true;
      // libccd stopped too early, as it does now and then: ask from elsewhere.
      if (!is_better) push /= 2.0;
    }
    return false;
  }

  /// Compass search over directions: slow and sure, for what libccd cannot do.
  void search_by_compass() {
    for (double step = 0.25; step > Tolerance<double>::equal(); step /= 2.0) {
      for (bool is_better = true; is_better;) {
        is_better = false;
        Vec3<double> t1, t2;
        tangent_basis(normal_, t1, t2);
        for (const auto& [x, y] : compass) {
          is_better = offer((normal_ + step * (x * t1 + y * t2)).normalized()) || is_better;
        }
      }
    }
  }

  /// Newton's method on the sphere, for curved solids, whose direction GJK leaves rough. The
  /// overlap f is positively homogeneous, its gradient is the support point w: along the tangent
  /// step u, f = f0 + w.u + u'(W - f0)u / 2 with W the derivative of w, taken by differences. Keeps
  /// only what is better, so corners and edges do no harm.
  void polish() {
    constexpr double difference = 1.0 / 8192.0;
    for (int i = 0; i < max_polishes; ++i) {
      Vec3<double> t1, t2;
      tangent_basis(normal_, t1, t2);
      const Vec3<double> w = witness(normal_);
      const Vec3<double> dw1 =
          (witness(normal_ + difference * t1) - witness(normal_ - difference * t1)) /
          (2.0 * difference);
      const Vec3<double> dw2 =
          (witness(normal_ + difference * t2) - witness(normal_ - difference * t2)) /
          (2.0 * difference);
      const double h11 = dw1.dot(t1) - overlap_;
      const double h22 = dw2.dot(t2) - overlap_;
      const double h12 = (dw1.dot(t2) + dw2.dot(t1)) / 2.0;
      const double determinant = h11 * h22 - h12 * h12;
      const double g1 = w.dot(t1);
      const double g2 = w.dot(t2);
      const double u1 = -(h22 * g1 - h12 * g2) / determinant;
      const double u2 = -(h11 * g2 - h12 * g1) / determinant;
      // A long step means a flat or broken place where Newton has nothing to say; NaN fails too.
      if (!(u1 * u1 + u2 * u2 < 1.0 / 64.0)) return;
      if (!offer((normal_ + u1 * t1 + u2 * t2).normalized())) return;
    }
  }

 private:
  static constexpr int max_pushes = 24;
  static constexpr int max_polishes = 3;
  static constexpr unsigned max_gjk_iterations = 128;
  static constexpr double diagonal = 0.7071067811865476;
  static constexpr double compass[8][2] = {
      {1, 0},  {diagonal, diagonal},   {0, 1},  {-diagonal, diagonal},
      {-1, 0}, {-diagonal, -diagonal}, {0, -1}, {diagonal, -diagonal}};

  struct GjkAnswer {
    bool is_apart = false;
    Vec3<double> normal = Vec3<double>::Zero();
    // Distance GJK claims beyond what supports along its normal prove; 0 when it is right.
    double residual = 0.0;
  };

  /// GJK ends when a step gains less than this. Finer only brings degenerate simplices, with
  /// answers that are worse; polyhedra end exactly whatever it is.
  static constexpr double gjk_tolerance() { return 1024.0 * Tolerance<double>::round_off(); }
  /// On curved cores GJK may end so while about this much is still to be gained.
  static constexpr double convergence() { return 64.0 * Tolerance<double>::equal(); }

  /// Where the support functions of both meet along n, radii left out.
  [[nodiscard]] Vec3<double> core_witness(const Vec3<double>& n) const {
    return a_.support(n) - b_.support(-n);
  }
  [[nodiscard]] Vec3<double> witness(const Vec3<double>& direction) const {
    const Vec3<double> n = direction.normalized();
    return core_witness(n) + rounding_ * n;
  }

  /// Where an edge of one box crosses one of the other: with the face normals, all directions that
  /// least overlap of boxes can have (the separating axes), so theirs is least everywhere.
  void try_edges(const Vec3<double>& between) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const Vec3<double> axis = a_.rotation.col(i).cross(b_.rotation.col(j));
        // Edges that are as good as parallel have no direction of their own.
        if (axis.squaredNorm() < Tolerance<double>::equal()) continue;
        // Of symmetric solids the side that faces the other has less overlap.
        offer(axis.dot(between) < 0.0 ? -axis.normalized() : axis.normalized());
      }
    }
  }

  /// Takes a unit direction if the overlap along it is less.
  bool offer(const Vec3<double>& n) {
    const double overlap = core_witness(n).dot(n) + rounding_;
    if (!(overlap < overlap_)) return false;
    overlap_ = overlap;
    normal_ = n;
    return true;
  }

  [[nodiscard]] GjkAnswer gjk(const Vec3<double>& push) const {
    PlacedConvex a = a_;
    PlacedConvex b = b_;
    b.position += push;
    double distance = 0.0;
    Vec3<double> on_a, on_b;
    GjkAnswer answer;
    if (!fcl::detail::GJKDistance<double>(&a, PlacedConvex::ccd_support, &b,
                                          PlacedConvex::ccd_support, max_gjk_iterations,
                                          gjk_tolerance(), &distance, &on_a, &on_b)) {
      return answer;
    }
    answer.normal = (on_b - on_a).normalized();
    answer.is_apart = answer.normal.squaredNorm() > 0.5;  // Neither zero nor NaN.
    answer.residual = distance - (push - core_witness(answer.normal)).dot(answer.normal);
    return answer;
  }

  PlacedConvex a_;
  PlacedConvex b_;
  double rounding_;
  double push_;
  // Less gain than this is none; what is left of it on curved solids is for polish().
  double settled_;
  double overlap_ = infinity<double>;
  Vec3<double> normal_ = Vec3<double>::UnitZ();
};

}  // namespace detail

inline Vec3<double> FclConvex::support(const Vec3<double>& direction) const {
  return std::visit([&](const auto* s) { return detail::support_core(*s, direction); }, shape);
}

template <typename ConvexShape>
FclConvex fcl_convex(const ConvexShape& shape) {
  FclConvex convex{.shape = &shape};
  detail::measure(convex, shape);
  return convex;
}

inline FclContactNormal fcl_contact_normal(const FclConvex& a, const FclConvex& b,
                                           const Transform<double>& X_AB, double margin) {
  BRISTLE_ASSERT(a.reach > 0.0 && b.reach > 0.0);
  const double scale = 1.0 / std::max(a.reach, b.reach);
  detail::OverlapSearch search(a, b, X_AB, scale);
  search.try_candidates(scale * margin);
  if (!std::isfinite(search.overlap())) return {};
  if (search.overlap() >= -scale * margin && !search.search_apart() &&
      !search.search_overlapping()) {
    search.search_by_compass();
  }
  if (search.overlap() >= -scale * margin && (detail::is_curved(a) || detail::is_curved(b))) {
    search.polish();
  }
  const double gap = -search.overlap() / scale;
  return {gap <= margin ? FclNearness::near : FclNearness::apart, search.normal(), gap};
}

}  // namespace bristle
