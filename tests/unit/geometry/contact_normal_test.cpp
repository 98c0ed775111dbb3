// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/geometry/contacts/box_box.hpp>
#include <bristle/geometry/contacts/contact_normal.hpp>
#include <bristle/geometry/shapes/quickhull.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <span>
#include <support/random.hpp>
#include <support/rounds.hpp>
#include <variant>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using bristle::test::Random;
using bristle::test::rounds;

namespace {

/// Every solid has its alternative, in the order of `solid_kinds`.
template <Scalar S>
using Solid =
    std::variant<Sphere<S>, Box<S>, Capsule<S>, Cylinder<S>, Cone<S>, Ellipsoid<S>, ConvexHull<S>>;
constexpr std::size_t solid_kinds = 7;

template <Scalar S>
ConvexView<S> view(const Solid<S>& solid) {
  return std::visit([](const auto& s) { return convex_view(s); }, solid);
}

/// A solid of sizes between 0.2 and 1 times `scale`.
template <Scalar S>
Solid<S> random_solid(Random& random, std::size_t kind, S scale) {
  const auto size = [&] { return scale * random.uniform(S(0.2), S(1)); };
  switch (kind) {
    case 0:
      return Sphere<S>{size()};
    case 1:
      return Box<S>{{size(), size(), size()}};
    case 2:
      return Capsule<S>{size(), size()};
    case 3:
      return Cylinder<S>{size(), size()};
    case 4:
      return Cone<S>{size(), size()};
    case 5:
      return Ellipsoid<S>{{size(), size(), size()}};
    default: {
      std::vector<Vec3<S>> points;
      for (int i = 0; i < 16; ++i) points.push_back(scale * random.in_cube(S(1)));
      return convex_hull<S>(std::span<const Vec3<S>>(points));
    }
  }
}

/// [m] Overlap along a unit direction, from supports alone.
template <Scalar S>
S overlap_along(const ConvexView<S>& a, const ConvexView<S>& b, const Transform<S>& X,
                const Vec3<S>& n) {
  const Vec3<S> on_b = X * b.support(-(X.rotation.conjugate() * n));
  return (a.support(n) - on_b).dot(n) + a.rounding + b.rounding;
}

/// [m] Least overlap along directions all over the sphere, each then improved by a shrinking random
/// search: an upper bound of the least of all, and close to it.
template <Scalar S>
S sampled_overlap(Random& random, const ConvexView<S>& a, const ConvexView<S>& b,
                  const Transform<S>& X) {
  struct Sample {
    S overlap;
    Vec3<S> n;
  };
  std::vector<Sample> samples;
  constexpr int count = 400;
  // A spiral of nearly equal areas.
  for (int i = 0; i < count; ++i) {
    const S z = S(1) - (S(2) * S(i) + S(1)) / S(count);
    const S r = std::sqrt(S(1) - z * z);
    const S angle = S(2.399963) * S(i);
    const Vec3<S> n(r * std::cos(angle), r * std::sin(angle), z);
    samples.push_back({overlap_along(a, b, X, n), n});
  }
  std::partial_sort(samples.begin(), samples.begin() + 8, samples.end(),
                    [](const Sample& p, const Sample& q) { return p.overlap < q.overlap; });
  S best = samples[0].overlap;
  for (std::size_t i = 0; i < 8; ++i) {
    Sample at = samples[i];
    for (S step = S(0.1); step > S(1e-5);) {
      const Vec3<S> n = (at.n + step * random.in_cube(S(1))).normalized();
      const S overlap = overlap_along(a, b, X, n);
      if (overlap < at.overlap) {
        at = {overlap, n};
      } else {
        step *= S(0.9);
      }
    }
    best = std::min(best, at.overlap);
  }
  return best;
}

/// [m] Distance of a point outside from an ellipsoid: with x(t) = r^2 p / (r^2 + t) the foot of the
/// perpendicular is where sum (x / r)^2 = 1, a falling convex function of t, on which Newton's
/// method from t = 0 climbs to the root from below.
double ellipsoid_distance(const Vec3<double>& r, const Vec3<double>& p) {
  double t = 0;
  const auto r2 = r.array().square();
  for (int i = 0; i < 100; ++i) {
    const Eigen::Array3d x = r2 * p.array() / (r2 + t);
    const double value = (x / r.array()).square().sum() - 1.0;
    const double slope = -2.0 * ((x / r.array()).square() / (r2 + t)).sum();
    t -= value / slope;
  }
  const Vec3<double> foot = (r2 * p.array() / (r2 + t)).matrix();
  return (p - foot).norm();
}

/// Counts how often it is asked.
struct CountingDistance {
  static inline int calls = 0;

