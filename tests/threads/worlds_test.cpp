/// @file
/// A pool of threads changes how long a step takes, and nothing else.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/pile.hpp"
#include "scenes/skin.hpp"

#include <bristle/core/thread_pool.hpp>

#include <doctest/doctest.h>

#include <atomic>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;

TEST_CASE("threads: rays are shared from more on than a range has") {
  CHECK(bristle::detail::chosen::fewest_shared_rays > bristle::detail::RayTree<double>::range_size);
}

TEST_CASE_TEMPLATE("threads: 1 to 8 workers give the same bits in every step", S, float, double) {
  constexpr int steps = 80;
  std::vector<std::uint64_t> expected;
  auto serial = make_pile<S>();
  std::uint64_t most_pairs = 0;
  for (int i = 0; i < steps; ++i) {
    serial.world.step();
    expected.push_back(serial.world.state_hash());
    most_pairs = std::max(most_pairs, serial.world.report().pairs_collided);
  }
  // Enough for several chunks; else this tests nothing.
  REQUIRE(most_pairs >= 128);
  REQUIRE(serial.world.report().sensors_touching > 100);
  for (const unsigned workers : {1u, 2u, 3u, 8u}) {
    ThreadPool pool(workers);
    WorldDef<S> def;
    def.parallel_for = pool.hook();
    auto pile = make_pile<S>(def);
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < steps; ++i) {
      pile.world.step();
      hashes.push_back(pile.world.state_hash());
    }
    CHECK(hashes == expected);
    CHECK(pile.world.report().pairs_collided == serial.world.report().pairs_collided);
    CHECK(pile.world.report().contact_points == serial.world.report().contact_points);
    CHECK(pile.world.report().rays_cast == serial.world.report().rays_cast);
  }
}

TEST_CASE("threads: rays are shared from more on than a range has") {
  CHECK(bristle::detail::chosen::fewest_shared_rays > bristle::detail::RayTree<double>::range_size);
}

TEST_CASE("threads: a large world uses the hook for pairs and patches, a small one not at all") {
  std::size_t loops = 0;
  WorldDef<double> def;
  def.parallel_for = [&](std::size_t count, const std::function<void(std::size_t)>& task) {
    ++loops;
    // From the last to the first: the order is nobody's promise.
    for (std::size_t i = count; i-- > 0;) task(i);
  };
  auto small = make_pile<double>(def, 0, 2);
  for (int i = 0; i < 10; ++i) small.world.step();
  CHECK(loops == 10);  // Three patches of 100 sensors.
  auto tiny = make_pile<double>(def, 1, 1);
  for (int i = 0; i < 10; ++i) tiny.world.step();
  CHECK(loops == 10);
  auto large = make_pile<double>(def, 6, 2);
  auto serial = make_pile<double>({}, 6, 2);
  for (int i = 0; i < 60; ++i) {
    large.world.step();
    serial.world.step();
  }
  CHECK(loops > 10 + 60);
  CHECK(large.world.state_hash() == serial.world.state_hash());
}

TEST_CASE_TEMPLATE("threads: ranges of one patch of 10,000 sensors give the same bits", S, float,
                   double) {
  constexpr int steps = 60;
  struct Case {
    Integration integration;
    std::uint32_t cast_every;
    bool in_rows;
  };
  for (const Case& run :
       {Case{Integration::explicit_, 1, false}, Case{Integration::implicit, 1, false},
        Case{Integration::implicit, 1, true}, Case{Integration::implicit, 3, true},
        Case{Integration::explicit_, 3, false}}) {
    CAPTURE(static_cast<int>(run.integration));
    CAPTURE(run.cast_every);
    CAPTURE(run.in_rows);
    std::vector<std::uint64_t> expected;
    auto serial = make_skin<S>({}, run.integration, run.cast_every, run.in_rows);
    std::uint64_t most_touching = 0;
    std::uint64_t rays = 0;
    for (int i = 0; i < steps; ++i) {
      serial.world.step();
      expected.push_back(serial.world.state_hash());
      most_touching = std::max(most_touching, serial.world.report().sensors_touching);
      rays += serial.world.report().rays_cast;
    }
    // Both bodies are felt, by some ranges each, and some packets are near neither.
    REQUIRE(most_touching > 2500);
    REQUIRE(rays > 2 * most_touching);
    REQUIRE(rays < 20000u * steps);
    const auto hashes_with = [&](const ParallelFor& hook) {
      WorldDef<S> def;
      def.parallel_for = hook;
      auto skin = make_skin<S>(def, run.integration, run.cast_every, run.in_rows);
      std::vector<std::uint64_t> hashes;
      for (int i = 0; i < steps; ++i) {
        skin.world.step();
        hashes.push_back(skin.world.state_hash());
      }
      CHECK(skin.world.report().rays_cast == serial.world.report().rays_cast);
      CHECK(skin.world.report().sensors_skipped == serial.world.report().sensors_skipped);
      return hashes;
    };
    for (const unsigned workers : {1u, 2u, 3u, 5u, 8u}) {
      ThreadPool pool(workers);
      CHECK(hashes_with(pool.hook()) == expected);
    }
    // In any order, too, and really in ranges: of rays, and of each sweep over the contacts.
    int loops = 0;
    CHECK(hashes_with([&](std::size_t count, const std::function<void(std::size_t)>& task) {
            ++loops;
            for (std::size_t i = count; i-- > 0;) task(i);
          }) == expected);
    CHECK(loops > steps);
  }
}

