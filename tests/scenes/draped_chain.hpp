/// @file
/// A chain over a cylinder, in a world.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scenes/chain_links.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace bristle::scenes {

inline constexpr double link_pitch = 0.05;
inline constexpr double link_radius = 0.01;
inline constexpr double drum_radius = 0.5;
inline constexpr double drum_friction = 0.2;

/// 100 capsules of 0.1 kg on ball joints over a cylinder, 1 mm above it.
struct DrapedChain {
  World<double> world;
  std::vector<BodyId> links;

  /// @param shift  [m] Length that hangs further down on one side.
  DrapedChain(double shift, double time_step) : world({.time_step = time_step}) {
    const auto ends = chain_links(100, link_pitch, drum_radius + link_radius + 1e-3, shift);
    const Material<double> material{.friction = drum_friction};
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
      const Vec3<double> along = ends[i + 1] - ends[i];
      links.push_back(world.add_body(
          {.mass = 0.1,
           .shape = Capsule<double>{link_radius, link_pitch / 2 - link_radius},
           .material = material,
           .position = (ends[i] + ends[i + 1]) / 2,
           .orientation = Quat<double>::FromTwoVectors(Vec3<double>::UnitZ(), along)}));
      if (i == 0) continue;
      const Transform<double> joint{Quat<double>::Identity(), ends[i]};
      world.add_joint({.kind = JointKind::ball,
                       .body_a = links[i - 1],
                       .body_b = links[i],
                       .X_AJ = world.pose(links[i - 1]).inverse() * joint,
                       .X_BJ = world.pose(links[i]).inverse() * joint});
    }
    world.add_body({.motion = Motion::fixed,
                    .shape = Cylinder<double>{drum_radius, 0.5},
                    .material = material,
                    .orientation = exp_rotation<double>({std::numbers::pi / 2, 0, 0})});
  }

  /// [m] Takes steps, and returns the widest gap of a joint.
  double run(double duration) {
    double gap = 0;
    const long steps = std::lround(duration / world.def().time_step);
    for (long i = 0; i < steps; ++i) {
      world.step();
      gap = std::max(gap, world.report().joint_gap);
    }
    return gap;
  }
  /// [m/s] Speed of the fastest link.
  [[nodiscard]] double speed() const {
    double most = 0;
    for (const BodyId id : links) most = std::max(most, world.body(id).twist.linear.norm());
    return most;
  }
};

}  // namespace bristle::scenes