  template <Scalar S>
  GjkResult<S> operator()(const PlacedConvex<S>& a, const PlacedConvex<S>& b,
                          const Vec3<S>& towards, S far) const {
    ++calls;
    return GjkDistance{}(a, b, towards, far);
  }
};

}  // namespace

TEST_CASE_TEMPLATE("contact_normal: one distance is enough for solids that are clearly apart", S,
                   float, double) {
  // Within the margin and beyond it: most triangles near a body are.
  Random random(9);
  int far = 0;
  for (int i = 0; i < 300; ++i) {
    const Solid<S> solid_a = random_solid<S>(random, 3 + random.index(4), S(1));
    const Solid<S> solid_b = random_solid<S>(random, 3 + random.index(4), S(1));
    const ConvexView<S> a = view(solid_a);
    const ConvexView<S> b = view(solid_b);
    const Transform<S> X{random.rotation<S>(), S(3.6) * random.direction<S>()};
    const S gap = contact_normal(a, b, X, S(9)).gap;
    if (gap < S(0.1)) continue;
    for (const S margin : {S(0.98) * gap, S(9)}) {
      CountingDistance::calls = 0;
      const auto found = contact_normal<CountingDistance>(a, b, X, margin);
      CHECK(CountingDistance::calls <= 1);
      CHECK(found.nearness == (margin > gap ? Nearness::near : Nearness::apart));
      if (CountingDistance::calls == 1 && margin < gap) ++far;
    }
  }
  CHECK(far > 10);
}

TEST_CASE_TEMPLATE("contact_normal: balls touch along the line of their centres, however deep", S,
                   float, double) {
  Random random(1);
  for (const S scale : {S(0.001), S(1), S(100)}) {
    for (int i = 0; i < 100; ++i) {
      const Sphere<S> a{scale * random.uniform(S(0.1), S(1))};
      const Sphere<S> b{scale * random.uniform(S(0.1), S(1))};
      const Vec3<S> towards = random.direction<S>();
      const S distance = scale * random.uniform(S(0.01), S(2));
      const auto found =
          contact_normal(convex_view(a), convex_view(b),
                         Transform<S>{random.rotation<S>(), distance * towards}, S(3) * scale);
      REQUIRE(found.nearness == Nearness::near);
      CHECK((found.normal - towards).norm() <= Tolerance<S>::round_off());
      CHECK(std::abs(found.gap - (distance - a.radius - b.radius)) <=
            Tolerance<S>::round_off() * scale);
    }
  }
}

TEST_CASE_TEMPLATE("contact_normal: capsules touch where their segments come closest", S, float,
                   double) {
  // The closest points of two segments by brute force over both, refined where it is nearest: the
  // squared distance is convex in the two parameters.
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Capsule<S> a{random.uniform(S(0.05), S(0.4)), random.uniform(S(0.1), S(1))};
    const Capsule<S> b{random.uniform(S(0.05), S(0.4)), random.uniform(S(0.1), S(1))};
    const Transform<S> X = random.pose(S(1.2));
    const Vec3<S> axis = X.rotate(Vec3<S>::UnitZ());
    S on_a = S(0);
    S on_b = S(0);
    // Coordinate descent; each step is exact.
    for (int k = 0; k < 2000; ++k) {
      on_a = std::clamp((X.translation + on_b * axis).z(), -a.half_length, a.half_length);
      on_b = std::clamp(axis.dot(Vec3<S>(S(0), S(0), on_a) - X.translation), -b.half_length,
                        b.half_length);
    }
    const S distance = (X.translation + on_b * axis - Vec3<S>(S(0), S(0), on_a)).norm();
    // Segments that nearly cross have a direction that says little.
    if (distance < S(0.01)) continue;
    const auto found = contact_normal(convex_view(a), convex_view(b), X, S(3));
    // Coordinate descent leaves 1e-6 of the size where axes are nearly parallel.
    CHECK(std::abs(found.gap - (distance - a.radius - b.radius)) <=
          S(8) * Tolerance<S>::round_off() + S(1e-6));
  }
}

