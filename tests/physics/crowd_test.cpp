/// @file
/// Many bodies at one place, as after a bad spawn: they come apart over steps of bounded work.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/collision/crowd_limit.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// Bodies of one shape at almost one point, without gravity.
template <typename S>
struct Crowd {
  Crowd(std::uint64_t count, const Shape<S>& shape) : world({.gravity = Vec3<S>::Zero()}) {
    test::Random random(1);
    for (std::uint64_t i = 0; i < count; ++i) {
      const Vec3<S> position = Vec3<S>(S(1), S(2), S(3)) + random.in_cube(S(1e-3));
      ids.push_back(world.add_body({.mass = S(1), .shape = shape, .position = position}));
    }
  }
  /// [m] Least distance of two bodies.
  [[nodiscard]] S nearest() const {
    S least = infinity<S>;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      for (std::size_t k = i + 1; k < ids.size(); ++k) {
        least = std::min(least,
                         (world.pose(ids[i]).translation - world.pose(ids[k]).translation).norm());
      }
    }
    return least;
  }

  World<S> world;
  std::vector<BodyId> ids;
};

}  // namespace

TEST_CASE_TEMPLATE("crowd: two hundred bodies at one place come apart, a few pairs each at a time",
                   S, float, double) {
  const S half = S(0.05);
  for (const Shape<S>& shape : {Shape<S>(Sphere<S>{half}), Shape<S>(Box<S>{{half, half, half}})}) {
    Crowd<S> crowd(200, shape);
    crowd.world.step();
    const StepReport<S>& report = crowd.world.report();
    CHECK(report.pairs_put_off > 0);
    CHECK(report.pairs_collided <= CrowdLimit<S>::most * crowd.ids.size());
    CHECK(report.pairs_collided + report.pairs_put_off == 200 * 199 / 2);
    for (int i = 0; i < 120; ++i) crowd.world.step();
    CHECK(report.pairs_put_off == 0);
    CHECK(crowd.nearest() > S(1.99) * half);
    Vec3<S> momentum = Vec3<S>::Zero();
    S turnover = S(0);
    for (const BodyId id : crowd.ids) {
      momentum += crowd.world.body(id).twist.linear;
      turnover += crowd.world.body(id).twist.linear.norm();
    }
    CHECK(momentum.norm() <= S(1e4) * Tolerance<S>::round_off() * (S(1) + turnover));
  }
}

TEST_CASE("crowd: a heap that only touches puts nothing off") {
  World<double> world;
  world.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
  for (int i = 0; i < 64; ++i) {
    world.add_body({.mass = 1.0,
                    .shape = Box<double>{{0.05, 0.05, 0.05}},
                    .position = {0.1 * (i % 4), 0.1 * (i / 4 % 4), 0.05 + 0.1 * (i / 16)}});
  }
  std::uint64_t put_off = 0;
  std::uint64_t collided = 0;
  for (int i = 0; i < 120; ++i) {
    world.step();
    put_off += world.report().pairs_put_off;
    collided += world.report().pairs_collided;
  }
  CHECK(put_off == 0);
  CHECK(collided > 0);
}
