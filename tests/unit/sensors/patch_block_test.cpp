// SPDX-License-Identifier: BSD-3-Clause
#include "support/random_patch.hpp"
#include "support/relative.hpp"
#include "support/scalar_patch.hpp"

#include <bristle/sensors/patch_block.hpp>

#include <doctest/doctest.h>

#include <vector>

using namespace bristle;

using namespace bristle::detail;

namespace {

constexpr double dt = 1e-3;

/// A pair of a random patch with contacts, and a scheme between the extremes.
template <Scalar S>
PatchPair<S>& first_pair(test::RandomPatch<S>& random) {
  for (;;) {
    random.next();
    PatchPair<S>& pair = random.scratch.pairs[0];
    if (pair.count == 0) continue;
    set_scheme(pair, S(9 * 3000), S(9 * 0.4), S(0.5), S(dt));
    return pair;
  }
}

LawOptions options_of(NormalDirection normal, SlipReset reset = SlipReset::release) {
  LawOptions options;
  options.normal = normal;
  options.reset = reset;
  return options;
}

/// The impulse of the contact in lane i of a packet.
template <Scalar S>
Vec3<S> impulse_of(const ContactPacket<S>& packet, std::size_t i) {
  return packet.impulse[i];
}

/// Calls visit(packet, lane, k) for the contacts of a pair in the order of `scalar_contacts`.
template <Scalar S, typename Visit>
void for_each_lane(PatchScratch<S>& scratch, const PatchPair<S>& pair, Visit&& visit) {
  std::size_t k = 0;
  for (ContactPacket<S>& packet : contacts_of(scratch, pair)) {
    for (std::size_t i = 0; i < packet_size; ++i) {
      if ((packet.is_in_range >> i & 1u) != 0) visit(packet, i, k++);
    }
  }
}

/// A pair in scalars, one contact after the other.
template <Scalar S>
class ScalarBlock {
 public:
  ScalarBlock(const SensorPatch<S>& patch, const PatchScratch<S>& scratch, const PatchPair<S>& pair)
      : patch_(patch), pair_(pair), contacts(test::scalar_contacts(patch, scratch, pair)) {
    for (PatchContact<S>& c : contacts) {
      test::linearise_start(patch, pair, c, S(dt));
      made_for_.push_back(c.force);
    }
  }

  /// [N s, N m s] On B about c, in A's axes, for u in A's axes.
  Wrench<S> evaluate(const Vec6<S>& u) {
    Wrench<S> sum;
    for (PatchContact<S>& c : contacts) {
      const Vec3<S> v = velocity(c, u);
      c.impulse = model_impulse<S>(c, v);
      c.normal_impulse = c.is_loaded ? c.impulse.dot(c.n) : S(0);
      if (c.normal_impulse < S(0)) {
        c.impulse = tangential<S>(c.impulse, c.n);
        c.normal_impulse = S(0);
      }
      sum += Wrench<S>::at(c.rho, c.impulse);
    }
    return sum;
  }

  bool update(const Vec6<S>& u, int pass, bool is_last_pass) {
    const SensorParameters<S>& p = patch_.def.parameters;
    const LawOptions& options = patch_.def.options;
    PassChange<S> change;
    for (PatchContact<S>& c : contacts) {
      const Vec3<S> v = velocity(c, u);
      linearise_normal<S>(p, c, S(dt));
      update_normal<S>(c, true, v, S(dt), change);
      update_slip<S>(c, tangential<S>(v, c.n), p.breakaway_distance, options.reset, S(dt), pass,
                     is_last_pass, change);
      if (!c.is_loaded) c.a_normal = 0;
    }
    const bool has_changed = change.did_switch || change.force_change > S(1e-3) * change.force_sum;
    if (!has_changed && !change.has_slip) {
      // Forces are compared with those that the models were made for.
      for (std::size_t k = 0; k < contacts.size(); ++k) contacts[k].force = made_for_[k];
      return false;
    }
    S friction_sum = 0, friction_change = 0;
    for (PatchContact<S>& c : contacts) {
      const Vec3<S> v = velocity(c, u);
      const Vec3<S> before = tangential<S>(c.impulse, c.n);
      c.normal_impulse = is_last_pass && has_changed ? S(0) : S(dt) * c.force;
      linearise<S>(p, options, pair_, c, tangential<S>(v, c.n), S(dt));
      if (!c.is_loaded) c.a_normal = 0;
      friction_change += (tangential<S>(model_impulse<S>(c, v), c.n) - before).norm();
      friction_sum += before.norm();
    }
    for (std::size_t k = 0; k < contacts.size(); ++k) made_for_[k] = contacts[k].force;
    return has_changed || friction_change > S(1e-3) * friction_sum;
  }