TEST_CASE("contact_normal: a ball keeps Newton's distance from an ellipsoid") {
  Random random(3);
  for (const double scale : {0.001, 1.0, 100.0}) {
    for (const double flat : {1.0, 0.1, 0.001}) {
      const Ellipsoid<double> ellipsoid{scale * Vec3<double>(1, 0.6, 0.5 * flat)};
      const Sphere<double> ball{0.2 * scale};
      for (int i = 0; i < 100; ++i) {
        const Vec3<double> p = scale * random.uniform(1.01, 2.0) * random.direction<double>();
        const double expected = ellipsoid_distance(ellipsoid.radii, p) - ball.radius;
        const auto found = contact_normal(convex_view(ellipsoid), convex_view(ball),
                                          Transform<double>{.translation = p}, 3.0 * scale);
        REQUIRE(found.nearness == Nearness::near);
        CHECK(std::abs(found.gap - expected) <= 1e-8 * scale);
      }
    }
  }
}

TEST_CASE_TEMPLATE("contact_normal: boxes overlap by the least of the fifteen axes", S, float,
                   double) {
  Random random(4);
  int overlapping = 0;
  for (int i = 0; i < rounds(500); ++i) {
    const Box<S> a{{random.uniform(S(0.2), S(1)), random.uniform(S(0.2), S(1)), S(0.5)}};
    const Box<S> b{{random.uniform(S(0.2), S(1)), random.uniform(S(0.2), S(1)), S(0.4)}};
    const Transform<S> X = random.pose(S(1));
    const auto va = convex_view(a);
    const auto vb = convex_view(b);
    S least = infinity<S>;
    const Mat3<S> R = X.rotation_matrix();
    const auto try_axis = [&](const Vec3<S>& axis) {
      if (axis.norm() < S(0.01)) return;
      const Vec3<S> n = axis.normalized();
      least = std::min({least, overlap_along(va, vb, X, n), overlap_along(va, vb, X, Vec3<S>(-n))});
    };
    for (int j = 0; j < 3; ++j) {
      try_axis(Vec3<S>::Unit(j));
      try_axis(R.col(j));
      for (int k = 0; k < 3; ++k) try_axis(Vec3<S>(Vec3<S>::Unit(j)).cross(Vec3<S>(R.col(k))));
    }
    const auto found = contact_normal(va, vb, X, S(0));
    if (least <= S(0)) {
      CHECK(found.nearness == Nearness::apart);
      continue;
    }
    ++overlapping;
    CHECK(std::abs(found.gap + least) <= S(4) * Tolerance<S>::round_off());
  }
  CHECK(overlapping > 100);
}

TEST_CASE_TEMPLATE("contact_normal: no direction has less overlap, for every pair of kinds", S,
                   float, double) {
  // The oracle is an upper bound of the least overlap. The result may be above it by the bounds of
  // contact_normal.hpp: round-off of polyhedra, 1e-8 of the size of curved solids, or a fiftieth of
  // the depth where another valley is that close. It may be below it by whatever the random search
  // has left: the overlap found is that of a direction, which is checked.
  Random random(5);
  for (std::size_t ka = 0; ka < solid_kinds; ++ka) {
    for (std::size_t kb = 0; kb < solid_kinds; ++kb) {
      int near = 0;
      for (int i = 0; i < rounds(30); ++i) {
        CAPTURE(ka);
        CAPTURE(kb);
        CAPTURE(i);
        const S scale = std::array{S(0.001), S(1), S(100)}[static_cast<std::size_t>(i) % 3];
        const Solid<S> solid_a = random_solid<S>(random, ka, scale);
        const Solid<S> solid_b = random_solid<S>(random, kb, scale);
        const ConvexView<S> a = view(solid_a);
        const ConvexView<S> b = view(solid_b);
        const Transform<S> X = random.pose(scale);
        const auto found = contact_normal(a, b, X, S(0.2) * scale);
        const S sampled = sampled_overlap(random, a, b, X);
        const S size = std::max(a.reach, b.reach);
        if (found.nearness == Nearness::apart) {
          CHECK(sampled <= S(-0.2) * scale + S(1e-4) * size);
          continue;
        }
        REQUIRE(found.nearness == Nearness::near);
        ++near;
        CHECK(std::abs(found.normal.norm() - S(1)) <= Tolerance<S>::round_off());
        CHECK(std::abs(overlap_along(a, b, X, found.normal) + found.gap) <=
              Tolerance<S>::round_off() * size);
        const bool is_curved = a.is_curved() || b.is_curved();
        const S tolerance =
            size * (S(8) * Tolerance<S>::round_off() + (is_curved ? S(1e-8) : S(0)));
        const S other_valley = is_curved ? S(0.02) * std::abs(found.gap) : S(0);
        CHECK(-found.gap <= sampled + tolerance + other_valley);
      }
      CHECK(near > 5);
    }
  }
}

