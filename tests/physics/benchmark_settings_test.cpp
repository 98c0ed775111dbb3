/// @file
/// The settings that the benchmark of work and error compares are settings that a world takes.
// SPDX-License-Identifier: BSD-3-Clause
#include "benchmarks/work_precision/drivers/bristle_driver.hpp"

#include <doctest/doctest.h>

using namespace bristle;

TEST_CASE_TEMPLATE("benchmark_settings: worlds take all of them", S, double, float) {
  for (const std::string& setting : work_precision::bristle_settings()) {
    CAPTURE(setting);
    World<S> world(work_precision::world_def<S>(setting));
    BodyDef<S> ball;
    ball.mass = S(1);
    ball.shape = Sphere<S>{S(0.1)};
    const BodyId id = world.add_body(ball);
    world.step();
    CHECK(world.body(id).twist.linear.z() < S(0));
  }
}
