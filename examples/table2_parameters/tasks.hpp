// The paper's Table II: the constants of its three tasks, what they mean in a grip, and what
// `tuned_for` proposes for the same wants. All are tried in the gripper of Fig. 6 (b).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "fig6_grip/grip.hpp"

#include <array>

namespace table2 {

struct Task {
  const char* name;
  double mass;   // [kg] of the part
  double force;  // [N] of each finger here; the paper does not give it
  // As printed: mu_S [1/m], mu_V [N s/m], K_N [N], K_D per step of the paper's loop of 1 kHz,
  // sigma_a [m].
  double static_friction;
  double sliding_friction;
  double normal_stiffness;
  double normal_damping;
  double breakaway_distance;
};

inline constexpr std::array<Task, 4> tasks{{
    {"object of 0.4 kg", 0.4, 10, 1000, 0.5, 1.0, 5, 0.001},
    {"object of 0.8 kg", 0.8, 10, 1000, 0.5, 1.0, 5, 0.001},
    {"screwdriver", 0.6, 10, 5000, 0.8, 0.8, 0.1, 0.001},
    {"thread", 0.002, 0.5, 1000, 0.3, 0.05, 5, 0.005},
}};

/// Readings of a task's constants.
enum class Reading {
  /// K_D taken for N s, as Eq. 3 has it.
  literal,
  /// K_D divided by the 1000 steps a second of the paper's loop.
  converted,
  /// `tuned_for` the same friction mu_S sigma_a, creep sigma_a, force and mass.
  tuned
};
inline constexpr std::array<Reading, 3> readings{Reading::literal, Reading::converted,
                                                 Reading::tuned};

inline const char* name_of(Reading reading) {
  return reading == Reading::literal     ? "K_D in N s"
         : reading == Reading::converted ? "K_D per step"
                                         : "tuned_for";
}

inline bristle::SensorParameters<double> parameters(const Task& task, Reading reading) {
  if (reading == Reading::tuned) {
    return bristle::tuned_for<double>({.friction = task.static_friction * task.breakaway_distance,
                                       .creep = task.breakaway_distance,
                                       .load = task.force,
                                       .mass = task.mass})
        .parameters(fig6::round_pad(1));
  }
  return {.normal_stiffness = task.normal_stiffness,
          .normal_damping =
              reading == Reading::literal ? task.normal_damping : 1e-3 * task.normal_damping,
          .static_friction = task.static_friction,
          .sliding_friction = task.sliding_friction,
          .breakaway_distance = task.breakaway_distance};
}

/// Description of the constants for both pads, which together carry twice the force.
inline bristle::PatchDescription<double> description(const Task& task, Reading reading) {
  return bristle::describe(parameters(task, reading), {.count = 2 * fig6::round_pad(1).size(),
                                                       .length = fig6::range,
                                                       .load = 2 * task.force,
                                                       .mass = task.mass});
}

inline fig6::GripDef grip_of(const Task& task, Reading reading, double time_step,
                             bristle::Integration integration) {
  return {.mass = task.mass,
          .force = task.force,
          .time_step = time_step,
          .integration = integration,
          .parameters = parameters(task, reading)};
}

}  // namespace table2
