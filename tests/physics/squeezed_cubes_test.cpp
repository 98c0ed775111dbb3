// Cubes that plates press together: friction alone holds them, from cube to cube.
// SPDX-License-Identifier: BSD-3-Clause
#include "scenes/squeezed_cubes.hpp"

#include "support/numbers.hpp"
#include "support/relative.hpp"

#include <doctest/doctest.h>

#include <algorithm>

using namespace bristle;
using bristle::test::g;

namespace {

using scenes::half_cube, scenes::make_squeezed_floor, scenes::step_fall;

/// A wall of twelve cubes of 0.5 to 2 kg, pressed from two sides.
scenes::SqueezedCubes<double> make_squeezed_wall(double rate, double press) {
  scenes::SqueezedCubes<double> wall(1 / rate);
  for (int row = 0; row < 3; ++row) {
    for (int i = 0; i < 4; ++i) {
      const double mass = 0.5 + 0.5 * ((7 * i + 3 * row) % 4);
      wall.add_cube(mass, 2 * half_cube * Vec3<double>(i - 1.5, 0, row - 1));
    }
  }
  wall.add_plates(0, 4 * half_cube, {0, half_cube, 3 * half_cube}, press, false);
  return wall;
}

/// A block of 18 cubes, two deep or three, or of 36, four deep, every other one of them a hundred
/// times as heavy as the next, pressed from two sides. All of its contacts are new in the first
/// step.
scenes::SqueezedCubes<double> make_squeezed_block(double rate, double press, int deep) {
  scenes::SqueezedCubes<double> block(1 / rate);
  const int high = deep == 3 ? 2 : 3;
  for (int x = 0; x < deep; ++x) {
    for (int y = 0; y < 3; ++y) {
      for (int z = 0; z < high; ++z) {
        const double mass = (x + y + z) % 2 == 0 ? 1 : 0.01;
        block.add_cube(mass, 2 * half_cube * Vec3<double>(x - (deep - 1) / 2.0, y - 1, z));
      }
    }
  }
  block.add_plates(0, deep * half_cube, {0, 3 * half_cube, high * half_cube}, press, false);
  return block;
}

/// Checks that cubes, shaken by a force [N] or not, stay up for a second. The first steps may leave
/// a thousandth of the free fall in one of them, and nothing may creep.
void check_held(scenes::SqueezedCubes<double> cubes, double rate, double press, double shake) {
  CAPTURE(rate);
  CAPTURE(press);
  cubes.run(1, shake);
  CHECK(cubes.sag() < 1e-3 * step_fall(rate));
}

}  // namespace

TEST_CASE("squeezed_cubes: a floor that friction can hold stays up") {
  for (const double rate : {60.0, 240.0}) {
    for (const double press : {1.02, 1.1, 1.3, 1.5, 2.0, 3.0}) {
      for (const bool turns : {false, true}) {
        CAPTURE(turns);
        check_held(make_squeezed_floor<double>(rate, press, turns), rate, press, 0);
      }
    }
  }
}

TEST_CASE("squeezed_cubes: a floor stays up while its cubes are pushed to and fro") {
  for (const double rate : {60.0, 240.0}) {
    for (const double press : {1.3, 2.0}) {
      check_held(make_squeezed_floor<double>(rate, press, false), rate, press, 5);
    }
  }
}

TEST_CASE("squeezed_cubes: a wall of unlike cubes stays up between two plates") {
  for (const double rate : {60.0, 240.0}) {
    for (const double press : {1.3, 1.5, 2.0}) {
      check_held(make_squeezed_wall(rate, press), rate, press, 0);
    }
  }
}

TEST_CASE("squeezed_cubes: a block of unlike cubes stays up between two plates") {
  for (const double rate : {60.0, 240.0}) {
    for (const double press : {1.02, 1.5, 8.0, 50.0}) {
      for (const int deep : {2, 3, 4}) {
        CAPTURE(deep);
        // 36 cubes that are pressed harder touch so often that they are swept.
        const double most = deep == 4 ? 3.0 : press;
        check_held(make_squeezed_block(rate, std::min(press, most), deep), rate, press, 0);
      }
    }
  }
}

TEST_CASE("squeezed_cubes: a block that is held needs no factorisation") {
  // Each step finds the loads of the last one again. Cubes touch at edges and corners, too, whose
  // contacts must not turn about.
  for (const double rate : {60.0, 240.0}) {
    CAPTURE(rate);
    for (const double press : {1.5, 3.0}) {
      for (const int deep : {2, 3, 4}) {
        CAPTURE(deep);
        scenes::SqueezedCubes<double> block = make_squeezed_block(rate, press, deep);
        block.run(10 / rate, 0);
        for (int i = 0; i < 20; ++i) {
          block.run(1 / rate, 0);
          CHECK(block.factorisations() == 0);
        }
      }
    }
  }
}

TEST_CASE("squeezed_cubes: a floor stays up under a puck that slides over it") {
  // What slides in the island lets the opening speeds of all its contacts change. The floor gives
  // way by less than it would fall in one step, once.
  for (const double rate : {60.0, 240.0}) {
    for (const double press : {1.3, 2.0, 3.0}) {
      CAPTURE(rate);
      CAPTURE(press);
      scenes::SqueezedCubes<double> floor = make_squeezed_floor<double>(rate, press, false);
      floor.add_puck(-2 * half_cube, 0.3);
      floor.run(1, 0);
      CHECK(floor.sag() < step_fall(rate));
    }
  }
}

TEST_CASE("squeezed_cubes: what friction cannot hold comes down by Coulomb's law") {
  // All contacts of the plates slide. So plates that press with a share p of the force needed leave
  // (1 - p) g to the centre of mass, however cubes slide along each other. It is exact for the
  // trapezoidal rule but for what the solver leaves, a thousandth of the slip in a step.
  constexpr double press = 0.8;
  constexpr double seconds = 0.25;
  for (const double rate : {60.0, 240.0}) {
    CAPTURE(rate);
    scenes::SqueezedCubes<double> floor = make_squeezed_floor<double>(rate, press, false);
    floor.run(seconds, 0);
    CHECK(floor.fall() == test::relative((1 - press) * g * seconds * seconds / 2).epsilon(0.01));
  }
}
