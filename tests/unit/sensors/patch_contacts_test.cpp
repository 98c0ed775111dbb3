// SPDX-License-Identifier: BSD-3-Clause
#include "support/random_patch.hpp"
#include "support/relative.hpp"

#include <bristle/sensors/patch_contacts.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>

using namespace bristle;

using namespace bristle::detail;

namespace {

/// [1] Of sums of a few hundred terms that partly cancel.
template <typename S>
constexpr S contact_round_off = S(50) * Tolerance<S>::round_off();

/// Which sensors have a contact in a pair, and where: packet of contacts and lane.
template <typename S, typename Visit>
void for_each_contact(const PatchScratch<S>& scratch, const PatchPair<S>& pair, Visit&& visit) {
  for (std::uint32_t k = pair.first; k < pair.first + pair.count; ++k) {
    const ContactPacket<S>& packet = scratch.contacts[k];
    for (std::size_t i = 0; i < packet_size; ++i) {
      if ((packet.is_in_range >> i & 1u) != 0) visit(packet, i, packet.packet * packet_size + i);
    }
  }
}

}  // namespace

TEST_CASE_TEMPLATE("collect_contacts: every hit that does not graze, at its body, as in scalars", S,
                   float, double) {
  test::RandomPatch<S> few(11, {});
  test::RandomPatch<S> many(11, {}, test::RandomPatch<S>::many);
  for (int round = 0; round < 24; ++round) {
    test::RandomPatch<S>& random = round < 20 ? few : many;
    random.next();
    const SensorPatch<S>& patch = random.patch;
    std::size_t found = 0;
    for (const PatchPair<S>& pair : random.scratch.pairs) {
      const std::size_t body = pair.body_b == test::RandomPatch<S>::id(0).index ? 0 : 1;
      const Body<S>& a = random.a;
      const Body<S>& b = random.b[body];
      Vec3<S> center = Vec3<S>::Zero();
      std::size_t count = 0;
      for_each_contact(
          random.scratch, pair, [&](const ContactPacket<S>& packet, std::size_t i, std::size_t k) {
            ++found;
            ++count;
            REQUIRE(k < patch.size());
            CHECK((random.scratch.hits.tag[k] == 12u) == (body == 1));
            const Vec3<S> m = random.scratch.hits.normal[k];
            const Vec3<S> point =
                patch.geometry->start[k] +
                random.scratch.hits.distance[k] * Vec3<S>(patch.geometry->direction[k]);
            const S depth = S(1) - random.scratch.hits.distance[k] / patch.geometry->length[k];
            CHECK(((packet.is_in_contact >> i & 1u) != 0) == (depth > S(0)));
            // In lanes, and of one sensor.
            const std::size_t at = i / lanes<S> * lanes<S>;
            const TouchPack<S> touches(random.scratch.hits, patch.geometry->packets[packet.packet],
                                       packet.packet, at, packet.is_in_range, false);
            const SensorTouch<S> touch = touch_of(*patch.geometry, random.scratch.hits, k);
            for (const auto& [point_found, g_found, depth_found] :
                 {std::tuple(touches.point[i - at], touches.g[i - at], touches.depth[i - at]),
                  std::tuple(touch.point, touch.g, touch.depth)}) {
              CHECK((point_found - point).norm() < contact_round_off<S>);
              CHECK((g_found - depth_gradient<S>(patch.geometry->direction[k], m)).norm() <
                    S(100) * contact_round_off<S>);
              CHECK(std::abs(depth_found - depth) < contact_round_off<S>);
            }
            center += point;
            // The motion at the point, from that of both bodies in the world.
            const Vec3<S> r_W = a.center_pose.rotate(point);
            const Vec3<S> p_AB = b.center_pose.translation - a.center_pose.translation;
            const Vec3<S> v = a.twist.at(r_W) - b.twist.at(r_W - p_AB);
            CHECK((pair.R_WA * pair.start_motion.at(point) - v).norm() < contact_round_off<S>);
          });
      center /= S(count);
      CHECK((pair.center - center).norm() < contact_round_off<S>);
      CHECK((pair.arm_a - a.center_pose.rotate(center)).norm() < contact_round_off<S>);
      const Vec3<S> arm_b = pair.arm_a + a.center_pose.translation - b.center_pose.translation;
      CHECK((pair.arm_b - arm_b).norm() < contact_round_off<S>);
    }
    std::size_t expected = 0;
    for (std::size_t k = 0; k < patch.size(); ++k) {
      expected += random.scratch.hits.is_hit(k) &&
                          random.scratch.hits.normal[k].dot(patch.geometry->direction[k]) <=
                              S(-chosen::grazing_cosine)
                      ? 1u
                      : 0u;
    }
    CHECK(found == expected);
  }
}