TEST_CASE_TEMPLATE(
    "contact_normal: swapping the solids, moving both and scaling both changes nothing", S, float,
    double) {
  Random random(6);
  int turned = 0;
  int asked = 0;
  for (std::size_t ka = 0; ka < solid_kinds; ++ka) {
    for (std::size_t kb = 0; kb < solid_kinds; ++kb) {
      for (int i = 0; i < 10; ++i) {
        CAPTURE(ka);
        CAPTURE(kb);
        CAPTURE(i);
        Random same = random;
        const Solid<S> solid_a = random_solid<S>(random, ka, S(1));
        const Solid<S> solid_b = random_solid<S>(random, kb, S(1));
        const ConvexView<S> a = view(solid_a);
        const ConvexView<S> b = view(solid_b);
        const Transform<S> X = random.pose(S(1));
        const auto found = contact_normal(a, b, X, S(3));
        const bool is_curved = a.is_curved() || b.is_curved();
        // On curved solids the search ends when it gains less than a sixteenth of `equal`.
        const S tolerance = S(16) * Tolerance<S>::round_off() +
                            (is_curved ? std::max(S(1e-7), Tolerance<S>::equal() / S(4)) : S(0));
        // Of two valleys that are a fiftieth apart either may be found.
        const auto check = [&](const ContactNormal<S>& other, const Vec3<S>& normal, S size) {
          ++asked;
          const S difference = std::abs(other.gap / size - found.gap);
          if ((normal - found.normal).norm() > S(0.01)) {
            ++turned;
            CHECK(difference <= tolerance + S(0.02) * std::abs(found.gap));
          } else {
            CHECK(difference <= tolerance);
          }
        };
        const auto swapped = contact_normal(b, a, X.inverse(), S(3));
        check(swapped, -X.rotate(swapped.normal), S(1));
        // Both in another frame of the world.
        const Transform<S> X_W = random.pose(S(2));
        const auto moved = contact_normal(a, b, relative_pose(X_W, X_W * X), S(3));
        check(moved, moved.normal, S(1));
        for (const S scale : {S(0.01), S(100)}) {
          Random copy = same;
          const Solid<S> scaled_a = random_solid<S>(copy, ka, scale);
          const Solid<S> scaled_b = random_solid<S>(copy, kb, scale);
          const auto scaled =
              contact_normal(view(scaled_a), view(scaled_b),
                             Transform<S>{X.rotation, scale * X.translation}, S(3) * scale);
          check(scaled, scaled.normal, scale);
        }
      }
    }
  }
  CHECK(turned <= asked / 50);
}

