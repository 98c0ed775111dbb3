/// @file
/// Batches of worlds: each does what it would alone, is reset, changed and read.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/grasp.hpp"
#include "support/relative.hpp"

#include <bristle/core/thread_pool.hpp>
#include <bristle/world/world_batch.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

using namespace bristle;
using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

/// Two driven fingers that hold a part; world i of a batch has a part of its own mass and friction.
template <typename S>
GraspScene<S> training_grasp() {
  GraspDef<S> def;
  def.finger_mass = S(0.1);
  return make_grasp<S>(def);
}

template <typename S>
void vary(const GraspScene<S>& scene, std::size_t number, World<S>& world) {
  world.set_mass(scene.part, S(0.2) + S(0.01) * S(number));
  SensorParameters<S> parameters = world.patch(scene.pads[0]).def.parameters;
  parameters.static_friction *= S(1) + S(number % 7) / S(10);
  for (const PatchId pad : scene.pads) world.set_parameters(pad, parameters);
}

template <typename S>
std::vector<std::uint64_t> batch_hashes(const WorldBatch<S>& batch) {
  std::vector<std::uint64_t> hashes;
  for (std::size_t i = 0; i < batch.size(); ++i) hashes.push_back(batch.world(i).state_hash());
  return hashes;
}

std::string field_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const InvalidArgument& error) {
    return error.field();
  }
  return {};
}

}  // namespace

TEST_CASE_TEMPLATE("WorldBatch: worlds do what they would do alone, for any number of threads", S,
                   float, double) {
  const GraspScene<S> scene = training_grasp<S>();
  constexpr std::size_t count = 37;
  std::vector<std::uint64_t> alone;
  for (std::size_t i = 0; i < count; ++i) {
    World<S> world(scene.world);
    vary(scene, i, world);
    for (int k = 0; k < 60; ++k) world.step();
    alone.push_back(world.state_hash());
  }
  CHECK(alone[0] != alone[1]);
  for (const unsigned workers : {1u, 2u, 3u, 8u}) {
    CAPTURE(workers);
    ThreadPool pool(workers);
    WorldBatch<S> batch(scene.world, count, pool.hook());
    batch.for_each([&](std::size_t i, World<S>& world) { vary(scene, i, world); });
    for (int k = 0; k < 20; ++k) batch.step(3);
    CHECK(batch_hashes(batch) == alone);
  }
}

TEST_CASE("WorldBatch: worlds share the rays of their patches, which outlive the original") {
  std::optional<GraspScene<double>> scene = training_grasp<double>();
  const PatchId pad = scene->pads[0];
  std::optional<WorldBatch<double>> batch(std::in_place, scene->world, std::size_t(2));
  const auto* rays = scene->world.patch(pad).geometry.get();
  for (const std::size_t i : {0u, 1u}) CHECK(batch->world(i).patch(pad).geometry.get() == rays);
  World<double> copy(batch->world(1));
  batch.reset();
  scene.reset();
  copy.step();
  CHECK(copy.reading(pad).touching() > 0);
}

TEST_CASE("WorldBatch: worlds of a mask start anew, with the masses they had") {
  const auto scene = training_grasp<double>();
  WorldBatch<double> batch(scene.world, 20);
  const std::uint64_t start = scene.world.state_hash();
  batch.for_each([&](std::size_t i, World<double>& world) { vary(scene, i, world); });
  batch.step(10);
  const std::vector<std::uint64_t> before = batch_hashes(batch);
  std::vector<std::uint8_t> mask(20, 0);
  mask[3] = mask[17] = 1;
  batch.reset(mask);
  for (std::size_t i = 0; i < 20; ++i) {
    CHECK(batch.world(i).state_hash() == (mask[i] != 0 ? start : before[i]));
    const double mass = mask[i] != 0 ? 0.5 : 0.2 + 0.01 * double(i);
    CHECK(batch.world(i).body(scene.part).mass == test::relative(mass).epsilon(1e-15));
  }
  batch.reset();
  batch.step(7);
  World<double> alone(scene.world);
  for (int k = 0; k < 7; ++k) alone.step();
  for (const std::uint64_t hash : batch_hashes(batch)) CHECK(hash == alone.state_hash());
}

