// The run with the library's own geometry.
// SPDX-License-Identifier: BSD-3-Clause
#include "run.hpp"

gripper::Outcome gripper::run_with_analytic(const Settings& settings) {
  return run_with<bristle::AnalyticBackend>(settings);
}