 private:
  static Vec3<S> velocity(const PatchContact<S>& c, const Vec6<S>& u) {
    return velocity_at<S>(u.template head<3>(), u.template tail<3>(), c.rho);
  }

  const SensorPatch<S>& patch_;
  const PatchPair<S>& pair_;
  std::vector<S> made_for_;

 public:
  std::vector<PatchContact<S>> contacts;
};

}  // namespace

TEST_CASE_TEMPLATE("set_scheme: nearly conservative when soft, implicit Euler when stiff", S, float,
                   double) {
  PatchPair<S> pair;
  set_scheme(pair, S(0), S(0), S(1), S(1e-3));
  CHECK(pair.alpha == S(0));
  CHECK(pair.beta == S(1) / S(12));
  CHECK(pair.theta == S(0.5));
  set_scheme(pair, S(1e12), S(0), S(1), S(1));
  CHECK(static_cast<double>(pair.alpha) == test::relative(1));
  CHECK(static_cast<double>(pair.beta) == doctest::Approx(0));
  CHECK(static_cast<double>(pair.theta) == test::relative(1));
  // x = w (dt^2 k + dt c) = 0.5 (0.01 * 100 + 0.1 * 10) = 1.
  set_scheme(pair, S(100), S(10), S(0.5), S(0.1));
  CHECK(static_cast<double>(pair.alpha) == test::relative(0.5).epsilon(1e-6));
  CHECK(static_cast<double>(pair.beta) == test::relative(0.25 / 12).epsilon(1e-6));
}

TEST_CASE("fill_block: is the sum of its sensors, and never gives energy") {
  for (const NormalDirection normal : {NormalDirection::ray, NormalDirection::gradient}) {
    test::RandomPatch<double> random(5, options_of(normal));
    for (int round = 0; round < 20; ++round) {
      PatchPair<double>& pair = first_pair(random);
      start_linearisation(random.patch, random.scratch, pair, dt);
      SoftBlock<double> block;
      fill_block(pair, block);
      // Symmetric positive semidefinite.
      CHECK((block.matrix - block.matrix.transpose()).norm() < 1e-12 * block.matrix.norm());
      for (int i = 0; i < 10; ++i) {
        const Vec6<double> u = random.motion(1);
        CHECK(u.dot(block.matrix * u) >= -1e-12 * block.matrix.norm());
      }
      // The impulses of all sensors at a motion add up to offset + matrix u, while no sensor would
      // have to pull. At the start motion all loaded sensors push.
      Vec6<double> u;
      const Twist<double> start = pair.start_motion.shifted(pair.center);
      u << pair.R_WA * start.linear, pair.R_WA * start.angular;
      const Wrench<double> sum = evaluate(random.patch, random.scratch, pair, u, dt, {}).impulse;
      Vec6<double> expected = block.offset + block.matrix * u;
      CHECK((sum.force - expected.head<3>()).norm() < 1e-12 * expected.head<3>().norm());
      CHECK((sum.torque - expected.tail<3>()).norm() < 1e-12 * expected.head<3>().norm());
    }
  }
}

