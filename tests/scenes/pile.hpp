/// @file
/// Many bodies that fall on each other, some of them on sensors: enough for several threads.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/world/world.hpp>

#include <vector>

namespace bristle::scenes {

/// The built scene.
template <Scalar S, typename Backend = AnalyticBackend>
struct Pile {
  World<S, Backend> world;
  std::vector<BodyId> bodies{};
  std::vector<PatchId> patches{};
};

/// Builds the scene: `layers` of 4 x 4 spheres and boxes, staggered so that they tumble;
/// beside them `plates` with 100 sensors each on the floor, every second one with another on top.
template <Scalar S, typename Backend = AnalyticBackend>
[[nodiscard]] Pile<S, Backend> make_pile(const WorldDef<S>& def = {}, int layers = 3,
                                         int plates = 5) {
  Pile<S, Backend> pile{World<S, Backend>(def)};
  BodyDef<S> floor;
  floor.motion = Motion::fixed;
  floor.shape = HalfSpace<S>{};
  pile.world.add_body(floor);
  const Shape<S> shapes[] = {Sphere<S>{S(0.05)}, Box<S>{{S(0.05), S(0.04), S(0.05)}},
                             Box<S>{{S(0.03), S(0.05), S(0.04)}}};
  int number = 0;
  for (int k = 0; k < layers; ++k) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        BodyDef<S> body;
        body.mass = S(0.2) + S(0.01) * S(number % 7);
        body.shape = shapes[number++ % 3];
        body.position = {S(0.095) * S(i) + S(0.02) * S(k % 2), S(0.095) * S(j) + S(0.013) * S(k),
                         S(0.07) + S(0.11) * S(k)};
        pile.bodies.push_back(pile.world.add_body(body));
      }
    }
  }
  for (int k = 0; k < plates; ++k) {
    for (int level = 0; level <= k % 2; ++level) {
      BodyDef<S> plate;
      plate.mass = S(0.5);
      plate.shape = Box<S>{{S(0.1), S(0.1), S(0.02)}};
      plate.position = {S(0.3) * S(k) - S(1), S(-0.5), S(0.025) + S(0.05) * S(level)};
      plate.velocity = {S(0.1) * S(level), S(0), S(0)};
      const BodyId id = pile.world.add_body(plate);
      pile.bodies.push_back(id);
      PatchDef<S> patch;
      for (int i = 0; i < 10; ++i) {
        for (int j = 0; j < 10; ++j) {
          patch.sensors.add(
              Vec3<S>(S(0.018) * S(i) - S(0.081), S(0.018) * S(j) - S(0.081), S(-0.015)),
              Vec3<S>(S(0), S(0), S(-1)), S(0.01));
        }
      }
      patch.parameters = {S(0.4), S(0.02), S(3000), S(0.2), S(1e-3)};
      pile.patches.push_back(pile.world.add_patch(id, patch));
    }
  }
  return pile;
}

}  // namespace bristle::scenes