TEST_CASE_TEMPLATE("collect_contacts: bristles are anchored while they touch, and in that body", S,
                   float, double) {
  test::RandomPatch<S> random(12, {});
  for (int round = 0; round < 20; ++round) {
    random.next();
    const SensorPatch<S>& patch = random.patch;
    std::vector<BodyId> touched(patch.bristles.size() * packet_size);
    for (const PatchPair<S>& pair : random.scratch.pairs) {
      const std::size_t body = pair.body_b == test::RandomPatch<S>::id(0).index ? 0 : 1;
      for_each_contact(
          random.scratch, pair, [&](const ContactPacket<S>& packet, std::size_t i, std::size_t k) {
            if ((packet.is_in_contact >> i & 1u) == 0) return;
            touched[k] = test::RandomPatch<S>::id(body);
            // Anchored with the stretch that is reported.
            const Anchor<S> anchor{patch.bristles[packet.packet].anchor_a[i],
                                   patch.bristles[packet.packet].anchor_b[i]};
            const Vec3<S> stretch =
                anchor_stretch(anchor, pair.pose, Vec3<S>(patch.geometry->direction[k]));
            CHECK((stretch - packet.stretch[i]).norm() < contact_round_off<S>);
            CHECK(packet.stretch[i].norm() <=
                  patch.def.parameters.breakaway_distance * (1 + contact_round_off<S>));
          });
    }
    for (std::size_t k = 0; k < touched.size(); ++k) {
      const bool is_anchored = (patch.is_anchored[k / packet_size] >> k % packet_size & 1u) != 0;
      CHECK(is_anchored == (touched[k] != BodyId{}));
      if (is_anchored) CHECK(patch.readings.body[k] == touched[k]);
    }
  }
}

TEST_CASE_TEMPLATE("collect_contacts: stiffness is summed about the middle of the patch", S, float,
                   double) {
  for (const FrictionScaling scaling :
       {FrictionScaling::normal_force, FrictionScaling::depth, FrictionScaling::none}) {
    LawOptions options;
    options.scaling = scaling;
    test::RandomPatch<S> random(13, options);
    random.next();
    const SensorPatch<S>& patch = random.patch;
    const SensorParameters<S>& p = patch.def.parameters;
    const S dt = test::RandomPatch<S>::dt;
    for (const PatchPair<S>& pair : random.scratch.pairs) {
      PairStiffness<S> expected;
      for_each_contact(
          random.scratch, pair, [&](const ContactPacket<S>& packet, std::size_t i, std::size_t k) {
            const SensorTouch<S> touch = touch_of(*patch.geometry, random.scratch.hits, k);
            const Vec3<S> arm = touch.point - patch.geometry->box.center();
            const S normal = (dt * dt * p.normal_stiffness + 2 * dt * p.normal_damping) /
                             patch.geometry->length[k];
            expected.normal += normal;
            expected.normal_first += normal * arm;
            expected.normal_second += normal * arm.squaredNorm();
            if ((packet.is_in_contact >> i & 1u) == 0) return;
            const S rate =
                touch.g.dot(pair.start_motion.at(touch.point)) / patch.geometry->length[k];
            const S k_t =
                bristle_stiffness(p, scaling, normal_force(p, touch.depth, rate), touch.depth);
            const S tangential = dt * dt * k_t + 2 * dt * p.sliding_friction;
            expected.bristle_sum += k_t;
            expected.viscous_sum += p.sliding_friction;
            expected.tangential += tangential;
            expected.tangential_first += tangential * arm;
            expected.tangential_second += tangential * arm.squaredNorm();
          });
      const PairStiffness<S>& found = pair.stiffness;
      const auto same = [](S x, S y) {
        return std::abs(x - y) <= contact_round_off<S> * std::abs(y);
      };
      CHECK(same(found.bristle_sum, expected.bristle_sum));
      CHECK(same(found.viscous_sum, expected.viscous_sum));
      CHECK(same(found.tangential, expected.tangential));
      CHECK(same(found.normal, expected.normal));
      CHECK(same(found.tangential_second, expected.tangential_second));
      CHECK(same(found.normal_second, expected.normal_second));
      CHECK((found.tangential_first - expected.tangential_first).norm() <=
            contact_round_off<S> * S(0.1) * expected.tangential);
      CHECK((found.normal_first - expected.normal_first).norm() <=
            contact_round_off<S> * S(0.1) * expected.normal);
    }
  }
}

