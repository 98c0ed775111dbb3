/// @file
/// The scene of the cluster: two fingers hold a part and are shaken.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cluster/draw.hpp"

#include <bristle/bristle.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace cluster {

using bristle::World;

/// One world of the batch, and what differs in the others.
struct Grip {
  World<float> world;
  bristle::BodyId part;
  std::array<bristle::BodyId, 2> fingers;
  std::array<bristle::PatchId, 2> pads;
  bristle::SensorLayout<float> sensors;

  /// [-] A step takes 1 ms.
  static constexpr std::size_t steps_per_round = 50;

  /// @param sensors_per_row  [-] A pad has as many rows.
  explicit Grip(std::size_t sensors_per_row) : world({.time_step = 1e-3f}) {
    part = world.add_body(
        {.mass = 1.0f, .shape = bristle::Box<float>{.half_extents = {0.03f, 0.03f, 0.03f}}});
    for (std::size_t side = 0; side < 2; ++side) {
      const float inwards = side == 0 ? 1.0f : -1.0f;
      fingers[side] = world.add_body(
          {.motion = bristle::Motion::kinematic, .position = {-0.0415f * inwards, 0.0f, 0.0f}});
      // Rays reach 15 mm in from the finger, 3.5 of them into the part: each pad presses with 10 N.
      sensors = bristle::sensor_grid<float>({.center = {0.010f * inwards, 0.0f, 0.0f},
                                             .side_u = {0.0f, 0.036f * inwards, 0.0f},
                                             .side_v = {0.0f, 0.0f, 0.036f},
                                             .count_u = sensors_per_row,
                                             .count_v = sensors_per_row});
      pads[side] = world.add_patch(fingers[side], {.sensors = sensors,
                                                   .parameters = parameters(0.5f),
                                                   .options = {.reset = bristle::SlipReset::drag}});
    }
  }

  [[nodiscard]] static float mass(std::uint64_t number) {
    return 0.2f + 1.6f * drawn(number, Drawn::mass);
  }
  [[nodiscard]] static float friction(std::uint64_t number) {
    return 0.3f + 0.5f * drawn(number, Drawn::friction);
  }
  /// [1] Weight over the friction that both pads can carry.
  [[nodiscard]] static float load(std::uint64_t number) {
    return mass(number) * 9.81f / (friction(number) * 2 * pressing_force);
  }

  /// Gives a copy of `world` what is drawn for its number.
  void vary(World<float>& copy, std::uint64_t number) const {
    copy.set_mass(part, mass(number));
    for (const bristle::PatchId pad : pads) copy.set_parameters(pad, parameters(friction(number)));
  }

  /// Moves both fingers sideways, at a speed drawn for the world and the round.
  void shake(World<float>& copy, std::uint64_t number, std::uint64_t round) const {
    const float speed = 0.04f * (drawn(number, Drawn::first_motion, round) - 0.5f);
    for (const bristle::BodyId finger : fingers) {
      copy.set_velocity(finger, {{0.0f, speed, 0.0f}, {0.0f, 0.0f, 0.0f}});
    }
  }

 private:
  /// [N] Of one pad.
  static constexpr float pressing_force = 10.0f;

  [[nodiscard]] bristle::SensorParameters<float> parameters(float friction) const {
    return bristle::tuned_for<float>(
               {.friction = friction, .creep = 1e-3f, .load = pressing_force, .press = 0.35f})
        .parameters(sensors);
  }
};

}  // namespace cluster
