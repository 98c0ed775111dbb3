/// @file
/// Snapshots: a restored world steps on with the same bits, and nothing else is ever restored.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/grasp.hpp"
#include "scenes/medley.hpp"
#include "scenes/stack.hpp"
#include "support/random.hpp"
#include "support/relative.hpp"
#include "support/rounds.hpp"

#include <bristle/sensors/placement.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

using namespace bristle;

using namespace bristle::detail;
using namespace bristle::scenes;

namespace {

using Bytes = std::vector<std::byte>;

template <typename World>
void run_steps(World& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step();
}

/// Hashes of the state after each of some steps.
template <typename World>
std::vector<std::uint64_t> hashes_of(World& world, int steps) {
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < steps; ++i) {
    world.step();
    hashes.push_back(world.state_hash());
  }
  return hashes;
}

/// Checks that worlds resume from a snapshot what the original did after it: the original itself
/// later in time, and a fresh one.
template <typename World>
void check_resumes(World& original, World fresh, int before, int after) {
  run_steps(original, before);
  const Bytes snapshot = original.snapshot();
  const std::uint64_t hash = original.state_hash();
  const std::vector<std::uint64_t> expected = hashes_of(original, after);
  CHECK(original.state_hash() != hash);
  original.restore(snapshot);
  CHECK(original.state_hash() == hash);
  CHECK(original.snapshot() == snapshot);
  CHECK(hashes_of(original, after) == expected);
  CHECK(fresh.state_hash() != hash);
  fresh.restore(snapshot);
  CHECK(fresh.state_hash() == hash);
  CHECK(hashes_of(fresh, after) == expected);
}

/// Returns whether an exception names something.
bool names(const InvalidArgument& error, const std::string& what) {
  return error.field().find(what) != std::string::npos;
}

/// Field that `restore` objects to.
template <typename World>
std::string refusal_of(World& world, std::span<const std::byte> snapshot) {
  const std::uint64_t before = world.state_hash();
  std::string field;
  try {
    world.restore(snapshot);
  } catch (const InvalidArgument& error) {
    field = error.field();
  }
  if (!field.empty()) CHECK(world.state_hash() == before);
  return field;
}

/// Overwrites the hash of a damaged snapshot, so that the damage gets past the door.
void pass_the_door(Bytes& bytes) {
  bristle::detail::SnapshotHead head;
  std::memcpy(&head, bytes.data(), sizeof head);
  head.payload_size = bytes.size() - sizeof head;
  head.payload_hash = hash_of(std::span<const std::byte>(bytes).subspan(sizeof head));
  std::memcpy(bytes.data(), &head, sizeof head);
}

}  // namespace

TEST_CASE_TEMPLATE("snapshot: a bit of everything resumes with the same bits", S, float, double) {
  // Plates still slide, cubes still fall and the arm still moves at 40 steps.
  auto original = make_medley<S>();
  check_resumes(original.world, make_medley<S>().world, 40, 300);
}

TEST_CASE("snapshot: stacks and grasps resume with the same bits") {
  for (const StackBy by : {StackBy::contact, StackBy::sensors}) {
    StackDef<double> def;
    def.by = by;
    auto original = make_stack<double>(def);
    check_resumes(original.world, make_stack<double>(def).world, 30, 200);
  }
  for (const Integration integration : {Integration::explicit_, Integration::implicit}) {
    GraspDef<double> def;
    def.integration = integration;
    def.finger_mass = 0.3;
    auto original = make_grasp<double>(def);
    check_resumes(original.world, make_grasp<double>(def).world, 100, 300);
  }
}

TEST_CASE("snapshot: what callers set between steps is state") {
  auto original = make_medley<double>();
  auto& world = original.world;
  run_steps(world, 50);
  world.apply_force(original.bodies[0], {3, 0, 0}, {0, 0, 0.1});
  world.set_motor(original.joints[0], {MotorMode::position, 0.02, 4, 0.1});
  world.set_filter(original.bodies[3], {2, 1, 0});
  world.set_parameters(original.patches[1], {2, 0.1, 3000, 0.2, 2e-3});
  world.set_gravity({0.5, 0, -9});
  world.set_time_step(1.0 / 300);
  auto fresh = make_medley<double>();
  fresh.world.restore(world.snapshot());
  CHECK(fresh.world.time_step() == 1.0 / 300);
  CHECK(hashes_of(fresh.world, 100) == hashes_of(world, 100));
}