TEST_CASE("collect_contacts: who hits nothing lets go; nothing near or cleared, all do") {
  test::RandomPatch<double> random(14, {});
  for (const bool is_any_near : {true, false}) {
    random.next();
    REQUIRE(random.patch.has_hits);
    REQUIRE(!random.patch.sensed.empty());
    random.scratch.reset_near_hits();
    const DynamicArray<std::uint32_t> near = random.scratch.near;
    if (!is_any_near) random.scratch.near.clear();
    collect_contacts(random.patch, random.scratch, random.a,
                     [](std::uint32_t) { return TouchedBody<double>{}; }, {.dt = 1e-3});
    CHECK(random.scratch.pairs.empty());
    CHECK_FALSE(random.patch.has_hits);
    CHECK(random.patch.sensed.empty());
    for (const LaneBits bits : random.patch.is_anchored) CHECK(bits == 0);
    random.scratch.near = near;
  }
  random.next();
  clear_patch(random.patch);
  CHECK_FALSE(random.patch.has_hits);
  CHECK(random.patch.sensed.empty());
  for (const LaneBits bits : random.patch.is_anchored) CHECK(bits == 0);
}

TEST_CASE("reset_near_hits: of a range, and only what is near") {
  test::RandomPatch<double> random(15, {}, 53);
  random.next();
  PatchScratch<double> scratch = random.scratch;
  scratch.near = {0, 1, 3};
  scratch.reset_near_hits({16, 32});
  for (std::size_t i = 0; i < 53; ++i) {
    const bool is_kept = i < 16 || i >= 32;
    CHECK(scratch.hits.distance[i] ==
          (is_kept ? random.scratch.hits.distance[i] : infinity<double>));
  }
  scratch.near = {0, 3};
  scratch.reset_near_hits();
  for (std::size_t i = 0; i < 53; ++i) {
    const bool is_kept = i >= 32 && i < 48;
    CHECK(scratch.hits.distance[i] ==
          (is_kept ? random.scratch.hits.distance[i] : infinity<double>));
  }
}

TEST_CASE("find_hit_mask: range by range as all at once, and nothing of other ranges") {
  test::RandomPatch<double> random(15, {}, 53);
  random.next();
  SensorPatch<double> whole = random.patch;
  PatchScratch<double> whole_scratch = random.scratch;
  REQUIRE(whole.bristles.size() == 4);
  for (const LaneBits bits : whole.is_anchored) REQUIRE(bits != 0);
  // The second packet is near nothing any more, and the last hits nothing.
  whole_scratch.near = {0, 2, 3};
  whole_scratch.reset_near_hits({48, 53});
  SensorPatch<double> in_ranges = whole;
  PatchScratch<double> ranges_scratch = whole_scratch;
  begin_hit_mask(in_ranges, ranges_scratch);
  find_hit_mask(in_ranges, ranges_scratch, {32, 53});
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK((in_ranges.hit_bits[i] != 0) == (i == 2));
    CHECK(in_ranges.is_anchored[i] == (i == 3 ? 0 : whole.is_anchored[i]));
  }
  find_hit_mask(in_ranges, ranges_scratch, {0, 16});
  CHECK(in_ranges.is_anchored[1] == whole.is_anchored[1]);
  find_hit_mask(in_ranges, ranges_scratch, {16, 32});
  CHECK(in_ranges.is_anchored[1] == 0);

  const auto collect = [&](SensorPatch<double>& patch, PatchScratch<double>& scratch,
                           bool knows_hit_mask) {
    collect_contacts(patch, scratch, random.a,
                     [&](std::uint32_t tag) {
                       const std::size_t body = tag == 12u ? 1 : 0;
                       return TouchedBody<double>{&random.b[body], random.id(body)};
                     },
                     {.dt = 1e-3, .knows_hit_mask = knows_hit_mask});
  };
  collect(whole, whole_scratch, false);
  collect(in_ranges, ranges_scratch, true);
  CHECK(in_ranges.hit_bits == whole.hit_bits);
  REQUIRE(ranges_scratch.contacts.size() == whole_scratch.contacts.size());
  REQUIRE(ranges_scratch.contacts.size() >= 2);
  for (std::size_t k = 0; k < whole_scratch.contacts.size(); ++k) {
    CHECK(ranges_scratch.contacts[k].packet == whole_scratch.contacts[k].packet);
    CHECK(ranges_scratch.contacts[k].is_in_range == whole_scratch.contacts[k].is_in_range);
    CHECK(ranges_scratch.contacts[k].stretch.x == whole_scratch.contacts[k].stretch.x);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(in_ranges.is_anchored[i] == whole.is_anchored[i]);
    CHECK(in_ranges.bristles[i].anchor_a.x == whole.bristles[i].anchor_a.x);
    CHECK(in_ranges.bristles[i].anchor_b.x == whole.bristles[i].anchor_b.x);
  }
}