TEST_CASE("WorldBatch: worlds of a mask go on from another world's state, and then as it does") {
  const auto scene = training_grasp<double>();
  World<double> later(scene.world);
  for (int k = 0; k < 12; ++k) later.step();
  WorldBatch<double> batch(scene.world, 5);
  batch.step(3);
  const std::vector<std::uint64_t> before = batch_hashes(batch);
  const std::vector<std::uint8_t> mask{0, 1, 0, 0, 1};
  batch.reset_to(later, mask);
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(batch.world(i).state_hash() == (mask[i] != 0 ? later.state_hash() : before[i]));
  }
  // One of the batch's own worlds serves as well.
  batch.reset_to(batch.world(4));
  batch.step(4);
  for (int k = 0; k < 4; ++k) later.step();
  for (const std::uint64_t hash : batch_hashes(batch)) CHECK(hash == later.state_hash());
  CHECK_THROWS_AS(batch.reset_to(later, std::vector<std::uint8_t>(4, 1)), InvalidArgument);
}

TEST_CASE("WorldBatch: what is gathered is what the worlds say") {
  const auto scene = training_grasp<double>();
  WorldBatch<double> batch(scene.world, 19);
  batch.for_each([&](std::size_t i, World<double>& world) { vary(scene, i, world); });
  batch.step(5);
  const std::size_t n = scene.world.patch(scene.pads[0]).size();
  std::vector<double> bodies(19 * 2 * 13), joints(19 * 2 * 2), taxels(19 * 2 * 4 * n),
      points(19 * 2 * 6 * n), own(6 * n);
  std::vector<std::uint32_t> touching(19 * 2);
  const std::vector<BodyId> ids{scene.fingers[1], scene.part};
  batch.gather_bodies(ids, bodies);
  batch.gather_joints(scene.drives, joints);
  batch.gather_taxels(scene.pads, taxels);
  batch.gather_points(scene.pads, points);
  batch.gather_touching(scene.pads, touching);
  for (std::size_t i = 0; i < 19; ++i) {
    CAPTURE(i);
    const World<double>& world = batch.world(i);
    for (std::size_t k = 0; k < 2; ++k) {
      const double* b = &bodies[(2 * i + k) * 13];
      const Transform<double> X = world.pose(ids[k]);
      const Twist<double>& twist = world.body(ids[k]).twist;
      CHECK(Vec3<double>(b[0], b[1], b[2]) == X.translation);
      CHECK(Quat<double>(b[6], b[3], b[4], b[5]).coeffs() == X.rotation.coeffs());
      CHECK(Vec3<double>(b[7], b[8], b[9]) == twist.linear);
      CHECK(Vec3<double>(b[10], b[11], b[12]) == twist.angular);
      CHECK(joints[2 * (2 * i + k)] == world.reading(scene.drives[k]).position);
      CHECK(joints[2 * (2 * i + k) + 1] == world.reading(scene.drives[k]).velocity);
      const PatchReading<double> reading = world.reading(scene.pads[k]);
      world.taxel_points(scene.pads[k], own);
      CHECK(
          std::equal(own.begin(), own.end(), points.begin() + std::ptrdiff_t((2 * i + k) * 6 * n)));
      CHECK(touching[2 * i + k] == reading.touching());
      const double* t = &taxels[(2 * i + k) * 4 * n];
      for (std::size_t s = 0; s < n; ++s) {
        CHECK(t[s] == reading.depth[s]);
        CHECK(t[n + s] == reading.normal_force[s]);
        CHECK(t[2 * n + s] == reading.shear_1[s]);
        CHECK(t[3 * n + s] == reading.shear_2[s]);
      }
    }
  }
  CHECK(touching[0] > 0);
}