TEST_CASE("snapshot: queries and readings are those of the restored state") {
  auto original = make_grasp<double>({});
  original.run(0.05);
  auto fresh = make_grasp<double>({});
  fresh.world.set_pose(fresh.part, {Quat<double>::Identity(), {5, 5, 5}});
  fresh.world.restore(original.world.snapshot());
  Ray<double> ray;
  ray.origin = {0, 0, 1};
  ray.direction = {0, 0, -1};
  ray.length = 2;
  CHECK(fresh.world.cast_ray(ray).body == original.part);
  CHECK(fresh.world.cast_ray(ray).distance == original.world.cast_ray(ray).distance);
  CHECK(fresh.total_normal() == original.total_normal());
  CHECK(fresh.total_normal() > 10);
  CHECK(fresh.world.largest_stable_step(fresh.pads[0]) ==
        original.world.largest_stable_step(original.pads[0]));
  const auto taxels = [](const auto& scene) {
    std::vector<double> points(6 * scene.world.patch(scene.pads[0]).size());
    scene.world.taxel_points(scene.pads[0], points);
    return points;
  };
  CHECK(taxels(fresh) == taxels(original));
}

TEST_CASE("snapshot: what touched can let go in a restored world") {
  auto original = make_grasp<double>({});
  original.run(0.05);
  CHECK(original.total_normal() > 10);
  auto fresh = make_grasp<double>({});
  fresh.world.set_pose(fresh.part, {Quat<double>::Identity(), {5, 5, 5}});
  fresh.world.step();
  fresh.world.restore(original.world.snapshot());
  // Turned, it leaves the last packet of the right pad, which its box still meets; then it is far.
  const Quat<double> turned(Eigen::AngleAxisd(0.5, Vec3<double>::UnitZ()));
  for (const Transform<double>& pose :
       {Transform<double>{turned, {-0.004, 0, 0}}, Transform<double>{turned, {0, 0, 5}}}) {
    for (auto* scene : {&original, &fresh}) scene->world.set_pose(scene->part, pose);
    CHECK(hashes_of(fresh.world, 3) == hashes_of(original.world, 3));
  }
}

TEST_CASE("snapshot: a world of other things is named and left alone") {
  auto m = make_medley<double>();
  run_steps(m.world, 50);
  const Bytes snapshot = m.world.snapshot();

  auto fewer = make_medley<double>();
  fewer.world.remove_body(fewer.bodies[3]);
  CHECK(refusal_of(fewer.world, snapshot) == "snapshot: bodies");
  // The same number, but a body of another generation.
  fewer.world.add_body({.mass = 1.0, .shape = Box<double>{{0.1, 0.1, 0.1}}});
  CHECK(refusal_of(fewer.world, snapshot) == "snapshot: bodies");

  auto more = make_medley<double>();
  more.world.add_shape(more.bodies[0], {.shape = Sphere<double>{0.01}});
  CHECK(refusal_of(more.world, snapshot) == "snapshot: shapes");

  auto loose = make_medley<double>();
  loose.world.remove_joint(loose.joints[0]);
  CHECK(refusal_of(loose.world, snapshot) == "snapshot: joints");

  auto numb = make_medley<double>();
  numb.world.remove_patch(numb.patches[2]);
  CHECK(refusal_of(numb.world, snapshot) == "snapshot: patches");
  PatchDef<double> smaller;
  smaller.may_point_inwards = true;
  smaller.sensors.add({0, 0, 0}, {0, 0, -1}, 0.01);
  auto resized = make_medley<double>();
  resized.world.remove_patch(resized.patches[2]);
  numb.world.add_patch(numb.bodies[2], smaller);
  CHECK(refusal_of(numb.world, snapshot) == "snapshot: patches");

  // Another mass is state, another solid is not.
  World<double> hollow;
  World<double> full;
  const Shape<double> ball = Sphere<double>{0.1};
  hollow.add_body({.mass = 1.0, .inertia = Mat3<double>(Mat3<double>::Identity()), .shape = ball});
  full.add_body({.mass = 1.0, .shape = ball});
  CHECK(refusal_of(full, hollow.snapshot()) == "snapshot: bodies (state)");

  auto other_scalar = make_medley<float>();
  CHECK(refusal_of(other_scalar.world, snapshot) == "snapshot: bytes of a scalar");
  CHECK(refusal_of(m.world, snapshot).empty());
}

