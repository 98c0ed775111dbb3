// Settings of one run of the example and its outcome.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/io/trace.hpp>
#include <bristle/sensors/sensor_parameters.hpp>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace gripper {

/// Settings from the command line.
struct Settings {
  std::string backend = "fcl";
  std::string scalar = "double";
  bristle::Integration integration = bristle::Integration::automatic;
  /// paper (release), drag or ambf.
  std::string law = "paper";
  /// [s]
  double time_step = 1e-3;
  std::filesystem::path pad;
  std::filesystem::path output = "gripper_on_incline";
  /// None: no replay is recorded.
  std::filesystem::path replay;
};

/// One stretch of the run, for the plot.
struct Phase {
  std::string name;
  double start = 0;  // [s]
  double end = 0;
};

/// Measurements. Lengths in m, forces in N, times in s.
struct Outcome {
  bristle::Trace trace{
      {"time", "s"},         {"part height", "mm"}, {"gripper height", "mm"}, {"sag", "um"},
      {"normal force", "N"}, {"shear force", "N"},  {"slipping sensors", ""}, {"motor force", "N"}};
  std::vector<Phase> phases;
  std::string replay;  // binary glTF, if asked for

  std::size_t sensors = 0;
  double weight = 0;         // m g
  double sag = 0;            // of the part in the hand, after settling
  double predicted_sag = 0;  // m g / (mu_S sum F_N)
  double creep = 0;          // movement in the hand during the hold
  double hold_time = 0;
  double hold_force_error = 0;    // |vertical force of the sensors - m g|
  double slip_load = 0;           // sum F_N when it let go
  double friction = 0;            // mu that was asked for
  double slid = 0;                // while loosened
  double caught_creep = 0;        // movement in the second half of the catch
  double final_speed = 0;         // of the part, set down and released
  double final_height_error = 0;  // of the part above the incline
  double simulated_time = 0;
  double cpu_time = 0;
  std::uint64_t rays_cast = 0;
  std::uint64_t rays_skipped = 0;
  std::uint64_t explicit_pairs = 0;
  std::uint64_t implicit_pairs = 0;
  std::uint64_t backend_failures = 0;
  bool was_held = false;  // still in the hand after the hold
  bool was_caught = false;
};

Outcome run_with_analytic(const Settings& settings);
Outcome run_with_fcl(const Settings& settings);

}  // namespace gripper
