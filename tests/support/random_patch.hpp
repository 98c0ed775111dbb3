/// @file
/// A patch with random sensors over random hits on two bodies, for kernels over whole patches.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/random.hpp"

#include <bristle/sensors/patch_contacts.hpp>

#include <array>
#include <concepts>
#include <cstddef>
#include <utility>

namespace bristle::test {

using namespace bristle::detail;

/// Sensors anywhere and hits that need not belong to any shape: the law does not ask.
template <Scalar S>
class RandomPatch {
 public:
  static constexpr S dt = S(1e-3);
  /// [-] Sensors: two packets and a bit, or three ranges. So many cross a threshold now and then on
  /// which lanes and scalars round differently in float.
  static constexpr std::size_t few = 37;
  static constexpr std::size_t many = std::same_as<S, float> ? few : 1300;

  RandomPatch(std::uint64_t seed, LawOptions options, std::size_t sensors = few) : random_(seed) {
    PatchDef<S> def;
    for (std::size_t i = 0; i < sensors; ++i) {
      def.sensors.add(random_.in_cube(S(0.05)), random_.direction<S>(),
                      random_.uniform(S(0.005), S(0.02)));
    }
    def.parameters = {S(2), S(0.05), S(3000), S(0.4), S(1e-3)};
    def.options = options;
    patch = make_patch<S>(std::move(def), BodyId{0, 1}, Vec3<S>(Vec3<S>::Zero()));
    for (Body<S>* body : {&a, &b[0], &b[1]}) {
      body->center_pose = {random_.rotation<S>(), random_.in_cube(S(0.1))};
    }
  }

  static BodyId id(std::size_t body) { return {static_cast<std::uint32_t>(3 + body), 7}; }

  /// Moves the bodies a little and lets most sensors hit one of the two, some beyond their reach,
  /// some at a grazing angle; then makes contacts. Shapes 10 and 11 are of the first body, 12 of
  /// the second.
  void next() {
    for (Body<S>* body : {&a, &b[0], &b[1]}) {
      body->center_pose.translation += random_.in_cube(S(6e-4));
      body->twist = {random_.in_cube(S(0.3)), random_.in_cube(S(1))};
    }
    scratch.begin(patch);
    scratch.list_all();
    scratch.reset_near_hits();
    for (std::size_t i = 0; i < patch.size(); ++i) {
      const std::size_t kind = random_.index(10);
      if (kind == 0) continue;
      const Vec3<S> n = patch.geometry->direction[i];
      Vec3<S> m = random_.direction<S>();
      if (m.dot(n) > S(0)) m = -m;
      scratch.hits.offer(i, {random_.uniform(S(0), S(1.2)) * patch.geometry->length[i], m},
                         kind < 6   ? 10u
                         : kind < 8 ? 11u
                                    : 12u);
    }
    collect_contacts(patch, scratch, a,
                     [this](std::uint32_t tag) {
                       const std::size_t body = tag == 12u ? 1 : 0;
                       return TouchedBody<S>{&b[body], id(body)};
                     },
                     {.dt = dt});
  }

  /// A motion of which bristles notice something.
  Vec6<S> motion(S size) {
    Vec6<S> u;
    u << random_.in_cube(size), random_.in_cube(size);
    return u;
  }
  Random& random() { return random_; }

  SensorPatch<S> patch;
  PatchScratch<S> scratch;
  Body<S> a;
  std::array<Body<S>, 2> b;

 private:
  Random random_;
};

}  // namespace bristle::test