TEST_CASE("collect_contacts: a normal that is no number is no contact") {
  test::RandomPatch<double> random(15, {});
  random.next();
  SensorPatch<double>& patch = random.patch;
  random.scratch.reset_near_hits();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  random.scratch.hits.offer(2, {0.001, Vec3<double>(nan, 0, 0)}, 10);
  random.scratch.hits.offer(3, {0.001, -Vec3<double>(patch.geometry->direction[3])}, 10);
  collect_contacts(patch, random.scratch, random.a,
                   [&](std::uint32_t) {
                     return TouchedBody<double>{&random.b[0], test::RandomPatch<double>::id(0)};
                   },
                   {.dt = 1e-3});
  REQUIRE(random.scratch.contacts.size() == 1);
  CHECK(random.scratch.contacts[0].is_in_range == 1u << 3);
  CHECK(patch.is_anchored[0] == 1u << 3);
  CHECK(random.scratch.pairs[0].center.allFinite());
}

TEST_CASE("collect_contacts: a body in the slot of a removed one is another body") {
  test::RandomPatch<double> random(16, {});
  SensorPatch<double>& patch = random.patch;
  random.scratch.begin(patch);
  random.scratch.list_all();
  const auto meet = [&](BodyId id, double distance) {
    random.scratch.reset_near_hits();
    random.scratch.hits.offer(
        5, {distance * patch.geometry->length[5], -Vec3<double>(patch.geometry->direction[5])}, 10);
    collect_contacts(patch, random.scratch, random.a,
                     [&](std::uint32_t) {
                       return TouchedBody<double>{&random.b[0], id};
                     },
                     {.dt = 1e-3});
  };
  const BodyId first = test::RandomPatch<double>::id(0);
  meet(first, 0.5);
  // Half of what a bristle can stretch, aside.
  random.b[0].center_pose.translation +=
      random.a.center_pose.rotate(0.5e-3 * Vec3<double>(patch.geometry->packets[0].tangent[5]));
  meet(first, 0.5);
  CHECK(random.scratch.contacts[0].stretch[5].norm() == test::relative(0.5e-3));
  meet({first.index, first.generation + 1}, 0.5);
  CHECK(random.scratch.contacts[0].stretch[5].norm() == 0.0);
}

TEST_CASE("collect_contacts: a ray that starts inside a body is pressed in all the way") {
  test::RandomPatch<double> random(17, {});
  SensorPatch<double>& patch = random.patch;
  random.scratch.begin(patch);
  random.scratch.list_all();
  random.scratch.reset_near_hits();
  random.scratch.hits.offer(5, {0, -Vec3<double>(patch.geometry->direction[5])}, 10);
  collect_contacts(patch, random.scratch, random.a,
                   [&](std::uint32_t) {
                     return TouchedBody<double>{&random.b[0], test::RandomPatch<double>::id(0)};
                   },
                   {.dt = 1e-3});
  REQUIRE(random.scratch.contacts.size() == 1);
  CHECK(random.scratch.contacts[0].is_in_contact == 1u << 5);
  CHECK(touch_of(*patch.geometry, random.scratch.hits, 5).depth == 1.0);
}
