// SPDX-License-Identifier: BSD-3-Clause
#include "support/random_patch.hpp"

#include <bristle/sensors/patch_explicit.hpp>
#include <bristle/sensors/patch_readings.hpp>
#include <bristle/sensors/sensor_wrench.hpp>

#include <doctest/doctest.h>

#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// The same patch, one sensor after the other by `sensor_wrench`.
template <Scalar S>
class OneByOne {
 public:
  OneByOne(const SensorPatch<S>& patch) : memory_(patch.size()), body_(patch.size(), 9) {}

  /// [N, N m] On A about its centre of mass, by sensor, after `RandomPatch::next`.
  std::vector<Wrench<S>> next(const test::RandomPatch<S>& random) {
    const SensorPatch<S>& patch = random.patch;
    std::vector<Wrench<S>> wrenches;
    for (std::size_t i = 0; i < patch.size(); ++i) {
      const std::size_t body = random.scratch.hits.tag[i] == 12u ? 1 : 0;
      // sensor_wrench leaves this to its caller: a bristle anchored elsewhere starts anew.
      if (body_[i] != body) memory_[i].is_anchored = false;
      body_[i] = body;
      const Body<S>& a = random.a;
      const Body<S>& b = random.b[body];
      wrenches.push_back(sensor_wrench<S>(
          patch.parameters(i), patch.def.options,
          {patch.geometry->start[i], patch.geometry->direction[i], patch.geometry->length[i]},
          random.scratch.hits.distance[i],
          random.a.center_pose.rotate(random.scratch.hits.normal[i]), a.center_pose, a.twist,
          b.center_pose, b.twist, random.dt, memory_[i]));
    }
    return wrenches;
  }

 private:
  std::vector<SensorMemory<S>> memory_;
  std::vector<std::size_t> body_;
};

/// Steps a random patch and compares sums and readings with its sensors one by one.
template <Scalar S>
void compare(test::RandomPatch<S>& random) {
  SensorPatch<S>& patch = random.patch;
  OneByOne<S> one_by_one(patch);
  const Vec3<S> origin = random.a.center_pose.translation;
  const S sums = std::same_as<S, float> ? S(1e-5) : S(1e-12);
  int slips = 0;
  for (int round = 0; round < 60; ++round) {
    random.next();
    const std::vector<Wrench<S>> expected = one_by_one.next(random);
    Wrench<S> on_a;
    for (const PatchPair<S>& pair : random.scratch.pairs) {
      const BodyId id{pair.body_b, 7};
      const Wrench<S> on_b =
          S(1) / random.dt * explicit_impulses(patch, random.scratch, pair, id, random.dt);
      on_a += -on_b.shifted(-pair.arm_a);
    }
    Wrench<S> sum;
    S size = S(0);
    for (const Wrench<S>& w : expected) {
      sum += w;
      size += w.force.norm();
    }
    REQUIRE(size > S(0));
    CHECK((on_a.force - sum.force).norm() < sums * size);
    CHECK((on_a.torque - sum.torque).norm() < sums * size * S(0.1));

    fill_readings<S>(patch, random.scratch, origin, random.dt, [](std::uint32_t slot) {
      return BodyId{slot, 7};
    });
    const PatchReading<S> r = patch.readings.view();
    REQUIRE(r.size() == patch.size());
    CHECK((r.wrench.force - sum.force).norm() < sums * size);
    CHECK((r.wrench.torque - sum.torque).norm() < sums * size * S(0.1));
    for (std::size_t i = 0; i < r.size(); ++i) {
      Vec3<S> t1, t2;
      tangent_basis<S>(patch.geometry->direction[i], t1, t2);
      const Vec3<S> force = random.a.center_pose.rotate(
          r.shear_1[i] * t1 + r.shear_2[i] * t2 - r.normal_force[i] * patch.geometry->direction[i]);
      // 1e-3 of the stretch is round-off of the poses in float.
      CHECK((force - expected[i].force).norm() < S(100) * sums * size);
      const bool is_active_lane = random.scratch.hits.is_hit(i) &&
                                  random.scratch.hits.distance[i] < patch.geometry->length[i] &&
                                  random.scratch.hits.normal[i].dot(patch.geometry->direction[i]) <=
                                      S(-chosen::grazing_cosine);
      CHECK((r.state[i] != SensorState::free) == is_active_lane);
      CHECK((r.body[i] == BodyId{}) == !is_active_lane);
      if (r.state[i] == SensorState::slipping) ++slips;
      if (!is_active_lane) {
        CHECK(r.depth[i] == S(0));
        CHECK(r.normal_force[i] == S(0));
        CHECK(r.shear_1[i] == S(0));
        CHECK(r.shear_2[i] == S(0));
        continue;
      }
      CHECK(r.body[i].index == (random.scratch.hits.tag[i] == 12u ? 4u : 3u));
      const Vec3<S> point(r.point_x[i], r.point_y[i], r.point_z[i]);
      const Vec3<S> p_A = patch.geometry->start[i] +
                          random.scratch.hits.distance[i] * Vec3<S>(patch.geometry->direction[i]);
      CHECK((point - origin - random.a.center_pose.rotate(p_A)).norm() < sums);
    }
  }
  CHECK(slips > 10);
}

}  // namespace

TEST_CASE_TEMPLATE("explicit_impulses: lanes give what sensors one by one give", S, float, double) {
  std::uint64_t seed = 20;
  for (const SlipReset reset : {SlipReset::release, SlipReset::drag}) {
    for (const FrictionScaling scaling :
         {FrictionScaling::normal_force, FrictionScaling::depth, FrictionScaling::none}) {
      for (const NormalDirection normal : {NormalDirection::ray, NormalDirection::gradient}) {
        for (const Integration integration : {Integration::automatic, Integration::explicit_}) {
          LawOptions options;
          options.reset = reset;
          options.scaling = scaling;
          options.normal = normal;
          const bool is_large = scaling == FrictionScaling::normal_force;
          using Patch = test::RandomPatch<S>;
          Patch random(++seed, options, is_large ? Patch::many : Patch::few);
          random.patch.def.integration = integration;
          compare(random);
        }
      }
    }
  }
}

TEST_CASE("explicit_impulses: each sensor with constants of its own") {
  test::RandomPatch<double> random(50, {});
  for (std::size_t i = 0; i < random.patch.size(); ++i) {
    const double k = 1 + 0.1 * static_cast<double>(i);
    random.patch.def.per_sensor.push_back({k, 0.01 * k, 1000 * k, 0.3 * k, 3e-4 * k});
  }
  compare(random);
}
