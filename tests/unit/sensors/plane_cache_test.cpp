// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/geometry/backends/analytic_backend.hpp>
#include <bristle/sensors/patch_scratch.hpp>

#include <doctest/doctest.h>

#include <cmath>

using namespace bristle;

using namespace bristle::detail;

namespace {

template <typename S>
SensorPatch<S> patch_of(int side) {
  PatchDef<S> def;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      def.sensors.add(Vec3<S>(S(0.003) * S(i - side / 2), S(0.003) * S(j - side / 2), 0),
                      Vec3<S>(S(0.1), 0, 1).normalized(), S(0.01));
    }
  }
  return make_patch(std::move(def), BodyId{}, Vec3<S>(Vec3<S>::Zero()));
}

/// Scratch memory in which no packet has a hit.
template <typename S>
PatchScratch<S> scratch_of(const SensorPatch<S>& patch) {
  PatchScratch<S> scratch;
  scratch.begin(patch);
  scratch.list_all();
  return scratch;
}

template <typename S>
void cast(PatchScratch<S>& scratch, const Shape<S>& shape, const Transform<S>& X, S extra,
          std::uint32_t tag) {
  AnalyticBackend::cast_rays(AnalyticBackend::make<S>(shape), X, scratch.geometry->rays(extra), tag,
                             scratch.hits);
}

template <typename S>
PairPose<S> pair(const Transform<S>& X) {
  return {X.rotation_matrix(), X.translation};
}

}  // namespace

// Kept planes of a box are its faces: wherever it goes, they are hit where rays cast anew hit it.
TEST_CASE_TEMPLATE("plane cache: flat faces move exactly", S, float, double) {
  test::Random random(5);
  auto patch = patch_of<S>(5);
  auto scratch = scratch_of(patch);
  auto fresh = scratch_of(patch);
  // Larger than the patch, so that no ray comes to another face.
  const Shape<S> box = Box<S>{{S(0.1), S(0.1), S(0.02)}};
  for (int round = 0; round < 50; ++round) {
    const Transform<S> X{exp_rotation<S>(random.in_cube(S(0.2))),
                         Vec3<S>(0, 0, S(0.0275)) + random.in_cube(S(0.002))};
    scratch.list_all();
    scratch.reset_near_hits();
    // Far enough to keep what only comes into reach later.
    cast(scratch, box, X, S(0.01), 7);
    patch.plane_cache.shapes.assign(1, {7, 0, pair(X), S(0.01)});
    patch.plane_cache.keep(scratch);
    const Transform<S> moved{exp_rotation<S>(random.in_cube(S(0.02))) * X.rotation,
                             X.translation + random.in_cube(S(0.001))};
    patch.plane_cache.advance(scratch, [&](std::uint32_t tag, PairPose<S>& pose) {
      CHECK(tag == 7);
      pose = pair(moved);
      return S(0);
    });
    fresh.reset_near_hits();
    cast(fresh, box, moved, S(0), 7);
    const double round_off = 100 * static_cast<double>(Tolerance<S>::round_off());
    for (std::size_t i = 0; i < patch.size(); ++i) {
      const double expected = static_cast<double>(fresh.hits.distance[i]);
      const double kept = static_cast<double>(scratch.hits.distance[i]);
      if (std::abs(std::min(expected, kept) - 0.01) < 0.1 * round_off) continue;
      CHECK(fresh.hits.is_hit(i) == scratch.hits.is_hit(i));
      if (!fresh.hits.is_hit(i)) continue;
      CHECK(std::abs(kept - expected) < 0.1 * round_off);
      if (expected > 0)
        CHECK((fresh.hits.normal[i] - scratch.hits.normal[i]).norm() < S(round_off));
      CHECK(scratch.hits.tag[i] == 7);
    }
  }
}

// A point of B that is r away from A's centre moves by at most what `covers` counts.
TEST_CASE("plane cache: what they cover is a bound of how far anything moved") {
  test::Random random(9);
  for (int round = 0; round < 1000; ++round) {
    const Transform<double> from{exp_rotation<double>(random.in_cube(3.0)), random.in_cube(2.0)};
    const Transform<double> to{exp_rotation<double>(random.in_cube(0.1)) * from.rotation,
                               from.translation + random.in_cube(0.1)};
    const double reach = 0.3;
    const Vec3<double> r = reach * random.direction<double>();
    const double moved = (to * (from.inverse() * r) - r).norm();
    // Just enough reserve for this one point may be too little for others, never too much.
    const PlaneCacheShape<double> kept{0, 0, pair(from), moved - 1e-9};
    CHECK_FALSE(kept.covers(pair(to), 0.0, reach));
    CHECK(PlaneCacheShape<double>{0, 0, pair(from), 1e-9}.covers(pair(from), 0.0, reach));
    CHECK_FALSE(PlaneCacheShape<double>{0, 0, pair(from), 0.01}.covers(pair(from), 0.02, reach));
  }
}

TEST_CASE("plane cache: a plane that turned its back, or went out of reach, is no hit") {
  auto patch = patch_of<double>(1);
  auto scratch = scratch_of(patch);
  const Shape<double> box = Box<double>{{0.1, 0.1, 0.02}};
  const Transform<double> X{Quat<double>::Identity(), {0, 0, 0.025}};
  scratch.reset_near_hits();
  cast(scratch, box, X, 0.0, 3);
  REQUIRE(scratch.hits.is_hit(0));
  patch.plane_cache.shapes.assign(1, {3, 0, pair(X), 0.01});
  patch.plane_cache.keep(scratch);
  const auto is_hit_at = [&](const Transform<double>& now, double extra) {
    patch.plane_cache.advance(scratch, [&](std::uint32_t, PairPose<double>& pose) {
      pose = pair(now);
      return extra;
    });
    return scratch.hits.is_hit(0);
  };
  CHECK(is_hit_at(X, 0));
  CHECK_FALSE(is_hit_at({Quat<double>::Identity(), {0, 0, 0.031}}, 0));
  CHECK(is_hit_at({Quat<double>::Identity(), {0, 0, 0.031}}, 0.003));
  CHECK_FALSE(is_hit_at({exp_rotation<double>({3.0, 0, 0}), {0, 0, 0.025}}, 0));
}

TEST_CASE("plane cache: where a ray starts inside, nothing is known of the surface") {
  const Shape<double> box = Box<double>{{0.1, 0.1, 0.02}};
  for (const double height : {0.025, 0.0175}) {
    auto patch = patch_of<double>(5);
    auto scratch = scratch_of(patch);
    const Transform<double> X{Quat<double>::Identity(), {0, 0, height}};
    scratch.reset_near_hits();
    cast(scratch, box, X, 0.01, 3);
    patch.plane_cache.shapes.assign(1, {3, 0, pair(X), 0.01});
    patch.plane_cache.keep(scratch);
    // The box is 5 mm ahead of the starts, or 2.5 mm behind them.
    CHECK(patch.plane_cache.shapes[0].covers(pair(X), 0.0, patch.geometry->reach) ==
          (height > 0.02));
  }
}