TEST_CASE("snapshot: truncated, foreign and damaged bytes are refused whole") {
  auto m = make_medley<double>();
  run_steps(m.world, 60);
  const Bytes snapshot = m.world.snapshot();
  auto target = make_medley<double>();
  test::Random random(7);
  for (std::size_t size = 0; size < snapshot.size(); size += 1 + size / 8) {
    INFO("size ", size);
    CHECK_FALSE(refusal_of(target.world, std::span(snapshot).first(size)).empty());
    Bytes cut(snapshot.begin(), snapshot.begin() + static_cast<std::ptrdiff_t>(size));
    if (size < sizeof(bristle::detail::SnapshotHead)) continue;
    pass_the_door(cut);
    CHECK_FALSE(refusal_of(target.world, cut).empty());
  }
  Bytes longer = snapshot;
  longer.push_back(std::byte{0});
  CHECK(refusal_of(target.world, longer) == "snapshot: size");
  pass_the_door(longer);
  CHECK(refusal_of(target.world, longer) == "snapshot: size");
  for (int round = 0; round < test::rounds(200); ++round) {
    Bytes noise(random.index(3000));
    for (std::byte& b : noise) b = static_cast<std::byte>(random.index(256));
    CHECK_FALSE(refusal_of(target.world, noise).empty());
    // One flipped bit anywhere.
    Bytes flipped = snapshot;
    flipped[random.index(flipped.size())] ^= std::byte{1} << random.index(8);
    CHECK_FALSE(refusal_of(target.world, flipped).empty());
  }
}

TEST_CASE("snapshot: damage behind the door never leads out of bounds") {
  auto m = make_medley<double>();
  // With hits that are kept, in several packets.
  PatchDef<double> slow;
  slow.sensors = sensor_grid<double>({.center = {0, 0, -0.015},
                                      .side_u = {0, 0.15, 0},
                                      .side_v = {0.15, 0, 0},
                                      .count_u = 12,
                                      .count_v = 12,
                                      .range = 0.01});
  slow.parameters = m.world.patch(m.patches[0]).def.parameters;
  slow.cast_every = 4;
  slow.may_point_inwards = true;
  m.world.add_patch(m.bodies[0], slow);
  run_steps(m.world, 60);
  const Bytes snapshot = m.world.snapshot();
  test::Random random(11);
  int refused = 0;
  int accepted = 0;
  for (int round = 0; round < test::rounds(300); ++round) {
    Bytes bytes = snapshot;
    const std::size_t first = sizeof(bristle::detail::SnapshotHead);
    const std::size_t hits = 1 + random.index(20);
    for (std::size_t k = 0; k < hits; ++k) {
      bytes[first + random.index(bytes.size() - first)] = static_cast<std::byte>(random.index(256));
    }
    pass_the_door(bytes);
    auto copy = m.world;
    try {
      copy.restore(bytes);
      ++accepted;
      // Numbers may be any, and the world copes; the sanitizers watch.
      run_steps(copy, 3);
    } catch (const InvalidArgument& error) {
      CHECK(names(error, "snapshot"));
      CHECK(copy.state_hash() == m.world.state_hash());
      ++refused;
    }
  }
  CHECK(refused > 0);
  CHECK(accepted > 0);
}