TEST_CASE("start_linearisation: at rest gives what the explicit law gives") {
  for (const NormalDirection normal : {NormalDirection::ray, NormalDirection::gradient}) {
    test::RandomPatch<double> random(6, options_of(normal));
    PatchPair<double>& pair = first_pair(random);
    pair.start_motion = {};
    start_linearisation(random.patch, random.scratch, pair, dt);
    (void)evaluate<double>(random.patch, random.scratch, pair, Vec6<double>::Zero(), dt, {});
    const auto contacts = test::scalar_contacts(random.patch, random.scratch, pair);
    for_each_lane(
        random.scratch, pair, [&](ContactPacket<double>& packet, std::size_t i, std::size_t k) {
          const PatchContact<double>& c = contacts[k];
          if (!c.is_in_contact) {
            CHECK(packet.normal_impulse[i] == 0);
            return;
          }
          const SensorContact<double> contact{c.depth, c.inverse_length, c.n, c.g,
                                              Vec3<double>::Zero()};
          const SensorForce<double> f = sensor_force<double>(
              random.patch.def.parameters, random.patch.def.options, contact, c.stretch, dt);
          CHECK((packet.impulse[i] - dt * f.total()).norm() < 1e-15);
          CHECK(packet.normal_impulse[i] == test::relative(dt * f.normal).epsilon(1e-12));
        });
  }
}

TEST_CASE_TEMPLATE("implicit patch: lanes give what sensors one by one give, pass by pass", S,
                   float, double) {
  const S sums = std::same_as<S, float> ? S(1e-5) : S(1e-12);
  int slips = 0, damped = 0, settled = 0;
  for (const SlipReset reset : {SlipReset::release, SlipReset::drag}) {
    for (const NormalDirection normal : {NormalDirection::ray, NormalDirection::gradient}) {
      const bool is_large = normal == NormalDirection::gradient;
      using Patch = test::RandomPatch<S>;
      Patch random(7, options_of(normal, reset), is_large ? Patch::many : Patch::few);
      for (int round = 0; round < 40; ++round) {
        PatchPair<S>& pair = first_pair(random);
        SensorPatch<S>& patch = random.patch;
        ScalarBlock<S> scalar(patch, random.scratch, pair);
        start_linearisation(patch, random.scratch, pair, S(dt));
        // From resting to slipping by whole stretches, and back and forth.
        const S speed = round % 4 == 0 ? S(1e-3) : round % 4 == 1 ? S(0.3) : S(3);
        Vec6<S> u = random.motion(speed);
        for (int pass = 1; pass <= 5; ++pass) {
          if (round % 2 == 1) u = -u;
          // Drifts by less than counts in one pass, and by more in two.
          if (round % 8 == 0) u *= S(1 + 7e-4);
          Vec6<S> u_A;
          u_A << pair.R_WA.transpose() * u.template head<3>(),
              pair.R_WA.transpose() * u.template tail<3>();
          const Wrench<S> expected = scalar.evaluate(u_A);
          S size = S(0);
          for (const PatchContact<S>& c : scalar.contacts) size += c.impulse.norm();
          const SolvePass solve{pass, 5 - pass};
          const PairResponse<S> answer = evaluate(patch, random.scratch, pair, u, S(dt), solve);
          const Wrench<S>& sum = answer.impulse;
          CHECK((sum.force - pair.R_WA * expected.force).norm() <= sums * size);
          CHECK((sum.torque - pair.R_WA * expected.torque).norm() <= S(0.1) * sums * size);
          for_each_lane(
              random.scratch, pair, [&](ContactPacket<S>& packet, std::size_t i, std::size_t k) {
                CHECK((packet.impulse[i] - scalar.contacts[k].impulse).norm() <= sums * size);
                CHECK(std::abs(packet.normal_impulse[i] - scalar.contacts[k].normal_impulse) <=
                      sums * size);
              });
          if (solve.left == 0) {
            CHECK_FALSE(answer.has_changed);
            continue;
          }
          CHECK(answer.has_changed == scalar.update(u_A, pass, solve.left == 1));
          settled += answer.has_changed ? 0 : 1;
          for_each_lane(random.scratch, pair,
                        [&](ContactPacket<S>& packet, std::size_t i, std::size_t k) {
                          const PatchContact<S>& c = scalar.contacts[k];
                          CHECK(((packet.is_loaded >> i & 1u) != 0) == c.is_loaded);
                          CHECK(((packet.is_slipping >> i & 1u) != 0) == c.is_slipping);
                          CHECK(((packet.is_damping_slip >> i & 1u) != 0) == c.is_damping_slip);
                          slips += c.is_slipping ? 1 : 0;
                          damped += c.is_damping_slip ? 1 : 0;
                        });
        }
      }
    }
  }
  CHECK(slips > 100);
  CHECK(damped > 100);
  CHECK(settled > 10);
}