namespace {

/// Two floors of 2021 sensors, one in rows and one in neighbour order: two ranges each, of which
/// the last ends within a packet. A ball of triangles and a box slide over each.
template <Scalar S>
struct Floors {
  World<S> world;
  std::vector<BodyId> sliders;

  explicit Floors(const ParallelFor& hook) : world({.time_step = S(1e-3), .parallel_for = hook}) {
    for (const bool in_rows : {true, false}) {
      const S y = S(in_rows ? -0.04 : 0.04);
      const BodyId floor = world.add_body({.motion = Motion::fixed, .position = {0, y, 0}});
      PatchDef<S> patch;
      patch.sensors = sensor_grid<S>(
          {.side_u = {S(0.1), 0, 0}, .side_v = {0, S(0.06), 0}, .count_u = 47, .count_v = 43});
      if (!in_rows) patch.sensors = in_order(patch.sensors, neighbour_order(patch.sensors));
      patch.parameters = tuned_for<S>({.load = S(20), .mass = S(2)}).parameters(patch.sensors);
      world.add_patch(floor, patch);
      sliders.push_back(world.add_body({.mass = S(1),
                                        .shape = sphere_mesh<S>(S(0.03), 8),
                                        .position = {S(-0.022), y, S(0.03)},
                                        .velocity = {S(-0.1), S(0.05), 0}}));
      sliders.push_back(world.add_body({.mass = S(1),
                                        .shape = Box<S>{{S(0.02), S(0.02), S(0.01)}},
                                        .position = {S(0.03), y, S(0.01)},
                                        .velocity = {S(-0.05), S(0.1), 0}}));
    }
  }

  void lift(S height) {
    for (const BodyId id : sliders) {
      Transform<S> pose = world.pose(id);
      pose.translation.z() += height;
      world.set_pose(id, pose);
    }
  }
};

}  // namespace

TEST_CASE_TEMPLATE("threads: several shapes in reach of patches in rows and in neighbour order", S,
                   float, double) {
  std::uint64_t most_touching = 0;
  const auto hashes_with = [&](const ParallelFor& hook) {
    Floors<S> floors(hook);
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < 60; ++i) {
      // For five steps nothing is in reach.
      if (i == 30) floors.lift(S(1));
      if (i == 35) floors.lift(S(-1));
      floors.world.step();
      hashes.push_back(floors.world.state_hash());
      most_touching = std::max(most_touching, floors.world.report().sensors_touching);
    }
    return hashes;
  };
  const std::vector<std::uint64_t> expected = hashes_with(serial_for);
  CHECK(most_touching > 1000);
  for (const unsigned workers : {2u, 3u}) {
    ThreadPool pool(workers);
    CHECK(hashes_with(pool.hook()) == expected);
  }
  // One thread that has all ranges of a patch one after the other, and one that has each by itself.
  const ParallelFor forwards = [](std::size_t count, const auto& task) { serial_for(count, task); };
  const ParallelFor backwards = [](std::size_t count, const auto& task) {
    for (std::size_t i = count; i-- > 0;) task(i);
  };
  CHECK(hashes_with(forwards) == expected);
  CHECK(hashes_with(backwards) == expected);
}