TEST_CASE_TEMPLATE("contact_normal: what stands on a thin wide plate has the plate's normal", S,
                   float, double) {
  // A thousand to one, at the plate's rim too, from a gap of 1e-4 to a depth of 1e-4.
  Random random(7);
  for (const S scale : {S(0.001), S(1), S(100)}) {
    const Box<S> plate{scale * Vec3<S>(S(1), S(1), S(0.001))};
    const std::array<Solid<S>, 5> solids{
        Box<S>{scale * Vec3<S>(S(0.03), S(0.02), S(0.03))},
        Cylinder<S>{S(0.02) * scale, S(0.03) * scale}, Cone<S>{S(0.02) * scale, S(0.03) * scale},
        Sphere<S>{S(0.03) * scale}, Ellipsoid<S>{scale * Vec3<S>(S(0.01), S(0.02), S(0.03))}};
    for (const Solid<S>& solid : solids) {
      for (const S gap : {S(1e-4), S(0), S(-1e-4)}) {
        for (const S x : {S(0), S(0.5), S(0.97)}) {
          const Transform<S> X{exp_rotation<S>({S(0), S(0), random.uniform(S(0), S(6))}),
                               scale * Vec3<S>(x, S(0.1), S(0.031) + gap)};
          const auto found = contact_normal(convex_view(plate), view(solid), X, S(0.01) * scale);
          REQUIRE(found.nearness == Nearness::near);
          CHECK((found.normal - Vec3<S>::UnitZ()).norm() <= S(4) * Tolerance<S>::round_off());
          CHECK(std::abs(found.gap - gap * scale) <= S(4) * Tolerance<S>::round_off() * scale);
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("contact_normal: coincident, parallel and flat solids end with an answer", S,
                   float, double) {
  Random random(8);
  // A wedge that validation allows: a tetrahedron a thousand times wider than high.
  const std::vector<Vec3<S>> flat{Vec3<S>(S(-1), S(-1), S(0)), Vec3<S>(S(1), S(-1), S(0)),
                                  Vec3<S>(S(0), S(1), S(0)), Vec3<S>(S(0), S(0), S(0.001))};
  std::vector<Solid<S>> solids;
  for (std::size_t k = 0; k < solid_kinds; ++k) solids.push_back(random_solid<S>(random, k, S(1)));
  solids.push_back(convex_hull<S>(std::span<const Vec3<S>>(flat)));
  solids.push_back(Box<S>{{S(1), S(0.001), S(1)}});
  const S nan = std::numeric_limits<S>::quiet_NaN();
  for (const Solid<S>& solid_a : solids) {
    for (const Solid<S>& solid_b : solids) {
      const ConvexView<S> a = view(solid_a);
      const ConvexView<S> b = view(solid_b);
      // The centres of both at one place, in parallel and across.
      for (const Quat<S>& attitude :
           {Quat<S>(Quat<S>::Identity()), exp_rotation<S>({S(std::acos(-1.0) / 2), S(0), S(0)})}) {
        const Transform<S> X{attitude, a.center - attitude * b.center};
        const auto deep = contact_normal(a, b, X, S(0.01));
        CHECK(deep.nearness == Nearness::near);
        CHECK(deep.gap < S(0));
        CHECK(std::abs(deep.normal.norm() - S(1)) <= Tolerance<S>::round_off());
      }
      const auto nearness = [&](const Vec3<S>& p) {
        return contact_normal(a, b, Transform<S>{.translation = p}, S(0.01)).nearness;
      };
      CHECK(nearness({nan, S(0), S(0)}) == Nearness::unknown);
      CHECK(nearness({infinity<S>, S(0), S(0)}) != Nearness::near);
      CHECK(nearness({S(0), S(1e12), S(0)}) == Nearness::apart);
    }
  }
}

TEST_CASE_TEMPLATE("contact_normal: a search by compass ends, however long a solid is", S, float,
                   double) {
  // As the comment of search_by_compass() derives it.
  constexpr int most = std::same_as<S, float> ? 2640 : 9024;
  Random random(7);
  int worst = 0;
  for (const S length : {S(1), S(1e3), S(1e5), S(1e8), S(1e12), S(1e20), S(1e25)}) {
    for (int i = 0; i < rounds(60); ++i) {
      CAPTURE(length);
      CAPTURE(i);
      Solid<S> needle = Ellipsoid<S>{{S(0.3), length, S(0.3)}};
      if (i % 4 == 1) needle = Cone<S>{S(0.3), length};
      if (i % 4 == 2) needle = Cylinder<S>{length, S(0.3)};
      if (i % 4 == 3) {
        std::vector<Vec3<S>> points;
        for (int k = 0; k < 16; ++k) {
          points.push_back(random.in_cube(S(1)).cwiseProduct(
              Vec3<S>(S(1), std::min(length, S(1e4)), S(1))));  // Longer ones have no volume.
        }
        needle = convex_hull<S>(std::span<const Vec3<S>>(points));
      }
      const Solid<S> other = random_solid<S>(random, random.index(solid_kinds), S(0.5));
      const ConvexView<S> a = view(needle);
      const ConvexView<S> b = view(other);
      const Transform<S> X_AB = random.pose(S(0.4));
      const S scale = S(1) / std::max(a.reach, b.reach);
      detail::OverlapSearch<S, GjkDistance> search(a, b, X_AB, scale);
      search.try_candidates(infinity<S>);
      const S before = search.overlap();
      const int candidates = search.evaluations();
      search.search_by_compass();
      CHECK(search.overlap() <= before);
      CHECK(search.evaluations() - candidates <= most);
      worst = std::max(worst, search.evaluations() - candidates);
    }
  }
  CHECK(worst > 24 * 8);  // It does search.
}

// A ball whose middle is inside an ellipsoid of revolution: the way out is that of its middle, in
// the plane of the axis, plus the radius. The foot (a cos t, b sin t) of the perpendicular is where
// (foot - p) is across the tangent, found by bisection. The line of centres points along the
// needle, and from it the search has a valley to go down that is as long as the sphere and as
// narrow as the needle is thin: moves by steps alone took minutes, or ended far from the bottom.
TEST_CASE("contact_normal: a search by compass finds the bottom of a long narrow valley") {
  Random random(3);
  for (const double length : {1e1, 1e2, 1e3, 1e4}) {
    for (int i = 0; i < rounds(50); ++i) {
      const double r = 0.3;
      const Solid<double> needle = Ellipsoid<double>{{r, length, r}};
      const Solid<double> ball = Sphere<double>{0.2};
      const double aside = random.uniform(0.02, 0.15);
      const double along = length * random.uniform(0.05, 0.6);
      const double angle = random.uniform(0.0, 6.28);
      Transform<double> X_AB;
      X_AB.translation = {aside * std::cos(angle), along, aside * std::sin(angle)};
      double low = std::asin(along / length) - 0.3;
      double high = low + 0.6;
      const auto to_foot = [&](double t) {
        return Vec2<double>(r * std::cos(t) - aside, length * std::sin(t) - along);
      };
      for (int k = 0; k < 100; ++k) {
        const double t = (low + high) / 2;
        const Vec2<double> tangent(-r * std::sin(t), length * std::cos(t));
        (to_foot(t).dot(tangent) > 0 ? high : low) = t;
      }
      const double exact = to_foot(low).norm() + 0.2;
      const ConvexView<double> a = view(needle);
      const ConvexView<double> b = view(ball);
      const double scale = 1.0 / length;
      detail::OverlapSearch<double, GjkDistance> search(a, b, X_AB, scale);
      search.try_candidates(infinity<double>);
      search.search_by_compass();
      CAPTURE(length);
      CAPTURE(i);
      // Directions are right to the last step s, and beside the bottom of a valley of curvature
      // length^2 / r the overlap grows by half of that times s^2: 4e-5 at a length of 1e4.
      const double step = Tolerance<double>::equal();
      const double slack = length * length / (2 * r) * step * step + 1e-12 * length;
      CHECK(search.overlap() * length >= exact - 1e-12 * length);
      CHECK(search.overlap() * length <= exact + slack);
    }
  }
}

TEST_CASE("contact_normal: hulls that meet at a corner or an edge keep their normal") {
  Random random(76);
  for (int i = 0; i < 200; ++i) {
    const Vec3<double> half = random.in_cube(0.4) + Vec3<double>::Constant(0.5);
    std::vector<Vec3<double>> corners;
    for (int k = 0; k < 8; ++k) {
      corners.push_back(
          {(k & 1 ? 1 : -1) * half.x(), (k & 2 ? 1 : -1) * half.y(), (k & 4 ? 1 : -1) * half.z()});
    }
    const auto hull = convex_hull<double>(std::span<const Vec3<double>>(corners));
    Vec3<double> apart = 2 * half;
    if (i % 4 < 3) apart[i % 4] = 0;
    Vec3<double> first;
    for (int k = 0; k < 20; ++k) {
      // From the last bit to a tenth of what counts as equal.
      const double jitter = std::exp2(random.uniform(-52.0, -41.0));
      const Transform<double> X_AB{exp_rotation<double>(jitter * random.direction<double>()),
                                   apart + jitter * random.direction<double>()};
      const auto found = contact_normal(convex_view(hull), convex_view(hull), X_AB, 0.01);
      REQUIRE(found.nearness == Nearness::near);
      if (k == 0) first = found.normal;
      CHECK(found.normal.dot(first) > 0.99);
    }
  }
}