TEST_CASE("evaluate: a settled patch needs no further solve") {
  test::RandomPatch<double> random(7, {});
  PatchPair<double>& pair = first_pair(random);
  start_linearisation(random.patch, random.scratch, pair, dt);
  // At the motion of the start nothing is found otherwise than assumed, but for what comes within
  // reach: leave only what touches.
  for (ContactPacket<double>& packet : random.scratch.contacts)
    packet.is_in_range = packet.is_in_contact;
  Vec6<double> u;
  const Twist<double> start = pair.start_motion.shifted(pair.center);
  u << pair.R_WA * start.linear, pair.R_WA * start.angular;
  // The normal force changes by the depth that the motion adds; a first answer takes that in.
  (void)evaluate<double>(random.patch, random.scratch, pair, u, dt, {1, 3});
  CHECK_FALSE(evaluate<double>(random.patch, random.scratch, pair, u, dt, {2, 2}).has_changed);
}

TEST_CASE("evaluate: notices parting and slip") {
  test::RandomPatch<double> random(8, {});
  PatchPair<double>& pair = first_pair(random);
  start_linearisation(random.patch, random.scratch, pair, dt);
  const auto before = test::scalar_contacts(random.patch, random.scratch, pair);
  Vec6<double> u = Vec6<double>::Zero();
  u.head<3>() = pair.R_WA * (-1e3 * before[0].g.normalized());
  CHECK(evaluate<double>(random.patch, random.scratch, pair, u, dt, {1, 3}).has_changed);
  CHECK(random.scratch.contacts[pair.first].normal_impulse[static_cast<std::size_t>(
            std::countr_zero(random.scratch.contacts[pair.first].is_in_range))] == 0);
  std::size_t slipping = 0;
  for_each_lane(random.scratch, pair,
                [&](ContactPacket<double>& packet, std::size_t i, std::size_t k) {
                  if (k == 0) {
                    CHECK((packet.is_loaded >> i & 1u) == 0);
                    CHECK(packet.force[i] == 0);
                  }
                  slipping += packet.is_slipping >> i & 1u;
                });
  // 1 m in a step is far beyond sigma_a.
  CHECK(slipping > 0);
}

TEST_CASE("clear_impulses: takes back what was given") {
  test::RandomPatch<double> random(9, {});
  PatchPair<double>& pair = first_pair(random);
  start_linearisation(random.patch, random.scratch, pair, dt);
  const Vec6<double> fast = random.motion(10);
  (void)evaluate<double>(random.patch, random.scratch, pair, fast, dt, {1, 1});
  CHECK(random.scratch.contacts[pair.first].is_slipping != 0);
  clear_impulses(random.scratch, pair);
  for_each_lane(random.scratch, pair,
                [&](ContactPacket<double>& packet, std::size_t i, std::size_t) {
                  CHECK(packet.impulse[i] == Vec3<double>::Zero());
                  CHECK(packet.normal_impulse[i] == 0);
                  CHECK(packet.is_slipping == 0);
                });
}
