// How errors fall with the step: for small scenes whose motion is known, the error at a ladder of
// steps and the order fitted to it, for both integrators.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/convergence.hpp"

#include <cstdio>
#include <vector>

using namespace bristle;
using namespace bristle::scenes;

int main() {
  for (const Integrator integrator : {Integrator::trapezoidal, Integrator::symplectic_euler}) {
    std::printf("%s\n%-12s", integrator == Integrator::trapezoidal ? "trapezoidal" : "symplectic",
                "dt [s]");
    for (const double dt : step_ladder) std::printf(" %9.2e", dt);
    std::printf("     order\n");
    for (const KnownMotion& motion : known_motions()) {
      std::vector<double> errors;
      std::printf("%-12s", motion.name.c_str());
      for (const double dt : step_ladder) {
        errors.push_back(motion.error(dt, integrator));
        std::printf(" %9.2e", errors.back());
      }
      std::printf(" %9.2f\n", fitted_order(step_ladder, errors, motion.round_off));
    }
  }
}
