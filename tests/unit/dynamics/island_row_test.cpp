/// @file
/// Projection on friction cones.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/random.hpp"

#include <bristle/dynamics/solver/island_row.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

using namespace bristle;

using namespace bristle::detail;

TEST_CASE("project_on_cone: finds the nearest point of a cone, with an end and without") {
  // q is the nearest point of a convex set to p if (p - q) . (r - q) <= 0 for all r of the set.
  test::Random random(11);
  for (const double friction : {0.0, 0.3, 1.0, 2.0}) {
    for (const double most : {0.5, 2.0, infinity<double>}) {
      CAPTURE(friction);
      CAPTURE(most);
      for (int i = 0; i < 300; ++i) {
        std::array<double, 3> p{};
        for (double& x : p) x = random.uniform(-3.0, 3.0);
        std::array<double, 3> q = p;
        project_on_cone(friction, most, q[0], q[1], q[2]);
        CHECK(q[0] >= 0);
        CHECK(q[0] <= most);
        CHECK(std::hypot(q[1], q[2]) <= friction * q[0] + 1e-15);
        for (int k = 0; k < 50; ++k) {
          const double n = random.uniform(0.0, std::min(most, 4.0));
          const double t = friction * n * random.uniform(0.0, 1.0);
          const double angle = random.uniform(0.0, 6.3);
          const double dot = (p[0] - q[0]) * (n - q[0]) +
                             (p[1] - q[1]) * (t * std::cos(angle) - q[1]) +
                             (p[2] - q[2]) * (t * std::sin(angle) - q[2]);
          CHECK(dot <= 1e-13);
        }
      }
    }
  }
}
