// The run with FCL and libccd.
// SPDX-License-Identifier: BSD-3-Clause
#include "run.hpp"

#include <stdexcept>

gripper::Outcome gripper::run_with_fcl(const Settings& settings) {
#if defined(BRISTLE_WITH_FCL)
  return run_with<bristle::FclBackend>(settings);
#else
  (void)settings;
  throw std::runtime_error("built without FCL; use --backend analytic, or install libfcl-dev");
#endif
}