TEST_CASE("WorldBatch: a world that cannot be computed is named, and the others go on") {
  const auto scene = training_grasp<double>();
  WorldBatch<double> batch(scene.world, 20);
  WorldBatch<double> good(batch);
  // Times its mass that is no number a double has.
  batch.world(11).apply_wrench(scene.part, {{1e150, 0, 0}, {0, 0, 0}});
  batch.world(11).set_mass(scene.part, 1e-140);
  batch.step(2);
  good.step(2);
  for (std::size_t i = 0; i < 20; ++i) {
    CAPTURE(i);
    CHECK(batch.failed()[i] == (i == 11 ? 1 : 0));
    if (i != 11) CHECK(batch.world(i).state_hash() == good.world(i).state_hash());
  }
  batch.reset(batch.failed());
  CHECK(batch.failed()[11] == 0);
  CHECK(batch.world(11).state_hash() == scene.world.state_hash());
}

TEST_CASE("WorldBatch: what does not fit is refused, and nothing is written") {
  const auto scene = training_grasp<double>();
  CHECK(field_of([&] { WorldBatch<double>(scene.world, 0); }) == "WorldBatch: count");
  WorldBatch<double> batch(scene.world, 4);
  const std::vector<std::uint64_t> before = batch_hashes(batch);
  const std::vector<std::uint8_t> mask(3, 1);
  std::vector<double> out(4 * 13, 7.0);
  const std::vector<BodyId> part{scene.part};
  const std::span<double> shorter = std::span(out).first(51);
  CHECK(field_of([&] { (void)batch.world(4); }) == "WorldBatch: number of a world");
  CHECK(field_of([&] { batch.reset(mask); }) == "WorldBatch: mask.size()");
  CHECK(field_of([&] { batch.gather_bodies(part, shorter); }) == "WorldBatch: out.size()");
  batch.world(2).remove_body(scene.part);
  CHECK(field_of([&] { batch.gather_bodies(part, out); }) == "WorldBatch: handle of a world");
  for (const double x : out) CHECK(x == 7.0);
  batch.reset();
  CHECK(batch_hashes(batch) == before);
  CHECK(field_of([&] { WorldBatch<double>(scene.world, 2, ParallelFor{}); }) ==
        "WorldBatch: parallel_for");
  // A world that was assigned to has another patch under the same handle.
  World<double> wide;
  const BodyId finger = wide.add_body({.motion = Motion::kinematic});
  SensorLayout<double> many;
  for (int i = 0; i < 40; ++i) many.add({0.01 * i, 0, 0}, {0, 0, 1}, 0.01);
  REQUIRE(wide.add_patch(finger, many, SensorParameters<double>{}) == scene.pads[0]);
  batch.world(3) = wide;
  const std::vector<PatchId> pads{scene.pads[0]};
  std::vector<double> taxels(4 * 4 * scene.world.patch(scene.pads[0]).size(), 7.0);
  CHECK(field_of([&] { batch.gather_taxels(pads, taxels); }) == "WorldBatch: sensors of a patch");
  for (const double x : taxels) CHECK(x == 7.0);
}

TEST_CASE("WorldBatch: of what several visits throw the first counts, by number; all are made") {
  const auto scene = training_grasp<double>();
  ThreadPool pool(3);
  WorldBatch<double> batch(scene.world, 200, pool.hook());
  std::vector<int> visited(200, 0);
  const auto visit = [&](std::size_t i, World<double>& world) {
    ++visited[i];
    if (i % 70 == 60) world.set_mass(scene.part, -double(i));
  };
  CHECK_THROWS_WITH_AS(batch.for_each(visit), doctest::Contains("-60"), InvalidArgument);
  CHECK(std::count(visited.begin(), visited.end(), 1) == 200);
}

TEST_CASE("WorldBatch: few worlds are shared out, too") {
  const auto scene = training_grasp<double>();
  std::size_t most = 0;
  const ParallelFor counting = [&](std::size_t count, const auto& task) {
    most = std::max(most, count);
    serial_for(count, task);
  };
  WorldBatch<double> batch(scene.world, 12, counting);
  batch.step();
  CHECK(most == 12);
}