TEST_CASE_TEMPLATE("snapshot: a forged one is refused whole, or leaves a world that steps on", S,
                   float, double) {
  // A box that hangs on a hinge and rests on five sensors: most lanes of their packet are none.
  World<S> world;
  BodyDef<S> def;
  def.motion = Motion::fixed;
  def.shape = HalfSpace<S>{};
  const BodyId floor = world.add_body(def);
  def.motion = Motion::dynamic;
  def.shape = Box<S>{{S(0.1), S(0.1), S(0.1)}};
  def.position = {0, 0, S(0.0995)};
  const BodyId box = world.add_body(def);
  def.position = {0, 0, S(0.3)};
  world.add_body(def);
  world.add_joint({.kind = JointKind::revolute,
                   .body_a = floor,
                   .body_b = box,
                   .X_AJ = {Quat<S>::Identity(), {S(0.1), 0, S(0.0995)}},
                   .X_BJ = {Quat<S>::Identity(), {S(0.1), 0, 0}}});
  PatchDef<S> patch;
  for (int i = 0; i < 5; ++i) {
    patch.sensors.add({S(0.02) * S(i), 0, S(-0.095)}, {0, 0, -1}, S(0.01));
  }
  patch.parameters = {10, S(0.1), 2000, S(0.1), S(1e-3)};
  const PatchId sensors = world.add_patch(box, patch);
  patch.cast_every = 3;
  const PatchId slow = world.add_patch(box, patch);
  run_steps(world, 20);
  REQUIRE(world.reading(sensors).touching() == 5);
  REQUIRE(world.reading(slow).touching() == 5);
  const Bytes snapshot = world.snapshot();
  const std::uint64_t hash = world.state_hash();
  using Limits = std::numeric_limits<S>;
  const std::array<S, 8> numbers{Limits::quiet_NaN(),
                                 Limits::infinity(),
                                 -Limits::infinity(),
                                 Limits::max(),
                                 Limits::lowest(),
                                 S(-1),
                                 S(0),
                                 Limits::denorm_min()};
  test::Random random(23);
  constexpr std::size_t head = sizeof(bristle::detail::SnapshotHead);
  int accepted = 0;
  const auto check = [&](Bytes bytes) {
    pass_the_door(bytes);
    World<S> copy = world;
    if (!refusal_of(copy, bytes).empty()) return;
    ++accepted;
    CHECK(copy.time_step() > S(0));
    for (const PatchId id : {sensors, slow}) CHECK(copy.largest_stable_step(id) >= S(0));
    run_steps(copy, 2);
    for (const BodyId id : {floor, box}) {
      const Transform<S> X = copy.pose(id);
      CHECK(X.translation.allFinite());
      CHECK(X.rotation.norm() == test::relative(1).epsilon(1e-3));
      CHECK(copy.body(id).twist.linear.allFinite());
    }
    CHECK_NOTHROW(copy.restore(copy.snapshot()));
  };
  for (int round = 0; round < test::rounds(3000); ++round) {
    Bytes flipped = snapshot;
    flipped[head + random.index(snapshot.size() - head)] ^= std::byte{1} << random.index(8);
    check(std::move(flipped));
    Bytes forged = snapshot;
    std::memcpy(forged.data() + head + random.index(snapshot.size() - head - sizeof(S)),
                &numbers[random.index(numbers.size())], sizeof(S));
    check(std::move(forged));
  }
  CHECK(accepted > 0);
  CHECK(world.state_hash() == hash);
}

TEST_CASE("snapshot: a step, a pose and a turn that cannot be are named") {
  World<double> world({.time_step = 1.0 / 512});
  const Vec3<double> place(0.7186, -1.339, 2.417);
  const BodyId id = world.add_body({.mass = 1.0, .shape = Sphere<double>{0.1}, .position = place});
  const Bytes snapshot = world.snapshot();
  const auto refusal_with = [&](double was, double becomes) {
    Bytes bytes = snapshot;
    const auto* first = reinterpret_cast<const std::byte*>(&was);
    const auto at = std::search(bytes.begin() + sizeof(bristle::detail::SnapshotHead), bytes.end(),
                                first, first + sizeof was);
    REQUIRE(at != bytes.end());
    std::memcpy(&*at, &becomes, sizeof becomes);
    pass_the_door(bytes);
    return refusal_of(world, bytes);
  };
  for (const double step : {0.0, -1.0 / 512, 1e-200}) {
    CHECK(refusal_with(1.0 / 512, step) == "snapshot: time step");
  }
  CHECK(refusal_with(place.x(), infinity<double>) == "snapshot: number");
  CHECK(refusal_with(place.y(), std::nan("")) == "snapshot: number");
  CHECK(refusal_with(place.z(), 1e200) == "snapshot: bodies (state)");
  // The real part of its orientation: the first 1 behind the mass.
  world.set_pose(id, {Quat<double>(0.6, 0.8, 0, 0), place});
  const Bytes turned = world.snapshot();
  Bytes bytes = turned;
  const double was = 0.8, becomes = 0.9;
  const auto* first = reinterpret_cast<const std::byte*>(&was);
  const auto at = std::search(bytes.begin(), bytes.end(), first, first + sizeof was);
  REQUIRE(at != bytes.end());
  std::memcpy(&*at, &becomes, sizeof becomes);
  pass_the_door(bytes);
  CHECK(refusal_of(world, bytes) == "snapshot: bodies (state)");
}

