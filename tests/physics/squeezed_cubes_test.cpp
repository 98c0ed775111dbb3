// Cubes that plates press together: friction alone holds them, from cube to cube.
// SPDX-License-Identifier: BSD-3-Clause
#include "support/numbers.hpp"
#include "support/relative.hpp"

#include <bristle/world/world.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

using namespace bristle;
using bristle::test::g;

namespace {

constexpr double half_cube = 0.05;        // [m] Of a cube.
constexpr double cube_friction = 0.5;     // [1]
constexpr double plate_thickness = 0.04;  // [m] Of a plate of 2 kg.

/// Cubes in the air between plates that slide towards them. Gravity pulls along -z.
class SqueezedCubes {
 public:
  explicit SqueezedCubes(double time_step) : world_(WorldDef<double>{.time_step = time_step}) {}

  void add_cube(double mass, const Vec3<double>& position) {
    BodyDef<double> cube;
    cube.shape = Box<double>{{half_cube, half_cube, half_cube}};
    cube.mass = mass;
    cube.position = position;
    cube.material = {cube_friction, 0};
    cubes_.push_back({world_.add_body(cube), position.z()});
    weight_ += mass * g;
  }

  /// Adds a pair of plates that press along an axis.
  /// @param reach    [m] Of the cubes along it.
  /// @param extents  [m] Half extents of a plate. That along the axis is its thickness.
  /// @param share    [1] Share of the weight that the pair holds at most.
  void add_plates(Eigen::Index axis, double reach, Vec3<double> extents, double share, bool turns) {
    for (const double side : {-1.0, 1.0}) {
      BodyDef<double> plate;
      extents[axis] = plate_thickness / 2;
      plate.shape = Box<double>{extents};
      plate.mass = 2;
      plate.position = Vec3<double>(0, 0, 0);
      plate.position[axis] = side * (reach + plate_thickness / 2);
      plate.material = {cube_friction, 0};
      plate.locked.linear = {axis != 0, axis != 1, axis != 2};
      if (!turns) plate.locked.angular = {true, true, true};
      Vec3<double> push(0, 0, 0);
      push[axis] = -side * share * weight_ / (2 * cube_friction);
      plates_.push_back({world_.add_body(plate), push});
    }
  }

  /// Puts a puck of 0.5 kg onto the cubes. It slides along x at a speed [m/s], almost freely.
  void add_puck(double x, double speed) {
    BodyDef<double> puck;
    puck.shape = Box<double>{{0.02, 0.02, 0.01}};
    puck.mass = 0.5;
    puck.position = {x, 0, half_cube + 0.01};
    puck.velocity = {speed, 0, 0};
    puck.material = {0.0005, 0};
    world_.add_body(puck);
  }

  /// Steps on for a time [s]. Forces of `shake` [N] push all cubes to and fro along x and y.
  void run(double seconds, double shake) {
    const double dt = world_.time_step();
    for (int i = 0; i < std::lround(seconds / dt); ++i) {
      for (const Plate& plate : plates_) {
        world_.apply_force(plate.body, plate.push, world_.body(plate.body).pose().translation);
      }
      for (std::size_t k = 0; k < cubes_.size(); ++k) {
        const double phase = static_cast<double>(k);
        const Vec3<double> push(shake * std::sin(0.3 * i + phase),
                                shake * std::sin(0.37 * i + 2 * phase), 0);
        const BodyId body = cubes_[k].body;
        world_.apply_force(body, push, world_.body(body).pose().translation);
      }
      world_.step();
    }
  }

  /// [-] Factorisations of the last step.
  [[nodiscard]] std::uint64_t factorisations() const { return world_.report().factorisations; }
  /// [m] How far the cube that sank most has come down.
  [[nodiscard]] double sag() const {
    double most = 0;
    for (const Cube& cube : cubes_) {
      most = std::max(most, cube.height - world_.body(cube.body).pose().translation.z());
    }
    return most;
  }

  /// [m] How far the centre of mass has come down. All cubes have one mass.
  [[nodiscard]] double fall() const {
    double sum = 0;
    for (const Cube& cube : cubes_) {
      sum += cube.height - world_.body(cube.body).pose().translation.z();
    }
    return sum / static_cast<double>(cubes_.size());
  }

 private:
  struct Cube {
    BodyId body;
    double height;  // [m] At the start.
  };
  struct Plate {
    BodyId body;
    Vec3<double> push;  // [N]
  };

  World<double> world_;
  double weight_ = 0;  // [N] Of all cubes.
  std::vector<Cube> cubes_;
  std::vector<Plate> plates_;
};

/// A floor of nine cubes, pressed from four sides.
/// @param press  [1] Force of the plates by the least that can hold the weight.
/// @param turns  True for plates that may tilt.
SqueezedCubes make_squeezed_floor(double rate, double press, bool turns) {
  SqueezedCubes floor(1 / rate);
  for (const double x : {-2 * half_cube, 0.0, 2 * half_cube}) {
    for (const double y : {-2 * half_cube, 0.0, 2 * half_cube}) floor.add_cube(1, {x, y, 0});
  }
  for (const Eigen::Index axis : {0, 1}) {
    // Plates are narrower than the floor, so they do not touch each other.
    floor.add_plates(axis, 3 * half_cube, {2.5 * half_cube, 2.5 * half_cube, half_cube}, press / 2,
                     turns);
  }
  return floor;
}

/// A wall of twelve cubes of 0.5 to 2 kg, pressed from two sides.
SqueezedCubes make_squeezed_wall(double rate, double press) {
  SqueezedCubes wall(1 / rate);
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
SqueezedCubes make_squeezed_block(double rate, double press, int deep) {
  SqueezedCubes block(1 / rate);
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

/// [m] Free fall in one step.
double step_fall(double rate) { return g / (2 * rate * rate); }

/// Checks that cubes, shaken by a force [N] or not, stay up for a second. The first steps may leave
/// a thousandth of the free fall in one of them, and nothing may creep.
void check_held(SqueezedCubes cubes, double rate, double press, double shake) {
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
        check_held(make_squeezed_floor(rate, press, turns), rate, press, 0);
      }
    }
  }
}

TEST_CASE("squeezed_cubes: a floor stays up while its cubes are pushed to and fro") {
  for (const double rate : {60.0, 240.0}) {
    for (const double press : {1.3, 2.0}) {
      check_held(make_squeezed_floor(rate, press, false), rate, press, 5);
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
        SqueezedCubes block = make_squeezed_block(rate, press, deep);
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
      SqueezedCubes floor = make_squeezed_floor(rate, press, false);
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
    SqueezedCubes floor = make_squeezed_floor(rate, press, false);
    floor.run(seconds, 0);
    CHECK(floor.fall() == test::relative((1 - press) * g * seconds * seconds / 2).epsilon(0.01));
  }
}
