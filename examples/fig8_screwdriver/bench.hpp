// Workpieces for the hands of the paper's Fig. 8 (a): a screwdriver with a tip of four arms, and a
// cast with a slot for them, which turns on a base against friction. Sizes and masses are those of
// ScrewDriverEnv, the authors' scene in AMBF's format:
//
//   here           there
//   driver         SDHandle (capsule), SDShaft (cylinder), SDTip1 and SDTip2 (crossed cylinders),
//                  which fixed joints make one body
//   cast           Cylinder (disk) with Cube_001_001 to Cube_004, whose gaps are the slot, and
//                  Fin1, Fin2; fixed joints again
//   turning joint  FixedBase-Cylinder, continuous
//   base           FixedBase
//
// Heights are from the top of the base. There the base leans by 15 degrees and the driver begins in
// the air above the cast; here the base is level and the driver stands on it, beside the cast.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/geometry/shapes/shape_properties.hpp>
#include <bristle/math/rotation.hpp>
#include <bristle/world/world.hpp>

#include <numbers>
#include <utility>
#include <vector>

namespace fig8 {

using bristle::Vec3;

inline constexpr double degree = std::numbers::pi / 180;

inline constexpr double handle_radius = 0.075;  // [m]
inline constexpr double handle_height = 0.831;  // [m] of its middle above that of the tip
inline constexpr double shaft_radius = 0.021;   // [m]
inline constexpr double shaft_height = 0.291;   // [m] likewise
inline constexpr double arm_radius = 0.022;     // [m] of the tip's arms
inline constexpr double driver_mass = 0.6;      // [kg]

inline constexpr double cast_height = 0.091;       // [m] of the disk's middle
inline constexpr double half_disk = 0.0355;        // [m]
inline constexpr double cube_height = 0.082;       // [m] of the cubes' middle above the disk's
inline constexpr double half_cube_height = 0.044;  // [m]
inline constexpr double cast_friction = 0.5;       // [N m] of its joint, whatever the speed
/// [N m s] AMBF's angular damping of 0.9 /s of the 0.1 kg m^2 that turn.
inline constexpr double cast_damping = 0.09;

/// [m] Heights of the tip's middle: standing on the base, seated in the slot, clear of the cubes.
inline constexpr double standing_height = arm_radius;
inline constexpr double seated_height = cast_height + half_disk + arm_radius;
inline constexpr double clear_height = cast_height + cube_height + half_cube_height + 0.06;
/// [m] Where the driver stands at first; the cast is at the origin.
inline constexpr double stand_y = 0.8;

/// Collision filters; the pads of the hands sense the driver alone.
inline constexpr bristle::CollisionFilter driver_filter{1, 2, 0};
inline constexpr bristle::CollisionFilter bench_filter{2, 1, 0};
inline constexpr bristle::CollisionFilter finger_filter{4, 0, 0};

/// Parts that make up one body, each of even density.
class Assembly {
 public:
  void add(const bristle::Shape<double>& shape, double mass, const Vec3<double>& place,
           const Vec3<double>& turn = Vec3<double>::Zero()) {
    const bristle::Transform<double> X_BS{bristle::exp_rotation<double>(turn), place};
    shapes_.push_back({.shape = shape, .X_BS = X_BS});
    const bristle::MassProperties<double> unit = bristle::unit_mass_properties<double>(shape);
    sum_ = sum_ + unit.scaled(mass / unit.mass).transformed(X_BS);
  }
  [[nodiscard]] bristle::BodyDef<double> body(const Vec3<double>& position,
                                              const bristle::CollisionFilter& filter) const {
    bristle::BodyDef<double> def;
    def.mass = sum_.mass;
    def.center_of_mass = sum_.center;
    def.inertia = sum_.inertia;
    def.shapes = shapes_;
    def.filter = filter;
    def.position = position;
    return def;
  }

 private:
  std::vector<bristle::ShapeDef<double>> shapes_;
  bristle::MassProperties<double> sum_{};
};

/// Handle, shaft and tip; the frame's origin is the middle of the tip, z points to the handle.
inline Assembly driver_parts() {
  using namespace bristle;
  Assembly driver;
  driver.add(Capsule<double>{.radius = handle_radius, .half_length = 0.2785 - handle_radius}, 0.2,
             {0, 0, handle_height});
  driver.add(Cylinder<double>{.radius = shaft_radius, .half_length = 0.267}, 0.1,
             {0, 0, shaft_height});
  const Cylinder<double> arms{.radius = arm_radius, .half_length = 0.1005};
  driver.add(arms, 0.15, {0, 0, 0}, {0, 90 * degree, 0});
  driver.add(arms, 0.15, {0, 0, 0}, {90 * degree, 0, 0});
  return driver;
}

/// The disk with cubes and fins; the frame's origin is the middle of the disk.
inline Assembly cast_parts() {
  using namespace bristle;
  Assembly cast;
  cast.add(Cylinder<double>{.radius = 0.3765, .half_length = half_disk}, 0.5, {0, 0, 0});
  for (const double x : {-0.071, 0.071}) {
    for (const double y : {-0.071, 0.071}) {
      cast.add(Box<double>{{0.0355, 0.0355, half_cube_height}}, 0.1, {x, y, cube_height});
    }
  }
  for (const double x : {-0.564, 0.543}) {
    cast.add(Box<double>{{0.191, 0.045, 0.015}}, 0.1, {x, 0, -0.005});
  }
  return cast;
}

/// The bench in a world.
struct Bench {
  bristle::BodyId base{};
  bristle::BodyId driver{};
  bristle::BodyId cast{};
  bristle::JointId turning{};

  explicit Bench(bristle::World<double>& world) {
    using namespace bristle;
    base = world.add_body({.motion = Motion::fixed,
                           .shape = Box<double>{{0.4915, 1.1765, 0.013}},
                           .filter = bench_filter,
                           .position = {0, 0, -0.013}});
    driver = world.add_body(driver_parts().body({0, stand_y, standing_height}, driver_filter));
    cast = world.add_body(cast_parts().body({0, 0, cast_height}, bench_filter));

    JointDef<double> joint;
    joint.kind = JointKind::revolute;
    joint.body_a = base;
    joint.body_b = cast;
    // The joint's x axis points up.
    joint.X_AJ.rotation = joint.X_BJ.rotation = exp_rotation<double>({0, -90 * degree, 0});
    joint.X_AJ.translation = {0, 0, cast_height + 0.013};
    joint.motor = {MotorMode::velocity, 0, cast_friction};
    joint.spring.damping = cast_damping;
    turning = world.add_joint(joint);
  }
};

}  // namespace fig8
