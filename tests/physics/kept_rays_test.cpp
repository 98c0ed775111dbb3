/// @file
/// The triangle cache of rays changes the cost of a step, and none of its results.
// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/thread_pool.hpp>
#include <bristle/geometry/meshes/mesh_shapes.hpp>
#include <bristle/sensors/placement.hpp>
#include <bristle/sensors/tuning.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

using namespace bristle;

namespace {

/// Pads of 81 sensors, and on each of them a ball of 5780 triangles that rolls: far more triangles
/// than rays, so that rays keep those near them.
template <Scalar S>
class Rolling {
 public:
  explicit Rolling(WorldDef<S> def = {}, std::size_t pads = 1) : world(with_step(def)) {
    for (std::size_t k = 0; k < pads; ++k) {
      const S x = S(0.3) * S(k);
      const BodyId pad = world.add_body({.motion = Motion::fixed, .position = {x, 0, 0}});
      PatchDef<S> patch;
      patch.sensors = sensor_grid<S>(
          {.side_u = {S(0.06), 0, 0}, .side_v = {0, S(0.06), 0}, .count_u = 9, .count_v = 9});
      patch.parameters = tuned_for<S>({.load = S(20), .mass = S(2)}).parameters(patch.sensors);
      world.add_patch(pad, patch);
      balls.push_back(add_ball(k, sphere_mesh<S>(S(0.03), 17)));
    }
  }

  BodyId add_ball(std::size_t k, TriangleMesh<S> mesh) {
    BodyDef<S> ball;
    ball.mass = S(1);
    ball.shape = std::move(mesh);
    ball.position = {S(0.3) * S(k) - S(0.01), 0, S(0.031)};
    ball.velocity = {S(0.02) * S(k + 1), S(0.01), 0};
    return world.add_body(ball);
  }
  /// Puts another ball where the first one is, and under its name but for the generation.
  void replace_ball() {
    const BodyId old = balls[0];
    const Transform<S> pose = world.pose(old);
    world.remove_body(old);
    balls[0] = add_ball(0, sphere_mesh<S>(S(0.0298), 15));
    world.set_pose(balls[0], pose);
    REQUIRE(balls[0].index == old.index);
  }

  World<S> world;
  std::vector<BodyId> balls;

 private:
  static WorldDef<S> with_step(WorldDef<S> def) {
    def.time_step = S(1e-3);
    return def;
  }
};

}  // namespace

TEST_CASE_TEMPLATE("kept rays: worlds that have kept nothing yet step with the same bits", S, float,
                   double) {
  Rolling<S> keeping;
  Rolling<S> fresh;
  std::uint64_t touching = 0;
  for (int i = 0; i < 200; ++i) {
    if (i % 5 == 0) {
      fresh = Rolling<S>();
      fresh.world.restore(keeping.world.snapshot());
    }
    keeping.world.step();
    fresh.world.step();
    REQUIRE(fresh.world.state_hash() == keeping.world.state_hash());
    touching += keeping.world.report().sensors_touching;
  }
  CHECK(touching > 200 * 2);
}

TEST_CASE_TEMPLATE("kept rays: a mesh in the place of another is met, and not the other", S, float,
                   double) {
  Rolling<S> keeping;
  for (int i = 0; i < 50; ++i) keeping.world.step();
  REQUIRE(keeping.world.report().sensors_touching > 0);
  keeping.replace_ball();
  Rolling<S> fresh;
  fresh.replace_ball();
  fresh.world.restore(keeping.world.snapshot());
  std::uint64_t touching = 0;
  for (int i = 0; i < 100; ++i) {
    keeping.world.step();
    fresh.world.step();
    REQUIRE(fresh.world.state_hash() == keeping.world.state_hash());
    touching += keeping.world.report().sensors_touching;
  }
  CHECK(touching > 0);
}

TEST_CASE("kept rays: a ball that is set elsewhere is met there") {
  Rolling<double> keeping;
  for (int i = 0; i < 50; ++i) keeping.world.step();
  Transform<double> pose = keeping.world.pose(keeping.balls[0]);
  pose.translation.x() += 0.013;
  pose.rotation = Quat<double>(Eigen::AngleAxisd(1.0, Vec3<double>(1, 2, 2) / 3)) * pose.rotation;
  keeping.world.set_pose(keeping.balls[0], pose);
  Rolling<double> fresh;
  fresh.world.restore(keeping.world.snapshot());
  for (int i = 0; i < 50; ++i) {
    keeping.world.step();
    fresh.world.step();
    REQUIRE(fresh.world.state_hash() == keeping.world.state_hash());
  }
  CHECK(keeping.world.report().sensors_touching > 0);
}

TEST_CASE("kept rays: threads that share patches share no lists") {
  Rolling<double> serial({}, 5);
  std::vector<std::uint64_t> expected;
  for (int i = 0; i < 80; ++i) {
    serial.world.step();
    expected.push_back(serial.world.state_hash());
  }
  REQUIRE(serial.world.report().sensors_touching > 5);
  for (const unsigned workers : {2u, 8u}) {
    ThreadPool pool(workers);
    WorldDef<double> def;
    def.parallel_for = pool.hook();
    Rolling<double> shared(def, 5);
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 80; ++i) {
      shared.world.step();
      hashes.push_back(shared.world.state_hash());
    }
    CHECK(hashes == expected);
  }
}
