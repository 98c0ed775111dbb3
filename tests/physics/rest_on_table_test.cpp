/// @file
/// Shapes whose contacts are found by iteration come to rest on a table and stay there.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/drops.hpp"

#include <doctest/doctest.h>

using namespace bristle;
using namespace bristle::scenes;

TEST_CASE("rest_on_table: dropped shapes rest on a box without sinking or drifting") {
  for (const DropDef<double>& def : drops<double>()) {
    CAPTURE(def.name);
    check_drop<AnalyticBackend>(def, false);
  }
}

TEST_CASE("rest_on_table: and on a table that is a mesh") {
  for (const DropDef<double>& def : drops<double>()) {
    CAPTURE(def.name);
    check_drop<AnalyticBackend>(def, true);
  }
}