TEST_CASE("state_hash: every kind of state counts") {
  const auto reference = make_medley<double>();
  const std::uint64_t hash = reference.world.state_hash();
  const auto differs = [&](auto&& change) {
    auto m = make_medley<double>();
    change(m);
    return m.world.state_hash() != hash;
  };
  using M = Medley<double>;
  CHECK_FALSE(differs([](M&) {}));
  CHECK(differs([](M& m) {
    m.world.set_velocity(m.bodies[0], {{0.3, 0.1, 1e-300}, {0, 0.4, 1}});
  }));
  CHECK(differs([](M& m) { m.world.apply_force(m.bodies[7], {0, 0, 1e-9}, {0, 0, 0}); }));
  CHECK(differs([](M& m) { m.world.set_filter(m.bodies[1], {1, 0xfffffffe, 0}); }));
  CHECK(differs([](M& m) { m.world.set_motor(m.joints[0], {}); }));
  CHECK(differs([](M& m) { m.world.set_parameters(m.patches[0], {1, 0.05, 2000, 0.5, 1.1e-3}); }));
  CHECK(differs([](M& m) { m.world.set_gravity({0, 0, -9.8}); }));
  CHECK(differs([](M& m) { m.world.set_time_step(1e-3); }));
  CHECK(differs([](M& m) { m.world.remove_joint(m.joints[1]); }));
  CHECK(differs([](M& m) { m.world.step(); }));
  // -0.0 equals 0.0, but not in its bits.
  CHECK(differs([](M& m) { m.world.set_gravity({-0.0, 0, -9.81}); }));
}

TEST_CASE_TEMPLATE("snapshot: masses and surfaces that were set come back, with the same bits", S,
                   float, double) {
  const auto make = [] {
    World<S> world({.gravity = {S(3), S(0), S(-9)}});
    world.add_body({.motion = Motion::fixed, .shape = HalfSpace<S>{}});
    BodyDef<S> box;
    box.mass = S(1);
    box.shape = Box<S>{{S(0.1), S(0.1), S(0.02)}};
    box.position = {S(0), S(0), S(0.02)};
    world.add_body(box);
    return world;
  };
  const BodyId box{1, 0};
  World<S> world = make();
  world.set_mass(box, S(0.3));
  world.set_material(box, {.friction = S(0.1)});
  for (int i = 0; i < 30; ++i) world.step();
  const std::vector<std::byte> then = world.snapshot();
  World<S> other = make();
  CHECK(other.state_hash() != world.state_hash());
  world.set_mass(box, S(2));
  world.set_material(box, {.friction = S(1)});
  CHECK(world.snapshot() != then);
  world.restore(then);
  other.restore(then);
  CHECK(other.body(box).mass == S(0.3));
  for (int i = 0; i < 30; ++i) {
    world.step();
    other.step();
  }
  CHECK(world.state_hash() == other.state_hash());
  // Of a friction of sqrt(0.5 * 0.1) that it slides by for a quarter of a second.
  const S expected = (S(3) - std::sqrt(S(0.05)) * S(9)) / S(4);
  CHECK(world.body(box).twist.linear.x() == test::relative(expected).epsilon(1e-3));
}