TEST_CASE("WorldBatch: worlds that have become different scenes do what they would alone") {
  const auto scene = training_grasp<double>();
  const auto change = [&](std::size_t i, World<double>& world) {
    if (i % 5 == 1) world.remove_body(scene.part);
    if (i % 5 == 2) world.remove_joint(scene.drives[1]);
    if (i % 5 == 3) world.remove_patch(scene.pads[0]);
    if (i % 5 == 4) {
      world.set_time_step(1.0 / 240);
      for (int k = 0; k < 6; ++k) {
        world.add_body(
            {.mass = 0.1, .shape = Sphere<double>{0.02}, .position = {0.01 * k, 0.2, 0.05 * k}});
      }
    }
  };
  ThreadPool pool(2);
  WorldBatch<double> batch(scene.world, 130, pool.hook());
  batch.for_each(change);
  for (int k = 0; k < 10; ++k) batch.step(4);
  for (std::size_t i = 0; i < batch.size(); i += 7) {
    World<double> alone(scene.world);
    change(i, alone);
    for (int k = 0; k < 40; ++k) alone.step();
    CHECK(batch.world(i).state_hash() == alone.state_hash());
  }
}

TEST_CASE_TEMPLATE("set_mass: weight, inertia and swing are those of a body made with that mass", S,
                   float, double) {
  // A box on its edge tips over a fixed corner of the floor; the other is made as heavy.
  const auto make = [](S mass) {
    World<S> world;
    BodyDef<S> floor;
    floor.motion = Motion::fixed;
    floor.shape = HalfSpace<S>{};
    world.add_body(floor);
    BodyDef<S> box;
    box.mass = mass;
    box.shape = Box<S>{{S(0.1), S(0.05), S(0.02)}};
    box.position = {S(0), S(0), S(0.15)};
    box.orientation = exp_rotation<S>({S(0.3), S(0.2), S(0)});
    world.add_body(box);
    return world;
  };
  World<S> expected = make(S(4));
  World<S> changed = make(S(0.5));
  const BodyId box{1, 0};
  REQUIRE(changed.contains(box));
  changed.set_mass(box, S(4));
  const Mat3<S> difference = changed.body(box).inertia_B - expected.body(box).inertia_B;
  CHECK(difference.norm() < Tolerance<S>::round_off() * expected.body(box).inertia_B.norm());
  for (int i = 0; i < 100; ++i) {
    expected.step();
    changed.step();
  }
  CHECK((changed.pose(box).translation - expected.pose(box).translation).norm() <
        Tolerance<S>::equal());
  using Limits = std::numeric_limits<S>;
  for (const S bad : {S(0), S(-1), Limits::quiet_NaN(), Limits::infinity(), Limits::min()}) {
    CHECK_THROWS_AS(changed.set_mass(box, bad), InvalidArgument);
  }
  CHECK(changed.body(box).mass == S(4));
  CHECK_THROWS_WITH_AS(changed.set_mass(BodyId{0, 0}, S(1)), doctest::Contains("dynamic"),
                       InvalidArgument);
}

TEST_CASE(
    "set_material: a box that stood slides by g (sin a - mu cos a) once its slope is smooth") {
  const double angle = 0.3;
  World<double> world({.gravity = {9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)}});
  const BodyId floor = world.add_body(
      {.motion = Motion::fixed, .shape = HalfSpace<double>{}, .material = {.friction = 1}});
  const BodyId box = world.add_body({.mass = 1,
                                     .shape = Box<double>{{0.1, 0.1, 0.02}},
                                     .material = {.friction = 1},
                                     .position = {0, 0, 0.02}});
  for (int i = 0; i < 500; ++i) world.step();
  CHECK(world.body(box).twist.linear.norm() < 1e-9);
  for (const BodyId id : {floor, box}) world.set_material(id, {.friction = 0.1});
  const double time = 0.5;
  for (int i = 0; i < std::lround(time / world.time_step()); ++i) world.step();
  const double expected = 9.81 * (std::sin(angle) - 0.1 * std::cos(angle)) * time;
  CHECK(world.body(box).twist.linear.x() == test::relative(expected).epsilon(1e-3));
  CHECK_THROWS_AS(world.set_material(box, {.friction = -1}), InvalidArgument);
}
