/// @file
/// Wires that fall on each other: boxes a thousand to a hundred thousand times as long as thick.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/momentum.hpp"

#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace bristle::scenes {

/// Six steel wires of 1 m over a floor.
class FallingWires {
 public:
  /// @param slenderness  [1] Length by thickness.
  FallingWires(double slenderness, double time_step)
      : world_({.gravity = {0, 0, -9.81}, .time_step = time_step}) {
    world_.add_body({.motion = Motion::fixed, .shape = HalfSpace<double>{}});
    for (int i = 0; i < 6; ++i) {
      wires_.push_back(world_.add_body(
          {.density = 8000,
           .shape = Box<double>{{0.5, 0.5 / slenderness, 0.5 / slenderness}},
           .position = {0.01 * i, 0.02 * i, 0.5 + 0.1 * i},
           .orientation = Quat<double>(1, 0.1, 0.2 + 0.05 * i, 0.3 * i).normalized()}));
    }
  }

  /// @return [J] The most energy after a step.
  double run(double duration) {
    double most = 0;
    const long steps = std::lround(duration / world_.time_step());
    for (long i = 0; i < steps; ++i) {
      world_.step();
      most = std::max(most, energy());
    }
    return most;
  }

  /// [J] Kinetic, and potential above the floor.
  [[nodiscard]] double energy() const {
    return test::energy_of(world_, std::span<const BodyId>(wires_));
  }

 private:
  World<double> world_;
  std::vector<BodyId> wires_;
};

}  // namespace bristle::scenes
