/// @file
/// Errors fall with the step as the order of the scheme says; benchmarks/convergence_order.cpp
/// prints what is measured here.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/convergence.hpp"

#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <vector>

using namespace bristle;
using namespace bristle::scenes;

namespace {

std::vector<double> errors_of(const KnownMotion& motion, Integrator integrator) {
  std::vector<double> errors;
  for (const double dt : step_ladder) errors.push_back(motion.error(dt, integrator));
  return errors;
}

}  // namespace

TEST_CASE("convergence: the fit finds the slope of a power, and needs three errors") {
  const std::vector<double> steps{1e-3, 2e-3, 4e-3, 8e-3};
  const std::vector<double> errors{1e-20, 4e-6, 16e-6, 64e-6};
  CHECK(fitted_order(steps, errors, 1e-12) == test::relative(2));
  CHECK(std::isnan(fitted_order(steps, errors, 1e-5)));
}

TEST_CASE("convergence: the trapezoidal rule is exact under constant forces, else of its order") {
  for (const KnownMotion& motion : known_motions()) {
    CAPTURE(motion.name);
    const std::vector<double> errors = errors_of(motion, Integrator::trapezoidal);
    if (motion.order == 0) {
      for (const double error : errors) CHECK(error < motion.round_off);
    } else {
      CHECK(fitted_order(step_ladder, errors, motion.round_off) >= motion.order - 0.1);
      // Small as well: an order says nothing about the factor. 5 mm at 20 ms would be first order.
      CHECK(errors.front() < 1e-3);
    }
  }
}

TEST_CASE("convergence: symplectic Euler is of first order") {
  for (const KnownMotion& motion : known_motions()) {
    CAPTURE(motion.name);
    const std::vector<double> errors = errors_of(motion, Integrator::symplectic_euler);
    const double order = fitted_order(step_ladder, errors, motion.round_off);
    CHECK(order == test::relative(motion.euler_order).epsilon(0.15));
  }
}
