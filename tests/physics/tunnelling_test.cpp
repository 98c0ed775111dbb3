/// @file
/// Nothing passes through a thin plate, however fast it comes or spins.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/plates.hpp"

#include <doctest/doctest.h>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("tunnelling: a ball of 5 cm at 100 m/s does not pass a plate of 1 cm") {
  // From all phases of the step, straight and aslant.
  for (const bool is_mesh : {false, true}) {
    for (int i = 0; i < 25; ++i) {
      CAPTURE(is_mesh);
      CAPTURE(i);
      check_fast_ball<AnalyticBackend>(is_mesh, 0.04 + 0.13 * i, 0);
      check_fast_ball<AnalyticBackend>(is_mesh, 0.04 + 0.13 * i, 60);
    }
  }
}

TEST_CASE("tunnelling: rods of 1 m that spin at 100 rad/s do not pass a plate of 1 cm") {
  for (const bool is_mesh : {false, true}) {
    for (int i = 0; i < 12; ++i) {
      CAPTURE(is_mesh);
      CAPTURE(i);
      check_spinning_rod<AnalyticBackend>(Capsule<double>{0.02, 0.48}, is_mesh, i);
      check_spinning_rod<AnalyticBackend>(Box<double>{{0.02, 0.02, 0.5}}, is_mesh, i);
    }
  }
}
