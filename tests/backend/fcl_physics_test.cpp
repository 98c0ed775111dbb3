// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/world/world.hpp>
#include <doctest/doctest.h>

#include <scenes/drops.hpp>
#include <scenes/plates.hpp>
// What tests/physics demands of the analytic backend (rest_on_table, tunnelling), of FCL.

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("FclBackend: dropped shapes rest on a table without sinking or drifting") {
  for (const DropDef<double>& def : drops<double>()) {
    CAPTURE(def.name);
    for (const bool is_mesh : {false, true}) check_drop<FclBackend>(def, is_mesh);
  }
}

TEST_CASE("FclBackend: fast balls and spinning rods do not pass a thin plate") {
  for (const bool is_mesh : {false, true}) {
    for (int i = 0; i < 12; ++i) {
      CAPTURE(is_mesh);
      CAPTURE(i);
      check_fast_ball<FclBackend>(is_mesh, 0.04 + 0.26 * i, 0);
      check_spinning_rod<FclBackend>(Capsule<double>{0.02, 0.48}, is_mesh, i);
      check_spinning_rod<FclBackend>(Box<double>{{0.02, 0.02, 0.5}}, is_mesh, i);
    }
  }
}
