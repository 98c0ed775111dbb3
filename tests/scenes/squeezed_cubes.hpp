/// @file
/// Cubes that plates press together: friction alone holds them, from cube to cube.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/numbers.hpp"

#include <bristle/world/world.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace bristle::scenes {

inline constexpr double half_cube = 0.05;  // [m] Of a cube.

/// Cubes in the air between plates that slide towards them. Gravity pulls along -z.
template <Scalar S>
class SqueezedCubes {
 public:
  /// @param time_step  [s]
  explicit SqueezedCubes(double time_step) : world_(WorldDef<S>{.time_step = S(time_step)}) {}

  void add_cube(double mass, const Vec3<double>& position) {
    BodyDef<S> cube;
    cube.shape = Box<S>{to_scalar({half_cube, half_cube, half_cube})};
    cube.mass = S(mass);
    cube.position = to_scalar(position);
    cube.material = {S(friction), S(0)};
    cubes_.push_back({world_.add_body(cube), position.z()});
    weight_ += mass * test::g;
  }

  /// Adds a pair of plates that press along an axis.
  /// @param reach    [m] Of the cubes along it.
  /// @param extents  [m] Half extents of a plate. That along the axis is its thickness.
  /// @param share    [1] Share of the weight that the pair holds at most.
  void add_plates(Eigen::Index axis, double reach, Vec3<double> extents, double share, bool turns) {
    for (const double side : {-1.0, 1.0}) {
      BodyDef<S> plate;
      extents[axis] = thickness / 2;
      plate.shape = Box<S>{to_scalar(extents)};
      plate.mass = S(2);
      plate.position = to_scalar({0, 0, 0});
      plate.position[axis] = S(side * (reach + thickness / 2));
      plate.material = {S(friction), S(0)};
      plate.locked.linear = {axis != 0, axis != 1, axis != 2};
      if (!turns) plate.locked.angular = {true, true, true};
      Vec3<double> push(0, 0, 0);
      push[axis] = -side * share * weight_ / (2 * friction);
      plates_.push_back({world_.add_body(plate), push});
    }
  }

  /// Puts a puck of 0.5 kg onto the cubes. It slides along x at a speed [m/s], almost freely.
  void add_puck(double x, double speed) {
    BodyDef<S> puck;
    puck.shape = Box<S>{to_scalar({0.02, 0.02, 0.01})};
    puck.mass = S(0.5);
    puck.position = to_scalar({x, 0, half_cube + 0.01});
    puck.velocity = to_scalar({speed, 0, 0});
    puck.material = {S(0.0005), S(0)};
    world_.add_body(puck);
  }

  /// Steps on for a time [s]. Forces of `shake` [N] push all cubes to and fro along x and y.
  void run(double seconds, double shake) {
    const double dt = value_of(world_.time_step());
    for (int i = 0; i < std::lround(seconds / dt); ++i) {
      for (const Plate& plate : plates_) {
        world_.apply_force(plate.body, to_scalar(plate.push),
                           world_.body(plate.body).pose().translation);
      }
      for (std::size_t k = 0; k < cubes_.size(); ++k) {
        const double phase = static_cast<double>(k);
        const Vec3<double> push(shake * std::sin(0.3 * i + phase),
                                shake * std::sin(0.37 * i + 2 * phase), 0);
        const BodyId body = cubes_[k].body;
        world_.apply_force(body, to_scalar(push), world_.body(body).pose().translation);
      }
      world_.step();
    }
  }

  /// [-] Factorisations of the last step.
  [[nodiscard]] std::uint64_t factorisations() const { return world_.report().factorisations; }
  /// [m] How far the cube that sank most has come down.
  [[nodiscard]] double sag() const {
    double most = 0;
    for (const Cube& cube : cubes_) most = std::max(most, fall_of(cube));
    return most;
  }
  /// [m] How far the centre of mass has come down. All cubes have one mass.
  [[nodiscard]] double fall() const {
    double sum = 0;
    for (const Cube& cube : cubes_) sum += fall_of(cube);
    return sum / static_cast<double>(cubes_.size());
  }

 private:
  static constexpr double friction = 0.5;    // [1]
  static constexpr double thickness = 0.04;  // [m] Of a plate of 2 kg.

  struct Cube {
    BodyId body;
    double height;  // [m] At the start.
  };
  struct Plate {
    BodyId body;
    Vec3<double> push;  // [N]
  };

  [[nodiscard]] static Vec3<S> to_scalar(const Vec3<double>& v) {
    return {S(v.x()), S(v.y()), S(v.z())};
  }
  [[nodiscard]] double fall_of(const Cube& cube) const {
    return cube.height - value_of(world_.body(cube.body).pose().translation.z());
  }

  World<S> world_;
  double weight_ = 0;  // [N] Of all cubes.
  std::vector<Cube> cubes_;
  std::vector<Plate> plates_;
};

/// A floor of nine cubes, pressed from four sides.
/// @param rate   [1/s] Steps.
/// @param press  [1] Force of the plates by the least that can hold the weight.
/// @param turns  True for plates that may tilt.
template <Scalar S>
[[nodiscard]] SqueezedCubes<S> make_squeezed_floor(double rate, double press, bool turns) {
  SqueezedCubes<S> floor(1 / rate);
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

/// [m] Free fall in one step.
[[nodiscard]] inline double step_fall(double rate) { return test::g / (2 * rate * rate); }

}  // namespace bristle::scenes
