/// @file
/// Random drops of boxes with sensors on all sides, whose rays meet floors and each other
/// obliquely.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/momentum.hpp"
#include "support/random.hpp"

#include <bristle/math/rotation.hpp>
#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using namespace bristle;

namespace {

/// [m] Half the edge of a box.
constexpr double half_box = 0.05;

/// 4 x 4 rays of 20 mm a side, 14 mm of each in front of it.
SensorLayout<double> skin_of_box() {
  SensorLayout<double> skin;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      for (int k = 0; k < 16; ++k) {
        Vec3<double> start = Vec3<double>::Zero(), along = Vec3<double>::Zero();
        start[axis] = side * (half_box - 0.006);
        along[axis] = side;
        start[(axis + 1) % 3] = half_box * 0.9 * ((k % 4 + 0.5) / 2 - 1);
        start[(axis + 2) % 3] = half_box * 0.9 * ((k / 4 + 0.5) / 2 - 1);
        skin.add(start, along, 0.02);
      }
    }
  }
  return skin;
}

/// Boxes above a floor, one over the other, that turn and drift, with hard contact behind sensors
/// of 1 to `stiffest` times what carries the weight.
struct Tumble {
  World<double> world;
  std::vector<BodyId> boxes;
  double weight = 0;  // [N]

  Tumble(test::Random& random, int count, double stiffest, double dt)
      : world(WorldDef<double>{.time_step = dt}) {
    world.add_body(
        {.motion = Motion::fixed, .shape = HalfSpace<double>{}, .material = {.friction = 0.3}});
    const double factor = std::pow(stiffest, random.uniform(0.0, 1.0));
    const double sigma = random.index(2) == 0 ? 1e-3 : 1e-4;
    const double friction = random.uniform(0.3, 1.2) / sigma;
    const double damping = random.index(2) == 0 ? 0 : std::pow(10, random.uniform(-3.5, -1.5));
    const double viscous = random.index(2) == 0 ? 0 : std::pow(10, random.uniform(-2.0, 2.0));
    const SlipReset reset = random.index(2) == 0 ? SlipReset::drag : SlipReset::release;
    for (int i = 0; i < count; ++i) {
      const double mass = 0.5 * std::pow(10, random.uniform(-0.5, 0.5));
      weight += 9.81 * mass;
      const BodyId box = world.add_body(
          {.mass = mass,
           .shape = Box<double>{{half_box, half_box, half_box}},
           .position = {random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02), 0.13 + 0.24 * i},
           .orientation = random.rotation<double>(),
           .velocity = 0.5 * random.in_cube(1.0),
           .angular_velocity = 3 * random.in_cube(1.0)});
      PatchDef<double> patch;
      patch.sensors = skin_of_box();
      const double stiffness = factor * 3 * mass * 9.81 / (16 * 0.3);
      patch.parameters = {stiffness, stiffness * damping, friction, viscous, sigma};
      patch.integration = Integration::implicit;
      patch.options.reset = reset;
      world.add_patch(box, patch);
      boxes.push_back(box);
    }
  }
  [[nodiscard]] double energy() const {
    return test::energy_of(world, std::span<const BodyId>(boxes));
  }
};

}  // namespace

// An energy gain counts if it exceeds the work of the weight over a tenth of a micrometre.
TEST_CASE("tumble: boxes with skins of up to 30 times their weight never gain energy") {
  test::Random random(5);
  int gained = 0, touched = 0;
  for (const double stiffest : {1.0, 30.0}) {
    for (int trial = 0; trial < 100; ++trial) {
      for (const int count : {1, 2}) {
        const double steps[] = {1e-4, 1e-3, 1.0 / 240, 1.0 / 60, 1.0 / 30};
        const double dt = steps[trial % 5];
        Tumble scene(random, count, stiffest, dt);
        const double start = scene.energy();
        double highest = start;
        for (int k = std::min(4000, static_cast<int>(0.8 / dt)); k > 0; --k) {
          scene.world.step();
          highest = std::max(highest, scene.energy());
          touched += scene.world.report().sensors_touching > 0 ? 1 : 0;
        }
        gained += highest > start + 1e-7 * scene.weight ? 1 : 0;
      }
    }
  }
  CHECK(touched > 10000);
  CHECK(gained == 0);
}
